//! The cubic through four bands in single precision, in three forms, against double precision and exact rational
//! arithmetic.

use num_rational::BigRational;
use num_traits::ToPrimitive;
use rand::RngExt;
use rayon::prelude::*;
use serde::Serialize;
use sorairo_shared::fit::spectrum::{newton_coefficients, newton_value};
use sorairo_shared::glam::Vec4;

use super::outcome::{Outcome, generator};
use sorairo::low_level::spectra::measured::MEASURED_RANGE;
use sorairo::low_level::spectra::observer::normalised;
use sorairo::scene::rules::CLOSEST_BANDS;

/// How many times half a unit in the last place, times [`amplification`], the cubic may be off, relative to the largest
/// value; see [`newton_coefficients`].
pub const BOUND: f64 = 18.0 * (1.0 + 1.0 / (1 << 19) as f64);

/// Half a unit in the last place of 1 in single precision.
const HALF_ULP: f64 = 1.0 / (1 << 24) as f64;

/// Every so many cases the double precision that judges them is itself judged by exact arithmetic.
const EXACT_EVERY: u64 = 256;

/// Wavelengths at which the cubic of a case is looked at, besides its bands.
const LOOKS: usize = 12;

/// A way to put a cubic through four points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// The Vandermonde matrix of the wavelengths in nm, by Gaussian elimination with partial pivoting.
    Raw,
    /// The same of wavelengths normalised to [-1, 1].
    Normalised,
    /// Newton's form on normalised wavelengths: what the kernels do.
    Newton,
}

impl Form {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Raw, Self::Normalised, Self::Newton];

    /// The form's name in a chart.
    pub fn name(self) -> &'static str {
        match self {
            Self::Raw => "Vandermonde matrix in nm",
            Self::Normalised => "Vandermonde matrix on [-1, 1]",
            Self::Newton => "Newton on [-1, 1] (sorairo)",
        }
    }

    /// The unknown of the form's polynomial at a wavelength (nm).
    pub fn place(self, wavelength: f64) -> f32 {
        match self {
            Self::Raw => wavelength as f32,
            Self::Normalised | Self::Newton => normalised(wavelength) as f32,
        }
    }

    /// The cubic through `values` at the bands (nm), in single precision, evaluated at wavelengths (nm).
    pub fn values(self, bands: [f64; 4], values: [f32; 4], at: &[f64]) -> Vec<f32> {
        let nodes = bands.map(|band| self.place(band));
        let places = at.iter().map(|&wavelength| self.place(wavelength));
        if self == Self::Newton {
            let (nodes, values) = (Vec4::from_array(nodes), Vec4::from_array(values));
            let coefficients = newton_coefficients(nodes, values);
            places.map(|x| newton_value(nodes, coefficients, x)).collect()
        } else {
            let [a0, a1, a2, a3] = eliminated(nodes, values);
            places.map(|x| ((a3 * x + a2) * x + a1) * x + a0).collect()
        }
    }
}

/// The coefficients of the cubic by Gaussian elimination with partial pivoting in single precision; NaN or infinite
/// where the matrix is singular to it.
fn eliminated(nodes: [f32; 4], values: [f32; 4]) -> [f32; 4] {
    let mut rows: [[f32; 5]; 4] =
        std::array::from_fn(|i| [1.0, nodes[i], nodes[i] * nodes[i], nodes[i] * nodes[i] * nodes[i], values[i]]);
    for column in 0..4 {
        let size = |row: &usize| rows[*row][column].abs();
        let pivot = (column..4).max_by(|a, b| size(a).total_cmp(&size(b))).expect("a row is left");
        rows.swap(column, pivot);
        let (above, below) = rows.split_at_mut(column + 1);
        let pivot = &above[column];
        for row in below {
            let factor = row[column] / pivot[column];
            row.iter_mut().zip(pivot).skip(column).for_each(|(number, above)| *number -= factor * above);
        }
    }
    let mut coefficients = [0.0; 4];
    for i in (0..4).rev() {
        let known: f32 = (i + 1..4).map(|k| rows[i][k] * coefficients[k]).sum();
        coefficients[i] = (rows[i][4] - known) / rows[i][i];
    }
    coefficients
}

