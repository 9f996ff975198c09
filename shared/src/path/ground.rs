//! The ground: what falls on it, and what it sends back.
//!
//! It is level, and as bright from every side (Lambert): of the irradiance `E` that falls on it the radiance `a E / π` comes back, with `a` its
//! albedo. `E` is that of the sun itself, `μ_s T(sun)`, and that of the sky.

use crate::geometry::Ray;
use crate::glam::{Vec2, Vec4};
use crate::math::max;
use crate::medium::atmosphere::Atmosphere;
use crate::medium::bands::{Bands, Coefficients};
use crate::medium::columns::{ColumnDensities, column_densities, sun_column_densities};
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

/// Irradiance of level ground by the sun, relative to that above the atmosphere: `μ_s e^(-τ)`; 0 where the sun is below the horizon.
#[inline]
pub fn direct_irradiance<V: Value>(
    atmosphere: &Atmosphere,
    coefficients: &Coefficients<V>,
    mu_s: f32,
    variant: u32,
) -> V {
    coefficients.transmittance(column_densities_to_sun(atmosphere, mu_s, variant)).scaled(max(mu_s, 0.0))
}

/// Column densities between the ground and the sun (km), or the horizon where the sun is below it.
#[inline]
fn column_densities_to_sun(atmosphere: &Atmosphere, mu_s: f32, variant: u32) -> ColumnDensities {
    let up = max(mu_s, 0.0);
    let outwards = column_densities(atmosphere, 0.0, ground_density(variant), up, variant);
    sun_column_densities(atmosphere, 0.0, outwards, up, variant)
}

/// Relative densities of (air, aerosol) on the ground.
#[inline]
fn ground_density(variant: u32) -> Vec2 {
    Vec2::new(1.0, if variant & variant::AEROSOL != 0 { 1.0 } else { 0.0 })
}

/// The ground at the end of a way.
#[inline]
pub(crate) fn ground_on_way(atmosphere: &Atmosphere, way: Way, variant: u32) -> GroundView {
    let Way { ray, length, .. } = way;
    let r = atmosphere.ground_radius + ray.altitude;
    let inverse = 1.0 / atmosphere.ground_radius;
    let mu = max(-(r * ray.mu + length) * inverse, 0.0);
    let mu_s = (r * ray.mu_s + length * ray.nu) * inverse;
    let ground = Place { distance: length, altitude: 0.0, mu, mu_s };
    let outwards = column_densities(atmosphere, 0.0, ground_density(variant), mu, variant);
    let towards_observer = TowardsObserver::new(atmosphere, ray, 0.0, false, variant);
    let along = towards_observer.column_densities(atmosphere, ground, outwards, variant);
    GroundView { is_seen: way.meets_ground(atmosphere.shell()), distance: length, mu_s, along }
}

/// The ground that a ray meets. Where no ray can descend the observer stands on it.
#[inline]
pub fn ground_seen(atmosphere: &Atmosphere, ray: Ray, variant: u32) -> GroundView {
    if variant & variant::DESCENT == 0 {
        GroundView { is_seen: ray.mu < 0.0, distance: 0.0, mu_s: ray.mu_s, along: ColumnDensities::ZERO }
    } else {
        ground_on_way(atmosphere, Way::new(atmosphere.shell(), ray, variant & !variant::SHADOW), variant)
    }
}

/// Light that comes from white ground along a ray (transfer, sr⁻¹), of what the sun and the sky's `diffuse` irradiance throw on it.
#[inline]
pub fn ground_light(atmosphere: &Atmosphere, bands: &Bands, ground: GroundView, diffuse: Vec4, variant: u32) -> Vec4 {
    let coefficients = bands.coefficients();
    let irradiance = direct_irradiance(atmosphere, &coefficients, ground.mu_s, variant) + diffuse;
    coefficients.transmittance(ground.along) * irradiance * LAMBERT
}
