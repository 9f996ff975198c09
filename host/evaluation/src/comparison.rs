//! A measured radiance beside a computed one.

use serde::Serialize;

/// Width of a measured band (nm).
pub(super) const WIDTH: f64 = 11.75;

/// What one band of one direction is.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// The scan, by its local time.
    pub scan: String,
    /// Elevation of the direction (degrees).
    pub elevation: f64,
    /// Azimuth of the direction (degrees).
    pub azimuth: f64,
    /// Angle from the sun (degrees).
    pub from_sun: f64,
    /// Middle of the band (nm).
    pub wavelength: f64,
    /// Measured radiance (W·m⁻²·sr⁻¹·nm⁻¹).
    pub measured: f64,
    /// Ours.
    pub ours: f64,
}
