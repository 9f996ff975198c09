//! From the bands to a spectrum and a colour: the host's half of the fit.

use sorairo_shared::color::XYZ_TO_REC709;
use sorairo_shared::glam::{DMat4, DVec4, Vec4};

use crate::tables;

/// The observer's range and step (nm): 81 samples.
pub const OBSERVER_START: f64 = 380.0;
/// See [`OBSERVER_START`].
pub const OBSERVER_END: f64 = 780.0;
/// See [`OBSERVER_START`].
pub const OBSERVER_STEP: f64 = 5.0;

/// Maps the observer's range to [-1, 1]. On wavelengths in nm the Vandermonde matrix has a condition number of 1e10, on
/// these about 10.
pub fn normalised(wavelength: f64) -> f64 {
    (wavelength - (OBSERVER_START + OBSERVER_END) / 2.0) / ((OBSERVER_END - OBSERVER_START) / 2.0)
}

/// Wavelengths of the observer's samples (nm).
pub fn observer_wavelengths() -> impl Iterator<Item = f64> {
    let samples = ((OBSERVER_END - OBSERVER_START) / OBSERVER_STEP).round() as u32;
    (0..=samples).map(|i| OBSERVER_START + OBSERVER_STEP * f64::from(i))
}

/// The rows of the observer sum: (x̄ Δλ, ȳ Δλ, z̄ Δλ, normalised wavelength).
pub fn observer_rows() -> Vec<DVec4> {
    observer_wavelengths()
        .map(|wavelength| {
            let [x, y, z] = tables::cie1931().at(wavelength);
            DVec4::new(x * OBSERVER_STEP, y * OBSERVER_STEP, z * OBSERVER_STEP, normalised(wavelength))
        })
        .collect()
}

/// The cubic through four bands, in double precision.
#[derive(Clone, Debug)]
pub struct CubicFit {
    nodes: DVec4,
    /// Inverse of the Vandermonde matrix of the nodes: values at the bands to monomial coefficients.
    inverse: DMat4,
}

impl CubicFit {
    /// The fit through four distinct wavelengths (nm).
    pub fn new(wavelengths: [f64; 4]) -> Self {
        let nodes = DVec4::from_array(wavelengths.map(normalised));
        let vandermonde = DMat4::from_cols(DVec4::ONE, nodes, nodes * nodes, nodes * nodes * nodes);
        Self { nodes, inverse: vandermonde.inverse() }
    }

    /// The normalised wavelengths of the bands.
    pub fn nodes(&self) -> DVec4 {
        self.nodes
    }

    /// The weight of each band's value in the fitted value at the normalised wavelength `x`: the cardinal functions.
    fn cardinals(&self, x: f64) -> DVec4 {
        self.inverse.transpose() * DVec4::new(1.0, x, x * x, x * x * x)
    }

    /// The fitted spectrum at a wavelength (nm) from its values at the bands.
    pub fn value(&self, values: [f64; 4], wavelength: f64) -> f64 {
        self.cardinals(normalised(wavelength)).dot(DVec4::from_array(values))
    }

    /// Solve, observer sum and XYZ→RGB as one 3×4 matrix on the transfer at the bands: the rows of red, green and blue.
    pub fn folded(&self, observer: &[DVec4], solar_irradiance: [f64; 4]) -> [Vec4; 3] {
        let mut xyz = [DVec4::ZERO; 3];
        for row in observer {
            let cardinals = self.cardinals(row.w);
            for (sum, weight) in xyz.iter_mut().zip([row.x, row.y, row.z]) {
                *sum += cardinals * weight;
            }
        }
        let solar = DVec4::from_array(solar_irradiance);
        XYZ_TO_REC709.map(|row| {
            let [x, y, z] = row.map(f64::from);
            ((xyz[0] * x + xyz[1] * y + xyz[2] * z) * solar).as_vec4()
        })
    }
}
