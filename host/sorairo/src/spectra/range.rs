//! The wavelengths of sums over an observer, and those that are known.

use sorairo_shared::fit::observer::OBSERVER_NODES;

/// First wavelength of the observer sum (nm).
pub const START: f64 = 380.0;
/// Last wavelength of the observer sum (nm).
pub const END: f64 = 780.0;
/// Step of the observer sum (nm).
pub const STEP: f64 = (END - START) / (OBSERVER_NODES - 1) as f64;

/// The wavelengths (nm) that the tables of ozone and of the CIE 1931 observer cover.
pub const MEASURED_RANGE: (f64, f64) = (360.0, 830.0);

/// The wavelengths (nm) that the tables of gases and of the sun cover: those of the sun's beam through a measured
/// profile.
pub const RANGE_OF_BEAMS: (f64, f64) = (280.0, 2500.0);
