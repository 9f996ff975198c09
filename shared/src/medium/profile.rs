//! Densities of air, aerosol and ozone, and their column densities in closed form.
//!
//! A column density is the integral of a constituent's relative density along a ray to the top of the atmosphere, in km. It
//! is colourless: the same number serves every wavelength.
//!
//! # Exponential constituents
//!
//! For a density `e^(-h/H)` on a sphere the column density at altitude `h` is `ρ(h) H Ch(r/H, μ)` with Chapman's grazing incidence
//! function (Chapman 1931, <https://doi.org/10.1088/0959-5309/43/1/305>), which has no closed form. With
//!
//! ```text
//! g = √(1 + h/R),   K = κ √(R / 2H),   t = 1 / (1 + K g μ)
//! C(h, μ) = ρ(h) H K g Σᵢ cᵢ tⁱ,   i = 1 ... 8,   κ = 0.45,   cᵢ = aᵢ + bᵢ H/R
//! ```
//!
//! it is a smooth function of `t` alone, to an accuracy that eight terms exhaust. For the Earth and `μ >= 0` the error is 9e-6 of
//! the column density at the ground, and 9e-6 in the optical depth of air at 380 nm anywhere. A grid looked up
//! bilinearly needs 33 × 129 entries and four loads for the same.
//!
//! `cᵢ` would be `aᵢ + bᵢ H/r`. Taken at the ground they leave an error that grows with altitude, for `R/H = 100` to 4e-4 of the column density at
//! four scale heights. In opaque air that would be seen; there the column density is multiplied by
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
//! density and its first two derivatives at both ends (error 8e-6 km for the Earth's tent, whose vertical column density is 15 km).

use bytemuck::{Pod, Zeroable};

use crate::geometry::{Shell, altitude_from, distance_to_top, perigee_altitude, zenith_cosine_at_top};
use crate::glam::{Vec2, Vec3, Vec4};
use crate::math::{abs, exp4, max, max4, min, sqrt, sqrt4};
use crate::variant;

/// `κ` of the [module's](self) closed form.
const CHAPMAN_SPREAD: f64 = 0.45;

/// `aᵢ` of the [module's](self) closed form: a least-squares fit to Chapman's function, weighted by its relative error, for
/// `R/H` from 100 to infinity.
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

/// `e₀`, `e₁` and `e₂` of the [module's](self) correction for altitude: a fit to `Σᵢ bᵢ tⁱ / Σᵢ aᵢ tⁱ` for `R/H` from 100 to 800.
const CHAPMAN_ALTITUDE_COEFFICIENTS: [f32; 3] = [1.009_65, 0.054_870, -0.717_864];

/// How the planet and the constituents of its atmosphere are laid out. The layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Atmosphere {
    /// Air.
    pub air: Exponential,
    /// Aerosol.
    pub aerosol: Exponential,
    /// Radius of the ground sphere (km).
    pub ground_radius: f32,
    /// Height of the top of the atmosphere above the ground (km).
    pub depth: f32,
    /// Asymmetry `g` of the aerosol's phase function, in (-1, 1).
    pub aerosol_asymmetry: f32,
    /// Altitude at which the ozone layer begins (km).
    pub ozone_bottom: f32,
    /// Altitude at which ozone is densest (km).
    pub ozone_peak: f32,
    /// Altitude at which the ozone layer ends (km).
    pub ozone_top: f32,
    /// Anisotropy of the phase function of air; see [`crate::medium::phase::air_phase`].
    pub air_anisotropy: f32,
    /// Unused; fills the last 16 bytes.
    pub padding: u32,
}

/// A constituent whose density falls exponentially with altitude, and its column densities by the [module's](self) closed form.
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

/// Column densities of (air, aerosol, ozone) along one path (km).
pub type ColumnDensities = Vec3;

/// Column densities along two rays from one point.
#[derive(Clone, Copy)]
pub struct TwoRays {
    /// Along the first ray (km).
    pub first: ColumnDensities,
    /// Along the second ray (km).
    pub second: ColumnDensities,
}

impl Atmosphere {
    /// The two spheres between which the atmosphere lies.
    #[inline(always)]
    pub fn shell(&self) -> Shell {
        Shell { ground_radius: self.ground_radius, depth: self.depth }
    }
}

