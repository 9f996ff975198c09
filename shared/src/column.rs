//! Column densities of air, aerosol and ozone, in closed form.
//!
//! A column density is the integral of a constituent's relative density along a ray to the top of the atmosphere, in km. It
//! is colourless: the same number serves every wavelength.
//!
//! # Exponential constituents
//!
//! For a density `e^(-h/H)` on a sphere the column at altitude `h` is `ρ(h) H Ch(r/H, μ)` with Chapman's grazing incidence
//! function (Chapman 1931, <https://doi.org/10.1088/0959-5309/43/1/305>), which has no closed form. With
//!
//! ```text
//! g = √(1 + h/R),   K = κ √(R / 2H),   t = 1 / (1 + K g μ)
//! C(h, μ) = ρ(h) H K g Σᵢ cᵢ tⁱ,   i = 1 ... 8,   κ = 0.45,   cᵢ = aᵢ + bᵢ H/R
//! ```
//!
//! it is a smooth function of `t` alone, to an accuracy that eight terms exhaust. For the Earth and `μ >= 0` the error is 9e-6 of
//! the column at the ground, and 9e-6 in the optical depth of air at 380 nm anywhere; it grows with altitude in units of the planet's
//! radius, to 5e-4 at twenty scale heights for `R/H = 100`, where hardly any air is left. A table looked up
//! bilinearly needs 33 × 129 entries and four loads for the same.
//!
//! # Ozone
//!
//! The tent is a sum of three ramps `max(a - h, 0)`. The integral of one along the ray, up to the shell at altitude
//! `a`, is taken by the quintic Hermite rule on its value and first two derivatives at both ends (error 1e-6 of an optical depth of 1).

use crate::atmosphere::{Atmosphere, Exponential};
use crate::geometry::{altitude_from, distance_to_top, perigee_altitude, zenith_cosine_at_top};
use crate::glam::{Vec2, Vec3, Vec4};
use crate::math::{max, max4, sqrt, sqrt4};
use crate::variant;

/// `κ` of the [module's](self) closed form.
pub const CHAPMAN_SPREAD: f64 = 0.45;

