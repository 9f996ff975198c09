//! The orders after the first on a device.

use crate::glam::Vec4;
use crate::light_field::device::nodes::{
    amplitude, four_of, meets_ground, mu_s_on_ground, origin_of, place_of_node, ray_of, scatterers_at, table_sight,
};
use crate::light_field::device::uniform::{FieldUniform, OF_NODE, moments_of};
use crate::light_field::moments::{Moments, Stencil};
use crate::light_field::polarisation::{SpinFunctions, number};
use crate::light_field::rays::{SMALLEST, Sight, SunPlace, between_logarithms, functions_of_air};
use crate::light_field::source::{NodeMoments, polarised_source, size, source};
use crate::math::{PI, acos, exp4, fetch, ln4, max, max4, safe_sqrt, store};
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
/// `Σ_l χ_l L_lm N_lm P_l^m`; then that of polarised light, where it is gathered; where what lies between suns is
/// interpolated by logarithms, both relative to the size of the first, whose logarithm follows.
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
        let of_air = fetch(values, at + 2);
        let place = fetch(values, at);
        let second = functions_of_air(1.0, place.x, place.y);
        let (taken, last) = (moments_of(uniform.taken), moments_of(uniform.last));
        let of_sun = uniform.of_node(uniform.last) * groups;
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
            let mut source = source(&moments, last, (taken.degree, m), of_air, &scatterers, has_aerosol);
            if (uniform.polarised > 0) & (m <= 2) {
                let function = number([second.y, second.z, second.w], m);
                let couplings = uniform.coupling();
                let [added, made] =
                    polarised_source(&moments, last, (m, function), &scatterers, couplings, has_aerosol);
                source += added;
                if uniform.gathered > 0 {
                    store(values, to + (taken.azimuthal + 1 + m) * groups, made);
                }
            }
            store(values, to + m * groups, source);
            magnitudes += source.magnitude();
            m += 1;
        }
        if uniform.logarithmic != 0 {
            let size = size(&magnitudes, &scatterers);
            let inverse = Vec4::ONE / size;
            m = 0;
            while m < taken.azimuthal + 1 + uniform.gathered as usize {
                let source = fetch(values, to + m * groups);
                store(values, to + m * groups, source * inverse);
                m += 1;
            }
            store(values, to + m * groups, ln4(size));
        }
    }
}

