//! Column densities along rays.
//!
//! A column density is the integral of a constituent's relative density along a ray to the top of the atmosphere, in
//! km. It is colourless: the same number serves every wavelength. Those of air and aerosol come by the closed form of
//! [`crate::medium::exponential`], those of ozone by [`crate::medium::ozone`].

use crate::geometry::{altitude_from, distance_to_top, perigee_altitude, zenith_cosine_at_top};
use crate::glam::{Vec2, Vec3, Vec4};
use crate::math::{abs, max, sqrt};
use crate::medium::atmosphere::{Atmosphere, ColumnDensities, Medium, lanes};
use crate::medium::density::relative_densities;
use crate::medium::exponential::CHAPMAN_ALTITUDE_COEFFICIENTS;
use crate::medium::ozone::ozone_column_densities;
use crate::medium::tables::{self, Sunlight, SunlightEntry};
use crate::variant;

/// Column densities along two rays from one point.
#[derive(Clone, Copy)]
pub struct TwoRays {
    /// Along the first ray (km).
    pub first: ColumnDensities,
    /// Along the second ray (km).
    pub second: ColumnDensities,
}

/// Equivalent lengths of air and aerosol (km), along two rays from one point with `mu >= 0`: column densities per local
/// density, `H K g Σᵢ cᵢ tⁱ`. Over such a length a constituent falls off. The lanes are air and aerosol along the first
/// ray, then along the second; what nobody asks for, the compiler drops.
///
/// `g` is `√(1 + h/R)`. Where the air is opaque, the correction for altitude is made; elsewhere nothing of it would be
/// seen.
#[inline(always)]
pub fn equivalent_lengths(medium: Medium<'_>, g: f32, mu: Vec2, variant: u32) -> Vec4 {
    let (air, aerosol) = (&medium.atmosphere.air, &medium.atmosphere.aerosol);
    let t = Vec4::ONE / (Vec4::ONE + lanes(air.spread, aerosol.spread) * g * Vec4::new(mu.x, mu.x, mu.y, mu.y));
    let (a, b) = (air.low_coefficients, aerosol.low_coefficients);
    let (c, d) = (air.high_coefficients, aerosol.high_coefficients);
    let high = ((lanes(c.w, d.w) * t + lanes(c.z, d.z)) * t + lanes(c.y, d.y)) * t + lanes(c.x, d.x);
    let low = ((high * t + lanes(a.w, b.w)) * t + lanes(a.z, b.z)) * t + lanes(a.y, b.y);
    let length = lanes(air.unit, aerosol.unit) * g * t * (low * t + lanes(a.x, b.x));
    if variant & variant::OPAQUE != 0 { length * altitude_correction(medium.atmosphere, g, t) } else { length }
}

/// The factors of the correction for altitude of [`crate::medium::exponential`]: `1 - (H/R) (1 - 1/g²) Σᵢ eᵢ tⁱ`.
#[inline(always)]
fn altitude_correction(atmosphere: &Atmosphere, g: f32, t: Vec4) -> Vec4 {
    let [e0, e1, e2] = CHAPMAN_ALTITUDE_COEFFICIENTS;
    let curvature = lanes(atmosphere.air.curvature(), atmosphere.aerosol.curvature());
    Vec4::ONE - curvature * (1.0 - 1.0 / (g * g)) * ((t * e2 + Vec4::splat(e1)) * t + Vec4::splat(e0))
}

/// Column densities (km) in closed form from `altitude` (km) outwards along two rays with cosines `mu >= 0`, of an
/// atmosphere without a top. `density` holds the relative densities of (air, aerosol) there; what `variant` leaves out
/// is 0.
#[inline(always)]
fn column_densities_of_two(medium: Medium<'_>, altitude: f32, density: Vec2, mu: Vec2, variant: u32) -> TwoRays {
    let g = sqrt(1.0 + altitude * (1.0 / medium.atmosphere.ground_radius));
    let exponential = lanes(density.x, density.y) * equivalent_lengths(medium, g, mu, variant);
    let mut first = Vec3::new(exponential.x, 0.0, 0.0);
    let mut second = Vec3::new(exponential.z, 0.0, 0.0);
    if variant & variant::AEROSOL != 0 {
        (first.y, second.y) = (exponential.y, exponential.w);
    }
    if variant & variant::OZONE != 0 {
        let ozone = ozone_column_densities(medium, altitude, mu);
        (first.z, second.z) = (ozone.x, ozone.y);
    }
    TwoRays { first: ColumnDensities::without_gases(first), second: ColumnDensities::without_gases(second) }
}

