//! A polariser before the lens.
//!
//! Light with the Stokes vector `(I, Q, U)` relative to the top of the image leaves it, turned by `φ` counterclockwise
//! as the photographer sees it, with the radiance (Malus' law; Collett 2005, *Field Guide to Polarization*, DOI
//! 10.1117/3.626141)
//!
//! ```text
//! ((1 + 1/E) I + (1 - 1/E) (Q cos 2φ + U sin 2φ)) / 2
//! ```
//!
//! with the extinction ratio `E`, how many times more passes of light along its axis than of that across it. The
//! lookups keep radiance; what they lack for `Q` and `U` stands in the colour rows: the aerosol's degree of
//! polarisation over the scattering angle, and `Q` and `U` of light of higher orders.

use crate::camera::top_of_image;
use crate::display::rgb::into_gamut;
use crate::glam::{Vec2, Vec3, Vec4};
use crate::light_field::multiple_lookup::{place, value};
use crate::math::{PI, acos, clamp, fetch, floor, max, min, mix, sqrt};
use crate::medium::phase::{AirPhase, ScatteringAngle, cornette_shanks_phase};
use crate::sky::{Constituents, cosine_from_sun, scattered_by_aerosol, view_ray};
use crate::uniform::{Polariser, Uniform};
use crate::variant;

/// Scattering angles at which the aerosol's degree of polarisation stands: every degree.
pub const DEGREES: u32 = 181;

/// Linear RGB of the sky (W·m⁻²·sr⁻¹) in a direction that passes the polariser, from the colours of its constituents.
/// The air's light comes from the direction `source`.
#[inline(always)]
pub fn passed(
    uniform: &Uniform,
    colour: &[Vec4],
    constituents: Constituents,
    source: Vec3,
    direction: Vec3,
    variant: u32,
) -> Vec3 {
    let passes = uniform.polariser.passes;
    let sun = uniform.sun.truncate();
    let angle = ScatteringAngle::between(direction, sun);
    let air_phase = AirPhase::new(uniform.atmosphere.air_anisotropy);
    // Of light whose electric vector lies across the scattering plane, where dipoles have it.
    let top = top_of_image(&uniform.camera, variant::projection(variant), direction);
    let of_sun = -along(top, direction, sun);
    let of_air = air_phase.degree_of_polarisation(angle.cosine) * passes_along(passes, of_sun);
    let mut rgb = constituents.air * (air_phase.at(angle.cosine) * (passes.x + of_air));
    if variant & variant::AEROSOL != 0 {
        let degree = degree_of_aerosol(uniform, colour, angle) * passes_along(passes, of_sun);
        let passes = degree + Vec3::splat(passes.x);
        rgb += if variant & variant::PHASE_TABLE != 0 {
            scattered_by_aerosol(uniform, constituents.aerosol, angle, passes)
        } else {
            let phase = cornette_shanks_phase(angle, uniform.atmosphere.aerosol_asymmetry);
            constituents.aerosol * phase * passes
        };
    }
    if variant & variant::REST != 0 {
        rgb += constituents.rest * passes.x;
    }
    if variant & variant::MULTIPLE != 0 {
        rgb += of_higher_orders(uniform, colour, source, along(top, direction, Vec3::Z));
    }
    into_gamut(rgb, &uniform.rgb)
}

/// What passes of light that is wholly polarised, with the cosine and sine of twice the angle of its electric vector
/// from the top of the image, beside half of it.
#[inline(always)]
fn passes_along(passes: Vec4, doubled: Vec2) -> f32 {
    passes.y * doubled.x + passes.z * doubled.y
}

/// Cosine and sine of twice the angle, counterclockwise from the top of the image, of the plane through a direction and
/// another vector; nothing where they are parallel.
#[inline(always)]
fn along(top: Vec3, direction: Vec3, vector: Vec3) -> Vec2 {
    let (up, left) = (top.dot(vector), top.cross(direction).dot(vector));
    let square = up * up + left * left;
    Vec2::new(up * up - left * left, 2.0 * up * left) * (1.0 / max(square, 1e-12))
}

/// The degree of polarisation of light that aerosol scatters once; see [`Polariser::first`].
#[inline(always)]
fn degree_of_aerosol(uniform: &Uniform, colour: &[Vec4], angle: ScatteringAngle) -> Vec3 {
    let at = acos(clamp(angle.cosine, -1.0, 1.0)) * ((DEGREES - 1) as f32 / PI);
    let below = min(floor(at), (DEGREES - 2) as f32);
    let first = uniform.polariser.first as usize + below as usize;
    let degree = mix(fetch(colour, first), fetch(colour, first + 1), at - below);
    Vec3::new(degree.x, degree.y, degree.z)
}

/// What passes of `Q` and `U` of light of higher orders; `vertical` is the vertical plane about the top of the image.
#[inline(always)]
fn of_higher_orders(uniform: &Uniform, colour: &[Vec4], source: Vec3, vertical: Vec2) -> Vec3 {
    let Polariser { passes, lookup, first, .. } = uniform.polariser;
    let place = place(lookup, &uniform.atmosphere, view_ray(uniform, source), cosine_from_sun(uniform, source));
    let entries = first + DEGREES;
    let (q, u) = (value(lookup, colour, (entries, 0), place, 0), value(lookup, colour, (entries, 1), place, 0));
    let level = max(sqrt(source.x * source.x + source.y * source.y), 1e-10);
    let sine = (uniform.bearing.x * source.y - uniform.bearing.y * source.x) / level;
    let of_q = passes.y * vertical.x + passes.z * vertical.y;
    let of_u = passes.z * vertical.x - passes.y * vertical.y;
    let rgb = q * of_q + u * (of_u * sine);
    Vec3::new(rgb.x, rgb.y, rgb.z)
}
