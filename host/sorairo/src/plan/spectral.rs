//! Spectra of a sky, planned: from the light at a few bands to the radiance at any wavelengths.
//!
//! The four bands of colour leave the ends of a spectrum to extrapolation: 7.8 % at 380 nm by day. So a spectrum takes eight more, [`BANDS`], and
//! learns from rays in a light field as fine as the sky's: under the lowest and the highest sun that have the same light field, so that what
//! was learnt serves all suns between them. Rays under one half way, from which nothing was learnt, tell whether that is good enough; where it is
//! not, each wavelength is integrated. Up to eight wavelengths are bands themselves.

use std::sync::Arc;

use rayon::prelude::*;
use sorairo_shared::fit::spectrum::SPECTRUM_RISE;
use sorairo_shared::glam::{Vec2, Vec3, Vec4};
use sorairo_shared::sky::Parts;
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant;

use super::directions::{direction, is_night};
use super::fit::SpectralFit;
use super::fit::linear::{Interpolant, LinearFit, hats};
use super::fit::regression::{Examples, Regression, Training, beside_more_bands, regress, spectrum_rows};
use super::fit::training::{DARKEST, Grid, Place, known, light_of, multiples, sorted, spectral_grids};
use super::integral::{Constituent, RayIntegral, needed};
use super::multiple::{Keep, TOGETHER};
use super::quadrature::gauss_legendre;
use super::sky::{SkyPlan, optics_of};
use super::{samples, upload};
use crate::scene::{ColourPath, Scene};
use crate::spectra::mean::Window;
use crate::spectra::measured::MEASURED_RANGE;
use crate::spectra::observer;
use crate::spectra::optics::Optics;

/// Bands (nm) that a spectrum takes beside the four of colour, the same for every sky: between those and beyond them, closer where ozone's
/// cross-section bends. What they leave over 70 skies stands in `docs/decisions/04-regression-fit.md`.
pub const BANDS: [f64; 8] = [365.0, 395.0, 480.0, 600.0, 665.0, 700.0, 750.0, 830.0];

/// What a spectrum may be off by day, relative to itself or, where it is fainter, to [`FLOOR`] of its peak.
pub const BOUND_BY_DAY: f64 = 0.01;

/// The same in twilight, which varies more from ray to ray.
pub const BOUND_IN_TWILIGHT: f64 = 0.02;

/// The part of a spectrum's peak below which errors are relative to that.
pub const FLOOR: f64 = 0.05;

/// Variance of a band's logarithm that says nothing: light is read between the entries of a lookup, which is off by some 3e-4, and slopes of
/// both signs multiply it.
const NOISE: f64 = 1e-7;

/// Bands (nm) that lie closer tell nothing new of each other.
const CLOSEST: f64 = 5.0;

/// The most wavelengths at which training light is computed.
const MOST_COMPUTED: usize = 2 * TOGETHER;

/// Step (nm) between those at which it is where more are asked for: ozone's cross-section bends within ten.
const STEP: f64 = 5.0;

/// Step (nm) between the wavelengths that colour needs where each wavelength is integrated.
const COLOUR_STEP: f64 = 20.0;

/// Wider bands (nm) are integrated in parts: over 20 nm a spectrum bends by 0.2 % at 390 nm, over 50 by 1.3 %.
const WIDEST: f64 = 20.0;

/// The regressions of each constituent, one for each wavelength.
pub type Regressions = Vec<(Constituent, Vec<Regression>)>;

/// What gives the radiance at wavelengths.
#[derive(Clone, Debug)]
pub enum SpectrumFit {
    /// Weighted sums of the light at the bands.
    Linear(LinearFit),
    /// A regression of each constituent for each wavelength.
    Regression(Regressions),
}

/// What rays say from which nothing was learnt.
#[derive(Clone, Copy, Debug)]
pub struct HeldOut {
    /// The largest error of the regression.
    pub error: f64,
    /// What it may be.
    pub bound: f64,
}

/// The spectra of a sky at some wavelengths.
#[derive(Clone, Debug)]
pub struct SpectralPlan {
    /// The wavelengths (nm).
    pub wavelengths: Vec<f64>,
    /// Those at which the fit is read (nm): the same, or the middles of as many parts of each band.
    points: Vec<f64>,
    /// The ray integral at the bands, of which those of colour come first.
    pub integral: RayIntegral,
    /// The fit through them.
    pub fit: SpectrumFit,
    /// The fit of colours where it goes through bands of its own, which stand behind the others: means, where each
    /// wavelength is integrated and tables are finer than the observer's nodes.
    colour: Option<LinearFit>,
    /// What light at the wavelengths is relative to.
    lit_by: LitBy,
    /// How good a regression was found to be; none where nothing had to be learnt, or the scene chose its bands or its fit.
    pub held_out: Option<HeldOut>,
}

