//! The colour observer: samples of the colour-matching functions over the visible range.

use sorairo_shared::color::XYZ_TO_REC709;
use sorairo_shared::glam::{DMat3, DVec3};

use crate::tables;

/// First wavelength of the observer sum (nm).
pub const START: f64 = 380.0;
/// Last wavelength of the observer sum (nm).
pub const END: f64 = 780.0;
/// Step of the observer sum (nm): 81 samples.
pub const STEP: f64 = 5.0;

/// Wavelengths of the observer's samples (nm).
pub fn wavelengths() -> Vec<f64> {
    let last = ((END - START) / STEP).round() as u32;
    (0..=last).map(|i| START + STEP * f64::from(i)).collect()
}

/// The weights (x̄ Δλ, ȳ Δλ, z̄ Δλ) of the sample at a wavelength (nm), in nm.
pub fn weights(wavelength: f64) -> DVec3 {
    DVec3::from_array(tables::cie1931().at(wavelength)) * STEP
}

/// Maps the observer's range to [-1, 1]. On wavelengths in nm the Vandermonde matrix has a condition number of 1e10, on
/// these about 10.
pub fn normalised(wavelength: f64) -> f64 {
    (wavelength - (START + END) / 2.0) / ((END - START) / 2.0)
}

/// XYZ to linear Rec. 709 RGB; see [`XYZ_TO_REC709`].
pub fn xyz_to_rgb() -> DMat3 {
    let [red, green, blue] = XYZ_TO_REC709.map(|row| DVec3::from_array(row.map(f64::from)));
    DMat3::from_cols(red, green, blue).transpose()
}
