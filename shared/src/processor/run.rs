//! Runs of pixels of a block: the steps of [`crate::picture::run`], each for all runs.

use super::lanes::{BLOCK, Four, Lanes, Three, ZERO, lanes};
use super::pixels::Pixels;
use crate::camera::{EQUIRECTANGULAR, PERSPECTIVE, position_view};
use crate::display::tone::encoded;
use crate::glam::{UVec2, Vec4};
use crate::interpolation::cubic::Stencil;
use crate::kernels::interpolated_word;
use crate::picture::below::{sky_view, with_ground};
use crate::picture::formed_run::{FORMED, FormedRun, from_middle_to_formed};
use crate::picture::lookup::sky_at_pixel;
use crate::picture::perspective_run::{PerspectiveRun, may_meet_horizon};
use crate::picture::run::{Circle, HalfAzimuth, Middle, RUN, Run, from_middle, middle_position};
use crate::uniform::Uniform;
use crate::variant;

/// Points of a run whose sky is wanted: its pixels, or the places of [`crate::picture::formed_run`].
pub const AT_PIXELS: usize = RUN as usize;
/// See [`AT_PIXELS`].
pub const AT_PLACES: usize = FORMED as usize;

/// Runs of a block.
#[inline(always)]
pub fn runs(pixels: Pixels) -> usize {
    pixels.count / RUN as usize
}

/// Pixels from the middle of a run to one of so many points of it.
#[inline(always)]
fn beside<const POINTS: usize>(point: usize) -> f32 {
    if POINTS == AT_PLACES { from_middle_to_formed(point as u32) } else { from_middle(point as u32) }
}

/// Linear RGB of the sky at so many points of each run of a block that is all of runs, run after run, with no more
/// than a part of ground before it.
#[inline(always)]
pub fn sky_of_runs<const POINTS: usize>(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, variant: u32) -> Three {
    // All pixels of a row that runs share their row and their part of ground.
    let view = sky_view(uniform, pixels.first, uniform.first_row, variant);
    let mut sky = sky_above::<POINTS>(uniform, entries, pixels, [view.row, view.source_row], variant);
    for lane in lanes(POINTS * runs(pixels)) {
        sky.set(lane, with_ground(uniform, sky.get(lane), view.ground));
    }
    sky
}

/// The same without the ground before it; `rows` are those of an equirectangular image, of the direction and of the
/// source.
#[inline(always)]
fn sky_above<const POINTS: usize>(
    uniform: &Uniform,
    entries: &[Vec4],
    pixels: Pixels,
    rows: [u32; 2],
    variant: u32,
) -> Three {
    let is_perspective = variant::projection(variant) == PERSPECTIVE;
    const REST: u32 = variant::AEROSOL | variant::REST;
    let image = variant & (variant::DESCENT | variant::IMAGE);
    if variant & variant::PHASE_TABLE != 0 {
        let reads = variant & (variant::PHASE_TABLE | REST);
        return match is_perspective {
            true => sky_of_perspective::<POINTS>(uniform, entries, pixels, reads | image),
            false => sky_on_circle::<POINTS>(uniform, entries, pixels, rows, reads),
        };
    }
    match (variant & variant::AEROSOL != 0, variant & variant::REST != 0) {
        (true, false) if is_perspective => {
            sky_of_perspective::<POINTS>(uniform, entries, pixels, variant::AEROSOL | image)
        }
        (true, true) if is_perspective => sky_of_perspective::<POINTS>(uniform, entries, pixels, REST | image),
        _ if is_perspective => sky_of_perspective::<POINTS>(uniform, entries, pixels, variant),
        (true, false) => sky_on_circle::<POINTS>(uniform, entries, pixels, rows, variant::AEROSOL),
        (true, true) => sky_on_circle::<POINTS>(uniform, entries, pixels, rows, REST),
        _ => sky_on_circle::<POINTS>(uniform, entries, pixels, rows, variant),
    }
}