impl SpectralPlan {
    /// That of a sky at wavelengths (nm): through as many bands as they need, or through the scene's own if it names its bands or another fit. Tables
    /// say what holds at each wavelength itself.
    pub fn new(sky: &SkyPlan, wavelengths: &[f64]) -> Self {
        Self::as_read(&sky.at_wavelengths(), wavelengths)
    }

    /// That of a sky at the nodes of the observer, for sums over them: of tables it takes the means over what each node stands for, and so the sun's
    /// lines and what lies between the nodes count.
    pub fn over_steps(sky: &SkyPlan) -> Self {
        Self::as_read(sky, &observer::wavelengths())
    }

    /// That of a sky in bands so wide (nm) about wavelengths (nm): the means of the sun and of tables over each. What
    /// is smooth counts in the middle of a band, or of each part of one that is wider than 20 nm.
    pub fn over_bands(sky: &SkyPlan, wavelengths: &[f64], width: f64) -> Self {
        let parts = (width / WIDEST).ceil().max(1.0);
        let part = width / parts;
        if parts == 1.0 || sky.is_night || is_chosen(sky) {
            return Self::as_read(&sky.over_bands(width), wavelengths);
        }
        let middles = |nm: &f64| {
            let first = nm - 0.5 * (width - part);
            (0..parts as u32).map(move |i| (first + part * f64::from(i)).clamp(MEASURED_RANGE.0, MEASURED_RANGE.1))
        };
        let points: Vec<f64> = wavelengths.iter().flat_map(middles).collect();
        let each = Self::of_each(&sky.over_bands(part), &points, &sorted(points.iter().copied()));
        Self { wavelengths: wavelengths.to_vec(), ..each }
    }

    /// That of a sky whose optics are read at wavelengths (nm), or about them.
    fn as_read(sky: &SkyPlan, wavelengths: &[f64]) -> Self {
        if sky.is_night || is_chosen(sky) || wavelengths.is_empty() {
            return Self::through_own_bands(sky, wavelengths);
        }
        let asked = sorted(wavelengths.iter().copied());
        let is_own = |nm: &f64| sky.base.optics.is_on_steps() && sky.base.wavelengths.contains(nm);
        let others: Vec<f64> = asked.iter().copied().filter(|nm| !is_own(nm)).collect();
        if others.len() <= BANDS.len() {
            return Self::of_bands(sky, wavelengths, others);
        }
        Self::learnt(sky, wavelengths, &asked)
    }

    /// That of a sky by its own bands, those of its colour.
    pub fn of_own_bands(sky: &SkyPlan, wavelengths: &[f64]) -> Self {
        Self::through_own_bands(&sky.at_wavelengths(), wavelengths)
    }

    fn through_own_bands(sky: &SkyPlan, wavelengths: &[f64]) -> Self {
        let fit = match &sky.fit {
            SpectralFit::Linear(fit) => SpectrumFit::Linear(fit.clone()),
            SpectralFit::Regression if sky.is_night => SpectrumFit::Regression(Vec::new()),
            SpectralFit::Regression => SpectrumFit::Regression(sky.training().regressions(wavelengths)),
        };
        Self::through(wavelengths, sky.integral().clone(), fit, None)
    }

    /// That of wavelengths each of which is a band, one of the sky's or of `others`.
    fn of_bands(sky: &SkyPlan, wavelengths: &[f64], others: Vec<f64>) -> Self {
        let integral = beside_own(sky, others);
        let regression = |&nm: &f64| {
            // The last, since the band of a colour may stand for more than its wavelength.
            let its_own = integral.wavelengths.iter().rposition(|&band| band == nm);
            let slope = |band: usize| if Some(band) == its_own { 1.0 } else { 0.0 };
            Regression { intercept: 0.0, slopes: (0..integral.wavelengths.len()).map(slope).collect() }
        };
        let regressions: Vec<Regression> = wavelengths.iter().map(regression).collect();
        let training = Training { integral: &integral, observer: sky.observer, space: &sky.space };
        let constituents = training.constituents();
        let fit = constituents.map(|constituent| (constituent, regressions.clone())).collect();
        Self::through(wavelengths, integral, SpectrumFit::Regression(fit), None)
    }