/// `aᵢ` of the [module's](self) closed form: a least-squares fit to Chapman's function, weighted by its relative error, for
/// `R/H` from 100 to infinity.
pub const CHAPMAN_COEFFICIENTS: [f64; 8] = [
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
pub const CHAPMAN_CURVATURE_COEFFICIENTS: [f64; 8] = [
    1.085_023_083,
    -0.309_249_597,
    8.703_815_575,
    -25.836_264_771,
    48.485_178_669,
    -56.958_204_787,
    34.336_085_576,
    -8.033_917_76,
];

/// The column of an exponential constituent per unit of its local density (km), for `mu >= 0`: `H K g Σᵢ cᵢ tⁱ`.
///
/// `g` is `√(1 + h/R)`.
#[inline(always)]
pub fn column_per_density(constituent: &Exponential, g: f32, mu: f32) -> f32 {
    let t = 1.0 / (1.0 + constituent.spread * g * mu);
    let (a, b) = (constituent.low_coefficients, constituent.high_coefficients);
    let high = ((b.w * t + b.z) * t + b.y) * t + b.x;
    let polynomial = (((high * t + a.w) * t + a.z) * t + a.y) * t + a.x;
    constituent.unit * g * t * polynomial
}

/// Column of ozone (km at its peak density) on a rising ray: the tent as a sum of three ramps.
///
/// Each ramp `max(a - h, 0)` is integrated along the ray by the quintic Hermite rule. The three stand in the first lanes of
/// vectors, which a CPU computes together; a GPU's compiler drops the fourth.
#[inline(always)]
fn ozone_column(atmosphere: &Atmosphere, altitude: f32, mu: f32) -> f32 {
    let (bottom, peak, top) = (atmosphere.ozone_bottom, atmosphere.ozone_peak, atmosphere.ozone_top);
    let rise = 1.0 / (peak - bottom);
    let fall = 1.0 / (top - peak);
    let ends = Vec4::new(bottom, peak, top, top);
    let r_end = ends + Vec4::splat(atmosphere.ground_radius);
    let inverse_end = Vec4::ONE / r_end;
    let r = atmosphere.ground_radius + altitude;
    let r_mu = r * mu;
    let height = max4(ends - Vec4::splat(altitude), 0.0);
    let height_squared = height * (r_end + Vec4::splat(r));
    let root = sqrt4(height_squared + Vec4::splat(r_mu * r_mu));
    let length = height_squared / (root + Vec4::splat(r_mu + 1e-30));
    let mu_end = root * inverse_end;
    let curvature = (Vec4::ONE - mu_end * mu_end) * inverse_end + Vec4::splat((1.0 - mu * mu) / r);
    let slope = (mu_end - Vec4::splat(mu)) * 0.1 - length * curvature * (1.0 / 120.0);
    let ramp = length * (height * 0.5 + length * slope);
    max(rise * ramp.x - (rise + fall) * ramp.y + fall * ramp.z, 0.0)
}

/// Column densities (air, aerosol, ozone) in km, from `altitude` (km) outwards along a ray with `mu >= 0`, of an atmosphere
/// without a top. `density` holds the local densities of (air, aerosol); what `variant` leaves out is 0.
#[inline(always)]
pub fn column_outwards(atmosphere: &Atmosphere, altitude: f32, density: Vec2, mu: f32, variant: u32) -> Vec3 {
    let g = sqrt(1.0 + altitude / atmosphere.ground_radius);
    let mut column = Vec3::new(density.x * column_per_density(&atmosphere.air, g, mu), 0.0, 0.0);
    if variant & variant::AEROSOL != 0 {
        column.y = density.y * column_per_density(&atmosphere.aerosol, g, mu);
    }
    if variant & variant::OZONE != 0 {
        column.z = ozone_column(atmosphere, altitude, mu);
    }
    column
}

/// Densities of (air, aerosol) at an altitude (km), relative to the ground.
#[inline(always)]
pub fn densities(atmosphere: &Atmosphere, altitude: f32, variant: u32) -> Vec2 {
    let mut density = Vec2::new(atmosphere.air.density(altitude), 0.0);
    if variant & variant::AEROSOL != 0 {
        density.y = atmosphere.aerosol.density(altitude);
    }
    density
}

/// [`column_outwards`] for the level ray at an altitude (km), the lowest point of a ray that comes down and goes up again.
#[inline]
pub fn level_column(atmosphere: &Atmosphere, altitude: f32, variant: u32) -> Vec3 {
    let density = densities(atmosphere, altitude, variant);
    let g = sqrt(1.0 + altitude / atmosphere.ground_radius);
    let air = density.x * g * atmosphere.air.level_column;
    let aerosol = density.y * g * atmosphere.aerosol.level_column;
    let mut column = Vec3::new(air, aerosol, 0.0);
    if variant & variant::OZONE != 0 {
        column.z = ozone_column(atmosphere, altitude, 0.0);
    }
    column
}

/// The lowest point of a stretch of a ray.
#[derive(Clone, Copy)]
pub struct Lowest {
    /// Its altitude (km).
    pub altitude: f32,
    /// Cosine of the angle between the ray and the vertical there, 0 or more.
    pub mu: f32,
}

/// The columns of air and aerosol (km) over the first `length` km of a ray, where that is shorter than the distance over which
/// they fall off at the ray's lowest point; elsewhere `column`, which is the difference of two columns to infinity.
///
/// Two such columns in an opaque atmosphere have no digits left for a stretch much shorter than themselves. There three nodes of
/// Gauss-Legendre leave 5e-7 of the stretch's own column.
#[inline]
pub fn short_column(
    atmosphere: &Atmosphere,
    altitude: f32,
    mu: f32,
    lowest: Lowest,
    length: f32,
    column: Vec3,
    variant: u32,
) -> Vec3 {
    const OUTER_NODE: f32 = 0.112_701_665;
    let g = sqrt(1.0 + lowest.altitude / atmosphere.ground_radius);
    let shell = atmosphere.shell();
    let density = |s: f32| densities(atmosphere, altitude_from(shell, altitude, mu, s), variant);
    let ends = density(OUTER_NODE * length) + density((1.0 - OUTER_NODE) * length);
    let stretch = (ends * (5.0 / 18.0) + density(0.5 * length) * (8.0 / 18.0)) * length;
    let mut result = column;
    if length < column_per_density(&atmosphere.air, g, lowest.mu) {
        result.x = stretch.x;
    }
    if (variant & variant::AEROSOL != 0) & (length < column_per_density(&atmosphere.aerosol, g, lowest.mu)) {
        result.y = stretch.y;
    }
    result
}

/// Column densities (air, aerosol, ozone) in km from a lit point to the sun, on either side of the point's horizon.
///
/// Below it the ray first descends to its perigee: twice the column that rises from there, less the one behind the point. What the
/// exponential profiles hold above the top of the atmosphere is taken off where it matters.
#[inline(always)]
pub fn sun_column(atmosphere: &Atmosphere, altitude: f32, density: Vec2, mu_s: f32, variant: u32) -> Vec3 {
    let above_horizon = if mu_s < 0.0 { -mu_s } else { mu_s };
    let mut column = column_outwards(atmosphere, altitude, density, above_horizon, variant);
    let mut lowest = Lowest { altitude, mu: above_horizon };
    if (variant & variant::LOW_SUN != 0) & (mu_s < 0.0) {
        lowest = Lowest { altitude: max(perigee_altitude(atmosphere.shell(), altitude, mu_s), 0.0), mu: 0.0 };
        column = level_column(atmosphere, lowest.altitude, variant) * 2.0 - column;
    }
    if variant & variant::ABOVE_TOP != 0 {
        let top = atmosphere.depth;
        let mu = zenith_cosine_at_top(atmosphere.shell(), altitude, mu_s);
        column -= column_outwards(atmosphere, top, densities(atmosphere, top, variant), mu, variant);
        if variant & variant::OPAQUE != 0 {
            let length = distance_to_top(atmosphere.shell(), altitude, mu_s);
            column = short_column(atmosphere, altitude, mu_s, lowest, length, column, variant);
        }
    }
    column.max(Vec3::ZERO)
}
