//! Tables of the output transform of ACES 2.0: the reach of AP1 and the gamut of the display, by hue.
//!
//! The algorithm is that of the Academy's *ACES 2.0 Output Transform* (`Lib.Academy.OutputTransform.ctl`,
//! <https://github.com/ampas/aces-core>) as OpenColorIO runs it (`ops/fixedfunction/ACES2/Transform.cpp`,
//! <https://github.com/AcademySoftwareFoundation/OpenColorIO>). Its tolerances belong to the result and are kept; the
//! model of appearance is in double precision. [`sorairo_shared::display::aces`] says what the rows hold.

use std::sync::OnceLock;

use sorairo_shared::display::aces::{
    CONE_EXPONENT, CUSP_ROUNDING, DEGREES, HALF_RESPONSE, Hull, KNOTS, LIGHTNESS_EXPONENT, LIMIT_J, OPPONENT_SCALE,
    ROWS, line_through, m_at_hull,
};
use sorairo_shared::glam::{DMat3, DVec2, DVec3, Vec4};

use crate::plan::picture::colour_space::{Chromaticities, chromaticities, rgb_to_xyz};
use crate::scene::{Display, Rgb};

/// A turn of hue in degrees.
const TURN: f64 = 360.0;

/// The rows that [`sorairo_shared::display::aces::aces2`] reads for a display.
pub fn tables(display: Display) -> &'static [Vec4] {
    static REC709: OnceLock<Vec<Vec4>> = OnceLock::new();
    static P3: OnceLock<Vec<Vec4>> = OnceLock::new();
    match display {
        Display::Srgb => REC709.get_or_init(|| computed(Rgb::Srgb)),
        Display::DisplayP3 | Display::Rec2020 | Display::Rec2100Pq => P3.get_or_init(|| computed(Rgb::DisplayP3)),
    }
}

fn computed(limit: Rgb) -> Vec<Vec4> {
    let (display, widest) = (Gamut::new(&chromaticities(limit)), Gamut::new(&chromaticities(Rgb::AcesCg)));
    let cusps = Cusps::new(&display);
    let hues = hue_knots(&sorted_hues(&cusps, &widest));
    let mut knots: Vec<Vec4> = hues.iter().map(|&hue| knot(hue, &cusps)).collect();
    knots.push(knots[0].with_w(TURN as f32));
    let mut rows = degree_rows(&widest, &knots);
    rows.extend(knots);
    debug_assert_eq!(rows.len(), ROWS);
    rows
}

/// The cones' fundamentals of CAM16 as a space of RGB: the matrix of Li et al. (2017), by the chromaticities that ACES
/// rounds it to.
const CONES: Chromaticities = Chromaticities {
    red: DVec2::new(0.8336, 0.1735),
    green: DVec2::new(2.3854, -1.4659),
    blue: DVec2::new(0.087, -0.125),
    white: DVec2::splat(0.333),
};

/// The matrix from linear RGB to the cones, whose response to the space's white is 1.
fn to_cones(space: &Chromaticities) -> DMat3 {
    let cones = rgb_to_xyz(&CONES).inverse() * rgb_to_xyz(space);
    DMat3::from_diagonal((cones * DVec3::ONE).recip()) * cones
}

/// A colour as the model of appearance has it.
#[derive(Clone, Copy, Debug)]
struct Correlates {
    /// Lightness.
    j: f64,
    /// Colourfulness.
    m: f64,
    /// Hue in degrees, from 0 to below 360.
    hue: f64,
}

/// A space of linear RGB under the model of appearance; see [`sorairo_shared::display::aces`].
struct Gamut {
    to_cones: DMat3,
    from_cones: DMat3,
}

impl Gamut {
    fn new(space: &Chromaticities) -> Self {
        let to_cones = to_cones(space);
        Self { to_cones, from_cones: to_cones.inverse() }
    }

    /// How linear RGB appears.
    fn correlates(&self, rgb: DVec3) -> Correlates {
        let DVec3 { x: long, y: middle, z: short } = self.to_cones * rgb;
        let [long, middle, short] = [long, middle, short].map(response);
        let a = long - middle * (12.0 / 11.0) + short / 11.0;
        let b = (long + middle - 2.0 * short) / 9.0;
        Correlates {
            j: lightness((2.0 * long + middle + 0.05 * short) / 3.05),
            m: f64::from(OPPONENT_SCALE) * a.hypot(b),
            hue: b.atan2(a).to_degrees().rem_euclid(TURN),
        }
    }

