//! The regression of spectra on their bands: what is learnt on the rays of some skies, and its error on others.

use std::sync::Arc;

use rayon::prelude::*;
use sorairo_shared::glam::Vec3;
use sorairo_shared::sky::ByConstituent;
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant;

use crate::plan::fit::SpectralFit;
use crate::plan::fit::light::light_of;
use crate::plan::fit::rays::{Grid, spectral_grids};
use crate::plan::fit::regression::{Examples, LIT, Regression, Training, regress, regress_parts};
use crate::plan::fit::training::{DARKEST, multiples, sorted};
use crate::plan::integral::{Constituent, RayIntegral, needed};
use crate::plan::light_field::{Cacheable, TOGETHER};
use crate::plan::rays::directions::is_night;
use crate::plan::rays::source::Source;
use crate::plan::sky::SkyPlan;
use crate::plan::spectral::bands::{at_wavelengths, sampled, with_line_bands, with_own_bands};
use crate::plan::spectral::illumination::{Illumination, Regressions, radiance};
use crate::plan::spectral::interpolation::{lines, places, right_at_bands};
use crate::plan::strengths::{LINE_BANDS, Strengths, has_lines, without_lines};
use crate::plan::upload;
use crate::spectra::optics::Optics;

/// The part of a spectrum's peak below which errors are relative to that.
pub const FLOOR: f64 = 0.05;

/// Variance of a band's logarithm that says nothing: light is read between the entries of a lookup, which is off by
/// some 3e-4, and slopes of both signs multiply it.
const NOISE: f64 = 1e-7;

/// The most wavelengths at which training light is computed.
const MOST_COMPUTED: usize = 2 * TOGETHER;

/// Step (nm) between those at which it is where more are asked for: ozone's cross-section bends within ten.
const STEP: f64 = 5.0;

/// What the skies of all suns that have the same light field teach of their spectra.
pub(crate) struct SpectralModel {
    /// The wavelengths at which light was computed (nm).
    pub(crate) computed: Vec<f64>,
    /// Those at which it is known what lines of gases leave of it (nm, increasing): of the former and those asked for.
    lined: Vec<f64>,
    /// For some suns, by their elevation (degrees, increasing), the regressions of each constituent there.
    suns: Vec<(f64, Vec<(Constituent, Taught)>)>,
    /// The largest error of those between two suns along rays from which they did not learn; of light without lines.
    pub(crate) error: f64,
    /// The same through the lines of gases, where there are any.
    pub(crate) error_of_lines: Option<f64>,
}

/// What rays teach of a constituent.
#[derive(Clone, Debug)]
pub(crate) struct Taught {
    /// Its light, without lines of gases if there are any, at every wavelength that was computed.
    pub(crate) smooth: Vec<Regression>,
    /// What lines leave of it: none without gases.
    pub(crate) left: Vec<Regression>,
}

impl Taught {
    fn towards(&self, other: &Self, part: f64) -> Self {
        let mix = |low: &[Regression], high: &[Regression]| -> Vec<Regression> {
            low.iter().zip(high).map(|(low, high)| low.towards(high, part)).collect()
        };
        Self { smooth: mix(&self.smooth, &other.smooth), left: mix(&self.left, &other.left) }
    }
}

impl Cacheable for SpectralModel {
    fn bytes(&self) -> usize {
        let taught = self.suns.iter().flat_map(|(_, of_sun)| of_sun);
        let regressions = taught.flat_map(|(_, taught)| taught.smooth.iter().chain(&taught.left));
        let of = |regression: &Regression| size_of::<Regression>() + size_of_val(&regression.slopes[..]);
        regressions.map(of).sum::<usize>() + size_of_val(&self.computed[..])
    }
}

impl SpectralModel {
    /// That of the skies about a sky for a spectrum through bands (nm), at wavelengths asked for in order (nm).
    pub(crate) fn of(sky: &SkyPlan, bands: Vec<f64>, asked: &[f64]) -> Arc<Self> {
        let has_lines = has_lines(&sky.base.optics, asked);
        let smooth = if has_lines { bands.len() - LINE_BANDS.len() } else { bands.len() };
        let computed = computed(&bands[..smooth], asked);
        let lined = if has_lines { sorted(computed.iter().chain(asked).copied()) } else { Vec::new() };
        let ends = [asked[0], asked[asked.len() - 1]];
        let optical = upload::bands(&sky.base.optics, &computed);
        let every = RayIntegral { bands: optical.clone(), ..sky.base.clone() };
        let (resolution, setting) = (every.spectral_resolution(), every.setting());
        let steps = sky.scene.render.steps.map_or(0.0, f64::from);
        // Errors are judged where the sun's spectrum has its lines; how far it is does not matter.
        let sun: Vec<f64> = computed.iter().map(|&nm| sky.base.optics.sun.at(nm)).collect();
        let others = [&computed[..], &bands, &lined, &ends, &[steps], &sun].concat();
        let learn = || Self::new(sky, [computed, lined], bands, ends);
        // The bands of colour are means, of which the values at wavelengths know nothing.
        let air = [&sky.base.bands[..], &optical].concat();
        sky.base.light_fields.learnt(&setting, &air, (&resolution, sky.base.orders), others, learn)
    }