/// Kernel `field_gather`: the light that is gathered in a sight of a ray at a group of bands, with that of the ground
/// for a ray of a table; for an observer's the irradiance of the ground stands beside it. `Q` and `U` follow where they
/// are asked for.
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
    let (mut light, mut q, mut u) = (Vec4::ZERO, Vec4::ZERO, Vec4::ZERO);
    let mut node = ray * uniform.nodes_of_ray();
    let end = node + uniform.nodes_of_ray();
    while node < end {
        let there = place_of_node(uniform, values, node);
        if there.radius > 0.0 {
            let SunPlace { suns, cosine } = there.sun(axis, origin.x, sight);
            let scale = scale_of_node(uniform, values, (node, group), suns);
            light += light_of_node(uniform, values, (node, group), suns, cosine) * scale;
            if uniform.gathered > 0 {
                let spin = SpinFunctions::new(there.mu, there.sine);
                let [of_q, of_u] = stokes_of_node(uniform, values, (node, group), suns, cosine, spin);
                q += of_q * scale;
                u += of_u * scale;
            }
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
    let mut at = uniform.values.light as usize + uniform.of_light() * index;
    store(values, at, light);
    at += 1;
    if !is_of_table {
        store(values, at, irradiance);
        at += 1;
    }
    if uniform.gathered > 0 {
        store(values, at, q);
        store(values, at + 1, u);
    }
}

/// A source of a node between four suns.
#[inline(always)]
fn between_suns(values: &[Vec4], at: usize, step: usize, weights: [f32; 4]) -> Vec4 {
    fetch(values, at) * weights[0]
        + fetch(values, at + step) * weights[1]
        + fetch(values, at + 2 * step) * weights[2]
        + fetch(values, at + 3 * step) * weights[3]
}

/// The size that the sources of a node are relative to, between four suns.
#[inline(always)]
fn scale_of_node(uniform: &FieldUniform, values: &[Vec4], (node, group): (usize, usize), suns: Stencil) -> Vec4 {
    if uniform.logarithmic == 0 {
        return Vec4::ONE;
    }
    let groups = uniform.group_count();
    let numbers = uniform.taken.y as usize + 1 + uniform.gathered as usize;
    let (at, step) = (uniform.source(node, suns.first, group) + numbers * groups, (numbers + 1) * groups);
    let four =
        [fetch(values, at), fetch(values, at + step), fetch(values, at + 2 * step), fetch(values, at + 3 * step)];
    exp4(between_logarithms_of_four(four, suns.weights))
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
    let step = (numbers + 1 + uniform.gathered as usize) * groups;
    let first = uniform.source(node, suns.first, group);
    let mut sum = Vec4::ZERO;
    // cos((m + 1) φ) = 2 cos φ cos(m φ) - cos((m - 1) φ)
    let (mut before, mut value) = (cosine, 1.0);
    let mut m = 0;
    while m < numbers {
        sum += between_suns(values, first + m * groups, step, suns.weights) * value;
        let next = 2.0 * cosine * value - before;
        before = value;
        value = next;
        m += 1;
    }
    sum
}

/// `Q` and `U` likewise: `Σ_m W_m P_m cos(m φ)` and `Σ_m X_m P_m sin(m φ)`.
#[inline(always)]
fn stokes_of_node(
    uniform: &FieldUniform,
    values: &[Vec4],
    (node, group): (usize, usize),
    suns: Stencil,
    cosine: f32,
    spin: SpinFunctions,
) -> [Vec4; 2] {
    let groups = uniform.group_count();
    let numbers = uniform.taken.y as usize + 1;
    let step = (numbers + 1 + uniform.gathered as usize) * groups;
    let first = uniform.source(node, suns.first, group) + numbers * groups;
    let [of_q, of_u] = spin.at_azimuth(cosine, safe_sqrt(1.0 - cosine * cosine));
    let (mut q, mut u) = (Vec4::ZERO, Vec4::ZERO);
    let mut m = 0;
    while m <= 2 {
        let between = between_suns(values, first + m * groups, step, suns.weights);
        q += between * number(of_q, m);
        u += between * number(of_u, m);
        m += 1;
    }
    [q, u]
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
/// sun and a group of bands; then what its `Q` and `U` add to `E_2m`.
#[inline(always)]
pub fn field_fourier(uniform: &FieldUniform, tables: &[f32], values: &mut [Vec4], index: usize) {
    let groups = uniform.group_count();
    let of_radiance = uniform.of.y as usize + 1;
    let numbers = of_radiance + uniform.polarised as usize;
    let (place, group) = (index / groups, index % groups);
    let (under_sun, m) = (place / numbers, place % numbers);
    let azimuths = uniform.azimuths as usize;
    let around = if m == 0 { 2.0 * PI } else { PI };
    let ray = ray_of(uniform, tables, under_sun / uniform.suns as usize);
    let spin = SpinFunctions::new(ray.y, ray.z);
    let mut coefficient = Vec4::ZERO;
    let mut azimuth = 0;
    while azimuth < azimuths {
        let sight = (under_sun * azimuths + azimuth) * groups + group;
        let at = uniform.values.light as usize + uniform.of_light() * sight;
        if m < of_radiance {
            coefficient += fetch(values, at) * (around * amplitude(uniform, tables, m, azimuth));
        } else {
            let cosine = fetch(tables, uniform.tables.azimuths as usize + azimuth);
            let [of_q, of_u] = spin.at_azimuth(cosine, safe_sqrt(1.0 - cosine * cosine));
            let part = 2.0 * PI * amplitude(uniform, tables, 0, azimuth);
            let number_of = m - of_radiance;
            coefficient += (fetch(values, at + 1) * number(of_q, number_of)
                + fetch(values, at + 2) * number(of_u, number_of))
                * part;
        }
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
    let of_node = uniform.of_node(uniform.of);
    let nodes = uniform.altitudes as usize * suns;
    let (under_sun, moment) = (place / of_node, place % of_node);
    let (mut altitude, mut sun) = (under_sun / suns, under_sun % suns);
    let is_irradiance = under_sun >= nodes;
    if is_irradiance {
        altitude = 0;
        sun = place - nodes * of_node;
    }
    let is_polarised = !is_irradiance & (moment >= of.count());
    let mut m = 0;
    while !is_irradiance & !is_polarised & (moment >= of.first(m + 1)) {
        m += 1;
    }
    // Which coefficient of a ray, and which of its functions.
    let coefficient = if is_polarised { of.azimuthal + 1 + moment - of.count() } else { m };
    let function = if is_polarised { 0 } else { first.first(m) + moment - of.first(m) };
    let numbers = of.azimuthal + 1 + uniform.polarised as usize;
    let starts = uniform.tables.first_rays as usize;
    let mut ray = fetch(tables, starts + altitude) as usize;
    let end = fetch(tables, starts + altitude + 1) as usize;
    let mut sum = Vec4::ZERO;
    while ray < end {
        let of_ray = ray_of(uniform, tables, ray);
        let at = ((ray * suns + sun) * numbers + coefficient) * groups + group;
        let fourier = uniform.values.fourier as usize + at;
        let weight = if is_irradiance {
            max(of_ray.y, 0.0)
        } else if is_polarised {
            1.0
        } else {
            fetch(functions, uniform.values.ray_functions as usize + ray * first.count() + function)
        };
        sum += fetch(values, fourier) * (weight * of_ray.w);
        ray += 1;
    }
    store(orders, uniform.kept.of as usize + index, sum);
    if !is_irradiance & ((moment == 0) | is_polarised) {
        let kind = if is_polarised { 1 + moment - of.count() } else { 0 };
        store(orders, uniform.kept.means as usize + (kind * nodes + under_sun) * groups + group, sum);
    }
}

/// Kernel `field_sum`: a moment, or the irradiance of the ground, of all orders, each times its factor.
#[inline(always)]
pub fn field_sum(uniform: &FieldUniform, tables: &[f32], orders: &mut [Vec4], index: usize) {
    let groups = uniform.group_count();
    let nodes = uniform.altitudes as usize * uniform.suns as usize;
    let (first, next, later) = (moments_of(uniform.first), moments_of(uniform.next), moments_of(uniform.later));
    let (place, group) = (index / groups, index % groups);
    let polarised = uniform.polarised as usize;
    let of_node = first.count() + polarised;
    let (node, moment) = (place / of_node, place % of_node);
    let is_irradiance = node >= nodes;
    let is_polarised = !is_irradiance & (moment >= first.count());
    let mut m = 0;
    while !is_irradiance & !is_polarised & (moment >= first.first(m + 1)) {
        m += 1;
    }
    let degree = if is_polarised { 0 } else { m + moment - first.first(m) };
    // Whose factors: those of radiance and `E_20`, of `E_21` or of `E_22`.
    let kinds = if polarised > 0 { polarised } else { 1 };
    let kind = if is_polarised { moment - first.count() } else { 0 };
    let mut sum = fetch(orders, uniform.kept.of as usize + index);
    let mut at = uniform.kept.last as usize;
    let mut order = 0;
    while order < uniform.orders as usize {
        // A choice between two places in memory is none that SPIR-V has: each number is chosen by itself.
        let of = Moments {
            degree: if order == 0 { next.degree } else { later.degree },
            azimuthal: if order == 0 { next.azimuthal } else { later.azimuthal },
        };
        let of_node_there = of.count() + polarised;
        let factor = four_of(tables, uniform.tables.factors as usize + 4 * ((order * kinds + kind) * groups + group));
        if is_irradiance {
            let sun = place - nodes * of_node;
            sum += fetch(orders, at + (nodes * of_node_there + sun) * groups + group) * factor;
        } else if is_polarised {
            sum += fetch(orders, at + (node * of_node_there + of.count() + kind) * groups + group) * factor;
        } else if (m <= of.azimuthal) & (degree <= of.degree) {
            sum += fetch(orders, at + (node * of_node_there + of.first(m) + degree - m) * groups + group) * factor;
        }
        at += (nodes * of_node_there + uniform.suns as usize) * groups;
        order += 1;
    }
    store(orders, uniform.kept.sum as usize + index, sum);
}