    /// The linear RGB that appears so.
    fn rgb(&self, seen: &Correlates) -> DVec3 {
        let achromatic = (seen.j / f64::from(LIMIT_J)).powf(f64::from(LIGHTNESS_EXPONENT).recip())
            / (1.0 + f64::from(HALF_RESPONSE));
        let (sine, cosine) = seen.hue.to_radians().sin_cos();
        let (a, b) = (seen.m * cosine / f64::from(OPPONENT_SCALE), seen.m * sine / f64::from(OPPONENT_SCALE));
        let differences = DVec3::new(451.0 * a + 288.0 * b, -891.0 * a - 261.0 * b, -220.0 * a - 6300.0 * b) / 1403.0;
        self.from_cones * DVec3::from_array((achromatic + differences).to_array().map(light))
    }
}

/// A cone's response to light, with its sign.
fn response(x: f64) -> f64 {
    let power = x.abs().powf(f64::from(CONE_EXPONENT));
    (power / (f64::from(HALF_RESPONSE) + power)).copysign(x)
}

/// The light of a cone's response, with its sign.
fn light(response: f64) -> f64 {
    let r = response.abs().min(0.99);
    (f64::from(HALF_RESPONSE) * r / (1.0 - r)).powf(f64::from(CONE_EXPONENT).recip()).copysign(response)
}

/// Lightness of an achromatic response.
fn lightness(response: f64) -> f64 {
    f64::from(LIMIT_J) * ((1.0 + f64::from(HALF_RESPONSE)) * response).powf(f64::from(LIGHTNESS_EXPONENT))
}

/// The corners of a cube of RGB between black and white, as their hues go round: red, yellow, green, cyan, blue,
/// magenta.
const CORNERS: [DVec3; 6] =
    [DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y, DVec3::new(0.0, 1.0, 1.0), DVec3::Z, DVec3::new(1.0, 0.0, 1.0)];

/// The interval, no longer than a tolerance, to which bisection narrows one at whose upper end alone a condition holds.
fn bisected([mut low, mut high]: [f64; 2], tolerance: f64, holds: impl Fn(f64) -> bool) -> [f64; 2] {
    while high - low > tolerance {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    [low, high]
}

/// The first interval of a scale of equal steps from 0 at whose upper end a condition holds, or the one that reaches
/// `end`.
fn first_step(step: f64, end: f64, holds: impl Fn(f64) -> bool) -> [f64; 2] {
    let mut high = step;
    while high < end && !holds(high) {
        high += step;
    }
    [high - step, high]
}

/// Hue of a corner of AP1 made so bright that its lightness is the limit, which depends a little on brightness.
fn reach_corner_hue(widest: &Gamut, corner: DVec3) -> f64 {
    const BRIGHTEST: f64 = 1024.0;
    const TOLERANCE: f64 = 1e-3;
    let is_light = |scale: f64| widest.correlates(scale * corner).j >= f64::from(LIMIT_J);
    let [_, scale] = bisected([0.0, BRIGHTEST], TOLERANCE, is_light);
    widest.correlates(scale * corner).hue
}

/// The most colourful that a display can show at each hue: the edges of its cube between the [`CORNERS`].
struct Cusps<'a> {
    display: &'a Gamut,
    corner_hues: [f64; 6],
}

impl<'a> Cusps<'a> {
    fn new(display: &'a Gamut) -> Self {
        Self { display, corner_hues: CORNERS.map(|corner| display.correlates(corner).hue) }
    }

    /// The cusp at a hue, by bisection along the edge on which it lies.
    fn at(&self, hue: f64) -> Correlates {
        const TOLERANCE: f64 = 1e-7;
        let beyond = |i: usize, hue: f64| (hue - self.corner_hues[i]).rem_euclid(TURN);
        let edge = (0..6).find(|&i| beyond(i, hue) < beyond(i, self.corner_hues[(i + 1) % 6])).unwrap_or(0);
        let (from, to) = (CORNERS[edge], CORNERS[(edge + 1) % 6]);
        let sample = |t: f64| self.display.correlates(from.lerp(to, t));
        let [low, high] = bisected([0.0, 1.0], TOLERANCE, |t| beyond(edge, sample(t).hue) > beyond(edge, hue));
        sample(0.5 * (low + high))
    }
}

/// The hues of the corners of the display and of AP1, at which nothing may be interpolated, increasing.
fn sorted_hues(cusps: &Cusps<'_>, widest: &Gamut) -> Vec<f64> {
    let mut hues = cusps.corner_hues.to_vec();
    hues.extend(CORNERS.map(|corner| reach_corner_hue(widest, corner)));
    hues.sort_by(f64::total_cmp);
    hues.dedup();
    hues
}

