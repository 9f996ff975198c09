//! The regression of spectra on their bands: what is learnt on the rays of some skies, and its error on others.

use std::sync::Arc;

use rayon::prelude::*;
use sorairo_shared::glam::Vec3;
use sorairo_shared::sky::ByConstituent;
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant;

use crate::plan::fit::SpectralFit;
use crate::plan::fit::regression::{Examples, Regression, Training, regress};
use crate::plan::fit::training::{DARKEST, Grid, light_of, multiples, sorted, spectral_grids};
use crate::plan::integral::{Constituent, RayIntegral, needed};
use crate::plan::light_field::{Cacheable, TOGETHER};
use crate::plan::rays::directions::is_night;
use crate::plan::rays::source::Source;
use crate::plan::sky::SkyPlan;
use crate::plan::spectral::bands::{at_wavelengths, sampled, with_own_bands};
use crate::plan::spectral::illumination::{Illumination, Regressions, radiance};
use crate::plan::spectral::interpolation::{lines, places, right_at_bands};
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
    /// For some suns, by their elevation (degrees, increasing), the regressions of each constituent there.
    suns: Vec<(f64, Regressions)>,
    /// The largest error of those between two suns along rays from which they did not learn.
    pub(crate) error: f64,
}

impl Cacheable for SpectralModel {
    fn bytes(&self) -> usize {
        let regressions = self.suns.iter().flat_map(|(_, of_sun)| of_sun).flat_map(|(_, regressions)| regressions);
        let of = |regression: &Regression| size_of::<Regression>() + size_of_val(&regression.slopes[..]);
        regressions.map(of).sum::<usize>() + size_of_val(&self.computed[..])
    }
}

impl SpectralModel {
    /// That of the skies about a sky for a spectrum through bands (nm), at wavelengths asked for in order (nm).
    pub(crate) fn of(sky: &SkyPlan, bands: Vec<f64>, asked: &[f64]) -> Arc<Self> {
        let computed = computed(&bands, asked);
        let ends = [asked[0], asked[asked.len() - 1]];
        let optical = upload::bands(&sky.base.optics, &computed);
        let every = RayIntegral { bands: optical.clone(), ..sky.base.clone() };
        let (resolution, setting) = (every.spectral_resolution(), every.setting());
        let steps = sky.scene.render.steps.map_or(0.0, f64::from);
        // Errors are judged where the sun's spectrum has its lines; how far it is does not matter.
        let sun: Vec<f64> = computed.iter().map(|&nm| sky.base.optics.sun.at(nm)).collect();
        let others = [&computed[..], &bands, &ends, &[steps], &sun].concat();
        let learn = || Self::new(sky, computed, bands, ends);
        // The bands of colour are means, of which the values at wavelengths know nothing.
        let air = [&sky.base.bands[..], &optical].concat();
        sky.base.light_fields.learnt(&setting, &air, (&resolution, sky.base.orders), others, learn)
    }

    fn new(sky: &SkyPlan, computed: Vec<f64>, bands: Vec<f64>, ends: [f64; 2]) -> Self {
        let [lowest, middle, highest] = sky.base.setting().suns_of_light_field();
        let lit = |elevation: &f64| !is_night(&sky.scene.under_sun(*elevation));
        let learnt =
            |elevation: f64| (elevation, regressions(sky, &TrainingSky::new(sky, elevation, &bands, &computed)));
        let suns = Some(lowest).filter(lit).into_iter().chain([highest]).map(learnt).collect();
        let between = if lit(&middle) { middle } else { highest };
        let tried = TrainingSky::new(sky, between, &bands, &computed);
        let model = Self { computed, suns, error: 0.0 };
        Self { error: error(&tried, &model.under(between), ends), ..model }
    }

    /// The regressions under a sun at an elevation (degrees): between those of two suns.
    pub(crate) fn under(&self, elevation: f64) -> Regressions {
        let last = self.suns.len() - 1;
        let above = self.suns.partition_point(|&(sun, _)| sun < elevation).min(last);
        let below = above.saturating_sub(1);
        let [(low, of_low), (high, of_high)] = [below, above].map(|at| &self.suns[at]);
        let part = if high > low { ((elevation - low) / (high - low)).clamp(0.0, 1.0) } else { 1.0 };
        let mix = |low: &[Regression], high: &[Regression]| -> Vec<Regression> {
            low.iter().zip(high).map(|(low, high)| low.towards(high, part)).collect()
        };
        let both = of_low.iter().zip(of_high);
        both.map(|((constituent, low), (_, high))| (*constituent, mix(low, high))).collect()
    }
}

