//! Spectra of a sky, planned: from the light at a few bands to the radiance at any wavelengths.
//!
//! The four bands of colour leave the ends of a spectrum to extrapolation: 7.8 % at 380 nm by day. So a spectrum takes
//! eight more, [`BANDS`], and learns from rays in a light field as fine as the sky's: under the lowest and the highest
//! sun that have the same light field, so that what was learnt serves all suns between them. Rays under one half way,
//! from which nothing was learnt, tell whether that is good enough; where it is not, each wavelength is integrated. Up
//! to eight wavelengths are bands themselves.

mod bands;
mod illumination;
mod interpolation;
mod model;

pub use bands::BANDS;
pub use illumination::Regressions;
#[cfg(feature = "files")]
pub(crate) use interpolation::weights_of_bands;
pub use model::FLOOR;

use crate::medium::aerosol::abscissa;
use crate::plan::fit::SpectralFit;
use crate::plan::fit::linear::{Interpolant, LinearFit};
use crate::plan::fit::regression::{Regression, Training, beside_more_bands, spectrum_rows};
use crate::plan::fit::training::{multiples, sorted};
use crate::plan::integral::{Constituent, RayIntegral};
use crate::plan::sky::{SkyPlan, optics_of};
use crate::plan::spectral::bands::{BANDS_BESIDE_LINES, at_bands, bands_beside, beside_own, beside_own_with_lines};
use crate::plan::spectral::illumination::{Illumination, radiance};
use crate::plan::spectral::interpolation::between;
use crate::plan::spectral::model::{SpectralModel, Taught};
use crate::plan::strengths::{LINE_BANDS, has_lines};
use crate::spectra::mean::Window;
use crate::spectra::measured::MEASURED_RANGE;
use crate::spectra::observer;
use sorairo_shared::glam::{Vec3, Vec4};
use sorairo_shared::sky::ByConstituent;
use sorairo_shared::variant;

/// What a spectrum may be off by day, relative to itself or, where it is fainter, to [`FLOOR`] of its peak.
pub const BOUND_BY_DAY: f64 = 0.01;

/// The same in twilight, which varies more from ray to ray.
pub const BOUND_IN_TWILIGHT: f64 = 0.02;

/// Step (nm) between the wavelengths that colour needs where each wavelength is integrated.
const COLOUR_STEP: f64 = 20.0;

/// Wider bands (nm) are integrated in parts: over 20 nm a spectrum bends by 0.2 % at 390 nm, over 50 by 1.3 %.
const WIDEST: f64 = 20.0;

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
pub struct Validation {
    /// The largest error of the regression.
    pub error: f64,
    /// What it may be.
    pub bound: f64,
    /// The same through the lines of gases, where there are any.
    pub of_lines: Option<f64>,
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
    /// How many bands, the last, see what lines of gases leave; see [`LINE_BANDS`].
    line_bands: usize,
    /// The fit through them.
    pub fit: SpectrumFit,
    /// The fit of colours where it goes through bands of its own, which stand behind the others: means, where each
    /// wavelength is integrated and tables are finer than the observer's nodes.
    colour: Option<LinearFit>,
    /// What light at the wavelengths is relative to.
    illumination: Illumination,
    /// How good a regression was found to be; none where nothing had to be learnt, or the scene chose its bands or its
    /// fit.
    pub validation: Option<Validation>,
}

impl SpectralPlan {
    /// That of a sky at wavelengths (nm): through as many bands as they need, or through the scene's own if it names
    /// its bands or another fit. Tables say what holds at each wavelength itself.
    pub fn new(sky: &SkyPlan, wavelengths: &[f64]) -> Self {
        Self::as_read(&sky.at_wavelengths(), wavelengths)
    }

