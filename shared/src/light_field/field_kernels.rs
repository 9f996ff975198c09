//! The light field on a device: what each of its kernels does for one index.
//!
//! The theory is that of `multiple`, which computes the same on a processor, a tile of suns at a time. Here an invocation has one value, for a group of four
//! bands, and the steps follow each other as dispatches:
//!
//! | kernel | of each | computes |
//! | --- | --- | --- |
//! | `field_nodes` | sample of a ray | what every sun and azimuth share: air, aerosol, the place between altitudes |
//! | `field_functions` | ray, and sun | the spherical functions of its direction |
//! | `field_phases` | ray, sun and azimuthal number | the phase functions' coefficient |
//! | `field_first` | sight of a ray | the sun's light, scattered once or reflected; of a listed ray, for the fit to learn from, without what the ground reflects |
//! | `field_first_fourier` | ray, sun and azimuthal number | its coefficient, after the phase functions |
//! | `field_sources` | sample of a ray, and sun | the source that an order of the light field makes |
//! | `field_gather` | sight of a ray | the light gathered from the sources |
//! | `field_fourier` | ray, sun and azimuthal number | the coefficient of what was gathered |
//! | `field_moments` | altitude, sun and moment | the moment of the order; and the irradiance of the ground |
//! | `field_sum` | altitude, sun and moment | the orders, each times its factor |
//!
//! A *sight* of a ray is a sun seen from its origin at an azimuth.

use crate::geometry::Ray;
use crate::glam::{Vec2, Vec3, Vec4};
use crate::light_field::field_uniform::{FieldBuffers, FieldUniform, OF_FIRST, OF_NODE, OF_ORIGIN, moments_of};
use crate::light_field::ground::{LAMBERT, direct_irradiance, ground_on_way};
use crate::light_field::moments::{Moments, Stencil, legendre};
use crate::light_field::rays::{
    NodePlace, PER_MEAN_FREE_PATH, PieceSamples, SMALLEST, Sample, Sight, SunPlace, between_logarithms,
    functions_of_air, lit_from_end_to_end, place_of_altitude,
};
use crate::light_field::source::{NodeMoments, size, source};
use crate::math::{PI, abs, acos, exp4, fetch, ln4, max, max4, safe_sqrt, store};
use crate::medium::bands::{Bands, ByScatterer};
use crate::medium::profile::{Atmosphere, column_densities, sun_column_densities};
use crate::path::single::{Way, single_scattering_placed_for};
use crate::value::Value;
use crate::variant;

/// A ray as the tables have it: altitude (km), the cosine and the sine of its zenith angle, weight.
#[inline(always)]
fn ray_of(uniform: &FieldUniform, tables: &[f32], ray: usize) -> Vec4 {
    four_of(tables, uniform.tables.rays as usize + 4 * ray)
}

