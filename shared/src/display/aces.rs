//! The output transform of ACES 2.0: from the light of a scene to that of a display of 100 cd/m² with the white D65 and
//! the primaries of Rec. 709 or P3. One of Rec. 2020 shows the colours of P3, as for this brightness the Academy has no
//! wider gamut.
//!
//! A colour becomes lightness `J`, colourfulness `M` and hue `h` of a model of colour appearance. A curve brings the
//! lightness into the range of the display; the colourfulness follows it, first by a curve that knows nothing of the
//! display, then along lines of constant hue into the display's gamut. The hue stays. Formulas and figures are those of
//! the Academy's *ACES 2.0 Output Transform* (`Lib.Academy.OutputTransform.ctl`, <https://github.com/ampas/aces-core>)
//! and of OpenColorIO (`ops/fixedfunction/ACES2`, <https://github.com/AcademySoftwareFoundation/OpenColorIO>), whose
//! styles of these transforms are `ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-100nit-REC709_2.0` and the like with
//! `P3-D65`. Nothing is sampled but the gamuts by hue, as the standard itself does.
//!
//! The model is that of Hellwig and Fairchild (2022, *Brightness, lightness, colorfulness, and chroma in CIECAM02 and
//! CAM16*, Color Research and Application 47) as ACES simplifies it: full adaptation to the white, the same compression
//! for every brightness, no eccentricity of hues. With the cones' light `x` scaled so that white is 1,
//!
//! ```text
//! r = x^0.42 / (c + x^0.42)            response of a cone
//! R = (2 r_L + r_M + r_S / 20) / 3.05  achromatic response
//! J = 100 ((1 + c) R)^z
//! a = k (r_L - 12/11 r_M + r_S / 11)
//! b = k (r_L + r_M - 2 r_S) / 9
//! M = √(a² + b²),  h = ∠(a, b)
//! ```
//!
//! so that the luminance of the model, and its factors for the surround, are left in `c`, `z` and `k` alone.
//!
//! # Tables
//!
//! A host makes [`ROWS`] rows. The first [`DEGREES`] belong to whole degrees of hue: `x` and `y` are the reach of AP1
//! there and one degree further, its colourfulness at `J = 100`; `z` is the row of the last knot that is not above it.
//! Then [`KNOTS`] rows are knots of the display's gamut, unevenly spaced by about a degree: `x` is the lightness of the
//! cusp, `y` its colourfulness, `z` the exponent of the hull above it, `w` the hue in degrees.

use crate::glam::{Mat3, Vec2, Vec3, Vec4};
use crate::math::{abs, angle_of, clamp, fetch, floor, ln, max, min, pow, safe_sqrt};
use crate::variant;

/// Rows that belong to whole degrees of hue.
pub const DEGREES: usize = 360;

/// Rows of knots; the last is the first, a turn further.
pub const KNOTS: usize = 361;

/// Rows of the tables.
pub const ROWS: usize = DEGREES + KNOTS;

/// The most knots within a degree of hue, its lower end excluded.
pub const KNOTS_IN_A_DEGREE: u32 = 2;

/// From linear Rec. 709 to AP1, adapted from D65 to the white of ACES by Bradford's cone responses.
pub const REC709_TO_AP1: Mat3 = Mat3::from_cols(
    Vec3::new(0.613_097_402_4, 0.070_193_722_5, 0.020_615_592_9),
    Vec3::new(0.339_523_146_2, 0.916_353_879_1, 0.109_569_772_9),
    Vec3::new(0.047_379_451_4, 0.013_452_398_5, 0.869_814_634_2),
);

/// From linear Display P3 to AP1, likewise.
pub const DISPLAY_P3_TO_AP1: Mat3 = Mat3::from_cols(
    Vec3::new(0.735_797_914_0, 0.047_179_885_0, 0.003_563_664_6),
    Vec3::new(0.212_166_485_3, 0.938_045_700_9, 0.041_141_885_6),
    Vec3::new(0.052_035_600_7, 0.014_774_414_1, 0.955_294_449_7),
);

/// From linear Rec. 2020 to AP1, likewise.
pub const REC2020_TO_AP1: Mat3 = Mat3::from_cols(
    Vec3::new(0.974_894_977_9, 0.002_179_562_8, 0.004_797_239_7),
    Vec3::new(0.019_599_108_6, 0.995_535_468_9, 0.024_532_016_6),
    Vec3::new(0.005_505_913_4, 0.002_284_968_3, 0.970_670_743_7),
);

