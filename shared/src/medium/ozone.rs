//! Ozone as a tent over altitude: its density, and its column densities.
//!
//! The integral over each slope of the tent, from where the ray enters it to the shell at its end, is taken by the
//! quintic Hermite rule on the density and its first two derivatives at both ends (error 8e-6 km for the Earth's tent,
//! whose vertical column density is 15 km).

use crate::glam::{Vec2, Vec4};
use crate::math::{max, max4, min, sqrt4};
use crate::medium::atmosphere::{Medium, lanes};
use crate::medium::tables;
use crate::variant;

/// Density of ozone relative to the tent's peak: a tent over bottom, peak and top (Bruneton 2017, "Ozone"), or from
/// tables.
///
/// `altitude` in km; from 0 to 1 in a tent.
#[inline]
pub fn ozone_density(medium: Medium<'_>, altitude: f32, variant: u32) -> f32 {
    if variant & variant::TABLES != 0 {
        return tables::relative_densities(medium, altitude).z;
    }
    let rising =
        (altitude - medium.atmosphere.ozone_bottom) / (medium.atmosphere.ozone_peak - medium.atmosphere.ozone_bottom);
    let falling =
        (medium.atmosphere.ozone_top - altitude) / (medium.atmosphere.ozone_top - medium.atmosphere.ozone_peak);
    max(min(rising, falling), 0.0)
}

/// Column densities of ozone (km at its peak density) along two rising rays from one point: the two slopes of the tent,
/// each from where the ray enters it.
///
/// Each is integrated along the ray by the quintic Hermite rule. The lanes of the vectors are the rising and the
/// falling slope along the first ray, then along the second.
#[inline(always)]
pub(crate) fn ozone_column_densities(medium: Medium<'_>, altitude: f32, mu: Vec2) -> Vec2 {
    let (bottom, peak, top) =
        (medium.atmosphere.ozone_bottom, medium.atmosphere.ozone_peak, medium.atmosphere.ozone_top);
    let rise = 1.0 / (peak - bottom);
    let fall = 1.0 / (top - peak);
    let r = medium.atmosphere.ground_radius + altitude;
    let exit = lanes(peak, top);
    let entry = lanes(min(max(altitude, bottom), peak), min(max(altitude, peak), top));
    let (r_entry, r_exit) =
        (entry + Vec4::splat(medium.atmosphere.ground_radius), exit + Vec4::splat(medium.atmosphere.ground_radius));
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