    /// That of a sky at the nodes of the observer, for sums over them: of tables it takes the means over what each node
    /// stands for, and so the sun's lines and what lies between the nodes count.
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
        if others.len() <= BANDS.len() && !has_lines(&sky.base.optics, &asked) {
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
        let has_lines = has_lines(&sky.base.optics, asked);
        let integral = if has_lines {
            beside_own_with_lines(sky, bands_beside(&BANDS_BESIDE_LINES, own, asked))
        } else {
            beside_own(sky, bands_beside(&BANDS, own, asked))
        };
        let model = SpectralModel::of(sky, integral.wavelengths.clone(), asked);
        let bound = if integral.source.elevation < 0.0 { BOUND_IN_TWILIGHT } else { BOUND_BY_DAY };
        let validation = Some(Validation { error: model.error, bound, of_lines: model.error_of_lines });
        // Each wavelength by itself would take one coefficient for its lines.
        if model.error > bound && !has_lines {
            return Self { validation, ..Self::of_each(sky, wavelengths, asked) };
        }
        let at = |(constituent, taught): (Constituent, Taught)| {
            let smooth = between(&integral.optics, constituent, &model.computed, &taught.smooth, wavelengths);
            (constituent, model.through_lines(smooth, &taught.left, wavelengths))
        };
        let fit = SpectrumFit::Regression(model.under(sky.scene.sun.elevation).into_iter().map(at).collect());
        let line_bands = if has_lines { LINE_BANDS.len() } else { 0 };
        Self { line_bands, ..Self::through(wavelengths, integral, fit, validation) }
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

    fn through(wavelengths: &[f64], integral: RayIntegral, fit: SpectrumFit, validation: Option<Validation>) -> Self {
        let illumination = Illumination::new(&integral.optics, wavelengths);
        let points = wavelengths.to_vec();
        Self {
            wavelengths: points.clone(),
            points,
            integral,
            line_bands: 0,
            fit,
            colour: None,
            illumination,
            validation,
        }
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
                let mut of_spectrum = spectrum_rows(optics, &self.wavelengths, regressions);
                if self.integral.variant & variant::PHASE_TABLE != 0 {
                    of_spectrum.extend(self.wavelengths.iter().map(|&nm| Vec4::splat(abscissa(nm) as f32)));
                }
                [colour, of_spectrum]
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

    /// The wavelengths (nm) of bands that see smooth light, which come first.
    pub fn smooth_bands(&self) -> &[f64] {
        let bands = &self.integral.wavelengths;
        &bands[..bands.len() - self.line_bands]
    }

    /// Radiance at each wavelength in a direction (W·m⁻²·sr⁻¹·nm⁻¹); by a polynomial it may lie below zero.
    pub fn radiance(&self, view: Vec3) -> Vec<f64> {
        self.radiance_of_directions(&[view])
    }

    /// The same in many directions, one after the other.
    pub fn radiance_of_directions(&self, views: &[Vec3]) -> Vec<f64> {
        let light = self.integral.light_of_directions(views);
        let of_view = |(&view, light)| self.radiance_of_light(view, light);
        views.iter().zip(light.chunks_exact(self.integral.bands.len())).flat_map(of_view).collect()
    }

    /// The same in a direction, of light at each group of bands.
    pub(crate) fn radiance_of_light(&self, view: Vec3, light: &[ByConstituent<Vec4>]) -> Vec<f64> {
        let integral = &self.integral;
        match &self.fit {
            SpectrumFit::Linear(fit) => {
                let at_bands = integral.at_bands(integral.transfers_of_light(view, light).into_iter());
                let at = |&point: &f64| fit.radiance(&integral.optics, &at_bands, point);
                let radiance: Vec<f64> = self.points.iter().map(at).collect();
                means(&radiance, self.parts()).collect()
            }
            SpectrumFit::Regression(regressions) => {
                let of = |constituent: Constituent| integral.at_bands(light.iter().map(|&group| constituent.of(group)));
                radiance(integral, &self.illumination, regressions, view, of)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::direction;
    use crate::plan::fit::training::known;
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
        assert_eq!(bands_beside(&BANDS, &own, &[360.0, 830.0]), BANDS);
        let fewer = bands_beside(&BANDS, &own, &[400.0, 700.0]);
        assert_eq!(fewer, [400.0, 480.0, 600.0, 665.0, 700.0]);
        assert!(bands_beside(&BANDS, &own, &[432.0, 437.0]).is_empty());
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
        let sky = sky(|scene| {
            *scene = Scene::preset(Preset::Earth);
            scene.sun.elevation = 15.0;
        });
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
            let [rows, _] = plan.rows(&sky);
            let groups = plan.integral.bands.len();
            // Those of colour lie beside those that are asked for.
            let all = RayIntegral { wavelengths: vec![0.0; 4 * groups], ..plan.integral.clone() };
            let transfer = all.transfer(view);
            let channel = |channel: usize| -> f64 {
                let weight = |band: usize| f64::from(rows[3 * (band / 4) + channel][band % 4]);
                (0..groups * 4).map(|band| weight(band) * transfer.get(band).copied().unwrap_or(0.0)).sum()
            };
            Vec3::from_array([0, 1, 2].map(|i| channel(i) as f32))
        };
        let (found, expected) = (of_colour(&each), sky.rgb_towards(view));
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
        let expected = over(GroundAlbedo::Grey(0.2)).rgb_towards(view);
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
