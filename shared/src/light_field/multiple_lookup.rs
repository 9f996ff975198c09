//! The lookup of multiply scattered light: a grid of directions, between which every ray is interpolated.
//!
//! Light scattered more than once has no phase function left, and varies slowly with the direction: a few thousand
//! entries hold it. As in [`crate::picture::lookup`], rows are elevations, crowded towards the horizon on either side
//! of it, and columns are places of [`crate::interpolation::azimuth`]; between them it is interpolated by cubics, or on
//! a finer grid by straight lines. Rows of an observer outside the atmosphere are elevations where the ray enters it,
//! so that they resolve the limb from any distance; columns are the observer's own.
//!
//! An entry is the light that air and aerosol scatter towards the observer and, below the horizon, the diffuse
//! irradiance of the ground that is seen there. Both are relative to the irradiance of the sun above the atmosphere
//! (transfer, sr⁻¹, and a pure number).

use bytemuck::{Pod, Zeroable};

use crate::geometry::{Ray, inside_atmosphere};
use crate::glam::Vec4;
use crate::interpolation::azimuth::place_of_azimuth;
use crate::interpolation::cubic::stencil;
use crate::math::{PI, acos, clamp, fetch, floor, max4, min, mix, safe_sqrt};
use crate::medium::atmosphere::Atmosphere;
use crate::variant;

/// Where the entries are. The layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MultipleLookup {
    /// Rows above the horizon; 0 where there is no multiply scattered light. Otherwise four at least, as of the other
    /// two.
    pub above: u32,
    /// Rows below the horizon.
    pub below: u32,
    /// Columns.
    pub azimuths: u32,
    /// Groups of four bands.
    pub groups: u32,
    /// Elevation of the horizon, seen from where rays enter the atmosphere or begin (radians).
    pub horizon: f32,
    /// Elevations above the horizon that the rows above span (radians): to the zenith, or from outside to the top of
    /// the atmosphere.
    pub span_above: f32,
    /// Elevations below the horizon that the rows below span (radians).
    pub span_below: f32,
    /// Unused; fills the last 16 bytes.
    pub padding: u32,
}

impl MultipleLookup {
    /// Entries of scattered light; those of irradiance follow them.
    #[inline]
    pub fn entries(&self) -> u32 {
        self.groups * (self.above + self.below) * self.azimuths
    }