    fn new(sky: &SkyPlan, [computed, lined]: [Vec<f64>; 2], bands: Vec<f64>, ends: [f64; 2]) -> Self {
        let [lowest, middle, highest] = sky.base.setting().suns_of_light_field();
        let lit = |elevation: &f64| !is_night(&sky.scene.under_sun(*elevation));
        let under = |elevation: f64| TrainingSky::new(sky, elevation, &bands, [&computed, &lined]);
        let learnt = |elevation: f64| (elevation, regressions(sky, &under(elevation)));
        let suns = Some(lowest).filter(lit).into_iter().chain([highest]).map(learnt).collect();
        let between = if lit(&middle) { middle } else { highest };
        let tried = Tried::new(under(between), &lined);
        let model = Self { suns, error: 0.0, error_of_lines: None, computed, lined };
        let taught = model.under(between);
        let smooth = taught.iter().map(|(constituent, taught)| (*constituent, taught.smooth.clone())).collect();
        let with_lines = |(constituent, taught): (Constituent, Taught)| {
            (constituent, model.through_lines(taught.smooth, &taught.left, &model.computed))
        };
        let error_of_lines =
            (!model.lined.is_empty()).then(|| tried.error(&taught.into_iter().map(with_lines).collect(), ends, true));
        Self { error: tried.error(&smooth, ends, false), error_of_lines, ..model }
    }

    /// Regressions at wavelengths (nm) with what lines leave there.
    pub(crate) fn through_lines(
        &self,
        smooth: Vec<Regression>,
        left: &[Regression],
        wavelengths: &[f64],
    ) -> Vec<Regression> {
        if left.is_empty() {
            return smooth;
        }
        let through = |(smooth, at): (Regression, usize)| smooth.times(&left[at]);
        smooth.into_iter().zip(places(wavelengths, &self.lined)).map(through).collect()
    }

    /// The regressions under a sun at an elevation (degrees): between those of two suns.
    pub(crate) fn under(&self, elevation: f64) -> Vec<(Constituent, Taught)> {
        let last = self.suns.len() - 1;
        let above = self.suns.partition_point(|&(sun, _)| sun < elevation).min(last);
        let below = above.saturating_sub(1);
        let [(low, of_low), (high, of_high)] = [below, above].map(|at| &self.suns[at]);
        let part = if high > low { ((elevation - low) / (high - low)).clamp(0.0, 1.0) } else { 1.0 };
        let both = of_low.iter().zip(of_high);
        both.map(|((constituent, low), (_, high))| (*constituent, low.towards(high, part))).collect()
    }
}

/// A sky that teaches: its light at some bands, and at every wavelength that is computed.
struct TrainingSky {
    bands: RayIntegral,
    every: RayIntegral,
    /// Light at the strengths of lines of gases, of which `every` has none then.
    lines: Option<(Strengths, RayIntegral)>,
}

/// Light along rays.
struct Lights {
    bands: Vec<f64>,
    /// At every wavelength that is computed.
    every: Vec<f64>,
    /// The part of it that lines leave.
    left: Vec<f64>,
}

