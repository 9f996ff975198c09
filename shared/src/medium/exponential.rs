//! Constituents whose density falls exponentially with altitude, and their column densities in closed form.
//!
//! For a density `e^(-h/H)` on a sphere the column density at altitude `h` is `ρ(h) H Ch(r/H, μ)` with Chapman's
//! grazing incidence function (Chapman 1931, <https://doi.org/10.1088/0959-5309/43/1/305>), which has no closed form.
//! With
//!
//! ```text
//! g = √(1 + h/R),   K = κ √(R / 2H),   t = 1 / (1 + K g μ)
//! C(h, μ) = ρ(h) H K g Σᵢ cᵢ tⁱ,   i = 1 ... 8,   κ = 0.45,   cᵢ = aᵢ + bᵢ H/R
//! ```
//!
//! it is a smooth function of `t` alone, to an accuracy that eight terms exhaust. For the Earth and `μ >= 0` the error
//! is 9e-6 of the column density at the ground, and 9e-6 in the optical depth of air at 380 nm anywhere. A grid looked
//! up bilinearly needs 33 × 129 entries and four loads for the same.
//!
//! `cᵢ` would be `aᵢ + bᵢ H/r`. Taken at the ground they leave an error that grows with altitude, for `R/H = 100` to
//! 4e-4 of the column density at four scale heights. In opaque air that would be seen; there the column density is
//! multiplied by
//!
//! ```text
//! 1 - H (1/R - 1/r) (e₀ + e₁ t + e₂ t²)
//! ```
//!
//! which leaves 1.1e-5 at four scale heights and 4e-5 at sixteen.

use bytemuck::{Pod, Zeroable};

use crate::glam::Vec4;

/// `κ` of the [module's](self) closed form.
const CHAPMAN_SPREAD: f64 = 0.45;

/// `aᵢ` of the [module's](self) closed form: a least-squares fit to Chapman's function, weighted by its relative error,
/// for `R/H` from 100 to infinity.
const CHAPMAN_COEFFICIENTS: [f64; 8] = [
    1.000_012_061,
    0.999_615_471,
    0.899_133_219,
    0.726_897_944,
    0.210_190_767,
    0.749_425_595,
    -0.896_814_234,
    0.250_332_081,
];

/// `bᵢ` of the [module's](self) closed form, from the same fit.
const CHAPMAN_CURVATURE_COEFFICIENTS: [f64; 8] = [
    1.085_023_083,
    -0.309_249_597,
    8.703_815_575,
    -25.836_264_771,
    48.485_178_669,
    -56.958_204_787,
    34.336_085_576,
    -8.033_917_76,
];

/// `e₀`, `e₁` and `e₂` of the [module's](self) correction for altitude: a fit to `Σᵢ bᵢ tⁱ / Σᵢ aᵢ tⁱ` for `R/H` from
/// 100 to 800.
pub(crate) const CHAPMAN_ALTITUDE_COEFFICIENTS: [f32; 3] = [1.009_65, 0.054_870, -0.717_864];

/// A constituent whose density falls exponentially with altitude, and its column densities by the [module's](self)
/// closed form.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Exponential {
    /// Coefficients of `t¹` to `t⁴` in the polynomial of the column density.
    pub low_coefficients: Vec4,
    /// Coefficients of `t⁵` to `t⁸`.
    pub high_coefficients: Vec4,
    /// Scale height `H` (km).
    pub scale_height: f32,
    /// `K = κ √(R / 2H)`: how fast the column density falls with the cosine of the zenith angle.
    pub spread: f32,
    /// `H K` (km), the unit of the column density.
    pub unit: f32,
    /// The column density of a level ray at the ground (km): `H K` times the sum of all coefficients.
    pub level_column_density: f32,
}

impl Exponential {
    /// The constituent with this scale height (km) on a planet with this radius (km): its coefficients `cᵢ`, rounded
    /// once.
    pub fn new(scale_height: f64, ground_radius: f64) -> Self {
        let curvature = scale_height / ground_radius;
        let spread = CHAPMAN_SPREAD * libm::sqrt(0.5 / curvature);
        let c: [f64; 8] =
            core::array::from_fn(|i| CHAPMAN_COEFFICIENTS[i] + CHAPMAN_CURVATURE_COEFFICIENTS[i] * curvature);
        let four = |first: usize| Vec4::from_array(core::array::from_fn(|i| c[first + i] as f32));
        Self {
            low_coefficients: four(0),
            high_coefficients: four(4),
            scale_height: scale_height as f32,
            spread: spread as f32,
            unit: (scale_height * spread) as f32,
            level_column_density: (scale_height * spread * c.iter().sum::<f64>()) as f32,
        }
    }

    /// `H/R`, from the spread.
    #[inline(always)]
    pub fn curvature(&self) -> f32 {
        const SPREAD: f32 = CHAPMAN_SPREAD as f32;
        let ratio = SPREAD / self.spread;
        0.5 * ratio * ratio
    }
}
