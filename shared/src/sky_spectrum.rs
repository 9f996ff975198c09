//! The sky's colour and spectrum in a direction: what a pixel of a spectral image holds.
//!
//! A pixel takes three words of linear RGB, then one for the radiance at each wavelength (W·m⁻²·sr⁻¹·nm⁻¹). The wavelengths' rows
//! follow those of the colour in the colour table: for a fit that is linear in the transfer, one for each group of four bands; for
//! the learnt fit, three of air, and three of aerosol if there is some ([`crate::spectrum::learnt_value`]).

use crate::atmosphere::{cornette_shanks_phase, rayleigh_phase};
use crate::color::into_gamut;
use crate::frame::Frame;
use crate::glam::{Vec2, Vec3, Vec4};
use crate::math::{fetch, max, store};
use crate::scattering::Bands;
use crate::sky::{Constituents, LINEAR, scattered, transfer, view_ray, with_phases};
use crate::spectrum::{Logarithms, ROWS_PER_NODE, learnt_rgb, learnt_value};
use crate::variant;

/// Words of a pixel before its spectrum.
pub const RGB_WORDS: u32 = 3;

/// Words that a pixel takes.
#[inline]
pub fn words(frame: &Frame) -> u32 {
    RGB_WORDS + frame.wavelengths
}

/// Stores a pixel without light, whose words begin at `at`.
#[inline]
pub fn store_black(frame: &Frame, output: &mut [u32], at: usize) {
    let mut i = 0;
    while i < words(frame) {
        store(output, at + i as usize, 0);
        i += 1;
    }
}

/// Stores the colour and the spectrum in a direction, by a [`LINEAR`] or a learnt fit; the pixel's words begin at `at`.
#[inline]
pub fn store_spectrum(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    output: &mut [u32],
    at: usize,
    direction: Vec3,
    fit: u32,
    variant: u32,
) {
    if fit == LINEAR {
        store_linear(frame, bands, quadrature, colour, output, at, direction, variant);
    } else {
        store_learnt(frame, bands, quadrature, colour, output, at, direction, variant);
    }
}

#[inline]
fn store_linear(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    output: &mut [u32],
    at: usize,
    direction: Vec3,
    variant: u32,
) {
    let groups = bands.len();
    let mut rgb = Vec3::ZERO;
    let mut group = 0;
    while group < groups {
        let transfer = transfer(frame, &fetch(bands, group), quadrature, direction, variant);
        let channel = |i: usize| fetch(colour, 3 * group + i).dot(transfer);
        rgb += Vec3::new(channel(0), channel(1), channel(2));
        let mut i = 0;
        while i < frame.wavelengths as usize {
            let word = at + RGB_WORDS as usize + i;
            let row = fetch(colour, (3 + i) * groups + group);
            let mut radiance = row.dot(transfer);
            if group > 0 {
                radiance += f32::from_bits(fetch(output, word));
            }
            // A polynomial can pass below zero between its bands; light cannot.
            if group + 1 == groups {
                radiance = max(radiance, 0.0);
            }
            store(output, word, radiance.to_bits());
            i += 1;
        }
        group += 1;
    }
    store_colour(output, at, into_gamut(rgb, &frame.rgb));
}

#[inline]
fn store_learnt(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    output: &mut [u32],
    at: usize,
    direction: Vec3,
    variant: u32,
) {
    let ray = view_ray(frame, direction);
    let scattered = scattered(frame, bands, quadrature, ray, variant);
    let air = Logarithms::new(scattered.air, bands.len() > 1, Vec4::ZERO, false);
    let aerosol = Logarithms::new(scattered.aerosol, bands.len() > 1, Vec4::ZERO, false);
    let air_phase = rayleigh_phase(ray.nu);
    let aerosol_phase = cornette_shanks_phase(ray.scattering_angle(), frame.atmosphere.aerosol_asymmetry);
    let nodes = frame.air_nodes + frame.aerosol_nodes;
    let has_aerosol = variant & variant::AEROSOL != 0;
    let mut row = (nodes * ROWS_PER_NODE) as usize;
    let mut i = 0;
    while i < frame.wavelengths as usize {
        let mut radiance = air_phase * learnt_value(colour, row, &air);
        row += ROWS_PER_NODE as usize;
        if has_aerosol {
            radiance += aerosol_phase * learnt_value(colour, row, &aerosol);
            row += ROWS_PER_NODE as usize;
        }
        store(output, at + RGB_WORDS as usize + i, radiance.to_bits());
        i += 1;
    }
    let constituents = Constituents {
        air: learnt_rgb(colour, 0, frame.air_nodes, &air),
        aerosol: learnt_rgb(colour, frame.air_nodes, frame.aerosol_nodes, &aerosol),
    };
    store_colour(output, at, with_phases(frame, constituents, ray.scattering_angle(), variant));
}

#[inline]
fn store_colour(output: &mut [u32], at: usize, rgb: Vec3) {
    store(output, at, rgb.x.to_bits());
    store(output, at + 1, rgb.y.to_bits());
    store(output, at + 2, rgb.z.to_bits());
}