impl TrainingSky {
    /// The sky of the same air under a sun at an elevation (degrees).
    fn new(sky: &SkyPlan, elevation: f64, bands: &[f64], [computed, lined]: [&[f64]; 2]) -> Self {
        let scene = sky.scene.under_sun(elevation);
        let RayIntegral { uniform, optics, variant, .. } = &sky.base;
        let source = Source::sun(&scene);
        let [sun, bearing] = source.for_kernels();
        let under = RayIntegral {
            uniform: Uniform { sun, bearing, ..*uniform },
            variant: variant & !variant::INTEGRAL | needed(&scene, optics),
            source,
            ..sky.base.clone()
        };
        let fit = &SpectralFit::Regression;
        let under = RayIntegral { quadrature: sampled(&scene, &under, fit, bands), ..under };
        let at = |wavelengths: &[f64]| at_wavelengths(&under, fit, wavelengths.to_vec(), bands.len());
        let (own, every) = (with_own_bands(&under, at(bands)), at(computed));
        let strengths = Strengths::new(&scene, &under.optics, lined).filter(|_| !lined.is_empty());
        let Some(strengths) = strengths else { return Self { bands: own, every, lines: None } };
        let every = RayIntegral { bands: without_lines(&under.optics, computed), ..every };
        let of_lines = strengths.integral(&every);
        Self { bands: with_line_bands(own), every, lines: Some((strengths, of_lines)) }
    }

    /// The light of each constituent along rays.
    fn light_of(&self, grids: &[Grid]) -> ByConstituent<Vec<Lights>> {
        let (mut bands, mut every) = (light_of(&self.bands, grids), light_of(&self.every, grids));
        let mut at_strengths = self.lines.as_ref().map(|(_, lines)| light_of(lines, grids));
        let mut beside = |constituent: Constituent| -> Vec<Lights> {
            let take = |parts: &mut ByConstituent<Vec<Vec<f64>>>| std::mem::take(constituent.of_mut(parts));
            let (bands, every) = (take(&mut bands), take(&mut every));
            let left = match (&self.lines, &mut at_strengths) {
                (Some((strengths, _)), Some(light)) => take(light).iter().map(|ray| strengths.left(ray)).collect(),
                _ => vec![Vec::new(); bands.len()],
            };
            let rays = bands.into_iter().zip(every).zip(left);
            rays.map(|((bands, every), left)| Lights { bands, every, left }).collect()
        };
        ByConstituent {
            air: beside(Constituent::Air),
            aerosol: beside(Constituent::Aerosol),
            multiple: beside(Constituent::Multiple),
            ground: beside(Constituent::Ground),
        }
    }
}

/// Wavelengths (nm) at which training light is computed, increasing: the bands, and those asked for or, if these are
/// too many, every [`STEP`] between them that is not close to a band.
pub(crate) fn computed(bands: &[f64], asked: &[f64]) -> Vec<f64> {
    let all = sorted(bands.iter().chain(asked).copied());
    if all.len() <= MOST_COMPUTED {
        return all;
    }
    let (first, last) = (asked[0], asked[asked.len() - 1]);
    let is_apart = |nm: &f64| bands.iter().all(|band| (band - nm).abs() > 0.5 * STEP);
    sorted(multiples(STEP, first, last).filter(is_apart).chain([first, last]).chain(bands.iter().copied()))
}

/// The regressions of each constituent, as a sky teaches them.
fn regressions(sky: &SkyPlan, taught: &TrainingSky) -> Vec<(Constituent, Taught)> {
    let (bands, computed) = (&taught.bands.wavelengths, &taught.every.wavelengths);
    let all = [&bands[..], computed].concat();
    let training = Training { integral: &taught.bands, observer: sky.observer, space: &sky.space };
    let mut light = taught.light_of(&spectral_grids(&taught.bands)[0]);
    // Where there is no ground, no sun or no light, and where a cubic between dark entries of a lookup passes zero, a
    // ray teaches nothing.
    let is_lit = |ray: &Lights| ray.bands.iter().chain(&ray.every).all(|&value| value > DARKEST);
    let smooth = bands.len() - if taught.lines.is_some() { LINE_BANDS.len() } else { 0 };
    let of = |constituent: Constituent| {
        let rays: Vec<Lights> = std::mem::take(constituent.of_mut(&mut light)).into_iter().filter(is_lit).collect();
        let left = of_lines(&rays);
        let spectra = rays.into_iter().map(|ray| [ray.bands, ray.every].concat()).collect();
        let mut examples = training.chosen(constituent, spectra, &all);
        examples.bands.iter_mut().for_each(|bands| bands.truncate(smooth));
        (constituent, examples, left)
    };
    let examples: Vec<(Constituent, Examples, Option<Examples>)> = training.constituents().map(of).collect();
    let places = places(&bands[..smooth], computed);
    let regressed = |(constituent, examples, left): (Constituent, Examples, Option<Examples>)| {
        let mut regressions = regress(&examples, 0..computed.len(), NOISE);
        regressions.iter_mut().for_each(|regression| regression.slopes.resize(bands.len(), 0.0));
        // Bands that stand for more than their wavelength are not what is sought there.
        let smooth = if sky.base.optics.is_on_steps() {
            let at_bands: Vec<&Regression> = places.iter().map(|&place| &regressions[place]).collect();
            let right = |(&nm, regression)| right_at_bands(regression, &at_bands, &lines(bands, nm));
            computed.iter().zip(&regressions).map(right).collect()
        } else {
            regressions
        };
        let left = left.map_or_else(Vec::new, |left| regress_parts(&left, NOISE));
        (constituent, Taught { smooth, left })
    };
    examples.into_par_iter().map(regressed).collect()
}

