//! From the light of a scene to the signals of a display of high dynamic range.
//!
//! No view transform takes part. The light of Rec. 2020, 1 being white, becomes that of a display of 1000 cd/m² by the
//! opto-optical transfer function of HLG (ITU-R BT.2100-3, table 5): `203 Y^0.2 RGB` cd/m². So white has the 203 cd/m²
//! and middle grey the 26 cd/m² of ITU-R BT.2408-7, table 1. What is brighter than 317 cd/m² rolls off: the curve of
//! ITU-R BT.2390-11, 5.4.1, brings the largest component from a mastering display of 10 000 cd/m² to one of 1000, and
//! the others follow it. So every colour keeps its chromaticity, and with it its hue. The signals are those of PQ
//! (SMPTE ST 2084; ITU-R BT.2100-3, table 4).

use crate::display::rgb::highest;
use crate::glam::Vec3;
use crate::math::{max, min, pow};

/// The luminance of diffuse white (cd/m²; ITU-R BT.2408-7, table 1).
pub const WHITE: f32 = 203.0;

/// The luminance that the brightest is shown with (cd/m²).
pub const PEAK: f32 = 1000.0;

/// The luminance of the signal 1 (cd/m²).
const BRIGHTEST: f32 = 10_000.0;

/// What HLG's system gamma of 1.2 for a peak of 1000 cd/m² adds to the power of the luminance.
const GAMMA_MINUS_ONE: f32 = 0.2;

/// The signal of [`PEAK`].
const PEAK_SIGNAL: f32 = 0.751_827_1;

/// The signal up to which light stays as it is.
const KNEE: f32 = 1.5 * PEAK_SIGNAL - 0.5;

// Numbers of PQ, as the standards name them.
const M1: f32 = 2610.0 / 16384.0;
const M2: f32 = 2523.0 / 4096.0 * 128.0;
const C1: f32 = 3424.0 / 4096.0;
const C2: f32 = 2413.0 / 4096.0 * 32.0;
const C3: f32 = 2392.0 / 4096.0 * 32.0;

/// The signal of a luminance of 0 to 10 000 cd/m²: the inverse of the EOTF.
///
/// As C1 is C3 - C2 + 1, the base of the large power M2 is 1 less something small, which keeps the digits.
#[inline(always)]
pub fn signal(luminance: f32) -> f32 {
    let power = pow(luminance * (1.0 / BRIGHTEST), M1);
    pow(1.0 - (C2 - C3) * (1.0 - power) / (1.0 + C3 * power), M2)
}

/// The luminance (cd/m²) of a signal in [0, 1]: the EOTF.
#[inline(always)]
pub fn luminance(signal: f32) -> f32 {
    let power = pow(signal, 1.0 / M2);
    BRIGHTEST * pow(max(power - C1, 0.0) / (C2 - C3 * power), 1.0 / M1)
}

/// The signal of [`PEAK`] or less that stands for one above [`KNEE`]: Hermite's cubic, which begins with the slope 1
/// and ends level.
#[inline(always)]
fn rolled_off(signal: f32) -> f32 {
    let t = (min(signal, 1.0) - KNEE) / (1.0 - KNEE);
    let (t2, t3) = (t * t, t * t * t);
    (2.0 * t3 - 3.0 * t2 + 1.0) * KNEE + (t3 - 2.0 * t2 + t) * (1.0 - KNEE) + (3.0 * t2 - 2.0 * t3) * PEAK_SIGNAL
}

