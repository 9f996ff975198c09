//! The single-scattering integral: a ray in, the transfer at each band out (Eqs. 1-3).
//!
//! Sunlight of irradiance `E(λ)` reaches a point at distance `s` along the view ray, weakened by the optical depth between the
//! top of the atmosphere and the point. There air scatters the part `β_air ρ_air P_air(ν)` of it towards the observer, and
//! aerosol the part `β_aerosol ρ_aerosol P_aerosol(ν)`; on the way it is weakened once more:
//!
//! ```text
//! L(λ) = E(λ) ∫ Σ_c β_c(λ) ρ_c(h) P_c(ν) exp(-τ(sun → s; λ) - τ(s → observer; λ)) ds        (Eq. 1)
//! τ(λ) = Σ_c β_c,ext(λ) ∫ ρ_c(h) ds                                                        (Eq. 2)
//! β_air(λ) = 4π k / λ⁴                                                                     (Eq. 3)
//! ```
//!
//! The integral runs over the part of the ray that the sun lights. Phase functions do not change along a ray, so the
//! integral of each constituent is returned without its phase function. Light scattered more than once would enter as a
//! source per band beside the two integrands below.

use bytemuck::{Pod, Zeroable};

use crate::atmosphere::Atmosphere;
use crate::column::{
    Lowest, column_outwards, columns_outwards, columns_per_density, densities, level_column, short_column, sun_column,
};
use crate::geometry::{
    self, Interval, Ray, altitude_along, altitude_from, altitude_of_lit_end, distance_to_top, inside_atmosphere,
    perigee_altitude,
};
use crate::glam::{Vec2, Vec3, Vec4};
use crate::math::{abs, exp4, fetch, max, min, sqrt};
use crate::variant;

/// Optical properties of the atmosphere and the sun at four bands. The layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Bands {
    /// Scattering coefficient of air at the ground (km⁻¹).
    pub air_scattering: Vec4,
    /// Scattering coefficient of aerosol at the ground (km⁻¹).
    pub aerosol_scattering: Vec4,
    /// Extinction coefficient of aerosol at the ground (km⁻¹).
    pub aerosol_extinction: Vec4,
    /// Absorption coefficient of ozone at its peak (km⁻¹).
    pub ozone_absorption: Vec4,
    /// Solar irradiance at the top of the atmosphere (W·m⁻²·nm⁻¹).
    pub solar_irradiance: Vec4,
    /// What the fit of an explicit solve multiplies the transfer with: the solar irradiance, or 1.
    pub fit_irradiance: Vec4,
}

/// Nothing.
pub const DARK: SingleScattering = SingleScattering { air: Vec4::ZERO, aerosol: Vec4::ZERO };

/// What one ray's single scattering amounts to at four bands, before the phase functions.
#[derive(Clone, Copy)]
pub struct SingleScattering {
    /// The integral of Eq. (1) for air, with `P = 1` and `E = 1`.
    pub air: Vec4,
    /// The integral of Eq. (1) for aerosol, with `P = 1` and `E = 1`.
    pub aerosol: Vec4,
}

/// Optical depth at each band of a column of (air, aerosol, ozone) densities in km (Eq. 2).
#[inline(always)]
pub fn optical_depth(bands: &Bands, column: Vec3) -> Vec4 {
    bands.air_scattering * column.x + bands.aerosol_extinction * column.y + bands.ozone_absorption * column.z
}

