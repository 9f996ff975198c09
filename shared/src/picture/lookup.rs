//! The sky lookup: the colours of the sky's constituents, integrated for a few directions, between which every pixel is
//! interpolated.
//!
//! Without its phase functions the sky is smooth, and it is symmetric about the vertical plane through the sun. Rows
//! are elevations, crowded towards the horizon on either side of it; columns are places of
//! [`crate::interpolation::azimuth`]. The phase functions are exact at every pixel, and so is the horizon.
//!
//! Above the horizon, a place `x` in [0, 1] is the part `C x² + (1 - C) x⁴` of the way to the zenith, or from outside
//! the atmosphere to its upper edge: the layers that a ray grazes lie within a few degrees. Below it, what is seen
//! changes with the distance `d` to the ground: `1 - x` is the root of the part of the way from the nearest ground to
//! that of the horizon, at the distance `t = √(h (2R + h))`. From `r = R + h` follows the sine of the depression, `t/r
//! + (t - d)²/(2 r d)`.
//!
//! Few directions are integrated, the anchors; between them go cubics to many entries, between which straight lines do
//! for the pixels. Both have a grid of these rows and columns. The anchors lie behind the entries.
//!
//! The rows of an equirectangular image are elevations too. Its lookup has the same rows, and nothing is interpolated
//! between them; between columns go cubics. Where the columns lie far enough apart, neighbouring pixels share what they
//! read; see [`crate::picture::run`].

use crate::camera::{EQUIRECTANGULAR, PERSPECTIVE, equirectangular_elevation, is_within};
use crate::glam::{UVec2, Vec3, Vec4};
use crate::interpolation::azimuth::{cosine_at_place, place_of_azimuth};
use crate::interpolation::cubic::{Stencil, stencil};
use crate::math::{PI, abs, acos, clamp, fetch, floor, max, min, mix, safe_sqrt, sin_cos, sqrt, store};
use crate::medium::phase::ScatteringAngle;
use crate::picture::below::{SkyView, edge, margin, with_ground};
use crate::picture::polariser::passed;
use crate::sky::{Constituents, cosine_from_sun, with_phases};
use crate::uniform::Uniform;
use crate::variant;

/// The part of a square in the way from the horizon upwards; see the [module](self).
const CROWDING: f32 = 0.1;

/// Anchors on either side of a place, at most, that the cubics of an entry beside it read.
const REACH_OF_CUBICS: u32 = 3;

/// Rows and columns of directions.
#[derive(Clone, Copy)]
pub struct Grid {
    /// Rows above the horizon.
    pub above: u32,
    /// Rows below the horizon.
    pub below: u32,
    /// Columns.
    pub azimuths: u32,
}

/// The grid of the entries; of an equirectangular image the rows are its own.
#[inline(always)]
fn entry_grid(uniform: &Uniform) -> Grid {
    Grid { above: uniform.lookup_above, below: uniform.lookup_below, azimuths: uniform.lookup_azimuths }
}

/// The grid of the anchors.
#[inline(always)]
fn anchor_grid(uniform: &Uniform) -> Grid {
    Grid { above: uniform.anchors_above, below: uniform.anchors_below, azimuths: uniform.anchor_azimuths }
}

/// Where a direction lies between the horizon and the end of its side.
#[derive(Clone, Copy)]
struct FromHorizon {
    above: bool,
    /// 0 at the horizon, 1 at the zenith or the nadir.
    x: f32,
}

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

/// Anchors of the sky lookup, each of as many colours.
#[inline(always)]
pub fn anchors(uniform: &Uniform) -> u32 {
    (uniform.anchors_above + uniform.anchors_below) * uniform.anchor_azimuths
}