/// Hues of the [`KNOTS`] but the last, as even as they can be: every corner's hue is one of them, and 0.
fn hue_knots(corners: &[f64]) -> Vec<f64> {
    let places = knot_places(corners);
    let starts = std::iter::once(0.0).chain(corners.iter().copied());
    let ends = corners.iter().copied().chain(std::iter::once(TURN));
    let first = std::iter::once(0).chain(places.iter().copied());
    let last = places.iter().copied().chain(std::iter::once(KNOTS - 1));
    let intervals = starts.zip(ends).zip(first.zip(last));
    intervals.flat_map(|((low, high), (first, last))| evenly(low, high, last.saturating_sub(first))).collect()
}

/// Hues from `low` to below `high`.
fn evenly(low: f64, high: f64, count: usize) -> impl Iterator<Item = f64> {
    let step = (high - low) / count as f64;
    (0..count).map(move |i| low + i as f64 * step)
}

/// Which knots are the corners: the nearest, and where two would be the same, the one before or after it.
fn knot_places(corners: &[f64]) -> Vec<usize> {
    let last = KNOTS - 2;
    let mut places: Vec<usize> = Vec::new();
    for (i, &hue) in corners.iter().enumerate() {
        let lowest = places.last().copied().unwrap_or(usize::from(corners[0] != 0.0));
        let mut place = (hue.round() as usize).max(lowest).min(last);
        match places[..] {
            [.., before, same] if same == place && before + 1 != same => places[i - 1] = same - 1,
            [.., same] if same == place => place += 1,
            _ => {}
        }
        places.push(place.min(last));
    }
    places
}

/// The row of a knot.
fn knot(hue: f64, cusps: &Cusps<'_>) -> Vec4 {
    /// The part of its rounding by which the cusp is moved out, so that the rounded hull touches the display's.
    const MOVED_OUT: f32 = 0.27;
    let cusp = cusps.at(hue);
    let widened = cusp.m as f32 * (1.0 + MOVED_OUT * CUSP_ROUNDING);
    let hull = Hull { cusp_j: cusp.j as f32, cusp_m: widened, upper_exponent: 1.0, reach_m: 0.0 };
    Vec4::new(hull.cusp_j, hull.cusp_m, upper_exponent(cusps.display, hue, &hull), hue as f32)
}

/// Exponent of the hull above the cusp: that of the smallest hull which encloses the display along five lines.
fn upper_exponent(display: &Gamut, hue: f64, hull: &Hull) -> f32 {
    const STEP: f64 = 0.4;
    const LARGEST: f64 = 5.0;
    const TOLERANCE: f64 = 1e-5;
    let holds = |gamma: f64| {
        let hull = Hull { upper_exponent: (1.0 / gamma) as f32, ..*hull };
        [0.01, 0.1, 0.5, 0.8, 0.99].into_iter().all(|part| is_outside(display, hue, &hull, part))
    };
    let [_, gamma] = bisected(first_step(STEP, LARGEST, holds), TOLERANCE, holds);
    (1.0 / gamma) as f32
}

/// Whether the hull, where the line through the point `part` of the way from the cusp's lightness to white leaves it,
/// is brighter than the display.
fn is_outside(display: &Gamut, hue: f64, hull: &Hull, part: f32) -> bool {
    let line = line_through(hull.cusp_j + (LIMIT_J - hull.cusp_j) * part, hull.cusp_m, hull);
    let m = m_at_hull(&line, hull);
    let seen = Correlates { j: f64::from(line.axis + line.slope * m), m: f64::from(m), hue };
    display.rgb(&seen).max_element() > 1.0
}

/// The rows of whole degrees.
fn degree_rows(widest: &Gamut, knots: &[Vec4]) -> Vec<Vec4> {
    let reach: Vec<f32> = (0..DEGREES).map(|degree| reach_m(widest, degree as f64) as f32).collect();
    let row = |degree: usize| {
        let above = knots.partition_point(|knot| knot.w <= degree as f32);
        let knot = (DEGREES + above - 1) as f32;
        Vec4::new(reach[degree], reach[(degree + 1) % DEGREES], knot, 0.0)
    };
    (0..DEGREES).map(row).collect()
}

/// Colourfulness of AP1 at the limit of lightness: where one of its components is below 0.
fn reach_m(widest: &Gamut, hue: f64) -> f64 {
    const STEP: f64 = 50.0;
    const LARGEST: f64 = 1300.0;
    const TOLERANCE: f64 = 1e-2;
    let is_outside = |m: f64| widest.rgb(&Correlates { j: f64::from(LIMIT_J), m, hue }).min_element() < 0.0;
    bisected(first_step(STEP, LARGEST, is_outside), TOLERANCE, is_outside)[1]
}

