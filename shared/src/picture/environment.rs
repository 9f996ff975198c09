//! Environment maps for programs that light with them: smaller levels of an equirectangular map, and its irradiance in
//! spherical harmonics.
//!
//! The pixels of an equirectangular map stand for unequal solid angles, so a plain box filter would give the zenith too
//! much weight. Here a pixel of the next level is the mean over its part of the sphere: the rows that it covers count
//! by their solid angles. Each level then has the mean radiance of the one before, and the last, a single pixel, is
//! that mean. Levels halve as those of a texture do, rounded down; a pixel of an odd level counts to both of the pixels
//! that share it, to each with its part.
//!
//! Irradiance takes nine coefficients (Ramamoorthi and Hanrahan 2001, *An efficient representation for irradiance
//! environment maps*, <https://doi.org/10.1145/383259.383317>, Eqs. 7 and 8). A harmonic is a function of the elevation
//! times one of the azimuth, so each row is summed first against the five functions of the azimuth, then the rows
//! against the nine of the elevation. North is in the map's centre.

use bytemuck::{Pod, Zeroable};

use crate::glam::Vec4;
use crate::math::{PI, fetch, fetch_in, half_bits, sin_cos, store, store_in};

/// A level in the buffer that holds all levels of a map. The layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Level {
    /// Its first pixel in the buffer.
    pub first: u32,
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
    /// Pixels from the start of a row to that of the next: the width, or more where rows are aligned.
    pub row_pixels: u32,
}

impl Level {
    /// Where a pixel stands in the buffer.
    #[inline]
    pub fn index(&self, column: u32, row: u32) -> usize {
        (self.first + row * self.row_pixels + column) as usize
    }
}

/// From a level to the next. The layout is that of a GPU uniform buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct LevelStep {
    /// The level that is read.
    pub source: Level,
    /// The level that is written.
    pub target: Level,
}

/// Pixels of a level that one of the next covers, in a column or in a row: the first, the last, and the parts of these
/// two before and up to which nothing is covered.
#[derive(Clone, Copy)]
struct Cover {
    first: u32,
    before: f32,
    last: u32,
    up_to: f32,
}

impl Cover {
    /// Of `source` pixels, those below pixel `index` of `target`.
    #[inline]
    fn new(source: u32, target: u32, index: u32) -> Self {
        let (from, to) = (index * source, (index + 1) * source);
        let (first, end) = (from / target, to / target);
        let part = to - end * target;
        // Where the last pixel ends, the next one is not begun.
        let (last, up_to) = if part > 0 { (end, part as f32 / target as f32) } else { (end - 1, 1.0) };
        Self { first, before: (from - first * target) as f32 / target as f32, last, up_to }
    }

    /// The covered part of a pixel: where it begins and where it ends, in [0, 1].
    #[inline]
    fn part(self, pixel: u32) -> (f32, f32) {
        let begin = if pixel == self.first { self.before } else { 0.0 };
        let end = if pixel == self.last { self.up_to } else { 1.0 };
        (begin, end)
    }
}

/// Solid angle per radian of azimuth (sr) of the part from `begin` to `end` of a row of a map of this height: the
/// difference of the sines of its elevations, as a product that keeps its digits at the poles.
#[inline]
fn row_solid_angle(height: u32, row: u32, begin: f32, end: f32) -> f32 {
    let rows = height as f32;
    let middle = row as f32 + 0.5 * (begin + end);
    let from_pole = if middle > 0.5 * rows { rows - middle } else { middle };
    let (sine, _) = sin_cos(from_pole * PI / rows);
    let (half, _) = sin_cos(0.5 * (end - begin) * PI / rows);
    2.0 * sine * half
}

