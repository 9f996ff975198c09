//! What the rays of a light field cross, on a device.

use crate::geometry::Ray;
use crate::glam::{Vec2, Vec3, Vec4};
use crate::light_field::device::uniform::{FieldBuffers, FieldUniform, OF_NODE, OF_ORIGIN, moments_of};
use crate::light_field::moments::{Stencil, legendre};
use crate::light_field::rays::{NodePlace, Sight, functions_of_air, place_of_altitude};
use crate::math::{fetch, safe_sqrt, store};
use crate::medium::atmosphere::Atmosphere;
use crate::medium::bands::{Bands, ByScatterer};
use crate::path::ground::{LAMBERT, ground_on_way};
use crate::path::pieces::{PieceSamples, Sample};
use crate::path::ray::Way;
use crate::variant;

/// A ray as the tables have it: altitude (km), the cosine and the sine of its zenith angle, weight.
#[inline(always)]
pub(crate) fn ray_of(uniform: &FieldUniform, tables: &[f32], ray: usize) -> Vec4 {
    four_of(tables, uniform.tables.rays as usize + 4 * ray)
}

#[inline(always)]
pub(crate) fn four_of(tables: &[f32], at: usize) -> Vec4 {
    Vec4::new(fetch(tables, at), fetch(tables, at + 1), fetch(tables, at + 2), fetch(tables, at + 3))
}

/// Kernel `field_nodes`: a node of a ray; with its first, the ray's origin and the ground that it meets.
#[inline(always)]
pub fn field_node(
    uniform: &FieldUniform,
    buffers: FieldBuffers<'_>,
    functions: &mut [f32],
    values: &mut [Vec4],
    node: usize,
    variant: u32,
) {
    let medium = buffers.medium(uniform);
    let (ray_number, index) = (node / uniform.nodes_of_ray(), node % uniform.nodes_of_ray());
    let ray = ray_of(uniform, buffers.tables, ray_number);
    let in_plane = Ray::new(ray.x, Vec3::new(ray.z, 0.0, ray.y), Vec3::Z);
    let way = Way::new(medium, in_plane, variant & !variant::SHADOW);
    if index == 0 {
        store_origin(uniform, buffers, values, ray_number, way, variant);
    }
    let rising = index >= uniform.samples as usize;
    let interval = way.lit(false, rising);
    let at = uniform.values.nodes as usize + OF_NODE * node;
    if interval.end > interval.start {
        let samples = PieceSamples::new(medium, &uniform.placed_for, way, interval, rising, variant);
        let quadrature = fetch(buffers.quadrature, index % uniform.samples as usize);
        let sample = samples.at(medium, quadrature, variant);
        let sine = safe_sqrt(1.0 - sample.mu * sample.mu);
        let place = place_of_altitude(medium.atmosphere, uniform.for_air, uniform.thin_air, sample.altitude);
        let Stencil { first, weights } = uniform.altitude_axis(buffers.tables).stencil(place, 0);
        let radius = medium.atmosphere.ground_radius + sample.altitude;
        store(values, at, Vec4::new(sample.mu, sine, sample.distance, radius));
        store(values, at + 1, Vec4::from_array(weights));
        store(values, at + 2, functions_of_air(uniform.air, sample.mu, sine));
        store(values, at + 3, Vec4::new(sample.altitude, sample.density.x, sample.density.y, first as f32));
        if variant & variant::AEROSOL != 0 {
            store_aerosol_functions(uniform, buffers.tables, functions, node, Vec2::new(sample.mu, sine));
        }
        store_scatterers(uniform, buffers.bands, values, node, sample);
    } else {
        // A node of no ray: its radius says so.
        store(values, at, Vec4::ZERO);
    }
}

#[inline(always)]
fn store_origin(
    uniform: &FieldUniform,
    buffers: FieldBuffers<'_>,
    values: &mut [Vec4],
    ray: usize,
    way: Way,
    variant: u32,
) {
    let medium = buffers.medium(uniform);
    let start = ray_of(uniform, buffers.tables, ray);
    let ground = ground_on_way(medium, way, variant);
    let radius = medium.atmosphere.ground_radius + way.ray.altitude;
    // Where a ray from outside enters, it is as far from the planet's centre as anywhere else.
    let sine = start.z * ((medium.atmosphere.ground_radius + start.x) / radius);
    let at = uniform.values.origins as usize + OF_ORIGIN * ray;
    let is_seen = if ground.is_seen { 1.0 } else { 0.0 };
    store(values, at, Vec4::new(radius, way.ray.mu, sine, ground.distance));
    store(values, at + 1, Vec4::new(is_seen, 0.0, 0.0, 0.0));
    let mut group = 0;
    while group < uniform.group_count() {
        let bands = fetch(buffers.bands, group);
        let seen = bands.coefficients().transmittance(ground.along) * bands.albedo * (LAMBERT * is_seen);
        store(values, uniform.values.grounds as usize + ray * uniform.group_count() + group, seen);
        group += 1;
    }
}