#[inline(always)]
fn four_of(tables: &[f32], at: usize) -> Vec4 {
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
    let atmosphere = &uniform.atmosphere;
    let (ray_number, index) = (node / uniform.nodes_of_ray(), node % uniform.nodes_of_ray());
    let ray = ray_of(uniform, buffers.tables, ray_number);
    let in_plane = Ray::new(ray.x, Vec3::new(ray.z, 0.0, ray.y), Vec3::Z);
    let way = Way::new(atmosphere.shell(), in_plane, variant & !variant::SHADOW);
    if index == 0 {
        store_origin(uniform, buffers, values, ray_number, way, variant);
    }
    let rising = index >= uniform.samples as usize;
    let interval = way.lit(false, rising);
    let at = uniform.values.nodes as usize + OF_NODE * node;
    if interval.end > interval.start {
        let samples = PieceSamples::new(atmosphere, &uniform.placed_for, way, interval, rising, variant);
        let quadrature = fetch(buffers.quadrature, index % uniform.samples as usize);
        let sample = samples.at(atmosphere, quadrature, variant);
        let sine = safe_sqrt(1.0 - sample.mu * sample.mu);
        let place = place_of_altitude(atmosphere, uniform.thin_air, sample.altitude);
        let Stencil { first, weights } = uniform.altitude_axis(buffers.tables).stencil(place, 0);
        let radius = atmosphere.ground_radius + sample.altitude;
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
    let atmosphere = &uniform.atmosphere;
    let Vec4 { x: altitude, z: sine, .. } = ray_of(uniform, buffers.tables, ray);
    let ground = ground_on_way(atmosphere, way, variant);
    let radius = atmosphere.ground_radius + way.ray.altitude;
    // Where a ray from outside enters, it is as far from the planet's centre as anywhere else.
    let sine = sine * ((atmosphere.ground_radius + altitude) / radius);
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
fn scatterers_at(uniform: &FieldUniform, node: usize, group: usize) -> usize {
    uniform.values.scatterers as usize + 2 * (node * uniform.group_count() + group)
}

/// Where a node is; its radius is 0 for one of no ray.
#[inline(always)]
fn place_of_node(uniform: &FieldUniform, values: &[Vec4], node: usize) -> NodePlace {
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
fn sun_angle(uniform: &FieldUniform, tables: &[f32], sun: usize) -> Vec2 {
    let at = uniform.tables.sun_angles as usize + 2 * sun;
    Vec2::new(fetch(tables, at), fetch(tables, at + 1))
}

/// A ray's origin: its radius (km), the cosine and the sine of the zenith angle there, the distance of the ground (km).
#[inline(always)]
fn origin_of(uniform: &FieldUniform, values: &[Vec4], ray: usize) -> Vec4 {
    fetch(values, uniform.values.origins as usize + OF_ORIGIN * ray)
}

#[inline(always)]
fn meets_ground(uniform: &FieldUniform, values: &[Vec4], ray: usize) -> bool {
    fetch(values, uniform.values.origins as usize + OF_ORIGIN * ray + 1).x > 0.0
}

/// A sight of a ray of a table: a sun at one of the azimuths.
#[inline(always)]
fn table_sight(uniform: &FieldUniform, tables: &[f32], origin: Vec4, sight: usize) -> Sight {
    let azimuths = uniform.azimuths as usize;
    let (sun, azimuth) = (sight / azimuths, sight % azimuths);
    let angle = sun_angle(uniform, tables, sun);
    let cosine = fetch(tables, uniform.tables.azimuths as usize + azimuth);
    let near = if sun > 0 { sun - 1 } else { 0 };
    Sight { mu_s: angle.y, nu: origin.y * angle.y + origin.z * angle.x * cosine, near }
}

/// Kernel `field_first`: light of the first order at a group of bands in a sight of a table's ray, by its constituents before their phase functions; without
/// azimuths that of a listed ray, which is no table's and whose ground is left out.
#[inline(always)]
pub fn field_first(uniform: &FieldUniform, buffers: FieldBuffers<'_>, values: &mut [Vec4], index: usize, variant: u32) {
    let atmosphere = &uniform.atmosphere;
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
            let mu_s = mu_s_on_ground(atmosphere, origin, sight);
            let seen = fetch(values, uniform.values.grounds as usize + ray_number * uniform.group_count() + group);
            of_ground = direct_irradiance(atmosphere, &bands, mu_s, variant) * seen;
        }
    } else {
        ray = listed_ray(uniform, buffers.tables, place);
    }
    let light = if is_of_table && ((variant & variant::SHADOW == 0) || lit_from_end_to_end(atmosphere, ray)) {
        lit_ray(uniform, values, &bands, (ray_number, group), sight, variant)
    } else {
        let placed_for = &uniform.placed_for;
        let (quadrature, crowding) = (buffers.quadrature, PER_MEAN_FREE_PATH);
        single_scattering_placed_for(atmosphere, &bands.coefficients(), placed_for, crowding, quadrature, ray, variant)
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

/// Cosine of the zenith angle of a sight's sun where a ray meets the ground.
#[inline(always)]
fn mu_s_on_ground(atmosphere: &Atmosphere, origin: Vec4, sight: Sight) -> f32 {
    (origin.x * sight.mu_s + origin.w * sight.nu) / atmosphere.ground_radius
}

/// Light scattered once along a ray of a table that is lit from end to end, at a group of bands, of air and of aerosol before their phase functions.
#[inline(always)]
fn lit_ray(
    uniform: &FieldUniform,
    values: &[Vec4],
    bands: &Bands,
    (ray, group): (usize, usize),
    sight: Sight,
    variant: u32,
) -> ByScatterer<Vec4> {
    let atmosphere = &uniform.atmosphere;
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
            let outwards = column_densities(atmosphere, altitude, density, abs(mu_s), variant);
            let along = sun_column_densities(atmosphere, altitude, outwards, mu_s, variant);
            let sunlight = bands.coefficients().transmittance(along);
            let at = scatterers_at(uniform, node, group);
            air += fetch(values, at) * sunlight;
            aerosol += fetch(values, at + 1) * sunlight;
        }
        node += 1;
    }
    ByScatterer { air, aerosol }
}

/// Kernel `field_phases`: the coefficients of `cos(m φ)` of the phase functions of (air, aerosol, what has none) between a ray's direction and a sun's, by the
/// addition theorem.
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

/// Kernel `field_first_fourier`: the coefficient of `cos(n φ)` of the first order's light, after the phase functions, for a ray, a sun and a group of bands.
///
/// What was integrated at some azimuths is a sum of their multiples `cos(j φ)`. The phase functions are sums of `cos(m φ)` by the addition theorem, and the
/// integral over the circle of three cosines is left.
#[inline(always)]
pub fn field_first_fourier(uniform: &FieldUniform, tables: &[f32], values: &mut [Vec4], index: usize) {
    let groups = uniform.group_count();
    let numbers = uniform.first.y as usize + 1;
    let (place, group) = (index / groups, index % groups);
    let (under_sun, n) = (place / numbers, place % numbers);
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
        j += 1;
    }
    store(values, uniform.values.fourier as usize + index, coefficient);
}

