//! Rays through spherical shells: altitudes, intersections, and the planet's shadow.
//!
//! In single precision `r² - R²` loses every digit of an altitude at planet scale. All functions here therefore work
//! with the altitude `h` and with products such as `h (2R + h) = r² - R²`, which do not cancel.

use crate::glam::Vec3;
use crate::math::{abs, max, safe_sqrt, sqrt};

/// The two spheres between which the atmosphere lies.
#[derive(Clone, Copy)]
pub struct Shell {
    /// Radius of the ground sphere (km).
    pub ground_radius: f32,
    /// Height of the top of the atmosphere above the ground (km).
    pub depth: f32,
    /// The planet's shadow, which bent sunlight narrows.
    pub shadow: Shadow,
}

/// The planet's shadow: a cone about the sun's direction, of the radius `R + offset - slope x` at a distance `x` behind
/// the planet's centre. Without refraction it is a cylinder.
#[derive(Clone, Copy)]
pub struct Shadow {
    /// How much wider the cone is at the planet's centre than the planet (km).
    pub offset: f32,
    /// By how much its radius falls with the distance; 0 for straight light.
    pub slope: f32,
    /// The distance behind the centre at which it begins, where the lowest ray touches the ground (km).
    pub begin: f32,
}

/// A view ray and the sun, as seen from the ray's origin.
#[derive(Clone, Copy)]
pub struct Ray {
    /// Altitude of the origin above the ground (km).
    pub altitude: f32,
    /// Cosine of the zenith angle of the ray at its origin.
    pub mu: f32,
    /// Cosine of the zenith angle of the sun at the ray's origin.
    pub mu_s: f32,
    /// Cosine of the angle between the ray and the sun.
    pub nu: f32,
    /// `1 - nu²`, computed from the cross product so that it is exact towards the sun and away from it.
    pub one_minus_nu_squared: f32,
    /// `mu - mu_s nu`, the part of the zenith direction along the ray and across the sun.
    pub mu_across_sun: f32,
    /// `1 - mu²`, computed from the components so that it is exact near the zenith and the nadir.
    pub one_minus_mu_squared: f32,
    /// `mu_s - mu nu`, the part of the zenith direction along the sun and across the ray.
    pub mu_s_across_view: f32,
}

/// An interval of distances along a ray (km); empty if `end <= start`.
#[derive(Clone, Copy)]
pub struct Interval {
    /// Where it begins (km).
    pub start: f32,
    /// Where it ends (km).
    pub end: f32,
}

impl Ray {
    /// The ray from `altitude` (km) along the unit vector `view`, with the sun along the unit vector `sun`.
    #[inline(always)]
    pub fn new(altitude: f32, view: Vec3, sun: Vec3) -> Self {
        let nu = view.dot(sun);
        let cross = view.cross(sun);
        Self {
            altitude,
            mu: view.z,
            mu_s: sun.z,
            nu,
            one_minus_nu_squared: cross.dot(cross),
            // z·(v - s ν) = z·(s × (v × s)), by components and without cancellation.
            mu_across_sun: sun.x * cross.y - sun.y * cross.x,
            one_minus_mu_squared: view.x * view.x + view.y * view.y,
            mu_s_across_view: view.y * cross.x - view.x * cross.y,
        }
    }

    /// The square of half of the chord that the ray's line cuts from the top of the atmosphere, seen from outside of
    /// it; negative if it misses.
    ///
    /// `(r μ)² - (r² - top²)` keeps its digits near the atmosphere, `top² - r² (1 - μ²)` far from it.
    #[inline(always)]
    fn half_chord_squared(self, shell: Shell) -> f32 {
        let top = shell.ground_radius + shell.depth;
        let r = shell.ground_radius + self.altitude;
        let r_mu = r * self.mu;
        let nearest = r * sqrt(self.one_minus_mu_squared);
        let above_top_squared = (self.altitude - shell.depth) * (r + top);
        if r_mu * r_mu < top * top { r_mu * r_mu - above_top_squared } else { (top - nearest) * (top + nearest) }
    }

