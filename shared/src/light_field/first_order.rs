//! Light of the first order along the rays of a light field, at the wavelengths that a processor computes together.

use crate::geometry::Ray;
use crate::glam::Vec2;
use crate::light_field::rays::Sight;
use crate::light_field::table::{RayNode, TableRay};
use crate::medium::atmosphere::Medium;
use crate::medium::bands::{Bands, ByScatterer, Coefficients};
use crate::medium::columns::sunlight_of_two;
use crate::medium::tables::Sunlight;
use crate::path::pieces::PER_MEAN_FREE_PATH_OF_ORDERS;
use crate::path::ray::Way;
use crate::path::single::{Nodes, single_scattering_on_way, single_scattering_placed_for};
use crate::value::{Lanes, Value};

/// The part of sunlight that reaches a node of a ray for two suns, by the cosines of their zenith angles there. Neither
/// may lie in the planet's shadow.
#[inline(always)]
fn transmitted_of_two<const N: usize>(
    medium: Medium<'_>,
    coefficients: &Coefficients<Lanes<N>>,
    node: &RayNode<N>,
    mu_s: Vec2,
    variant: u32,
) -> [Lanes<N>; 2] {
    sunlight_of_two(medium, node.altitude, node.density, mu_s, variant)
        .map(|Sunlight { along, spread }| coefficients.transmittance(along).scaled(spread))
}

/// Light scattered once along a ray of a table that is lit from end to end by two suns, of air and of aerosol, before
/// their phase functions.
#[cfg_attr(
    not(target_arch = "spirv"),
    multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))
)]
pub fn single_scattering_of_lit_ray<'a, const N: usize>(
    medium: Medium<'a>,
    coefficients: &Coefficients<Lanes<N>>,
    ray: TableRay<N>,
    sights: [Sight; 2],
    variant: u32,
) -> [ByScatterer<Lanes<N>>; 2] {
    let mut light = [ByScatterer::<Lanes<N>>::ZERO; 2];
    for node in ray.nodes {
        let [first, second] = sights;
        let mu_s = Vec2::new(node.place.mu_s(ray.radius, first), node.place.mu_s(ray.radius, second));
        let sunlight = transmitted_of_two(medium, coefficients, node, mu_s, variant);
        for (light, sunlight) in light.iter_mut().zip(&sunlight) {
            light.air.add_product(&node.scatterers.air, sunlight);
            light.aerosol.add_product(&node.scatterers.aerosol, sunlight);
        }
    }
    light
}

/// Light scattered once along a ray at some wavelengths, of air and of aerosol, before their phase functions: as
/// [`crate::path::single::single_scattering`], with the column densities of a sample made once for all of them. The
/// samples are placed for `bands`.
#[cfg_attr(
    not(target_arch = "spirv"),
    multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))
)]
pub fn single_scattering_of_many<'a, const N: usize>(
    medium: Medium<'a>,
    coefficients: &Coefficients<Lanes<N>>,
    bands: &Bands,
    quadrature: &[Vec2],
    ray: Ray,
    variant: u32,
) -> ByScatterer<Lanes<N>> {
    single_scattering_placed_for(
        medium,
        coefficients,
        bands,
        PER_MEAN_FREE_PATH_OF_ORDERS,
        Nodes::all(quadrature),
        ray,
        variant,
    )
}

/// The same of the part of a ray up to a distance (km) from its origin.
#[cfg_attr(
    not(target_arch = "spirv"),
    multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))
)]
pub fn single_scattering_until<'a, const N: usize>(
    medium: Medium<'a>,
    coefficients: &Coefficients<Lanes<N>>,
    bands: &Bands,
    quadrature: &[Vec2],
    (ray, distance): (Ray, f32),
    variant: u32,
) -> ByScatterer<Lanes<N>> {
    let way = Way::new(medium, ray, variant).until(medium.shell(), ray, distance);
    let placed_for = (bands, PER_MEAN_FREE_PATH_OF_ORDERS);
    single_scattering_on_way(medium, coefficients, placed_for, Nodes::all(quadrature), way, variant)
}
