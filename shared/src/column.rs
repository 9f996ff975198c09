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
//! the column at the ground, and 9e-6 in the optical depth of air at 380 nm anywhere. A table looked up
//! bilinearly needs 33 × 129 entries and four loads for the same.
//!
//! `cᵢ` would be `aᵢ + bᵢ H/r`. Taken at the ground they leave an error that grows with altitude, for `R/H = 100` to 4e-4 of the column at
//! four scale heights. In opaque air that would be seen; there the column is multiplied by
//!
//! ```text
//! 1 - H (1/R - 1/r) (e₀ + e₁ t + e₂ t²)
//! ```
//!
//! which leaves 1.1e-5 at four scale heights and 4e-5 at sixteen.
//!
//! # Ozone
//!
//! The integral over each slope of the tent, from where the ray enters it to the shell at its end, is taken by the quintic Hermite rule on the
//! density and its first two derivatives at both ends (error 8e-6 km for the Earth's tent, whose vertical column is 15 km).

use crate::atmosphere::Atmosphere;
use crate::geometry::{altitude_from, distance_to_top, perigee_altitude, zenith_cosine_at_top};
use crate::glam::{Vec2, Vec3, Vec4};
use crate::math::{abs, exp4, max, max4, min, sqrt, sqrt4};
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

/// `e₀`, `e₁` and `e₂` of the [module's](self) correction for altitude: a fit to `Σᵢ bᵢ tⁱ / Σᵢ aᵢ tⁱ` for `R/H` from 100 to 800.
const CHAPMAN_ALTITUDE_COEFFICIENTS: [f32; 3] = [1.009_65, 0.054_870, -0.717_864];

/// The columns of the exponential constituents per unit of their local densities (km), along two rays from one point with `mu >= 0`:
/// `H K g Σᵢ cᵢ tⁱ`. The lanes are air and aerosol along the first ray, then along the second; what nobody asks for, the compiler drops.
///
/// `g` is `√(1 + h/R)`. Where the air is opaque, the correction for altitude is made; elsewhere nothing of it would be seen.
#[inline(always)]
pub fn columns_per_density(atmosphere: &Atmosphere, g: f32, mu: Vec2, variant: u32) -> Vec4 {
    let (air, aerosol) = (&atmosphere.air, &atmosphere.aerosol);
    let t = Vec4::ONE / (Vec4::ONE + lanes(air.spread, aerosol.spread) * g * Vec4::new(mu.x, mu.x, mu.y, mu.y));
    let (a, b) = (air.low_coefficients, aerosol.low_coefficients);
    let (c, d) = (air.high_coefficients, aerosol.high_coefficients);
    let high = ((lanes(c.w, d.w) * t + lanes(c.z, d.z)) * t + lanes(c.y, d.y)) * t + lanes(c.x, d.x);
    let low = ((high * t + lanes(a.w, b.w)) * t + lanes(a.z, b.z)) * t + lanes(a.y, b.y);
    let column = lanes(air.unit, aerosol.unit) * g * t * (low * t + lanes(a.x, b.x));
    if variant & variant::OPAQUE != 0 { column * altitude_correction(atmosphere, g, t) } else { column }
}

/// Two values, of air and of aerosol or of the two slopes of ozone, for each of two rays.
#[inline(always)]
fn lanes(first: f32, second: f32) -> Vec4 {
    Vec4::new(first, second, first, second)
}

/// The factors of the [module's](self) correction for altitude: `1 - (H/R) (1 - 1/g²) Σᵢ eᵢ tⁱ`.
#[inline(always)]
fn altitude_correction(atmosphere: &Atmosphere, g: f32, t: Vec4) -> Vec4 {
    let [e0, e1, e2] = CHAPMAN_ALTITUDE_COEFFICIENTS;
    let curvature = lanes(atmosphere.air.curvature(), atmosphere.aerosol.curvature());
    Vec4::ONE - curvature * (1.0 - 1.0 / (g * g)) * ((t * e2 + Vec4::splat(e1)) * t + Vec4::splat(e0))
}

/// Columns of ozone (km at its peak density) on two rising rays from one point: the two slopes of the tent, each from where the ray
/// enters it.
///
/// Each is integrated along the ray by the quintic Hermite rule. The lanes of the vectors are the rising and the falling slope along
/// the first ray, then along the second.
#[inline(always)]
fn ozone_columns(atmosphere: &Atmosphere, altitude: f32, mu: Vec2) -> Vec2 {
    let (bottom, peak, top) = (atmosphere.ozone_bottom, atmosphere.ozone_peak, atmosphere.ozone_top);
    let rise = 1.0 / (peak - bottom);
    let fall = 1.0 / (top - peak);
    let r = atmosphere.ground_radius + altitude;
    let exit = lanes(peak, top);
    let entry = lanes(min(max(altitude, bottom), peak), min(max(altitude, peak), top));
    let (r_entry, r_exit) =
        (entry + Vec4::splat(atmosphere.ground_radius), exit + Vec4::splat(atmosphere.ground_radius));
    let (inverse_entry, inverse_exit) = (Vec4::ONE / r_entry, Vec4::ONE / r_exit);
    let r_mu = Vec4::new(mu.x, mu.x, mu.y, mu.y) * r;
    let root_at = |end: Vec4, r_end: Vec4| {
        let height_squared = (end - Vec4::splat(altitude)) * (r_end + Vec4::splat(r));
        sqrt4(max4(height_squared + r_mu * r_mu, 0.0))
    };
    let (root_entry, root_exit) = (root_at(entry, r_entry), root_at(exit, r_exit));
    let (mu_entry, mu_exit) = (root_entry * inverse_entry, root_exit * inverse_exit);
    let curvature = (Vec4::ONE - mu_entry * mu_entry) * inverse_entry + (Vec4::ONE - mu_exit * mu_exit) * inverse_exit;
    let length = (exit - entry) * (r_entry + r_exit) / (root_entry + root_exit + Vec4::splat(1e-30));
    let bend = (mu_entry - mu_exit) * 0.1 + length * curvature * (1.0 / 120.0);
    let mean_density = lanes(0.5 + 0.5 * (entry.x - bottom) * rise, 0.5 * (top - entry.y) * fall);
    let column = length * (mean_density + lanes(rise, -fall) * length * bend);
    Vec2::new(max(column.x + column.y, 0.0), max(column.z + column.w, 0.0))
}