impl Exponential {
    /// The constituent with this scale height (km) on a planet with this radius (km): its coefficients `cᵢ`, rounded once.
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

/// Relative densities of (air, aerosol) at an altitude (km); aerosol is 0 where `variant` leaves it out.
#[inline(always)]
pub fn relative_densities(atmosphere: &Atmosphere, altitude: f32, variant: u32) -> Vec2 {
    // Divisions of what a ray's samples share: the compiler makes them once.
    let fall_off = Vec4::NEG_ONE / lanes(atmosphere.air.scale_height, atmosphere.aerosol.scale_height);
    let density = exp4(fall_off * altitude);
    Vec2::new(density.x, if variant & variant::AEROSOL != 0 { density.y } else { 0.0 })
}

/// Density of ozone relative to its peak: a tent over bottom, peak and top (Bruneton 2017, "Ozone").
///
/// `altitude` in km; from 0 to 1.
#[inline]
pub fn ozone_density(atmosphere: &Atmosphere, altitude: f32) -> f32 {
    let rising = (altitude - atmosphere.ozone_bottom) / (atmosphere.ozone_peak - atmosphere.ozone_bottom);
    let falling = (atmosphere.ozone_top - altitude) / (atmosphere.ozone_top - atmosphere.ozone_peak);
    max(min(rising, falling), 0.0)
}

/// Equivalent lengths of air and aerosol (km), along two rays from one point with `mu >= 0`: column densities per local density,
/// `H K g Σᵢ cᵢ tⁱ`. Over such a length a constituent falls off. The lanes are air and aerosol along the first ray, then along the second; what nobody asks for, the compiler drops.
///
/// `g` is `√(1 + h/R)`. Where the air is opaque, the correction for altitude is made; elsewhere nothing of it would be seen.
#[inline(always)]
pub fn equivalent_lengths(atmosphere: &Atmosphere, g: f32, mu: Vec2, variant: u32) -> Vec4 {
    let (air, aerosol) = (&atmosphere.air, &atmosphere.aerosol);
    let t = Vec4::ONE / (Vec4::ONE + lanes(air.spread, aerosol.spread) * g * Vec4::new(mu.x, mu.x, mu.y, mu.y));
    let (a, b) = (air.low_coefficients, aerosol.low_coefficients);
    let (c, d) = (air.high_coefficients, aerosol.high_coefficients);
    let high = ((lanes(c.w, d.w) * t + lanes(c.z, d.z)) * t + lanes(c.y, d.y)) * t + lanes(c.x, d.x);
    let low = ((high * t + lanes(a.w, b.w)) * t + lanes(a.z, b.z)) * t + lanes(a.y, b.y);
    let length = lanes(air.unit, aerosol.unit) * g * t * (low * t + lanes(a.x, b.x));
    if variant & variant::OPAQUE != 0 { length * altitude_correction(atmosphere, g, t) } else { length }
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

/// Column densities of ozone (km at its peak density) along two rising rays from one point: the two slopes of the tent, each from where the ray
/// enters it.
///
/// Each is integrated along the ray by the quintic Hermite rule. The lanes of the vectors are the rising and the falling slope along
/// the first ray, then along the second.
#[inline(always)]
fn ozone_column_densities(atmosphere: &Atmosphere, altitude: f32, mu: Vec2) -> Vec2 {
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
    let slopes = length * (mean_density + lanes(rise, -fall) * length * bend);
    Vec2::new(max(slopes.x + slopes.y, 0.0), max(slopes.z + slopes.w, 0.0))
}

/// Column densities (km) from `altitude` (km) outwards along two rays with cosines `mu >= 0`, of an atmosphere without a top.
/// `density` holds the relative densities of (air, aerosol) there; what `variant` leaves out is 0.
#[inline(always)]
pub fn column_densities_of_two(
    atmosphere: &Atmosphere,
    altitude: f32,
    density: Vec2,
    mu: Vec2,
    variant: u32,
) -> TwoRays {
    let g = sqrt(1.0 + altitude * (1.0 / atmosphere.ground_radius));
    let exponential = lanes(density.x, density.y) * equivalent_lengths(atmosphere, g, mu, variant);
    let mut first = Vec3::new(exponential.x, 0.0, 0.0);
    let mut second = Vec3::new(exponential.z, 0.0, 0.0);
    if variant & variant::AEROSOL != 0 {
        (first.y, second.y) = (exponential.y, exponential.w);
    }
    if variant & variant::OZONE != 0 {
        let ozone = ozone_column_densities(atmosphere, altitude, mu);
        (first.z, second.z) = (ozone.x, ozone.y);
    }
    TwoRays { first, second }
}

/// Column densities (km) from `altitude` (km) outwards along a ray with a cosine `mu >= 0`; see [`column_densities_of_two`].
#[inline(always)]
pub fn column_densities(
    atmosphere: &Atmosphere,
    altitude: f32,
    density: Vec2,
    mu: f32,
    variant: u32,
) -> ColumnDensities {
    column_densities_of_two(atmosphere, altitude, density, Vec2::splat(mu), variant).first
}

/// [`column_densities`] along the level ray at an altitude (km), the lowest point of a ray that comes down and goes up again.
#[inline(always)]
pub fn level_column_densities(atmosphere: &Atmosphere, altitude: f32, variant: u32) -> ColumnDensities {
    let density = relative_densities(atmosphere, altitude, variant);
    let g = sqrt(1.0 + altitude * (1.0 / atmosphere.ground_radius));
    let air = density.x * g * atmosphere.air.level_column_density;
    let aerosol = density.y * g * atmosphere.aerosol.level_column_density;
    let mut outwards = Vec3::new(air, aerosol, 0.0);
    if variant & variant::OPAQUE != 0 {
        let correction = altitude_correction(atmosphere, g, Vec4::ONE);
        outwards *= Vec3::new(correction.x, correction.y, 1.0);
    }
    if variant & variant::OZONE != 0 {
        outwards.z = ozone_column_densities(atmosphere, altitude, Vec2::ZERO).x;
    }
    outwards
}

/// The lowest point of a stretch of a ray.
#[derive(Clone, Copy)]
pub struct LowestPoint {
    /// Its altitude (km).
    pub altitude: f32,
    /// Cosine of the angle between the ray and the vertical there, 0 or more.
    pub mu: f32,
}

/// Column densities over the first `length` km of a ray: those of air and aerosol summed where that is shorter than the length over which
/// they fall off at the ray's lowest point; elsewhere `difference`, which is of two column densities to infinity (km).
///
/// Two such column densities in an opaque atmosphere have no digits left for a stretch much shorter than themselves. There three nodes of
/// Gauss-Legendre leave 5e-7 of the stretch's own column density.
#[inline(always)]
pub fn stretch_column_densities(
    atmosphere: &Atmosphere,
    altitude: f32,
    mu: f32,
    lowest: LowestPoint,
    length: f32,
    difference: ColumnDensities,
    variant: u32,
) -> ColumnDensities {
    const OUTER_NODE: f32 = 0.112_701_665;
    let g = sqrt(1.0 + lowest.altitude / atmosphere.ground_radius);
    let shell = atmosphere.shell();
    let density = |s: f32| relative_densities(atmosphere, altitude_from(shell, altitude, mu, s), variant);
    let ends = density(OUTER_NODE * length) + density((1.0 - OUTER_NODE) * length);
    let stretch = (ends * (5.0 / 18.0) + density(0.5 * length) * (8.0 / 18.0)) * length;
    let fall_off = equivalent_lengths(atmosphere, g, Vec2::splat(lowest.mu), variant);
    let mut result = difference;
    if length < fall_off.x {
        result.x = stretch.x;
    }
    if (variant & variant::AEROSOL != 0) & (length < fall_off.y) {
        result.y = stretch.y;
    }
    result
}

/// Column densities (km) from a lit point to the sun, on either side of the point's horizon.
///
/// `outwards` are those from the point outwards at the cosine `|mu_s|`. Below the horizon the ray first descends to its perigee: twice
/// the column densities that rise from there, less those behind the point. What the exponential profiles hold above the top of the atmosphere is
/// taken off where it matters.
#[inline(always)]
pub fn sun_column_densities(
    atmosphere: &Atmosphere,
    altitude: f32,
    outwards: ColumnDensities,
    mu_s: f32,
    variant: u32,
) -> ColumnDensities {
    let mut density = outwards;
    let mut lowest = LowestPoint { altitude, mu: abs(mu_s) };
    if (variant & variant::LOW_SUN != 0) & (mu_s < 0.0) {
        lowest = LowestPoint { altitude: max(perigee_altitude(atmosphere.shell(), altitude, mu_s), 0.0), mu: 0.0 };
        density = level_column_densities(atmosphere, lowest.altitude, variant) * 2.0 - density;
    }
    if variant & variant::ABOVE_TOP != 0 {
        let top = atmosphere.depth;
        let mu = zenith_cosine_at_top(atmosphere.shell(), altitude, mu_s);
        density -= column_densities(atmosphere, top, relative_densities(atmosphere, top, variant), mu, variant);
        if variant & variant::OPAQUE != 0 {
            let length = distance_to_top(atmosphere.shell(), altitude, mu_s);
            density = stretch_column_densities(atmosphere, altitude, mu_s, lowest, length, density, variant);
        }
    }
    density.max(Vec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GROUND_RADIUS: f64 = 6360.0;
    const SCALE_HEIGHTS: [f64; 2] = [8.0, 1.2];

    fn earth() -> Atmosphere {
        let [air, aerosol] = SCALE_HEIGHTS.map(|height| Exponential::new(height, GROUND_RADIUS));
        Atmosphere {
            air,
            aerosol,
            ground_radius: GROUND_RADIUS as f32,
            depth: 100.0,
            ozone_bottom: 10.0,
            ozone_peak: 25.0,
            ozone_top: 40.0,
            ..Atmosphere::zeroed()
        }
    }

    /// The integral of a density along a straight ray, by midpoints every 10 m.
    fn integral(density: impl Fn(f64) -> f64, altitude: f64, mu: f64) -> f64 {
        let r = GROUND_RADIUS + altitude;
        let at = |s: f64| density((r * r + s * s + 2.0 * r * mu * s).sqrt() - GROUND_RADIUS);
        (0..400_000).map(|i| at(0.01 * (f64::from(i) + 0.5))).sum::<f64>() * 0.01
    }

    fn truth(altitude: f64, mu: f64) -> [f64; 3] {
        let [air, aerosol] = SCALE_HEIGHTS.map(|height| integral(|h| (-h / height).exp(), altitude, mu));
        [air, aerosol, integral(|h| f64::from(ozone_density(&earth(), h as f32)), altitude, mu)]
    }

    fn agrees(found: ColumnDensities, truth: [f64; 3], vertical: [f64; 3]) {
        for ((found, truth), vertical) in found.to_array().into_iter().zip(truth).zip(vertical) {
            // The closed form's 9e-6 of the ground's, and single precision's rounding.
            let error = (f64::from(found) - truth).abs();
            assert!(error <= 1.2e-5 * truth.max(0.1 * vertical), "{found}, not {truth}");
        }
    }

    #[test]
    fn ozone_is_a_tent() {
        for (altitude, density) in [(0.0, 0.0), (10.0, 0.0), (17.5, 0.5), (25.0, 1.0), (32.5, 0.5), (41.0, 0.0)] {
            assert!((ozone_density(&earth(), altitude) - density).abs() < 1e-6);
        }
    }

    #[test]
    fn a_vertical_column_density_from_the_ground_is_the_scale_height() {
        let found = column_densities(&earth(), 0.0, Vec2::ONE, 1.0, variant::WHOLE_INTEGRAL);
        // Half of the tent's width is 15 km.
        agrees(found, [8.0, 1.2, 15.0], [8.0, 1.2, 15.0]);
    }

    #[test]
    fn column_densities_are_integrals_of_densities() {
        let atmosphere = earth();
        for altitude in [0.0f32, 2.0, 18.0] {
            let density = relative_densities(&atmosphere, altitude, variant::WHOLE_INTEGRAL);
            for mu in [0.0f32, 0.03, 0.3, 1.0] {
                let found = column_densities(&atmosphere, altitude, density, mu, variant::WHOLE_INTEGRAL);
                agrees(found, truth(f64::from(altitude), f64::from(mu)), [8.0, 1.2, 15.0]);
            }
            let level = level_column_densities(&atmosphere, altitude, variant::WHOLE_INTEGRAL);
            agrees(level, truth(f64::from(altitude), 0.0), [8.0, 1.2, 15.0]);
        }
    }

    #[test]
    fn sunlight_from_below_the_horizon_crosses_the_air_twice() {
        let atmosphere = earth();
        let (altitude, mu_s) = (30.0f32, -0.06f32);
        let density = relative_densities(&atmosphere, altitude, variant::WHOLE_INTEGRAL);
        let outwards = column_densities(&atmosphere, altitude, density, -mu_s, variant::WHOLE_INTEGRAL);
        let below_horizon = variant::WHOLE_INTEGRAL & !variant::ABOVE_TOP;
        let found = sun_column_densities(&atmosphere, altitude, outwards, mu_s, below_horizon);
        agrees(found, truth(f64::from(altitude), f64::from(mu_s)), [8.0, 1.2, 15.0]);
    }
}