/// Kernel `environment_level`: the mean radiance over a pixel of the next level, with an alpha of 1.
#[inline]
pub fn level_pixel(step: &LevelStep, levels: &mut [Vec4], column: u32, row: u32) {
    let columns = Cover::new(step.source.width, step.target.width, column);
    let rows = Cover::new(step.source.height, step.target.height, row);
    let mut sum = Vec4::ZERO;
    let mut solid_angle = 0.0;
    let mut y = rows.first;
    while y <= rows.last {
        let (top, bottom) = rows.part(y);
        let of_row = row_solid_angle(step.source.height, y, top, bottom);
        let mut x = columns.first;
        while x <= columns.last {
            let (left, right) = columns.part(x);
            let weight = of_row * (right - left);
            sum += fetch(levels, step.source.index(x, y)) * weight;
            solid_angle += weight;
            x += 1;
        }
        y += 1;
    }
    let mean = sum / solid_angle;
    store(levels, step.target.index(column, row), Vec4::new(mean.x, mean.y, mean.z, 1.0));
}

/// Kernel `environment_half`: a pixel of the target level as a texel of `rgba16float`, two words.
#[inline]
pub fn half_pixel(step: &LevelStep, levels: &[Vec4], halves: &mut [u32], column: u32, row: u32) {
    let index = step.target.index(column, row);
    let pixel = fetch(levels, index);
    store(halves, 2 * index, half_bits(pixel.x) | (half_bits(pixel.y) << 16));
    store(halves, 2 * index + 1, half_bits(pixel.z) | (half_bits(pixel.w) << 16));
}

/// Invocations that share a sum. The entry points repeat it as a literal, which a test compares.
pub const LANES: u32 = 64;

/// Functions of the azimuth in harmonics up to the second degree: 1, sine and cosine, those of twice the azimuth.
pub const ROW_SUMS: u32 = 5;

/// Coefficients of the harmonics up to the second degree.
pub const COEFFICIENTS: u32 = 9;

/// Sums of all lanes over a row.
pub type RowLanes = [Vec4; (LANES * ROW_SUMS) as usize];

/// Sums of all lanes over the rows.
pub type CoefficientLanes = [Vec4; (LANES * COEFFICIENTS) as usize];

/// Kernel `environment_rows`, first half: a lane's part of a row of the source level, summed against the functions of
/// the azimuth and kept.
#[inline]
pub fn keep_row_sums(step: &LevelStep, levels: &[Vec4], row: u32, lane: u32, kept: &mut RowLanes) {
    let level = &step.source;
    let (mut all, mut sines, mut cosines) = (Vec4::ZERO, Vec4::ZERO, Vec4::ZERO);
    let (mut sines_2, mut cosines_2) = (Vec4::ZERO, Vec4::ZERO);
    let mut column = lane;
    while column < level.width {
        let radiance = fetch(levels, level.index(column, row));
        // Azimuths run clockwise, and y is west.
        let (sine, cosine) = sin_cos((0.5 - (column as f32 + 0.5) / level.width as f32) * 2.0 * PI);
        all += radiance;
        sines += radiance * sine;
        cosines += radiance * cosine;
        sines_2 += radiance * (2.0 * sine * cosine);
        cosines_2 += radiance * (cosine * cosine - sine * sine);
        column += LANES;
    }
    let at = (lane * ROW_SUMS) as usize;
    store_in(kept, at, all);
    store_in(kept, at + 1, sines);
    store_in(kept, at + 2, cosines);
    store_in(kept, at + 3, sines_2);
    store_in(kept, at + 4, cosines_2);
}

/// Kernel `environment_rows`, second half, once all lanes are kept: one of the row's sums, stored.
#[inline]
pub fn store_row_sum(kept: &RowLanes, rows: &mut [Vec4], row: u32, which: u32) {
    let mut sum = Vec4::ZERO;
    let mut lane = 0;
    while lane < LANES {
        sum += fetch_in(kept, (lane * ROW_SUMS + which) as usize);
        lane += 1;
    }
    store(rows, (row * ROW_SUMS + which) as usize, sum);
}