    /// That of more wavelengths, `asked` in order, through [`BANDS`] beside the sky's, or each itself.
    fn learnt(sky: &SkyPlan, wavelengths: &[f64], asked: &[f64]) -> Self {
        let own = &sky.base.wavelengths;
        let integral = beside_own(sky, bands_beside(own, asked));
        let lesson = Lesson::of(sky, integral.wavelengths.clone(), asked);
        let bound = if integral.uniform.sun.z < 0.0 { BOUND_IN_TWILIGHT } else { BOUND_BY_DAY };
        let held_out = Some(HeldOut { error: lesson.error, bound });
        if lesson.error > bound {
            return Self { held_out, ..Self::of_each(sky, wavelengths, asked) };
        }
        let at = |(constituent, regressions): (Constituent, Vec<Regression>)| {
            (constituent, between(&integral.optics, constituent, &lesson.computed, &regressions, wavelengths))
        };
        let fit = SpectrumFit::Regression(lesson.under(sky.scene.sun.elevation).into_iter().map(at).collect());
        Self::through(wavelengths, integral, fit, held_out)
    }

    /// That of wavelengths each of which is a band, with others where an observer of colours would miss them.
    fn of_each(sky: &SkyPlan, wavelengths: &[f64], asked: &[f64]) -> Self {
        let nodes: Vec<f64> = multiples(COLOUR_STEP, observer::START, observer::END).collect();
        let fit_through =
            |wavelengths| LinearFit { wavelengths, interpolant: Interpolant::Segments, of_radiance: false };
        let is_missed = |nm: &f64| asked.iter().all(|asked| (asked - nm).abs() > 0.5 * COLOUR_STEP);
        let is_smooth = sky.base.optics.is_on_steps();
        let between = nodes.iter().copied().filter(|nm| is_smooth && is_missed(nm));
        let fit = fit_through(sorted(asked.iter().copied().chain(between)));
        let of_lines = SpectralFit::Linear(fit.clone());
        let mut integral = at_bands(sky, &of_lines, fit.wavelengths.clone());
        let colour = (!is_smooth).then(|| {
            let means = optics_of(&sky.scene).over(Window::Node(COLOUR_STEP));
            integral.bands.extend(of_lines.bands(&means, &nodes));
            fit_through(nodes)
        });
        let integral = integral.with_spectral_light();
        Self { colour, ..Self::through(wavelengths, integral, SpectrumFit::Linear(fit), None) }
    }

    fn through(wavelengths: &[f64], integral: RayIntegral, fit: SpectrumFit, held_out: Option<HeldOut>) -> Self {
        let lit_by = LitBy::new(&integral.optics, wavelengths);
        let points = wavelengths.to_vec();
        Self { wavelengths: points.clone(), points, integral, fit, colour: None, lit_by, held_out }
    }

    /// The rows of a spectral image: those of colour, and those of the spectrum.
    pub fn rows(&self, sky: &SkyPlan) -> [Vec<Vec4>; 2] {
        let optics = &self.integral.optics;
        match &self.fit {
            SpectrumFit::Linear(fit) => {
                let folded = |fit: &LinearFit| fit.folded(&sky.base.optics, sky.observer, &sky.space);
                let (own, all) = (fit.wavelengths.len().div_ceil(4), self.integral.bands.len());
                let of_spectrum = self.mean_rows(&fit.spectrum_rows(optics, &self.points), own);
                let Some(colour) = &self.colour else { return [folded(fit), of_spectrum] };
                let of_colour = [vec![Vec4::ZERO; 3 * own], folded(colour)].concat();
                let beside = vec![Vec4::ZERO; all - own];
                [of_colour, of_spectrum.chunks(own).flat_map(|row| [row, &beside].concat()).collect()]
            }
            SpectrumFit::Regression(regressions) => {
                let (own, all) = (sky.base.bands.len(), self.integral.bands.len());
                let colour = beside_more_bands(&sky.colours().rows, own, all);
                [colour, spectrum_rows(optics, &self.wavelengths, regressions)]
            }
        }
    }

    /// The mean of the rows of each band's parts, each of so many groups.
    fn mean_rows(&self, rows: &[Vec4], groups: usize) -> Vec<Vec4> {
        let parts = self.parts();
        let of_band = |rows: &[Vec4], group| rows.iter().skip(group).step_by(groups).sum::<Vec4>() / parts as f32;
        rows.chunks(parts * groups).flat_map(|rows| (0..groups).map(move |group| of_band(rows, group))).collect()
    }

    /// In how many parts each band is integrated; one of a wavelength.
    fn parts(&self) -> usize {
        self.points.len().checked_div(self.wavelengths.len()).unwrap_or(1)
    }