/// The cubic through four points at `x` in double precision, by Newton's form; its own error is 2⁻²⁹ of single
/// precision's.
pub fn reference(nodes: [f32; 4], values: [f32; 4], x: f32) -> f64 {
    let (n, mut d, x) = (nodes.map(f64::from), values.map(f64::from), f64::from(x));
    for order in 1..4 {
        for i in (order..4).rev() {
            d[i] = (d[i] - d[i - 1]) / (n[i] - n[i - order]);
        }
    }
    ((d[3] * (x - n[2]) + d[2]) * (x - n[1]) + d[1]) * (x - n[0]) + d[0]
}

/// The cubic through four points at `x`, exactly.
pub fn exact(nodes: [f32; 4], values: [f32; 4], x: f32) -> BigRational {
    let rational = |number: f32| BigRational::from_float(number).expect("a finite number");
    let (nodes, x) = (nodes.map(rational), rational(x));
    let cardinal = |i: usize| {
        let others = (0..4).filter(|&j| j != i);
        others.map(|j| (&x - &nodes[j]) / (&nodes[i] - &nodes[j])).product::<BigRational>()
    };
    (0..4).map(|i| rational(values[i]) * cardinal(i)).sum()
}

/// The double next to an exact number.
pub(super) fn double(number: &BigRational) -> f64 {
    number.to_f64().unwrap_or(f64::NAN)
}

/// `Λ(x)` of [`newton_coefficients`]: how much the divided differences amplify a relative error of one.
pub fn amplification(nodes: [f32; 4], x: f32) -> f64 {
    let (n, x) = (nodes.map(f64::from), f64::from(x));
    let mut sums = [1.0; 4];
    for order in 1..4 {
        for i in (order..4).rev() {
            sums[i] = (sums[i] + sums[i - 1]) / (n[i] - n[i - order]).abs();
        }
    }
    let mut product = 1.0;
    let mut sum = 0.0;
    for (node, amount) in n.into_iter().zip(sums) {
        sum += amount * product;
        product *= (x - node).abs();
    }
    sum
}

/// The condition number, in the maximum norm, of the Vandermonde matrix on the places that a form gives four bands
/// (nm).
///
/// The inverse's columns are the coefficients of the cardinal polynomials.
pub fn condition(form: Form, bands: [f64; 4]) -> f64 {
    let nodes = match form {
        Form::Raw => bands,
        Form::Normalised | Form::Newton => bands.map(normalised),
    };
    let size = nodes.iter().map(|x| (0..4).map(|k| x.abs().powi(k)).sum::<f64>()).fold(0.0, f64::max);
    let mut rows = [0.0; 4];
    for i in 0..4 {
        let mut polynomial = [1.0, 0.0, 0.0, 0.0];
        let mut scale = 1.0;
        for j in (0..4).filter(|&j| j != i) {
            for k in (0..4).rev() {
                let lower = if k > 0 { polynomial[k - 1] } else { 0.0 };
                polynomial[k] = lower - nodes[j] * polynomial[k];
            }
            scale *= nodes[i] - nodes[j];
        }
        rows.iter_mut().zip(polynomial).for_each(|(row, coefficient)| *row += (coefficient / scale).abs());
    }
    size * rows.into_iter().fold(0.0, f64::max)
}

/// Four bands and what stands at them.
#[derive(Clone, Debug)]
pub struct Case {
    /// Wavelengths (nm), in the order in which they are given.
    pub bands: [f64; 4],
    /// Values at the bands.
    pub values: [f32; 4],
    /// Wavelengths at which the cubic is looked at (nm).
    pub at: Vec<f64>,
}