/// The direction of a place `x` in [0, 1] from the horizon to the zenith (`above`) or the nadir, for the cosine `c` of
/// the azimuth from the sun.
#[inline(always)]
pub fn grid_view(uniform: &Uniform, above: bool, x: f32, c: f32) -> Vec3 {
    if above {
        let square = x * x;
        let from_horizon = square * (CROWDING + (1.0 - CROWDING) * square) * uniform.lookup_span;
        let (sine, cosine) = sin_cos(uniform.horizon + max(from_horizon, margin(uniform)));
        towards(uniform, sine, cosine, c)
    } else {
        let (tangent, radius) = (tangent_length(uniform), radius(uniform));
        let near = 1.0 - x;
        let distance = uniform.altitude + (tangent - uniform.altitude) * near * near;
        let short = tangent - distance;
        let beyond_horizon = max(0.5 * short * short / (radius * distance), margin(uniform));
        let depression = min(tangent / radius + beyond_horizon, 1.0);
        towards(uniform, -depression, safe_sqrt((1.0 - depression) * (1.0 + depression)), c)
    }
}

/// The inverse of [`grid_view`].
#[inline(always)]
fn from_horizon(uniform: &Uniform, view: Vec3, variant: u32) -> FromHorizon {
    let (tangent, depth) = (tangent_length(uniform), -view.z * radius(uniform));
    if (variant & variant::DESCENT == 0) | (depth <= tangent) {
        let elevation = 0.5 * PI - acos(view.z);
        let part = clamp((elevation - uniform.horizon) / uniform.lookup_span, 0.0, 1.0);
        let root = sqrt(CROWDING * CROWDING + 4.0 * (1.0 - CROWDING) * part);
        FromHorizon { above: true, x: sqrt(2.0 * part / (CROWDING + root)) }
    } else {
        let distance = tangent * tangent / (depth + safe_sqrt((depth - tangent) * (depth + tangent)));
        let part = (distance - uniform.altitude) / (tangent - uniform.altitude);
        FromHorizon { above: false, x: max(1.0 - safe_sqrt(part), 0.0) }
    }
}

/// The observer's distance from the planet's centre (km).
#[inline(always)]
fn radius(uniform: &Uniform) -> f32 {
    uniform.atmosphere.ground_radius + uniform.altitude
}

/// The distance of the horizon (km).
#[inline(always)]
fn tangent_length(uniform: &Uniform) -> f32 {
    sqrt(uniform.altitude * (2.0 * uniform.atmosphere.ground_radius + uniform.altitude))
}

/// The direction with this sine and cosine of its elevation, for the cosine `c` of the azimuth from the sun.
#[inline(always)]
pub fn towards(uniform: &Uniform, sine: f32, cosine: f32, c: f32) -> Vec3 {
    let s = safe_sqrt(1.0 - c * c);
    let (to_sun, across) = (uniform.bearing, Vec3::new(-uniform.bearing.y, uniform.bearing.x, 0.0));
    Vec3::new(cosine * (c * to_sun.x + s * across.x), cosine * (c * to_sun.y + s * across.y), sine)
}

/// The direction of the entry with this index.
#[inline(always)]
pub fn entry_view(uniform: &Uniform, entry: u32, variant: u32) -> Vec3 {
    let grid = entry_grid(uniform);
    if variant::projection(variant) == EQUIRECTANGULAR {
        let row = entry / grid.azimuths;
        let c = cosine_of_column(grid, entry - row * grid.azimuths);
        let (sine, cosine) = sin_cos(equirectangular_elevation(&uniform.camera, row as f32 + 0.5));
        return towards(uniform, sine, cosine, c);
    }
    view_in_grid(uniform, grid, entry)
}

/// The direction of the anchor with this index.
#[inline(always)]
pub fn anchor_view(uniform: &Uniform, anchor: u32) -> Vec3 {
    view_in_grid(uniform, anchor_grid(uniform), anchor)
}

#[inline(always)]
fn view_in_grid(uniform: &Uniform, grid: Grid, index: u32) -> Vec3 {
    let row = index / grid.azimuths;
    let FromHorizon { above, x } = row_from_horizon(grid, row);
    grid_view(uniform, above, x, cosine_of_column(grid, index - row * grid.azimuths))
}

