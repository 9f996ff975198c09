//! The rule by which the ray integral is sampled.

use std::sync::OnceLock;

use sorairo_shared::glam::Vec2;

/// Rules of fewer points than this are kept: those of all but rays that are sampled most finely.
const KEPT: usize = 129;

/// The rules that have been computed, by their number of points.
static RULES: [OnceLock<Vec<Vec2>>; KEPT] = [const { OnceLock::new() }; KEPT];

/// Nodes and weights of Gauss-Legendre quadrature with `n` points on [0, 1], nodes increasing.
///
/// Newton's method on the Legendre polynomial from Tricomi's estimate of its roots (Press et al. 2007, *Numerical
/// Recipes*, 4.6.1); the rule is exact for polynomials of degree `2n - 1`.
pub fn gauss_legendre(n: u32) -> Vec<Vec2> {
    match RULES.get(n as usize) {
        Some(rule) => rule.get_or_init(|| computed(n)).clone(),
        None => computed(n),
    }
}

fn computed(n: u32) -> Vec<Vec2> {
    let mut rule = vec![Vec2::ZERO; n as usize];
    for i in 0..n.div_ceil(2) {
        let (from_end, weight) = node_and_weight(n, i);
        let (low, high) = (i as usize, (n - 1 - i) as usize);
        rule[high] = Vec2::new((1.0 - from_end) as f32, weight as f32);
        rule[low] = Vec2::new(from_end as f32, weight as f32);
    }
    rule
}

/// The nodes of [`gauss_legendre`] and their weights, increasing, in double precision.
pub fn nodes_and_weights(n: u32) -> Vec<(f64, f64)> {
    let node = |i: u32| match node_and_weight(n, i.min(n - 1 - i)) {
        (from_end, weight) if 2 * i < n => (from_end, weight),
        (from_end, weight) => (1.0 - from_end, weight),
    };
    (0..n).map(node).collect()
}

/// The node `i` from an end of [0, 1], as its distance from that end, and its weight.
fn node_and_weight(n: u32, i: u32) -> (f64, f64) {
    /// Newton's method squares the error: a step as small as this leaves none.
    const LAST_STEP: f64 = 1e-9;
    let mut x = (std::f64::consts::PI * (f64::from(i) + 0.75) / (f64::from(n) + 0.5)).cos();
    loop {
        let (value, slope) = legendre(n, x);
        x -= value / slope;
        if (value / slope).abs() < LAST_STEP {
            break;
        }
    }
    let (_, slope) = legendre(n, x);
    (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
}

/// The Legendre polynomial of degree `n` at `x`, and its derivative.
fn legendre(n: u32, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (0.0, 1.0);
    for k in 1..=n {
        let k = f64::from(k);
        (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
    }
    (value, f64::from(n) * (x * value - before) / (x * x - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_is_exact_for_polynomials_up_to_its_degree() {
        for n in [1, 2, 5, 16, 64] {
            let rule = gauss_legendre(n);
            for degree in 0..(2 * n).min(12) as i32 {
                let sum: f64 = rule.iter().map(|p| f64::from(p.y) * f64::from(p.x).powi(degree)).sum();
                let truth = 1.0 / f64::from(degree + 1);
                // Nodes and weights are rounded to single precision.
                assert!((sum - truth).abs() < 3e-7, "n = {n}, degree {degree}: {sum}");
            }
        }
    }
}
