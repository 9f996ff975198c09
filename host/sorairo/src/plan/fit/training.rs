//! The spectra on which a regression fit is made: light along some hundred rays of the sky's own, by its constituents.
//!
//! Light at many wavelengths costs little more than at a few if what a ray crosses is computed once for all of them;
//! see [`sorairo_shared::light_field`]. Of light that was scattered before more than [`TOGETHER`] are not: between
//! every 10 nm it follows from optical depths and albedo, whose spectra are known.

use nalgebra::{Matrix2, Vector2};
use sorairo_shared::medium::bands::Bands;
use sorairo_shared::sky::ByConstituent;

use crate::plan::fit::light::{rest, scattered_once};
use crate::plan::fit::rays::{training_rows, training_views};
use crate::plan::integral::{Constituent, RayIntegral};
use crate::plan::light_field::{Resolution, TOGETHER};
use crate::plan::rays::quadrature::gauss_legendre;
use crate::plan::strengths::{AtStrengths, FIRST_LINE, Strengths, bands_through};
use crate::plan::upload::bands;
use crate::spectra::optics::{Coefficients, Optics};

/// The smallest integral whose logarithm is taken, as in the kernels.
pub const DARKEST: f64 = sorairo_shared::fit::spectrum::DARKEST as f64;

/// Step (nm) between the wavelengths that are computed where more are asked for than are computed together.
const STEP: f64 = 10.0;

/// Where it doubles (nm) in light without lines, so that this and light through them are computed together.
const TWICE_THE_STEP: f64 = 560.0;

/// Samples on a piece of a training ray, at least, of an image that has as many: what a smooth integrand takes.
const FEWEST_SAMPLES: u32 = 12;

/// What scatters light towards the observer as one of its constituents (km⁻¹), or 1 for the ground's.
pub fn scattering_of(constituent: Constituent, coefficients: Coefficients) -> f64 {
    match constituent {
        Constituent::Air | Constituent::Multiple => coefficients.air_scattering,
        Constituent::Aerosol => coefficients.aerosol_scattering,
        Constituent::Ground => 1.0,
    }
}

/// Spectra of every constituent along the training rays at wavelengths (nm), the first of which are the integral's
/// bands: these have one coefficient for the lines of gases, as in the integral, and the others what lines leave. Of
/// what a sky does not have there are none.
pub fn training_spectra(integral: &RayIntegral, wavelengths: &[f64]) -> ByConstituent<Vec<Vec<f64>>> {
    // Only ratios between wavelengths are learnt: a quarter of the samples, and a coarse light field, will do.
    let samples = integral.quadrature.len() as u32;
    let quadrature = gauss_legendre((samples / 4).max(FEWEST_SAMPLES).min(samples));
    let lines = OfLines::new(integral, wavelengths);
    let at = lines.beside(&integral.optics, wavelengths);
    let views = training_views(integral);
    let (air, aerosol) = scattered_once(integral, &quadrature, &views, (&at.0, at.1));
    let between = Between::new(&integral.wavelengths, wavelengths, lines.strengths.is_some());
    let coarse = Resolution::for_training(&integral.setting(), integral.aerosol_depth());
    let at = lines.beside(&integral.optics, &between.computed);
    let (multiple, mut ground) = rest(integral, (&at.0, at.1), &training_rows(integral), &coarse);
    ground.retain(|spectrum| spectrum.iter().any(|&value| value != 0.0));
    let absorbed = |&nm: &f64| lines.absorbed(&integral.optics, nm);
    let absorbed = [&between.computed[..], wavelengths].map(|at| at.iter().map(absorbed).collect::<Vec<Absorbed>>());
    let at_all = |mut spectra: Vec<Vec<f64>>, constituent| {
        without_undershoots(&mut spectra);
        let known = |&wavelength: &f64| known(&integral.optics, constituent, wavelength);
        let known = [&between.computed[..], wavelengths].map(|at| at.iter().map(known).collect::<Vec<f64>>());
        let at_all = |spectrum: &Vec<f64>| {
            let (computed, beside) = spectrum.split_at(between.computed.len());
            lines.seen(between.at_all(computed, &known, &absorbed), beside)
        };
        spectra.iter().map(at_all).collect()
    };
    let (multiple, ground) = (at_all(multiple, Constituent::Multiple), at_all(ground, Constituent::Ground));
    let at_once = |spectra: Vec<Vec<f64>>| {
        let seen = |mut spectrum: Vec<f64>| {
            let beside = spectrum.split_off(wavelengths.len());
            lines.seen(spectrum, &beside)
        };
        spectra.into_iter().map(seen).collect()
    };
    ByConstituent { air: at_once(air), aerosol: at_once(aerosol), multiple, ground }
}

/// What the lines of gases do to spectra; nothing in air without gases.
struct OfLines {
    strengths: Option<Strengths>,
    /// The integral's bands with their coefficients.
    bands: Vec<AtStrengths>,
}

