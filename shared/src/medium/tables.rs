//! Densities and column densities of profiles that have no closed form, from tables.
//!
//! A table holds, over altitude and direction, the logarithms of column densities to the top of the atmosphere, and
//! beside them those of two gases. Between its entries they are straight lines over the altitude and cubics over the
//! direction. Altitudes crowd towards the ground, `h = depth (i / (N - 1))²`. One table is of straight view rays, by
//! the cosine `μ ≥ 0` of the zenith angle. The other is of sunlight, which may be bent, by the zenith angle of the sun
//! without air:
//!
//! ```text
//! x = (1 - μ) / (1 + K μ),   K = 0.45 √((R + h) / 16 km)        view rays: 0 at the zenith, 1 for a level ray
//! x = 1 - √(1 - z / z_max(h))                                   sunlight: z_max(h) is the zenith angle of the lowest sun that is seen
//! ```
//!
//! Light scattered once is right to 0.06 % by day and 1.1 % with the sun at -6°, against rays that march
//! (`tests/tests/sky/profile.rs`).
//!
//! Refraction spreads a beam: a bundle of sunlight has the irradiance `T F` of that above the air, with
//! `F = (sin z_a / sin z) dz_a/dz` and the zenith angle `z_a` at which the sun is seen. A sample of the integral takes
//! irradiance, so that `F` stands beside the column densities.

use crate::geometry::Shadow;
use crate::glam::{Vec2, Vec4};
use crate::interpolation::cubic::{Stencil, stencil};
use crate::math::{acos, exp4, fetch, max, min, sqrt};
use crate::medium::atmosphere::{ColumnDensities, Medium};

/// Altitudes of the tables.
pub const ALTITUDES: usize = 128;
/// Directions of the table of view rays, between which logarithms are cubics.
pub const VIEWS: usize = 64;
/// Directions of the table of sunlight, likewise: beside the lowest sun the spread of a beam changes fast.
pub const SUNS: usize = 128;
/// Where the table of view rays begins: before it stand, of each altitude, the logarithms of the relative densities of
/// (air, aerosol, ozone), and the zenith angle of the lowest sun that is seen (radians).
pub const VIEW: usize = ALTITUDES;
/// Where the table of sunlight begins, whose fourth numbers are `F`.
pub const SUN: usize = VIEW + ALTITUDES * VIEWS;
/// Where the cosines of the zenith angles begin at which the sun is seen from the ground, by the directions of
/// sunlight.
pub const SEEN: usize = SUN + ALTITUDES * SUNS;
/// Where the cones begin that the planet's shadow is at each altitude: offset (km) and slope; see [`Shadow`].
pub const EDGE: usize = SEEN + SUNS;
/// Where, altitude by altitude, the relative densities of (pairs of oxygen, water vapour) begin, per km and relative to
/// the columns over the ground.
pub const GASES: usize = EDGE + ALTITUDES;
/// Where the table of gases on view rays begins: logarithms of the amounts of both in a direction, and in the next.
/// They are straight lines over the direction, since so little light is lost to them.
pub const VIEW_GASES: usize = GASES + ALTITUDES;
/// Where that of gases on sunlight begins.
pub const SUN_GASES: usize = VIEW_GASES + ALTITUDES * VIEWS;
/// Entries of all.
pub const ENTRIES: usize = SUN_GASES + ALTITUDES * SUNS;

/// `K²` of the axis of view rays by the distance from the planet's centre (km⁻¹): `0.45² / (2 · 8 km)`.
pub const AXIS_SPREAD: f32 = 0.2025 / 16.0;

/// A place between two entries.
#[derive(Clone, Copy)]
struct Place {
    first: usize,
    part: f32,
}

impl Place {
    /// That of a number in [0, 1] along an axis of so many entries.
    #[inline(always)]
    fn new(along: f32, entries: usize) -> Self {
        let place = along * (entries - 1) as f32;
        let first = min(max(place, 0.0), (entries - 2) as f32) as u32;
        Self { first: first as usize, part: min(max(place - first as f32, 0.0), 1.0) }
    }

    #[inline(always)]
    fn between(self, a: Vec4, b: Vec4) -> Vec4 {
        a + (b - a) * self.part
    }
}

/// Between two altitudes a logarithm is a straight line over the altitude itself.
#[inline(always)]
fn place_of_altitude(medium: Medium<'_>, altitude: f32) -> Place {
    const LAST: f32 = (ALTITUDES - 1) as f32;
    let scaled = max(altitude, 0.0) * (LAST * LAST / medium.atmosphere.depth);
    let first = min(sqrt(scaled), LAST - 1.0) as u32;
    let below = first as f32;
    let part = (scaled - below * below) / (2.0 * below + 1.0);
    Place { first: first as usize, part: min(max(part, 0.0), 1.0) }
}

/// Between two altitudes angles are straight lines over the altitude's root.
#[inline(always)]
fn place_of_root(medium: Medium<'_>, altitude: f32) -> Place {
    Place::new(sqrt(max(altitude, 0.0) / medium.atmosphere.depth), ALTITUDES)
}

/// The planet's shadow about an altitude (km) on its edge: the cone that the edge touches there.
#[inline(always)]
pub fn shadow_at(medium: Medium<'_>, altitude: f32) -> Shadow {
    let place = place_of_root(medium, altitude);
    let edge = place.between(fetch(medium.tables, EDGE + place.first), fetch(medium.tables, EDGE + place.first + 1));
    Shadow { offset: edge.x, slope: edge.y, begin: medium.atmosphere.shadow_begin }
}