/// A sky that teaches: its light at some bands, and at every wavelength that is computed.
struct TrainingSky {
    bands: RayIntegral,
    every: RayIntegral,
}

impl TrainingSky {
    /// The sky of the same air under a sun at an elevation (degrees).
    fn new(sky: &SkyPlan, elevation: f64, bands: &[f64], computed: &[f64]) -> Self {
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
        Self { bands: with_own_bands(&under, at(bands)), every: at(computed) }
    }

    /// The light of each constituent along rays: at the bands, then at every wavelength.
    fn light_of(&self, grids: &[Grid]) -> ByConstituent<Vec<Vec<f64>>> {
        let (mut bands, mut every) = (light_of(&self.bands, grids), light_of(&self.every, grids));
        let mut beside = |constituent: Constituent| -> Vec<Vec<f64>> {
            let [bands, every] = [&mut bands, &mut every].map(|parts| std::mem::take(constituent.of_mut(parts)));
            bands.into_iter().zip(every).map(|(bands, every)| [bands, every].concat()).collect()
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

/// The regressions of each constituent at every wavelength that was computed, as a sky teaches them.
fn regressions(sky: &SkyPlan, taught: &TrainingSky) -> Regressions {
    let (bands, computed) = (&taught.bands.wavelengths, &taught.every.wavelengths);
    let all = [&bands[..], computed].concat();
    let training = Training { integral: &taught.bands, observer: sky.observer, space: &sky.space };
    let mut spectra = taught.light_of(&spectral_grids(&taught.bands)[0]);
    // Where there is no ground, no sun or no light, and where a cubic between dark entries of a lookup passes zero, a
    // ray teaches nothing.
    let is_lit = |spectrum: &Vec<f64>| spectrum.iter().all(|&value| value > DARKEST);
    let of = |constituent: Constituent| {
        let spectra = std::mem::take(constituent.of_mut(&mut spectra)).into_iter().filter(is_lit);
        (constituent, training.chosen(constituent, spectra.collect(), &all))
    };
    let examples: Vec<(Constituent, Examples)> = training.constituents().map(of).collect();
    let places = places(bands, computed);
    let regressed = |(constituent, examples): (Constituent, Examples)| {
        let regressions = regress(&examples, 0..computed.len(), NOISE);
        let at_bands: Vec<&Regression> = places.iter().map(|&place| &regressions[place]).collect();
        let right = |(&nm, regression)| right_at_bands(regression, &at_bands, &lines(bands, nm));
        // Bands that stand for more than their wavelength are not what is sought there.
        let found = match sky.base.optics.is_on_steps() {
            true => computed.iter().zip(&regressions).map(right).collect(),
            false => regressions,
        };
        (constituent, found)
    };
    examples.into_par_iter().map(regressed).collect()
}

/// The largest error of regressions at every wavelength that was computed between two ends (nm), along rays of a sky
/// from which they did not learn.
fn error(sky: &TrainingSky, regressions: &[(Constituent, Vec<Regression>)], ends: [f64; 2]) -> f64 {
    let TrainingSky { bands, every } = sky;
    let computed = &every.wavelengths;
    let judged = places(&ends, computed);
    let judged = judged[0]..judged[1] + 1;
    let [_, grids] = spectral_grids(bands);
    let views: Vec<Vec3> = grids.iter().flat_map(|grid| grid.views(bands)).collect();
    let illumination = Illumination::new(&Optics { sun_distance: 1.0, ..every.optics.clone() }, computed);
    let ByConstituent { air, aerosol, multiple, ground } = &sky.light_of(&grids);
    let spectra = ByConstituent { air, aerosol, multiple, ground };
    let of_ray = |(ray, &view): (usize, &Vec3)| {
        let seen = |constituent: Constituent| constituent.of(spectra)[ray].split_at(bands.wavelengths.len());
        let found = radiance(every, &illumination, regressions, view, |constituent| seen(constituent).0.to_vec());
        let phases: Vec<Vec<f64>> =
            regressions.iter().map(|(constituent, _)| every.phases_at(*constituent, view, computed)).collect();
        let truth = |i: usize| {
            let of = |((constituent, _), phases): (&(Constituent, Vec<Regression>), &Vec<f64>)| {
                seen(*constituent).1[i] * illumination.albedo(*constituent)[i] * phases[i]
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
    views.iter().enumerate().map(of_ray).fold(0.0, f64::max)
}
