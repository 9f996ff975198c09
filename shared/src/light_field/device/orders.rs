//! The orders after the first on a device.

use crate::glam::Vec4;
use crate::light_field::device::nodes::{
    amplitude, four_of, meets_ground, mu_s_on_ground, origin_of, place_of_node, ray_of, scatterers_at, table_sight,
};
use crate::light_field::device::uniform::{FieldUniform, OF_NODE, moments_of};
use crate::light_field::moments::{Moments, Stencil};
use crate::light_field::rays::{SMALLEST, Sight, SunPlace, between_logarithms};
use crate::light_field::source::{NodeMoments, size, source};
use crate::math::{PI, acos, exp4, fetch, ln4, max, max4, store};
use crate::medium::bands::ByScatterer;
use crate::value::Value;
use crate::variant;

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

/// Kernel `field_sources`: the source at a node of a ray towards its origin, under a sun and for each azimuthal number:
/// `Σ_l χ_l L_lm N_lm P_l^m`; where what lies between suns is interpolated by logarithms, relative to its size, whose
/// logarithm follows.
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

/// Kernel `field_gather`: the light that is gathered in a sight of a ray at a group of bands, with that of the ground
/// for a ray of a table; for an observer's the irradiance of the ground stands beside it.
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

/// Kernel `field_fourier`: the integral over the circle of the light that was gathered against `cos(m φ)`, for a ray, a
/// sun and a group of bands.
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

/// Kernel `field_moments`: a moment of an order at an altitude, under a sun and at a group of bands; after those of all
/// altitudes the irradiance of the ground.
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
