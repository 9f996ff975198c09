//! The sky lookup for the pixels of a block: the steps of [`crate::lookup`], each for all pixels.

use super::colour::{BlockConstituents, with_phases_of_block};
use super::lanes::{BLOCK, Four, Lanes, Three, ZERO, lanes};
use super::pixels::{Pixels, Views};
use crate::camera::{EQUIRECTANGULAR, position_view};
use crate::cubic::Stencil;
use crate::glam::{Vec2, Vec4};
use crate::lookup::{
    AlongRow, GridPlace, RUN, RowPlace, along_row, grid_constituents, grid_place, ground_beneath, is_on_ground,
    row_constituents, row_place,
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
        along_row_of_block(uniform, entries, pixels, views, variant).constituents(uniform, views, pixels.count)
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

/// An [`AlongRow`] of each pixel.
struct BlockAlongRow {
    column: Lanes,
    colours: BlockConstituents,
    slopes: BlockConstituents,
}

impl BlockAlongRow {
    const NONE: Self = Self { column: ZERO, colours: BlockConstituents::DARK, slopes: BlockConstituents::DARK };

    #[inline(always)]
    fn set(&mut self, lane: usize, place: AlongRow) {
        self.column[lane] = place.column;
        self.colours.air.set(lane, place.air.truncate());
        self.slopes.air.set(lane, place.air_slope.truncate());
        self.colours.aerosol.set(lane, place.aerosol.truncate());
        self.slopes.aerosol.set(lane, place.aerosol_slope.truncate());
        self.colours.rest.set(lane, place.rest.truncate());
        self.slopes.rest.set(lane, place.rest_slope.truncate());
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> AlongRow {
        AlongRow {
            column: self.column[lane],
            air: self.colours.air.get(lane).extend(0.0),
            air_slope: self.slopes.air.get(lane).extend(0.0),
            aerosol: self.colours.aerosol.get(lane).extend(0.0),
            aerosol_slope: self.slopes.aerosol.get(lane).extend(0.0),
            rest: self.colours.rest.get(lane).extend(0.0),
            rest_slope: self.slopes.rest.get(lane).extend(0.0),
        }
    }

    #[inline(always)]
    fn constituents(&self, uniform: &Uniform, views: &Views, count: usize) -> BlockConstituents {
        const ALL: u32 = variant::AEROSOL | variant::REST;
        let mut sum = BlockConstituents::DARK;
        for lane in lanes(count) {
            // What the variant leaves out is zero here, and stays so.
            sum.set(lane, row_constituents(uniform, self.get(lane), views.directions.get(lane), ALL));
        }
        sum
    }
}

/// The colours along the row at each pixel, or in the middle of its run.
#[inline(always)]
fn along_row_of_block(
    uniform: &Uniform,
    entries: &[Vec4],
    pixels: Pixels,
    views: &Views,
    variant: u32,
) -> BlockAlongRow {
    let mut places = Places::NONE;
    let mut run = 1;
    if variant & variant::RUNS != 0 {
        run = RUN as usize;
        for index in lanes(pixels.count / run) {
            let middle = (pixels.first + RUN * index as u32 + RUN / 2) as f32;
            let middle = Vec2::new(middle, uniform.first_row as f32 + 0.5);
            places.set(index, row_place(uniform, position_view(&uniform.camera, EQUIRECTANGULAR, middle).direction));
        }
    } else {
        for lane in lanes(pixels.count) {
            places.set(lane, row_place(uniform, views.directions.get(lane)));
        }
    }
    let mut rows = BlockAlongRow::NONE;
    for index in lanes(pixels.count / run) {
        let row = along_row(uniform, entries, places.get(index), uniform.first_row, variant);
        for lane in index * run..(index + 1) * run {
            rows.set(lane, row);
        }
    }
    rows
}

/// A [`RowPlace`] of each pixel or run.
struct Places {
    column: Lanes,
    first: [u32; BLOCK],
    weights: Four,
    slopes: Four,
}

impl Places {
    const NONE: Self = Self { column: ZERO, first: [0; BLOCK], weights: Four::ZERO, slopes: Four::ZERO };

    #[inline(always)]
    fn set(&mut self, lane: usize, place: RowPlace) {
        self.column[lane] = place.column;
        self.first[lane] = place.near.first;
        self.weights.set(lane, place.near.weights);
        self.slopes.set(lane, place.near.slopes);
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> RowPlace {
        let near = Stencil { first: self.first[lane], weights: self.weights.get(lane), slopes: self.slopes.get(lane) };
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
