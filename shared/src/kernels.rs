//! The door to this crate: one function per kernel.
//!
//! A kernel is a pure function of the uniform, the buffers and an index. A GPU entry point fetches its index, calls
//! the function and stores the result; the CPU calls the same function in a loop.

use crate::camera::{EQUIRECTANGULAR, PixelView, pixel_view, position_view};
use crate::disc::disc_in_pixel;
use crate::glam::{Vec2, Vec3, Vec4};
use crate::lookup::{self, RUN};
use crate::math::{fetch, half_bits, store};
use crate::sky::{Constituents, constituents, sky, transfer};
use crate::spectral;
use crate::tone::{NEAREST, dither, srgb8};
use crate::uniform::{Buffers, Uniform};
use crate::variant::{self, PixelFormat};

/// Pixels along each side of a GPU workgroup. The entry points repeat it as a literal, which a test compares.
pub const WORKGROUP_SIDE: u32 = 16;

/// Entries of the sky lookup in a workgroup; likewise.
pub const LOOKUP_WORKGROUP: u32 = 64;

/// A bit pattern that no kernel stores, a NaN and a picture of alpha 0: what the output holds before a kernel runs.
pub const SENTINEL: u32 = 0x7fff_ffff;

/// Stores a pixel's linear RGB as the variant's [`PixelFormat`] says; `row` counts from the dispatch's first row.
#[inline(always)]
pub fn store_rgb(uniform: &Uniform, output: &mut [u32], column: u32, row: u32, rgb: Vec3, variant: u32) {
    let index = index(uniform, column, row);
    let format = variant::pixel_format(variant);
    if format == PixelFormat::Picture as u32 {
        let word = picture_word(uniform, column, uniform.first_row + row, rgb, variant);
        store(output, index as usize, word);
    } else if format == PixelFormat::HalfRgb as u32 {
        let at = 2 * index as usize;
        store(output, at, half_bits(rgb.x) | (half_bits(rgb.y) << 16));
        store(output, at + 1, half_bits(rgb.z) | (half_bits(1.0) << 16));
    } else {
        let has_alpha = format == PixelFormat::LinearRgba as u32;
        let at = if has_alpha { 4 * index } else { 3 * index } as usize;
        store(output, at, rgb.x.to_bits());
        store(output, at + 1, rgb.y.to_bits());
        store(output, at + 2, rgb.z.to_bits());
        if has_alpha {
            store(output, at + 3, 1.0f32.to_bits());
        }
    }
}

/// A picture's word of a pixel's linear RGB; `row` counts from the image's top.
#[inline(always)]
pub fn picture_word(uniform: &Uniform, column: u32, row: u32, rgb: Vec3, variant: u32) -> u32 {
    let is_dithered = variant & variant::DITHER != 0;
    srgb8(rgb, uniform.exposure, if is_dithered { dither(column, row) } else { NEAREST })
}

/// Stores a pixel's radiance at a group of four bands (W·m⁻²·sr⁻¹·nm⁻¹); the groups of a pixel follow each other.
#[inline(always)]
pub fn store_radiance(output: &mut [u32], index: u32, groups: u32, group: u32, radiance: Vec4) {
    let at = 4 * (index * groups + group) as usize;
    store(output, at, radiance.x.to_bits());
    store(output, at + 1, radiance.y.to_bits());
    store(output, at + 2, radiance.z.to_bits());
    store(output, at + 3, radiance.w.to_bits());
}

/// The view through a pixel; `row` counts from the dispatch's first row.
#[inline(always)]
pub fn view(uniform: &Uniform, column: u32, row: u32, variant: u32) -> PixelView {
    pixel_view(&uniform.camera, variant::projection(variant), column, uniform.first_row + row)
}

/// Kernel `radiance`: a pixel's radiance at every band, nothing more. This is where the paper's own GPU part ends.
#[inline(always)]
pub fn radiance_pixel(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    output: &mut [u32],
    column: u32,
    row: u32,
    variant: u32,
) {
    let view = view(uniform, column, row, variant);
    let mut group = 0;
    while group < buffers.bands.len() {
        let mut radiance = Vec4::ZERO;
        if view.covered {
            let solar_irradiance = fetch(buffers.bands, group).solar_irradiance;
            radiance = transfer(uniform, buffers, group, view.direction, variant) * solar_irradiance;
        }
        store_radiance(output, index(uniform, column, row), buffers.bands.len() as u32, group as u32, radiance);
        group += 1;
    }
}

