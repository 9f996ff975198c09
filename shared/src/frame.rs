//! The door to this crate: what a frame needs to know, and one function per kernel.
//!
//! A kernel is a pure function of the frame's parameters, its tables and an index. A GPU entry point fetches its index, calls
//! the function and stores the result; the CPU calls the same function in a loop.

use bytemuck::{Pod, Zeroable};

use crate::atmosphere::Atmosphere;
use crate::camera::{Camera, EQUIRECTANGULAR, PixelView, pixel_view, position_view};
use crate::color::{RgbSpace, srgb8};
use crate::glam::{Vec2, Vec3, Vec4};
use crate::math::{fetch, half_bits, store};
use crate::scattering::Bands;
use crate::sky::{Constituents, constituents, sky, transfer, view_ray};
use crate::sky_table::RUN;
use crate::sun_disc::{SunDisc, disc_in_pixel};
use crate::{sky_spectrum, sky_table, variant};

/// Pixels along each side of a GPU workgroup. The entry points repeat it as a literal, which a test compares.
pub const WORKGROUP_SIDE: u32 = 16;

/// Entries of the sky table in a workgroup; likewise.
pub const TABLE_WORKGROUP: u32 = 64;

/// Everything about a frame that every pixel shares. The layout is that of a GPU uniform buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Frame {
    /// Planet and profiles.
    pub atmosphere: Atmosphere,
    /// Camera and image size.
    pub camera: Camera,
    /// Unit vector to the sun; `w` unused.
    pub sun: Vec4,
    /// Unit vector along the ground to the sun's bearing; `z` and `w` are 0.
    pub bearing: Vec4,
    /// Wavelengths of the first four bands, mapped to [-1, 1] over the observer's range.
    pub nodes: Vec4,
    /// The space of linear RGB that pixels are stored in.
    pub rgb: RgbSpace,
    /// The sun's disc, where the variant has it.
    pub disc: SunDisc,
    /// Altitude of the observer (km).
    pub altitude: f32,
    /// First row of the image that this dispatch computes.
    pub first_row: u32,
    /// Rows that this dispatch computes.
    pub rows: u32,
    /// Factor from linear RGB to a picture's linear value.
    pub exposure: f32,
    /// Nodes of the learnt fit of air.
    pub air_nodes: u32,
    /// Nodes of the learnt fit of aerosol, which follow those of air in the table; 0 without aerosol.
    pub aerosol_nodes: u32,
    /// Rows of the sky table above the horizon; 0 without a table. For an equirectangular image they are its own.
    pub table_above: u32,
    /// Rows of the sky table below the horizon, likewise; 0 from the ground itself, where nothing is seen there.
    pub table_below: u32,
    /// Columns of the sky table.
    pub table_azimuths: u32,
    /// Elevation of the horizon (radians): 0 on the ground, negative above it.
    pub horizon: f32,
    /// Wavelengths of a spectral image, whose rows stand last in the colour table; 0 for other images.
    pub wavelengths: u32,
    /// Unused; fills the last 16 bytes.
    pub padding: u32,
}

/// How a pixel of the sky is stored.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pixel {
    /// Three `f32` words: linear RGB.
    LinearRgb = 0,
    /// One word: 8 bit sRGB, exposed, red in the lowest byte.
    Picture = 1,
    /// Two words: linear RGB as half floats, red and green, then blue and 1.
    HalfRgb = 2,
}

impl Pixel {
    /// Words that a pixel takes.
    pub const fn words(self) -> u32 {
        match self {
            Self::LinearRgb => 3,
            Self::Picture => 1,
            Self::HalfRgb => 2,
        }
    }
}

/// A bit pattern that no kernel stores, a NaN and a picture of alpha 0: what the output holds before a kernel runs.
pub const SENTINEL: u32 = 0x7fff_ffff;

/// Stores a pixel's linear RGB as the variant's [`Pixel`] says; `index` counts pixels from the output's start.
#[inline]
pub fn store_rgb(frame: &Frame, output: &mut [u32], index: u32, rgb: Vec3, variant: u32) {
    let pixel = variant::pixel(variant);
    if pixel == Pixel::Picture as u32 {
        store(output, index as usize, srgb8(rgb, frame.exposure));
    } else if pixel == Pixel::HalfRgb as u32 {
        let at = 2 * index as usize;
        store(output, at, half_bits(rgb.x) | (half_bits(rgb.y) << 16));
        store(output, at + 1, half_bits(rgb.z) | (half_bits(1.0) << 16));
    } else {
        let at = 3 * index as usize;
        store(output, at, rgb.x.to_bits());
        store(output, at + 1, rgb.y.to_bits());
        store(output, at + 2, rgb.z.to_bits());
    }
}

/// Stores a pixel's radiance at a group of four bands (W·m⁻²·sr⁻¹·nm⁻¹); the groups of a pixel follow each other.
#[inline]
pub fn store_radiance(output: &mut [u32], index: u32, groups: u32, group: u32, radiance: Vec4) {
    let at = 4 * (index * groups + group) as usize;
    store(output, at, radiance.x.to_bits());
    store(output, at + 1, radiance.y.to_bits());
    store(output, at + 2, radiance.z.to_bits());
    store(output, at + 3, radiance.w.to_bits());
}

