//! Nodes and sights of a light field's rays, wherever it is computed.

use crate::glam::{Vec3, Vec4};
use crate::light_field::moments::{Axis, Stencil};
use crate::math::{PI, acos, clamp, exp, max, min, sqrt};
use crate::medium::atmosphere::Atmosphere;

/// An altitude (km) as a place along the axis of altitudes, in which a light field is interpolated: where it changes,
/// an altitude takes more room. By day it changes with the air above and below, in the scale heights of air and of
/// aerosol; in twilight what is lit is thin air, which has a larger share. `for_air` is the share for air of what is
/// not for thin air; aerosol has the rest.
#[inline(always)]
pub fn place_of_altitude(atmosphere: &Atmosphere, for_air: f32, thin_air: f32, altitude: f32) -> f32 {
    let air = for_air * (1.0 - exp(-altitude / atmosphere.air.scale_height));
    let aerosol = (1.0 - for_air) * (1.0 - exp(-altitude / atmosphere.aerosol.scale_height));
    (1.0 - thin_air) * (air + aerosol) + thin_air * sqrt(altitude / atmosphere.depth)
}

/// `N_00 P_0^0`, then `χ_2 N_2m P_2^m` of air for `m = 0, 1, 2`, in a direction: all that air scatters of a light
/// field.
#[inline(always)]
pub fn functions_of_air(chi: f32, mu: f32, sine: f32) -> Vec4 {
    let (zeroth, second) = (sqrt(0.25 / PI), chi * sqrt(1.25 / PI));
    let root3 = sqrt(3.0);
    let of_second = Vec3::new(1.5 * mu * mu - 0.5, root3 * mu * sine, 0.5 * root3 * sine * sine) * second;
    Vec4::new(zeroth, of_second.x, of_second.y, of_second.z)
}

/// The smallest size of a source relative to what scatters there, and the smallest at all: its inverse is finite in
/// single precision.
pub const SMALLEST: [f32; 2] = [1e-22, 1e-36];

/// A cubic between four logarithms. It may not leave their range: where they fall off a cliff it would explode.
#[inline(always)]
pub fn between_logarithms([a, b, c, d]: [f32; 4], [wa, wb, wc, wd]: [f32; 4]) -> f32 {
    let (low, high) = (min(min(a, b), min(c, d)), max(max(a, b), max(c, d)));
    min(max(a * wa + b * wb + c * wc + d * wd, low), high)
}

/// A sun as a ray's origin sees it.
#[derive(Clone, Copy)]
pub struct Sight {
    /// Cosine of the zenith angle of the sun at the ray's origin.
    pub mu_s: f32,
    /// Cosine of the angle between the ray and the sun.
    pub nu: f32,
    /// A sun of the table near it, where the search begins.
    pub near: usize,
}

/// A sun as a node of a ray sees it.
#[derive(Clone, Copy)]
pub struct SunPlace {
    /// Its place between the suns of the table.
    pub suns: Stencil,
    /// Cosine of its azimuth from the ray.
    pub cosine: f32,
}

/// Where a node of a ray is.
#[derive(Clone, Copy)]
pub struct NodePlace {
    /// Cosine of the zenith angle of the ray there.
    pub mu: f32,
    /// Its sine.
    pub sine: f32,
    /// Distance from the ray's origin (km).
    pub distance: f32,
    /// Distance from the planet's centre (km).
    pub radius: f32,
}

impl NodePlace {
    /// The sun of a sight there, among the suns of a table. The ray's origin is `radius` (km) from the planet's centre.
    #[inline(always)]
    pub fn sun(self, suns: Axis, radius: f32, sight: Sight) -> SunPlace {
        let mu_s = self.mu_s(radius, sight);
        let sine_s = sqrt(max(1.0 - mu_s * mu_s, 1e-12));
        let inverse_sine = if self.sine > 1e-6 { 1.0 / self.sine } else { 0.0 };
        let cosine = clamp((sight.nu - self.mu * mu_s) * inverse_sine / sine_s, -1.0, 1.0);
        SunPlace { suns: suns.stencil(acos(mu_s), sight.near), cosine }
    }

    /// The cosine of that sun's zenith angle there.
    #[inline(always)]
    pub fn mu_s(self, radius: f32, sight: Sight) -> f32 {
        clamp((radius * sight.mu_s + self.distance * sight.nu) / self.radius, -1.0, 1.0)
    }
}
