//! The door to this crate: what a frame needs to know, and one function per kernel.
//!
//! A kernel is a pure function of the frame's parameters, its tables and an index. A GPU entry point fetches its index, calls
//! the function and stores the result; the CPU calls the same function in a loop.

use bytemuck::{Pod, Zeroable};

use crate::atmosphere::{Atmosphere, cornette_shanks_phase, rayleigh_phase};
use crate::camera::{Camera, PixelView, pixel_view};
use crate::color::{into_gamut, observe_cubic, srgb8, xyz_to_rec709};
use crate::geometry::Ray;
use crate::glam::{Vec2, Vec3, Vec4};
use crate::scattering::{Bands, SingleScattering, single_scattering};
use crate::spectrum::{Octet, learnt_rgb};

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
    /// Wavelengths of the first four bands, mapped to [-1, 1] over the observer's range.
    pub nodes: Vec4,
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
    /// Nodes of the learnt fit of air.
    pub air_nodes: u32,
    /// Nodes of the learnt fit of aerosol, which follow those of air in the table; 0 without aerosol.
    pub aerosol_nodes: u32,
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

/// The view ray of a frame in a direction.
#[inline]
pub fn view_ray(frame: &Frame, direction: Vec3) -> Ray {
    Ray::new(frame.altitude, direction, Vec3::new(frame.sun.x, frame.sun.y, frame.sun.z))
}

/// Transfer (sr⁻¹) at four bands in a direction: single scattering with its phase functions (Eq. 1).
#[inline]
pub fn transfer(frame: &Frame, bands: &Bands, quadrature: &[Vec2], direction: Vec3) -> Vec4 {
    let ray = view_ray(frame, direction);
    let scattered = single_scattering(&frame.atmosphere, bands, quadrature, ray);
    scattered.air * rayleigh_phase(ray.nu)
        + scattered.aerosol * cornette_shanks_phase(ray.nu, frame.atmosphere.aerosol_asymmetry)
}

/// Linear RGB in a direction by a fit that is linear in the transfer: solve, observer sum and XYZ→RGB (Eqs. 4-8) are one
/// matrix, whose rows for red, green and blue stand in `colour` for each group of four bands.
#[inline]
pub fn linear_sky(frame: &Frame, bands: &[Bands], quadrature: &[Vec2], colour: &[Vec4], direction: Vec3) -> Vec3 {
    let mut rgb = Vec3::ZERO;
    let mut group = 0;
    while group < bands.len() {
        let transfer = transfer(frame, &bands[group], quadrature, direction);
        let row = 3 * group;
        rgb += Vec3::new(colour[row].dot(transfer), colour[row + 1].dot(transfer), colour[row + 2].dot(transfer));
        group += 1;
    }
    into_gamut(rgb)
}

/// Linear RGB in a direction by the paper's mathematics, step by step (Eqs. 1-8): the cubic through four bands, its sum over
/// the observer's samples in `colour`, XYZ→RGB.
#[inline]
pub fn solved_sky(frame: &Frame, bands: &[Bands], quadrature: &[Vec2], colour: &[Vec4], direction: Vec3) -> Vec3 {
    let radiance = transfer(frame, &bands[0], quadrature, direction) * bands[0].fit_irradiance;
    into_gamut(xyz_to_rec709(observe_cubic(frame.nodes, radiance, colour)))
}

/// Linear RGB in a direction by the learnt fit, separately for air and aerosol; see [`learnt_rgb`].
#[inline]
pub fn learnt_sky(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    direction: Vec3,
    solve: bool,
) -> Vec3 {
    let ray = view_ray(frame, direction);
    let mut second = SingleScattering { air: Vec4::ZERO, aerosol: Vec4::ZERO };
    if bands.len() > 1 {
        second = single_scattering(&frame.atmosphere, &bands[1], quadrature, ray);
    }
    let first = single_scattering(&frame.atmosphere, &bands[0], quadrature, ray);
    let air = Octet { first: first.air, second: second.air };
    let mut rgb = learnt_rgb(colour, 0, frame.air_nodes, air, frame.nodes, solve) * rayleigh_phase(ray.nu);
    if frame.aerosol_nodes > 0 {
        let aerosol = Octet { first: first.aerosol, second: second.aerosol };
        rgb += learnt_rgb(colour, frame.air_nodes, frame.aerosol_nodes, aerosol, frame.nodes, solve)
            * cornette_shanks_phase(ray.nu, frame.atmosphere.aerosol_asymmetry);
    }
    into_gamut(rgb)
}

/// The view through a pixel; `row` counts from the dispatch's first row.
#[inline]
pub fn view(frame: &Frame, column: u32, row: u32) -> PixelView {
    pixel_view(&frame.camera, column, frame.first_row + row)
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

/// Stores a pixel's radiance at a group of four bands (W·m⁻²·sr⁻¹·nm⁻¹); the groups of a pixel follow each other.
#[inline]
pub fn store_radiance(output: &mut [u32], index: u32, groups: u32, group: u32, radiance: Vec4) {
    let at = 4 * (index * groups + group) as usize;
    output[at] = radiance.x.to_bits();
    output[at + 1] = radiance.y.to_bits();
    output[at + 2] = radiance.z.to_bits();
    output[at + 3] = radiance.w.to_bits();
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
    index: u32,
) {
    let view = view(frame, column, row);
    let mut group = 0;
    while group < bands.len() {
        let mut radiance = Vec4::ZERO;
        if view.covered {
            radiance = transfer(frame, &bands[group], quadrature, view.direction) * bands[group].solar_irradiance;
        }
        store_radiance(output, index, bands.len() as u32, group as u32, radiance);
        group += 1;
    }
}

/// Kernel `sky_linear`: a pixel of [`linear_sky`], stored.
#[inline]
pub fn sky_linear_pixel(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    output: &mut [u32],
    column: u32,
    row: u32,
    index: u32,
) {
    let view = view(frame, column, row);
    let mut rgb = Vec3::ZERO;
    if view.covered {
        rgb = linear_sky(frame, bands, quadrature, colour, view.direction);
    }
    store_rgb(frame, output, index, rgb);
}

/// Kernel `sky_solve`: a pixel of [`solved_sky`], stored.
#[inline]
pub fn sky_solve_pixel(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    output: &mut [u32],
    column: u32,
    row: u32,
    index: u32,
) {
    let view = view(frame, column, row);
    let mut rgb = Vec3::ZERO;
    if view.covered {
        rgb = solved_sky(frame, bands, quadrature, colour, view.direction);
    }
    store_rgb(frame, output, index, rgb);
}

/// Kernels `sky_learnt` and, with `solve`, `sky_learnt_solve`: a pixel of [`learnt_sky`], stored.
#[inline]
pub fn sky_learnt_pixel(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    output: &mut [u32],
    column: u32,
    row: u32,
    index: u32,
    solve: bool,
) {
    let view = view(frame, column, row);
    let mut rgb = Vec3::ZERO;
    if view.covered {
        rgb = learnt_sky(frame, bands, quadrature, colour, view.direction, solve);
    }
    store_rgb(frame, output, index, rgb);
}