/// From AP1 to the cones of CAM16, each scaled so that the white of ACES is 1.
pub const AP1_TO_CONES: Mat3 = Mat3::from_cols(
    Vec3::new(0.409_815_474_8, 0.142_658_121_6, 0.006_586_978_5),
    Vec3::new(0.457_611_264_7, 0.686_865_057_0, 0.036_290_586_9),
    Vec3::new(0.132_573_260_5, 0.170_476_821_4, 0.957_122_434_6),
);

/// From the cones of CAM16, scaled so that D65 is 1, to linear Rec. 709.
pub const CONES_TO_REC709: Mat3 = Mat3::from_cols(
    Vec3::new(5.913_454_005_3, -1.170_761_527_0, 0.008_436_141_9),
    Vec3::new(-4.865_529_710_2, 2.475_041_753_0, -0.252_851_421_3),
    Vec3::new(-0.047_924_295_1, -0.304_280_226_0, 1.244_415_279_5),
);

/// From the cones of CAM16, likewise, to linear Display P3.
pub const CONES_TO_DISPLAY_P3: Mat3 = Mat3::from_cols(
    Vec3::new(4.655_736_326_5, -0.935_606_667_9, 0.023_938_488_2),
    Vec3::new(-3.562_299_104_1, 2.231_377_364_2, -0.134_155_617_0),
    Vec3::new(-0.093_437_222_4, -0.295_770_696_2, 1.110_217_128_8),
);

/// From linear Display P3 to linear Rec. 2020.
pub const DISPLAY_P3_TO_REC2020: Mat3 = Mat3::from_cols(
    Vec3::new(0.753_833_034_4, 0.045_743_849_0, -0.001_210_340_4),
    Vec3::new(0.198_597_369_1, 0.941_777_219_8, 0.017_601_717_3),
    Vec3::new(0.047_569_596_6, 0.012_478_931_2, 0.983_608_623_1),
);

/// The brightest AP1 that the transform knows: eight times what the curve brings to white.
const BRIGHTEST: f32 = 1024.0;

/// The darkest AP1: black on any display, and far from what single precision cannot divide by.
const DARKEST: f32 = 1e-9;

/// Exponent of a cone's response.
pub const CONE_EXPONENT: f32 = 0.42;

/// `c` of a cone's response: 27.13 `F_L^-0.42`, with `F_L` for an adapting luminance of 100 cd/m² (Li et al. 2017,
/// *Comprehensive color solutions*).
pub const HALF_RESPONSE: f32 = 29.894_686;

/// The largest response that a display's light is found from; white has 0.032.
const LARGEST_RESPONSE: f32 = 0.99;

/// `z` of the lightness: 0.59 (1.48 + √0.2), for a dim surround and a background of a fifth of the white.
pub const LIGHTNESS_EXPONENT: f32 = 1.137_056;

/// `k` of the opponent colours: 400 for the responses, times 43 and 0.9 for a dim surround.
pub const OPPONENT_SCALE: f32 = 400.0 * 43.0 * 0.9;

/// The lightness of the display's white.
pub const LIMIT_J: f32 = 100.0;

/// The lightness of 10.013 cd/m², which middle grey becomes.
pub const MIDDLE_J: f32 = 34.096_535;

/// Contrast of the curve of lightness.
pub const CONTRAST: f32 = 1.15;

/// Toe of the curve of lightness.
pub const TOE: f32 = 0.04;

/// What the curve of lightness tends to, before its toe: 128 in the scene become the display's white.
pub const CURVE_LIMIT: f32 = 1.047_103_8;

/// The light of the scene at the middle of the curve of lightness: 0.18 becomes 0.10013.
pub const CURVE_MIDDLE: f32 = 0.919_858_25;

/// Exponent of the hull of a display below its cusp.
pub const LOWER_EXPONENT: f32 = 1.0 / 1.14;

/// Distance of the focus to which colours move, in units of [`LIMIT_J`].
const FOCUS_DISTANCE: f32 = 1.35;

/// Where, between cusp and white, the focus begins to move away.
const FOCUS_BLEND: f32 = 0.3;

