//! Fits that are linear in the values at the bands: the paper's cubic, a polynomial through the transfer, and none at
//! all.

use sorairo_shared::glam::{DVec3, Vec4};

use crate::plan::picture::colour_space::ColourSpace;
use crate::scene::ColourObserver;
use crate::spectra::observer;
use crate::spectra::optics::Optics;

/// What a linear fit interpolates with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolant {
    /// The polynomial through all bands.
    Polynomial,
    /// Straight lines from band to band, level beyond the ends.
    Segments,
}

/// A fit whose value at any wavelength is a weighted sum of the values at the bands.
#[derive(Clone, Debug)]
pub struct LinearFit {
    /// Wavelengths of the bands (nm), increasing.
    pub wavelengths: Vec<f64>,
    /// What lies between the bands.
    pub interpolant: Interpolant,
    /// Whether the radiance is fitted, as in the paper, or the transfer, which the sun's spectral lines do not disturb.
    pub of_radiance: bool,
}

impl LinearFit {
    /// The weight of each band's value in the fitted value at a wavelength (nm).
    pub fn cardinals(&self, wavelength: f64) -> Vec<f64> {
        match self.interpolant {
            Interpolant::Polynomial => lagrange(&self.wavelengths, wavelength),
            Interpolant::Segments => hats(&self.wavelengths, wavelength),
        }
    }

    /// The solar irradiance that lights a band's part of the radiance at a wavelength (nm).
    fn irradiance(&self, optics: &Optics, band: usize, wavelength: f64) -> f64 {
        optics.solar_irradiance(if self.of_radiance { self.wavelengths[band] } else { wavelength })
    }

    /// The weight of each band's transfer in the radiance at a wavelength (nm).
    fn radiance_weights(&self, optics: &Optics, wavelength: f64) -> Vec<f64> {
        let weight = |(band, cardinal): (usize, f64)| cardinal * self.irradiance(optics, band, wavelength);
        self.cardinals(wavelength).into_iter().enumerate().map(weight).collect()
    }

    /// Radiance at a wavelength (nm) from the transfer at the bands.
    pub fn radiance(&self, optics: &Optics, transfer: &[f64], wavelength: f64) -> f64 {
        self.radiance_weights(optics, wavelength).into_iter().zip(transfer).map(|(weight, t)| weight * t).sum()
    }

    /// The rows of a spectral image: for each wavelength (nm), the weights of the transfer at each group of four bands
    /// in the radiance there.
    pub fn spectrum_rows(&self, optics: &Optics, wavelengths: &[f64]) -> Vec<Vec4> {
        let rows = |&wavelength: &f64| {
            let weights = self.radiance_weights(optics, wavelength);
            let four =
                |group: &[f64]| Vec4::from_array(std::array::from_fn(|i| group.get(i).copied().unwrap_or(0.0) as f32));
            weights.chunks(4).map(four).collect::<Vec<_>>()
        };
        wavelengths.iter().flat_map(rows).collect()
    }

    /// Solve, observer sum and XYZ→RGB as one matrix on the transfer at the bands: for each group of four bands its
    /// rows of red, green and blue. Bands that only fill the last group weigh nothing.
    pub fn folded(&self, optics: &Optics, observer: ColourObserver, space: &ColourSpace) -> Vec<Vec4> {
        let mut weights = vec![DVec3::ZERO; self.wavelengths.len().next_multiple_of(4)];
        for sample in observer::wavelengths() {
            let rgb = space.from_xyz * observer::weights(observer, sample);
            for (band, cardinal) in self.cardinals(sample).into_iter().enumerate() {
                weights[band] += rgb * (cardinal * self.irradiance(optics, band, sample));
            }
        }
        weights
            .chunks(4)
            .flat_map(|group| {
                [0, 1, 2].map(|channel| Vec4::from_array(std::array::from_fn(|band| group[band][channel] as f32)))
            })
            .collect()
    }

    /// The rows of the observer sum for the explicit solve: (x̄ Δλ, ȳ Δλ, z̄ Δλ, normalised wavelength), times the
    /// solar irradiance if the transfer is fitted.
    pub fn observer_rows(&self, optics: &Optics, observer: ColourObserver) -> Vec<Vec4> {
        let row = |wavelength: f64| {
            let irradiance = if self.of_radiance { 1.0 } else { optics.solar_irradiance(wavelength) };
            (observer::weights(observer, wavelength) * irradiance).extend(observer::normalised(wavelength)).as_vec4()
        };
        observer::wavelengths().into_iter().map(row).collect()
    }
}

/// The cardinal polynomials of Lagrange at `x`: the inverse of the Vandermonde matrix, transposed, times the powers of
/// `x`.
fn lagrange(nodes: &[f64], x: f64) -> Vec<f64> {
    let factor = |i: usize, j: usize| if i == j { 1.0 } else { (x - nodes[j]) / (nodes[i] - nodes[j]) };
    (0..nodes.len()).map(|i| (0..nodes.len()).map(|j| factor(i, j)).product()).collect()
}

/// The hat functions of increasing nodes at `x`.
pub fn hats(nodes: &[f64], x: f64) -> Vec<f64> {
    let mut weights = vec![0.0; nodes.len()];
    let above = nodes.partition_point(|&node| node <= x);
    if above == 0 {
        weights[0] = 1.0;
    } else if above == nodes.len() {
        weights[above - 1] = 1.0;
    } else {
        let t = (x - nodes[above - 1]) / (nodes[above] - nodes[above - 1]);
        weights[above - 1] = 1.0 - t;
        weights[above] = t;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cardinals_reproduce_what_they_interpolate() {
        let cubic = |x: f64| 2.0 + x * (0.01 + x * (-3e-5 + x * 2e-8));
        let line = |x: f64| 3.0 - 0.002 * x;
        for (interpolant, function) in
            [(Interpolant::Polynomial, &cubic as &dyn Fn(f64) -> f64), (Interpolant::Segments, &line)]
        {
            let fit = LinearFit { wavelengths: vec![430.0, 520.0, 610.0, 700.0], interpolant, of_radiance: false };
            for x in [430.0, 470.0, 555.0, 700.0] {
                let value: f64 = fit.cardinals(x).iter().zip(&fit.wavelengths).map(|(c, &w)| c * function(w)).sum();
                assert!((value / function(x) - 1.0).abs() < 1e-12, "{interpolant:?} at {x}");
            }
        }
    }
}