/// The single-scattering integral along a ray from any altitude, inside the atmosphere or above it (Eq. 1).
///
/// The lit part of the ray is cut at its perigee and at the planet's shadow, and each piece is integrated by the same
/// `quadrature`: (node, weight) on [0, 1], Gauss-Legendre in a variable that crowds towards the piece's lowest, densest end (see
/// `crowded`). `variant` says what the scene has; see [`variant`]. Without ozone twelve samples
/// leave 5e-4 of the radiance and sixteen 2e-5. With it, sunlight that grazes the kinks of the ozone tent slows the
/// convergence when the sun is low: sixteen then leave 7e-3, forty-eight 4e-4.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), multiversion::multiversion(targets("x86_64+avx+avx2")))]
pub fn single_scattering(
    atmosphere: &Atmosphere,
    bands: &Bands,
    quadrature: &[Vec2],
    ray: Ray,
    variant: u32,
) -> SingleScattering {
    let shell = atmosphere.shell();
    let mut ray = ray;
    let length;
    let mut perigee = 0.0;
    let mut lowest = ray.altitude;
    if variant & variant::DESCENT != 0 {
        (ray, length) = inside_atmosphere(shell, ray);
        perigee = max(-(shell.ground_radius + ray.altitude) * ray.mu, 0.0);
        lowest = if ray.mu < 0.0 { max(perigee_altitude(shell, ray.altitude, ray.mu), 0.0) } else { ray.altitude };
    } else {
        // From the ground itself every falling ray ends where it begins.
        length = if ray.mu < 0.0 { 0.0 } else { distance_to_top(shell, ray.altitude, ray.mu) };
    }
    let mut shadow = Interval { start: length, end: length };
    if variant & variant::SHADOW != 0 {
        shadow = geometry::shadow(shell, ray);
    }
    let mut sum = DARK;
    // Before or behind the shadow, falling or rising: at most three of the four pieces are not empty.
    let mut piece = if variant & variant::DESCENT != 0 { 0 } else { 1 };
    let step = if variant & variant::DESCENT != 0 { 1 } else { 2 };
    let pieces = if variant & variant::SHADOW != 0 { 4 } else { 2 };
    while piece < pieces {
        let rising = piece & 1 == 1;
        let behind_shadow = piece & 2 == 2;
        let lit = if behind_shadow {
            Interval { start: shadow.end, end: length }
        } else {
            Interval { start: 0.0, end: min(shadow.start, length) }
        };
        let interval = if rising {
            Interval { start: max(lit.start, perigee), end: lit.end }
        } else {
            Interval { start: lit.start, end: min(lit.end, perigee) }
        };
        if interval.end > interval.start {
            let low = if rising { interval.start } else { interval.end };
            // The ends that are known better than by their distance: the ground, the ray's lowest point, the observer, the shadow.
            let at_lowest = (low == perigee) | (!rising & (low == length));
            let mut altitude = if at_lowest { lowest } else { altitude_along(shell, ray, low) };
            if (variant & variant::SHADOW != 0) & (low != perigee) {
                altitude = altitude_of_lit_end(shell, ray, low, altitude);
            }
            let piece = Piece { low, altitude, length: interval.end - interval.start, rising };
            let part = integrate_piece(atmosphere, bands, quadrature, ray, lowest, piece, variant);
            sum.air += part.air;
            sum.aerosol += part.aerosol;
        }
        piece += step;
    }
    SingleScattering { air: sum.air * bands.air_scattering, aerosol: sum.aerosol * bands.aerosol_scattering }
}

/// A lit stretch of a ray on which its altitude only rises or only falls.
#[derive(Clone, Copy)]
struct Piece {
    /// Distance of its low end along the ray (km).
    low: f32,
    /// Altitude of its low end (km).
    altitude: f32,
    /// Its length (km).
    length: f32,
    /// Whether the ray rises from the low end on, and does not fall to it.
    rising: bool,
}

/// What a sample's own outward column is taken from (rising ray) or added to (falling ray) to give the column between the
/// observer and the sample (km). `lowest` is the altitude of the ray's lowest point (km).
#[inline(always)]
fn column_offset(atmosphere: &Atmosphere, ray: Ray, lowest: f32, rising: bool, variant: u32) -> Vec3 {
    let density = densities(atmosphere, ray.altitude, variant);
    let outwards = column_outwards(atmosphere, ray.altitude, density, abs(ray.mu), variant);
    if (variant & variant::DESCENT == 0) | (ray.mu >= 0.0) {
        outwards
    } else if rising {
        level_column(atmosphere, lowest, variant) * 2.0 - outwards
    } else {
        -outwards
    }
}