/// Where a row of a grid lies.
#[inline(always)]
fn row_from_horizon(grid: Grid, row: u32) -> FromHorizon {
    let above = row < grid.above;
    let (place, rows) = if above { (row, grid.above) } else { (row - grid.above, grid.below) };
    FromHorizon { above, x: place as f32 / (rows - 1) as f32 }
}

#[inline(always)]
fn cosine_of_column(grid: Grid, column: u32) -> f32 {
    cosine_at_place(column as f32 / (grid.azimuths - 1) as f32)
}

/// Whether an entry has to be computed: no pixel of a perspective reads one that lies farther from what its camera sees
/// than the cells about it reach.
#[inline(always)]
pub fn is_read(uniform: &Uniform, entry: u32, variant: u32) -> bool {
    is_near_view(uniform, entry_grid(uniform), entry, 1, variant)
}

/// Whether an anchor has to be integrated: likewise of the entries, all of which an equirectangular image has in its
/// own rows.
#[inline(always)]
pub fn is_anchor_read(uniform: &Uniform, anchor: u32, variant: u32) -> bool {
    if variant::projection(variant) == EQUIRECTANGULAR {
        return is_near_image_row(uniform, anchor);
    }
    is_near_view(uniform, anchor_grid(uniform), anchor, REACH_OF_CUBICS, variant)
}

/// Whether a row of an equirectangular image lies where cubics read an anchor. At the ends of a side, where cubics are
/// one-sided, all anchors count as read.
#[inline(always)]
fn is_near_image_row(uniform: &Uniform, anchor: u32) -> bool {
    let grid = anchor_grid(uniform);
    let row = anchor / grid.azimuths;
    let (first, end) = side_of_row(grid, row);
    if (row < first + REACH_OF_CUBICS) | (row + REACH_OF_CUBICS >= end) {
        return true;
    }
    let a = zenith_angle_of_row(uniform, grid, row - REACH_OF_CUBICS);
    let b = zenith_angle_of_row(uniform, grid, row + REACH_OF_CUBICS);
    // Of image rows, whose centres lie at the halves.
    let per_angle = uniform.camera.height as f32 / PI;
    floor(max(a, b) * per_angle + 0.5) > floor(min(a, b) * per_angle + 0.5)
}

/// Whether a place of a grid lies within so many of its cells of what the camera of a perspective sees.
#[inline(always)]
fn is_near_view(uniform: &Uniform, grid: Grid, index: u32, cells: u32, variant: u32) -> bool {
    if (variant::projection(variant) != PERSPECTIVE) | (uniform.fills_whole_lookup != 0) {
        return true;
    }
    let row = index / grid.azimuths;
    let column = index - row * grid.azimuths;
    let (before, behind) = around(column, 0, grid.azimuths, cells);
    let across = acos(cosine_of_column(grid, behind)) - acos(cosine_of_column(grid, before));
    let (first, end) = side_of_row(grid, row);
    let (upper, lower) = around(row, first, end, cells);
    let view = view_in_grid(uniform, grid, index);
    let zenith_angle = acos(view.z);
    let down = max(
        abs(zenith_angle_of_row(uniform, grid, upper) - zenith_angle),
        abs(zenith_angle_of_row(uniform, grid, lower) - zenith_angle),
    );
    let reach = across * (safe_sqrt(1.0 - view.z * view.z) + down) + down;
    let mirrored = mirrored_at_sun(uniform, view);
    (reach >= 0.5 * PI) | is_within(&uniform.camera, view, reach) | is_within(&uniform.camera, mirrored, reach)
}

/// The first row of the side of the horizon on which a row lies, and that behind its last.
#[inline(always)]
fn side_of_row(grid: Grid, row: u32) -> (u32, u32) {
    if row < grid.above { (0, grid.above) } else { (grid.above, grid.above + grid.below) }
}

/// The places so many before and behind another of those from `first` to before `end`.
#[inline(always)]
fn around(place: u32, first: u32, end: u32, cells: u32) -> (u32, u32) {
    let before = if place - first > cells { place - cells } else { first };
    let behind = if place + cells < end { place + cells } else { end - 1 };
    (before, behind)
}

