//! Moments of a light field, and their interpolation between the nodes of a table.
//!
//! A light field `L(v)` that is symmetric about the vertical plane through the sun is a sum of real spherical harmonics
//! that are even in the azimuth `φ` from the sun:
//!
//! ```text
//! L(v) = Σ_l Σ_m L_lm Y_lm(v),   Y_lm = N_lm P_l^m(μ) cos(m φ),   l = 0, 1, ...,   m = 0 ... l
//! ```
//!
//! with `μ` the cosine of the zenith angle, `P_l^m` the associated Legendre functions and `N_lm` such that the integral
//! of `Y_lm²` over the sphere is 1. The moment `L_lm` is then the integral of `L(v) Y_lm(v)`.

use crate::math::{PI, clamp, fetch, sqrt, store};

/// Which moments a table holds: those of a degree `l` up to `degree` and an azimuthal number `m` up to `azimuthal`, one
/// `m` after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moments {
    /// The highest degree.
    pub degree: usize,
    /// The highest azimuthal number, at most `degree`.
    pub azimuthal: usize,
}

impl Moments {
    /// Where the moments of an azimuthal number begin, with that of the degree `m`.
    #[inline]
    pub fn first(self, m: usize) -> usize {
        // Written so that nothing lies below zero in between: a shader has no saturating subtraction.
        m * (2 * self.degree + 3 - m) / 2
    }

    /// How many there are.
    #[inline]
    pub fn count(self) -> usize {
        self.first(self.azimuthal + 1)
    }
}

/// The functions `N_lm P_l^m(μ)` of all `moments` at `μ`, in their order from an index on; `sine` is `√(1 - μ²)`.
///
/// Upward recursions of functions that are normalised already (Holmes and Featherstone 2002, Eqs. 11-13,
/// <https://doi.org/10.1007/s00190-002-0216-2>): in single precision 2e-6 of the largest up to degree 48.
pub fn legendre(moments: Moments, mu: f32, sine: f32, functions: &mut [f32], first: usize) {
    let mut diagonal = sqrt(0.25 / PI);
    let mut m = 0;
    let mut at = first;
    while m <= moments.azimuthal {
        if m > 0 {
            // The cosine of the azimuth brings a factor √2 with m = 1.
            let ratio = if m == 1 { 3.0 } else { (2 * m + 1) as f32 / (2 * m) as f32 };
            diagonal *= sine * sqrt(ratio);
        }
        let mut before = 0.0;
        let mut value = diagonal;
        // 1 / √((4 l² - 1) / (l² - m²)) of the degree before.
        let mut inverse_slope = 0.0;
        let mut l = m;
        while l <= moments.degree {
            store(functions, at, value);
            at += 1;
            l += 1;
            let (l2, m2) = ((l * l) as f32, (m * m) as f32);
            let slope = sqrt((4.0 * l2 - 1.0) / (l2 - m2));
            let next = slope * (mu * value - inverse_slope * before);
            inverse_slope = 1.0 / slope;
            before = value;
            value = next;
        }
        m += 1;
    }
}

/// The part `Σ_l (2l + 1)/(4π) χ_l P_l(ν)` of a phase function with the Legendre moments `χ` (sr⁻¹), up to the degree
/// of the last of them.
pub fn phase_from_moments(chi: &[f32], nu: f32) -> f32 {
    let mut before = 0.0;
    let mut value = 1.0;
    let mut sum = 0.0;
    let mut l = 0;
    while l < chi.len() {
        let degree = l as f32;
        sum += (2.0 * degree + 1.0) * fetch(chi, l) * value;
        let next = ((2.0 * degree + 1.0) * nu * value - degree * before) / (degree + 1.0);
        before = value;
        value = next;
        l += 1;
    }
    sum * (0.25 / PI)
}

/// Nodes between which a function is interpolated by the cubic through four of them.
///
/// They stand in a list of numbers: the nodes, increasing and four at least, then for each four neighbours the four
/// inverse products of their differences, Lagrange's denominators.
#[derive(Clone, Copy)]
pub struct Axis<'a> {
    /// The list.
    pub values: &'a [f32],
    /// Where the nodes begin in it.
    pub first: usize,
    /// Nodes.
    pub count: usize,
}

/// Four neighbours of an axis and the weights of their values.
#[derive(Clone, Copy)]
pub struct Stencil {
    /// The first of the four.
    pub first: usize,
    /// Their weights.
    pub weights: [f32; 4],
}

