//! Directions from the observer, the horizon, and where it is night.

use std::f64::consts::FRAC_PI_2;

use sorairo_shared::glam::DVec3;

use crate::scene::Scene;

/// The unit vector to an elevation and an azimuth (degrees), azimuth clockwise from north; x north, y west, z up.
pub fn direction(elevation: f64, azimuth: f64) -> DVec3 {
    let (sin_elevation, cos_elevation) = elevation.to_radians().sin_cos();
    let (sin_azimuth, cos_azimuth) = azimuth.to_radians().sin_cos();
    DVec3::new(cos_elevation * cos_azimuth, -cos_elevation * sin_azimuth, sin_elevation)
}

/// Elevation (radians) of the horizon from an altitude above a sphere (km): `-acos(R / (R + h))`, without its
/// cancellation.
pub fn horizon(ground_radius: f64, altitude: f64) -> f64 {
    let tangent = (altitude * (2.0 * ground_radius + altitude)).sqrt();
    -(tangent / ground_radius).atan().min(FRAC_PI_2)
}

/// The angle (radians) from the horizon up to the zenith, or to the upper edge of the atmosphere where the observer
/// stands outside of it.
pub fn span_above_horizon(scene: &Scene) -> f64 {
    let a = &scene.atmosphere;
    let (depth, altitude) = (a.top_radius - a.ground_radius, scene.observer.altitude);
    let edge = if altitude > depth { horizon(a.top_radius, altitude - depth) } else { FRAC_PI_2 };
    edge - horizon(a.ground_radius, altitude)
}

/// The angle (radians, at the planet's centre) to the farthest point of the atmosphere that can be seen: what the
/// altitude of the observer and the depth of the atmosphere each let a ray see behind the horizon.
pub fn farthest_air(scene: &Scene) -> f64 {
    let a = &scene.atmosphere;
    let beyond_horizon = |altitude: f64| -horizon(a.ground_radius, altitude);
    beyond_horizon(scene.observer.altitude) + beyond_horizon(a.top_radius - a.ground_radius)
}

/// Whether the farthest air that can be seen stands in the planet's shadow, which is as deep as the atmosphere where
/// the sun stands as far below the horizon as its top can see.
pub fn is_night(scene: &Scene) -> bool {
    let a = &scene.atmosphere;
    let night = -farthest_air(scene) + horizon(a.ground_radius, a.top_radius - a.ground_radius);
    scene.sun.elevation < night.to_degrees()
}
