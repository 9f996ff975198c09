//! What crosses the bus for the light field on a device, and where things lie in its memory.

use bytemuck::{Pod, Zeroable};

use crate::glam::{UVec2, Vec2, Vec4, Vec4Swizzles};
use crate::light_field::moments::{Axis, Moments};
#[cfg(doc)]
use crate::light_field::polarisation;
use crate::light_field::polarisation::Coupling;
use crate::medium::atmosphere::{Atmosphere, Medium};
use crate::medium::bands::{Bands, ByScatterer};

/// [`Moments`] from a uniform, where they are the highest degree and the highest azimuthal number.
#[inline(always)]
pub(crate) fn moments_of(of: UVec2) -> Moments {
    Moments { degree: of.x as usize, azimuthal: of.y as usize }
}

/// What every invocation of a kernel of the light field shares. The layout is that of a GPU uniform buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FieldUniform {
    /// Planet and profiles.
    pub atmosphere: Atmosphere,
    /// For which the samples of a ray are placed.
    pub placed_for: Bands,
    /// How scatterers couple the moments of polarised light: `γ` and `α` of air, then those of aerosol.
    pub couplings: Vec4,
    /// Moments, as their highest degree and azimuthal number: of the first order, and of the directions of rays and
    /// suns.
    pub first: UVec2,
    /// Moments of the second order.
    pub next: UVec2,
    /// Moments of the orders after it.
    pub later: UVec2,
    /// Moments whose functions the nodes of the rays know.
    pub at_nodes: UVec2,
    /// Moments of the order that is gathered.
    pub last: UVec2,
    /// Those of them that are gathered.
    pub taken: UVec2,
    /// Moments of the order that is made.
    pub of: UVec2,
    /// Invocations of the dispatch.
    pub invocations: u32,
    /// Groups of four bands.
    pub groups: u32,
    /// Rays: those of a table, or of an observer.
    pub rays: u32,
    /// Samples on each of the two pieces of a ray.
    pub samples: u32,
    /// Altitudes of the table.
    pub altitudes: u32,
    /// Suns of the table.
    pub suns: u32,
    /// Sights of a ray.
    pub sights: u32,
    /// Azimuths of a ray of a table, whose sights are every sun at each of them; 0 for an observer's, whose sights are
    /// listed.
    pub azimuths: u32,
    /// 1 where what lies between suns is interpolated relative to its logarithm.
    pub logarithmic: u32,
    /// Orders that are summed.
    pub orders: u32,
    /// The share of altitudes for air of what is not for thin air; see [`crate::light_field::rays::place_of_altitude`].
    pub for_air: f32,
    /// The share of altitudes for thin air; see [`crate::light_field::rays::place_of_altitude`].
    pub thin_air: f32,
    /// `χ_2` of air.
    pub air: f32,
    /// Moments of polarised light of each node, behind those of radiance: [`polarisation::MOMENTS`], or none where
    /// light is taken as natural.
    pub polarised: u32,
    /// How many of them are gathered: all along the rays of a table, along an observer's where `Q` and `U` are asked
    /// for.
    pub gathered: u32,
    /// Unused; fills the last 16 bytes.
    pub padding0: u32,
    /// Unused, too.
    pub padding1: u32,
    /// Unused, too.
    pub padding2: u32,
    /// Where the lists begin that the host wrote.
    pub tables: Tables,
    /// Where things begin that kernels leave for each other.
    pub values: Values,
    /// Where the orders of the light field are.
    pub kept: Orders,
}

/// Where lists begin in [`FieldBuffers::tables`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Tables {
    /// The axis of altitudes; see [`Axis`].
    pub altitudes: u32,
    /// The axis of suns.
    pub suns: u32,
    /// Of each ray its altitude (km), the cosine and the sine of its zenith angle, and its part of the integral over
    /// the cosine.
    pub rays: u32,
    /// Of each altitude its first ray, and the end.
    pub first_rays: u32,
    /// Of each sun the sine and the cosine of its zenith angle.
    pub sun_angles: u32,
    /// Cosines of the azimuths, then what the value at each adds to the amplitudes of their multiples.
    pub azimuths: u32,
    /// `χ_l` of aerosol.
    pub aerosol: u32,
    /// Of each sight of an observer's rays the cosines of the sun's zenith angle and of its angle from the ray, or
    /// listed rays.
    pub sights: u32,
    /// Of each order and each band how much it counts; of polarised light for `E_20` as for radiance, then for `E_21`
    /// and for `E_22`.
    pub factors: u32,
    /// Unused; fills the last 16 bytes.
    pub padding0: u32,
    /// Unused, too.
    pub padding1: u32,
    /// Unused, too.
    pub padding2: u32,
}

