//! The sky lookup: the colours of the sky's constituents, integrated for a few directions, between which every pixel is interpolated.
//!
//! Without its phase functions the sky is smooth, and it is symmetric about the vertical plane through the sun. Rows are
//! elevations, crowded towards the horizon on either side of it; columns are places of [`crate::azimuth`]. The phase functions are exact at
//! every pixel, and so is the horizon.
//!
//! The rows of an equirectangular image are elevations too. Its lookup has the same rows, and nothing is interpolated between them; between
//! columns go cubics. Where the columns lie far enough apart, neighbouring pixels share what they read; see [`crate::run`].

use crate::azimuth::{cosine_at_place, place_of_azimuth};
use crate::camera::{EQUIRECTANGULAR, PERSPECTIVE, equirectangular_elevation, is_within};
use crate::cubic::{Stencil, stencil};
use crate::glam::{Vec3, Vec4};
use crate::math::{PI, acos, fetch, floor, max, min, mix, safe_sqrt, sin_cos, store};
use crate::phase::ScatteringAngle;
use crate::sky::{Constituents, cosine_from_sun, with_phases};
use crate::uniform::Uniform;
use crate::variant;

/// Rays this close to the horizon (radians) stand for the horizon itself, seen from above the ground: one side is sky, the
/// other ground.
const HORIZON_MARGIN: f32 = 1e-5;

/// Colours of an entry: air, aerosol, and the rest where there is any.
#[inline(always)]
pub fn colours_per_entry(variant: u32) -> u32 {
    if variant & variant::REST != 0 { 3 } else { 2 }
}

/// Stores the colours of an entry.
#[inline(always)]
pub fn store_entry(lookup: &mut [Vec4], entry: u32, colours: Constituents, variant: u32) {
    let at = (colours_per_entry(variant) * entry) as usize;
    store(lookup, at, colours.air.extend(0.0));
    store(lookup, at + 1, colours.aerosol.extend(0.0));
    if variant & variant::REST != 0 {
        store(lookup, at + 2, colours.rest.extend(0.0));
    }
}

/// Entries of the sky lookup, each of some colours; see [`colours_per_entry`].
#[inline(always)]
pub fn entries(uniform: &Uniform) -> u32 {
    (uniform.lookup_above + uniform.lookup_below) * uniform.lookup_azimuths
}

/// The direction of an entry, for position `x` in [0, 1] from the horizon to the zenith (`above`) or the nadir, and cosine
/// `c` of the azimuth from the sun.
#[inline(always)]
pub fn grid_view(uniform: &Uniform, above: bool, x: f32, c: f32) -> Vec3 {
    let from_horizon = max(x * x, 0.0);
    let elevation = if above {
        uniform.horizon + max(from_horizon * (0.5 * PI - uniform.horizon), margin(uniform))
    } else {
        uniform.horizon - max(from_horizon * (0.5 * PI + uniform.horizon), margin(uniform))
    };
    towards(uniform, elevation, c)
}

/// The direction at an elevation (radians), for the cosine `c` of the azimuth from the sun.
#[inline(always)]
fn towards(uniform: &Uniform, elevation: f32, c: f32) -> Vec3 {
    let (sine, cosine) = sin_cos(elevation);
    let s = safe_sqrt(1.0 - c * c);
    let (to_sun, across) = (uniform.bearing, Vec3::new(-uniform.bearing.y, uniform.bearing.x, 0.0));
    Vec3::new(cosine * (c * to_sun.x + s * across.x), cosine * (c * to_sun.y + s * across.y), sine)
}

#[inline(always)]
fn margin(uniform: &Uniform) -> f32 {
    if uniform.altitude > 0.0 { HORIZON_MARGIN } else { 0.0 }
}

/// The direction of the entry with this index.
#[inline(always)]
pub fn entry_view(uniform: &Uniform, entry: u32, variant: u32) -> Vec3 {
    let row = entry / uniform.lookup_azimuths;
    let column = entry - row * uniform.lookup_azimuths;
    let c = cosine_at_place(column as f32 / (uniform.lookup_azimuths - 1) as f32);
    if variant::projection(variant) == EQUIRECTANGULAR {
        return towards(uniform, equirectangular_elevation(&uniform.camera, row as f32 + 0.5), c);
    }
    let above = row < uniform.lookup_above;
    let (place, rows) =
        if above { (row, uniform.lookup_above) } else { (row - uniform.lookup_above, uniform.lookup_below) };
    let x = place as f32 / (rows - 1) as f32;
    grid_view(uniform, above, x, c)
}

