//! From linear RGB to a picture: the shoulder, the curve of sRGB, and packing.

use crate::glam::Vec3;
use crate::math::{clamp, max, min, sqrt};

/// A linear value that every picture shows as white: an infinite one would have no hue to keep.
const BRIGHTEST: f32 = 1e30;

/// Where [`shoulder`] leaves the straight line.
const SHOULDER_START: f32 = 0.8;

/// Brings values above 1 into the range of a display: a straight line up to 0.8, then a curve that reaches 1 at infinity.
///
/// The peak of the three components is compressed and the others scale with it, so that the hue stays, fading to
/// white far above 1. This is the compression of the Khronos PBR Neutral tone mapper (Khronos Group 2024,
/// <https://github.com/KhronosGroup/ToneMapping>) without its Fresnel offset, which is meant for lit surfaces.
#[inline(always)]
pub fn shoulder(rgb: Vec3) -> Vec3 {
    const DESATURATION: f32 = 0.15;
    let peak = max(rgb.x, max(rgb.y, rgb.z));
    if peak < SHOULDER_START {
        rgb
    } else {
        let room = 1.0 - SHOULDER_START;
        let new_peak = 1.0 - room * room / (peak + room - SHOULDER_START);
        let whiteness = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
        let scaled = rgb * (new_peak / peak);
        scaled + (Vec3::splat(new_peak) - scaled) * whiteness
    }
}

/// The sRGB transfer function of a linear value in [0, 1] (IEC 61966-2-1:1999), to 2e-5, a two-hundredth of an 8 bit step.
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

/// A pixel's threshold of [`srgb8`] in an ordered dither: over any few pixels the thresholds lie evenly in [0, 1), so that the mean of the bytes is
/// the value, and steps between two bytes cannot be seen as rings around the sun.
///
/// They are the fractional parts of `column / g + row / g²` in 32 bits, with `g` the root of g³ = g + 1 (1.3247…): the lattice R₂ of M. Roberts, *The
/// unreasonable effectiveness of quasirandom sequences* (2018), which has no period that an eye would find. It is the same in whole numbers on every
/// device.
#[inline(always)]
pub fn dither(column: u32, row: u32) -> f32 {
    const COLUMN: u32 = 0xc13f_a9a9;
    const ROW: u32 = 0x91e1_0da6;
    let fraction = column.wrapping_mul(COLUMN).wrapping_add(row.wrapping_mul(ROW));
    // Farther from 0 and from 1 than the rounding of the curve at white.
    ((fraction >> 20) as f32 + 0.5) * (1.0 / 4096.0)
}

/// A pixel of an 8 bit sRGB picture from linear RGB: exposed, brought into range, encoded.
///
/// `exposure` multiplies the linear value, up to 1e30, white in every picture. A value becomes the byte above it where it has come so near that
/// `threshold` (from 0 to below 1) makes up for the rest: [`NEAREST`], or [`dither`]. Returns red in the lowest byte, then green, blue, and 255.
#[inline(always)]
pub fn srgb8(rgb: Vec3, exposure: f32, threshold: f32) -> u32 {
    let exposed = rgb * exposure;
    let compressed =
        shoulder(Vec3::new(min(exposed.x, BRIGHTEST), min(exposed.y, BRIGHTEST), min(exposed.z, BRIGHTEST)));
    let byte = |x: f32| (255.0 * srgb_encode(x) + threshold) as u32;
    byte(compressed.x) | (byte(compressed.y) << 8) | (byte(compressed.z) << 16) | (255 << 24)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shoulder_keeps_the_hue() {
        // The hue of a hexcone: where the middle component stands between the smallest and the largest.
        let place = |rgb: Vec3| (rgb.y - rgb.x) / (rgb.z - rgb.x);
        for i in 1..400 {
            let rgb = Vec3::new(0.2, 0.5, 0.9) * (i as f32 * 0.05);
            let shown = shoulder(rgb);
            // Far above 1 the colour fades to white, and what is left of its differences carries the rounding of 1.
            let rounding = 3e-7 / (shown.z - shown.x);
            assert!((place(shown) - place(rgb)).abs() < rounding, "{rgb}: {shown}");
        }
    }

    #[test]
    fn the_shoulder_is_smooth_monotone_and_bounded() {
        let mut last = 0.0;
        for i in 1..100_000 {
            let x = i as f32 * 1e-3;
            let y = shoulder(Vec3::splat(x)).x;
            // Far above 1 neighbouring values round to the same number, or one ULP past it.
            assert!(y > last - 1.2e-7 && y <= 1.0 && y - last < 1.01e-3, "{x}");
            last = y;
        }
    }

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
        assert_eq!(srgb8(Vec3::new(1e30, 2e30, 1e31), 1e15, NEAREST), 0xffff_ffff);
    }

    #[test]
    fn the_mean_of_dithered_bytes_is_the_value() {
        // Of 16×16 pixels the thresholds are even to a few parts in 256; rounding to the nearest byte would be off by up to a half.
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
