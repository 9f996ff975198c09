//! How a dark sky looks to an eye: its rods, which know no colours, take over from its cones, and what is left of the
//! colours is blue.
//!
//! H. W. Jensen, S. Premože, P. Shirley, W. B. Thompson, J. A. Ferwerda and M. M. Stark (2000, *Night rendering*,
//! University of Utah UUCS-00-016). With XYZ in cd/m²:
//!
//! ```text
//! V = Y (1.33 (1 + (Y + Z) / X) - 1.68)         the light of the rods (Larson, Rushmeier and Piatko 1997)
//! s = 3 t² - 2 t³,  t = (log10 Y + 2) / 2.6     the part of the cones, in [0, 1]
//! x' = s x + (1 - s) / 4,  y' likewise          chromaticity
//! Y' = s Y + 0.4468 (1 - s) V                   luminance
//! ```
//!
//! so that 4 cd/m² and more look as they are, and 0.01 cd/m² and less has one blue. `V` is a fit to the functions of
//! both kinds of sight; an integral of its own over the spectrum would be a fourth row of every colour.

use bytemuck::{Pod, Zeroable};

use crate::display::rgb::RgbSpace;
use crate::glam::{Vec2, Vec3, Vec4};
use crate::math::{clamp, ln, max};

/// From linear RGB to the light that an eye sees. The layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Eye {
    /// X, Y and Z (cd/m²) of red; `w` is the unit of linear RGB's luminance per cd/m².
    pub red: Vec4,
    /// Those of green; `w` unused.
    pub green: Vec4,
    /// Those of blue; `w` unused.
    pub blue: Vec4,
}

/// The chromaticity of what rods see, in x and in y.
const BLUE: f32 = 0.25;

/// The luminance that rods give to their light.
const RODS: f32 = 0.4468;

/// Linear RGB as an eye sees it, of linear RGB within the gamut of a space.
#[inline(always)]
pub fn by_eye(rgb: Vec3, eye: &Eye, space: &RgbSpace) -> Vec3 {
    let xyz = (eye.red * rgb.x + eye.green * rgb.y + eye.blue * rgb.z).truncate();
    let cones = part_of_cones(xyz.y);
    let seen = space.from_xyz(mesopic(xyz, cones)) * eye.red.w;
    // Bright light stays to the bit, and rounding leaves nothing negative.
    if cones < 1.0 { Vec3::new(max(seen.x, 0.0), max(seen.y, 0.0), max(seen.z, 0.0)) } else { rgb }
}

/// The part of the cones in sight at a luminance (cd/m²).
#[inline(always)]
fn part_of_cones(luminance: f32) -> f32 {
    /// Far below where the rods are alone.
    const DARKEST: f32 = 1e-9;
    let decades = ln(max(luminance, DARKEST)) * core::f32::consts::LOG10_E;
    let t = clamp((decades + 2.0) * (1.0 / 2.6), 0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// XYZ (cd/m²) of which cones see a part.
#[inline(always)]
fn mesopic(xyz: Vec3, cones: f32) -> Vec3 {
    let Vec3 { x, y, z } = xyz;
    let sum = max(x + y + z, f32::MIN_POSITIVE);
    let rods = max(y * (1.33 * (1.0 + (y + z) / max(x, f32::MIN_POSITIVE)) - 1.68), 0.0);
    let at = Vec2::new(x, y) * (cones / sum) + Vec2::splat((1.0 - cones) * BLUE);
    let luminance = cones * y + RODS * (1.0 - cones) * rods;
    Vec3::new(at.x, at.y, 1.0 - at.x - at.y) * (luminance / max(at.y, f32::MIN_POSITIVE))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Linear RGB that is XYZ in cd/m².
    const EYE: Eye = Eye { red: Vec4::new(1.0, 0.0, 0.0, 1.0), green: Vec4::Y, blue: Vec4::Z };
    const SPACE: RgbSpace = RgbSpace { red: Vec4::X, green: Vec4::new(0.0, 1.0, 0.0, 1.0), blue: Vec4::Z };
    const D65: Vec3 = Vec3::new(0.9505, 1.0, 1.089);
    /// The light of a candle: illuminant A.
    const WARM: Vec3 = Vec3::new(1.0985, 1.0, 0.3558);

    fn seen(xyz: Vec3) -> Vec3 {
        by_eye(xyz, &EYE, &SPACE)
    }

    #[test]
    fn four_candelas_and_more_look_as_they_are() {
        for luminance in [4.0, 100.0, 1e4, 1e30] {
            assert_eq!(seen(WARM * luminance), WARM * luminance);
        }
    }

    #[test]
    fn by_starlight_everything_is_of_one_blue() {
        for xyz in [D65 * 1e-3, WARM * 1e-3, Vec3::new(0.2, 0.1, 0.9) * 1e-2] {
            let seen = seen(xyz);
            // 1 : 1 : 2 are x = y = 1/4.
            assert!((seen / seen.y - Vec3::new(1.0, 1.0, 2.0)).abs().max_element() < 1e-5, "{xyz}: {seen}");
        }
    }

    #[test]
    fn rods_see_a_cold_light_brighter_than_a_warm_one() {
        let [cold, warm] = [D65, WARM].map(|xyz| seen(xyz * 1e-3).y);
        assert!(cold > 1.5 * warm, "{cold} {warm}");
    }

    #[test]
    fn a_brighter_light_never_looks_darker() {
        for xyz in [D65, WARM, Vec3::new(0.4, 0.5, 0.9)] {
            let mut last = 0.0;
            for step in 0..=240 {
                let now = seen(xyz * (step as f32 * 0.1 - 20.0).exp2()).y;
                assert!(now > last, "{xyz} at step {step}: {now} after {last}");
                last = now;
            }
        }
    }

    #[test]
    fn black_is_black() {
        assert_eq!(seen(Vec3::ZERO), Vec3::ZERO);
    }
}
