//! The sun's disc: what it adds to the pixels that it reaches.
//!
//! A pixel gets the disc's radiance averaged over its solid angle, so that image and disc hold the same energy at any
//! resolution:
//!
//! ```text
//! L = 1/Ω ∫ L_disc dω over the part of the disc inside the pixel, Ω the pixel's solid angle
//! ```
//!
//! The integral is a sum over a grid of samples in the part of the pixel that lies in the disc's bounding box. The
//! disc's radiance stands in a grid over the elevation, along which the air in front of it changes, and over the cosine
//! of the angle to the normal of the sun's surface, on which limb darkening depends.

use crate::camera::{EQUIRECTANGULAR, position_view, solid_angle_density};
use crate::glam::{Vec2, Vec3, Vec4};
use crate::math::{PI, clamp, fetch, floor, max, min, mix, safe_sqrt, sin_cos, sqrt};
use crate::uniform::Uniform;
use crate::variant;

/// Rows of the grid, from the lowest elevation to the highest.
pub const ELEVATIONS: u32 = 16;

/// Columns of the grid, from the limb to the disc's centre.
pub const LIMB_COSINES: u32 = 16;

/// Whether a row of the whole image has no pixel of the sun's disc.
#[inline(always)]
pub fn is_beside_disc(uniform: &Uniform, row: u32, variant: u32) -> bool {
    let (disc, row) = (uniform.disc, row as f32);
    (variant & variant::SUN_DISC == 0) | (row + 1.0 <= disc.top) | (row >= disc.bottom)
}

/// What the disc adds to the linear RGB of a pixel, and the part of the pixel that it covers; `row` counts from the
/// image's top.
#[inline]
pub fn disc_in_pixel(uniform: &Uniform, colour: &[Vec4], column: u32, row: u32, variant: u32) -> (Vec3, f32) {
    let disc = uniform.disc;
    let projection = variant::projection(variant);
    let width = uniform.camera.width as f32;
    let corner = Vec2::new(column as f32, row as f32);
    let beside = if corner.x + 1.0 <= disc.left {
        width
    } else if corner.x >= disc.right {
        -width
    } else {
        0.0
    };
    let x = corner.x + beside;
    let from = Vec2::new(max(x, disc.left), max(corner.y, disc.top));
    let part = Vec2::new(min(x + 1.0, disc.right), min(corner.y + 1.0, disc.bottom)) - from;
    let mut sum = Vec3::ZERO;
    let mut covered = 0.0;
    if (part.x > 0.0) & (part.y > 0.0) {
        let n = disc.samples;
        let step = part / n as f32;
        let mut i = 0;
        while i < n * n {
            let (down, across) = (i / n, i % n);
            let position = from + step * Vec2::new(across as f32 + 0.5, down as f32 + 0.5);
            let view = position_view(&uniform.camera, projection, position);
            let radiance = disc_radiance(uniform, colour, view.direction);
            sum += radiance * solid_angle_density(&uniform.camera, projection, position);
            covered += if radiance.x + radiance.y + radiance.z > 0.0 { 1.0 } else { 0.0 };
            i += 1;
        }
        sum *= step.x * step.y / mean_density(uniform, projection, corner + Vec2::splat(0.5));
        covered *= step.x * step.y;
    }
    (sum, covered)
}

/// The mean of [`solid_angle_density`] over a pixel: of an equirectangular image, whose rows near the zenith are narrow
/// rings, exactly; else that at its centre.
#[inline]
fn mean_density(uniform: &Uniform, projection: u32, centre: Vec2) -> f32 {
    let density = solid_angle_density(&uniform.camera, projection, centre);
    let half_row = 0.5 * PI / uniform.camera.height as f32;
    let (sine, _) = sin_cos(half_row);
    max(if projection == EQUIRECTANGULAR { density * sine / half_row } else { density }, 1e-6)
}

/// Linear RGB of the disc in a direction; zero beside it.
#[inline]
fn disc_radiance(uniform: &Uniform, colour: &[Vec4], view: Vec3) -> Vec3 {
    let disc = uniform.disc;
    let sun = disc.centre.truncate();
    let across = view.cross(sun);
    // How far above the centre, along the vertical circle through it.
    let over = (view.z - sun.z * view.dot(sun)) / sqrt(max(1.0 - sun.z * sun.z, 1e-12));
    let flattened = over * over * (1.0 / (disc.centre.w * disc.centre.w) - 1.0);
    let off = sqrt(across.dot(across) + flattened) / disc.sine_radius;
    let mut radiance = Vec3::ZERO;
    if (off < 1.0) & (view.dot(sun) > 0.0) & (view.z >= disc.horizon) {
        let limb = safe_sqrt(1.0 - off * off) * (LIMB_COSINES - 1) as f32;
        let height = clamp((view.z - disc.lowest) / (disc.highest - disc.lowest), 0.0, 1.0) * (ELEVATIONS - 1) as f32;
        let column = min(floor(limb), (LIMB_COSINES - 2) as f32);
        let row = min(floor(height), (ELEVATIONS - 2) as f32);
        let low = (disc.first_entry + row as u32 * LIMB_COSINES + column as u32) as usize;
        let high = low + LIMB_COSINES as usize;
        let below = mix(fetch(colour, low), fetch(colour, low + 1), limb - column);
        let above = mix(fetch(colour, high), fetch(colour, high + 1), limb - column);
        let rgb = mix(below, above, height - row);
        radiance = Vec3::new(rgb.x, rgb.y, rgb.z);
    }
    radiance
}