    /// Radiance at each wavelength in a direction (W·m⁻²·sr⁻¹·nm⁻¹); by a polynomial it may lie below zero.
    pub fn radiance(&self, view: Vec3) -> Vec<f64> {
        self.radiance_of_directions(&[view])
    }

    /// The same in many directions, one after the other.
    pub fn radiance_of_directions(&self, views: &[Vec3]) -> Vec<f64> {
        let optics = &self.integral.optics;
        match &self.fit {
            SpectrumFit::Linear(fit) => {
                let of_view = |view: &Vec3| {
                    let at_bands = self.integral.transfer(*view);
                    let at = |&point: &f64| fit.radiance(optics, &at_bands, point);
                    let radiance: Vec<f64> = self.points.iter().map(at).collect();
                    means(&radiance, self.parts()).collect::<Vec<_>>()
                };
                views.iter().flat_map(of_view).collect()
            }
            SpectrumFit::Regression(regressions) => {
                let light = self.integral.light_of_directions(views);
                let of_view = |(&view, light): (&Vec3, &[Parts<Vec4>])| {
                    let of = |constituent: Constituent| {
                        self.integral.at_bands(light.iter().map(|&group| constituent.of(group)))
                    };
                    radiance(&self.integral, &self.lit_by, regressions, view, of)
                };
                views.iter().zip(light.chunks_exact(self.integral.bands.len())).flat_map(of_view).collect()
            }
        }
    }
}

/// Whether a scene names its bands or another fit than spectra take.
fn is_chosen(sky: &SkyPlan) -> bool {
    sky.scene.render.bands.is_some() || !matches!(sky.fit, SpectralFit::Regression)
}

/// The means of as many neighbours each.
fn means(values: &[f64], of: usize) -> impl Iterator<Item = f64> {
    values.chunks(of).map(move |values| values.iter().sum::<f64>() / of as f64)
}

/// What light at some wavelengths is relative to.
#[derive(Clone, Debug)]
struct LitBy {
    /// Irradiance of the sun above the atmosphere (W·m⁻²·nm⁻¹).
    sun: Vec<f64>,
    /// What each constituent's light is multiplied with; see [`Constituent::albedo`].
    albedo: Parts<Vec<f64>>,
}

impl LitBy {
    fn new(optics: &Optics, wavelengths: &[f64]) -> Self {
        let albedo = |of: Constituent| wavelengths.iter().map(|&nm| of.albedo(optics, nm)).collect();
        Self {
            sun: wavelengths.iter().map(|&nm| optics.solar_irradiance(nm)).collect(),
            albedo: Parts {
                air: albedo(Constituent::Air),
                aerosol: albedo(Constituent::Aerosol),
                multiple: albedo(Constituent::Multiple),
                ground: albedo(Constituent::Ground),
            },
        }
    }

    fn albedo(&self, of: Constituent) -> &[f64] {
        let Parts { air, aerosol, multiple, ground } = &self.albedo;
        of.of(Parts { air, aerosol, multiple, ground })
    }
}

/// Radiance by regressions at their wavelengths in a direction, from the light of each constituent at the bands.
fn radiance(
    integral: &RayIntegral,
    lit_by: &LitBy,
    regressions: &[(Constituent, Vec<Regression>)],
    view: Vec3,
    light: impl Fn(Constituent) -> Vec<f64>,
) -> Vec<f64> {
    let phases = integral.phases(view);
    let mut transfer = vec![0.0; lit_by.sun.len()];
    for (constituent, regressions) in regressions {
        let at_bands = light(*constituent);
        if at_bands.iter().all(|&value| value == 0.0) {
            continue;
        }
        let logarithms: Vec<f64> = at_bands.iter().map(|value| value.max(DARKEST).ln()).collect();
        let phase = f64::from(constituent.of(phases));
        let highest = at_bands.iter().copied().fold(DARKEST, f64::max) * f64::from(SPECTRUM_RISE).exp();
        for ((sum, regression), albedo) in transfer.iter_mut().zip(regressions).zip(lit_by.albedo(*constituent)) {
            *sum += phase * albedo * regression.value(&logarithms).min(highest);
        }
    }
    transfer.iter().zip(&lit_by.sun).map(|(transfer, sun)| transfer * sun).collect()
}

/// The sky's light at its own bands and at others (nm).
fn beside_own(sky: &SkyPlan, others: Vec<f64>) -> RayIntegral {
    let bands = [sky.base.wavelengths.clone(), others].concat();
    with_own_bands(&sky.base, at_bands(sky, &SpectralFit::Regression, bands)).with_spectral_light()
}