/// Light of a display (cd/m²), in no component above [`PEAK`], from that of a scene, in no component negative or above
/// [`BRIGHTEST`](super::tone::BRIGHTEST). Both are linear RGB of Rec. 2020, with these parts of the primaries in the
/// luminance.
#[inline(always)]
pub fn displayed(rgb: Vec3, parts: Vec3) -> Vec3 {
    let light = rgb * (WHITE * pow(parts.dot(rgb), GAMMA_MINUS_ONE));
    let brightest = highest(light);
    let seen = signal(min(brightest, BRIGHTEST));
    if seen <= KNEE { light } else { light * (luminance(rolled_off(seen)) / brightest) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Those of Rec. 2020 (ITU-R BT.2020-2, table 4).
    const PARTS: Vec3 = Vec3::new(0.2627, 0.6780, 0.0593);

    /// The largest component of a grey on the display (cd/m²).
    fn of_grey(light: f32) -> f32 {
        displayed(Vec3::splat(light), PARTS).max_element()
    }

    #[test]
    fn signals_are_those_that_the_standards_print() {
        // To the digits that are printed: BT.2408-7, BT.2390-11 and the formula in double precision.
        for (luminance, printed) in
            [(100.0, 0.508_078), (203.0, 0.580_689), (1000.0, 0.751_827), (4000.0, 0.902_572), (10_000.0, 1.0)]
        {
            // Single precision leaves a fifth of a step of 16 bits, which is 1.5e-5.
            assert!((signal(luminance) - printed).abs() < 4e-6, "{luminance}: {}", signal(luminance));
        }
        assert!(signal(0.0) < 4e-6);
    }

    #[test]
    fn a_signal_has_the_luminance_that_it_stands_for() {
        // A step of 16 bits is 1.4e-4 of the luminance and more; single precision leaves half of that.
        for step in 0..=996 {
            // Up to 9900 cd/m².
            let truth = 1e-2 * (step as f32 * 0.02).exp2();
            assert!((luminance(signal(truth)) / truth - 1.0).abs() < 7e-5, "{truth}: {}", luminance(signal(truth)));
        }
    }

    #[test]
    fn white_and_middle_grey_are_where_broadcasters_put_them() {
        assert!((of_grey(1.0) - 203.0).abs() < 0.01);
        // BT.2408 says 26 cd/m², and a signal of 38 %.
        assert!((of_grey(0.18) - 26.0).abs() < 0.1, "{}", of_grey(0.18));
        assert!((signal(of_grey(0.18)) - 0.38).abs() < 0.005);
    }

    #[test]
    fn more_light_is_never_darker_and_goes_to_the_peak_without_a_corner() {
        let (mut last, mut slope) = (signal(of_grey(0.5)), None);
        for step in 1..=600 {
            let now = signal(of_grey(0.5 * (step as f32 * 0.01).exp2()));
            let rise = now - last;
            assert!(rise > -8e-6, "step {step}: {rise}");
            // A step is a hundredth of a stop, 9e-4 of the signal below the knee, where a corner would change that by
            // much of itself; the curve changes it by 4e-6, and rounding by 1.5e-5.
            assert!(slope.is_none_or(|slope: f32| (rise - slope).abs() < 3e-5), "step {step}: {rise} after {slope:?}");
            (last, slope) = (now, Some(rise));
        }
        for light in [26.0, 100.0, 1e4, 1e30] {
            assert!((of_grey(light) - PEAK).abs() < 0.05, "{light}: {}", of_grey(light));
        }
    }

    #[test]
    fn colours_keep_their_chromaticity_and_nothing_is_above_the_peak() {
        for ray in [Vec3::new(1.0, 0.4, 0.05), Vec3::new(0.2, 0.4, 1.0), Vec3::new(0.0, 1.0, 0.0)] {
            for stops in -20..=99 {
                let rgb = ray * (stops as f32).exp2();
                let shown = displayed(rgb, PARTS);
                assert!(shown.max_element() < PEAK * 1.00005 && shown.min_element() >= 0.0, "{rgb}: {shown}");
                let off = (shown / shown.max_element() - ray).abs().max_element();
                assert!(off < 1e-6, "{rgb}: {shown}");
            }
        }
        assert_eq!(displayed(Vec3::ZERO, PARTS), Vec3::ZERO);
    }
}
