//! Runs of a picture that a view transform forms: at four places, between which what a display shows is interpolated.
//!
//! A view transform costs as much as all else that makes a pixel, and along a run what it shows is as smooth as the sky
//! itself. In units of half a run from its middle a cubic in the curve of sRGB goes through -1, -1/2, 1/4 and 1: the
//! ends are among them, so that neighbouring runs meet, and their sum is not 0, so that the cubic's highest term tells
//! of a fourth power, too, as a peak in the middle has it: of `a u^4` it is `a / 4`, and the cubic misses by `0.27 a`
//! at most. A corner, as where a colour reaches the end of the gamut, leaves no such term at one place, -1/11, but a
//! square. Where either term is large, and where the sun's disc stands, each pixel is formed for itself.

use crate::glam::{Vec3, Vec4};
use crate::interpolation::cubic::{ColourCubic, lane};
use crate::math::{abs, max};
use crate::picture::run::RUN;
use crate::variant::{self, PixelFormat};

/// Places of a run at which it is formed.
pub const FORMED: u32 = 4;

/// Where they are, in units of half a run.
const PLACES: Vec4 = Vec4::new(-1.0, -0.5, 0.25, 1.0);

/// What each adds to the terms of the cubic: Lagrange's polynomials, from the constant to the cube.
const TERMS: [Vec4; 4] = [
    Vec4::new(-1.0 / 10.0, 4.0 / 9.0, 32.0 / 45.0, -1.0 / 18.0),
    Vec4::new(3.0 / 10.0, -16.0 / 9.0, 64.0 / 45.0, 1.0 / 18.0),
    Vec4::new(6.0 / 10.0, -4.0 / 9.0, -32.0 / 45.0, 10.0 / 18.0),
    Vec4::new(-8.0 / 10.0, 16.0 / 9.0, -64.0 / 45.0, 8.0 / 18.0),
];

/// The largest cube of a run that is interpolated, of values from 0 to 1: a fourth power beside it is missed by a
/// fifteenth of a byte.
const LARGEST_CUBE: f32 = 0.06 / 255.0;

/// The largest square, likewise: a corner without a cube is missed by two fifths of it.
const LARGEST_SQUARE: f32 = 1.0 / 255.0;

/// Whether a variant's runs are interpolated as they are shown.
#[inline(always)]
pub fn is_formed(variant: u32) -> bool {
    let is_picture = variant::pixel_format(variant) == PixelFormat::Picture as u32;
    is_picture & (variant & variant::RUNS != 0) & (variant & (variant::AGX | variant::ACES) != 0)
}

/// Pixels from the middle of a run to one of the places, counted from 0.
#[inline(always)]
pub fn from_middle_to_formed(place: u32) -> f32 {
    (0.5 * RUN as f32) * lane(PLACES, place)
}

/// What a display shows along a run, in the curve of sRGB.
#[derive(Clone, Copy)]
pub struct FormedRun(ColourCubic);

impl FormedRun {
    /// Black.
    pub const BLACK: Self = Self(ColourCubic::DARK);

    /// Adds what one of the places, counted from 0, shows in the curve of sRGB.
    #[inline(always)]
    pub fn add(&mut self, encoded: Vec3, place: u32) {
        let [value, slope, bend, twist] = TERMS;
        self.0.value += encoded * lane(value, place);
        self.0.slope += encoded * lane(slope, place);
        self.0.bend += encoded * lane(bend, place);
        self.0.twist += encoded * lane(twist, place);
    }

    /// Whether the run is smooth between its places.
    #[inline(always)]
    pub fn is_smooth(self) -> bool {
        let largest = |term: Vec3| max(abs(term.x), max(abs(term.y), abs(term.z)));
        (largest(self.0.twist) <= LARGEST_CUBE) & (largest(self.0.bend) <= LARGEST_SQUARE)
    }

    /// Values in the curve of sRGB so many pixels beside the run's middle.
    #[inline(always)]
    pub fn beside(self, pixels: f32) -> Vec3 {
        self.0.beside(pixels * (2.0 / RUN as f32))
    }
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "tests run on the processor")]
mod tests {
    use super::*;
    use crate::picture::run::from_middle;

    fn run_through(curve: impl Fn(f32) -> f32) -> FormedRun {
        let mut run = FormedRun::BLACK;
        for place in 0..FORMED {
            run.add(Vec3::splat(curve(from_middle_to_formed(place) / 8.0)), place);
        }
        run
    }

    #[test]
    fn a_run_goes_through_a_cubic() {
        let cubic = |u: f32| ((0.3 * u - 0.2) * u + 0.1) * u + 0.5;
        let run = run_through(cubic);
        for pixel in 0..RUN {
            let beside = from_middle(pixel);
            assert!((run.beside(beside).x - cubic(beside / 8.0)).abs() < 1e-6, "{pixel}");
        }
        assert!(!run.is_smooth());
    }

    #[test]
    fn white_and_black_stay_as_they_are() {
        for value in [0.0, 1.0] {
            let run = run_through(|_| value);
            for pixel in 0..RUN {
                // So that no dither sees it: the least threshold is 1/8192 of a byte.
                assert!(255.0 * (run.beside(from_middle(pixel)).x - value).abs() < 1.0 / 8192.0);
            }
        }
    }

    /// Wherever in the run it is: a peak of five pixels either way, a corner, and a wave.
    #[test]
    fn what_a_smooth_run_misses_is_a_third_of_a_byte_at_most() {
        let (mut smooth, mut rough, mut worst) = (0, 0, 0.0f32);
        for kind in 0..3 {
            for at in -20..=20 {
                for width in 7..40 {
                    for height in 1..20 {
                        let (at, width, height) = (0.05 * at as f32, 0.1 * width as f32, 0.01 * height as f32);
                        let curve = |u: f32| match kind {
                            0 => height / (1.0 + (u - at) * (u - at) / (width * width)),
                            1 => height * (u - at).max(0.0) / width,
                            _ => height * (0.5 + 0.5 * ((u - at) / width).sin()),
                        };
                        let run = run_through(curve);
                        if run.is_smooth() {
                            let off = |pixel| {
                                255.0 * (run.beside(from_middle(pixel)).x - curve(from_middle(pixel) / 8.0)).abs()
                            };
                            worst = (0..RUN).map(off).fold(worst, f32::max);
                            smooth += 1;
                        } else {
                            rough += 1;
                        }
                    }
                }
            }
        }
        assert!(smooth > 1000 && rough > 1000 && worst < 0.34, "{smooth} smooth, {rough} rough, worst {worst}");
    }
}