/// Kernel `environment_harmonics`, first half: a lane's rows, summed against the harmonics' functions of the elevation
/// and kept.
#[inline]
pub fn keep_coefficients(step: &LevelStep, rows: &[Vec4], lane: u32, kept: &mut CoefficientLanes) {
    /// √(1/4π), √(3/4π), √(15/4π), √(5/16π), √(15/16π): the harmonics' factors.
    const Y_0: f32 = 0.282_094_8;
    const Y_1: f32 = 0.488_602_5;
    const Y_2: f32 = 1.092_548_4;
    const Y_20: f32 = 0.315_391_6;
    const Y_22: f32 = 0.546_274_2;
    let level = &step.source;
    let (mut y_00, mut y_10, mut y_20) = (Vec4::ZERO, Vec4::ZERO, Vec4::ZERO);
    let (mut y_1m1, mut y_11, mut y_2m1, mut y_21) = (Vec4::ZERO, Vec4::ZERO, Vec4::ZERO, Vec4::ZERO);
    let (mut y_2m2, mut y_22) = (Vec4::ZERO, Vec4::ZERO);
    let mut row = lane;
    while row < level.height {
        // Sine of the elevation, and its cosine.
        let (z, across) = sin_cos((0.5 - (row as f32 + 0.5) / level.height as f32) * PI);
        let solid_angle = row_solid_angle(level.height, row, 0.0, 1.0) * (2.0 * PI / level.width as f32);
        let at = (row * ROW_SUMS) as usize;
        let all = fetch(rows, at) * solid_angle;
        let sines = fetch(rows, at + 1) * (solid_angle * across);
        let cosines = fetch(rows, at + 2) * (solid_angle * across);
        y_00 += all * Y_0;
        y_1m1 += sines * Y_1;
        y_10 += all * (Y_1 * z);
        y_11 += cosines * Y_1;
        // sin(2φ) = 2 sin φ cos φ has one factor 2 already.
        y_2m2 += fetch(rows, at + 3) * (solid_angle * Y_22 * across * across);
        y_2m1 += sines * (Y_2 * z);
        y_20 += all * (Y_20 * (3.0 * z * z - 1.0));
        y_21 += cosines * (Y_2 * z);
        y_22 += fetch(rows, at + 4) * (solid_angle * Y_22 * across * across);
        row += LANES;
    }
    let at = (lane * COEFFICIENTS) as usize;
    store_in(kept, at, y_00);
    store_in(kept, at + 1, y_1m1);
    store_in(kept, at + 2, y_10);
    store_in(kept, at + 3, y_11);
    store_in(kept, at + 4, y_2m2);
    store_in(kept, at + 5, y_2m1);
    store_in(kept, at + 6, y_20);
    store_in(kept, at + 7, y_21);
    store_in(kept, at + 8, y_22);
}

/// Kernel `environment_harmonics`, second half, once all lanes are kept: one coefficient of the irradiance, stored; its
/// `w` is 0. The order is `Y_00, Y_1-1, Y_10, Y_11, Y_2-2, Y_2-1, Y_20, Y_21, Y_22`; a degree has lost what a cosine
/// leaves of it (Eq. 8 of the paper named above).
#[inline]
pub fn store_coefficient(kept: &CoefficientLanes, coefficients: &mut [Vec4], which: u32) {
    let cosine = if which == 0 {
        PI
    } else if which < 4 {
        2.0 * PI / 3.0
    } else {
        0.25 * PI
    };
    let mut sum = Vec4::ZERO;
    let mut lane = 0;
    while lane < LANES {
        sum += fetch_in(kept, (lane * COEFFICIENTS + which) as usize);
        lane += 1;
    }
    store(coefficients, which as usize, Vec4::new(sum.x, sum.y, sum.z, 0.0) * cosine);
}

