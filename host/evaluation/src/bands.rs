//! `sorairo bands`: the wavelengths for which the regression fit errs least.
//!
//! The spectra of the training rays and of the sky that is judged are integrated once, at every nanometre. A candidate
//! then costs regressions on tabulated logarithms and a few exponentials, well below a millisecond for each sun, and
//! the search can afford thousands: coordinate descent from several starts, in steps that shrink to 1 nm.

use rayon::prelude::*;
use serde::Serialize;
use sorairo_shared::glam::{DVec3, Vec3};

use super::error::{Reference, plan};
use super::metrics::Errors;
use crate::problem::Result;
use sorairo::Plan;
use sorairo::low_level::error::check_range;
use sorairo::low_level::plan::fit::light::scattered_once;
use sorairo::low_level::plan::fit::rays::training_views;
use sorairo::low_level::plan::fit::regression::{Examples, LIT, NO_NOISE, node_wavelengths, regress};
use sorairo::low_level::plan::fit::training::DARKEST;
use sorairo::low_level::plan::integral::Constituent;
use sorairo::low_level::plan::upload::bands;
use sorairo::low_level::spectra::observer;
use sorairo::scene::{ColourPath, Fit, Scene};

/// Where a band may lie (nm).
const SEARCHED: (u32, u32) = (395, 700);

/// Bands of a candidate lie at least this far apart (nm).
const APART: u32 = 8;

/// The wavelength (nm) of the phase functions by which rays count.
const OF_PHASE: f64 = 550.0;

/// Steps of the descent (nm), each until nothing improves.
const STEPS: [u32; 5] = [20, 10, 5, 2, 1];

/// Starting points besides the default wavelengths.
const STARTS: u32 = 3;

/// The outcome of a search.
#[derive(Clone, Debug, Serialize)]
pub struct Found {
    /// The best wavelengths (nm), increasing.
    pub bands: Vec<f64>,
    /// Their error over the suns.
    pub errors: Errors,
    /// The fit's own wavelengths (nm).
    pub default_bands: Vec<f64>,
    /// Their error over the suns.
    pub default_errors: Errors,
    /// Elevations of the sun (degrees).
    pub sun_elevations: Vec<f64>,
    /// How many choices were compared.
    pub candidates: usize,
}

/// The best `count` wavelengths of the regression fit for a scene's atmosphere and observer, over elevations of the sun
/// (degrees).
///
/// Best is the least sum of the largest and the mean CIEDE2000 difference over the sky; see [`super::error`]. The
/// errors returned are those of plans made with the wavelengths, not the search's own estimates.
///
/// # Errors
///
/// [`crate::Error::Sky`] if a value of the scene, the count or an elevation is out of range, or no sun lights the sky.
pub fn best(scene: &Scene, count: u32, sun_elevations: &[f64]) -> Result<Found> {
    check_range("count", f64::from(count), (3.0, 8.0), "wavelengths")?;
    let mut scene = scene.clone();
    (scene.render.fit, scene.render.color, scene.render.bands) = (Fit::Regression, ColourPath::Folded, None);
    let default_bands = plan(&scene)?.sky.plan().integral().wavelengths.clone();
    let suns: Vec<Sun> = sun_elevations.iter().map(|&sun| Sun::new(&scene, sun, count)).collect::<Result<_>>()?;
    if suns.iter().all(|sun| sun.reference.xyz.iter().all(|xyz| xyz.y <= 0.0)) {
        let complaint = "leave the whole sky dark; give at least one above -20 degrees";
        return Err(sorairo::Error::not_allowed("sun_elevations", complaint).into());
    }
    let mut search = Search { suns: &suns, candidates: 0 };
    let mut starts: Vec<Vec<u32>> = (0..STARTS).map(|i| spread(count, i)).collect();
    if default_bands.len() == count as usize {
        starts.push(default_bands.iter().map(|&band| band as u32).collect());
    }
    let found = starts.into_iter().map(|start| search.descend(start)).min_by(|a, b| a.1.total_cmp(&b.1));
    let bands: Vec<f64> = found.expect("there are starts").0.into_iter().map(f64::from).collect();
    let candidates = search.candidates;
    let errors_of = |bands: &[f64]| errors(&scene, bands, &suns);
    Ok(Found {
        errors: errors_of(&bands)?,
        default_errors: errors_of(&default_bands)?,
        bands,
        default_bands,
        sun_elevations: sun_elevations.to_vec(),
        candidates,
    })
}

