//! What falls from the sun's disc.

use sorairo_shared::glam::DVec3;

/// What falls from the disc.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SunIrradiance {
    /// On a surface that faces it: power between 380 and 780 nm (W·m⁻²).
    pub facing: f64,
    /// On a level surface likewise.
    pub level: f64,
    /// On a surface that faces it: linear RGB (W·m⁻²).
    pub rgb: DVec3,
}
