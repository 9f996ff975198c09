//! What the bench measures.

use serde::Serialize;

use crate::document::Machine;
use crate::light_field;
use crate::metrics::Errors;
use crate::timing::{Care, Times};
use sorairo::scene::Fit;

/// Elevations of the sun (degrees) at which run time is measured, for the day and for twilight.
pub(super) const TIMED_AT: [f64; 2] = [30.0, -2.0];

/// The fits, as the chart names them.
pub(super) const FITS: [(Fit, &str); 4] = [
    (Fit::Cubic, "polynomial, radiance (paper)"),
    (Fit::Transfer, "polynomial, transfer"),
    (Fit::Regression, "regression"),
    (Fit::Dense, "no fit"),
];

/// A fit, its wavelengths and its steps.
#[derive(Clone, Debug, Serialize)]
pub struct Configuration {
    /// The fit.
    pub fit: Fit,
    /// Wavelengths (nm).
    pub bands: Vec<f64>,
    /// Samples per piece; `None` for the program's choice by the height of the sun.
    pub steps: Option<u32>,
}

/// An atmosphere that errors are measured in.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Air {
    pub(super) ozone: bool,
    pub(super) aerosol: bool,
}

/// What was measured of a configuration while the sun is up, or in twilight.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// The configuration.
    pub configuration: Configuration,
    /// `day` or `twilight`.
    pub light: &'static str,
    /// Its steps in this light.
    pub steps: u32,
    /// Whether the program would choose it by itself.
    pub default: bool,
    /// Whether no other configuration beats both its time and its error in this light.
    pub unbeaten: bool,
    /// The error in each atmosphere over the suns of this light.
    pub(super) errors: Vec<(Air, Errors)>,
    /// The error over all of them.
    pub all: Errors,
    /// Run time.
    pub times: Times,
}

/// Run time of one way to an image of linear RGB in the CPU's memory.
#[derive(Clone, Debug, Serialize)]
pub struct Way {
    /// Size of the image.
    pub size: String,
    /// What was done where.
    pub way: &'static str,
    /// Its time.
    pub times: Times,
}

/// Everything that the bench measured.
#[derive(Clone, Debug, Serialize)]
pub struct Bench {
    /// Where and when.
    pub machine: Machine,
    /// How often each time was measured.
    pub rounds: usize,
    #[serde(skip)]
    pub(super) care: Care,
    /// Elevations of the sun (degrees) at which run time was measured, by day and in twilight.
    pub timed_at: [f64; 2],
    /// Size of the images of the comparison of fits.
    pub size: String,
    /// The sun's elevations (degrees).
    pub suns: Vec<f64>,
    /// The paths of the data.
    pub ways: Vec<Way>,
    /// The configurations.
    pub configurations: Vec<Measured>,
    /// Light fields of all orders.
    pub light_fields: Vec<light_field::Measured>,
}