impl Case {
    /// The case with this number.
    pub fn random(seed: u64, number: u64) -> Self {
        let mut rng = generator(seed, number);
        let bands = bands(&mut rng);
        let values = match rng.random_range(0..4) {
            // As a clear sky's transfer falls with the wavelength.
            0 => {
                let power = rng.random_range(-6.0..2.0);
                bands.map(|band| (band / 550.0).powf(power) as f32)
            }
            1 => std::array::from_fn(|_| rng.random_range(0.0..1.0)),
            // Logarithms of radiances, which the regression fit solves for.
            2 => std::array::from_fn(|_| rng.random_range(-70.0..10.0)),
            _ => std::array::from_fn(|_| 10f64.powf(rng.random_range(-15.0..5.0)) as f32),
        };
        let (shortest, longest) = MEASURED_RANGE;
        let mut at = bands.to_vec();
        at.extend([shortest, longest]);
        at.extend((2..LOOKS).map(|_| rng.random_range(shortest..longest)));
        Self { bands, values, at }
    }

    /// The largest error of Newton's form, in units of [`amplification`] times half a unit in the last place of the
    /// largest value.
    pub fn error(&self) -> f64 {
        self.error_of(&Form::Newton.values(self.bands, self.values, &self.at))
    }

    /// [`Self::error`] of what somebody else says the cubic is at the wavelengths that are looked at.
    fn error_of(&self, fitted: &[f32]) -> f64 {
        let nodes = self.nodes();
        let errors = self.at.iter().zip(fitted).map(|(&wavelength, &fitted)| {
            let x = Form::Newton.place(wavelength);
            (f64::from(fitted) - reference(nodes, self.values, x)).abs() / self.unit(x)
        });
        worst(errors)
    }

    fn nodes(&self) -> [f32; 4] {
        self.bands.map(|band| Form::Newton.place(band))
    }

    /// The unit of errors at a normalised wavelength.
    fn unit(&self, x: f32) -> f64 {
        HALF_ULP * amplification(self.nodes(), x) * largest(self.values)
    }

    /// The largest error of [`reference()`] against [`exact`] arithmetic, in the unit of [`Self::error`].
    pub fn error_of_reference(&self) -> f64 {
        let nodes = self.nodes();
        let errors = self.at.iter().map(|&wavelength| {
            let x = Form::Newton.place(wavelength);
            let rounded = BigRational::from_float(reference(nodes, self.values, x)).expect("a finite number");
            double(&(rounded - exact(nodes, self.values, x))).abs() / self.unit(x)
        });
        worst(errors)
    }
}

fn largest(values: [f32; 4]) -> f64 {
    values.into_iter().map(|value| f64::from(value.abs())).fold(0.0, f64::max)
}

/// The largest of some errors; a NaN is worse than anything.
fn worst(errors: impl Iterator<Item = f64>) -> f64 {
    errors.fold(0.0, |worst, error| if error.is_nan() { f64::INFINITY } else { worst.max(error) })
}

/// Four wavelengths (nm) in any order, at least [`CLOSEST_BANDS`] apart: often close together, sometimes on whole
/// steps.
fn bands(rng: &mut impl RngExt) -> [f64; 4] {
    let (shortest, longest) = MEASURED_RANGE;
    let mut gaps: [f64; 3] = std::array::from_fn(|_| CLOSEST_BANDS * 320f64.powf(rng.random_range(0.0..1.0)));
    let gaps_sum: f64 = gaps.iter().sum();
    let room = longest - shortest;
    if gaps_sum > room {
        gaps = gaps.map(|gap| (gap * 0.99 * room / gaps_sum).max(CLOSEST_BANDS));
    }
    let first = shortest + (room - gaps.iter().sum::<f64>()) * rng.random_range(0.0..1.0);
    let mut bands = [first, first + gaps[0], first + gaps[0] + gaps[1], first + gaps[0] + gaps[1] + gaps[2]];
    if rng.random_bool(0.3) {
        bands = bands.map(|band| (band / CLOSEST_BANDS).round() * CLOSEST_BANDS);
    }
    for i in (1..4).rev() {
        bands.swap(i, rng.random_range(0..=i));
    }
    bands
}