/// The part of a gamut within which colours stay, at least.
const KEPT_PART: f32 = 0.75;

/// Width of the rounding at a cusp, in units of its colourfulness.
pub const CUSP_ROUNDING: f32 = 0.12;

/// Linear light of a display in `[0, 1]` from that of a scene, both of the primaries of a variant's display.
///
/// No component of `rgb` may be negative. The tables begin at the row `first` of `tables`.
#[inline(always)]
pub fn aces2(rgb: Vec3, tables: &[Vec4], first: u32, variant: u32) -> Vec3 {
    let scene = appearance(AP1_TO_CONES * within_range(to_ap1(variant) * rgb));
    let hull = hull(tables, first, scene.hue());
    let response = response(tone_curve(light(scene.response)));
    let j = lightness(response);
    let m = scene.m * (response / scene.response);
    let compressed = into_gamut(j, compressed_m(j, m, response, scene.direction, hull.reach_m), &hull);
    display(compressed, scene.direction, variant)
}

/// From the linear RGB of a variant's display to AP1.
#[inline(always)]
fn to_ap1(variant: u32) -> Mat3 {
    if variant & variant::REC2020 != 0 {
        REC2020_TO_AP1
    } else if variant & variant::DISPLAY_P3 != 0 {
        DISPLAY_P3_TO_AP1
    } else {
        REC709_TO_AP1
    }
}

/// AP1 in the range that the transform knows.
#[inline(always)]
fn within_range(ap1: Vec3) -> Vec3 {
    let limited = |x: f32| clamp(x, DARKEST, BRIGHTEST);
    Vec3::new(limited(ap1.x), limited(ap1.y), limited(ap1.z))
}

/// How the light of a scene appears.
#[derive(Clone, Copy)]
struct Appearance {
    /// Achromatic response `R`.
    response: f32,
    /// Colourfulness `M`.
    m: f32,
    /// Cosine and sine of the hue; zero for a grey, whose hue is 0.
    direction: Vec2,
}

impl Appearance {
    /// The hue in degrees, from 0 to 360.
    #[inline(always)]
    fn hue(&self) -> f32 {
        angle_of(self.direction.x, self.direction.y).to_degrees()
    }
}

/// How a cone's light `x > 0` appears to it.
#[inline(always)]
fn response(x: f32) -> f32 {
    let power = pow(x, CONE_EXPONENT);
    power / (HALF_RESPONSE + power)
}

/// The cone's light of a response, with its sign.
#[inline(always)]
fn light(response: f32) -> f32 {
    let r = min(abs(response), LARGEST_RESPONSE);
    let x = pow(HALF_RESPONSE * r / (1.0 - r), 1.0 / CONE_EXPONENT);
    if response < 0.0 { -x } else { x }
}

/// Appearance of the light at the cones, in every component above 0.
///
/// The opponent colours are sums of differences, which a grey leaves at zero.
#[inline(always)]
fn appearance(cones: Vec3) -> Appearance {
    let (long, middle, short) = (response(cones.x), response(cones.y), response(cones.z));
    let a = OPPONENT_SCALE * ((long - middle) - (middle - short) * (1.0 / 11.0));
    let b = OPPONENT_SCALE * ((long - short) + (middle - short)) * (1.0 / 9.0);
    let m = safe_sqrt(a * a + b * b);
    Appearance {
        response: (2.0 * long + middle + 0.05 * short) * (1.0 / 3.05),
        m,
        direction: Vec2::new(a, b) * (1.0 / max(m, 1e-12)),
    }
}

/// Lightness `J` of an achromatic response.
#[inline(always)]
fn lightness(response: f32) -> f32 {
    LIMIT_J * pow((1.0 + HALF_RESPONSE) * response, LIGHTNESS_EXPONENT)
}

/// The light of a display, white being 1, of a scene's `y > 0`: `f² / (f + 0.04)` with `f = m (y / (y + s))^1.15`.
#[inline(always)]
fn tone_curve(y: f32) -> f32 {
    let f = CURVE_LIMIT * pow(y / (y + CURVE_MIDDLE), CONTRAST);
    f * f / (f + TOE)
}