impl OfLines {
    fn new(integral: &RayIntegral, wavelengths: &[f64]) -> Self {
        let strengths = Strengths::of_colours(&integral.optics, wavelengths);
        let band = |&nm: &f64| {
            let at = integral.optics.at(nm);
            (nm, [at.pair_absorption, at.water_absorption])
        };
        let bands = if strengths.is_some() { integral.wavelengths.iter().map(band).collect() } else { Vec::new() };
        Self { strengths, bands }
    }

    /// Groups of wavelengths (nm) without lines, beside which there is light at the strengths of lines and at the
    /// bands, and how many there are of all.
    fn beside(&self, optics: &Optics, wavelengths: &[f64]) -> (Vec<Bands>, usize) {
        let Some(strengths) = &self.strengths else { return (bands(optics, wavelengths), wavelengths.len()) };
        let all = [strengths.behind(wavelengths), self.bands.clone()].concat();
        (bands_through(optics, &all), all.len())
    }

    /// What gases absorb at a wavelength (nm) beside lines.
    fn absorbed(&self, optics: &Optics, nm: f64) -> Absorbed {
        let at = optics.at(nm);
        let smooth = if nm < FIRST_LINE { at.pair_absorption } else { 0.0 };
        Absorbed::new(at.ozone_absorption, smooth)
    }

    /// A spectrum through the lines, the bands first, of one without them and of light at the strengths and at the
    /// bands.
    fn seen(&self, spectrum: Vec<f64>, beside: &[f64]) -> Vec<f64> {
        let Some(strengths) = &self.strengths else { return spectrum };
        let (at_strengths, at_bands) = beside.split_at(beside.len() - self.bands.len());
        let mut spectrum = strengths.through([&spectrum, at_strengths].concat());
        spectrum[..at_bands.len()].copy_from_slice(at_bands);
        spectrum
    }
}

/// What stands for light below zero, relative to the brightest of its spectrum: about what twilight has at 380 nm.
const UNDERSHOOT: f64 = 0.01;

/// Where no direct light is left cubics between the nodes of a light field pass below zero at the shortest wavelengths.
/// Their logarithms would be those of darkness, and a fit would learn from them how dark may turn into bright. So such
/// rays are left out or, where most are like that, filled.
fn without_undershoots(spectra: &mut Vec<Vec<f64>>) {
    let is_whole = |spectrum: &Vec<f64>| spectrum.iter().all(|&value| value >= 0.0);
    if 2 * spectra.iter().filter(|spectrum| is_whole(spectrum)).count() >= spectra.len() {
        return spectra.retain(is_whole);
    }
    for spectrum in spectra {
        let brightest = spectrum.iter().copied().fold(0.0, f64::max);
        spectrum.iter_mut().filter(|value| **value < 0.0).for_each(|value| *value = UNDERSHOOT * brightest);
    }
}

/// What ozone and pairs of oxygen absorb.
type Absorbed = Vector2<f64>;

/// Wavelengths between others at which light is computed.
struct Between {
    /// Those at which it is, increasing.
    computed: Vec<f64>,
    /// Where each wavelength lies among them.
    places: Vec<Place>,
}

impl Between {
    /// The bands are always computed themselves; with lines these lie beside those without them.
    fn new(bands: &[f64], wavelengths: &[f64], has_lines: bool) -> Self {
        let computed = match wavelengths.len() > TOGETHER {
            true if has_lines => every_step(&[], wavelengths, TWICE_THE_STEP),
            true => every_step(bands, wavelengths, f64::INFINITY),
            false => wavelengths.to_vec(),
        };
        let place = |(i, &wavelength): (usize, &f64)| {
            if wavelengths.len() <= TOGETHER { Place { below: i, part: 0.0 } } else { Place::of(wavelength, &computed) }
        };
        let places = wavelengths.iter().enumerate().map(place).collect();
        Self { computed, places }
    }

    /// A spectrum at all wavelengths: the logarithm of what is not known of it, at those computed and at all, goes with
    /// the optical depths. What gases absorb, which bends between those computed, is known but for the columns that the
    /// light has crossed.
    fn at_all(
        &self,
        computed: &[f64],
        [known, all]: &[Vec<f64>; 2],
        [absorption, absorption_at_all]: &[Vec<Absorbed>; 2],
    ) -> Vec<f64> {
        let rest: Vec<f64> =
            computed.iter().zip(known).map(|(value, known)| (value.max(DARKEST) / known).ln()).collect();
        let columns = self.columns_in(&rest, absorption);
        let without_gases = |i: usize| rest[i] + columns.dot(&absorption[i]);
        let value = |((&Place { below, part }, known), absorption): ((&Place, &f64), &Absorbed)| match part {
            0.0 => computed[below],
            _ => {
                let (low, high) = (without_gases(below), without_gases(below + 1));
                known * (low + part * (high - low) - columns.dot(absorption)).exp()
            }
        };
        self.places.iter().zip(all).zip(absorption_at_all).map(value).collect()
    }