/// Holds Newton's form to its error bound, and the double precision that judges it to exact arithmetic.
pub fn solve(seed: u64, cases: u64) -> Outcome {
    let tried = (0..cases).into_par_iter().map(|number| {
        let case = Case::random(seed, number);
        let mut error = case.error();
        if number % EXACT_EVERY == 0 && case.error_of_reference() > 1e-3 {
            error = f64::INFINITY;
        }
        (u64::from(error > BOUND), error, number)
    });
    let worse = |a: (u64, f64, u64), b: (u64, f64, u64)| {
        // Ties go to the smaller number, so that the outcome does not depend on how the work was divided.
        let (_, error, number) = if b.1 > a.1 || (b.1 == a.1 && b.2 < a.2) { b } else { a };
        (a.0 + b.0, error, number)
    };
    let (failures, worst, number) = tried.reduce(|| (0, f64::NEG_INFINITY, u64::MAX), worse);
    let Case { bands, values, .. } = Case::random(seed, number);
    Outcome {
        subject: "cubic through four bands: error ÷ (2⁻²⁴ Λ Y)",
        seed,
        cases,
        failures,
        worst,
        bound: BOUND,
        worst_case: format!("case {number}: bands {bands:?} nm, values {values:?}"),
        ..Outcome::default()
    }
}

/// What the cubic through four points is at `x`: [`reference()`] or [`exact`].
pub type Truth = fn([f32; 4], [f32; 4], f32) -> f64;

/// The largest error of a form in single precision over the observer's range, against the true cubic through the form's
/// own nodes, relative to the largest value.
pub fn error_of(form: Form, bands: [f64; 4], values: [f32; 4], truth: Truth) -> f64 {
    let at = sorairo::low_level::spectra::observer::wavelengths();
    let nodes = bands.map(|band| form.place(band));
    let fitted = form.values(bands, values, &at);
    worst(at.iter().zip(fitted).map(|(&wavelength, fitted)| {
        (f64::from(fitted) - truth(nodes, values, form.place(wavelength))).abs() / largest(values)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_arithmetic_gives_a_cubic_back_from_four_of_its_points() {
        let cubic = |x: f32| ((2.0 * x - 1.0) * x + 4.0) * x - 3.0;
        let nodes = [0.5, -1.0, 2.0, 0.25];
        let value = exact(nodes, nodes.map(cubic), 3.0);
        assert_eq!(double(&value), f64::from(cubic(3.0)));
    }

    #[test]
    fn bands_are_apart_and_within_what_was_measured() {
        for number in 0..20_000 {
            let mut bands = Case::random(7, number).bands;
            assert!(bands.iter().all(|band| (360.0..=830.0).contains(band)), "{bands:?}");
            bands.sort_by(f64::total_cmp);
            // Adding a gap to a wavelength rounds at 1e-13 nm.
            assert!(bands.windows(2).all(|pair| pair[1] - pair[0] >= CLOSEST_BANDS - 1e-12), "{bands:?}");
        }
    }

    #[test]
    fn normalised_wavelengths_condition_the_matrix() {
        let paper = [430.0, 520.0, 610.0, 700.0];
        let (raw, normalised) = (condition(Form::Raw, paper), condition(Form::Normalised, paper));
        assert!(raw > 1e10 && normalised < 100.0, "{raw:e} {normalised}");
    }

    #[test]
    fn a_value_that_is_off_by_a_hundred_thousandth_fails() {
        let case = Case { bands: [430.0, 520.0, 610.0, 700.0], values: [4.0, 2.0, 1.0, 0.5], at: vec![430.0, 555.0] };
        let mut fitted = Form::Newton.values(case.bands, case.values, &case.at);
        assert!(case.error_of(&fitted) <= BOUND);
        // At a band Λ is a few units, and 1e-5 is 168 half units in the last place.
        fitted[0] *= 1.0 + 1e-5;
        assert!(case.error_of(&fitted) > BOUND);
        fitted[0] = f32::NAN;
        assert!(case.error_of(&fitted) > BOUND);
    }
}
