//! From a spectrum to a colour: the sum over a colour observer.

use crate::fit::spectrum::{newton_coefficients, newton_value};
use crate::glam::{Vec3, Vec4};
use crate::math::fetch;

/// Observer nodes of the sum over a cubic.
pub const OBSERVER_NODES: u32 = 81;

/// XYZ of the fitted spectrum: the cubic through four bands, summed over the observer nodes (Eqs. 4-7).
///
/// `radiance` at the bands; `wavelengths` the normalised ones of the bands; each of the first [`OBSERVER_NODES`] colour
/// rows holds (`x̄ Δλ`, `ȳ Δλ`, `z̄ Δλ`, normalised wavelength), times the solar irradiance if the fit is of the
/// transfer. Returns radiance weighted by the colour-matching functions (W·m⁻²·sr⁻¹).
#[inline]
pub fn observe_cubic(wavelengths: Vec4, radiance: Vec4, colour: &[Vec4]) -> Vec3 {
    let coefficients = newton_coefficients(wavelengths, radiance);
    let mut xyz = Vec3::ZERO;
    let mut i = 0;
    while i < OBSERVER_NODES {
        let row = fetch(colour, i as usize);
        xyz += Vec3::new(row.x, row.y, row.z) * newton_value(wavelengths, coefficients, row.w);
        i += 1;
    }
    xyz
}
