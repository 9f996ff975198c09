//! The spectrum between the bands: a fit through the integrated values, by one small linear solve per pixel.

use crate::glam::{Vec3, Vec4};
use crate::math::{exp, fetch, fetch_in, ln4, max, max4, min};
use crate::uniform::NODE_ROWS;
use crate::variant;

/// The coefficients of the cubic through four points, in Newton's form: the Vandermonde system
/// `Σₖ aₖ xᵢᵏ = yᵢ`, solved by divided differences.
///
/// `wavelengths` are four distinct normalised wavelengths in any order, `values` the ordinates. Newton's form solves
/// the same 4×4 system as the Vandermonde matrix without ever forming it, in 6 divisions (Björck and Pereyra 1970,
/// <https://doi.org/10.1090/S0025-5718-1970-0290541-1>).
///
/// # Error
///
/// Let `p` be the exact cubic through the given numbers, `p̂` what [`newton_value`] makes of these coefficients, and
/// `Y` the largest `|values|`. Then, as long as nothing underflows,
///
/// ```text
/// |p̂(x) - p(x)| <= 18 · 2⁻²⁴ · Λ(x) · Y · (1 + 2⁻¹⁹)
/// Λ(x) = Σₖ Mₖ Πⱼ<ₖ |x - xⱼ|,    k = 0 ... 3
/// M₀ = 1,    M₁ = 2 / |x₁ - x₀|,    and so on: divided differences with every difference of values made a sum
/// ```
///
/// A divided difference of order `k` passes `3k` roundings (two differences and a quotient at each level), each
/// relative to a sum of absolute values; Horner's rule adds `3k` to the term of order `k < 3` and one for its own
/// addition, nine to the last. The cubic term has most, 9 + 9 (Higham 2002, *Accuracy and Stability of Numerical
/// Algorithms*, 5.3 and lemma 3.1). On a GPU whose quotients are good to 2.5 ULP, as Vulkan demands, 30 takes the place
/// of 18.
///
/// With increasing wavelengths `Λ` is as small as the problem itself allows but for a constant; other orders lose more.
/// It grows as the inverse cube of the spacing: rounding a value at one of the bands does the same to the exact cubic.
#[inline(always)]
pub fn newton_coefficients(wavelengths: Vec4, values: Vec4) -> Vec4 {
    let d01 = (values.y - values.x) / (wavelengths.y - wavelengths.x);
    let d12 = (values.z - values.y) / (wavelengths.z - wavelengths.y);
    let d23 = (values.w - values.z) / (wavelengths.w - wavelengths.z);
    let d012 = (d12 - d01) / (wavelengths.z - wavelengths.x);
    let d123 = (d23 - d12) / (wavelengths.w - wavelengths.y);
    let d0123 = (d123 - d012) / (wavelengths.w - wavelengths.x);
    Vec4::new(values.x, d01, d012, d0123)
}

/// The cubic with these Newton coefficients at the normalised wavelength `x`.
#[inline]
pub fn newton_value(wavelengths: Vec4, coefficients: Vec4, x: f32) -> f32 {
    ((coefficients.w * (x - wavelengths.z) + coefficients.z) * (x - wavelengths.y) + coefficients.y)
        * (x - wavelengths.x)
        + coefficients.x
}

/// Values of up to twelve bands; zero for those that there are not.
#[derive(Clone, Copy)]
pub struct Dozen {
    /// The first four bands.
    pub first: Vec4,
    /// The next four.
    pub second: Vec4,
    /// The last four.
    pub third: Vec4,
}

impl Dozen {
    /// No light at any band.
    pub const DARK: Self = Self { first: Vec4::ZERO, second: Vec4::ZERO, third: Vec4::ZERO };

    /// Whether any of a variant's bands is above zero.
    #[inline(always)]
    pub fn is_lit(self, variant: u32) -> bool {
        let mut brightest = highest(self.first);
        if variant & variant::MORE_THAN_FOUR != 0 {
            brightest = max(brightest, highest(self.second));
        }
        if variant & variant::MORE_THAN_EIGHT != 0 {
            brightest = max(brightest, highest(self.third));
        }
        brightest > 0.0
    }
}

/// The largest of four values.
#[inline(always)]
fn highest(x: Vec4) -> f32 {
    max(max(x.x, x.y), max(x.z, x.w))
}

/// Rows that an observer node takes: one for each group of four bands, and one more.
#[inline]
pub fn rows_per_node(variant: u32) -> u32 {
    let mut rows = 2;
    if variant & variant::MORE_THAN_FOUR != 0 {
        rows += 1;
    }
    if variant & variant::MORE_THAN_EIGHT != 0 {
        rows += 1;
    }
    rows
}

/// The smallest transfer whose logarithm is taken; anything darker counts as this.
pub const DARKEST: f32 = 1e-30;

/// How far, in natural logarithms, a fitted value may rise above the brightest band. The bands enclose all but the ends
/// of the observer's range, where the transfer of a clear sky is at most 40 % brighter than at the outermost band.
const BRIGHTEST_RISE: f32 = 1.0;

/// How far, in natural logarithms, a value of a spectral image may rise above the brightest band. At 830 nm, far beyond
/// the bands, light that has crossed the most air has lost some ten logarithms fewer than at 650 nm.
pub const SPECTRUM_RISE: f32 = 10.0;