/// Column densities (km) from `altitude` (km) outwards along a ray with a cosine `mu >= 0`.
#[inline(always)]
pub fn column_densities(medium: Medium<'_>, altitude: f32, density: Vec2, mu: f32, variant: u32) -> ColumnDensities {
    if variant & variant::TABLES != 0 {
        return present(tables::column_densities(medium, altitude, mu), variant);
    }
    column_densities_of_two(medium, altitude, density, Vec2::splat(mu), variant).first
}

/// Column densities without those of what the variant leaves out.
#[inline(always)]
fn present(along: ColumnDensities, variant: u32) -> ColumnDensities {
    ColumnDensities {
        aerosol: if variant & variant::AEROSOL != 0 { along.aerosol } else { 0.0 },
        ozone: if variant & variant::OZONE != 0 { along.ozone } else { 0.0 },
        ..along
    }
}

/// [`column_densities`] along the level ray at an altitude (km), the lowest point of a ray that comes down and goes up
/// again.
#[inline(always)]
pub fn level_column_densities(medium: Medium<'_>, altitude: f32, variant: u32) -> ColumnDensities {
    if variant & variant::TABLES != 0 {
        return present(tables::column_densities(medium, altitude, 0.0), variant);
    }
    let density = relative_densities(medium, altitude, variant);
    let g = sqrt(1.0 + altitude * (1.0 / medium.atmosphere.ground_radius));
    let air = density.x * g * medium.atmosphere.air.level_column_density;
    let aerosol = density.y * g * medium.atmosphere.aerosol.level_column_density;
    let mut outwards = Vec3::new(air, aerosol, 0.0);
    if variant & variant::OPAQUE != 0 {
        let correction = altitude_correction(medium.atmosphere, g, Vec4::ONE);
        outwards *= Vec3::new(correction.x, correction.y, 1.0);
    }
    if variant & variant::OZONE != 0 {
        outwards.z = ozone_column_densities(medium, altitude, Vec2::ZERO).x;
    }
    ColumnDensities::without_gases(outwards)
}

/// The lowest point of a stretch of a ray.
#[derive(Clone, Copy)]
pub struct LowestPoint {
    /// Its altitude (km).
    pub altitude: f32,
    /// Cosine of the angle between the ray and the vertical there, 0 or more.
    pub mu: f32,
}

/// Column densities over the first `length` km of a ray: those of air and aerosol summed where that is shorter than the
/// length over which they fall off at the ray's lowest point; elsewhere `difference`, which is of two column densities
/// to infinity (km).
///
/// Two such column densities in an opaque atmosphere have no digits left for a stretch much shorter than themselves.
/// There three nodes of Gauss-Legendre leave 5e-7 of the stretch's own column density.
#[inline(always)]
pub fn stretch_column_densities(
    medium: Medium<'_>,
    altitude: f32,
    mu: f32,
    lowest: LowestPoint,
    length: f32,
    difference: ColumnDensities,
    variant: u32,
) -> ColumnDensities {
    const OUTER_NODE: f32 = 0.112_701_665;
    let g = sqrt(1.0 + lowest.altitude / medium.atmosphere.ground_radius);
    let shell = medium.shell();
    let density = |s: f32| relative_densities(medium, altitude_from(shell, altitude, mu, s), variant);
    let ends = density(OUTER_NODE * length) + density((1.0 - OUTER_NODE) * length);
    let stretch = (ends * (5.0 / 18.0) + density(0.5 * length) * (8.0 / 18.0)) * length;
    let fall_off = equivalent_lengths(medium, g, Vec2::splat(lowest.mu), variant);
    let mut result = difference;
    if length < fall_off.x {
        result.air = stretch.x;
    }
    if (variant & variant::AEROSOL != 0) & (length < fall_off.y) {
        result.aerosol = stretch.y;
    }
    result
}

