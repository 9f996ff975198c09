//! AgX, the view transform that forms a picture as film does: bright colours go to white, and none turns to the primary
//! that it is nearest to.
//!
//! Sobotka's transform (T. J. Sobotka 2022, <https://github.com/sobotka/AgX>) in the form that Blender has since 4.0
//! (Z. E. Zhou, M. Faderbauer and S. Kapanen 2023, <https://github.com/EaryChow/AgX_LUT_Gen>), which stands in Blender
//! as a table of 57³ colours; here it is computed. In linear Rec. 2020, of which `v` are the components through the
//! inset:
//!
//! ```text
//! x = (log2(v / 0.18) + 10) / 16.5                       stops about middle grey, -10 to 6.5
//! y = p + s t (1 + t^1.5)^(-2/3),  t = 2.4 (x - q) / s    the sigmoid about (q, p) = (10/16.5, 0.18^(1/2.4)) of slope 2.4
//! f = y^2.4                                               linear light
//! ```
//!
//! with one scale `s` for the toe and one for the shoulder, by which y(0) = 0 and y(1) = 1. Of the hue that the curve
//! leaves, two fifths are kept and three fifths are that of `v`; then the outset brings back what the inset took of the
//! chroma.
//!
//! A wider display is formed alike, and as Blender does it: on Rec. 2020 what is negative is cut, on Display P3 it is
//! lifted as on Rec. 709.

use crate::display::grade::{Grade, MIDDLE_GREY};
use crate::display::rgb::{highest, lowest};
use crate::glam::{Mat3, Vec3, Vec4};
use crate::math::{clamp, exp4, ln4, max, max4, min, pow, sqrt, sqrt4};
use crate::variant;

/// From linear Rec. 709 to the inset components: to Rec. 2020 of the same white, and towards grey by the inset with its
/// turned primaries.
const REC709_INSET: Mat3 = Mat3::from_cols_array(&[
    0.544812996,
    0.140415538,
    0.0888119027,
    0.373796137,
    0.754143246,
    0.178885106,
    0.0813908664,
    0.105441215,
    0.732302991,
]);

/// Their light back to linear Rec. 709.
const REC709_OUTSET: Mat3 = Mat3::from_cols_array(&[
    1.96489403,
    -0.299309079,
    -0.164356444,
    -0.856007909,
    1.32639189,
    -0.238207402,
    -0.10888612,
    -0.0270828126,
    1.40256385,
]);

/// From linear Display P3 to the inset components.
const DISPLAY_P3_INSET: Mat3 = Mat3::from_cols_array(&[
    0.650048,
    0.138214435,
    0.0868836929,
    0.260561103,
    0.745980375,
    0.108834158,
    0.0893908965,
    0.11580519,
    0.804282149,
]);

/// Their light back to linear Display P3.
const DISPLAY_P3_OUTSET: Mat3 = Mat3::from_cols_array(&[
    1.56290186,
    -0.22415287,
    -0.137750006,
    -0.468539299,
    1.253951,
    -0.135470129,
    -0.09436256,
    -0.0297981283,
    1.27322013,
]);

/// From linear Rec. 2020 to the inset components.
const REC2020_INSET: Mat3 = Mat3::from_cols_array(&[
    0.856627153,
    0.137318973,
    0.111898213,
    0.0951212405,
    0.761241991,
    0.0767994186,
    0.0482516061,
    0.101439036,
    0.811302368,
]);

/// Their light back to linear Rec. 2020.
const REC2020_OUTSET: Mat3 = Mat3::from_cols_array(&[
    1.12710058,
    -0.141329763,
    -0.141329763,
    -0.110606643,
    1.1578237,
    -0.110606643,
    -0.0164939387,
    -0.0164939387,
    1.25193641,
]);

/// Parts of the primaries in the luminance by the functions of CIE 2015, by which a colour outside the gamut is judged;
/// on Rec. 2020 none is.
const REC709_JUDGED: Vec3 = Vec3::new(0.210351141, 0.64979777, 0.139851089);
const DISPLAY_P3_JUDGED: Vec3 = Vec3::new(0.227594332, 0.618808406, 0.153597262);

/// Those by the functions of CIE 1931, which a chroma leaves as they are; of Rec. 709 they are [`MEAN`].
const DISPLAY_P3_LUMINANCE: Vec3 = Vec3::new(0.22897457, 0.69173852, 0.07928691);
const REC2020_LUMINANCE: Vec3 = Vec3::new(0.26270021, 0.67799807, 0.05930172);

/// That of three values, of Rec. 709, Display P3 and Rec. 2020, which belongs to a variant's display.
#[inline(always)]
fn of_display<T>(variant: u32, rec709: T, display_p3: T, rec2020: T) -> T {
    if variant & variant::REC2020 != 0 {
        rec2020
    } else if variant & variant::DISPLAY_P3 != 0 {
        display_p3
    } else {
        rec709
    }
}