/// The first bands of an integral as those of a sky's colour, which are means over what they stand for.
fn with_own_bands(sky: &RayIntegral, mut integral: RayIntegral) -> RayIntegral {
    // They fill their groups: a sky that names other bands has no more beside them.
    integral.bands[..sky.bands.len()].copy_from_slice(&sky.bands);
    integral
}

/// The sky's light at bands (nm), sampled as they need it; without that which was scattered more than once.
fn at_bands(sky: &SkyPlan, fit: &SpectralFit, bands: Vec<f64>) -> RayIntegral {
    let own = &sky.base;
    let quadrature = if samples::depends_on_bands(&sky.scene, own.variant) {
        sampled(&sky.scene, own, fit, &bands)
    } else {
        own.quadrature.clone()
    };
    let count = bands.len();
    RayIntegral { quadrature, ..at_wavelengths(own, fit, bands, count) }
}

/// The light of a sky at wavelengths (nm), for a fit through so many bands; without that which was scattered more than once.
fn at_wavelengths(sky: &RayIntegral, fit: &SpectralFit, wavelengths: Vec<f64>, bands: usize) -> RayIntegral {
    RayIntegral {
        bands: fit.bands(&sky.optics, &wavelengths),
        wavelengths,
        variant: sky.variant & !variant::FIT | fit.variant(bands, ColourPath::Folded),
        ..sky.clone()
    }
}

/// The rule by which the rays of a scene's sky are sampled as bands (nm) need it.
fn sampled(scene: &Scene, sky: &RayIntegral, fit: &SpectralFit, bands: &[f64]) -> Vec<Vec2> {
    let RayIntegral { uniform, optics, variant, .. } = sky;
    let bands = fit.bands(optics, bands);
    let fewest = || samples::per_piece(scene, uniform, optics, &bands, *variant, &sky.light_fields);
    gauss_legendre(scene.render.steps.unwrap_or_else(fewest))
}

/// What the skies of all suns that have the same light field teach of their spectra.
struct Lesson {
    /// The wavelengths at which light was computed (nm).
    computed: Vec<f64>,
    /// For some suns, by their elevation (degrees, increasing), the regressions of each constituent there.
    suns: Vec<(f64, Regressions)>,
    /// The largest error of those between two suns along rays from which they did not learn.
    error: f64,
}

impl Keep for Lesson {
    fn bytes(&self) -> usize {
        let regressions = self.suns.iter().flat_map(|(_, of_sun)| of_sun).flat_map(|(_, regressions)| regressions);
        let of = |regression: &Regression| size_of::<Regression>() + size_of_val(&regression.slopes[..]);
        regressions.map(of).sum::<usize>() + size_of_val(&self.computed[..])
    }
}

impl Lesson {
    /// That of the skies about a sky for a spectrum through bands (nm), at wavelengths asked for in order (nm).
    fn of(sky: &SkyPlan, bands: Vec<f64>, asked: &[f64]) -> Arc<Self> {
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
        let learnt = |elevation: f64| (elevation, regressions(sky, &Taught::new(sky, elevation, &bands, &computed)));
        let suns = Some(lowest).filter(lit).into_iter().chain([highest]).map(learnt).collect();
        let between = if lit(&middle) { middle } else { highest };
        let tried = Taught::new(sky, between, &bands, &computed);
        let lesson = Self { computed, suns, error: 0.0 };
        Self { error: error(&tried, &lesson.under(between), ends), ..lesson }
    }