/// What the value at an azimuth adds to the amplitude of `cos(j φ)`.
#[inline(always)]
fn amplitude(uniform: &FieldUniform, tables: &[f32], j: usize, azimuth: usize) -> f32 {
    let azimuths = uniform.azimuths as usize;
    fetch(tables, uniform.tables.azimuths as usize + azimuths * (1 + j) + azimuth)
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

/// The moments of an order under a sun at a group of bands, between the altitudes of a node, and the node's functions.
struct MomentsOfOrder<'a> {
    orders: &'a [Vec4],
    /// Where the moments at the first altitude begin.
    first: usize,
    altitude_step: usize,
    moment_step: usize,
    weights: Vec4,
    functions: &'a [f32],
    first_function: usize,
    known: Moments,
}

impl NodeMoments<Vec4> for MomentsOfOrder<'_> {
    #[inline(always)]
    fn moment(&self, number: usize) -> Vec4 {
        let (at, step) = (self.first + number * self.moment_step, self.altitude_step);
        fetch(self.orders, at) * self.weights.x
            + fetch(self.orders, at + step) * self.weights.y
            + fetch(self.orders, at + 2 * step) * self.weights.z
            + fetch(self.orders, at + 3 * step) * self.weights.w
    }

    #[inline(always)]
    fn function(&self, m: usize, behind: usize) -> f32 {
        fetch(self.functions, self.first_function + self.known.first(m) + behind)
    }
}