/// Sunlight at a lit point from the tables.
#[inline(always)]
fn bent_sunlight(medium: Medium<'_>, altitude: f32, mu_s: f32, variant: u32) -> Sunlight {
    sunlight_of_entry(SunlightEntry::at(medium, altitude, mu_s), variant)
}

/// Sunlight of what the table of sunlight holds.
#[inline(always)]
pub fn sunlight_of_entry(entry: SunlightEntry, variant: u32) -> Sunlight {
    let Sunlight { along, spread } = entry.sunlight();
    Sunlight { along: present(along, variant), spread }
}

/// Sunlight at a lit point where the relative densities of (air, aerosol) are known, by the cosine of the sun's zenith
/// angle.
#[inline(always)]
pub fn sunlight_at(medium: Medium<'_>, altitude: f32, density: Vec2, mu_s: f32, variant: u32) -> Sunlight {
    if variant & variant::TABLES != 0 {
        return bent_sunlight(medium, altitude, mu_s, variant);
    }
    let outwards = column_densities(medium, altitude, density, abs(mu_s), variant);
    straight_sunlight(medium, altitude, outwards, mu_s, variant)
}

/// Sunlight of two suns at a lit point.
#[inline(always)]
pub fn sunlight_of_two(medium: Medium<'_>, altitude: f32, density: Vec2, mu_s: Vec2, variant: u32) -> [Sunlight; 2] {
    if variant & variant::TABLES != 0 {
        return [mu_s.x, mu_s.y].map(|mu_s| bent_sunlight(medium, altitude, mu_s, variant));
    }
    let up = Vec2::new(abs(mu_s.x), abs(mu_s.y));
    let TwoRays { first, second } = column_densities_of_two(medium, altitude, density, up, variant);
    [(first, mu_s.x), (second, mu_s.y)]
        .map(|(outwards, mu_s)| straight_sunlight(medium, altitude, outwards, mu_s, variant))
}

/// Column densities outwards along a ray with a cosine `mu >= 0`, and sunlight, at a lit point.
#[inline(always)]
pub fn outwards_and_sunlight(
    medium: Medium<'_>,
    altitude: f32,
    density: Vec2,
    mu: f32,
    mu_s: f32,
    variant: u32,
) -> (ColumnDensities, Sunlight) {
    if variant & variant::TABLES != 0 {
        let outwards = column_densities(medium, altitude, density, mu, variant);
        return (outwards, bent_sunlight(medium, altitude, mu_s, variant));
    }
    let TwoRays { first, second } =
        column_densities_of_two(medium, altitude, density, Vec2::new(mu, abs(mu_s)), variant);
    (first, straight_sunlight(medium, altitude, second, mu_s, variant))
}

/// Sunlight on a straight way, by the column densities from a lit point outwards at the cosine `|mu_s|` (km).
#[inline(always)]
fn straight_sunlight(
    medium: Medium<'_>,
    altitude: f32,
    outwards: ColumnDensities,
    mu_s: f32,
    variant: u32,
) -> Sunlight {
    Sunlight { along: sun_column_densities(medium, altitude, outwards, mu_s, variant), spread: 1.0 }
}