/// Whether an entry has to be computed: no pixel of a perspective reads one that lies farther from what its camera sees than the cells about it reach.
#[inline(always)]
pub fn is_read(uniform: &Uniform, entry: u32, variant: u32) -> bool {
    if (variant::projection(variant) != PERSPECTIVE) | (uniform.fills_whole_lookup != 0) {
        return true;
    }
    let columns = uniform.lookup_azimuths;
    let column = entry % columns;
    let place = |column: u32| cosine_at_place(column as f32 / (columns - 1) as f32);
    let last = columns - 1;
    let (before, behind) = (if column > 0 { column - 1 } else { 0 }, if column < last { column + 1 } else { last });
    // Two columns lie farther apart the farther they are from the sun, and no two rows farther than this: of x² steps, the last is the longest.
    let across = acos(place(behind)) - acos(place(before));
    let (above, below) = (uniform.lookup_above, uniform.lookup_below);
    let rows = if (below > 0) & (below < above) { below } else { above };
    let down = 2.0 * PI / (rows - 1) as f32;
    let view = entry_view(uniform, entry, variant);
    let reach = across * (safe_sqrt(1.0 - view.z * view.z) + down) + down;
    let mirrored = mirrored_at_sun(uniform, view);
    (reach >= 0.5 * PI) | is_within(&uniform.camera, view, reach) | is_within(&uniform.camera, mirrored, reach)
}

/// The direction on the other side of the vertical plane through the sun, where the sky is the same.
#[inline(always)]
fn mirrored_at_sun(uniform: &Uniform, view: Vec3) -> Vec3 {
    let across = Vec3::new(-uniform.bearing.y, uniform.bearing.x, 0.0);
    view - across * (2.0 * view.dot(across))
}

/// Linear RGB of the sky in a direction, from the sky lookup: colours of air and aerosol between its entries, exact phase functions.
/// `row` is that of the whole image.
#[inline(always)]
pub fn sky_from_lookup(uniform: &Uniform, lookup: &[Vec4], view: Vec3, row: u32, variant: u32) -> Vec3 {
    if is_on_ground(view, variant) {
        return ground_beneath(uniform, variant);
    }
    if variant::projection(variant) == EQUIRECTANGULAR {
        coloured(uniform, along_row(uniform, lookup, row_place(uniform, view), row, variant), view, variant)
    } else {
        sky_in_grid(uniform, lookup, view, variant)
    }
}

/// Whether a view ends on the ground where it begins.
#[inline(always)]
pub fn is_on_ground(view: Vec3, variant: u32) -> bool {
    (variant & variant::DESCENT == 0) & (view.z < 0.0)
}

/// Linear RGB of the ground on which the observer stands.
#[inline(always)]
pub fn ground_beneath(uniform: &Uniform, variant: u32) -> Vec3 {
    if variant & variant::GROUND != 0 { rgb(uniform.ground) } else { Vec3::ZERO }
}

/// The entries about a direction in its row of the lookup.
#[inline(always)]
pub fn row_place(uniform: &Uniform, view: Vec3) -> Stencil {
    stencil(columns_from_sun(uniform, view), uniform.lookup_azimuths)
}

/// Colours of the constituents between four entries of an image's row.
#[inline(always)]
pub fn along_row(uniform: &Uniform, lookup: &[Vec4], near: Stencil, row: u32, variant: u32) -> Constituents {
    let at = (colours_per_entry(variant) * (row * uniform.lookup_azimuths + near.first)) as usize;
    let (mut aerosol, mut rest) = (Vec3::ZERO, Vec3::ZERO);
    if variant & variant::AEROSOL != 0 {
        aerosol = FourEntries::fetch(lookup, at + 1, variant).weighted(near.weights);
    }
    if variant & variant::REST != 0 {
        rest = FourEntries::fetch(lookup, at + 2, variant).weighted(near.weights);
    }
    Constituents { air: FourEntries::fetch(lookup, at, variant).weighted(near.weights), aerosol, rest }
}

/// A colour of four entries that follow each other in a row.
#[derive(Clone, Copy)]
pub struct FourEntries(Vec4, Vec4, Vec4, Vec4);