    /// Entries of both.
    #[inline]
    pub fn len(&self) -> u32 {
        self.entries() + self.groups * self.below * self.azimuths
    }

    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The place of a direction in the lookup.
#[derive(Clone, Copy)]
pub struct Place {
    /// Whether the direction meets the atmosphere; without it nothing else holds.
    pub is_lit: bool,
    /// Whether it is above the horizon.
    pub is_above: bool,
    /// Rows from the horizon.
    pub row: f32,
    /// Columns from the sun's azimuth.
    pub column: f32,
}

/// The place of a ray from any altitude, whose azimuth from the sun has the cosine `c`.
#[inline(always)]
pub fn place(lookup: MultipleLookup, atmosphere: &Atmosphere, ray: Ray, c: f32) -> Place {
    let mut mu = ray.mu;
    let mut is_lit = true;
    if ray.altitude > atmosphere.depth {
        let (inside, length) = inside_atmosphere(atmosphere.shell(), ray);
        mu = inside.mu;
        is_lit = length > 0.0;
    }
    let mut place = place_at(lookup, mu, c);
    place.is_lit = is_lit;
    place
}

/// The place of a direction with the cosine `mu` of its zenith angle, where the ray enters the atmosphere or begins,
/// and the cosine `c` of its azimuth from the sun.
#[inline(always)]
pub fn place_at(lookup: MultipleLookup, mu: f32, c: f32) -> Place {
    let elevation = 0.5 * PI - acos(mu);
    let is_above = elevation >= lookup.horizon;
    let (part, rows) = if is_above {
        ((elevation - lookup.horizon) / lookup.span_above, lookup.above)
    } else {
        ((lookup.horizon - elevation) / lookup.span_below, lookup.below)
    };
    let row = safe_sqrt(clamp(part, 0.0, 1.0)) * (rows - 1) as f32;
    Place { is_lit: true, is_above, row, column: place_of_azimuth(c) * (lookup.azimuths - 1) as f32 }
}

/// Light that air and aerosol scatter towards the observer, neither for the first time, at a group of four bands
/// (sr⁻¹).
#[inline(always)]
pub fn scattered(lookup: MultipleLookup, values: &[Vec4], place: Place, group: u32, variant: u32) -> Vec4 {
    max4(value(lookup, values, (0, group), place, variant), 0.0)
}

/// The value at a place of a group of a lookup whose entries begin at an index of `values`: of either sign, and 0 where
/// the ray meets no air.
#[inline(always)]
pub fn value(lookup: MultipleLookup, values: &[Vec4], (first, group): (u32, u32), place: Place, variant: u32) -> Vec4 {
    if !place.is_lit {
        return Vec4::ZERO;
    }
    let (first_row, rows) = if place.is_above { (0, lookup.above) } else { (lookup.above, lookup.below) };
    let first_row = group * (lookup.above + lookup.below) + first_row;
    between_entries(values, first + first_row * lookup.azimuths, rows, lookup.azimuths, place, variant)
}

/// Diffuse irradiance of the ground in a direction below the horizon, at a group of four bands; 0 above it.
#[inline(always)]
pub fn diffuse_irradiance(lookup: MultipleLookup, values: &[Vec4], place: Place, group: u32, variant: u32) -> Vec4 {
    if place.is_above {
        return Vec4::ZERO;
    }
    let first = lookup.entries() + group * lookup.below * lookup.azimuths;
    max4(between_entries(values, first, lookup.below, lookup.azimuths, place, variant), 0.0)
}

/// Between the entries of a part, of which the first of all rows is given: by cubics, or by straight lines where the
/// variant is [`variant::REFINED`].
#[inline(always)]
fn between_entries(values: &[Vec4], first: u32, rows: u32, columns: u32, place: Place, variant: u32) -> Vec4 {
    if variant & variant::REFINED != 0 {
        bilinear(values, first, rows, columns, place)
    } else {
        bicubic(values, first, rows, columns, place)
    }
}

/// Between two times two entries, of which the first of all rows is given.
#[inline(always)]
fn bilinear(values: &[Vec4], first: u32, rows: u32, columns: u32, place: Place) -> Vec4 {
    let first_row = min(floor(place.row), (rows - 2) as f32);
    let column = min(floor(place.column), (columns - 2) as f32);
    let at = (first + first_row as u32 * columns + column as u32) as usize;
    let (up, across) = (place.row - first_row, place.column - column);
    let above = at + columns as usize;
    let row = mix(fetch(values, at), fetch(values, at + 1), across);
    mix(row, mix(fetch(values, above), fetch(values, above + 1), across), up)
}

/// Between four times four entries, of which the first of all rows is given.
#[inline(always)]
fn bicubic(values: &[Vec4], first: u32, rows: u32, columns: u32, place: Place) -> Vec4 {
    let (across_rows, across_columns) = (stencil(place.row, rows), stencil(place.column, columns));
    let at = (first + across_rows.first * columns + across_columns.first) as usize;
    let columns = columns as usize;
    let (rows, weights) = (across_rows.weights, across_columns.weights);
    between(values, at, weights) * rows.x
        + between(values, at + columns, weights) * rows.y
        + between(values, at + 2 * columns, weights) * rows.z
        + between(values, at + 3 * columns, weights) * rows.w
}

/// Between four neighbours in a row.
#[inline(always)]
fn between(values: &[Vec4], at: usize, weights: Vec4) -> Vec4 {
    fetch(values, at) * weights.x
        + fetch(values, at + 1) * weights.y
        + fetch(values, at + 2) * weights.z
        + fetch(values, at + 3) * weights.w
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_interpolated_exactly_on_either_side_of_the_horizon() {
        let lookup = MultipleLookup {
            above: 6,
            below: 5,
            azimuths: 7,
            groups: 2,
            horizon: -0.1,
            span_above: 0.5 * PI + 0.1,
            span_below: 0.5 * PI - 0.1,
            padding: 0,
        };
        let cubic =
            |row: f32, column: f32, offset: f32| (row - 2.0) * (row - 1.0) * row + 0.3 * column * column + offset;
        let mut values = Vec::new();
        for group in 0..2 {
            for (rows, side) in [(6, 0.0), (5, 100.0)] {
                for row in 0..rows {
                    values.extend(
                        (0..7).map(|c| Vec4::splat(cubic(row as f32, c as f32, 20.0 + side + 1000.0 * group as f32))),
                    );
                }
            }
        }
        for group in 0..2 {
            for row in 0..5 {
                values.extend((0..7).map(|c| Vec4::splat(cubic(row as f32, c as f32, 5e4 + 1000.0 * group as f32))));
            }
        }
        assert_eq!(values.len(), lookup.len() as usize);
        for group in 0..2u32 {
            for (mu, side) in [(0.9f32, 0.0), (0.05, 0.0), (-0.09, 0.0), (-0.2, 100.0), (-0.95, 100.0), (-1.0, 100.0)] {
                for c in [-1.0f32, -0.4, 0.3, 1.0] {
                    let place = place_at(lookup, mu, c);
                    assert_eq!(place.is_above, side == 0.0);
                    let offset = 1000.0 * group as f32;
                    let expected = cubic(place.row, place.column, 20.0 + side + offset);
                    let found = scattered(lookup, &values, place, group, 0).x;
                    // Sixteen terms with weights of up to one, each rounded by 6e-8 of up to 2000.
                    assert!((found - expected).abs() < 2e-3, "{mu} {c}: {found}, not {expected}");
                    if !place.is_above {
                        let found = diffuse_irradiance(lookup, &values, place, group, 0).x;
                        let expected = cubic(place.row, place.column, 5e4 + offset);
                        assert!((found - expected).abs() < 5e-2, "{mu} {c}: {found}, not {expected}");
                    }
                }
            }
        }
    }
}