/// How strongly the samples of a piece crowd towards its low end: `k` of the substitution
/// `s = length · u / (1 + k (1 - u))`.
///
/// The integrand falls off over the distance `D` in which the density does, or over a few mean free paths of light, whichever is shorter;
/// `k` makes the sampled variable as long as three of those. `low` is the distance of the low end along the ray. A falling ray
/// reaches its low end last: in opaque air nothing is seen of it, and the density alone counts. `mu` is the cosine of the angle between
/// the vertical and the piece at its low end.
#[inline(always)]
fn crowded(atmosphere: &Atmosphere, bands: &Bands, piece: Piece, mu: f32, variant: u32) -> f32 {
    let Piece { altitude, length, rising, .. } = piece;
    let g = sqrt(1.0 + altitude / atmosphere.ground_radius);
    let fall_off = columns_per_density(atmosphere, g, Vec2::splat(mu), variant).x;
    let density = densities(atmosphere, altitude, variant);
    let extinction = bands.air_scattering * density.x + bands.aerosol_extinction * density.y;
    let strongest = if rising { max(max(extinction.x, extinction.y), max(extinction.z, extinction.w)) } else { 0.0 };
    max(0.35 * length * (1.0 / fall_off + 0.05 * strongest) - 1.0, 0.0)
}

/// The integral over a piece.
///
/// Samples are placed by their distance from the low end: altitudes there are sums of positive terms, and near the ground keep the digits
/// that they would lose as distances from an observer far above.
#[inline(always)]
fn integrate_piece(
    atmosphere: &Atmosphere,
    bands: &Bands,
    quadrature: &[Vec2],
    ray: Ray,
    lowest: f32,
    piece: Piece,
    variant: u32,
) -> SingleScattering {
    let shell = atmosphere.shell();
    let Piece { low, altitude: low_altitude, length, rising } = piece;
    let outwards = if rising { 1.0 } else { -1.0 };
    let r = shell.ground_radius + ray.altitude;
    let low_r = shell.ground_radius + low_altitude;
    let low_mu = max((r * ray.mu + low) * outwards, 0.0) / low_r;
    let low_r_mu_s = r * ray.mu_s + low * ray.nu;
    let nu = ray.nu * outwards;
    let offset = column_offset(atmosphere, ray, lowest, rising, variant);
    let k = crowded(atmosphere, bands, piece, low_mu, variant);
    let lowest_ahead = Lowest { altitude: lowest, mu: max(ray.mu, 0.0) };
    let mut air = Vec4::ZERO;
    let mut aerosol = Vec4::ZERO;
    let mut i = 0;
    while i < quadrature.len() {
        let node = fetch(quadrature, i);
        let stretch = 1.0 / (1.0 + k * (1.0 - node.x));
        let s = length * node.x * stretch;
        let weight = node.y * length * (1.0 + k) * stretch * stretch;

        let altitude = altitude_from(shell, low_altitude, low_mu, s);
        let inverse_r = 1.0 / (shell.ground_radius + altitude);
        let mu = (low_r * low_mu + s) * inverse_r;
        let mu_s = (low_r_mu_s + s * nu) * inverse_r;
        let density = densities(atmosphere, altitude, variant);
        let columns = columns_outwards(atmosphere, altitude, density, Vec2::new(mu, abs(mu_s)), variant);
        let mut to_observer = offset - columns.first * outwards;
        if variant & variant::OPAQUE != 0 {
            let lowest = if rising { lowest_ahead } else { Lowest { altitude, mu } };
            let distance = low + outwards * s;
            to_observer = short_column(atmosphere, ray.altitude, ray.mu, lowest, distance, to_observer, variant);
        }
        let to_sun = sun_column(atmosphere, altitude, columns.second, mu_s, variant);
        let column = to_observer.max(Vec3::ZERO) + to_sun;
        let transmittance = exp4(-optical_depth(bands, column)) * weight;
        air += transmittance * density.x;
        if variant & variant::AEROSOL != 0 {
            aerosol += transmittance * density.y;
        }
        i += 1;
    }
    SingleScattering { air, aerosol }
}