/// Where things begin that kernels leave for each other: the first three in the functions, the others among the values.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Values {
    /// Functions of aerosol at each node.
    pub node_functions: u32,
    /// Functions of each ray's direction.
    pub ray_functions: u32,
    /// Functions of each sun's.
    pub sun_functions: u32,
    /// Of each node where it is, its place between altitudes, the functions of air, and what is there.
    pub nodes: u32,
    /// Of each node what air and aerosol scatter and is seen.
    pub scatterers: u32,
    /// Of each ray its origin, and the ground that it meets.
    pub origins: u32,
    /// Of each ray what an irradiance of 1 on that ground adds to it.
    pub grounds: u32,
    /// Sources.
    pub sources: u32,
    /// Light of each sight; of the first order by constituents, of an observer with the irradiance of the ground; then
    /// `Q` and `U` where they are gathered.
    pub light: u32,
    /// Those of the phase functions for each ray and sun.
    pub phases: u32,
    /// Coefficients of `cos(m φ)`.
    pub fourier: u32,
    /// Unused; fills the last 16 bytes.
    pub padding: u32,
}

/// Where the orders of a light field are, each with its moments, at each node those of polarised light last, and after
/// them the irradiance of the ground.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Orders {
    /// The one that is gathered.
    pub last: u32,
    /// The one that is made.
    pub of: u32,
    /// The mean radiances of the one that is made, then its `E_20`, `E_21` and `E_22`.
    pub means: u32,
    /// The sum.
    pub sum: u32,
}

/// What kernels of the light field read.
#[derive(Clone, Copy)]
pub struct FieldBuffers<'a> {
    /// Optical properties at the bands, four to a group.
    pub bands: &'a [Bands],
    /// Quadrature nodes: (place, weight) on [0, 1].
    pub quadrature: &'a [Vec2],
    /// Lists of numbers; see [`Tables`].
    pub tables: &'a [f32],
    /// The tables of the medium; see [`crate::medium::tables`].
    pub columns: &'a [Vec4],
}

impl<'a> FieldBuffers<'a> {
    /// What fills the air.
    #[inline(always)]
    pub(crate) fn medium(&self, uniform: &'a FieldUniform) -> Medium<'a> {
        Medium { atmosphere: &uniform.atmosphere, tables: self.columns }
    }
}

/// Values of a node but those of its bands.
pub(crate) const OF_NODE: usize = 4;
/// Values of a ray's origin.
pub(crate) const OF_ORIGIN: usize = 2;
/// Values of a sight's light of the first order: of air, of aerosol, of the ground.
pub const OF_FIRST: usize = 3;
/// Values of a sight's light of a later order along a ray of a table.
const OF_TABLE: usize = 1;
/// Those along a ray of an observer: with the irradiance of the ground.
pub const OF_OBSERVER: usize = 2;
/// `Q` and `U` behind them.
pub const OF_STOKES: usize = 2;

impl FieldUniform {
    #[inline(always)]
    pub(crate) fn group_count(&self) -> usize {
        self.groups as usize
    }

    #[inline(always)]
    pub(crate) fn nodes_of_ray(&self) -> usize {
        2 * self.samples as usize
    }

    #[inline(always)]
    pub(crate) fn sun_axis<'a>(&self, tables: &'a [f32]) -> Axis<'a> {
        Axis { values: tables, first: self.tables.suns as usize, count: self.suns as usize }
    }

    #[inline(always)]
    pub(crate) fn altitude_axis<'a>(&self, tables: &'a [f32]) -> Axis<'a> {
        Axis { values: tables, first: self.tables.altitudes as usize, count: self.altitudes as usize }
    }

    /// Moments of each node: those that are listed, and those of polarised light.
    #[inline(always)]
    pub(crate) fn of_node(&self, of: UVec2) -> usize {
        moments_of(of).count() + self.polarised as usize
    }

    /// How scatterers couple the moments of polarised light.
    #[inline(always)]
    pub(crate) fn coupling(&self) -> ByScatterer<Coupling> {
        let (air, aerosol) = (self.couplings.xy(), self.couplings.zw());
        let coupling = |of: Vec2| Coupling { gamma: of.x, alpha: of.y };
        ByScatterer { air: coupling(air), aerosol: coupling(aerosol) }
    }

    /// Values of a sight's light of the orders after the first.
    #[inline(always)]
    pub(crate) fn of_light(&self) -> usize {
        let of_radiance = if self.azimuths > 0 { OF_TABLE } else { OF_OBSERVER };
        if self.gathered > 0 { of_radiance + OF_STOKES } else { of_radiance }
    }

    /// Where the sources of a node under a sun begin: of radiance, of polarised light, then the logarithm of their
    /// size.
    #[inline(always)]
    pub(crate) fn source(&self, node: usize, sun: usize, group: usize) -> usize {
        let of_sun = (self.taken.y as usize + 2 + self.gathered as usize) * self.group_count();
        self.values.sources as usize + (node * self.suns as usize + sun) * of_sun + group
    }

    /// Where an order's irradiance of the ground begins, after its moments.
    #[inline(always)]
    pub(crate) fn irradiance(&self, order: u32, of: UVec2) -> usize {
        let moments = self.altitudes as usize * self.suns as usize * self.of_node(of);
        order as usize + moments * self.group_count()
    }
}
