//! The sky lookup for the pixels of a block: the steps of [`crate::lookup`], each for all pixels.

use super::colour::{BlockConstituents, with_phases_of_block};
use super::lanes::{BLOCK, Four, Three, lanes};
use super::pixels::{Pixels, Views, put_ground};
use crate::camera::EQUIRECTANGULAR;
use crate::cubic::Stencil;
use crate::glam::Vec4;
use crate::lookup::{GridPlace, along_row, grid_constituents, grid_place, is_on_ground, row_place};
use crate::uniform::Uniform;
use crate::variant;

/// [`crate::lookup::sky_from_lookup`] of each pixel of a block.
#[inline(always)]
pub fn sky_of_block(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, views: &Views, variant: u32) -> Three {
    // Rows of the lookup are rows of an equirectangular image, none of which is of sky and of ground at once.
    if variant::projection(variant) == EQUIRECTANGULAR && is_on_ground(views.directions.get(0), variant) {
        let mut ground = Three::ZERO;
        put_ground(uniform, views, pixels.count, &mut ground, variant);
        return ground;
    }
    let constituents = if variant::projection(variant) == EQUIRECTANGULAR {
        along_row_of_block(uniform, entries, pixels, views, variant)
    } else {
        in_grid(uniform, entries, pixels, views, variant)
    };
    let mut sky = with_phases_of_block(uniform, &constituents, &views.directions, pixels.count, variant);
    put_ground(uniform, views, pixels.count, &mut sky, variant);
    sky
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
        sum.set(lane, along_row(uniform, entries, places.get(lane), uniform.first_row, variant));
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
        places[lane] = grid_place(uniform, views.directions.get(lane), variant);
    }
    let mut sum = BlockConstituents::DARK;
    for lane in lanes(pixels.count) {
        sum.set(lane, grid_constituents(uniform, entries, places[lane], variant));
    }
    sum
}
