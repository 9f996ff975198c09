//! The sky lookup for the pixels of a block: the steps of [`crate::picture::lookup`], each for all pixels.

use super::colour::{BlockConstituents, with_phases_of_block};
use super::lanes::{BLOCK, Four, Three, lanes};
use super::pixels::{Pixels, Views, are_on_ground, put_ground};
use crate::camera::EQUIRECTANGULAR;
use crate::glam::{UVec2, Vec4};
use crate::interpolation::cubic::Stencil;
use crate::picture::below::{edge, sky_view};
use crate::picture::lookup::{
    GridPlace, along_anchors, along_row, anchor_columns_about, anchor_rows_about, between_rows, colours_per_entry,
    grid_constituents, grid_place, row_place, sky_at_pixel, store_entry,
};
use crate::uniform::Uniform;
use crate::variant;

/// [`crate::picture::lookup::sky_from_lookup`] of each pixel of a block.
#[inline(always)]
pub fn sky_of_block(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, views: &Views, variant: u32) -> Three {
    let mut sky = Three::ZERO;
    if are_on_ground(views, pixels.count) {
        put_ground(uniform, views, pixels.count, &mut sky);
        return sky;
    }
    let constituents = if variant::projection(variant) == EQUIRECTANGULAR {
        along_row_of_block(uniform, entries, pixels, views, variant)
    } else {
        in_grid(uniform, entries, pixels, views, variant)
    };
    sky = with_phases_of_block(uniform, &constituents, &views.directions, pixels.count, variant);
    smooth_edge(uniform, entries, pixels, views, &mut sky, variant);
    put_ground(uniform, views, pixels.count, &mut sky);
    sky
}

/// Gives pixels that the horizon crosses a part of either side.
#[inline(always)]
fn smooth_edge(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, views: &Views, sky: &mut Three, variant: u32) {
    for lane in lanes(pixels.count) {
        let (pixel, direction) = (UVec2::new(pixels.column(lane), uniform.first_row), views.directions.get(lane));
        let (.., part) = edge(uniform, pixel.x, pixel.y, direction, variant);
        if part > 0.0 && part < 1.0 {
            let view = sky_view(uniform, pixel.x, pixel.y, variant);
            sky.set(lane, sky_at_pixel(uniform, entries, pixel, view, variant));
        }
    }
}

/// Constituents along the row.
#[inline(always)]
fn along_row_of_block(
    uniform: &Uniform,
    entries: &[Vec4],
    pixels: Pixels,
    views: &Views,
    variant: u32,
) -> BlockConstituents {
    let mut places = Places::NONE;
    for lane in lanes(pixels.count) {
        places.set(lane, row_place(uniform, views.directions.get(lane)));
    }
    let mut sum = BlockConstituents::DARK;
    for lane in lanes(pixels.count) {
        sum.set(lane, along_row(uniform, entries, places.get(lane), views.source_row, variant));
    }
    sum
}

/// What a value needs of the [`Stencil`] of each pixel.
struct Places {
    first: [u32; BLOCK],
    weights: Four,
}

impl Places {
    const NONE: Self = Self { first: [0; BLOCK], weights: Four::ZERO };

    #[inline(always)]
    fn set(&mut self, lane: usize, near: Stencil) {
        self.first[lane] = near.first;
        self.weights.set(lane, near.weights);
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> Stencil {
        let (slopes, bends) = (Vec4::ZERO, Vec4::ZERO);
        Stencil { first: self.first[lane], weights: self.weights.get(lane), slopes, bends }
    }
}

/// Constituents between four entries, of a lookup that does not have the rows of its image.
#[inline(always)]
fn in_grid(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, views: &Views, variant: u32) -> BlockConstituents {
    let mut places = [GridPlace { entry: 0, across: 0.0, down: 0.0 }; BLOCK];
    for lane in lanes(pixels.count) {
        places[lane] = grid_place(uniform, views.sources.get(lane), variant);
    }
    let mut sum = BlockConstituents::DARK;
    for lane in lanes(pixels.count) {
        sum.set(lane, grid_constituents(uniform, entries, places[lane], variant));
    }
    sum
}

/// Rows of anchors of which a cubic goes through each column of entries.
const ROWS_OF_CUBIC: usize = 4;

/// [`crate::picture::lookup::entry_between_anchors`] of each entry of some rows from `first_row` on, which `entries`
/// holds alone. What lies between anchors of a row is found once for all rows of entries beside it. `are_read` says
/// which anchors are known; what lies between none of them is left as it is.
#[inline(always)]
pub fn entries_of_rows(
    uniform: &Uniform,
    anchors: &[Vec4],
    are_read: &[bool],
    entries: &mut [Vec4],
    first_row: u32,
    variant: u32,
) {
    let columns = uniform.lookup_azimuths as usize;
    for first in (0..columns).step_by(BLOCK) {
        let count = BLOCK.min(columns - first);
        let mut across = Places::NONE;
        for lane in lanes(count) {
            across.set(lane, anchor_columns_about(uniform, (first + lane) as u32));
        }
        let mut known: [Option<u32>; ROWS_OF_CUBIC] = [None; ROWS_OF_CUBIC];
        let mut between = [const { BlockConstituents::DARK }; ROWS_OF_CUBIC];
        for (row, entries) in entries.chunks_exact_mut(columns * colours_per_entry(variant) as usize).enumerate() {
            let down = anchor_rows_about(uniform, first_row + row as u32, variant);
            let rows = [0, 1, 2, 3].map(|index| down.first + index);
            let of_row = |&row: &u32| {
                let at = |column: u32| (row * uniform.anchor_azimuths + column) as usize;
                are_read[at(across.first[0])..at(across.first[count - 1] + 4)].contains(&true)
            };
            if !rows.iter().any(of_row) {
                continue;
            }
            for row in rows {
                let kept = row as usize % ROWS_OF_CUBIC;
                if known[kept] == Some(row) {
                    continue;
                }
                known[kept] = Some(row);
                for lane in lanes(count) {
                    between[kept].set(lane, along_anchors(uniform, anchors, 0, row, across.get(lane), variant));
                }
            }
            let [a, b, c, d] = rows.map(|row| &between[row as usize % ROWS_OF_CUBIC]);
            for lane in lanes(count) {
                let colours = between_rows(a.get(lane), b.get(lane), c.get(lane), d.get(lane), down.weights);
                store_entry(entries, (first + lane) as u32, colours, variant);
            }
        }
    }
}