#[inline(always)]
fn at_altitude(medium: Medium<'_>, place: Place) -> Vec4 {
    place.between(fetch(medium.tables, place.first), fetch(medium.tables, place.first + 1))
}

#[inline(always)]
fn at_direction(medium: Medium<'_>, (table, count): (usize, usize), altitude: Place, x: f32) -> Vec4 {
    let Stencil { first, weights, .. } = stencil(min(max(x, 0.0), 1.0) * (count - 1) as f32, count as u32);
    let below = table + altitude.first * count + first as usize;
    altitude.between(of_four(medium, below, weights), of_four(medium, below + count, weights))
}

#[inline(always)]
fn of_four(medium: Medium<'_>, first: usize, weights: Vec4) -> Vec4 {
    fetch(medium.tables, first) * weights.x
        + fetch(medium.tables, first + 1) * weights.y
        + fetch(medium.tables, first + 2) * weights.z
        + fetch(medium.tables, first + 3) * weights.w
}

/// Relative densities of (air, aerosol, ozone) at an altitude (km): those of the profiles, which have the vertical
/// column densities of the exponential and the tent in whose place they stand.
#[inline(always)]
pub fn relative_densities(medium: Medium<'_>, altitude: f32) -> Vec4 {
    exp4(at_altitude(medium, place_of_altitude(medium, altitude)))
}

/// Column densities (km) from an altitude (km) outwards along a straight ray with a cosine `mu >= 0`.
#[inline(always)]
pub fn column_densities(medium: Medium<'_>, altitude: f32, mu: f32) -> ColumnDensities {
    let spread = sqrt((medium.atmosphere.ground_radius + altitude) * AXIS_SPREAD);
    let x = (1.0 - mu) / (1.0 + spread * mu);
    let place = place_of_altitude(medium, altitude);
    let main = at_direction(medium, (VIEW, VIEWS), place, x);
    of_logarithms(main, gases(medium, (VIEW_GASES, VIEWS), place, x))
}

/// Column densities of the logarithms of those of air, aerosol and ozone, and of the gases.
#[inline(always)]
fn of_logarithms(main: Vec4, gases: Vec2) -> ColumnDensities {
    let (main, gases) = (exp4(main), exp4(Vec4::new(gases.x, gases.y, 0.0, 0.0)));
    ColumnDensities { air: main.x, aerosol: main.y, ozone: main.z, pairs: gases.x, water: gases.y }
}

/// Logarithms of the amounts of gases at a place of a table.
#[inline(always)]
fn gases(medium: Medium<'_>, (table, count): (usize, usize), altitude: Place, x: f32) -> Vec2 {
    let Place { first, part } = Place::new(x, count);
    let below = table + altitude.first * count + first;
    let both = altitude.between(fetch(medium.tables, below), fetch(medium.tables, below + count));
    Vec2::new(both.x + (both.z - both.x) * part, both.y + (both.w - both.y) * part)
}

/// Relative densities of (pairs of oxygen, water vapour) at an altitude (km), per km of the columns over the ground.
#[inline(always)]
pub fn gas_densities(medium: Medium<'_>, altitude: f32) -> Vec2 {
    let place = place_of_altitude(medium, altitude);
    let entry = place.between(fetch(medium.tables, GASES + place.first), fetch(medium.tables, GASES + place.first + 1));
    let densities = exp4(entry);
    Vec2::new(densities.x, densities.y)
}

/// The way of sunlight to a point.
#[derive(Clone, Copy)]
pub struct Sunlight {
    /// What lies along it.
    pub along: ColumnDensities,
    /// `F`: by how much bending weakens the beam.
    pub spread: f32,
}

#[inline(always)]
fn along_suns(lowest: f32, mu_s: f32) -> f32 {
    1.0 - sqrt(max(1.0 - acos(mu_s) / lowest, 0.0))
}

/// What the table of sunlight holds at a place.
#[derive(Clone, Copy)]
pub struct SunlightEntry {
    /// Logarithms of the column densities of air, aerosol and ozone, and `F`.
    pub main: Vec4,
    /// Logarithms of the amounts of gases.
    pub gases: Vec2,
}

impl SunlightEntry {
    /// That at an altitude (km), by the cosine of the sun's zenith angle without air. A sun below the horizon shines as
    /// one on it.
    #[inline(always)]
    pub fn at(medium: Medium<'_>, altitude: f32, mu_s: f32) -> Self {
        let lowest = at_altitude(medium, place_of_root(medium, altitude)).w;
        let (place, x) = (place_of_altitude(medium, altitude), along_suns(lowest, mu_s));
        Self { main: at_direction(medium, (SUN, SUNS), place, x), gases: gases(medium, (SUN_GASES, SUNS), place, x) }
    }

    /// The sunlight.
    #[inline(always)]
    pub fn sunlight(self) -> Sunlight {
        Sunlight { along: of_logarithms(self.main, self.gases), spread: self.main.w }
    }
}

/// Cosine of the zenith angle at which the sun is seen from the ground, by that without air; 0 below the horizon.
#[inline(always)]
pub fn cosine_from_ground(medium: Medium<'_>, mu_s: f32) -> f32 {
    let place = Place::new(along_suns(fetch(medium.tables, 0).w, mu_s), SUNS);
    place.between(fetch(medium.tables, SEEN + place.first), fetch(medium.tables, SEEN + place.first + 1)).x
}