/// The levels of a map down to one pixel, behind each other, with rows of a multiple of `alignment` pixels.
#[cfg(not(target_arch = "spirv"))]
pub fn levels(width: u32, height: u32, alignment: u32) -> impl Iterator<Item = Level> {
    let level =
        move |first, width: u32, height| Level { first, width, height, row_pixels: width.next_multiple_of(alignment) };
    core::iter::successors(Some(level(0, width, height)), move |before| {
        let next = |side: u32| (side / 2).max(1);
        let is_last = before.width == 1 && before.height == 1;
        let first = before.first + before.row_pixels * before.height;
        (!is_last).then(|| level(first, next(before.width), next(before.height)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glam::Vec3;

    /// A map with all of its levels, its radiance by direction.
    struct Map {
        levels: Vec<Level>,
        pixels: Vec<Vec4>,
    }

    /// The direction through the centre of a pixel.
    fn direction(level: &Level, column: u32, row: u32) -> Vec3 {
        let side = |index: u32, count: u32| (f64::from(index) + 0.5) / f64::from(count);
        let azimuth = (side(column, level.width) - 0.5) * std::f64::consts::TAU;
        let elevation = (0.5 - side(row, level.height)) * std::f64::consts::PI;
        let (s, c) = elevation.sin_cos();
        Vec3::new((c * azimuth.cos()) as f32, (-c * azimuth.sin()) as f32, s as f32)
    }

    impl Map {
        fn new(width: u32, height: u32, radiance: impl Fn(Vec3) -> f32) -> Self {
            let levels: Vec<Level> = levels(width, height, 32).collect();
            let last = levels.last().unwrap();
            let mut pixels = vec![Vec4::splat(f32::NAN); (last.first + last.row_pixels) as usize];
            for row in 0..height {
                for column in 0..width {
                    let light = Vec3::splat(radiance(direction(&levels[0], column, row)));
                    pixels[levels[0].index(column, row)] = light.extend(1.0);
                }
            }
            for pair in levels.windows(2) {
                let step = LevelStep { source: pair[0], target: pair[1] };
                for row in 0..pair[1].height {
                    (0..pair[1].width).for_each(|column| level_pixel(&step, &mut pixels, column, row));
                }
            }
            Self { levels, pixels }
        }

        /// Radiance over the whole sphere of a level, divided by 4π, in double precision.
        fn mean(&self, level: &Level, solid_angle: impl Fn(&Level, u32) -> f64) -> f64 {
            let pixels = (0..level.height).flat_map(|row| (0..level.width).map(move |column| (column, row)));
            let (sum, whole) = pixels.fold((0.0, 0.0), |(sum, whole), (column, row)| {
                let weight = solid_angle(level, row);
                (sum + weight * f64::from(self.pixels[level.index(column, row)].x), whole + weight)
            });
            sum / whole
        }

        fn harmonics(&self) -> Vec<Vec4> {
            let step = LevelStep { source: self.levels[0], target: self.levels[0] };
            let mut rows = vec![Vec4::ZERO; (ROW_SUMS * step.source.height) as usize];
            for row in 0..step.source.height {
                let mut kept = [Vec4::ZERO; (LANES * ROW_SUMS) as usize];
                (0..LANES).for_each(|lane| keep_row_sums(&step, &self.pixels, row, lane, &mut kept));
                (0..ROW_SUMS).for_each(|which| store_row_sum(&kept, &mut rows, row, which));
            }
            let mut kept = [Vec4::ZERO; (LANES * COEFFICIENTS) as usize];
            (0..LANES).for_each(|lane| keep_coefficients(&step, &rows, lane, &mut kept));
            let mut coefficients = vec![Vec4::NAN; COEFFICIENTS as usize];
            (0..COEFFICIENTS).for_each(|which| store_coefficient(&kept, &mut coefficients, which));
            coefficients
        }
    }

    /// The solid angle of a row's pixel, to a factor.
    fn exact(level: &Level, row: u32) -> f64 {
        let sine = |edge: u32| ((0.5 - f64::from(edge) / f64::from(level.height)) * std::f64::consts::PI).sin();
        (sine(row) - sine(row + 1)) / f64::from(level.width)
    }

    /// As bright as a sky with a glow, and dark below.
    fn sky(direction: Vec3) -> f32 {
        let glow = direction.dot(Vec3::new(0.48, -0.64, 0.6)) - 1.0;
        if direction.z > 0.0 { 1.0 + 40.0 * crate::math::exp(30.0 * glow) } else { 0.1 }
    }

    #[test]
    fn every_level_has_the_mean_radiance_of_the_map() {
        for (width, height) in [(256, 128), (100, 50), (61, 33), (7, 1), (1, 9)] {
            let map = Map::new(width, height, sky);
            let expected = map.mean(&map.levels[0], exact);
            for level in &map.levels[1..] {
                let error = map.mean(level, exact) / expected - 1.0;
                // Single precision rounds each of at most eight levels and their weights by 1e-7.
                assert!(error.abs() < 2e-6, "{width}x{height}, {level:?}: {error:e}");
            }
            let last = map.levels.last().unwrap();
            assert_eq!((last.width, last.height), (1, 1));
            assert_eq!(map.pixels[last.index(0, 0)].w, 1.0);
        }
    }

    #[test]
    fn a_filter_that_takes_all_rows_alike_would_not_keep_it() {
        let map = Map::new(64, 32, |direction| direction.z * direction.z);
        let alike = map.mean(&map.levels[0], |_, _| 1.0);
        // The mean of sin² of the elevation is 1/3 over the sphere, and 1/2 over the rows.
        assert!((map.mean(map.levels.last().unwrap(), exact) - 1.0 / 3.0).abs() < 1e-3 && (alike - 0.5).abs() < 1e-3);
    }

    #[test]
    fn light_of_one_harmonic_has_its_coefficient_alone() {
        type Harmonic = fn(Vec3) -> f32;
        let pi = std::f64::consts::PI;
        let harmonics: [(Harmonic, f64, f64); 9] = [
            (|_| 1.0, (0.25 / pi).sqrt(), pi),
            (|v| v.y, (0.75 / pi).sqrt(), 2.0 * pi / 3.0),
            (|v| v.z, (0.75 / pi).sqrt(), 2.0 * pi / 3.0),
            (|v| v.x, (0.75 / pi).sqrt(), 2.0 * pi / 3.0),
            (|v| v.x * v.y, (3.75 / pi).sqrt(), pi / 4.0),
            (|v| v.y * v.z, (3.75 / pi).sqrt(), pi / 4.0),
            (|v| 3.0 * v.z * v.z - 1.0, (5.0 / 16.0 / pi).sqrt(), pi / 4.0),
            (|v| v.x * v.z, (3.75 / pi).sqrt(), pi / 4.0),
            (|v| v.x * v.x - v.y * v.y, (15.0 / 16.0 / pi).sqrt(), pi / 4.0),
        ];
        for (which, (of_direction, factor, cosine)) in harmonics.into_iter().enumerate() {
            let found = Map::new(256, 128, of_direction).harmonics();
            for (other, coefficient) in found.into_iter().enumerate() {
                // A harmonic's square has the integral 1, so this light has 1 / factor of it.
                let expected = if other == which { cosine / factor } else { 0.0 };
                // The middle of a row stands for the row: (π/128)² / 24 of a second derivative, which is 12 at most.
                let error = (f64::from(coefficient.x) - expected).abs();
                assert!(error < 3e-4 * pi / factor, "{which} {other}: {error:e}");
                assert_eq!(coefficient.w, 0.0);
            }
        }
    }

    #[test]
    fn halves_are_those_of_the_pixels() {
        let map = Map::new(8, 4, sky);
        let step = LevelStep { source: map.levels[0], target: map.levels[1] };
        let mut halves = vec![0; 2 * map.pixels.len()];
        half_pixel(&step, &map.pixels, &mut halves, 3, 1);
        let pixel = map.pixels[step.target.index(3, 1)];
        let at = 2 * step.target.index(3, 1);
        assert_eq!(halves[at], half_bits(pixel.x) | (half_bits(pixel.y) << 16));
        assert_eq!(halves[at + 1] >> 16, 0x3c00);
        assert_eq!(halves.iter().filter(|&&word| word != 0).count(), 2);
    }
}