/// What lies ten stops below middle grey, which is black.
const BLACK: f32 = MIDDLE_GREY / 1024.0;
const STOPS_BELOW: f32 = 10.0;
const STOPS: f32 = 16.5;

/// The sigmoid's pivot (x, y), its slope there, and its scales: `((slope x)^-1.5 ((slope x / y)^1.5 - 1))^(-2/3)` for
/// the toe with the pivot's x and y, for the shoulder with 1 less those.
const PIVOT_X: f32 = STOPS_BELOW / STOPS;
const PIVOT_Y: f32 = 0.48943709;
const SLOPE: f32 = 2.4;
const TOE: f32 = -0.565675607;
const SHOULDER: f32 = 0.715198286;

/// The part of the hue that is that of the components before the curve.
const KEPT_HUE: f32 = 0.6;

/// Parts of the components in the mean of stops about which a grade saturates, those of Rec. 709 in the luminance as
/// Blender's looks have them.
const MEAN: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Linear RGB of a variant's display, each in [0, 1], of exposed linear RGB of its primaries, none of it negative and
/// each at most 1e30.
///
/// A grade stretches the stops of the inset components about middle grey, as Blender's looks of contrast do, and the
/// chroma of what is shown.
#[inline(always)]
pub fn agx(rgb: Vec3, grade: &Grade, variant: u32) -> Vec3 {
    let inset = of_display(variant, REC709_INSET, DISPLAY_P3_INSET, REC2020_INSET);
    let outset = of_display(variant, REC709_OUTSET, DISPLAY_P3_OUTSET, REC2020_OUTSET);
    // In logarithms about middle grey. Far below black nothing is lost, and no logarithm is infinite.
    let stops = ln4(max4((inset * rgb).extend(MIDDLE_GREY), BLACK / 1024.0) * (1.0 / MIDDLE_GREY)).truncate();
    let mean = Vec3::splat(MEAN.dot(stops));
    let graded = (mean + (stops - mean) * grade.saturation) * grade.contrast;
    let formed = curve(graded);
    let darkest = lowest(formed);
    let range = highest(formed) - darkest;
    let before = exp4(graded.extend(0.0)).truncate();
    let lowest_before = lowest(before);
    // The smallest normal number: of a grey no component has a hue.
    let range_before = max(highest(before) - lowest_before, f32::MIN_POSITIVE);
    let hue_before = (before - Vec3::splat(lowest_before)) * (range / range_before);
    let hue_after = formed - Vec3::splat(darkest);
    let mixed = Vec3::splat(darkest) + hue_before * KEPT_HUE + hue_after * (1.0 - KEPT_HUE);
    let light = outset * mixed;
    let is_cut = variant & variant::REC2020 != 0;
    let judged = of_display(variant, REC709_JUDGED, DISPLAY_P3_JUDGED, REC709_JUDGED);
    let shown = if is_cut { at_least_black(light) } else { into_display(light, judged) };
    let shown = Vec3::new(min(shown.x, 1.0), min(shown.y, 1.0), min(shown.z, 1.0));
    with_chroma(shown, grade.chroma, of_display(variant, MEAN, DISPLAY_P3_LUMINANCE, REC2020_LUMINANCE))
}

/// A colour of a display of the same luminance and hue with so many times its chroma, or less towards the end of the
/// gamut. What chroma gains, `a`, and what the gamut has room for, `b`, both in units of the chroma, become
/// `a b / (a^4 + b^4)^(1/4)`: without the corner of the smaller of both, which would be seen as a line in a sky.
#[inline(always)]
fn with_chroma(rgb: Vec3, chroma: f32, parts: Vec3) -> Vec3 {
    let luminance = parts.dot(rgb);
    let away = rgb - Vec3::splat(luminance);
    let above = (1.0 - luminance) / max(highest(away), f32::MIN_POSITIVE);
    let below = luminance / max(-lowest(away), f32::MIN_POSITIVE);
    let (gain, room) = (chroma - 1.0, clamp(min(above, below) - 1.0, 0.0, 1e3));
    let (gain_2, room_2) = (gain * gain, room * room);
    let quartic = sqrt(sqrt(max(gain_2 * gain_2 + room_2 * room_2, 1e-30)));
    let kept = rgb + away * (gain * room / quartic);
    // Rounding leaves a ten-millionth beyond the ends.
    Vec3::new(clamp(kept.x, 0.0, 1.0), clamp(kept.y, 0.0, 1.0), clamp(kept.z, 0.0, 1.0))
}