#[cfg(test)]
mod tests {
    use sorairo_shared::display::aces::{
        AP1_TO_CONES, CONES_TO_DISPLAY_P3, CONES_TO_REC709, CONTRAST, CURVE_LIMIT, CURVE_MIDDLE, DISPLAY_P3_TO_AP1,
        DISPLAY_P3_TO_REC2020, KNOTS_IN_A_DEGREE, MIDDLE_J, REC709_TO_AP1, REC2020_TO_AP1, TOE, aces2,
    };
    use sorairo_shared::glam::{Mat3, Vec3};

    use super::*;
    use crate::plan::picture::colour_space::adaptation;
    use crate::plan::upload;
    use crate::rows::{Row, rows};

    /// Encoded by the transfer function of sRGB, in steps of a byte (IEC 61966-2-1:1999).
    fn steps(linear: f32) -> f64 {
        let x = f64::from(linear);
        255.0 * if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
    }

    const DISPLAYS: [Display; 3] = [Display::Srgb, Display::DisplayP3, Display::Rec2020];

    /// Colours of a scene, and what OpenColorIO makes of them for a display.
    fn reference(display: Display) -> Vec<[Vec3; 2]> {
        let text = match display {
            Display::Srgb => include_str!("aces_reference.csv"),
            Display::DisplayP3 => include_str!("aces_reference_p3.csv"),
            Display::Rec2020 | Display::Rec2100Pq => include_str!("aces_reference_rec2020.csv"),
        };
        let of_row = |row: std::result::Result<Row, String>| {
            let cells = row.expect("a row").cells;
            let numbers: Vec<f32> = cells.iter().map(|cell| cell.parse().expect("a number")).collect();
            [Vec3::from_slice(&numbers), Vec3::from_slice(&numbers[3..])]
        };
        rows(text).skip(1).map(of_row).collect()
    }

    fn shown(rgb: Vec3) -> Vec3 {
        shown_on(Display::Srgb, rgb)
    }

    fn shown_on(display: Display, rgb: Vec3) -> Vec3 {
        aces2(rgb, tables(display), 0, upload::display(display))
    }

    #[test]
    fn colours_are_those_of_opencolorio() {
        for (display, most) in DISPLAYS.into_iter().zip([200, 100, 100]) {
            let reference = reference(display);
            assert!(reference.len() > most);
            reference.into_iter().for_each(|colours| assert_that_it_is_shown(display, colours));
        }
    }

    fn assert_that_it_is_shown(display: Display, [scene, expected]: [Vec3; 2]) {
        let shown = shown_on(display, scene);
        let difference = (0..3).map(|i| (steps(shown[i]) - steps(expected[i])).abs()).fold(0.0, f64::max);
        // Both round in single precision: of 300 000 colours at random the worst differs by 0.0075, a bright yellow
        // near the edge of the gamut.
        assert!(difference < 0.01, "{display:?}, {scene}: {shown} and not {expected}");
    }

    #[test]
    fn a_brighter_light_never_looks_darker() {
        let luminance = Vec3::new(0.2126, 0.7152, 0.0722);
        for i in 1..512 {
            let colour = Vec3::new((i % 8) as f32, (i / 8 % 8) as f32, (i / 64) as f32) / 7.0;
            let mut last = 0.0;
            for exposure in -112..=112 {
                let now = luminance.dot(shown(colour * (exposure as f32 * 0.125).exp2()));
                // A few roundings of 1: at white, steps of an eighth of a stop are no greater.
                assert!(now > last - 1e-6, "{colour} at {exposure}/8 stops: {now} after {last}");
                last = now;
            }
        }
    }

    #[test]
    fn every_light_has_a_colour() {
        let lights = [0.0, 1e-30, 1e-9, 0.18, 100.0, 1e30];
        for i in 0..216 {
            let scene = Vec3::new(lights[i % 6], lights[i / 6 % 6], lights[i / 36]);
            let shown = shown(scene);
            assert!(shown.cmpge(Vec3::ZERO).all() && shown.cmple(Vec3::ONE).all(), "{scene}: {shown}");
        }
        assert!(shown(Vec3::ZERO).max_element() < 1e-12);
        assert!(shown(Vec3::splat(1e30)).min_element() > 0.999_99);
    }