/// Column densities (air, aerosol, ozone) in km along two rays from one point.
#[derive(Clone, Copy)]
pub struct TwoColumns {
    /// Along the first ray.
    pub first: Vec3,
    /// Along the second ray.
    pub second: Vec3,
}

/// Column densities (km) from `altitude` (km) outwards along two rays with cosines `mu >= 0`, of an atmosphere without a top.
/// `density` holds the local densities of (air, aerosol); what `variant` leaves out is 0.
#[inline(always)]
pub fn columns_outwards(atmosphere: &Atmosphere, altitude: f32, density: Vec2, mu: Vec2, variant: u32) -> TwoColumns {
    let g = sqrt(1.0 + altitude * (1.0 / atmosphere.ground_radius));
    let column = lanes(density.x, density.y) * columns_per_density(atmosphere, g, mu, variant);
    let mut columns = TwoColumns { first: Vec3::new(column.x, 0.0, 0.0), second: Vec3::new(column.z, 0.0, 0.0) };
    if variant & variant::AEROSOL != 0 {
        (columns.first.y, columns.second.y) = (column.y, column.w);
    }
    if variant & variant::OZONE != 0 {
        let ozone = ozone_columns(atmosphere, altitude, mu);
        (columns.first.z, columns.second.z) = (ozone.x, ozone.y);
    }
    columns
}

/// [`columns_outwards`] along one ray.
#[inline(always)]
pub fn column_outwards(atmosphere: &Atmosphere, altitude: f32, density: Vec2, mu: f32, variant: u32) -> Vec3 {
    columns_outwards(atmosphere, altitude, density, Vec2::splat(mu), variant).first
}

/// Densities of (air, aerosol) at an altitude (km), relative to the ground.
#[inline(always)]
pub fn densities(atmosphere: &Atmosphere, altitude: f32, variant: u32) -> Vec2 {
    // Divisions of what a ray's samples share: the compiler makes them once.
    let fall_off = Vec4::NEG_ONE / lanes(atmosphere.air.scale_height, atmosphere.aerosol.scale_height);
    let density = exp4(fall_off * altitude);
    Vec2::new(density.x, if variant & variant::AEROSOL != 0 { density.y } else { 0.0 })
}

/// [`column_outwards`] for the level ray at an altitude (km), the lowest point of a ray that comes down and goes up again.
#[inline(always)]
pub fn level_column(atmosphere: &Atmosphere, altitude: f32, variant: u32) -> Vec3 {
    let density = densities(atmosphere, altitude, variant);
    let g = sqrt(1.0 + altitude * (1.0 / atmosphere.ground_radius));
    let mut column =
        Vec3::new(density.x * g * atmosphere.air.level_column, density.y * g * atmosphere.aerosol.level_column, 0.0);
    if variant & variant::OPAQUE != 0 {
        let correction = altitude_correction(atmosphere, g, Vec4::ONE);
        column *= Vec3::new(correction.x, correction.y, 1.0);
    }
    if variant & variant::OZONE != 0 {
        column.z = ozone_columns(atmosphere, altitude, Vec2::ZERO).x;
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
#[inline(always)]
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
    let fall_off = columns_per_density(atmosphere, g, Vec2::splat(lowest.mu), variant);
    let mut result = column;
    if length < fall_off.x {
        result.x = stretch.x;
    }
    if (variant & variant::AEROSOL != 0) & (length < fall_off.y) {
        result.y = stretch.y;
    }
    result
}

/// Column densities (air, aerosol, ozone) in km from a lit point to the sun, on either side of the point's horizon.
///
/// `outwards` are the columns from the point outwards at the cosine `|mu_s|`. Below the horizon the ray first descends to its perigee: twice
/// the column that rises from there, less the one behind the point. What the exponential profiles hold above the top of the atmosphere is
/// taken off where it matters.
#[inline(always)]
pub fn sun_column(atmosphere: &Atmosphere, altitude: f32, outwards: Vec3, mu_s: f32, variant: u32) -> Vec3 {
    let mut column = outwards;
    let mut lowest = Lowest { altitude, mu: abs(mu_s) };
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
