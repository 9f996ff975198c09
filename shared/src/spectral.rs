//! The sky's colour and spectrum in a direction: what a pixel of a spectral image holds.
//!
//! A pixel takes three words of linear RGB, then one for the radiance at each wavelength (W·m⁻²·sr⁻¹·nm⁻¹). The colour rows
//! of the wavelengths follow those of the colour: for a fit that is linear in the transfer, one for each group of four bands; for
//! the regression fit, [`rows_per_node`] of each constituent that there is ([`regression_value`]).

use crate::fit::{Logarithms, regression_value, rows_per_node};
use crate::glam::{Vec3, Vec4};
use crate::math::{fetch, max, store};
use crate::phase::ScatteringAngle;
use crate::rgb::into_gamut;
use crate::sky::{
    LINEAR, at_all_bands, constituent_count, phases, regression_constituents, transfer, view_ray, with_phases,
};
use crate::uniform::{Buffers, Uniform};
use crate::variant;

/// Words of a pixel before its spectrum.
pub const RGB_WORDS: u32 = 3;

/// Words that a pixel takes.
#[inline]
pub fn words(uniform: &Uniform) -> u32 {
    RGB_WORDS + uniform.spectral_wavelengths
}

/// Stores a pixel without light, whose words begin at `at`.
#[inline]
pub fn store_black(uniform: &Uniform, output: &mut [u32], at: usize) {
    let mut i = 0;
    while i < words(uniform) {
        store(output, at + i as usize, 0);
        i += 1;
    }
}

/// Stores the colour and the spectrum in a direction, by a [`LINEAR`] or a regression fit; the pixel's words begin at `at`.
#[inline]
pub fn store_spectrum(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    output: &mut [u32],
    at: usize,
    direction: Vec3,
    fit: u32,
    variant: u32,
) {
    if fit == LINEAR {
        store_linear(uniform, buffers, output, at, direction, variant);
    } else {
        store_regression(uniform, buffers, output, at, direction, variant);
    }
}

#[inline]
fn store_linear(uniform: &Uniform, buffers: Buffers<'_>, output: &mut [u32], at: usize, direction: Vec3, variant: u32) {
    let Buffers { bands, colour, .. } = buffers;
    let groups = bands.len();
    let mut rgb = Vec3::ZERO;
    let mut group = 0;
    while group < groups {
        let transfer = transfer(uniform, buffers, group, direction, variant);
        let channel = |i: usize| fetch(colour, 3 * group + i).dot(transfer);
        rgb += Vec3::new(channel(0), channel(1), channel(2));
        let mut i = 0;
        while i < uniform.spectral_wavelengths as usize {
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
    store_colour(output, at, into_gamut(rgb, &uniform.rgb));
}

#[inline]
fn store_regression(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    output: &mut [u32],
    at: usize,
    direction: Vec3,
    variant: u32,
) {
    let colour = buffers.colour;
    let angle = ScatteringAngle::of_ray(view_ray(uniform, direction));
    let lights = at_all_bands(uniform, buffers, direction, variant);
    let air = Logarithms::new(lights.air, Vec4::ZERO, false, variant);
    let aerosol = Logarithms::new(lights.aerosol, Vec4::ZERO, false, variant);
    let multiple = Logarithms::new(lights.multiple, Vec4::ZERO, false, variant);
    let ground = Logarithms::new(lights.ground, Vec4::ZERO, false, variant);
    let phases = phases(uniform, angle);
    let rows = rows_per_node(variant) as usize;
    let mut row = (constituent_count(variant) * uniform.nodes) as usize * rows;
    let mut i = 0;
    while i < uniform.spectral_wavelengths as usize {
        let mut radiance = phases.air * regression_value(colour, row, &air, variant);
        row += rows;
        if variant & variant::AEROSOL != 0 {
            radiance += phases.aerosol * regression_value(colour, row, &aerosol, variant);
            row += rows;
        }
        if variant & variant::MULTIPLE != 0 {
            radiance += regression_value(colour, row, &multiple, variant);
            row += rows;
        }
        if variant & variant::GROUND != 0 {
            radiance += regression_value(colour, row, &ground, variant);
            row += rows;
        }
        store(output, at + RGB_WORDS as usize + i, radiance.to_bits());
        i += 1;
    }
    let constituents = regression_constituents(uniform, buffers, lights, false, variant);
    store_colour(output, at, with_phases(uniform, constituents, angle, variant));
}

#[inline]
fn store_colour(output: &mut [u32], at: usize, rgb: Vec3) {
    store(output, at, rgb.x.to_bits());
    store(output, at + 1, rgb.y.to_bits());
    store(output, at + 2, rgb.z.to_bits());
}
