//! Gauss-Legendre quadrature, with every node and weight computed from the polynomials.

use std::f64::consts::PI;

/// Gauss-Legendre quadrature on [0, 1].
pub(crate) struct GaussLegendre<const N: usize> {
    pub(crate) nodes: [f64; N],
    pub(crate) weights: [f64; N],
    /// Row j integrates from 0 to node j: the integral of the polynomial through all N nodes.
    pub(crate) running: [[f64; N]; N],
}

impl<const N: usize> GaussLegendre<N> {
    pub(crate) fn new() -> Self {
        let roots: [f64; N] = std::array::from_fn(|i| legendre_root(N, i));
        let weights = roots.map(|x| {
            let slope = legendre_slope(N, x);
            1.0 / ((1.0 - x * x) * slope * slope)
        });
        let running =
            std::array::from_fn(|j| std::array::from_fn(|k| weights[k] * running_weight(N, roots[j], roots[k])));
        Self { nodes: roots.map(|x| 0.5 + 0.5 * x), weights, running }
    }

    /// ∫ f from `start` to `end`.
    pub(crate) fn integrate(&self, start: f64, end: f64, f: impl Fn(f64) -> f64) -> f64 {
        let width = end - start;
        let mut sum = 0.0;
        for i in 0..N {
            sum += self.weights[i] * f(start + width * self.nodes[i]);
        }
        width * sum
    }
}

/// Σ over m < n of P_m(node) (P_m+1(x) − P_m−1(x)) / 2, with P_−1 = −1: half the integral from −1
/// to x of the series that is 1 over its Gauss weight at `node` and 0 at the other nodes.
fn running_weight(n: usize, x: f64, node: f64) -> f64 {
    let term = |m: usize| {
        let before = if m == 0 { -1.0 } else { legendre(m - 1, x) };
        0.5 * legendre(m, node) * (legendre(m + 1, x) - before)
    };
    (0..n).map(term).sum()
}

/// Legendre polynomial P_n(x), by Bonnet's recursion.
fn legendre(n: usize, x: f64) -> f64 {
    let (mut before, mut value) = (0.0, 1.0);
    for k in 0..n {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0));
    }
    value
}

/// dP_n/dx inside (−1, 1).
fn legendre_slope(n: usize, x: f64) -> f64 {
    n as f64 * (x * legendre(n, x) - legendre(n - 1, x)) / (x * x - 1.0)
}

/// The i-th root of P_n, ascending, by Newton's method from Tricomi's estimate.
fn legendre_root(n: usize, i: usize) -> f64 {
    let mut x = -(PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
    for _ in 0..8 {
        x -= legendre(n, x) / legendre_slope(n, x);
    }
    x
}