/// The error of wavelengths over all suns, by the plans that the kernels would run.
fn errors(scene: &Scene, bands: &[f64], suns: &[Sun]) -> Result<Errors> {
    suns.iter().try_fold(Errors::default(), |sum, sun| {
        let mut scene = scene.clone();
        scene.sun.elevation = sun.elevation;
        scene.render.bands = Some(bands.to_vec());
        Ok(sum.and(&sun.reference.errors(&plan(&scene)?)))
    })
}

/// `count` wavelengths over the range of the observer, in one of several ways: evenly, or crowded to either end.
fn spread(count: u32, way: u32) -> Vec<u32> {
    let power = [1.0, 1.4, 0.7][way as usize % 3];
    let at = |i: u32| 425.0 + 230.0 * (f64::from(i) / f64::from(count - 1)).powf(power);
    (0..count).map(|i| at(i).round() as u32).collect()
}

/// Coordinate descent.
struct Search<'a> {
    suns: &'a [Sun],
    candidates: usize,
}

impl Search<'_> {
    /// The bands, from a start, that no single move improves; and their cost.
    fn descend(&mut self, start: Vec<u32>) -> (Vec<u32>, f64) {
        let mut best = (start.clone(), self.cost(&start));
        for step in STEPS {
            loop {
                let moves = moves(&best.0, step);
                self.candidates += moves.len();
                let found = moves
                    .into_par_iter()
                    .map(|bands| (self.cost(&bands), bands))
                    .min_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
                match found {
                    Some((cost, bands)) if cost < best.1 => best = (bands, cost),
                    _ => break,
                }
            }
        }
        best
    }

    fn cost(&self, bands: &[u32]) -> f64 {
        let errors = self.suns.iter().fold(Errors::default(), |sum, sun| sum.and(&sun.errors(bands)));
        let cost = errors.delta_e_max + errors.delta_e_mean;
        if cost.is_nan() { f64::INFINITY } else { cost }
    }
}

/// Every allowed move of one band, or of two neighbours together, by a step.
fn moves(bands: &[u32], step: u32) -> Vec<Vec<u32>> {
    let mut moves = Vec::new();
    for first in 0..bands.len() {
        for width in 1..=2.min(bands.len() - first) {
            for up in [true, false] {
                let mut moved = bands.to_vec();
                for band in &mut moved[first..first + width] {
                    *band = if up { *band + step } else { *band - step };
                }
                let inside = moved.iter().all(|band| (SEARCHED.0..=SEARCHED.1).contains(band));
                if inside && moved.windows(2).all(|pair| pair[1] >= pair[0] + APART) {
                    moves.push(moved);
                }
            }
        }
    }
    moves
}

/// One sun's sky, ready to be fitted with any bands.
struct Sun {
    elevation: f64,
    plan: Plan,
    reference: Reference,
    /// How many observer nodes there are.
    nodes: usize,
    constituents: Vec<Spectra>,
}

/// Spectra of one constituent.
struct Spectra {
    constituent: Constituent,
    /// ln X of each training ray at every searched nanometre.
    training: Vec<Vec<f64>>,
    /// X of each training ray at the fit's observer nodes, then at those of the whole sum.
    targets: Vec<Vec<f64>>,
    /// ln X of each judged ray at every searched nanometre, and its phase function; `None` for a dark ray.
    judged: Vec<Option<(Vec<f64>, f64)>>,
}

impl Sun {
    fn new(scene: &Scene, elevation: f64, count: u32) -> Result<Self> {
        let mut scene = scene.clone();
        scene.sun.elevation = elevation;
        let plan = plan(&scene)?;
        let reference = Reference::new(&scene)?;
        let nodes = node_wavelengths(count as usize, plan.sky.plan().integral().optics.gases.is_some());
        let aerosol = scene.atmosphere.aerosol.optical_depth > 0.0;
        let constituents =
            [Constituent::Air, Constituent::Aerosol].into_iter().filter(|c| *c == Constituent::Air || aerosol);
        let constituents = constituents.map(|c| Spectra::new(&plan, c, &reference, &nodes)).collect();
        Ok(Self { elevation, plan, reference, nodes: nodes.len(), constituents })
    }

    /// The error of the regression fit with some bands (nm), in double precision after the integrals.
    fn errors(&self, bands: &[u32]) -> Errors {
        let mut rgb = vec![DVec3::ZERO; self.reference.xyz.len()];
        for spectra in &self.constituents {
            spectra.add(&self.plan, self.nodes, bands, &mut rgb);
        }
        let to_xyz = self.plan.sky.plan().space.from_xyz.inverse();
        Errors::of(rgb.into_iter().map(|rgb| to_xyz * rgb).zip(self.reference.xyz.iter().copied()))
    }
}