impl Axis<'_> {
    /// The stencil at `x`, which is taken to the nearest end where it lies outside. The neighbours are looked for from
    /// `guess` on.
    #[inline(always)]
    pub fn stencil(self, x: f32, guess: usize) -> Stencil {
        let last = self.count - 1;
        let x = clamp(x, self.node(0), self.node(last));
        let mut first = if guess + 3 > last { last - 3 } else { guess };
        while (first + 3 < last) && (x >= self.node(first + 2)) {
            first += 1;
        }
        while (first > 0) && (x < self.node(first + 1)) {
            first -= 1;
        }
        let a = x - self.node(first);
        let b = x - self.node(first + 1);
        let c = x - self.node(first + 2);
        let d = x - self.node(first + 3);
        let (ab, cd) = (a * b, c * d);
        let inverse = move |i: usize| fetch(self.values, self.first + self.count + 4 * first + i);
        let weights = [b * cd * inverse(0), a * cd * inverse(1), ab * d * inverse(2), ab * c * inverse(3)];
        Stencil { first, weights }
    }

    #[inline(always)]
    fn node(self, index: usize) -> f32 {
        fetch(self.values, self.first + index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Moments = Moments { degree: 12, azimuthal: 12 };

    fn functions(mu: f64) -> Vec<f64> {
        let mut functions = vec![0.0; ALL.count()];
        legendre(ALL, mu as f32, (1.0 - mu * mu).sqrt() as f32, &mut functions, 0);
        functions.into_iter().map(f64::from).collect()
    }

    #[test]
    fn moments_follow_each_other_without_gaps() {
        let moments = Moments { degree: 5, azimuthal: 3 };
        let counts: Vec<usize> = (0..=3).map(|m| moments.first(m + 1) - moments.first(m)).collect();
        assert_eq!((moments.first(0), counts, moments.count()), (0, vec![6, 5, 4, 3], 18));
    }

    #[test]
    fn harmonics_are_orthonormal() {
        let n = 4000;
        let rows: Vec<Vec<f64>> = (0..n).map(|i| functions(-1.0 + (2.0 * f64::from(i) + 1.0) / f64::from(n))).collect();
        for m in 0..=ALL.azimuthal {
            // The integral of cos²(mφ) over the azimuth.
            let around = if m == 0 { 2.0 } else { 1.0 } * std::f64::consts::PI;
            for a in ALL.first(m)..ALL.first(m + 1) {
                for b in a..ALL.first(m + 1) {
                    let integral: f64 =
                        rows.iter().map(|row| row[a] * row[b]).sum::<f64>() * 2.0 / f64::from(n) * around;
                    let expected = if a == b { 1.0 } else { 0.0 };
                    // 4000 midpoints leave 1e-5 of a polynomial of degree 24, single precision 1e-6 of each value.
                    assert!((integral - expected).abs() < 5e-5, "m = {m}, {a} and {b}: {integral}");
                }
            }
        }
    }

    #[test]
    fn a_phase_function_is_the_sum_of_its_moments() {
        // Rayleigh's: χ = 1, 0, 1/10.
        for nu in [-1.0f32, -0.3, 0.0, 0.5, 1.0] {
            let expected = 3.0 / (16.0 * PI) * (1.0 + nu * nu);
            assert!((phase_from_moments(&[1.0, 0.0, 0.1], nu) / expected - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_cubic_is_interpolated_exactly() {
        let nodes = [0.0f32, 0.3, 1.0, 1.2, 2.0, 3.5];
        let inverse_product = |first: usize, a: usize| {
            let others = (0..4).filter(|&b| b != a);
            1.0 / others.map(|b| nodes[first + a] - nodes[first + b]).product::<f32>()
        };
        let inverse_products = (0..3).flat_map(|first| (0..4).map(move |a| inverse_product(first, a)));
        // Behind numbers that are others'.
        let values: Vec<f32> = [7.0; 3].into_iter().chain(nodes).chain(inverse_products).collect();
        let axis = Axis { values: &values, first: 3, count: nodes.len() };
        let cubic = |x: f32| ((0.3 * x - 1.0) * x + 0.2) * x + 2.0;
        for guess in 0..6 {
            for x in [0.0f32, 0.1, 0.3, 1.1, 1.7, 3.0, 3.5] {
                let Stencil { first, weights } = axis.stencil(x, guess);
                let value: f32 = (0..4).map(|i| weights[i] * cubic(nodes[first + i])).sum();
                // Weights of up to three, values of up to four, each rounded by 6e-8.
                assert!((value - cubic(x)).abs() < 5e-6, "{x}: {value}, not {}", cubic(x));
            }
            assert_eq!(axis.stencil(-1.0, guess).weights, axis.stencil(0.0, guess).weights);
        }
    }
}
