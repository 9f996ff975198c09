//! The sky's colour and spectrum in a direction: what a pixel of a spectral image holds.
//!
//! A pixel takes three words of linear RGB, then one for the radiance at each wavelength (W·m⁻²·sr⁻¹·nm⁻¹). A fit that
//! is linear in the transfer has one colour row of each wavelength for each group of four bands, which follow those of
//! the colour; the regression fit has [`rows_per_node`] of each constituent that there is ([`regression_value`]), and
//! behind all of them the abscissa of each wavelength where the aerosol's phase function is a table.

use crate::fit::spectrum::{Dozen, Logarithms, regression_value, rows_per_node};
use crate::glam::{Vec3, Vec4};
use crate::math::{fetch, max, store};
use crate::medium::phase::{ScatteringAngle, air_phase};
use crate::sky::{ByConstituent, aerosol_phase, constituent_count, linear_rgb, regression_constituents, with_phases};
use crate::uniform::{Buffers, Uniform};
use crate::variant;

/// Words of a pixel before its spectrum.
pub const RGB_WORDS: u32 = 3;

/// Words that a pixel takes.
#[inline]
pub fn words(uniform: &Uniform) -> u32 {
    RGB_WORDS + uniform.spectral_wavelengths
}

/// Stores what a group of four bands adds to a spectrum by a linear fit, whose pixel's words begin at `at`; gives what
/// it adds to linear RGB.
#[inline]
pub fn store_linear(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    output: &mut [u32],
    at: usize,
    group: usize,
    transfer: Vec4,
) -> Vec3 {
    let Buffers { bands, colour, .. } = buffers;
    let groups = bands.len();
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
    linear_rgb([fetch(colour, 3 * group), fetch(colour, 3 * group + 1), fetch(colour, 3 * group + 2)], transfer)
}

/// Stores the spectrum of light by the regression fit, likewise; gives linear RGB.
#[inline]
pub fn store_regression(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    output: &mut [u32],
    at: usize,
    lights: ByConstituent<Dozen>,
    angle: ScatteringAngle,
    variant: u32,
) -> Vec3 {
    let colour = buffers.colour;
    let logarithms = |light| Logarithms::new(light, uniform.band_wavelengths, variant);
    let air = logarithms(lights.air);
    let aerosol = logarithms(lights.aerosol);
    let multiple = logarithms(lights.multiple);
    let ground = logarithms(lights.ground);
    let air_phase = air_phase(uniform.atmosphere.air_anisotropy, angle.cosine);
    let rows = rows_per_node(variant) as usize;
    let abscissae = (uniform.spectral_wavelengths * constituent_count(variant)) as usize * rows;
    let mut row = 0;
    let mut i = 0;
    while i < uniform.spectral_wavelengths as usize {
        let mut radiance = air_phase * regression_value(colour, row, &air, variant);
        row += rows;
        if variant & variant::AEROSOL != 0 {
            let mut abscissa = 0.0;
            if variant & variant::PHASE_TABLE != 0 {
                abscissa = fetch(colour, abscissae + i).x;
            }
            let phase = aerosol_phase(uniform, angle, Vec4::splat(abscissa), variant).x;
            radiance += phase * regression_value(colour, row, &aerosol, variant);
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
    with_phases(uniform, regression_constituents(uniform, lights, variant), angle, variant)
}

/// Stores the colour of a pixel whose words begin at `at`.
#[inline]
pub fn store_colour(output: &mut [u32], at: usize, rgb: Vec3) {
    store(output, at, rgb.x.to_bits());
    store(output, at + 1, rgb.y.to_bits());
    store(output, at + 2, rgb.z.to_bits());
}