impl Spectra {
    fn new(plan: &Plan, constituent: Constituent, reference: &Reference, nodes: &[f64]) -> Self {
        let searched: Vec<f64> = (SEARCHED.0..=SEARCHED.1).map(f64::from).collect();
        let targets: Vec<f64> = nodes.iter().copied().chain(observer::wavelengths()).collect();
        let all: Vec<f64> = searched.iter().chain(&targets).copied().collect();
        let integral = plan.sky.plan().integral();
        let spectra = |views: &[Vec3], at: &[f64]| {
            let (air, aerosol) =
                scattered_once(integral, &integral.quadrature, views, (&bands(&integral.optics, at), at.len()));
            if constituent == Constituent::Air { air } else { aerosol }
        };
        let mut rays = spectra(&training_views(integral), &all);
        let middle = searched.len() / 2;
        let brightest = rays.iter().map(|ray| ray[middle]).fold(0.0, f64::max);
        rays.retain(|ray| ray[middle] > LIT * brightest);
        let ln = |values: &[f64]| values.iter().map(|value| value.max(DARKEST).ln()).collect::<Vec<f64>>();
        let judged = spectra(&reference.views, &searched);
        let judged = judged.iter().zip(&reference.views).map(|(ray, &view)| {
            let phase = plan.sky.plan().integral().phases_at(constituent, view, &[OF_PHASE])[0];
            ray.iter().any(|&value| value > 0.0).then(|| (ln(&ray[..searched.len()]), phase))
        });
        Self {
            constituent,
            training: rays.iter().map(|ray| ln(&ray[..searched.len()])).collect(),
            targets: rays
                .iter()
                .map(|ray| ray[searched.len()..all.len()].iter().map(|value| value.max(DARKEST)).collect())
                .collect(),
            judged: judged.collect(),
        }
    }

    /// Adds the constituent's linear RGB by the regression fit to each judged ray.
    fn add(&self, plan: &Plan, nodes: usize, bands: &[u32], rgb: &mut [DVec3]) {
        if self.training.is_empty() {
            return;
        }
        let at = |ray: &[f64]| bands.iter().map(|band| ray[(band - SEARCHED.0) as usize]).collect::<Vec<f64>>();
        let examples = Examples {
            bands: self.training.iter().map(|ray| at(ray)).collect(),
            values: self.targets.clone(),
            weights: vec![1.0; self.training.len()],
        };
        let regressions = regress(&examples, 0..nodes, NO_NOISE);
        let colours = plan.sky.plan().training().node_weights(
            self.constituent,
            &examples,
            &regressions,
            &observer::wavelengths(),
        );
        for (rgb, judged) in rgb.iter_mut().zip(&self.judged) {
            let Some((ray, phase)) = judged else { continue };
            let logarithms = at(ray);
            let sum: DVec3 =
                regressions.iter().zip(&colours).map(|(node, &colour)| colour * node.value(&logarithms)).sum();
            *rgb += sum * *phase;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sorairo::scene::Preset;

    #[test]
    fn moves_keep_bands_in_order_and_in_range() {
        let moves = moves(&[395, 403, 600, 700], 5);
        assert!(!moves.is_empty());
        assert!(moves.iter().all(|bands| bands.windows(2).all(|pair| pair[1] >= pair[0] + APART)));
        assert!(moves.contains(&vec![395, 403, 605, 700]) && !moves.contains(&vec![400, 403, 600, 700]));
        assert!(moves.contains(&vec![400, 408, 600, 700]));
    }

    #[test]
    fn the_search_judges_bands_as_their_plan_does() {
        let mut scene = Scene::preset(Preset::Earth).first_order();
        scene.sun.elevation = 10.0;
        let sun = Sun::new(&scene, 10.0, 4).unwrap();
        for bands in [[444, 530, 585, 650], [410, 500, 560, 690]] {
            let given: Vec<f64> = bands.iter().map(|&band| f64::from(band)).collect();
            let errors = errors(&scene, &given, std::slice::from_ref(&sun)).unwrap();
            let estimate = sun.errors(&bands);
            // The kernels round in single precision.
            assert!((estimate.delta_e_max - errors.delta_e_max).abs() < 1e-3, "{estimate:?} {errors:?}");
        }
    }
}