    /// The regressions under a sun at an elevation (degrees): between those of two suns.
    fn under(&self, elevation: f64) -> Regressions {
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
struct Taught {
    bands: RayIntegral,
    every: RayIntegral,
}

impl Taught {
    /// The sky of the same air under a sun at an elevation (degrees).
    fn new(sky: &SkyPlan, elevation: f64, bands: &[f64], computed: &[f64]) -> Self {
        let scene = sky.scene.under_sun(elevation);
        let RayIntegral { uniform, optics, variant, .. } = &sky.base;
        let towards = |elevation| direction(elevation, scene.sun.azimuth).as_vec3().extend(0.0);
        let under = RayIntegral {
            uniform: Uniform { sun: towards(elevation), bearing: towards(0.0), ..*uniform },
            variant: variant & !variant::WHOLE_INTEGRAL | needed(&scene, optics),
            sun_azimuth: scene.sun.azimuth,
            ..sky.base.clone()
        };
        let fit = &SpectralFit::Regression;
        let under = RayIntegral { quadrature: sampled(&scene, &under, fit, bands), ..under };
        let at = |wavelengths: &[f64]| at_wavelengths(&under, fit, wavelengths.to_vec(), bands.len());
        Self { bands: with_own_bands(&under, at(bands)), every: at(computed) }
    }

    /// The light of each constituent along rays: at the bands, then at every wavelength.
    fn light_of(&self, grids: &[Grid]) -> Parts<Vec<Vec<f64>>> {
        let (mut bands, mut every) = (light_of(&self.bands, grids), light_of(&self.every, grids));
        let mut beside = |constituent: Constituent| -> Vec<Vec<f64>> {
            let [bands, every] = [&mut bands, &mut every].map(|parts| std::mem::take(constituent.of_mut(parts)));
            bands.into_iter().zip(every).map(|(bands, every)| [bands, every].concat()).collect()
        };
        Parts {
            air: beside(Constituent::Air),
            aerosol: beside(Constituent::Aerosol),
            multiple: beside(Constituent::Multiple),
            ground: beside(Constituent::Ground),
        }
    }
}

/// Those of [`BANDS`] (nm) that lie among wavelengths asked for, in order, and apart from some bands. What lies beyond moves to their ends.
fn bands_beside(own: &[f64], asked: &[f64]) -> Vec<f64> {
    let mut all = own.to_vec();
    for band in BANDS.map(|band| band.clamp(asked[0], asked[asked.len() - 1])) {
        if all.iter().all(|other| (other - band).abs() >= CLOSEST) {
            all.push(band);
        }
    }
    all.split_off(own.len())
}

/// Wavelengths (nm) at which training light is computed, increasing: the bands, and those asked for or, if these are too many, every
/// [`STEP`] between them that is not close to a band.
fn computed(bands: &[f64], asked: &[f64]) -> Vec<f64> {
    let all = sorted(bands.iter().chain(asked).copied());
    if all.len() <= MOST_COMPUTED {
        return all;
    }
    let (first, last) = (asked[0], asked[asked.len() - 1]);
    let is_apart = |nm: &f64| bands.iter().all(|band| (band - nm).abs() > 0.5 * STEP);
    sorted(multiples(STEP, first, last).filter(is_apart).chain([first, last]).chain(bands.iter().copied()))
}

/// Where each of some wavelengths (nm) stands among others.
fn places(wavelengths: &[f64], all: &[f64]) -> Vec<usize> {
    wavelengths.iter().map(|nm| all.partition_point(|other| other < nm)).collect()
}

/// The regressions of each constituent at every wavelength that was computed, as a sky teaches them.
fn regressions(sky: &SkyPlan, taught: &Taught) -> Regressions {
    let (bands, computed) = (&taught.bands.wavelengths, &taught.every.wavelengths);
    let all = [&bands[..], computed].concat();
    let training = Training { integral: &taught.bands, observer: sky.observer, space: &sky.space };
    let mut spectra = taught.light_of(&spectral_grids(&taught.bands)[0]);
    // Where there is no ground, no sun or no light, and where a cubic between dark entries of a lookup passes zero, a ray teaches nothing.
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

/// A regression to which the bands' own regressions add what they miss of the bands, by the weights of straight lines between them. The bands are
/// right then, and what rays have that no other taught, such as what a lookup leaves, goes along.
fn right_at_bands(regression: &Regression, at_bands: &[&Regression], weights: &[f64]) -> Regression {
    let missed = |of: &dyn Fn(&Regression) -> f64| -> f64 {
        at_bands.iter().zip(weights).map(|(at_band, weight)| weight * of(at_band)).sum()
    };
    let slope = |(band, slope): (usize, &f64)| slope + weights[band] - missed(&|at_band| at_band.slopes[band]);
    Regression {
        intercept: regression.intercept - missed(&|at_band| at_band.intercept),
        slopes: regression.slopes.iter().enumerate().map(slope).collect(),
    }
}

/// The weights of bands (nm, in any order) on the straight lines between them, level beyond their ends, at a wavelength (nm).
fn lines(bands: &[f64], wavelength: f64) -> Vec<f64> {
    let increasing = sorted(bands.iter().copied());
    let weights = hats(&increasing, wavelength);
    places(bands, &increasing).into_iter().map(|place| weights[place]).collect()
}

/// The regressions of a constituent at wavelengths (nm) between those at which they were computed. What of a spectrum's logarithm is not known
/// goes with the optical depths, and a regression is linear in what it is made of.
fn between(
    optics: &Optics,
    constituent: Constituent,
    computed: &[f64],
    regressions: &[Regression],
    wavelengths: &[f64],
) -> Vec<Regression> {
    let known = |nm: f64| known(optics, constituent, nm).ln();
    let at = |&nm: &f64| {
        let Place { below, part } = Place::of(nm, computed);
        let (low, high) = (&regressions[below], &regressions[below + 1]);
        let mixed = low.towards(high, part);
        let known_of_both = [below, below + 1].map(|at| known(computed[at]));
        let known_between = known_of_both[0] + part * (known_of_both[1] - known_of_both[0]);
        Regression { intercept: mixed.intercept + known(nm) - known_between, ..mixed }
    };
    wavelengths.iter().map(at).collect()
}

/// The largest error of regressions at every wavelength that was computed between two ends (nm), along rays of a sky from which they did not
/// learn.
fn error(sky: &Taught, regressions: &[(Constituent, Vec<Regression>)], ends: [f64; 2]) -> f64 {
    let Taught { bands, every } = sky;
    let computed = &every.wavelengths;
    let judged = places(&ends, computed);
    let judged = judged[0]..judged[1] + 1;
    let [_, grids] = spectral_grids(bands);
    let views: Vec<Vec3> = grids.iter().flat_map(|grid| grid.views(bands)).collect();
    let lit_by = LitBy::new(&Optics { sun_distance: 1.0, ..every.optics.clone() }, computed);
    let Parts { air, aerosol, multiple, ground } = &sky.light_of(&grids);
    let spectra = Parts { air, aerosol, multiple, ground };
    let of_ray = |(ray, &view): (usize, &Vec3)| {
        let seen = |constituent: Constituent| constituent.of(spectra)[ray].split_at(bands.wavelengths.len());
        let found = radiance(every, &lit_by, regressions, view, |constituent| seen(constituent).0.to_vec());
        let phases = every.phases(view);
        let truth = |i: usize| {
            let of = |(constituent, _): &(Constituent, Vec<Regression>)| {
                seen(*constituent).1[i] * lit_by.albedo(*constituent)[i] * f64::from(constituent.of(phases))
            };
            regressions.iter().map(of).sum::<f64>() * lit_by.sun[i]
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::direction;
    use crate::scene::{Fit, GroundAlbedo, Preset, Rgb, Scene, SunSpectrum};
    use crate::spectra::table::Table;
    use crate::spectra::table_file::TableFile;

    fn sky(change: impl FnOnce(&mut Scene)) -> SkyPlan {
        let mut scene = Scene::preset(Preset::Standard);
        change(&mut scene);
        SkyPlan::new(&scene.validated().unwrap(), Rgb::Srgb)
    }

    fn every(step: f64, first: f64, last: f64) -> Vec<f64> {
        multiples(step, first, last).collect()
    }

    #[test]
    fn bands_lie_among_the_wavelengths_that_are_asked_for_and_apart() {
        let own = [433.0, 525.0, 564.0, 632.0];
        assert_eq!(bands_beside(&own, &[360.0, 830.0]), BANDS);
        let fewer = bands_beside(&own, &[400.0, 700.0]);
        assert_eq!(fewer, [400.0, 480.0, 600.0, 665.0, 700.0]);
        assert!(bands_beside(&own, &[432.0, 437.0]).is_empty());
    }

    #[test]
    fn a_scene_that_names_its_bands_or_its_fit_keeps_them() {
        let wavelengths = every(10.0, 380.0, 780.0);
        let given = vec![400.0, 470.0, 540.0, 610.0, 700.0];
        let own = sky(|scene| scene.render.bands = Some(given.clone()));
        assert_eq!(SpectralPlan::new(&own, &wavelengths).integral.wavelengths, given);
        let cubic = sky(|scene| scene.render.fit = Fit::Cubic);
        assert!(matches!(SpectralPlan::new(&cubic, &wavelengths).fit, SpectrumFit::Linear(_)));
        let night = sky(|scene| scene.sun.elevation = -40.0);
        let dark = SpectralPlan::new(&night, &wavelengths).radiance(Vec3::Z);
        assert_eq!(dark, vec![0.0; wavelengths.len()]);
    }

    #[test]
    fn light_below_zero_teaches_the_bands_of_colour_nothing() {
        // Cubics between the nodes of its light field pass below zero at the shortest wavelengths.
        let sky = sky(|scene| scene.sun.elevation = -15.0);
        let wavelengths = every(5.0, 380.0, 780.0);
        let view = direction(40.0, 60.0).as_vec3();
        let brightest = |spectra: SpectralPlan| spectra.radiance(view).into_iter().fold(0.0, f64::max);
        let own = brightest(SpectralPlan::of_own_bands(&sky, &wavelengths));
        let right = brightest(SpectralPlan::new(&sky, &wavelengths));
        // Bands chosen for colour are off by a factor of 4 here; those that had learnt from darkness by 14 000.
        assert!(own > 0.1 * right && own < 10.0 * right, "{own:e}, {right:e}");
    }

    #[test]
    fn where_a_fit_will_not_do_each_wavelength_is_integrated_and_colour_stays() {
        let sky = sky(|scene| scene.sun.elevation = 15.0);
        let asked = every(25.0, 375.0, 825.0);
        let (each, fitted) =
            (SpectralPlan::of_each(&sky.at_wavelengths(), &asked, &asked), SpectralPlan::new(&sky, &asked));
        assert!(matches!(each.fit, SpectrumFit::Linear(_)) && matches!(fitted.fit, SpectrumFit::Regression(_)));
        let view = direction(20.0, 60.0).as_vec3();
        for (each, fitted) in each.radiance(view).into_iter().zip(fitted.radiance(view)) {
            assert!((fitted / each - 1.0).abs() < BOUND_BY_DAY, "{fitted}, {each}");
        }
        let [of_colour, of_spectrum] = each.rows(&sky);
        let groups = each.integral.bands.len();
        assert_eq!([of_colour.len(), of_spectrum.len()], [3 * groups, asked.len() * groups]);
        let of_colour = |plan: &SpectralPlan| {
            let transfer = plan.integral.transfer(view);
            let [rows, _] = plan.rows(&sky);
            let groups = plan.integral.bands.len();
            let channel = |channel: usize| -> f64 {
                let weight = |band: usize| f64::from(rows[3 * (band / 4) + channel][band % 4]);
                (0..groups * 4).map(|band| weight(band) * transfer.get(band).copied().unwrap_or(0.0)).sum()
            };
            Vec3::from_array([0, 1, 2].map(|i| channel(i) as f32))
        };
        let (found, expected) = (of_colour(&each), sky.radiance(view));
        // Straight lines over 20 nm at most.
        assert!((found - expected).abs().max_element() < 0.02 * expected.max_element(), "{found}, {expected}");
    }

    #[test]
    fn a_colour_beside_each_wavelength_sees_lines_of_the_ground_by_their_mean() {
        let over = |ground: GroundAlbedo| {
            sky(|scene| (scene.ground.albedo, scene.sun.spectrum) = (ground.clone(), SunSpectrum::Flat))
        };
        let asked = every(25.0, 375.0, 825.0);
        let view = direction(-20.0, 60.0).as_vec3();
        let colour = |sky: &SkyPlan| {
            let plan = SpectralPlan::of_each(&sky.at_wavelengths(), &asked, &asked);
            let [rows, spectrum] = plan.rows(sky);
            let groups = plan.integral.bands.len();
            assert_eq!([rows.len(), spectrum.len()], [3 * groups, asked.len() * groups]);
            let integral = RayIntegral { wavelengths: vec![0.0; 4 * groups], ..plan.integral };
            let channel = |channel: usize| -> f64 {
                let weighed =
                    |(band, transfer): (usize, f64)| transfer * f64::from(rows[3 * (band / 4) + channel][band % 4]);
                integral.transfer(view).into_iter().enumerate().map(weighed).sum()
            };
            Vec3::from_array([0, 1, 2].map(|i| channel(i) as f32))
        };
        let expected = over(GroundAlbedo::Grey(0.2)).radiance(view);
        for shift in [0, 2] {
            let lines = (360..=830).map(|nm: u32| (f64::from(nm), [f64::from((nm + shift).is_multiple_of(5))]));
            let ground = GroundAlbedo::File(TableFile::holding("lines.csv", Table::of(lines)));
            let found = colour(&over(ground));
            // Straight lines over 20 nm; the values at the wavelengths themselves are 5 and 0 times the mean.
            assert!((found - expected).abs().max_element() < 0.02 * expected.max_element(), "{found}, {expected}");
        }
    }

    #[test]
    fn wavelengths_between_those_computed_have_regressions_between_theirs() {
        let optics = &sky(|_| {}).base.optics;
        let computed = [500.0, 505.0];
        let regression = |nm: f64| Regression {
            intercept: known(optics, Constituent::Air, nm).ln() - 2.0,
            slopes: vec![0.25 + 0.01 * (nm - 500.0); 4],
        };
        let found =
            &between(optics, Constituent::Air, &computed, &computed.map(regression), &[500.0, 502.5, 505.0])[..];
        for (found, nm) in found.iter().zip([500.0, 502.5, 505.0]) {
            assert!((found.intercept - regression(nm).intercept).abs() < 1e-12, "{nm}");
        }
        // Half way in the fourth power of the wavelength is hardly off half way.
        assert!((found[1].slopes[0] - 0.275).abs() < 1e-3 && found[2].slopes[0] == 0.3, "{:?}", found[1]);
    }
}