/// Kernels `sky_linear`, `sky_solve`, `sky_regression` and `sky_regression_solve`: the sky's colour at a pixel by a fit of the
/// kind [`crate::sky`] names, integrated at the pixel itself, and stored.
#[inline(always)]
pub fn sky_pixel(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    output: &mut [u32],
    column: u32,
    row: u32,
    fit: u32,
    variant: u32,
) {
    let view = view(uniform, column, row, variant);
    let mut rgb = Vec3::ZERO;
    if view.covered {
        rgb = sky(uniform, buffers, view.direction, fit, variant);
        if variant & variant::SUN_DISC != 0 {
            rgb += disc_in_pixel(uniform, buffers.colour, column, uniform.first_row + row, variant);
        }
    }
    store_rgb(uniform, output, column, row, rgb, variant);
}

/// Kernels `spectrum_linear` and `spectrum_regression`: linear RGB and the radiance at every wavelength of a spectral image, see
/// [`spectral`], integrated at the pixel itself, and stored.
#[inline(always)]
pub fn spectrum_pixel(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    output: &mut [u32],
    column: u32,
    row: u32,
    fit: u32,
    variant: u32,
) {
    let view = view(uniform, column, row, variant);
    let at = (index(uniform, column, row) * spectral::words(uniform)) as usize;
    if view.covered {
        spectral::store_spectrum(uniform, buffers, output, at, view.direction, fit, variant);
    } else {
        spectral::store_black(uniform, output, at);
    }
}

/// Kernels `lookup_linear` and `lookup_regression`: the colours of an entry of the sky lookup.
#[inline(always)]
pub fn lookup_colours(uniform: &Uniform, buffers: Buffers<'_>, entry: u32, fit: u32, variant: u32) -> Constituents {
    constituents(uniform, buffers, lookup::entry_view(uniform, entry, variant), fit, variant)
}

/// Invocations of the kernel `sky_lookup` for a row: one for a pixel, or for a run of them.
#[inline(always)]
pub fn lookup_invocations(uniform: &Uniform, variant: u32) -> u32 {
    if variant & variant::RUNS != 0 { uniform.camera.width / RUN } else { uniform.camera.width }
}

/// Kernel `sky_lookup`: the sky's colour from the sky lookup at a pixel, or at a run of pixels in a row, stored. `column` counts what an
/// invocation does.
#[inline(always)]
pub fn lookup_pixel(
    uniform: &Uniform,
    colour: &[Vec4],
    entries: &[Vec4],
    output: &mut [u32],
    column: u32,
    row: u32,
    variant: u32,
) {
    if variant & variant::RUNS != 0 {
        let first = RUN * column;
        let whole_row = uniform.first_row + row;
        let middle = Vec2::new((first + RUN / 2) as f32, whole_row as f32 + 0.5);
        let direction = position_view(&uniform.camera, EQUIRECTANGULAR, middle).direction;
        if lookup::is_on_ground(direction, variant) {
            let mut pixel = first;
            while pixel < first + RUN {
                store_rgb(uniform, output, pixel, row, lookup::ground_beneath(uniform, variant), variant);
                pixel += 1;
            }
            return;
        }
        let place = lookup::row_place(uniform, direction);
        let place = lookup::along_row(uniform, entries, place, whole_row, variant);
        let mut pixel = first;
        while pixel < first + RUN {
            let direction = view(uniform, pixel, row, variant).direction;
            let rgb = lookup::sky_along_row(uniform, place, direction, variant);
            store_looked_up(uniform, colour, output, pixel, row, rgb, variant);
            pixel += 1;
        }
    } else {
        let view = view(uniform, column, row, variant);
        if view.covered {
            let rgb = lookup::sky_from_lookup(uniform, entries, view.direction, uniform.first_row + row, variant);
            store_looked_up(uniform, colour, output, column, row, rgb, variant);
        } else {
            store_rgb(uniform, output, column, row, Vec3::ZERO, variant);
        }
    }
}

/// Stores a colour of the sky, with the sun's disc before it.
#[inline(always)]
fn store_looked_up(
    uniform: &Uniform,
    colour: &[Vec4],
    output: &mut [u32],
    column: u32,
    row: u32,
    sky: Vec3,
    variant: u32,
) {
    let mut rgb = sky;
    if variant & variant::SUN_DISC != 0 {
        rgb += disc_in_pixel(uniform, colour, column, uniform.first_row + row, variant);
    }
    store_rgb(uniform, output, column, row, rgb, variant);
}

/// Where a pixel stands in the output of its dispatch, in pixels.
#[inline(always)]
fn index(uniform: &Uniform, column: u32, row: u32) -> u32 {
    row * uniform.row_pixels + column
}
