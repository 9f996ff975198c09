//! Light of the first order on a device.

use crate::geometry::Ray;
use crate::glam::{Vec2, Vec3, Vec4};
use crate::light_field::device::nodes::{
    amplitude, meets_ground, mu_s_on_ground, origin_of, place_of_node, ray_of, scatterers_at, sun_angle, table_sight,
};
use crate::light_field::device::uniform::{FieldBuffers, FieldUniform, OF_FIRST, OF_NODE, moments_of};
use crate::light_field::polarisation::SpinFunctions;
use crate::light_field::rays::{Sight, functions_of_air};
use crate::math::{PI, fetch, safe_sqrt, store};
use crate::medium::atmosphere::Medium;
use crate::medium::bands::{Bands, ByScatterer};
use crate::medium::columns::sunlight_at;
use crate::path::ground::direct_irradiance;
use crate::path::pieces::{PER_MEAN_FREE_PATH_OF_ORDERS, lit_from_end_to_end};
use crate::path::single::{Nodes, single_scattering_placed_for};
use crate::variant;

/// Kernel `field_first`: light of the first order at a group of bands in a sight of a table's ray, by its constituents
/// before their phase functions; without azimuths that of a listed ray, which is no table's and whose ground is left
/// out.
#[inline(always)]
pub fn field_first(uniform: &FieldUniform, buffers: FieldBuffers<'_>, values: &mut [Vec4], index: usize, variant: u32) {
    let medium = buffers.medium(uniform);
    let (place, group) = (index / uniform.group_count(), index % uniform.group_count());
    let bands = fetch(buffers.bands, group);
    let is_of_table = uniform.azimuths > 0;
    let (mut ray_number, mut sight) = (0, Sight { mu_s: 0.0, nu: 0.0, near: 0 });
    let mut of_ground = Vec4::ZERO;
    let ray;
    if is_of_table {
        ray_number = place / uniform.sights as usize;
        let sight_number = place % uniform.sights as usize;
        let origin = origin_of(uniform, values, ray_number);
        sight = table_sight(uniform, buffers.tables, origin, sight_number);
        ray = table_ray(uniform, buffers.tables, ray_number, sight_number);
        if meets_ground(uniform, values, ray_number) {
            let mu_s = mu_s_on_ground(&uniform.atmosphere, origin, sight);
            let seen = fetch(values, uniform.values.grounds as usize + ray_number * uniform.group_count() + group);
            of_ground = direct_irradiance(medium, &bands.coefficients(), mu_s, variant) * seen;
        }
    } else {
        ray = listed_ray(uniform, buffers.tables, place);
    }
    let light = if is_of_table && ((variant & variant::SHADOW == 0) || lit_from_end_to_end(medium, ray, variant)) {
        lit_ray(uniform, medium, values, &bands, (ray_number, group), sight, variant)
    } else {
        let placed_for = &uniform.placed_for;
        let (nodes, crowding) = (Nodes::all(buffers.quadrature), PER_MEAN_FREE_PATH_OF_ORDERS);
        single_scattering_placed_for(medium, &bands.coefficients(), placed_for, crowding, nodes, ray, variant)
    };
    let at = uniform.values.light as usize + OF_FIRST * index;
    store(values, at, light.air);
    store(values, at + 1, light.aerosol);
    store(values, at + 2, of_ground);
}

/// A ray of a table, with the sun of a sight.
#[inline(always)]
fn table_ray(uniform: &FieldUniform, tables: &[f32], ray: usize, sight: usize) -> Ray {
    let azimuths = uniform.azimuths as usize;
    let of_ray = ray_of(uniform, tables, ray);
    let sun = sun_angle(uniform, tables, sight / azimuths);
    let cosine = fetch(tables, uniform.tables.azimuths as usize + sight % azimuths);
    let view = Vec3::new(of_ray.z * cosine, of_ray.z * safe_sqrt(1.0 - cosine * cosine), of_ray.y);
    Ray::new(of_ray.x, view, Vec3::new(sun.x, 0.0, sun.y))
}

/// Numbers of a listed ray: its altitude (km), its direction, that of the sun.
pub const OF_LISTED_RAY: usize = 7;

#[inline(always)]
fn listed_ray(uniform: &FieldUniform, tables: &[f32], ray: usize) -> Ray {
    let at = uniform.tables.sights as usize + OF_LISTED_RAY * ray;
    let vector = move |at: usize| Vec3::new(fetch(tables, at), fetch(tables, at + 1), fetch(tables, at + 2));
    Ray::new(fetch(tables, at), vector(at + 1), vector(at + 4))
}

/// Light scattered once along a ray of a table that is lit from end to end, at a group of bands, of air and of aerosol
/// before their phase functions.
#[inline(always)]
fn lit_ray(
    uniform: &FieldUniform,
    medium: Medium<'_>,
    values: &[Vec4],
    bands: &Bands,
    (ray, group): (usize, usize),
    sight: Sight,
    variant: u32,
) -> ByScatterer<Vec4> {
    let radius = origin_of(uniform, values, ray).x;
    let (mut air, mut aerosol) = (Vec4::ZERO, Vec4::ZERO);
    let mut node = ray * uniform.nodes_of_ray();
    let end = node + uniform.nodes_of_ray();
    while node < end {
        let place = place_of_node(uniform, values, node);
        if place.radius > 0.0 {
            let there = fetch(values, uniform.values.nodes as usize + OF_NODE * node + 3);
            let (altitude, density) = (there.x, Vec2::new(there.y, there.z));
            let mu_s = place.mu_s(radius, sight);
            let sunlight = sunlight_at(medium, altitude, density, mu_s, variant);
            let sunlight = bands.coefficients().transmittance(sunlight.along) * sunlight.spread;
            let at = scatterers_at(uniform, node, group);
            air += fetch(values, at) * sunlight;
            aerosol += fetch(values, at + 1) * sunlight;
        }
        node += 1;
    }
    ByScatterer { air, aerosol }
}