/// The functions of a node's direction times `χ_l`; `angle` is the cosine and the sine of its zenith angle.
#[inline(always)]
fn store_aerosol_functions(uniform: &FieldUniform, tables: &[f32], functions: &mut [f32], node: usize, angle: Vec2) {
    let moments = moments_of(uniform.at_nodes);
    let first = uniform.values.node_functions as usize + node * moments.count();
    legendre(moments, angle.x, angle.y, functions, first);
    let mut at = first;
    let mut m = 0;
    while m <= moments.azimuthal {
        let mut l = m;
        while l <= moments.degree {
            let chi = fetch(tables, uniform.tables.aerosol as usize + l);
            let function = fetch(functions, at);
            store(functions, at, function * chi);
            at += 1;
            l += 1;
        }
        m += 1;
    }
}

/// What air and aerosol of a node scatter and is seen: `T β ρ` times the length that it stands for.
#[inline(always)]
fn store_scatterers(uniform: &FieldUniform, bands: &[Bands], values: &mut [Vec4], node: usize, sample: Sample) {
    let mut group = 0;
    while group < uniform.group_count() {
        let bands = fetch(bands, group);
        let coefficients = bands.coefficients();
        let seen = coefficients.transmittance(sample.to_observer) * sample.weight;
        let ByScatterer { air, aerosol } = coefficients.scattered(&seen, sample.density);
        let at = scatterers_at(uniform, node, group);
        store(values, at, air);
        store(values, at + 1, aerosol);
        group += 1;
    }
}

#[inline(always)]
pub(crate) fn scatterers_at(uniform: &FieldUniform, node: usize, group: usize) -> usize {
    uniform.values.scatterers as usize + 2 * (node * uniform.group_count() + group)
}

/// Where a node is; its radius is 0 for one of no ray.
#[inline(always)]
pub(crate) fn place_of_node(uniform: &FieldUniform, values: &[Vec4], node: usize) -> NodePlace {
    let place = fetch(values, uniform.values.nodes as usize + OF_NODE * node);
    NodePlace { mu: place.x, sine: place.y, distance: place.z, radius: place.w }
}

/// Kernel `field_functions`: the spherical functions of a ray's direction or, after those of all rays, of a sun's.
#[inline(always)]
pub fn field_function(uniform: &FieldUniform, tables: &[f32], functions: &mut [f32], index: usize) {
    let moments = moments_of(uniform.first);
    let rays = uniform.rays as usize;
    if index < rays {
        let ray = ray_of(uniform, tables, index);
        let at = uniform.values.ray_functions as usize + index * moments.count();
        legendre(moments, ray.y, ray.z, functions, at);
    } else {
        let sun = index - rays;
        let angle = sun_angle(uniform, tables, sun);
        let at = uniform.values.sun_functions as usize + sun * moments.count();
        legendre(moments, angle.y, angle.x, functions, at);
    }
}

/// Sine and cosine of the zenith angle of a sun of the table.
#[inline(always)]
pub(crate) fn sun_angle(uniform: &FieldUniform, tables: &[f32], sun: usize) -> Vec2 {
    let at = uniform.tables.sun_angles as usize + 2 * sun;
    Vec2::new(fetch(tables, at), fetch(tables, at + 1))
}

/// A ray's origin: its radius (km), the cosine and the sine of the zenith angle there, the distance of the ground (km).
#[inline(always)]
pub(crate) fn origin_of(uniform: &FieldUniform, values: &[Vec4], ray: usize) -> Vec4 {
    fetch(values, uniform.values.origins as usize + OF_ORIGIN * ray)
}

#[inline(always)]
pub(crate) fn meets_ground(uniform: &FieldUniform, values: &[Vec4], ray: usize) -> bool {
    fetch(values, uniform.values.origins as usize + OF_ORIGIN * ray + 1).x > 0.0
}

/// A sight of a ray of a table: a sun at one of the azimuths.
#[inline(always)]
pub(crate) fn table_sight(uniform: &FieldUniform, tables: &[f32], origin: Vec4, sight: usize) -> Sight {
    let azimuths = uniform.azimuths as usize;
    let (sun, azimuth) = (sight / azimuths, sight % azimuths);
    let angle = sun_angle(uniform, tables, sun);
    let cosine = fetch(tables, uniform.tables.azimuths as usize + azimuth);
    let near = if sun > 0 { sun - 1 } else { 0 };
    Sight { mu_s: angle.y, nu: origin.y * angle.y + origin.z * angle.x * cosine, near }
}

/// Cosine of the zenith angle of a sight's sun where a ray meets the ground.
#[inline(always)]
pub(crate) fn mu_s_on_ground(atmosphere: &Atmosphere, origin: Vec4, sight: Sight) -> f32 {
    (origin.x * sight.mu_s + origin.w * sight.nu) / atmosphere.ground_radius
}

/// What the value at an azimuth adds to the amplitude of `cos(j φ)`.
#[inline(always)]
pub(crate) fn amplitude(uniform: &FieldUniform, tables: &[f32], j: usize, azimuth: usize) -> f32 {
    let azimuths = uniform.azimuths as usize;
    fetch(tables, uniform.tables.azimuths as usize + azimuths * (1 + j) + azimuth)
}
