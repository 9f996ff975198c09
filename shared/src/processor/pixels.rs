//! The pixels of a block: their directions, and how their colours are stored.

use super::lanes::{BLOCK, Lanes, Three, ZERO, lanes};
use crate::camera::{EQUIRECTANGULAR, FISHEYE, OCTAHEDRAL, PERSPECTIVE};
use crate::glam::{UVec2, Vec3, Vec4};
use crate::kernels::{picture_word, seen, shown_in, store_rgb};
use crate::picture::below::{sky_view, with_ground};
use crate::picture::disc::is_beside_disc;
use crate::uniform::Uniform;
use crate::variant::{self, PixelFormat};

/// Neighbouring pixels of the row with which a dispatch begins.
#[derive(Clone, Copy)]
pub struct Pixels {
    /// The column of the first.
    pub first: u32,
    /// How many they are: [`BLOCK`] at most.
    pub count: usize,
}

impl Pixels {
    /// The column of one of them.
    #[inline(always)]
    pub fn column(self, lane: usize) -> u32 {
        self.first + lane as u32
    }
}

/// The views through the pixels of a block; see [`crate::picture::below::SkyView`].
pub struct Views {
    /// Their directions.
    pub directions: Three,
    /// Their sources.
    pub sources: Three,
    /// Whether the projection covers them at all.
    pub covered: [bool; BLOCK],
    /// Their parts of ground.
    pub ground: Lanes,
    /// The row of an equirectangular image in which all sources lie.
    pub source_row: u32,
}

/// The views through the pixels of a block.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
pub fn views(uniform: &Uniform, pixels: Pixels, variant: u32) -> Views {
    // The projection as a number that the compiler knows.
    let of = |projection| variant::with_projection(variant, projection);
    match variant::projection(variant) {
        EQUIRECTANGULAR => views_by(uniform, pixels, of(EQUIRECTANGULAR)),
        FISHEYE => views_by(uniform, pixels, of(FISHEYE)),
        OCTAHEDRAL => views_by(uniform, pixels, of(OCTAHEDRAL)),
        _ => views_by(uniform, pixels, of(PERSPECTIVE)),
    }
}

#[inline(always)]
fn views_by(uniform: &Uniform, pixels: Pixels, variant: u32) -> Views {
    let (directions, sources) = (Three::ZERO, Three::ZERO);
    let mut views = Views { directions, sources, covered: [false; BLOCK], ground: ZERO, source_row: uniform.first_row };
    for lane in lanes(pixels.count) {
        let view = sky_view(uniform, pixels.column(lane), uniform.first_row, variant);
        views.directions.set(lane, view.direction);
        views.covered[lane] = view.covered;
        views.ground[lane] = view.ground;
        views.sources.set(lane, view.source);
        views.source_row = view.source_row;
    }
    views
}

/// Whether all views of a block are of ground alone.
#[inline(always)]
pub fn are_on_ground(views: &Views, count: usize) -> bool {
    let mut are_on_ground = true;
    for lane in lanes(count) {
        are_on_ground &= views.ground[lane] >= 1.0;
    }
    are_on_ground
}

/// Puts the ground before the sky.
#[inline(always)]
pub fn put_ground(uniform: &Uniform, views: &Views, count: usize, sky: &mut Three) {
    for lane in lanes(count) {
        sky.set(lane, with_ground(uniform, sky.get(lane), views.ground[lane]));
    }
}

/// Blackens what the projection does not cover.
#[inline(always)]
pub fn blacken(views: &Views, count: usize, rgb: &mut Three) {
    for lane in lanes(count) {
        let covered = rgb.get(lane);
        rgb.set(lane, if views.covered[lane] { covered } else { Vec3::ZERO });
    }
}

/// Makes colours of the sky those that are stored, with the sun's disc before them: in a picture those of a display.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
pub fn show(uniform: &Uniform, colour: &[Vec4], pixels: Pixels, rgb: &mut Three, variant: u32) {
    if !is_beside_disc(uniform, uniform.first_row, variant) {
        for lane in lanes(pixels.count) {
            let pixel = UVec2::new(pixels.column(lane), 0);
            rgb.set(lane, seen(uniform, colour, pixel, rgb.get(lane), variant));
        }
    } else if variant::pixel_format(variant) == PixelFormat::Picture as u32 {
        let count = pixels.count;
        // Of what the compiler knows it makes a loop that spreads over lanes.
        match variant & (variant::AGX | variant::ACES | variant::SELDOM) {
            variant::AGX => show_each(uniform, colour, count, rgb, PICTURE | variant::AGX),
            variant::ACES => show_each(uniform, colour, count, rgb, PICTURE | variant::ACES),
            0 => show_each(uniform, colour, count, rgb, PICTURE),
            _ => show_each(uniform, colour, count, rgb, variant),
        }
    }
}

/// The variant of a picture, and nothing more.
const PICTURE: u32 = (PixelFormat::Picture as u32) << variant::PIXEL_FORMAT_SHIFT;

#[inline(always)]
fn show_each(uniform: &Uniform, colour: &[Vec4], count: usize, rgb: &mut Three, variant: u32) {
    for lane in lanes(count) {
        rgb.set(lane, shown_in(uniform, colour, rgb.get(lane), variant));
    }
}

/// Stores the colours of a block as the variant's [`PixelFormat`] says; `output` holds its pixels alone.
#[inline(always)]
pub fn store_block(uniform: &Uniform, output: &mut [u32], pixels: Pixels, rgb: &Three, variant: u32) {
    let format = variant::pixel_format(variant);
    if format == PixelFormat::Picture as u32 {
        if variant & variant::DITHER != 0 {
            store_picture(uniform, output, pixels, rgb, variant::DITHER);
        } else {
            store_picture(uniform, output, pixels, rgb, 0);
        }
    } else if format == PixelFormat::LinearRgb as u32 {
        for (pixel, lane) in output.as_chunks_mut::<3>().0.iter_mut().zip(lanes(pixels.count)) {
            *pixel = rgb.get(lane).to_array().map(f32::to_bits);
        }
    } else {
        for lane in lanes(pixels.count) {
            store_rgb(uniform, output, UVec2::new(lane as u32, 0), rgb.get(lane), variant);
        }
    }
}

#[inline(always)]
fn store_picture(uniform: &Uniform, output: &mut [u32], pixels: Pixels, rgb: &Three, variant: u32) {
    for (word, lane) in output.iter_mut().zip(lanes(pixels.count)) {
        *word = picture_word(pixels.column(lane), uniform.first_row, rgb.get(lane), variant);
    }
}