    #[test]
    fn a_grey_stays_grey_and_follows_the_curve() {
        for i in -100..=100 {
            let grey = (f64::from(i) * 0.1).exp2();
            let shown = shown(Vec3::splat(grey as f32));
            let f = f64::from(CURVE_LIMIT) * (grey / (grey + f64::from(CURVE_MIDDLE))).powf(f64::from(CONTRAST));
            let truth = (f * f / (f + f64::from(TOE))).min(1.0);
            // The matrices round a grey, and the power 1/0.42 of a response has that more than twice.
            assert!(
                (shown.as_dvec3() / truth - DVec3::ONE).abs().max_element() < 1e-5,
                "{grey}: {shown} and not {truth}"
            );
        }
    }

    #[test]
    fn the_knots_are_sorted_and_no_degree_has_more_than_the_kernels_look_for() {
        DISPLAYS.into_iter().for_each(|display| assert_knots(tables(display)));
    }

    fn assert_knots(rows: &[Vec4]) {
        assert_eq!(rows.len(), ROWS);
        let knots = &rows[DEGREES..];
        assert!(knots.windows(2).all(|pair| pair[0].w < pair[1].w));
        assert_eq!((knots[0].w, knots[KNOTS - 1].w), (0.0, 360.0));
        for degree in 0..DEGREES {
            let from = rows[degree].z as usize;
            assert!(rows[from].w <= degree as f32 && rows[from + 1].w > degree as f32, "{degree}");
            let within = rows[from + 1..].iter().take_while(|knot| knot.w < degree as f32 + 1.0).count();
            assert!(within <= KNOTS_IN_A_DEGREE as usize, "{degree}: {within}");
        }
    }

    /// The curve of lightness from what the Academy chose: 0.18 becomes 10.013 cd/m², and 128 the white.
    #[test]
    fn the_curve_is_that_of_the_academy() {
        const BRIGHTEST: f64 = 128.0;
        let (contrast, toe) = (f64::from(CONTRAST), f64::from(TOE));
        let before_toe = |y: f64| 0.5 * (y + (y * (y + 4.0 * toe)).sqrt());
        let (grey, white) = (before_toe(0.10013), before_toe(1.0));
        let part = (grey / white).powf(1.0 / contrast) * BRIGHTEST / (BRIGHTEST + white);
        let middle = 0.18 / part - 0.18;
        let limit = white * (1.0 + middle / BRIGHTEST).powf(contrast);
        assert!((f64::from(CURVE_MIDDLE) - middle).abs() < 1e-6, "{middle}");
        assert!((f64::from(CURVE_LIMIT) - limit).abs() < 1e-6, "{limit}");
        assert!((f64::from(MIDDLE_J) - lightness(response(0.10013))).abs() < 1e-5);
    }

    /// CAM16 with an adapting luminance of 100 cd/m², a background of a fifth and a dim surround, `c` = 0.59.
    #[test]
    fn the_constants_of_the_kernels_are_those_of_the_model() {
        let near = |a: Mat3, b: DMat3| assert!(a.as_dmat3().abs_diff_eq(b, 3e-7), "{a} and not {b}");
        let [rec709, p3, rec2020, ap1] = [Rgb::Srgb, Rgb::DisplayP3, Rgb::Rec2020, Rgb::AcesCg].map(chromaticities);
        let to = rgb_to_xyz(&ap1);
        for (matrix, space) in [(REC709_TO_AP1, &rec709), (DISPLAY_P3_TO_AP1, &p3), (REC2020_TO_AP1, &rec2020)] {
            let from = rgb_to_xyz(space);
            near(matrix, to.inverse() * adaptation(from * DVec3::ONE, to * DVec3::ONE) * from);
        }
        near(AP1_TO_CONES, to_cones(&ap1));
        near(CONES_TO_REC709, to_cones(&rec709).inverse());
        near(CONES_TO_DISPLAY_P3, to_cones(&p3).inverse());
        near(DISPLAY_P3_TO_REC2020, rgb_to_xyz(&rec2020).inverse() * rgb_to_xyz(&p3));
        let k4 = (5.0 * 100.0 + 1.0f64).recip().powi(4);
        let adaptation = 0.2 * k4 * 500.0 + 0.1 * (1.0 - k4).powi(2) * 500.0f64.cbrt();
        assert!((f64::from(HALF_RESPONSE) - 27.13 * adaptation.powf(-0.42)).abs() < 2e-6);
        assert!((f64::from(LIGHTNESS_EXPONENT) - 0.59 * (1.48 + 0.2f64.sqrt())).abs() < 1e-7);
    }
}
