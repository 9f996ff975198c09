//! Runs of pixels of a block: the steps of [`crate::run`], each for all runs.

use super::lanes::{BLOCK, Four, Lanes, Three, ZERO, lanes};
use super::pixels::Pixels;
use crate::camera::{EQUIRECTANGULAR, PERSPECTIVE, pixel_view, position_view};
use crate::cubic::Stencil;
use crate::glam::Vec4;
use crate::lookup::{ground_beneath, is_on_ground, sky_in_grid};
use crate::perspective_run::{PerspectiveRun, may_meet_horizon};
use crate::run::{Circle, HalfAzimuth, Middle, RUN, Run, middle_direction, middle_position};
use crate::uniform::Uniform;
use crate::variant;

/// Linear RGB of the sky at each pixel of a block that is all of runs.
#[inline(always)]
pub fn sky_of_runs(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, variant: u32) -> Three {
    let first = middle_direction(uniform, pixels.first, uniform.first_row, variant);
    if is_on_ground(first, variant) {
        let mut ground = Three::ZERO;
        for lane in lanes(pixels.count) {
            ground.set(lane, ground_beneath(uniform, variant));
        }
        return ground;
    }
    let is_perspective = variant::projection(variant) == PERSPECTIVE;
    const REST: u32 = variant::AEROSOL | variant::REST;
    let descent = variant & variant::DESCENT;
    match (variant & variant::AEROSOL != 0, variant & variant::REST != 0) {
        (true, false) if is_perspective => sky_of_perspective(uniform, entries, pixels, variant::AEROSOL | descent),
        (true, true) if is_perspective => sky_of_perspective(uniform, entries, pixels, REST | descent),
        _ if is_perspective => sky_of_perspective(uniform, entries, pixels, variant),
        (true, false) => sky_on_circle(uniform, entries, pixels, variant::AEROSOL),
        (true, true) => sky_on_circle(uniform, entries, pixels, REST),
        _ => sky_on_circle(uniform, entries, pixels, variant),
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
                let view = pixel_view(&uniform.camera, PERSPECTIVE, column + pixel, uniform.first_row);
                let lane = (RUN as usize * index + pixel as usize) % BLOCK;
                sky.set(lane, sky_in_grid(uniform, entries, view.direction, variant));
            }
            continue;
        }
        let run = PerspectiveRun::new(uniform, entries, column, uniform.first_row, variant);
        for pixel in 0..RUN {
            let lane = (RUN as usize * index + pixel as usize) % BLOCK;
            sky.set(lane, run.sky(pixel, variant));
        }
    }
    sky
}

#[inline(always)]
fn sky_on_circle(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, variant: u32) -> Three {
    let circle = Circle::of_row(uniform, uniform.first_row);
    let mut middles = Middles::NONE;
    for index in lanes(pixels.count / RUN as usize) {
        let column = pixels.first + RUN * index as u32;
        let direction =
            position_view(&uniform.camera, EQUIRECTANGULAR, middle_position(column, uniform.first_row)).direction;
        middles.set(index, Middle::towards(uniform, direction));
    }
    let mut sky = Three::ZERO;
    for index in lanes(pixels.count / RUN as usize) {
        let run = Run::new(uniform, entries, circle, middles.get(index), uniform.first_row, variant);
        for pixel in 0..RUN {
            let lane = (RUN as usize * index + pixel as usize) % BLOCK;
            sky.set(lane, run.sky(pixel, variant));
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
