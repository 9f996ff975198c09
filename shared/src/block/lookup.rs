//! The sky lookup for the pixels of a block: the steps of [`crate::lookup`], each for all pixels.

use super::colour::{BlockConstituents, with_phases_of_block};
use super::lanes::{BLOCK, Four, Lanes, Three, ZERO, lanes};
use super::pixels::{Pixels, Views};
use crate::camera::{EQUIRECTANGULAR, position_view};
use crate::cubic::Stencil;
use crate::glam::{Vec2, Vec4};
use crate::lookup::{
    GridPlace, RUN, RowPlace, along_row, grid_constituents, grid_place, ground_beneath, is_on_ground, row_constituents,
    row_place,
};
use crate::uniform::Uniform;
use crate::variant;

/// [`crate::lookup::sky_from_lookup`] of each pixel of a block; of a variant with runs, as the kernel does it.
#[inline(always)]
pub fn sky_of_block(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, views: &Views, variant: u32) -> Three {
    // Rows of the lookup are rows of an equirectangular image, none of which is of sky and of ground at once.
    if variant::projection(variant) == EQUIRECTANGULAR && is_on_ground(views.directions.get(0), variant) {
        let mut ground = Three::ZERO;
        for lane in lanes(pixels.count) {
            ground.set(lane, ground_beneath(uniform, variant));
        }
        return ground;
    }
    let constituents = if variant::projection(variant) == EQUIRECTANGULAR {
        along_row_of_block(uniform, entries, pixels, views, variant)
    } else {
        in_grid(uniform, entries, pixels, views, variant)
    };
    let mut sky = with_phases_of_block(uniform, &constituents, &views.directions, pixels.count, variant);
    if variant & variant::DESCENT == 0 {
        let ground = ground_beneath(uniform, variant);
        for lane in lanes(pixels.count) {
            let above = sky.get(lane);
            let on_ground = is_on_ground(views.directions.get(lane), variant);
            sky.set(lane, if on_ground { ground } else { above });
        }
    }
    sky
}

/// Constituents along the row, of each pixel at its own place or beside the middle of its run.
#[inline(always)]
fn along_row_of_block(
    uniform: &Uniform,
    entries: &[Vec4],
    pixels: Pixels,
    views: &Views,
    variant: u32,
) -> BlockConstituents {
    if variant & variant::RUNS != 0 {
        return along_runs(uniform, entries, pixels, views, variant);
    }
    let mut places = Places::NONE;
    for lane in lanes(pixels.count) {
        places.set(lane, row_place(uniform, views.directions.get(lane)));
    }
    let mut sum = BlockConstituents::DARK;
    for lane in lanes(pixels.count) {
        let place = along_row(uniform, entries, places.get(lane), uniform.first_row, variant);
        sum.set(lane, row_constituents(uniform, place, views.directions.get(lane), variant));
    }
    sum
}

/// The same of a row in runs.
#[inline(always)]
fn along_runs(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, views: &Views, variant: u32) -> BlockConstituents {
    const ALL: u32 = variant::AEROSOL | variant::REST;
    let mut places = Places::NONE;
    for index in lanes(pixels.count / RUN as usize) {
        let middle = (pixels.first + RUN * index as u32 + RUN / 2) as f32;
        let middle = Vec2::new(middle, uniform.first_row as f32 + 0.5);
        places.set(index, row_place(uniform, position_view(&uniform.camera, EQUIRECTANGULAR, middle).direction));
    }
    let mut sum = BlockConstituents::DARK;
    for index in lanes(pixels.count / RUN as usize) {
        let place = along_row(uniform, entries, places.get(index), uniform.first_row, variant);
        // What the variant leaves out is dark here, and stays so.
        for lane in 0..RUN as usize {
            let lane = (RUN as usize * index + lane) % BLOCK;
            sum.set(lane, row_constituents(uniform, place, views.directions.get(lane), ALL));
        }
    }
    sum
}

/// A [`RowPlace`] of each pixel or run.
struct Places {
    column: Lanes,
    first: [u32; BLOCK],
    weights: Four,
    slopes: Four,
    bends: Four,
}

impl Places {
    const NONE: Self =
        Self { column: ZERO, first: [0; BLOCK], weights: Four::ZERO, slopes: Four::ZERO, bends: Four::ZERO };

    #[inline(always)]
    fn set(&mut self, lane: usize, place: RowPlace) {
        self.column[lane] = place.column;
        self.first[lane] = place.near.first;
        self.weights.set(lane, place.near.weights);
        self.slopes.set(lane, place.near.slopes);
        self.bends.set(lane, place.near.bends);
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> RowPlace {
        let near = Stencil {
            first: self.first[lane],
            weights: self.weights.get(lane),
            slopes: self.slopes.get(lane),
            bends: self.bends.get(lane),
        };
        RowPlace { column: self.column[lane], near }
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