#[inline(always)]
fn zenith_angle_of_row(uniform: &Uniform, grid: Grid, row: u32) -> f32 {
    let FromHorizon { above, x } = row_from_horizon(grid, row);
    acos(grid_view(uniform, above, x, 1.0).z)
}

/// The direction on the other side of the vertical plane through the sun, where the sky is the same.
#[inline(always)]
fn mirrored_at_sun(uniform: &Uniform, view: Vec3) -> Vec3 {
    let across = Vec3::new(-uniform.bearing.y, uniform.bearing.x, 0.0);
    view - across * (2.0 * view.dot(across))
}

/// Linear RGB of the sky and the ground at a pixel of the whole image, from the sky lookup: colours of air and aerosol
/// between its entries, exact phase functions. A polariser alone reads the colour rows.
#[inline(always)]
pub fn sky_from_lookup(
    uniform: &Uniform,
    colour: &[Vec4],
    lookup: &[Vec4],
    pixel: UVec2,
    view: SkyView,
    variant: u32,
) -> Vec3 {
    let mut sky = Vec3::ZERO;
    if view.ground < 1.0 {
        sky = if variant & variant::POLARISER != 0 {
            let found = constituents_at_pixel(uniform, lookup, pixel, view, variant);
            passed(uniform, colour, found, view.source, view.direction, variant)
        } else if variant::projection(variant) == EQUIRECTANGULAR {
            let place = row_place(uniform, view.direction);
            coloured(uniform, along_row(uniform, lookup, place, view.source_row, variant), view.direction, variant)
        } else {
            sky_at_pixel(uniform, lookup, pixel, view, variant)
        };
    }
    with_ground(uniform, sky, view.ground)
}

/// Linear RGB of the sky in the direction of a pixel, from a lookup that does not have the rows of its image; where the
/// horizon crosses the pixel, of both its sides.
#[inline(always)]
pub fn sky_at_pixel(uniform: &Uniform, lookup: &[Vec4], pixel: UVec2, view: SkyView, variant: u32) -> Vec3 {
    let (above, below, part) = edge(uniform, pixel.x, pixel.y, view.direction, variant);
    if (part > 0.0) & (part < 1.0) {
        let sky = sky_in_grid(uniform, lookup, above, above, variant);
        sky + (sky_in_grid(uniform, lookup, below, below, variant) - sky) * part
    } else {
        sky_in_grid(uniform, lookup, view.source, view.direction, variant)
    }
}

/// Colours of the constituents in the direction of a pixel; where the horizon crosses the pixel, of both its sides.
#[inline(always)]
fn constituents_at_pixel(
    uniform: &Uniform,
    lookup: &[Vec4],
    pixel: UVec2,
    view: SkyView,
    variant: u32,
) -> Constituents {
    if variant::projection(variant) == EQUIRECTANGULAR {
        return along_row(uniform, lookup, row_place(uniform, view.direction), view.source_row, variant);
    }
    let (above, below, part) = edge(uniform, pixel.x, pixel.y, view.direction, variant);
    let mut is_crossed = (part > 0.0) & (part < 1.0);
    let first = if is_crossed { above } else { view.source };
    let mut found = grid_constituents(uniform, lookup, grid_place(uniform, first, variant), variant);
    while is_crossed {
        let other = grid_constituents(uniform, lookup, grid_place(uniform, below, variant), variant);
        found.air += (other.air - found.air) * part;
        found.aerosol += (other.aerosol - found.aerosol) * part;
        found.rest += (other.rest - found.rest) * part;
        is_crossed = false;
    }
    found
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
    of_four(lookup, at, near.weights, variant)
}