/// The sigmoid of each component's logarithm about middle grey, as linear light.
#[inline(always)]
fn curve(logarithms: Vec3) -> Vec3 {
    let from_pivot = max4(logarithms.extend(0.0) * (core::f32::consts::LOG2_E / STOPS), -PIVOT_X);
    let of_end = |toe, shoulder| {
        let of = |x: f32| if x < 0.0 { toe } else { shoulder };
        Vec4::new(of(from_pivot.x), of(from_pivot.y), of(from_pivot.z), shoulder)
    };
    let scale = of_end(TOE, SHOULDER);
    // A rounding below 0 has no root.
    let t = max4(from_pivot * of_end(SLOPE / TOE, SLOPE / SHOULDER), 0.0);
    let root = sqrt4(Vec4::ONE / (Vec4::ONE + t * sqrt4(t)));
    // Near black the difference of two equal numbers may be negative.
    let y = max4(scale * t * polynomial(BENT, root) + Vec4::splat(PIVOT_Y), 0.0);
    (y * y * polynomial(LIGHT, sqrt4(sqrt4(y)))).truncate()
}

/// `x^(4/3)` from 0.2, which is far beyond white, to 1, within 5e-6.
const BENT: [f32; 7] = [-0.00819545332, 0.437159704, 1.14768154, -1.21764161, 1.0794825, -0.567152683, 0.128670177];

/// `x^1.6` from 0 to 1, which times `x^8` is within a thousandth of a picture's byte.
const LIGHT: [f32; 7] = [-0.00691978761, 0.200766805, 1.18635687, -0.6185636, 0.309888314, -0.0715313679, 0.0];

#[inline(always)]
fn polynomial(terms: [f32; 7], x: Vec4) -> Vec4 {
    let low = (x * terms[2] + Vec4::splat(terms[1])) * x + Vec4::splat(terms[0]);
    let high = ((x * terms[6] + Vec4::splat(terms[5])) * x + Vec4::splat(terms[4])) * x + Vec4::splat(terms[3]);
    high * (x * x * x) + low
}

/// A colour without its negative components.
#[inline(always)]
fn at_least_black(rgb: Vec3) -> Vec3 {
    Vec3::new(max(rgb.x, 0.0), max(rgb.y, 0.0), max(rgb.z, 0.0))
}

/// A colour without negative components: one outside the gamut is lifted by its most negative and scaled to the
/// brightness that it had, of which the luminance and that of the opposite colour have parts.
#[inline(always)]
fn into_display(rgb: Vec3, parts: Vec3) -> Vec3 {
    let least = lowest(rgb);
    if least >= 0.0 {
        rgb
    } else {
        let luminance = max(parts.dot(rgb), f32::MIN_POSITIVE);
        let lifted = luminance - least;
        let ratio = brightness(luminance, least) / brightness(lifted, 0.0);
        (rgb - Vec3::splat(least)) * min(ratio, 1.0)
    }
}

#[inline(always)]
fn brightness(luminance: f32, least: f32) -> f32 {
    let part = min(pow(luminance, 0.08), 1.0);
    part * luminance + (1.0 - part) * (2.0 * luminance - least)
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "tests run on the processor")]
mod tests {
    use super::*;
    use crate::display::tone::srgb_encode;

    /// Colours as they stand in Blender's tables of displays, and what it makes of them.
    const BLENDER: [(u32, &str); 3] = [
        (0, include_str!("../../data/agx_blender.csv")),
        (variant::DISPLAY_P3, include_str!("../../data/agx_blender_p3.csv")),
        (variant::REC2020, include_str!("../../data/agx_blender_rec2020.csv")),
    ];

    /// The grades that pictures may have.
    const GRADES: [Grade; 4] =
        [Grade::NONE, Grade::new(1.2, 0.85, 1.5), Grade::new(1.2, 1.0, 1.0), Grade::new(1.4, 0.95, 1.0)];

    /// Degrees by which a hue may turn: AgX turns the primaries on purpose, and its curves bend those of the gamut's
    /// edge most (found: 23.4).
    const WORST_TURN: f32 = 24.0;

    /// Colours along each direction of a cube, from 8 stops below middle grey upwards.
    fn rays() -> impl Iterator<Item = Vec3> {
        const SIDE: u32 = 6;
        (1..SIDE * SIDE * SIDE).map(|i| {
            let rgb = Vec3::new((i % SIDE) as f32, (i / SIDE % SIDE) as f32, (i / SIDE / SIDE) as f32);
            rgb / rgb.max_element()
        })
    }