/// The colourfulness that counts as 1 at a hue, so that all hues are compressed alike: a Fourier series of three terms.
#[inline(always)]
fn m_norm(direction: Vec2) -> f32 {
    /// `(0.03379 · 100)^0.30596 - 0.45135`, for a display of 100 cd/m².
    const SCALE: f32 = 1.000_053;
    let (cos1, sin1) = (direction.x, direction.y);
    let (cos2, sin2) = (2.0 * cos1 * cos1 - 1.0, 2.0 * cos1 * sin1);
    let (cos3, sin3) = ((2.0 * cos2 - 1.0) * cos1, (2.0 * cos2 + 1.0) * sin1);
    let cosines = 11.34072 * cos1 + 16.46899 * cos2 + 7.88380 * cos3;
    let sines = 14.66441 * sin1 - 6.37224 * sin2 + 9.19364 * sin3;
    SCALE * (cosines + sines + 77.12896)
}

/// The colourfulness that a display of any gamut has at lightness `j`; `m` has followed the curve already.
///
/// The reach of AP1 limits it. Two toes are bent beneath that limit: from above, by which what is near it gains, and
/// from below, by which the pale lose, the more the brighter they are.
#[inline(always)]
fn compressed_m(j: f32, m: f32, response: f32, direction: Vec2, reach_m: f32) -> f32 {
    const EXPANSION: f32 = 1.3;
    const EXPANSION_FLOOR: f32 = 0.005;
    const COMPRESSION: f32 = 2.4;
    /// Below this colours are grey enough to stay.
    const UNTOUCHED: f32 = 0.001;
    let norm = m_norm(direction);
    let (bright, dark) = (j / LIMIT_J, max(1.0 - j / LIMIT_J, 0.0));
    let limit = (1.0 + HALF_RESPONSE) * response * reach_m / norm;
    let floor = safe_sqrt(bright * bright + EXPANSION_FLOOR);
    let expanded = limit - toe(limit - m / norm, limit - UNTOUCHED, dark * EXPANSION, floor);
    toe(expanded, limit, bright * COMPRESSION, dark) * norm
}

/// A curve from 0 to `limit`, where it meets the straight line `y = x` that goes on from there.
///
/// `y` is the positive root of `y² - (k₃ x - k₁) y - k₂ k₃ x`, in the form that does not cancel.
#[inline(always)]
fn toe(x: f32, limit: f32, bend: f32, k2: f32) -> f32 {
    let k2 = max(k2, 0.001);
    let k1 = safe_sqrt(bend * bend + k2 * k2);
    let k3 = (limit + k1) / (limit + k2);
    let (linear, constant) = (k3 * x - k1, k2 * k3 * x);
    let root = 0.5 * (abs(linear) + safe_sqrt(linear * linear + 4.0 * constant));
    let curved = if linear < 0.0 { constant / root } else { root };
    if x > limit { x } else { curved }
}

/// The gamut of a display at a hue.
#[derive(Clone, Copy, Debug)]
pub struct Hull {
    /// Lightness of the cusp, the most colourful that the display can show.
    pub cusp_j: f32,
    /// Colourfulness of the cusp.
    pub cusp_m: f32,
    /// Exponent of the hull above the cusp.
    pub upper_exponent: f32,
    /// Colourfulness of AP1 at the lightness of the display's white.
    pub reach_m: f32,
}

/// The gamut at a hue in degrees, from 0 to 360, linearly between the rows of the tables.
#[inline(always)]
fn hull(tables: &[Vec4], first: u32, hue: f32) -> Hull {
    /// The number before 360.
    const LAST_HUE: f32 = 359.999_97;
    let hue = min(hue, LAST_HUE);
    let degree = floor(hue);
    let row = fetch(tables, (first + degree as u32) as usize);
    let mut knot = first + row.z as u32;
    let mut step = 0;
    while step < KNOTS_IN_A_DEGREE {
        knot += (hue >= fetch(tables, (knot + 1) as usize).w) as u32;
        step += 1;
    }
    let (low, high) = (fetch(tables, knot as usize), fetch(tables, (knot + 1) as usize));
    let cusp = low + (high - low) * ((hue - low.w) / (high.w - low.w));
    let reach_m = row.x + (row.y - row.x) * (hue - degree);
    Hull { cusp_j: cusp.x, cusp_m: cusp.y, upper_exponent: cusp.z, reach_m }
}