/// The least part of light that lines leave, of which a logarithm is taken.
const LEAST_LEFT: f64 = 1e-4;

/// What lines leave of rays as bright as counts; none without lines, or without rays.
fn of_lines(rays: &[Lights]) -> Option<Examples> {
    let brightness = |ray: &Lights| ray.bands[ray.bands.len() / 2];
    let brightest = rays.iter().map(brightness).fold(0.0, f64::max);
    let is_lit = |ray: &&Lights| !ray.left.is_empty() && brightness(ray) > LIT * brightest;
    let lit: Vec<&Lights> = rays.iter().filter(is_lit).collect();
    let logarithms = |ray: &&Lights| ray.bands.iter().map(|value| value.ln()).collect();
    let left = |ray: &&Lights| ray.left.iter().map(|left| left.max(LEAST_LEFT)).collect();
    let examples = Examples {
        bands: lit.iter().map(logarithms).collect(),
        values: lit.iter().map(left).collect(),
        weights: vec![1.0; lit.len()],
    };
    (!lit.is_empty()).then_some(examples)
}

/// A sky along rays from which nothing was learnt.
struct Tried {
    sky: TrainingSky,
    lined: Vec<f64>,
    views: Vec<Vec3>,
    light: ByConstituent<Vec<Lights>>,
}

impl Tried {
    fn new(sky: TrainingSky, lined: &[f64]) -> Self {
        let [_, grids] = spectral_grids(&sky.bands);
        let views = grids.iter().flat_map(|grid| grid.views(&sky.bands)).collect();
        let light = sky.light_of(&grids);
        Self { sky, lined: lined.to_vec(), views, light }
    }

    /// The largest error of regressions at every wavelength that was computed between two ends (nm), of light without
    /// lines or of what they leave.
    fn error(&self, regressions: &Regressions, ends: [f64; 2], of_lines: bool) -> f64 {
        let TrainingSky { every, lines, .. } = &self.sky;
        let computed = &every.wavelengths;
        let judged = places(&ends, computed);
        let judged = judged[0]..judged[1] + 1;
        let illumination = Illumination::new(&Optics { sun_distance: 1.0, ..every.optics.clone() }, computed);
        let lined = lines.as_ref().filter(|_| of_lines).map(|_| places(computed, &self.lined));
        let ByConstituent { air, aerosol, multiple, ground } = &self.light;
        let lights = ByConstituent { air, aerosol, multiple, ground };
        let of_ray = |(ray, &view): (usize, &Vec3)| {
            let seen = |constituent: Constituent| &constituent.of(lights)[ray];
            let found =
                radiance(every, &illumination, regressions, view, |constituent| seen(constituent).bands.clone());
            let phases: Vec<Vec<f64>> =
                regressions.iter().map(|(constituent, _)| every.phases_at(*constituent, view, computed)).collect();
            let truth = |i: usize| {
                let of = |((constituent, _), phases): (&(Constituent, Vec<Regression>), &Vec<f64>)| {
                    let light = seen(*constituent);
                    let left = lined.as_ref().map_or(1.0, |lined| light.left[lined[i]]);
                    light.every[i] * left * illumination.albedo(*constituent)[i] * phases[i]
                };
                regressions.iter().zip(&phases).map(of).sum::<f64>() * illumination.sun[i]
            };
            let truth: Vec<f64> = (0..computed.len()).map(truth).collect();
            let peak = truth[judged.clone()].iter().copied().fold(0.0, f64::max);
            let error = |i: usize| match (found[i] - truth[i]).abs() / truth[i].max(FLOOR * peak) {
                error if error.is_nan() => f64::INFINITY,
                error => error,
            };
            if peak > 0.0 { judged.clone().map(error).fold(0.0, f64::max) } else { 0.0 }
        };
        self.views.iter().enumerate().map(of_ray).fold(0.0, f64::max)
    }
}
