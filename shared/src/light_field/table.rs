//! The table of a light field on a processor: its rays, their nodes, and the moments at altitudes and suns.

use crate::glam::{Vec2, Vec4};
use crate::light_field::moments::{Axis, Moments, Stencil};
use crate::light_field::polarisation::{self, Coupling};
use crate::light_field::rays::{NodePlace, SMALLEST, Sight, SunPlace, between_logarithms};
use crate::math::exp_lanes;
use crate::medium::bands::ByScatterer;
use crate::value::{Lanes, Value};

/// The values of four neighbours with the weights of a stencil.
#[inline(always)]
pub fn between<V: Value>(values: &[V], Stencil { first, weights }: Stencil) -> V {
    V::weighted(values[first], values[first + 1], values[first + 2], values[first + 3], weights)
}

/// The values whose four neighbours have these logarithms; see [`crate::light_field::rays::between_logarithms`].
#[inline(always)]
pub fn exp_between_logarithms<const N: usize>(logarithms: &[Lanes<N>], stencil: Stencil) -> Lanes<N> {
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| &logarithms[stencil.first + i].0);
    let mut between = Lanes::ZERO;
    for i in 0..N {
        between.0[i] = between_logarithms([a[i], b[i], c[i], d[i]], stencil.weights);
    }
    exp_lanes(&mut between.0);
    between
}

/// The logarithms of light, of which there is a least.
pub fn logarithms_of_light<V: Value>(light: &V) -> V {
    light.at_least_number(SMALLEST[1]).logarithm()
}

/// A node of a ray through a table: what every sun and every azimuth share.
#[derive(Clone, Copy)]
pub struct RayNode<const N: usize> {
    /// Where it is.
    pub place: NodePlace,
    /// Altitude (km).
    pub altitude: f32,
    /// Relative densities of (air, aerosol).
    pub density: Vec2,
    /// Its place between the altitudes of the table.
    pub altitudes: Stencil,
    /// `N_00 P_0^0`, then `χ_2 N_2m P_2^m` of air for `m = 0, 1, 2`, in the ray's direction there.
    pub air_functions: Vec4,
    /// What scatters there and is seen: `T β ρ` times the length that the node stands for.
    pub scatterers: ByScatterer<Lanes<N>>,
}

/// A ray through a table.
#[derive(Clone, Copy)]
pub struct TableRay<'a, const N: usize> {
    /// Distance of its origin from the planet's centre (km).
    pub radius: f32,
    /// Its nodes.
    pub nodes: &'a [RayNode<N>],
    /// For each node the functions `χ_l N_lm P_l^m` of aerosol in the ray's direction there, for the moments `of`;
    /// empty without aerosol.
    pub functions: &'a [f32],
    /// The moments of `functions`.
    pub of: Moments,
}

/// Lanes that are summed together: of so many a table stays in a processor's own cache, and the sources of a node in
/// its first one.
pub const TILE: usize = 16;

/// How the wavelengths of a light field lie in tiles of [`TILE`] lanes: so many wavelengths together, and as many suns,
/// or multiples of an azimuth, as fill the tile.
#[inline(always)]
pub const fn wavelengths_of_tile<const N: usize>() -> usize {
    if N < TILE { N } else { TILE }
}

/// Suns, or multiples of an azimuth, of a tile.
#[inline(always)]
pub const fn suns_of_tile<const N: usize>() -> usize {
    TILE / wavelengths_of_tile::<N>()
}

/// The moments of a light field at the altitudes and suns of a table.
#[derive(Clone, Copy)]
pub struct MomentTable<'a> {
    /// Which.
    pub moments: Moments,
    /// How scatterers couple the moments of polarised light, which stand behind the others; none of a table without.
    pub couplings: Option<ByScatterer<Coupling>>,
    /// The moments, tile after tile of the wavelengths: in each, altitude after altitude, all of the first suns that
    /// share a tile, then of the next.
    pub values: &'a [f32],
    /// Altitudes.
    pub altitudes: usize,
    /// Zenith angles of the suns (radians).
    pub suns: Axis<'a>,
    /// Whether what lies between suns is interpolated relative to its logarithm: where the sun sets, light falls by
    /// powers of ten.
    pub logarithmic: bool,
}

impl MomentTable<'_> {
    /// Moments of polarised light at a node.
    #[inline(always)]
    pub fn polarised(&self) -> usize {
        if self.couplings.is_some() { polarisation::MOMENTS } else { 0 }
    }
}

/// The suns of all sights at a node of a ray, where they stand among the suns of a table: appended by `visit`, in the
/// order of the sights.
#[inline(always)]
pub fn suns_along<const N: usize>(
    suns: Axis,
    ray: TableRay<N>,
    index: usize,
    sights: &[Sight],
    mut visit: impl FnMut(SunPlace),
) {
    for &sight in sights {
        visit(ray.nodes[index].place.sun(suns, ray.radius, sight));
    }
}