/// The same in a perspective.
#[inline(always)]
fn sky_of_perspective<const POINTS: usize>(uniform: &Uniform, entries: &[Vec4], pixels: Pixels, variant: u32) -> Three {
    let mut sky = Three::ZERO;
    for index in lanes(runs(pixels)) {
        let column = pixels.first + RUN * index as u32;
        if may_meet_horizon(uniform, column, uniform.first_row, variant) {
            // It has no places.
            for pixel in 0..if POINTS == AT_PLACES { 0 } else { RUN } {
                let at = UVec2::new(column + pixel, uniform.first_row);
                let view = sky_view(uniform, at.x, at.y, variant);
                let lane = (RUN as usize * index + pixel as usize) % BLOCK;
                sky.set(lane, sky_at_pixel(uniform, entries, at, view, variant));
            }
            continue;
        }
        let run = PerspectiveRun::new(uniform, entries, column, uniform.first_row, variant);
        for point in 0..POINTS {
            sky.set((POINTS * index + point) % BLOCK, run.sky(uniform, beside::<POINTS>(point), variant));
        }
    }
    sky
}

#[inline(always)]
fn sky_on_circle<const POINTS: usize>(
    uniform: &Uniform,
    entries: &[Vec4],
    pixels: Pixels,
    rows: [u32; 2],
    variant: u32,
) -> Three {
    let [row, source_row] = rows;
    let circle = Circle::of_row(uniform, row);
    let mut middles = Middles::NONE;
    for index in lanes(runs(pixels)) {
        let column = pixels.first + RUN * index as u32;
        let direction = position_view(&uniform.camera, EQUIRECTANGULAR, middle_position(column, row)).direction;
        middles.set(index, Middle::towards(uniform, direction));
    }
    let mut sky = Three::ZERO;
    for index in lanes(runs(pixels)) {
        let run = Run::new(uniform, entries, circle, middles.get(index), source_row, variant);
        for point in 0..POINTS {
            sky.set((POINTS * index + point) % BLOCK, run.sky(uniform, beside::<POINTS>(point), variant));
        }
    }
    sky
}

/// Brings colours of a display, run after run, into the curve of sRGB.
#[inline(always)]
pub fn encode(rgb: &mut Three, count: usize) {
    for lane in lanes(count) {
        rgb.set(lane, encoded(rgb.get(lane)));
    }
}

/// Stores those runs of a block that are smooth between their places; returns whether all are. `at_places` is what a
/// display shows there, in the curve of sRGB.
#[inline(always)]
pub fn store_smooth(uniform: &Uniform, output: &mut [u32], pixels: Pixels, at_places: &Three, variant: u32) -> bool {
    let is_perspective = variant::projection(variant) == PERSPECTIVE;
    let mut are_smooth = true;
    for (index, output) in output.chunks_exact_mut(RUN as usize).enumerate() {
        let mut run = FormedRun::BLACK;
        for place in 0..FORMED {
            run.add(at_places.get((AT_PLACES * index + place as usize) % BLOCK), place);
        }
        let column = pixels.first + RUN * index as u32;
        let has_places = !(is_perspective && may_meet_horizon(uniform, column, uniform.first_row, variant));
        if has_places & run.is_smooth() {
            // Each compiled for itself.
            if variant & variant::DITHER != 0 {
                store_run(uniform, output, column, run, variant::DITHER);
            } else {
                store_run(uniform, output, column, run, 0);
            }
        } else {
            are_smooth = false;
        }
    }
    are_smooth
}

#[inline(always)]
fn store_run(uniform: &Uniform, output: &mut [u32], column: u32, run: FormedRun, variant: u32) {
    for (word, pixel) in output.iter_mut().zip(0..RUN) {
        *word = interpolated_word(column + pixel, uniform.first_row, run.beside(from_middle(pixel)), variant);
    }
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
