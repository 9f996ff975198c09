//! The light of all orders from the last three that were computed.
//!
//! An order of scattering is a linear operator `A` applied to the order before, so that the sum of an order `x` and all after it solves
//! `(1 - A) s = x`. With the next two orders `A x` and `A² x` known, `s = a x + b A x` leaves the residual
//! `x - a (x - A x) - b (A x - A² x)`; of all `a` and `b` those are taken that make it least (the minimal residual of a Krylov space of two,
//! Saad and Schultz 1986, <https://doi.org/10.1137/0907058>). One more scattering makes what is left smaller still: `x + a A x + b A² x`. Where orders are a
//! geometric series this is its sum.

use sorairo_shared::multiple::Lanes;

/// The part of the least squares that holds the coefficients to those of a geometric series, which they are where orders are in proportion and
/// nothing else tells them apart.
const TOWARDS_GEOMETRIC: f64 = 1e-4;

/// The ratio of orders that is taken at most where they do not fall off: the sum of what is left stays finite.
const LARGEST_RATIO: f64 = 0.98;

/// Nodes with less than this part of the brightest light matter less.
const DARK: f64 = 0.01;

/// What stands for all orders from the last but one on.
pub struct Closing<const N: usize> {
    /// How often the order before the last counts.
    pub second: Lanes<N>,
    /// How often the last one counts.
    pub third: Lanes<N>,
    /// The ratio of the last two.
    pub ratio: [f32; N],
    /// How far the sum may be off, relative to all light.
    pub error: f64,
}

impl<const N: usize> Closing<N> {
    /// From the mean radiances at all nodes of the last three orders, and those of the sum of all up to the first of them.
    pub fn new(orders: &[Vec<Lanes<N>>; 3], sum: &[Lanes<N>]) -> Self {
        let mut closing = Self { second: Lanes([1.0; N]), third: Lanes([1.0; N]), ratio: [0.0; N], error: 0.0 };
        let at = |means: &[Lanes<N>], band: usize| -> Vec<f64> {
            means.iter().map(|mean| f64::from(mean.0[band])).collect()
        };
        for band in 0..N {
            let orders = [0, 1, 2].map(|order| at(&orders[order], band));
            let of_band = OfBand::new(&orders, &at(sum, band));
            closing.second.0[band] = of_band.second as f32;
            closing.third.0[band] = of_band.third as f32;
            closing.ratio[band] = of_band.ratio as f32;
            closing.error = closing.error.max(of_band.error);
        }
        closing
    }
}

struct OfBand {
    second: f64,
    third: f64,
    ratio: f64,
    error: f64,
}

impl OfBand {
    fn new([first, second, third]: &[Vec<f64>; 3], sum: &[f64]) -> Self {
        let total = |values: &[f64]| values.iter().sum::<f64>();
        let before = total(second);
        let ratio = if before > 0.0 { (total(third) / before).clamp(0.0, LARGEST_RATIO) } else { 0.0 };
        let left = 1.0 / (1.0 - ratio);
        let brightest = sum.iter().copied().fold(0.0, f64::max);
        if brightest <= 0.0 {
            return Self { second: 1.0, third: left, ratio, error: 0.0 };
        }
        let nodes = || first.iter().zip(second).zip(third).zip(sum).map(|(((x, y), z), sum)| [*x, *y, *z, *sum]);
        let (mut uu, mut uv, mut vv, mut ut, mut vt) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for [x, y, z, sum] in nodes() {
            let weight = 1.0 / sum.max(DARK * brightest);
            let (u, v) = ((x - y) * weight, (y - z) * weight);
            // What the geometric series leaves.
            let t = x * weight - u - left * v;
            uu += u * u;
            uv += u * v;
            vv += v * v;
            ut += u * t;
            vt += v * t;
        }
        let (uu, vv) = (uu * (1.0 + TOWARDS_GEOMETRIC), vv * (1.0 + TOWARDS_GEOMETRIC));
        let determinant = uu * vv - uv * uv;
        let (a, b) = if determinant > 0.0 {
            (1.0 + (ut * vv - vt * uv) / determinant, left + (vt * uu - ut * uv) / determinant)
        } else {
            (1.0, left)
        };
        let off = |[x, y, z, sum]: [f64; 4]| {
            let residual = x - a * (x - y) - b * (y - z);
            residual.abs() * ratio * left / (sum + a * y + b * z).max(DARK * brightest)
        };
        Self { second: a, third: b, ratio, error: nodes().map(off).fold(0.0, f64::max) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orders of an operator with these eigenvalues, from a first order, at nodes that mix its parts.
    fn orders(eigenvalues: [f64; 2]) -> (Vec<Vec<f64>>, Vec<f64>) {
        let parts: Vec<[f64; 2]> = (0..20).map(|i| [1.0, 0.3 * (f64::from(i) * 0.2).cos()]).collect();
        let order = |n: i32| -> Vec<f64> {
            parts.iter().map(|[a, b]| a * eigenvalues[0].powi(n) + b * eigenvalues[1].powi(n)).collect()
        };
        let all = parts.iter().map(|[a, b]| a / (1.0 - eigenvalues[0]) + b / (1.0 - eigenvalues[1])).collect();
        ((0..3).map(order).collect(), all)
    }

    fn worst(eigenvalues: [f64; 2]) -> (f64, f64) {
        let (orders, all) = orders(eigenvalues);
        let orders: [Vec<f64>; 3] = orders.try_into().unwrap();
        let closing = OfBand::new(&orders, &orders[0]);
        let sum = |i: usize| orders[0][i] + closing.second * orders[1][i] + closing.third * orders[2][i];
        let off = (0..20).map(|i| (sum(i) / all[i] - 1.0).abs()).fold(0.0, f64::max);
        (off, closing.error)
    }

    #[test]
    fn a_geometric_series_is_summed_exactly() {
        let (off, error) = worst([0.6, 0.6]);
        assert!(off < 1e-9 && error < 1e-9, "{off:e}, {error:e}");
    }

    #[test]
    fn two_series_are_summed_within_the_error_that_is_told() {
        for eigenvalues in [[0.5, 0.2], [0.8, 0.4], [0.3, -0.1]] {
            let (off, error) = worst(eigenvalues);
            // The ridge leaves 1e-4 of a small difference; the error is told from the residual and the larger eigenvalue.
            assert!(off < 2e-3 && off <= 1.5 * error + 1e-6, "{eigenvalues:?}: {off:e}, told {error:e}");
        }
    }

    #[test]
    fn the_negative_control_is_off() {
        let (orders, all) = orders([0.8, 0.4]);
        let without: f64 = orders.iter().map(|order| order[0]).sum();
        assert!((without / all[0] - 1.0).abs() > 0.3);
    }
}