/// Kernel `field_phases`: the coefficients of `cos(m φ)` of the phase functions of (air, aerosol, what has none)
/// between a ray's direction and a sun's, by the addition theorem.
#[inline(always)]
pub fn field_phase(
    uniform: &FieldUniform,
    tables: &[f32],
    functions: &[f32],
    values: &mut [Vec4],
    index: usize,
    variant: u32,
) {
    let moments = moments_of(uniform.first);
    let suns = uniform.suns as usize;
    let (under_sun, m) = (index / (moments.azimuthal + 1), index % (moments.azimuthal + 1));
    let of_ray = uniform.values.ray_functions as usize + under_sun / suns * moments.count() + moments.first(m);
    let of_sun = uniform.values.sun_functions as usize + under_sun % suns * moments.count() + moments.first(m);
    let product = move |l: usize| fetch(functions, of_ray + l - m) * fetch(functions, of_sun + l - m);
    let mut phases = Vec4::new(0.0, 0.0, if m == 0 { 1.0 } else { 0.0 }, 0.0);
    if m == 0 {
        phases.x += product(0);
    }
    if m <= 2 {
        phases.x += uniform.air * product(2);
    }
    if variant & variant::AEROSOL != 0 {
        let mut l = m;
        while l <= moments.degree {
            phases.y += fetch(tables, uniform.tables.aerosol as usize + l) * product(l);
            l += 1;
        }
    }
    store(values, uniform.values.phases as usize + index, phases);
}

/// Kernel `field_first_fourier`: the coefficient of `cos(n φ)` of the first order's light, after the phase functions,
/// for a ray, a sun and a group of bands; then what the ray adds to `E_2n`.
///
/// What was integrated at some azimuths is a sum of their multiples `cos(j φ)`. The phase functions are sums of `cos(m
/// φ)` by the addition theorem, and the integral over the circle of three cosines is left.
#[inline(always)]
pub fn field_first_fourier(uniform: &FieldUniform, tables: &[f32], values: &mut [Vec4], index: usize) {
    let groups = uniform.group_count();
    let of_radiance = uniform.first.y as usize + 1;
    let numbers = of_radiance + uniform.polarised as usize;
    let (place, group) = (index / groups, index % groups);
    let (under_sun, n) = (place / numbers, place % numbers);
    let polarised = Polarised::new(uniform, tables, under_sun);
    let azimuths = uniform.azimuths as usize;
    let mut coefficient = Vec4::ZERO;
    let mut j = 0;
    while j < azimuths {
        let (mut air, mut aerosol, mut ground) = (Vec4::ZERO, Vec4::ZERO, Vec4::ZERO);
        let mut azimuth = 0;
        while azimuth < azimuths {
            let share = amplitude(uniform, tables, j, azimuth);
            let sight = under_sun * azimuths + azimuth;
            let at = uniform.values.light as usize + OF_FIRST * (sight * groups + group);
            air += fetch(values, at) * share;
            aerosol += fetch(values, at + 1) * share;
            ground += fetch(values, at + 2) * share;
            azimuth += 1;
        }
        if n < of_radiance {
            let difference = n.abs_diff(j);
            let mut both = phases(uniform, values, under_sun, difference) + phases(uniform, values, under_sun, n + j);
            if difference == 0 {
                both += phases(uniform, values, under_sun, 0);
            }
            if n + j == 0 {
                both += phases(uniform, values, under_sun, 0);
            }
            both *= 0.5 * PI;
            coefficient += air * both.x + aerosol * both.y + ground * both.z;
        } else {
            coefficient +=
                (air * polarised.gamma.x + aerosol * polarised.gamma.y) * polarised.share(n - of_radiance, j);
        }
        j += 1;
    }
    store(values, uniform.values.fourier as usize + index, coefficient);
}

/// Sunlight that is scattered once into a ray, as polarised light.
struct Polarised {
    spin: SpinFunctions,
    /// `Y_2m` of the sun.
    of_sun: Vec4,
    /// `γ` of air and of aerosol.
    gamma: Vec2,
}

impl Polarised {
    #[inline(always)]
    fn new(uniform: &FieldUniform, tables: &[f32], under_sun: usize) -> Self {
        let suns = uniform.suns as usize;
        let ray = ray_of(uniform, tables, under_sun / suns);
        let sun = sun_angle(uniform, tables, under_sun % suns);
        let ByScatterer { air, aerosol } = uniform.coupling();
        Self {
            spin: SpinFunctions::new(ray.y, ray.z),
            of_sun: functions_of_air(1.0, sun.y, sun.x),
            gamma: Vec2::new(air.gamma, aerosol.gamma),
        }
    }

    /// What light times `cos(j φ)` adds to `E_2n`, before `γ`.
    #[inline(always)]
    fn share(&self, n: usize, j: usize) -> f32 {
        self.spin.moment([self.of_sun.y, self.of_sun.z, self.of_sun.w], n, j)
    }
}

/// The coefficients of `cos(m φ)` of the phase functions that [`field_phase`] found.
#[inline(always)]
fn phases(uniform: &FieldUniform, values: &[Vec4], under_sun: usize, m: usize) -> Vec4 {
    let highest = uniform.first.y as usize;
    if m <= highest {
        fetch(values, uniform.values.phases as usize + under_sun * (highest + 1) + m)
    } else {
        Vec4::ZERO
    }
}