/// Kernel `field_sources`: the source at a node of a ray towards its origin, under a sun and for each azimuthal number: `Σ_l χ_l L_lm N_lm P_l^m`; where what
/// lies between suns is interpolated by logarithms, relative to its size, whose logarithm follows.
#[inline(always)]
pub fn field_source(
    uniform: &FieldUniform,
    functions: &[f32],
    values: &mut [Vec4],
    orders: &[Vec4],
    index: usize,
    variant: u32,
) {
    let (groups, suns) = (uniform.group_count(), uniform.suns as usize);
    let (place, group) = (index / groups, index % groups);
    let (node, sun) = (place / suns, place % suns);
    let at = uniform.values.nodes as usize + OF_NODE * node;
    if fetch(values, at).w > 0.0 {
        let functions_of_air = fetch(values, at + 2);
        let (taken, last) = (moments_of(uniform.taken), moments_of(uniform.last));
        let of_sun = last.count() * groups;
        let first_altitude = fetch(values, at + 3).w as usize;
        let known = moments_of(uniform.at_nodes);
        let moments = MomentsOfOrder {
            orders,
            first: uniform.kept.last as usize + (first_altitude * suns + sun) * of_sun + group,
            altitude_step: suns * of_sun,
            moment_step: groups,
            weights: fetch(values, at + 1),
            functions,
            first_function: uniform.values.node_functions as usize + node * known.count(),
            known,
        };
        let at = scatterers_at(uniform, node, group);
        let scatterers = ByScatterer { air: fetch(values, at), aerosol: fetch(values, at + 1) };
        let has_aerosol = variant & variant::AEROSOL != 0;
        let to = uniform.source(node, sun, group);
        let mut magnitudes = Vec4::ZERO;
        let mut m = 0;
        while m <= taken.azimuthal {
            let source = source(&moments, last, (taken.degree, m), functions_of_air, &scatterers, has_aerosol);
            store(values, to + m * groups, source);
            magnitudes += source.magnitude();
            m += 1;
        }
        if uniform.logarithmic != 0 {
            let size = size(&magnitudes, &scatterers);
            let inverse = Vec4::ONE / size;
            m = 0;
            while m <= taken.azimuthal {
                let source = fetch(values, to + m * groups);
                store(values, to + m * groups, source * inverse);
                m += 1;
            }
            store(values, to + m * groups, ln4(size));
        }
    }
}

/// Kernel `field_gather`: the light that is gathered in a sight of a ray at a group of bands, with that of the ground for a ray of a table; for an observer's
/// the irradiance of the ground stands beside it.
#[inline(always)]
pub fn field_gather(uniform: &FieldUniform, tables: &[f32], values: &mut [Vec4], orders: &[Vec4], index: usize) {
    let groups = uniform.group_count();
    let (place, group) = (index / groups, index % groups);
    let (ray, number) = (place / uniform.sights as usize, place % uniform.sights as usize);
    let origin = origin_of(uniform, values, ray);
    let is_of_table = uniform.azimuths > 0;
    let sight = if is_of_table {
        table_sight(uniform, tables, origin, number)
    } else {
        let at = uniform.tables.sights as usize + 2 * place;
        Sight { mu_s: fetch(tables, at), nu: fetch(tables, at + 1), near: uniform.suns as usize / 2 }
    };
    let axis = uniform.sun_axis(tables);
    let mut light = Vec4::ZERO;
    let mut node = ray * uniform.nodes_of_ray();
    let end = node + uniform.nodes_of_ray();
    while node < end {
        let there = place_of_node(uniform, values, node);
        if there.radius > 0.0 {
            let SunPlace { suns, cosine } = there.sun(axis, origin.x, sight);
            light += light_of_node(uniform, values, (node, group), suns, cosine);
        }
        node += 1;
    }
    let mut irradiance = Vec4::ZERO;
    if meets_ground(uniform, values, ray) {
        let Stencil { first, weights } =
            axis.stencil(acos(mu_s_on_ground(&uniform.atmosphere, origin, sight)), sight.near);
        let from = uniform.irradiance(uniform.kept.last, uniform.last) + first * groups + group;
        let (a, b) = (fetch(orders, from), fetch(orders, from + groups));
        let (c, d) = (fetch(orders, from + 2 * groups), fetch(orders, from + 3 * groups));
        // As the size of a source: where the sun sets the ground's light falls by powers of ten from sun to sun.
        irradiance = if uniform.logarithmic != 0 {
            let least = SMALLEST[1];
            let four = [ln4(max4(a, least)), ln4(max4(b, least)), ln4(max4(c, least)), ln4(max4(d, least))];
            exp4(between_logarithms_of_four(four, weights))
        } else {
            a * weights[0] + b * weights[1] + c * weights[2] + d * weights[3]
        };
        if is_of_table {
            light += irradiance * fetch(values, uniform.values.grounds as usize + ray * groups + group);
        }
    }
    if is_of_table {
        store(values, uniform.values.light as usize + index, light);
    } else {
        store(values, uniform.values.light as usize + 2 * index, light);
        store(values, uniform.values.light as usize + 2 * index + 1, irradiance);
    }
}