    #[test]
    fn a_colour_is_shown_as_blender_shows_it() {
        let (mut compared, mut worst) = (0, 0.0f32);
        let lines = |(display, table): (u32, &'static str)| {
            let lines = table.lines().filter(|line| !line.starts_with('#')).skip(1);
            lines.map(move |line| (display, line))
        };
        for (display, line) in BLENDER.into_iter().flat_map(lines) {
            let numbers: [f32; 6] = core::array::from_fn(|i| line.split(',').nth(i).unwrap().parse().unwrap());
            let shown = agx(Vec3::from_slice(&numbers), &Grade::NONE, display);
            for (shown, theirs) in shown.to_array().into_iter().zip(&numbers[3..]) {
                // The table holds y, of seven digits.
                let off = 255.0 * (srgb_encode(shown) - srgb_encode(theirs.powf(2.4))).abs();
                assert!(off < 0.1, "{line}: {shown}");
                worst = worst.max(off);
            }
            compared += 1;
        }
        assert!(compared > 1400 && worst > 0.0, "{compared} colours, worst {worst}");
    }

    #[test]
    fn a_chroma_leaves_the_luminance_of_every_display() {
        for luminance in [MEAN, DISPLAY_P3_LUMINANCE, REC2020_LUMINANCE] {
            assert!((luminance.element_sum() - 1.0).abs() < 1e-6);
            for rgb in [Vec3::new(0.3, 0.2, 0.5), Vec3::new(0.9, 0.1, 0.0)] {
                let shown = with_chroma(rgb, 1.5, luminance);
                assert!(luminance.dot(shown - rgb).abs() < 1e-6, "{rgb}: {shown}");
            }
        }
    }

    #[test]
    fn more_light_of_any_colour_is_a_brighter_pixel_until_it_is_white() {
        for (ray, grade) in rays().flat_map(|ray| GRADES.map(|grade| (ray, grade))) {
            let mut last = -1.0;
            for step in 0..=340 {
                let shown = agx(ray * MIDDLE_GREY * (step as f32 * 0.05 - 9.0).exp2(), &grade, 0);
                let luminance = Vec3::new(0.2126, 0.7152, 0.0722).dot(shown);
                // Ten stops below middle grey all is black, and a little below that where a grade has more contrast.
                let (is_white, is_black) = (shown.min_element() > 0.999, shown.max_element() < 1e-4);
                assert!(
                    luminance > last || (is_white || is_black) && luminance > last - 1e-3,
                    "{ray} at step {step}, contrast {}: {luminance}, {last}",
                    grade.contrast
                );
                last = luminance;
            }
        }
    }

    /// Oklab's chroma and hue (degrees) of linear RGB (B. Ottosson 2020).
    fn chroma_and_hue(rgb: Vec3) -> (f32, f32) {
        let lms = Vec3::new(
            Vec3::new(0.412_221_46, 0.536_332_55, 0.051_445_995).dot(rgb).cbrt(),
            Vec3::new(0.211_903_5, 0.680_699_5, 0.107_396_96).dot(rgb).cbrt(),
            Vec3::new(0.088_302_46, 0.281_718_85, 0.629_978_7).dot(rgb).cbrt(),
        );
        let a = Vec3::new(1.977_998_5, -2.428_592_2, 0.450_593_7).dot(lms);
        let b = Vec3::new(0.025_904_037, 0.782_771_77, -0.808_675_77).dot(lms);
        (a.hypot(b), b.atan2(a).to_degrees())
    }

    #[test]
    fn no_hue_turns_by_more_than_24_degrees_before_it_goes_to_white() {
        let (mut worst, mut compared) = (0.0f32, 0);
        for (ray, grade) in rays().flat_map(|ray| GRADES.map(|grade| (ray, grade))) {
            for stops in -4..=3 {
                let rgb = ray * MIDDLE_GREY * (stops as f32).exp2();
                let (chroma, shown) = chroma_and_hue(agx(rgb, &grade, 0));
                if chroma > 0.04 {
                    let off = (shown - chroma_and_hue(rgb).1 + 540.0).rem_euclid(360.0) - 180.0;
                    assert!(off.abs() < WORST_TURN, "{ray} at {stops} stops: {off} degrees");
                    worst = worst.max(off.abs());
                    compared += 1;
                }
            }
        }
        assert!(compared > 1000 && worst > 1.0, "{compared} colours, {worst} degrees");
    }

    #[test]
    fn no_light_is_lost_to_what_no_number_is() {
        for ray in rays() {
            for value in [0.0, 1e-38, 1e-10, 1e-3, 1.0, 1e4, 1e30] {
                let shown = agx(ray * value, &Grade::NONE, 0);
                assert!(shown.min_element() >= 0.0 && shown.max_element() <= 1.0, "{ray} times {value}: {shown}");
            }
            assert!(agx(ray * 1e30, &Grade::NONE, 0).max_element() > 0.999);
        }
        // A hundred-thousandth of a byte.
        let black = agx(Vec3::ZERO, &Grade::NONE, 0);
        assert!(black.max_element() < 3e-9, "{black}");
    }
}