/// A line of lightness over colourfulness along which colours move into a gamut, towards a focus of negative
/// colourfulness.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Lightness where it meets the axis of greys.
    pub axis: f32,
    /// Lightness per colourfulness.
    pub slope: f32,
    /// Lightness at which the line of this focus through the cusp meets the axis.
    pub cusp_axis: f32,
}

/// The line through a colour, below [`LIMIT_J`].
#[inline(always)]
pub fn line_through(j: f32, m: f32, hull: &Hull) -> Line {
    let (cusp_j, focus_j) = (hull.cusp_j, focus_lightness(hull.cusp_j));
    let gain = focus_gain(j, cusp_j);
    let axis = axis_lightness(j, m, focus_j, gain);
    let steepness = if axis < focus_j { axis } else { LIMIT_J - axis };
    let slope = steepness * (axis - focus_j) / (focus_j * gain);
    Line { axis, slope, cusp_axis: axis_lightness(cusp_j, hull.cusp_m, focus_j, gain) }
}

/// The lightness at which a line is level: between the cusp and middle grey.
#[inline(always)]
fn focus_lightness(cusp_j: f32) -> f32 {
    cusp_j + (MIDDLE_J - cusp_j) * min(1.0, 1.3 - cusp_j / LIMIT_J)
}

/// Distance of the focus from the axis (units of `J`). Near white it grows, so that lines become level.
#[inline(always)]
fn focus_gain(j: f32, cusp_j: f32) -> f32 {
    /// The least distance from white.
    const NEAREST: f32 = 1e-4;
    let gain = LIMIT_J * FOCUS_DISTANCE;
    let threshold = cusp_j + (LIMIT_J - cusp_j) * FOCUS_BLEND;
    let decades = ln((LIMIT_J - threshold) / max(LIMIT_J - j, NEAREST)) * core::f32::consts::LOG10_E;
    if j > threshold { gain * (decades * decades + 1.0) } else { gain }
}

/// Lightness at which the line through a colour meets the axis of greys: the root of a quadratic equation, as the slope
/// of a line depends on it.
#[inline(always)]
fn axis_lightness(j: f32, m: f32, focus_j: f32, gain: f32) -> f32 {
    let scaled = m / gain;
    let a = scaled / focus_j;
    let below = {
        let b = 1.0 - scaled;
        2.0 * j / (b + safe_sqrt(b * b + 4.0 * a * j))
    };
    let above = {
        let b = 1.0 + scaled + LIMIT_J * a;
        let c = LIMIT_J * scaled + j;
        2.0 * c / (b + safe_sqrt(b * b - 4.0 * a * c))
    };
    if j < focus_j { below } else { above }
}

/// Colourfulness at which a line leaves the hull `J = cusp_j (M / cusp_m)^(1 / exponent)`.
///
/// The hull is straightened: the line is moved so that it meets the axis where the curve would have it.
#[inline(always)]
fn m_at_curve(line: &Line, exponent: f32, cusp_j: f32, cusp_m: f32) -> f32 {
    let moved = line.cusp_axis * pow(line.axis / line.cusp_axis, exponent);
    moved * cusp_m / (cusp_j - line.slope * cusp_m)
}

/// Colourfulness at which a line leaves the gamut: the smaller of that below the cusp and that above it, rounded where
/// they are nearly the same.
///
/// The hull above the cusp is that below it, upside down.
#[inline(always)]
pub fn m_at_hull(line: &Line, hull: &Hull) -> f32 {
    let below = m_at_curve(line, LOWER_EXPONENT, hull.cusp_j, hull.cusp_m);
    let turned = Line { axis: LIMIT_J - line.axis, slope: -line.slope, cusp_axis: LIMIT_J - line.cusp_axis };
    let above = m_at_curve(&turned, hull.upper_exponent, LIMIT_J - hull.cusp_j, hull.cusp_m);
    let width = CUSP_ROUNDING * hull.cusp_m;
    let nearness = max(width - abs(below - above), 0.0) / width;
    min(below, above) - nearness * nearness * nearness * width * (1.0 / 6.0)
}