/// The light that the sources of a node send under a sun between four: `Σ_m S_m cos(m φ)`.
#[inline(always)]
fn light_of_node(
    uniform: &FieldUniform,
    values: &[Vec4],
    (node, group): (usize, usize),
    suns: Stencil,
    cosine: f32,
) -> Vec4 {
    let groups = uniform.group_count();
    let numbers = uniform.taken.y as usize + 1;
    let step = (numbers + 1) * groups;
    let weights = suns.weights;
    let first = uniform.source(node, suns.first, group);
    let mut sum = Vec4::ZERO;
    // cos((m + 1) φ) = 2 cos φ cos(m φ) - cos((m - 1) φ)
    let (mut before, mut value) = (cosine, 1.0);
    let mut m = 0;
    while m < numbers {
        let at = first + m * groups;
        let between = fetch(values, at) * weights[0]
            + fetch(values, at + step) * weights[1]
            + fetch(values, at + 2 * step) * weights[2]
            + fetch(values, at + 3 * step) * weights[3];
        sum += between * value;
        let next = 2.0 * cosine * value - before;
        before = value;
        value = next;
        m += 1;
    }
    if uniform.logarithmic != 0 {
        let at = first + numbers * groups;
        let four =
            [fetch(values, at), fetch(values, at + step), fetch(values, at + 2 * step), fetch(values, at + 3 * step)];
        sum *= exp4(between_logarithms_of_four(four, weights));
    }
    sum
}

/// [`between_logarithms`] at four bands.
#[inline(always)]
fn between_logarithms_of_four([a, b, c, d]: [Vec4; 4], weights: [f32; 4]) -> Vec4 {
    Vec4::new(
        between_logarithms([a.x, b.x, c.x, d.x], weights),
        between_logarithms([a.y, b.y, c.y, d.y], weights),
        between_logarithms([a.z, b.z, c.z, d.z], weights),
        between_logarithms([a.w, b.w, c.w, d.w], weights),
    )
}

/// Kernel `field_fourier`: the integral over the circle of the light that was gathered against `cos(m φ)`, for a ray, a sun and a group of bands.
#[inline(always)]
pub fn field_fourier(uniform: &FieldUniform, tables: &[f32], values: &mut [Vec4], index: usize) {
    let groups = uniform.group_count();
    let numbers = uniform.of.y as usize + 1;
    let (place, group) = (index / groups, index % groups);
    let (under_sun, m) = (place / numbers, place % numbers);
    let azimuths = uniform.azimuths as usize;
    let around = if m == 0 { 2.0 * PI } else { PI };
    let mut coefficient = Vec4::ZERO;
    let mut azimuth = 0;
    while azimuth < azimuths {
        let at = uniform.values.light as usize + (under_sun * azimuths + azimuth) * groups + group;
        coefficient += fetch(values, at) * (around * amplitude(uniform, tables, m, azimuth));
        azimuth += 1;
    }
    store(values, uniform.values.fourier as usize + index, coefficient);
}