    /// The same ray, seen from where it enters the atmosphere, given half of the chord that it cuts from the top of it
    /// (km).
    ///
    /// With `b` the distance of the line from the planet's centre and `q` half of the chord, the point of entry is
    /// `b w - q v`: `v` the ray's direction, `w` the unit vector from the centre to the line. Nothing of the distance
    /// to the observer is left in it, which in single precision would take the digits with it.
    #[inline(always)]
    fn entered(self, shell: Shell, q: f32) -> Self {
        let top = shell.ground_radius + shell.depth;
        let sine = sqrt(self.one_minus_mu_squared);
        let b = (shell.ground_radius + self.altitude) * sine;
        let sun_along_w = self.mu_s_across_view / max(sine, 1e-30);
        Self {
            altitude: shell.depth,
            mu: -q / top,
            mu_s: (b * sun_along_w - q * self.nu) / top,
            mu_across_sun: -(q * self.one_minus_nu_squared + b * self.nu * sun_along_w) / top,
            ..self
        }
    }
}

/// Altitude (km) at distance `s` (km) along the ray.
#[inline(always)]
pub fn altitude_along(shell: Shell, ray: Ray, s: f32) -> f32 {
    altitude_from(shell, ray.altitude, ray.mu, s)
}

/// Altitude (km) at distance `s` (km) from a point at `altitude` (km), along a ray with zenith cosine `mu` there.
///
/// `h(s) = (s² + 2 r μ s + h₀ (2R + h₀)) / (r(s) + R)`: an identity of `r(s)² - R²` without its cancellation.
#[inline(always)]
pub fn altitude_from(shell: Shell, altitude: f32, mu: f32, s: f32) -> f32 {
    let ground = shell.ground_radius;
    let r = ground + altitude;
    let above_ground_squared = s * (s + 2.0 * r * mu) + altitude * (ground + r);
    let r_at_s = safe_sqrt(ground * ground + above_ground_squared);
    max(above_ground_squared / (r_at_s + ground), 0.0)
}

/// Altitude (km) of the lowest point of the straight line through a point at `altitude` (km) with zenith cosine `mu`.
///
/// `h - r μ² / (1 + √(1 - μ²))`, equal to `r √(1 - μ²) - R`; negative if the line meets the ground.
#[inline(always)]
pub fn perigee_altitude(shell: Shell, altitude: f32, mu: f32) -> f32 {
    let r = shell.ground_radius + altitude;
    altitude - r * mu * mu / (1.0 + safe_sqrt(1.0 - mu * mu))
}

/// Distance (km) to the top of the atmosphere from a point inside it.
#[inline(always)]
pub fn distance_to_top(shell: Shell, altitude: f32, mu: f32) -> f32 {
    let r = shell.ground_radius + altitude;
    let below_top_squared = (shell.depth - altitude) * (2.0 * shell.ground_radius + shell.depth + altitude);
    let root = safe_sqrt(r * r * mu * mu + below_top_squared);
    if mu > 0.0 { below_top_squared / (r * mu + root) } else { root - r * mu }
}

/// Zenith cosine of the straight line through a point inside the atmosphere where it leaves through the top.
#[inline(always)]
pub fn zenith_cosine_at_top(shell: Shell, altitude: f32, mu: f32) -> f32 {
    let r = shell.ground_radius + altitude;
    let below_top_squared = (shell.depth - altitude) * (2.0 * shell.ground_radius + shell.depth + altitude);
    safe_sqrt(r * r * mu * mu + below_top_squared) / (shell.ground_radius + shell.depth)
}

/// The ray, seen from where it enters the atmosphere, and the distance (km) that it has left inside it, up to the
/// ground or the top. A ray that misses the atmosphere has nothing left.
#[inline(always)]
pub fn inside_atmosphere(shell: Shell, ray: Ray) -> (Ray, f32) {
    let mut inside = ray;
    let mut missed = false;
    if ray.altitude > shell.depth {
        let half_chord_squared = ray.half_chord_squared(shell);
        missed = (ray.mu >= 0.0) | (half_chord_squared <= 0.0);
        if !missed {
            inside = ray.entered(shell, sqrt(half_chord_squared));
        }
    }
    let mut length = distance_to_top(shell, inside.altitude, inside.mu);
    let r = shell.ground_radius + inside.altitude;
    let above_ground_squared = inside.altitude * (shell.ground_radius + r);
    let discriminant = r * r * inside.mu * inside.mu - above_ground_squared;
    if (inside.mu < 0.0) & (discriminant >= 0.0) {
        length = above_ground_squared / (safe_sqrt(discriminant) - r * inside.mu);
    }
    if missed {
        length = 0.0;
    }
    (inside, length)
}