/// Column densities (km) from a lit point to the sun, on either side of the point's horizon.
///
/// `outwards` are those from the point outwards at the cosine `|mu_s|`. Below the horizon the ray first descends to its
/// perigee: twice the column densities that rise from there, less those behind the point. What the exponential profiles
/// hold above the top of the atmosphere is taken off where it matters.
#[inline(always)]
fn sun_column_densities(
    medium: Medium<'_>,
    altitude: f32,
    outwards: ColumnDensities,
    mu_s: f32,
    variant: u32,
) -> ColumnDensities {
    let mut density = outwards;
    let mut lowest = LowestPoint { altitude, mu: abs(mu_s) };
    if (variant & variant::LOW_SUN != 0) & (mu_s < 0.0) {
        lowest = LowestPoint { altitude: max(perigee_altitude(medium.shell(), altitude, mu_s), 0.0), mu: 0.0 };
        density = level_column_densities(medium, lowest.altitude, variant) * 2.0 - density;
    }
    if variant & variant::ABOVE_TOP != 0 {
        let top = medium.atmosphere.depth;
        let mu = zenith_cosine_at_top(medium.shell(), altitude, mu_s);
        density = density - column_densities(medium, top, relative_densities(medium, top, variant), mu, variant);
        if variant & variant::OPAQUE != 0 {
            let length = distance_to_top(medium.shell(), altitude, mu_s);
            density = stretch_column_densities(medium, altitude, mu_s, lowest, length, density, variant);
        }
    }
    density.at_least_zero()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::exponential::Exponential;
    use crate::medium::ozone::ozone_density;
    use bytemuck::Zeroable;

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

    fn exponential(atmosphere: &Atmosphere) -> Medium<'_> {
        Medium { atmosphere, tables: &[] }
    }

    /// The integral of a density along a straight ray, by midpoints every 10 m.
    fn integral(density: impl Fn(f64) -> f64, altitude: f64, mu: f64) -> f64 {
        let r = GROUND_RADIUS + altitude;
        let at = |s: f64| density((r * r + s * s + 2.0 * r * mu * s).sqrt() - GROUND_RADIUS);
        (0..400_000).map(|i| at(0.01 * (f64::from(i) + 0.5))).sum::<f64>() * 0.01
    }

    fn truth(altitude: f64, mu: f64) -> [f64; 3] {
        let [air, aerosol] = SCALE_HEIGHTS.map(|height| integral(|h| (-h / height).exp(), altitude, mu));
        [air, aerosol, integral(|h| f64::from(ozone_density(exponential(&earth()), h as f32, 0)), altitude, mu)]
    }

    fn agrees(found: ColumnDensities, truth: [f64; 3], vertical: [f64; 3]) {
        for ((found, truth), vertical) in [found.air, found.aerosol, found.ozone].into_iter().zip(truth).zip(vertical) {
            // The closed form's 9e-6 of the ground's, and single precision's rounding.
            let error = (f64::from(found) - truth).abs();
            assert!(error <= 1.2e-5 * truth.max(0.1 * vertical), "{found}, not {truth}");
        }
    }

    #[test]
    fn ozone_is_a_tent() {
        for (altitude, density) in [(0.0, 0.0), (10.0, 0.0), (17.5, 0.5), (25.0, 1.0), (32.5, 0.5), (41.0, 0.0)] {
            assert!((ozone_density(exponential(&earth()), altitude, 0) - density).abs() < 1e-6);
        }
    }

    #[test]
    fn a_vertical_column_density_from_the_ground_is_the_scale_height() {
        let found = column_densities(exponential(&earth()), 0.0, Vec2::ONE, 1.0, variant::WHOLE_INTEGRAL);
        // Half of the tent's width is 15 km.
        agrees(found, [8.0, 1.2, 15.0], [8.0, 1.2, 15.0]);
    }

    #[test]
    fn column_densities_are_integrals_of_densities() {
        let atmosphere = earth();
        let medium = exponential(&atmosphere);
        for altitude in [0.0f32, 2.0, 18.0] {
            let density = relative_densities(medium, altitude, variant::WHOLE_INTEGRAL);
            for mu in [0.0f32, 0.03, 0.3, 1.0] {
                let found = column_densities(medium, altitude, density, mu, variant::WHOLE_INTEGRAL);
                agrees(found, truth(f64::from(altitude), f64::from(mu)), [8.0, 1.2, 15.0]);
            }
            let level = level_column_densities(medium, altitude, variant::WHOLE_INTEGRAL);
            agrees(level, truth(f64::from(altitude), 0.0), [8.0, 1.2, 15.0]);
        }
    }

    #[test]
    fn sunlight_from_below_the_horizon_crosses_the_air_twice() {
        let atmosphere = earth();
        let medium = exponential(&atmosphere);
        let (altitude, mu_s) = (30.0f32, -0.06f32);
        let density = relative_densities(medium, altitude, variant::WHOLE_INTEGRAL);
        let outwards = column_densities(medium, altitude, density, -mu_s, variant::WHOLE_INTEGRAL);
        let below_horizon = variant::WHOLE_INTEGRAL & !variant::ABOVE_TOP;
        let found = sun_column_densities(medium, altitude, outwards, mu_s, below_horizon);
        agrees(found, truth(f64::from(altitude), f64::from(mu_s)), [8.0, 1.2, 15.0]);
    }
}