/// Kernel `field_moments`: a moment of an order at an altitude, under a sun and at a group of bands; after those of all altitudes the irradiance of the
/// ground.
#[inline(always)]
pub fn field_moment(
    uniform: &FieldUniform,
    tables: &[f32],
    functions: &[f32],
    values: &[Vec4],
    orders: &mut [Vec4],
    index: usize,
) {
    let (groups, suns) = (uniform.group_count(), uniform.suns as usize);
    let (of, first) = (moments_of(uniform.of), moments_of(uniform.first));
    let (place, group) = (index / groups, index % groups);
    let (under_sun, moment) = (place / of.count(), place % of.count());
    let (mut altitude, mut sun) = (under_sun / suns, under_sun % suns);
    let is_irradiance = altitude >= uniform.altitudes as usize;
    if is_irradiance {
        altitude = 0;
        sun = place - uniform.altitudes as usize * suns * of.count();
    }
    let mut m = 0;
    while !is_irradiance & (moment >= of.first(m + 1)) {
        m += 1;
    }
    let function = first.first(m) + moment - of.first(m);
    let starts = uniform.tables.first_rays as usize;
    let mut ray = fetch(tables, starts + altitude) as usize;
    let end = fetch(tables, starts + altitude + 1) as usize;
    let mut sum = Vec4::ZERO;
    while ray < end {
        let of_ray = ray_of(uniform, tables, ray);
        let fourier = uniform.values.fourier as usize + ((ray * suns + sun) * (of.azimuthal + 1) + m) * groups + group;
        let weight = if is_irradiance {
            max(of_ray.y, 0.0)
        } else {
            fetch(functions, uniform.values.ray_functions as usize + ray * first.count() + function)
        };
        sum += fetch(values, fourier) * (weight * of_ray.w);
        ray += 1;
    }
    store(orders, uniform.kept.of as usize + index, sum);
    if !is_irradiance & (moment == 0) {
        store(orders, uniform.kept.means as usize + under_sun * groups + group, sum);
    }
}

/// Kernel `field_sum`: a moment, or the irradiance of the ground, of all orders, each times its factor.
#[inline(always)]
pub fn field_sum(uniform: &FieldUniform, tables: &[f32], orders: &mut [Vec4], index: usize) {
    let groups = uniform.group_count();
    let nodes = uniform.altitudes as usize * uniform.suns as usize;
    let (first, next, later) = (moments_of(uniform.first), moments_of(uniform.next), moments_of(uniform.later));
    let (place, group) = (index / groups, index % groups);
    let (node, moment) = (place / first.count(), place % first.count());
    let is_irradiance = node >= nodes;
    let mut m = 0;
    while !is_irradiance & (moment >= first.first(m + 1)) {
        m += 1;
    }
    let degree = m + moment - first.first(m);
    let mut sum = fetch(orders, uniform.kept.of as usize + index);
    let mut at = uniform.kept.last as usize;
    let mut order = 0;
    while order < uniform.orders as usize {
        // A choice between two places in memory is none that SPIR-V has: each number is chosen by itself.
        let of = Moments {
            degree: if order == 0 { next.degree } else { later.degree },
            azimuthal: if order == 0 { next.azimuthal } else { later.azimuthal },
        };
        let factor = four_of(tables, uniform.tables.factors as usize + 4 * (order * groups + group));
        if is_irradiance {
            let sun = place - nodes * first.count();
            sum += fetch(orders, at + (nodes * of.count() + sun) * groups + group) * factor;
        } else if (m <= of.azimuthal) & (degree <= of.degree) {
            sum += fetch(orders, at + (node * of.count() + of.first(m) + degree - m) * groups + group) * factor;
        }
        at += (nodes * of.count() + uniform.suns as usize) * groups;
        order += 1;
    }
    store(orders, uniform.kept.sum as usize + index, sum);
}