/// The view through a pixel; `row` counts from the dispatch's first row.
#[inline]
pub fn view(frame: &Frame, column: u32, row: u32, variant: u32) -> PixelView {
    pixel_view(&frame.camera, variant::projection(variant), column, frame.first_row + row)
}

/// Kernel `radiance`: a pixel's radiance at every band, nothing more. This is where the paper's own GPU part ends.
#[inline]
pub fn radiance_pixel(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    output: &mut [u32],
    column: u32,
    row: u32,
    variant: u32,
) {
    let view = view(frame, column, row, variant);
    let mut group = 0;
    while group < bands.len() {
        let mut radiance = Vec4::ZERO;
        if view.covered {
            let four = fetch(bands, group);
            radiance = transfer(frame, &four, quadrature, view.direction, variant) * four.solar_irradiance;
        }
        store_radiance(output, index(frame, column, row), bands.len() as u32, group as u32, radiance);
        group += 1;
    }
}

/// Kernels `sky_linear`, `sky_solve`, `sky_learnt` and `sky_learnt_solve`: the sky's colour at a pixel by a fit of the
/// kind [`crate::sky`] names, integrated at the pixel itself, and stored.
#[inline]
pub fn sky_pixel(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    output: &mut [u32],
    column: u32,
    row: u32,
    fit: u32,
    variant: u32,
) {
    let view = view(frame, column, row, variant);
    let mut rgb = Vec3::ZERO;
    if view.covered {
        rgb = sky(frame, bands, quadrature, colour, view.direction, fit, variant);
        if variant & variant::SUN_DISC != 0 {
            rgb += disc_in_pixel(frame, colour, column, frame.first_row + row, variant);
        }
    }
    store_rgb(frame, output, index(frame, column, row), rgb, variant);
}

/// Kernels `spectrum_linear` and `spectrum_learnt`: linear RGB and the radiance at every wavelength of a spectral image, see
/// [`sky_spectrum`], integrated at the pixel itself, and stored.
#[inline]
pub fn spectrum_pixel(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    output: &mut [u32],
    column: u32,
    row: u32,
    fit: u32,
    variant: u32,
) {
    let view = view(frame, column, row, variant);
    let at = (index(frame, column, row) * sky_spectrum::words(frame)) as usize;
    if view.covered {
        sky_spectrum::store_spectrum(frame, bands, quadrature, colour, output, at, view.direction, fit, variant);
    } else {
        sky_spectrum::store_black(frame, output, at);
    }
}

/// Kernels `table_linear` and `table_learnt`: the colours of an entry of the sky table.
#[inline]
pub fn table_colours(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    entry: u32,
    fit: u32,
    variant: u32,
) -> Constituents {
    let ray = view_ray(frame, sky_table::entry_view(frame, entry, variant));
    constituents(frame, bands, quadrature, colour, ray, fit, variant)
}

/// Invocations of the kernel `sky_table` for a row: one for a pixel, or for a run of them.
#[inline]
pub fn table_columns(frame: &Frame, variant: u32) -> u32 {
    if variant & variant::RUNS != 0 { frame.camera.width / RUN } else { frame.camera.width }
}

/// Kernel `sky_table`: the sky's colour from the sky table at a pixel, or at a run of pixels in a row, stored. `column` counts what an
/// invocation does.
#[inline]
pub fn table_pixel(
    frame: &Frame,
    colour: &[Vec4],
    table: &[Vec4],
    output: &mut [u32],
    column: u32,
    row: u32,
    variant: u32,
) {
    if variant & variant::RUNS != 0 {
        let first = RUN * column;
        let whole_row = frame.first_row + row;
        let middle = Vec2::new((first + RUN / 2) as f32, whole_row as f32 + 0.5);
        let direction = position_view(&frame.camera, EQUIRECTANGULAR, middle).direction;
        let between = sky_table::neighbours(frame, table, direction, whole_row, variant);
        let mut pixel = first;
        while pixel < first + RUN {
            let direction = view(frame, pixel, row, variant).direction;
            let rgb = sky_table::sky_between(frame, between, direction, variant);
            store_looked_up(frame, colour, output, pixel, row, rgb, variant);
            pixel += 1;
        }
    } else {
        let view = view(frame, column, row, variant);
        if view.covered {
            let rgb = sky_table::sky_from_table(frame, table, view.direction, frame.first_row + row, variant);
            store_looked_up(frame, colour, output, column, row, rgb, variant);
        } else {
            store_rgb(frame, output, index(frame, column, row), Vec3::ZERO, variant);
        }
    }
}

/// Stores a colour of the sky, with the sun's disc before it.
#[inline]
fn store_looked_up(frame: &Frame, colour: &[Vec4], output: &mut [u32], column: u32, row: u32, sky: Vec3, variant: u32) {
    let mut rgb = sky;
    if variant & variant::SUN_DISC != 0 {
        rgb += disc_in_pixel(frame, colour, column, frame.first_row + row, variant);
    }
    store_rgb(frame, output, index(frame, column, row), rgb, variant);
}

/// Where a pixel stands in the output of its dispatch, in pixels.
#[inline]
fn index(frame: &Frame, column: u32, row: u32) -> u32 {
    row * frame.camera.width + column
}
