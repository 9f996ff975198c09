//! Runs of pixels of a block: the steps of [`crate::picture::run`], each for all runs.

use super::lanes::{BLOCK, Four, Lanes, Three, ZERO, lanes};
use super::pixels::Pixels;
use crate::camera::{EQUIRECTANGULAR, PERSPECTIVE, position_view};
use crate::glam::{UVec2, Vec4};
use crate::interpolation::cubic::Stencil;
use crate::picture::below::{sky_view, with_ground};
use crate::picture::lookup::sky_at_pixel;
use crate::picture::perspective_run::{PerspectiveRun, may_meet_horizon};
use crate::picture::run::{Circle, HalfAzimuth, Middle, RUN, Run, middle_position};
use crate::uniform::Uniform;
use crate::variant;

/// Linear RGB of the sky at each pixel of a block that is all of runs.
#[inline(always)]
pub fn sky_of_runs(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, variant: u32) -> Three {
    // All pixels of a row that runs share their row and their part of ground.
    let view = sky_view(uniform, pixels.first, uniform.first_row, variant);
    let mut sky = Three::ZERO;
    if view.ground < 1.0 {
        sky = sky_above(uniform, entries, pixels, [view.row, view.source_row], variant);
    }
    for lane in lanes(pixels.count) {
        sky.set(lane, with_ground(uniform, sky.get(lane), view.ground));
    }
    sky
}

/// The same without the ground before it; `rows` are those of an equirectangular image, of the direction and of the
/// source.
#[inline(always)]
fn sky_above(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, rows: [u32; 2], variant: u32) -> Three {
    let is_perspective = variant::projection(variant) == PERSPECTIVE;
    const REST: u32 = variant::AEROSOL | variant::REST;
    let image = variant & (variant::DESCENT | variant::IMAGE);
    if variant & variant::PHASE_TABLE != 0 {
        let reads = variant & (variant::PHASE_TABLE | REST);
        return match is_perspective {
            true => sky_of_perspective(uniform, entries, pixels, reads | image),
            false => sky_on_circle(uniform, entries, pixels, rows, reads),
        };
    }
    match (variant & variant::AEROSOL != 0, variant & variant::REST != 0) {
        (true, false) if is_perspective => sky_of_perspective(uniform, entries, pixels, variant::AEROSOL | image),
        (true, true) if is_perspective => sky_of_perspective(uniform, entries, pixels, REST | image),
        _ if is_perspective => sky_of_perspective(uniform, entries, pixels, variant),
        (true, false) => sky_on_circle(uniform, entries, pixels, rows, variant::AEROSOL),
        (true, true) => sky_on_circle(uniform, entries, pixels, rows, REST),
        _ => sky_on_circle(uniform, entries, pixels, rows, variant),
    }
}

/// The same in a perspective.
#[inline(always)]
fn sky_of_perspective(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, variant: u32) -> Three {
    let mut sky = Three::ZERO;
    for index in lanes(pixels.count / RUN as usize) {
        let column = pixels.first + RUN * index as u32;
        if may_meet_horizon(uniform, column, uniform.first_row, variant) {
            for pixel in 0..RUN {
                let at = UVec2::new(column + pixel, uniform.first_row);
                let view = sky_view(uniform, at.x, at.y, variant);
                let lane = (RUN as usize * index + pixel as usize) % BLOCK;
                sky.set(lane, sky_at_pixel(uniform, entries, at, view, variant));
            }
            continue;
        }
        let run = PerspectiveRun::new(uniform, entries, column, uniform.first_row, variant);
        for pixel in 0..RUN {
            let lane = (RUN as usize * index + pixel as usize) % BLOCK;
            sky.set(lane, run.sky(uniform, pixel, variant));
        }
    }
    sky
}

#[inline(always)]
fn sky_on_circle(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, rows: [u32; 2], variant: u32) -> Three {
    let [row, source_row] = rows;
    let circle = Circle::of_row(uniform, row);
    let mut middles = Middles::NONE;
    for index in lanes(pixels.count / RUN as usize) {
        let column = pixels.first + RUN * index as u32;
        let direction = position_view(&uniform.camera, EQUIRECTANGULAR, middle_position(column, row)).direction;
        middles.set(index, Middle::towards(uniform, direction));
    }
    let mut sky = Three::ZERO;
    for index in lanes(pixels.count / RUN as usize) {
        let run = Run::new(uniform, entries, circle, middles.get(index), source_row, variant);
        for pixel in 0..RUN {
            let lane = (RUN as usize * index + pixel as usize) % BLOCK;
            sky.set(lane, run.sky(uniform, pixel, variant));
        }
    }
    sky
}

/// The [`Middle`] of each run.
struct Middles {
    sine: Lanes,
    cosine: Lanes,
    column: Lanes,
    first: [u32; BLOCK],
    weights: Four,
    slopes: Four,
    bends: Four,
}

impl Middles {
    const NONE: Self = Self {
        sine: ZERO,
        cosine: ZERO,
        column: ZERO,
        first: [0; BLOCK],
        weights: Four::ZERO,
        slopes: Four::ZERO,
        bends: Four::ZERO,
    };

    #[inline(always)]
    fn set(&mut self, index: usize, middle: Middle) {
        self.sine[index] = middle.half.sine;
        self.cosine[index] = middle.half.cosine;
        self.column[index] = middle.column;
        self.first[index] = middle.near.first;
        self.weights.set(index, middle.near.weights);
        self.slopes.set(index, middle.near.slopes);
        self.bends.set(index, middle.near.bends);
    }

    #[inline(always)]
    fn get(&self, index: usize) -> Middle {
        let near = Stencil {
            first: self.first[index],
            weights: self.weights.get(index),
            slopes: self.slopes.get(index),
            bends: self.bends.get(index),
        };
        let half = HalfAzimuth { sine: self.sine[index], cosine: self.cosine[index] };
        Middle { half, column: self.column[index], near }
    }
}
