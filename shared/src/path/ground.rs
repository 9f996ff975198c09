//! The ground: what falls on it, and what it sends back.
//!
//! It is level, and as bright from every side (Lambert): of the irradiance `E` that falls on it the radiance `a E / π`
//! comes back, with `a` its albedo. `E` is that of the sun itself, `μ_s T(sun)`, and that of the sky.

use crate::geometry::Ray;
use crate::glam::{Vec2, Vec4};
use crate::math::max;
use crate::medium::atmosphere::{ColumnDensities, Medium};
use crate::medium::bands::{Bands, Coefficients};
use crate::medium::columns::{column_densities, sunlight_at};
use crate::medium::density::relative_densities;
use crate::medium::tables::{self, Sunlight};
use crate::path::observer::TowardsObserver;
use crate::path::ray::Way;
use crate::path::samples::Place;
use crate::value::Value;
use crate::variant;

/// `1/π`, of the irradiance on a white ground that is its radiance (sr⁻¹).
pub const LAMBERT: f32 = core::f32::consts::FRAC_1_PI;

/// The place on the ground where a ray comes down.
#[derive(Clone, Copy)]
pub struct GroundView {
    /// Whether there is one; without it nothing else holds.
    pub is_seen: bool,
    /// Distance from where the ray enters the atmosphere, or begins (km).
    pub distance: f32,
    /// Cosine of the zenith angle of the sun there.
    pub mu_s: f32,
    /// Column densities on the way (km).
    pub along: ColumnDensities,
}

/// Irradiance of level ground by the sun, relative to that above the atmosphere: `μ_s e^(-τ)`, with the angle at which
/// the sun is seen; 0 where it is below the horizon.
#[inline]
pub fn direct_irradiance<V: Value>(medium: Medium<'_>, coefficients: &Coefficients<V>, mu_s: f32, variant: u32) -> V {
    let has_tables = variant & variant::TABLES != 0;
    let up = if has_tables { mu_s } else { max(mu_s, 0.0) };
    let Sunlight { along, spread } = sunlight_at(medium, 0.0, ground_density(medium, variant), up, variant);
    let cosine = if has_tables { tables::cosine_from_ground(medium, mu_s) } else { up };
    coefficients.transmittance(along).scaled(spread * cosine)
}

/// Relative densities of (air, aerosol) on the ground.
#[inline]
fn ground_density(medium: Medium<'_>, variant: u32) -> Vec2 {
    if variant & variant::TABLES != 0 {
        return relative_densities(medium, 0.0, variant);
    }
    Vec2::new(1.0, if variant & variant::AEROSOL != 0 { 1.0 } else { 0.0 })
}

/// The ground at the end of a way.
#[inline]
pub(crate) fn ground_on_way(medium: Medium<'_>, way: Way, variant: u32) -> GroundView {
    let Way { ray, length, .. } = way;
    let r = medium.atmosphere.ground_radius + ray.altitude;
    let inverse = 1.0 / medium.atmosphere.ground_radius;
    let mu = max(-(r * ray.mu + length) * inverse, 0.0);
    let mu_s = (r * ray.mu_s + length * ray.nu) * inverse;
    let ground = Place { distance: length, altitude: 0.0, mu, mu_s };
    let outwards = column_densities(medium, 0.0, ground_density(medium, variant), mu, variant);
    let towards_observer = TowardsObserver::new(medium, ray, 0.0, false, variant);
    let along = towards_observer.column_densities(medium, ground, outwards, variant);
    GroundView { is_seen: way.meets_ground(medium.shell()), distance: length, mu_s, along }
}

/// The ground that a ray meets. Where no ray can descend the observer stands on it.
#[inline]
pub fn ground_seen(medium: Medium<'_>, ray: Ray, variant: u32) -> GroundView {
    if variant & variant::DESCENT == 0 {
        GroundView { is_seen: ray.mu < 0.0, distance: 0.0, mu_s: ray.mu_s, along: ColumnDensities::ZERO }
    } else {
        ground_on_way(medium, Way::new(medium, ray, variant & !variant::SHADOW), variant)
    }
}

/// Light that comes from white ground along a ray (transfer, sr⁻¹), of what the sun and the sky's `diffuse` irradiance
/// throw on it.
#[inline]
pub fn ground_light(medium: Medium<'_>, bands: &Bands, ground: GroundView, diffuse: Vec4, variant: u32) -> Vec4 {
    let coefficients = bands.coefficients();
    let irradiance = direct_irradiance(medium, &coefficients, ground.mu_s, variant) + diffuse;
    coefficients.transmittance(ground.along) * irradiance * LAMBERT
}