/// Colours of the constituents between four that follow each other, of the first of which they stand at `at`.
#[inline(always)]
fn of_four(lookup: &[Vec4], at: usize, weights: Vec4, variant: u32) -> Constituents {
    let (mut aerosol, mut rest) = (Vec3::ZERO, Vec3::ZERO);
    if variant & variant::AEROSOL != 0 {
        aerosol = FourEntries::fetch(lookup, at + 1, variant).weighted(weights);
    }
    if variant & variant::REST != 0 {
        rest = FourEntries::fetch(lookup, at + 2, variant).weighted(weights);
    }
    Constituents { air: FourEntries::fetch(lookup, at, variant).weighted(weights), aerosol, rest }
}

/// Kernel `lookup`: colours of an entry, by cubics between sixteen anchors, the first of which is the one of this index
/// in `anchors`.
#[inline(always)]
pub fn entry_between_anchors(
    uniform: &Uniform,
    anchors: &[Vec4],
    first: u32,
    entry: u32,
    variant: u32,
) -> Constituents {
    let row = entry / uniform.lookup_azimuths;
    let down = anchor_rows_about(uniform, row, variant);
    let across = anchor_columns_about(uniform, entry - row * uniform.lookup_azimuths);
    let a = along_anchors(uniform, anchors, first, down.first, across, variant);
    let b = along_anchors(uniform, anchors, first, down.first + 1, across, variant);
    let c = along_anchors(uniform, anchors, first, down.first + 2, across, variant);
    let d = along_anchors(uniform, anchors, first, down.first + 3, across, variant);
    between_rows(a, b, c, d, down.weights)
}

/// The four rows of anchors about a row of entries.
#[inline(always)]
pub fn anchor_rows_about(uniform: &Uniform, row: u32, variant: u32) -> Stencil {
    let (entries, grid) = (entry_grid(uniform), anchor_grid(uniform));
    let mut place = row_from_horizon(entries, row);
    if variant::projection(variant) == EQUIRECTANGULAR {
        place = from_horizon(uniform, entry_view(uniform, row * entries.azimuths, variant), variant);
    }
    let (first_row, rows) = if place.above { (0, grid.above) } else { (grid.above, grid.below) };
    let near = stencil(place.x * (rows - 1) as f32, rows);
    Stencil { first: first_row + near.first, ..near }
}

/// The four columns of anchors about a column of entries.
#[inline(always)]
pub fn anchor_columns_about(uniform: &Uniform, column: u32) -> Stencil {
    let part = column as f32 / (uniform.lookup_azimuths - 1) as f32;
    stencil(part * (uniform.anchor_azimuths - 1) as f32, uniform.anchor_azimuths)
}

/// Colours between four anchors of a row, the first of all anchors being that of the index `first`.
#[inline(always)]
pub fn along_anchors(
    uniform: &Uniform,
    anchors: &[Vec4],
    first: u32,
    row: u32,
    across: Stencil,
    variant: u32,
) -> Constituents {
    let at = colours_per_entry(variant) * (first + row * uniform.anchor_azimuths + across.first);
    of_four(anchors, at as usize, across.weights, variant)
}

/// Colours between those of four rows.
#[inline(always)]
pub fn between_rows(a: Constituents, b: Constituents, c: Constituents, d: Constituents, weights: Vec4) -> Constituents {
    let (x, y, z, w) = (weights.x, weights.y, weights.z, weights.w);
    Constituents {
        air: a.air * x + b.air * y + c.air * z + d.air * w,
        aerosol: a.aerosol * x + b.aerosol * y + c.aerosol * z + d.aerosol * w,
        rest: a.rest * x + b.rest * y + c.rest * z + d.rest * w,
    }
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

/// Linear RGB of the air in a direction with the phase functions of another, from a lookup that does not have the rows
/// of its image.
#[inline(always)]
fn sky_in_grid(uniform: &Uniform, lookup: &[Vec4], source: Vec3, view: Vec3, variant: u32) -> Vec3 {
    let place = grid_place(uniform, source, variant);
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
    let FromHorizon { above, x } = from_horizon(uniform, view, variant);
    let (first_row, rows) =
        if above { (0, uniform.lookup_above) } else { (uniform.lookup_above, uniform.lookup_below) };
    let y = x * (rows - 1) as f32;
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
