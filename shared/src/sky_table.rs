//! The sky table: the colours of air and aerosol, integrated for a few directions and looked up for every pixel.
//!
//! Without its phase functions the sky is smooth, and it is symmetric about the vertical plane through the sun. Rows are
//! elevations, crowded towards the horizon on either side of it; columns are equidistant in the cosine of the azimuth from
//! the sun, in which a function that is even in the azimuth is smooth at both ends. The phase functions are exact at
//! every pixel, and so is the horizon.
//!
//! The rows of an equirectangular image are elevations too. Its table has the same rows, and nothing is interpolated between them.

use crate::atmosphere::ScatteringAngle;
use crate::camera::{EQUIRECTANGULAR, equirectangular_elevation};
use crate::frame::Frame;
use crate::glam::{Vec3, Vec4};
use crate::math::{PI, acos, clamp, fetch, floor, max, min, mix, safe_sqrt, sin_cos, sqrt};
use crate::sky::{Constituents, with_phases};
use crate::variant;

/// Rays this close to the horizon (radians) stand for the horizon itself, seen from above the ground: one side is sky, the
/// other ground.
const HORIZON_MARGIN: f32 = 1e-5;

/// Entries of the table of a frame.
#[inline]
pub fn entries(frame: &Frame) -> u32 {
    (frame.table_above + frame.table_below) * frame.table_azimuths
}

/// The direction of an entry, for position `x` in [0, 1] from the horizon to the zenith (`above`) or the nadir, and cosine
/// `c` of the azimuth from the sun.
#[inline]
pub fn grid_view(frame: &Frame, above: bool, x: f32, c: f32) -> Vec3 {
    let from_horizon = max(x * x, 0.0);
    let elevation = if above {
        frame.horizon + max(from_horizon * (0.5 * PI - frame.horizon), margin(frame))
    } else {
        frame.horizon - max(from_horizon * (0.5 * PI + frame.horizon), margin(frame))
    };
    towards(frame, elevation, c)
}

/// The direction at an elevation (radians), for the cosine `c` of the azimuth from the sun.
#[inline]
fn towards(frame: &Frame, elevation: f32, c: f32) -> Vec3 {
    let (sine, cosine) = sin_cos(elevation);
    let s = safe_sqrt(1.0 - c * c);
    let (to_sun, across) = (frame.bearing, Vec3::new(-frame.bearing.y, frame.bearing.x, 0.0));
    Vec3::new(cosine * (c * to_sun.x + s * across.x), cosine * (c * to_sun.y + s * across.y), sine)
}

#[inline]
fn margin(frame: &Frame) -> f32 {
    if frame.altitude > 0.0 { HORIZON_MARGIN } else { 0.0 }
}

/// The direction of the entry with this index.
#[inline]
pub fn entry_view(frame: &Frame, entry: u32, variant: u32) -> Vec3 {
    let row = entry / frame.table_azimuths;
    let column = entry - row * frame.table_azimuths;
    let c = 1.0 - 2.0 * column as f32 / (frame.table_azimuths - 1) as f32;
    if variant::projection(variant) == EQUIRECTANGULAR {
        return towards(frame, equirectangular_elevation(&frame.camera, row as f32 + 0.5), c);
    }
    let above = row < frame.table_above;
    let (place, rows) = if above { (row, frame.table_above) } else { (row - frame.table_above, frame.table_below) };
    let x = place as f32 / (rows - 1) as f32;
    grid_view(frame, above, x, c)
}

/// Linear RGB of the sky in a direction, from the table: colours of air and aerosol between its entries, exact phase functions.
/// `row` is that of the whole image.
#[inline]
pub fn sky_from_table(frame: &Frame, table: &[Vec4], view: Vec3, row: u32, variant: u32) -> Vec3 {
    if (variant & variant::DESCENT == 0) & (view.z < 0.0) {
        return Vec3::ZERO;
    }
    let cell = if variant::projection(variant) == EQUIRECTANGULAR {
        cell_of_row(frame, view, row)
    } else {
        cell(frame, view, variant)
    };
    let air = colour(table, cell, 0, variant);
    let mut aerosol = Vec3::ZERO;
    if variant & variant::AEROSOL != 0 {
        aerosol = colour(table, cell, 1, variant);
    }
    let angle = ScatteringAngle::between(view, frame.sun.truncate());
    with_phases(frame, Constituents { air, aerosol }, angle, variant)
}

/// Where a direction lies between the entries of the table.
#[derive(Clone, Copy)]
struct Cell {
    /// The entry above it and towards the sun.
    first: u32,
    /// Entries from there to the one below.
    to_next_row: u32,
    /// How far it lies from the first column to the next.
    across: f32,
    /// How far it lies from the first row to the next.
    down: f32,
}

/// The cell of a direction in the row of its pixel.
#[inline]
fn cell_of_row(frame: &Frame, view: Vec3, row: u32) -> Cell {
    let x = columns_from_sun(frame, view);
    let column = min(floor(x), (frame.table_azimuths - 2) as f32);
    Cell { first: row * frame.table_azimuths + column as u32, to_next_row: 0, across: x - column, down: 0.0 }
}

/// The cell of a direction.
#[inline]
fn cell(frame: &Frame, view: Vec3, variant: u32) -> Cell {
    let elevation = 0.5 * PI - acos(view.z);
    let above = (variant & variant::DESCENT == 0) | (elevation >= frame.horizon);
    let (from_horizon, first_row, rows) = if above {
        ((elevation - frame.horizon) / (0.5 * PI - frame.horizon), 0, frame.table_above)
    } else {
        ((frame.horizon - elevation) / (0.5 * PI + frame.horizon), frame.table_above, frame.table_below)
    };
    let y = safe_sqrt(from_horizon) * (rows - 1) as f32;
    let x = columns_from_sun(frame, view);
    let row = min(floor(y), (rows - 2) as f32);
    let column = min(floor(x), (frame.table_azimuths - 2) as f32);
    let first = (first_row + row as u32) * frame.table_azimuths + column as u32;
    Cell { first, to_next_row: frame.table_azimuths, across: x - column, down: y - row }
}

/// Columns of the table between the sun's azimuth and a direction's.
#[inline]
fn columns_from_sun(frame: &Frame, view: Vec3) -> f32 {
    let along = view.x * frame.bearing.x + view.y * frame.bearing.y;
    let c = clamp(along / max(sqrt(view.x * view.x + view.y * view.y), 1e-10), -1.0, 1.0);
    0.5 * (1.0 - c) * (frame.table_azimuths - 1) as f32
}

/// The colour of a constituent (0: air, 1: aerosol) in a cell.
#[inline]
fn colour(table: &[Vec4], cell: Cell, constituent: u32, variant: u32) -> Vec3 {
    let at = (2 * cell.first + constituent) as usize;
    let mut left = fetch(table, at);
    let mut right = fetch(table, at + 2);
    if variant::projection(variant) != EQUIRECTANGULAR {
        let below = at + 2 * cell.to_next_row as usize;
        left = mix(left, fetch(table, below), cell.down);
        right = mix(right, fetch(table, below + 2), cell.down);
    }
    let colour = mix(left, right, cell.across);
    Vec3::new(colour.x, colour.y, colour.z)
}