/// The part of the ray that lies in the planet's shadow, the half cylinder, or cone, behind the planet along the sun's
/// direction.
///
/// The distance of a point from the shadow's axis, squared, less the cone's radius there, squared, is `A s² + 2 B s +
/// C` with `q = R + offset + slope r μ_s`, `A = 1 - ν² - slope² ν²`, `B = r (μ - μ_s ν) - slope q ν` and `C = r² (1 -
/// μ_s²) - q² = h (2R + h) - (r μ_s)² - (q² - R²)`. The roots are the ends of the interval. A straight line that misses
/// the planet cannot pass from its lit side to its shadow inside the cylinder, so one look at the side on which the
/// interval begins decides. Towards the sun and away from it a line leaves a cone, or enters it, once.
#[inline(always)]
pub fn shadow(shell: Shell, ray: Ray) -> Interval {
    let r = shell.ground_radius + ray.altitude;
    let Shadow { offset, slope, begin } = shell.shadow;
    let wider = offset + slope * r * ray.mu_s;
    let radius = shell.ground_radius + wider;
    let curvature = ray.one_minus_nu_squared - slope * slope * ray.nu * ray.nu;
    let a = max(curvature, 1e-12);
    let b = r * ray.mu_across_sun - slope * radius * ray.nu;
    let above_ground = ray.altitude * (shell.ground_radius + r) - r * r * ray.mu_s * ray.mu_s;
    let c = above_ground - wider * (shell.ground_radius + radius);
    let discriminant = b * b - if slope > 0.0 { curvature } else { a } * c;
    let root = safe_sqrt(discriminant);
    // The two forms of each root; the one that adds numbers of the same sign keeps its digits.
    let near = if b > 0.0 { -(b + root) / a } else { c / max(root - b, 1e-30) };
    let far = if b > 0.0 { -c / (b + root) } else { (root - b) / a };
    let start = max(near, 0.0);
    let behind = r * ray.mu_s + start * ray.nu < -begin;
    if (discriminant > 0.0) & (far > start) & behind {
        Interval { start, end: far }
    } else {
        Interval { start: 0.0, end: 0.0 }
    }
}