    /// The columns of gases that bend the logarithm of a spectrum as it does, by least squares over the computed
    /// wavelengths.
    fn columns_in(&self, logarithms: &[f64], absorption: &[Absorbed]) -> Absorbed {
        let (mut square, mut along) = (Matrix2::zeros(), Absorbed::zeros());
        for i in 1..self.computed.len().max(1) - 1 {
            let Place { part, .. } = Place::of(self.computed[i], &[self.computed[i - 1], self.computed[i + 1]]);
            let bend = absorption[i] - (absorption[i - 1] * (1.0 - part) + absorption[i + 1] * part);
            let bend_of_light = logarithms[i] - (logarithms[i - 1] * (1.0 - part) + logarithms[i + 1] * part);
            square += bend * bend.transpose();
            along -= bend * bend_of_light;
        }
        // A gas that is not there has no column.
        for gas in 0..2 {
            square[(gas, gas)] += if square[(gas, gas)] == 0.0 { 1.0 } else { 0.0 };
        }
        square.cholesky().map_or(Absorbed::zeros(), |square| square.solve(&along)).map(|column| column.max(0.0))
    }
}

/// A wavelength between two others, at which light is computed.
pub struct Place {
    /// Which of those that are computed lies below it.
    pub below: usize,
    /// How much the one above it weighs.
    pub part: f64,
}

impl Place {
    /// That of a wavelength among others (nm, increasing, two at least).
    pub fn of(wavelength: f64, computed: &[f64]) -> Self {
        // Optical depths of air are linear in this.
        let power = |nm: f64| (1000.0 / nm).powi(4);
        let below = computed.partition_point(|&nm| nm <= wavelength).clamp(1, computed.len() - 1) - 1;
        let (low, high) = (power(computed[below]), power(computed[below + 1]));
        Self { below, part: (power(wavelength) - low) / (high - low) }
    }
}

/// What is known of a constituent's spectrum: what scatters there and, of light that was scattered before, that about
/// as much comes from the ground as its albedo.
pub fn known(optics: &Optics, constituent: Constituent, wavelength: f64) -> f64 {
    let scattering = scattering_of(constituent, optics.at(wavelength)).max(DARKEST);
    let from_ground = if constituent == Constituent::Multiple { optics.ground_albedo.at(wavelength) } else { 0.0 };
    scattering * (1.0 + from_ground)
}

/// The bands, the ends of some wavelengths (nm), beyond which spectra may not be known, and multiples of a step between
/// them, from some wavelength on of twice the step.
fn every_step(bands: &[f64], wavelengths: &[f64], twice: f64) -> Vec<f64> {
    let first = wavelengths.iter().copied().fold(f64::MAX, f64::min);
    let last = wavelengths.iter().copied().fold(0.0, f64::max);
    let coarse = multiples(2.0 * STEP, twice.max(first).min(last), last);
    let all = multiples(STEP, first, last.min(twice)).chain(coarse);
    sorted(all.chain([first, last]).chain(bands.iter().copied()))
}

/// The multiples of a step (nm) between two wavelengths.
pub fn multiples(step: f64, first: f64, last: f64) -> impl Iterator<Item = f64> {
    ((first / step).ceil() as u32..=(last / step).floor() as u32).map(move |i| step * f64::from(i))
}

/// Wavelengths (nm) in order, each once.
pub fn sorted(wavelengths: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut wavelengths: Vec<f64> = wavelengths.collect();
    wavelengths.sort_by(f64::total_cmp);
    wavelengths.dedup();
    wavelengths
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::SkyPlan;
    use crate::scene::{Preset, Rgb, Scene};
    use crate::spectra::observer;

    #[test]
    fn light_between_the_computed_wavelengths_follows_from_the_optical_depths() {
        for sun in [50.0, 2.0, -4.0] {
            let mut scene = Scene::preset(Preset::Standard);
            scene.sun.elevation = sun;
            let sky = SkyPlan::new(&scene.validated().unwrap(), Rgb::Srgb);
            let wavelengths = [&sky.integral().wavelengths[..], &observer::wavelengths()].concat();
            let thinned = training_spectra(sky.integral(), &wavelengths);
            // The bands and 380 to 595 nm, all of which are computed together.
            let computed = training_spectra(sky.integral(), &wavelengths[..TOGETHER]);
            for constituent in [Constituent::Multiple, Constituent::Ground] {
                let (found, expected) = (constituent.of(thinned.clone()), constituent.of(computed.clone()));
                let brightest = found.iter().map(|ray| ray[40]).fold(0.0, f64::max);
                let lit = found.iter().zip(&expected).filter(|(found, _)| found[40] > 1e-3 * brightest);
                let errors = lit.flat_map(|(found, expected)| found.iter().zip(expected));
                let worst = errors.map(|(found, expected)| (found / expected - 1.0).abs()).fold(0.0, f64::max);
                println!("sun at {sun}, {constituent:?}: {worst:.1e}");
                // Of such errors, which change sign from ray to ray and from wavelength to wavelength, a regression
                // keeps a part. Half of them is that in twilight light has crossed more ozone where it absorbs less.
                assert!(worst > 0.0 && worst < 5e-2, "sun at {sun}, {constituent:?}: {worst:e}");
            }
        }
    }
}
