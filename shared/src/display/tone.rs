//! From linear RGB to a picture: the view transform, the curve of sRGB, which every display here has, and packing.

use crate::display::aces::aces2;
use crate::display::agx::agx;
use crate::display::grade::Grade;
use crate::glam::{Vec3, Vec4};
use crate::math::{clamp, min, sqrt};
use crate::variant::{ACES, AGX};

/// A linear value that every picture shows as white: an infinite one would have no hue to keep.
pub const BRIGHTEST: f32 = 1e30;

/// The sRGB transfer function of a linear value in [0, 1] (IEC 61966-2-1:1999), to 2e-5, a two-hundredth of an 8 bit
/// step.
///
/// The power 1/2.4 of `x` is the power 5/3 of `x^(1/4)`, close enough to a square for a short polynomial.
#[inline(always)]
pub fn srgb_encode(linear: f32) -> f32 {
    let x = clamp(linear, 0.0, 1.0);
    let q = sqrt(sqrt(x));
    let curve = SRGB_POLYNOMIAL;
    let power = ((((curve[5] * q + curve[4]) * q + curve[3]) * q + curve[2]) * q + curve[1]) * q + curve[0];
    if x <= 0.003_130_8 { 12.92 * x } else { power }
}

/// `1.055 q^(5/3) - 0.055` for `q` from 0.23 to 1, by Chebyshev interpolation, moved by 4e-6 so that white is 1.
const SRGB_POLYNOMIAL: [f32; 6] = [-0.06162549, 0.164974, 1.2442139, -0.55755568, 0.27275226, -0.06275899];

/// The threshold of [`srgb8`] that rounds to the nearest byte.
pub const NEAREST: f32 = 0.5;

/// A pixel's threshold of [`srgb8`] in an ordered dither: over any few pixels the thresholds lie evenly in [0, 1), so
/// that the mean of the bytes is the value, and steps between two bytes cannot be seen as rings around the sun.
///
/// They are the fractional parts of `column / g + row / g²` in 32 bits, with `g` the root of g³ = g + 1 (1.3247…): the
/// lattice R₂ of M. Roberts, *The unreasonable effectiveness of quasirandom sequences* (2018), which has no period that
/// an eye would find. It is the same in whole numbers on every device.
#[inline(always)]
pub fn dither(column: u32, row: u32) -> f32 {
    const COLUMN: u32 = 0xc13f_a9a9;
    const ROW: u32 = 0x91e1_0da6;
    let fraction = column.wrapping_mul(COLUMN).wrapping_add(row.wrapping_mul(ROW));
    // Farther from 0 and from 1 than the rounding of the curve at white.
    ((fraction >> 20) as f32 + 0.5) * (1.0 / 4096.0)
}

/// Linear RGB for a display, each of at most 1, from that of a sky: exposed, up to 1e30, and brought into range by the
/// view transform of a variant, or cut. `tables` are the colour rows.
#[inline(always)]
pub fn shown(rgb: Vec3, exposure: f32, grade: &Grade, tables: &[Vec4], variant: u32) -> Vec3 {
    let exposed = rgb * exposure;
    let exposed = Vec3::new(min(exposed.x, BRIGHTEST), min(exposed.y, BRIGHTEST), min(exposed.z, BRIGHTEST));
    if variant & AGX != 0 {
        agx(exposed, grade, variant)
    } else if variant & ACES != 0 {
        aces2(exposed, tables, grade.tables, variant)
    } else {
        Vec3::new(min(exposed.x, 1.0), min(exposed.y, 1.0), min(exposed.z, 1.0))
    }
}

/// A pixel of an 8 bit picture in the curve of sRGB from linear RGB of a display, cut at white.
///
/// A value becomes the byte above it where it has come so near that `threshold` (from 0 to below 1) makes up for the
/// rest: [`NEAREST`], or [`dither`]. Returns red in the lowest byte, then green, blue, and 255.
#[inline(always)]
pub fn bytes(shown: Vec3, threshold: f32) -> u32 {
    bytes_of_encoded(encoded(shown), threshold)
}

/// Linear RGB of a display in the curve of sRGB.
#[inline(always)]
pub fn encoded(shown: Vec3) -> Vec3 {
    Vec3::new(srgb_encode(shown.x), srgb_encode(shown.y), srgb_encode(shown.z))
}

/// [`bytes`] of values in the curve of sRGB, in [0, 1].
#[inline(always)]
pub fn bytes_of_encoded(encoded: Vec3, threshold: f32) -> u32 {
    let byte = |x: f32| (255.0 * x + threshold) as u32;
    byte(encoded.x) | (byte(encoded.y) << 8) | (byte(encoded.z) << 16) | (255 << 24)
}

/// [`bytes`] of linear RGB without a view transform.
#[inline(always)]
pub fn srgb8(rgb: Vec3, exposure: f32, threshold: f32) -> u32 {
    bytes(shown(rgb, exposure, &Grade::NONE, &[], 0), threshold)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transfer_function_is_that_of_the_standard() {
        for i in 0..=100_000 {
            let x = f64::from(i) * 1e-5;
            let truth = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
            assert!((f64::from(srgb_encode(x as f32)) - truth).abs() < 2e-5, "{x}");
        }
    }

    #[test]
    fn a_picture_has_the_bytes_of_srgb() {
        assert_eq!(srgb8(Vec3::ZERO, 1.0, NEAREST), 0xff00_0000);
        // 0.5 linear is 188 in sRGB; 0.25 with one stop more is the same.
        assert_eq!(srgb8(Vec3::splat(0.5), 1.0, NEAREST) & 0xff, 188);
        assert_eq!(srgb8(Vec3::splat(0.25), 2.0, NEAREST) & 0xff, 188);
        assert_eq!(srgb8(Vec3::splat(1e30), 1.0, NEAREST), 0xffff_ffff);
    }

    /// An exposure of 50 stops once made an infinity of them, and of that a NaN and a black pixel.
    #[test]
    fn a_light_beyond_single_precision_is_white() {
        for view in [0, AGX] {
            assert_eq!(bytes(shown(Vec3::new(1e30, 2e30, 1e31), 1e15, &Grade::NONE, &[], view), NEAREST), 0xffff_ffff);
        }
    }

    #[test]
    fn the_mean_of_dithered_bytes_is_the_value() {
        // Of 16×16 pixels the thresholds are even to a few parts in 256; rounding to the nearest byte would be off by
        // up to a half.
        for i in 0..50 {
            let linear = 0.2 + i as f32 * 1e-4;
            let bytes =
                (0..256).map(|i| srgb8(Vec3::splat(linear), 1.0, dither(1000 + i % 16, 70_000 + i / 16)) & 0xff);
            let mean = bytes.sum::<u32>() as f32 / 256.0;
            let value = 255.0 * srgb_encode(linear);
            assert!((mean - value).abs() < 0.02, "{linear}: {mean} and not {value}");
        }
    }

    #[test]
    fn a_dither_leaves_black_black_and_white_white() {
        for i in 0..10_000 {
            let threshold = dither(i, i / 3);
            assert!((0.0..1.0).contains(&threshold));
            assert_eq!(srgb8(Vec3::ZERO, 1.0, threshold), 0xff00_0000);
            assert_eq!(srgb8(Vec3::splat(1e30), 1.0, threshold), 0xffff_ffff);
        }
    }
}