/// Altitude (km) of the end of a lit stretch on the planet's shadow or on the ground, at distance `s` (km) along the
/// ray; `by_distance` is what that distance has for it.
///
/// Behind the terminator the shadow's edge is as far from its axis as the cone is wide: `r_s c = R + offset + slope r_s
/// m`, with `m` the cosine of the zenith angle of the sun there and `c = √(1 - m²)`, so that `h = (R (m² / (1 + c) +
/// slope m) + offset) / (c - slope m)`. Near the terminator that keeps the metres that the distance of an observer far
/// above has lost, with which the edge may also be rounded to the ground. The error of the distance weighs `s |μ|`,
/// that of `m` at most `(r_s |m| + s) |m|`; what weighs less is taken.
#[inline(always)]
pub fn altitude_of_lit_end(shell: Shell, ray: Ray, s: f32, by_distance: f32) -> f32 {
    let r_at_s = shell.ground_radius + by_distance;
    let m = ((shell.ground_radius + ray.altitude) * ray.mu_s + s * ray.nu) / r_at_s;
    let cosine = safe_sqrt(1.0 - m * m);
    let Shadow { offset, slope, .. } = shell.shadow;
    let above = shell.ground_radius * (m * m / (1.0 + cosine) + slope * m) + offset;
    let edge = max(above / (cosine - slope * m), 0.0);
    let edge_weighs_less = (r_at_s * abs(m) + s) * abs(m) < s * abs(ray.mu);
    if (m < 0.0) & edge_weighs_less { edge } else { by_distance }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EARTH: Shell = Shell { ground_radius: 6360.0, depth: 100.0, shadow: STRAIGHT };
    const STRAIGHT: Shadow = Shadow { offset: 0.0, slope: 0.0, begin: 0.0 };

    fn direction(elevation: f32, azimuth: f32) -> Vec3 {
        let (sin_elevation, cos_elevation) = f64::from(elevation).to_radians().sin_cos();
        let (sin_azimuth, cos_azimuth) = f64::from(azimuth).to_radians().sin_cos();
        let level = [cos_elevation * cos_azimuth, -cos_elevation * sin_azimuth];
        Vec3::new(level[0] as f32, level[1] as f32, sin_elevation as f32)
    }

    #[test]
    fn altitude_keeps_its_digits_at_planet_scale() {
        let ray = Ray::new(0.002, direction(0.1, 0.0), direction(30.0, 0.0));
        for s in [0.001f32, 0.1, 1.0, 10.0, 300.0] {
            let (r, mu, s64) = (6360.0 + f64::from(ray.altitude), f64::from(ray.mu), f64::from(s));
            let truth = (r * r + s64 * s64 + 2.0 * r * mu * s64).sqrt() - 6360.0;
            let error = (f64::from(altitude_along(EARTH, ray, s)) - truth).abs();
            // Four roundings of terms no larger than the result.
            assert!(error <= 4e-7 * truth.max(1e-6), "s = {s}: {error:e} of {truth}");
        }
    }

    #[test]
    fn a_level_ray_has_its_perigee_at_its_origin() {
        assert_eq!(perigee_altitude(EARTH, 3.0, 0.0), 3.0);
        assert!(perigee_altitude(EARTH, 3.0, -0.5) < 0.0);
    }

    #[test]
    fn the_shadow_at_the_zenith_ends_at_the_height_of_the_last_ray() {
        let ray = Ray::new(0.0, direction(90.0, 0.0), direction(-4.0, 0.0));
        let height = 6360.0 * (1.0 / 4f64.to_radians().cos() - 1.0);
        let shadow = shadow(EARTH, ray);
        assert_eq!(shadow.start, 0.0);
        // The sine of 4° is known to 1 part in 2e7 and enters squared.
        assert!((f64::from(shadow.end) / height - 1.0).abs() < 1e-5, "{} {height}", shadow.end);
    }

    #[test]
    fn by_day_no_ray_from_the_ground_meets_the_shadow() {
        for elevation in [0.01, 1.0, 10.0, 90.0] {
            for azimuth in [0.0, 60.0, 120.0, 180.0] {
                for sun in [0.01, 5.0, 90.0] {
                    let ray = Ray::new(0.0, direction(elevation, azimuth), direction(sun, 0.0));
                    let (inside, length) = inside_atmosphere(EARTH, ray);
                    let shadow = shadow(EARTH, inside);
                    assert!(shadow.end <= shadow.start || shadow.start >= length, "{elevation} {azimuth} {sun}");
                }
            }
        }
    }

    #[test]
    fn a_ray_from_orbit_enters_at_the_top_and_ends_on_the_ground() {
        let (inside, length) = inside_atmosphere(EARTH, Ray::new(1000.0, direction(-90.0, 0.0), direction(45.0, 0.0)));
        assert_eq!(inside.altitude, 100.0);
        assert!((length - 100.0).abs() < 1e-3, "{length}");
        let (_, length) = inside_atmosphere(EARTH, Ray::new(1000.0, direction(10.0, 0.0), direction(45.0, 0.0)));
        assert_eq!(length, 0.0);
    }

    #[test]
    fn the_distance_to_the_top_is_the_vertical_depth_overhead() {
        assert!((distance_to_top(EARTH, 25.0, 1.0) - 75.0).abs() < 1e-4);
        let level = f64::sqrt(6460.0 * 6460.0 - 6360.0 * 6360.0);
        assert!((f64::from(distance_to_top(EARTH, 0.0, 0.0)) - level).abs() < 1e-3);
    }
}