/// Lightness and colourfulness within the gamut. A lightness above the display's white has no colour.
#[inline(always)]
fn into_gamut(j: f32, m: f32, hull: &Hull) -> Vec2 {
    let line = line_through(j, m, hull);
    let limit = m_at_hull(&line, hull);
    let reach_line = Line { cusp_axis: LIMIT_J, ..line };
    let reach = m_at_curve(&reach_line, 1.0 / LIGHTNESS_EXPONENT, LIMIT_J, hull.reach_m);
    let moved = within_hull(m, limit, reach);
    let has_colour = (j <= LIMIT_J) & (limit > 0.0);
    if has_colour { Vec2::new(line.axis + moved * line.slope, moved) } else { Vec2::new(j, 0.0) }
}

/// Colourfulness along a line, brought from `[0, reach]` into `[0, limit]`: the same up to a threshold, then a
/// hyperbola.
#[inline(always)]
fn within_hull(m: f32, limit: f32, reach: f32) -> f32 {
    let part = max(limit / reach, KEPT_PART);
    let threshold = part * limit;
    let excess = m - threshold;
    let scale = (reach - threshold) * (limit - threshold) / (reach - limit);
    let stays = (m <= threshold) | (part >= 1.0);
    if stays { m } else { threshold + scale * excess / (scale + excess) }
}

/// Linear light of a display of a lightness and colourfulness, and of a hue's cosine and sine: the model backwards,
/// limited to `[0, 1]`.
#[inline(always)]
fn display(jm: Vec2, direction: Vec2, variant: u32) -> Vec3 {
    const DENOMINATOR: f32 = 1.0 / (1403.0 * OPPONENT_SCALE);
    let response = pow(jm.x / LIMIT_J, 1.0 / LIGHTNESS_EXPONENT) / (1.0 + HALF_RESPONSE);
    let (a, b) = (jm.y * direction.x * DENOMINATOR, jm.y * direction.y * DENOMINATOR);
    let cones = Vec3::new(
        light(response + (451.0 * a + 288.0 * b)),
        light(response - (891.0 * a + 261.0 * b)),
        light(response - (220.0 * a + 6300.0 * b)),
    );
    if variant & variant::REC2020 != 0 {
        within_display(DISPLAY_P3_TO_REC2020 * within_display(CONES_TO_DISPLAY_P3 * cones))
    } else if variant & variant::DISPLAY_P3 != 0 {
        within_display(CONES_TO_DISPLAY_P3 * cones)
    } else {
        within_display(CONES_TO_REC709 * cones)
    }
}

/// Linear RGB limited to `[0, 1]`.
#[inline(always)]
fn within_display(rgb: Vec3) -> Vec3 {
    Vec3::new(clamp(rgb.x, 0.0, 1.0), clamp(rgb.y, 0.0, 1.0), clamp(rgb.z, 0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_the_inverse_of_response() {
        for i in -30..=10 {
            let x = (i as f32).exp2();
            assert!((light(response(x)) / x - 1.0).abs() < 4e-6, "{x}");
            assert_eq!(light(-response(x)), -light(response(x)));
        }
    }

    #[test]
    fn what_a_display_shows_looks_as_it_was_meant() {
        let white = 1.0 / (1.0 + HALF_RESPONSE);
        for i in 0..36 {
            let hue = (10.0 * i as f64).to_radians();
            let direction = Vec2::new(hue.cos() as f32, hue.sin() as f32);
            // Pale enough for every hue.
            let rgb = display(Vec2::new(60.0, 10.0), direction, 0);
            let seen = appearance(CONES_TO_REC709.inverse() * rgb);
            assert!((lightness(seen.response) - 60.0).abs() < 1e-3 && (seen.m - 10.0).abs() < 1e-2, "{i}");
            assert!((seen.direction - direction).length() < 1e-3, "{i}");
        }
        assert!((lightness(white) - LIMIT_J).abs() < 1e-4);
    }

    /// Every light that a display can show reaches every cone, so that the responses need no sign.
    #[test]
    fn no_matrix_towards_the_cones_has_a_negative_entry() {
        for matrix in [REC709_TO_AP1, DISPLAY_P3_TO_AP1, REC2020_TO_AP1, AP1_TO_CONES] {
            assert!(matrix.to_cols_array().into_iter().all(|entry| entry > 0.0));
            assert!((matrix * Vec3::ONE - Vec3::ONE).abs().max_element() < 2e-7);
        }
    }
}
