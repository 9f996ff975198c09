//! Regressions between the wavelengths at which they were computed.

use crate::plan::fit::linear::hats;
use crate::plan::fit::regression::Regression;
use crate::plan::fit::training::{Place, known, sorted};
use crate::plan::integral::Constituent;
use crate::spectra::optics::Optics;

/// Where each of some wavelengths (nm) stands among others.
pub(crate) fn places(wavelengths: &[f64], all: &[f64]) -> Vec<usize> {
    wavelengths.iter().map(|nm| all.partition_point(|other| other < nm)).collect()
}

/// A regression to which the bands' own regressions add what they miss of the bands, by the weights of straight lines
/// between them. The bands are right then, and what rays have that no other taught, such as what a lookup leaves, goes
/// along.
pub(crate) fn right_at_bands(regression: &Regression, at_bands: &[&Regression], weights: &[f64]) -> Regression {
    let missed = |of: &dyn Fn(&Regression) -> f64| -> f64 {
        at_bands.iter().zip(weights).map(|(at_band, weight)| weight * of(at_band)).sum()
    };
    let slope = |(band, slope): (usize, &f64)| slope + weights[band] - missed(&|at_band| at_band.slopes[band]);
    Regression {
        intercept: regression.intercept - missed(&|at_band| at_band.intercept),
        slopes: regression.slopes.iter().enumerate().map(slope).collect(),
    }
}

/// The weights of bands (nm, in any order) on the straight lines between them, level beyond their ends, at a wavelength
/// (nm).
pub(crate) fn lines(bands: &[f64], wavelength: f64) -> Vec<f64> {
    let increasing = sorted(bands.iter().copied());
    let weights = hats(&increasing, wavelength);
    places(bands, &increasing).into_iter().map(|place| weights[place]).collect()
}

/// The bands of [`lines`] that count at a wavelength (nm), with their weights.
#[cfg(feature = "files")]
pub(crate) fn weights_of_bands(bands: &[f64], wavelength: f64) -> Vec<(usize, f64)> {
    lines(bands, wavelength).into_iter().enumerate().filter(|(_, weight)| *weight != 0.0).collect()
}

/// The regressions of a constituent at wavelengths (nm) between those at which they were computed. What of a spectrum's
/// logarithm is not known goes with the optical depths, and a regression is linear in what it is made of.
pub(crate) fn between(
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
