//! What half floats do not hold of an image.

use std::ops::Add;

use rayon::prelude::*;
use sorairo_shared::math::max;

use crate::error::Error;
use crate::plan::picture::exposure::LARGEST_HALF;
use crate::scene::MOST_STOPS;

/// The smallest number of which half floats keep all of their digits (2⁻¹⁴).
const SMALLEST_HALF: f32 = 6.103_515_6e-5;

/// Half of the step to what would be the next half float: up to here rounding leads to the largest.
const ROUNDED_DOWN: f32 = 65_520.0;

/// Half of the smallest half float, which becomes 0.
const ROUNDED_TO_ZERO: f32 = 2.980_232_2e-8;

/// What half floats do not hold of some values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Losses {
    /// Values above 0.
    lit: u64,
    /// Those of them with fewer digits than others.
    weak: u64,
    /// Those that become 0.
    zero: u64,
    /// The largest value, and the sum of all.
    largest: f32,
    sum: f64,
    /// What the largest half float lacks of the values above it.
    cut: f64,
}

impl Add for Losses {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            lit: self.lit + other.lit,
            weak: self.weak + other.weak,
            zero: self.zero + other.zero,
            largest: max(self.largest, other.largest),
            sum: self.sum + other.sum,
            cut: self.cut + other.cut,
        }
    }
}

impl Losses {
    /// Those of values times a factor.
    pub(crate) fn of(values: &[f32], factor: f32) -> Self {
        const MANY: usize = 1 << 14;
        values
            .par_chunks(MANY)
            .map(|values| values.iter().map(|value| Self::of_one(value * factor)).sum::<Self>())
            .sum()
    }

    fn of_one(value: f32) -> Self {
        Self {
            lit: u64::from(value > 0.0),
            weak: u64::from(value > 0.0 && value < SMALLEST_HALF),
            zero: u64::from(value > 0.0 && value <= ROUNDED_TO_ZERO),
            largest: value,
            sum: f64::from(max(value, 0.0)),
            cut: if value >= ROUNDED_DOWN { f64::from(value) - f64::from(LARGEST_HALF) } else { 0.0 },
        }
    }

    /// Refuses values, exposed by so many stops, of which light would be cut off.
    pub(crate) fn refuse_cut(&self, exposure: f32) -> Result<(), Error> {
        if self.cut == 0.0 {
            return Ok(());
        }
        let stops = (exposure - (self.largest / LARGEST_HALF).log2()).floor();
        let instead = if f64::from(stops) < -MOST_STOPS {
            "f32 holds it".into()
        } else {
            format!("render.exr_exposure = {stops} keeps it, and so does f32")
        };
        Err(Error::not_allowed(
            "render.exr",
            format!(
                "is f16, and pixels are brighter than {LARGEST_HALF}, the most that half floats hold: {} of the image's light would be lost; {instead}",
                percent(self.cut / self.sum)
            ),
        ))
    }

    /// What is said where more than a thousandth of the values have lost digits.
    pub(crate) fn weakness(&self) -> Option<String> {
        let part = |count: u64| count as f64 / self.lit.max(1) as f64;
        (part(self.weak) > 1e-3).then(|| {
            format!(
                "{} of the values that are not 0 lie below {SMALLEST_HALF:.1e}, where half floats have fewer than three digits, and {} become 0; a higher \
                 render.exr_exposure, or f32, keeps them",
                percent(part(self.weak)),
                percent(part(self.zero))
            )
        })
    }
}

impl std::iter::Sum for Losses {
    fn sum<I: Iterator<Item = Self>>(losses: I) -> Self {
        losses.fold(Self::default(), Self::add)
    }
}

/// A part as two digits of a percentage.
fn percent(part: f64) -> String {
    let percent = 100.0 * part;
    let decimals = if percent == 0.0 { 0.0 } else { (1.0 - percent.log10().floor()).max(0.0) };
    format!("{percent:.*} %", decimals as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_cut_is_told_as_a_part_of_the_light_with_the_exposure_that_keeps_it() {
        // Of 262 016 · 1.5 = 393 024, half floats hold 196 512.
        let values = [65_504.0, 131_008.0, 65_504.0, 131_008.0];
        let told = Losses::of(&values, 1.0).refuse_cut(0.0).unwrap_err().to_string();
        assert!(told.contains("33 % of the image's light") && told.contains("render.exr_exposure = -1 "), "{told}");
        let told = Losses::of(&values, 4.0).refuse_cut(2.0).unwrap_err().to_string();
        assert!(told.contains("render.exr_exposure = -1 "), "{told}");
        assert!(Losses::of(&values, 0.5).refuse_cut(-1.0).is_ok());
        assert!(Losses::of(&[65_519.0], 1.0).refuse_cut(0.0).is_ok());
    }

    #[test]
    fn digits_that_are_lost_are_told_and_black_is_not() {
        let told = Losses::of(&[0.0, 0.0, 1.0, 1e-5, 1e-9], 1.0).weakness().unwrap();
        assert!(told.starts_with("67 % of") && told.contains("and 33 % become 0"), "{told}");
        assert_eq!(Losses::of(&[0.0, 0.0, 1.0, 1e-5, 1e-9], 131_072.0).weakness(), None);
        assert_eq!(Losses::of(&[0.0; 9], 1.0).weakness(), None);
        assert_eq!(percent(0.94321), "94 %");
        assert_eq!(percent(0.001234), "0.12 %");
    }
}
