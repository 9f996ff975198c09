//! The door to this crate: what a frame needs to know, and one function per kernel.
//!
//! A kernel is a pure function of the frame's parameters, its tables and an index. A GPU entry point fetches its index, calls
//! the function and stores the result; the CPU calls the same function in a loop.

use bytemuck::{Pod, Zeroable};

use crate::atmosphere::{Atmosphere, cornette_shanks_phase, rayleigh_phase};
use crate::camera::{Camera, pixel_view};
use crate::color::{into_gamut, observe_cubic, srgb8, xyz_to_rec709};
use crate::geometry::Ray;
use crate::glam::{Vec2, Vec3, Vec4};
use crate::scattering::{Bands, single_scattering};

/// Pixels along each side of a GPU workgroup. The entry points repeat it as a literal, which a test compares.
pub const WORKGROUP_SIDE: u32 = 8;

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
    /// Wavelengths of the four bands, mapped to [-1, 1] over the observer's range.
    pub nodes: Vec4,
    /// Solar irradiance at the bands (W·m⁻²·nm⁻¹).
    pub solar_irradiance: Vec4,
    /// Row of the folded colour matrix that gives red from the transfer at the bands; likewise green and blue.
    pub red: Vec4,
    /// See [`Frame::red`].
    pub green: Vec4,
    /// See [`Frame::red`].
    pub blue: Vec4,
    /// Altitude of the observer (km).
    pub altitude: f32,
    /// First row of the image that this dispatch computes.
    pub first_row: u32,
    /// Rows that this dispatch computes.
    pub rows: u32,
    /// Factor from linear RGB to the picture's linear value.
    pub exposure: f32,
    /// How a pixel is stored: a [`Pixel`].
    pub pixel: u32,
    /// Unused; fills the last 16 bytes.
    pub padding0: u32,
    /// Unused.
    pub padding1: u32,
    /// Unused.
    pub padding2: u32,
}

/// How a pixel of the sky is stored.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pixel {
    /// Three `f32` words: linear RGB.
    LinearRgb = 0,
    /// One word: 8 bit sRGB, exposed, red in the lowest byte.
    Picture = 1,
}

impl Pixel {
    /// The kind with this number, as [`Frame::pixel`] holds it.
    pub const fn from_u32(number: u32) -> Self {
        if number == Self::Picture as u32 { Self::Picture } else { Self::LinearRgb }
    }

    /// Words that a pixel takes.
    pub const fn words(self) -> u32 {
        match self {
            Self::LinearRgb => 3,
            Self::Picture => 1,
        }
    }
}

/// A bit pattern that no kernel stores, a NaN and a picture of alpha 0: what the output holds before a kernel runs.
pub const SENTINEL: u32 = 0x7fff_ffff;

/// Transfer (sr⁻¹) at the four bands in a direction: single scattering with its phase functions (Eq. 1).
#[inline]
pub fn transfer(frame: &Frame, bands: &Bands, quadrature: &[Vec2], direction: Vec3) -> Vec4 {
    let sun = Vec3::new(frame.sun.x, frame.sun.y, frame.sun.z);
    let ray = Ray::new(frame.altitude, direction, sun);
    let scattered = single_scattering(&frame.atmosphere, bands, quadrature, ray);
    scattered.air * rayleigh_phase(ray.nu)
        + scattered.aerosol * cornette_shanks_phase(ray.nu, frame.atmosphere.aerosol_asymmetry)
}

#[inline]
fn pixel_transfer(frame: &Frame, bands: &Bands, quadrature: &[Vec2], column: u32, row: u32) -> Vec4 {
    let view = pixel_view(&frame.camera, column, frame.first_row + row);
    if view.covered { transfer(frame, bands, quadrature, view.direction) } else { Vec4::ZERO }
}

/// Kernel `radiance`: the radiance at the four bands of a pixel (W·m⁻²·sr⁻¹·nm⁻¹), nothing more.
///
/// This is where the paper's own GPU part ends. `row` counts from the dispatch's first row, here and below.
#[inline]
pub fn radiance_pixel(frame: &Frame, bands: &Bands, quadrature: &[Vec2], column: u32, row: u32) -> Vec4 {
    pixel_transfer(frame, bands, quadrature, column, row) * frame.solar_irradiance
}

/// Kernel `sky_solve`: linear RGB of a pixel by the paper's mathematics, step by step (Eqs. 1-8): the cubic through the four
/// bands, its sum over the observer's samples, RGB.
#[inline]
pub fn sky_solve_pixel(
    frame: &Frame,
    bands: &Bands,
    quadrature: &[Vec2],
    observer: &[Vec4],
    column: u32,
    row: u32,
) -> Vec3 {
    let radiance = radiance_pixel(frame, bands, quadrature, column, row);
    into_gamut(xyz_to_rec709(observe_cubic(frame.nodes, radiance, observer)))
}

/// Linear RGB of the transfer at the bands, by the one 3×4 matrix that the steps of [`sky_solve_pixel`] amount to.
#[inline]
pub fn folded_rgb(frame: &Frame, transfer: Vec4) -> Vec3 {
    Vec3::new(frame.red.dot(transfer), frame.green.dot(transfer), frame.blue.dot(transfer))
}

/// Kernel `sky_folded`: the same RGB as [`sky_solve_pixel`], by [`folded_rgb`].
#[inline]
pub fn sky_folded_pixel(frame: &Frame, bands: &Bands, quadrature: &[Vec2], column: u32, row: u32) -> Vec3 {
    into_gamut(folded_rgb(frame, pixel_transfer(frame, bands, quadrature, column, row)))
}

/// Stores a pixel's linear RGB as the frame's [`Pixel`] says; `index` counts pixels from the output's start.
#[inline]
pub fn store_rgb(frame: &Frame, output: &mut [u32], index: u32, rgb: Vec3) {
    if frame.pixel == Pixel::Picture as u32 {
        output[index as usize] = srgb8(rgb, frame.exposure);
    } else {
        let at = 3 * index as usize;
        output[at] = rgb.x.to_bits();
        output[at + 1] = rgb.y.to_bits();
        output[at + 2] = rgb.z.to_bits();
    }
}

/// Stores a pixel's radiance at the four bands.
#[inline]
pub fn store_radiance(output: &mut [u32], index: u32, radiance: Vec4) {
    let at = 4 * index as usize;
    output[at] = radiance.x.to_bits();
    output[at + 1] = radiance.y.to_bits();
    output[at + 2] = radiance.z.to_bits();
    output[at + 3] = radiance.w.to_bits();
}