/// One constituent's integral at the bands, ready for the observer nodes of the regression fit.
#[derive(Clone, Copy)]
pub struct Logarithms {
    /// ln X at the first four bands, or the Newton coefficients of its cubic.
    pub(crate) first: Vec4,
    /// ln X at the next four bands.
    pub(crate) second: Vec4,
    /// ln X at the last four bands.
    pub(crate) third: Vec4,
    /// The logarithm of the brightest band.
    pub(crate) highest: f32,
    /// Whether any band is above zero.
    pub(crate) lit: bool,
}

impl Logarithms {
    /// Those of the integral at the bands, as many as the variant has. By a fit that is [`variant::SOLVED`], the Newton
    /// coefficients of `ln X` at the first four bands ([`newton_coefficients`]) take the place of the values
    /// themselves; `wavelengths` are the normalised ones of those bands.
    #[inline(always)]
    pub fn new(bands: Dozen, wavelengths: Vec4, variant: u32) -> Self {
        let first = ln4(max4(bands.first, DARKEST));
        let (mut second, mut third) = (Vec4::ZERO, Vec4::ZERO);
        let mut highest = highest(first);
        if variant & variant::MORE_THAN_FOUR != 0 {
            second = ln4(max4(bands.second, DARKEST));
            highest = max(highest, self::highest(second));
        }
        if variant & variant::MORE_THAN_EIGHT != 0 {
            third = ln4(max4(bands.third, DARKEST));
            highest = max(highest, self::highest(third));
        }
        Self {
            first: if variant & variant::SOLVED != 0 { newton_coefficients(wavelengths, first) } else { first },
            second,
            third,
            highest,
            lit: bands.is_lit(variant),
        }
    }

    /// X at a wavelength: `exp(c + b · ln X)`, the exponent given, at most `rise` logarithms above the brightest band.
    /// Without light it is what follows from [`DARKEST`].
    #[inline(always)]
    fn value(&self, exponent: f32, rise: f32) -> f32 {
        exp(min(exponent, self.highest + rise))
    }
}

/// Linear RGB of one constituent's integral by the regression fit: `Σ_q w_q exp(c_q + b_q · ln X)`.
///
/// `ln X(λ_q)` at each observer node is an affine function of `ln X` at the bands, by a regression on the scene's own
/// rays when the plan is made; the weights hold the observer, the sun and XYZ→RGB (Eqs. 4-8). The logarithm makes the
/// fit of an extinction spectrum linear; the exponentials are as few as the nodes.
///
/// Each node has [`rows_per_node`]: `b_q` for each group of four bands, and (`c_q`, red, green, blue). All bands at
/// zero give exactly zero.
#[inline(always)]
pub fn regression_rgb(
    node_rows: &[Vec4; NODE_ROWS],
    first_node: u32,
    nodes: u32,
    logarithms: &Logarithms,
    variant: u32,
) -> Vec3 {
    let rows = rows_per_node(variant);
    let mut rgb = Vec3::ZERO;
    let mut q = 0;
    while q < nodes {
        let row = ((first_node + q) * rows) as usize;
        let last = fetch_in(node_rows, row + rows as usize - 1);
        let mut exponent = last.x + fetch_in(node_rows, row).dot(logarithms.first);
        if variant & variant::MORE_THAN_FOUR != 0 {
            exponent += fetch_in(node_rows, row + 1).dot(logarithms.second);
        }
        if variant & variant::MORE_THAN_EIGHT != 0 {
            exponent += fetch_in(node_rows, row + 2).dot(logarithms.third);
        }
        rgb += Vec3::new(last.y, last.z, last.w) * logarithms.value(exponent, BRIGHTEST_RISE);
        q += 1;
    }
    if logarithms.lit { rgb } else { Vec3::ZERO }
}

/// One constituent's integral times the solar irradiance at one wavelength, by the regression fit (W·m⁻²·nm⁻¹).
///
/// The wavelength's rows begin at `row` of the colour rows, like those of a node of [`regression_rgb`]; the last one
/// holds (`c`, solar irradiance).
#[inline]
pub fn regression_value(colour: &[Vec4], row: usize, logarithms: &Logarithms, variant: u32) -> f32 {
    let last = fetch(colour, row + rows_per_node(variant) as usize - 1);
    let mut exponent = last.x + fetch(colour, row).dot(logarithms.first);
    if variant & variant::MORE_THAN_FOUR != 0 {
        exponent += fetch(colour, row + 1).dot(logarithms.second);
    }
    if variant & variant::MORE_THAN_EIGHT != 0 {
        exponent += fetch(colour, row + 2).dot(logarithms.third);
    }
    let value = last.y * logarithms.value(exponent, SPECTRUM_RISE);
    if logarithms.lit { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_comes_back_from_four_of_its_points() {
        let cubic = |x: f32| ((0.3 * x - 0.7) * x + 0.2) * x + 1.1;
        let wavelengths = Vec4::new(-1.0, -0.3, 0.35, 1.0);
        let values = Vec4::new(cubic(wavelengths.x), cubic(wavelengths.y), cubic(wavelengths.z), cubic(wavelengths.w));
        let coefficients = newton_coefficients(wavelengths, values);
        for i in 0..=40 {
            let x = -1.3 + 0.065 * i as f32;
            // Divided differences over spacings of 0.6 amplify one rounding of 1e-7 some ten times.
            assert!((newton_value(wavelengths, coefficients, x) - cubic(x)).abs() < 2e-6);
        }
    }
}