impl FourEntries {
    /// Those of the first of which the colour stands at `at`.
    #[inline(always)]
    pub fn fetch(lookup: &[Vec4], at: usize, variant: u32) -> Self {
        let colours = colours_per_entry(variant) as usize;
        Self(
            fetch(lookup, at),
            fetch(lookup, at + colours),
            fetch(lookup, at + 2 * colours),
            fetch(lookup, at + 3 * colours),
        )
    }

    /// Their sum, each with its weight.
    #[inline(always)]
    pub fn weighted(self, weights: Vec4) -> Vec3 {
        let Self(a, b, c, d) = self;
        rgb(a * weights.x + b * weights.y + c * weights.z + d * weights.w)
    }
}

/// Linear RGB of the sky in a direction, from a lookup that does not have the rows of its image.
#[inline(always)]
fn sky_in_grid(uniform: &Uniform, lookup: &[Vec4], view: Vec3, variant: u32) -> Vec3 {
    let place = grid_place(uniform, view, variant);
    coloured(uniform, grid_constituents(uniform, lookup, place, variant), view, variant)
}

/// A place between four entries of a lookup that does not have the rows of its image.
#[derive(Clone, Copy)]
pub struct GridPlace {
    /// The entry before it in the row before it.
    pub entry: u32,
    /// How far it is from that entry to the next in the row, in [0, 1].
    pub across: f32,
    /// How far it is from that row to the next, in [0, 1].
    pub down: f32,
}

/// The place of a direction.
#[inline(always)]
pub fn grid_place(uniform: &Uniform, view: Vec3, variant: u32) -> GridPlace {
    let elevation = 0.5 * PI - acos(view.z);
    let above = (variant & variant::DESCENT == 0) | (elevation >= uniform.horizon);
    let (from_horizon, first_row, rows) = if above {
        ((elevation - uniform.horizon) / (0.5 * PI - uniform.horizon), 0, uniform.lookup_above)
    } else {
        ((uniform.horizon - elevation) / (0.5 * PI + uniform.horizon), uniform.lookup_above, uniform.lookup_below)
    };
    let y = safe_sqrt(from_horizon) * (rows - 1) as f32;
    let x = columns_from_sun(uniform, view);
    let row = min(floor(y), (rows - 2) as f32);
    let column = min(floor(x), (uniform.lookup_azimuths - 2) as f32);
    let entry = (first_row + row as u32) * uniform.lookup_azimuths + column as u32;
    GridPlace { entry, across: x - column, down: y - row }
}

/// Colours of the constituents at a place.
#[inline(always)]
pub fn grid_constituents(uniform: &Uniform, lookup: &[Vec4], place: GridPlace, variant: u32) -> Constituents {
    let colours = colours_per_entry(variant) as usize;
    let entry = colours * place.entry as usize;
    let below = entry + colours * uniform.lookup_azimuths as usize;
    let (fx, fy) = (place.across, place.down);
    let air = bilinear(lookup, entry, below, colours, fx, fy);
    let mut aerosol = Vec3::ZERO;
    if variant & variant::AEROSOL != 0 {
        aerosol = bilinear(lookup, entry + 1, below + 1, colours, fx, fy);
    }
    let mut rest = Vec3::ZERO;
    if variant & variant::REST != 0 {
        rest = bilinear(lookup, entry + 2, below + 2, colours, fx, fy);
    }
    Constituents { air, aerosol, rest }
}

/// Linear RGB of the sky in a direction from what was looked up for it.
#[inline(always)]
fn coloured(uniform: &Uniform, constituents: Constituents, view: Vec3, variant: u32) -> Vec3 {
    with_phases(uniform, constituents, ScatteringAngle::between(view, uniform.sun.truncate()), variant)
}

/// Columns of the lookup between the sun's azimuth and a direction's.
#[inline(always)]
fn columns_from_sun(uniform: &Uniform, view: Vec3) -> f32 {
    place_of_azimuth(cosine_from_sun(uniform, view)) * (uniform.lookup_azimuths - 1) as f32
}

/// The colour between four entries of so many colours, given the first of each of their two rows.
#[inline(always)]
fn bilinear(lookup: &[Vec4], upper: usize, lower: usize, colours: usize, fx: f32, fy: f32) -> Vec3 {
    let left = mix(fetch(lookup, upper), fetch(lookup, lower), fy);
    let right = mix(fetch(lookup, upper + colours), fetch(lookup, lower + colours), fy);
    rgb(mix(left, right, fx))
}

#[inline(always)]
fn rgb(colour: Vec4) -> Vec3 {
    Vec3::new(colour.x, colour.y, colour.z)
}
