//! The light of all orders from the last few that were computed.
//!
//! An order of scattering is a linear operator `A` applied to the order before, so that the sum of an order `x` and all
//! after it solves `(1 - A) s = x`. With the next `n` orders `A x ... A^n x` known, `s = Σ_i c_i A^i x`, `i < n`,
//! leaves the residual `x - Σ_i c_i (A^i x - A^(i+1) x)`; of all `c` those are taken that make it least (the minimal
//! residual of a Krylov space, Saad and Schultz 1986, <https://doi.org/10.1137/0907058>). One more scattering makes
//! what is left smaller still: `x + Σ_i c_i A^(i+1) x`. Where orders are a geometric series this is its sum.
//!
//! As a sky changes, what `n` orders leave passes the tolerance, and one more is computed or one less. There the light
//! of `n` and that of `n + 1` are mixed, so that no sky jumps by what they differ.

use sorairo_shared::value::{Lanes, Value};

/// The part of the least squares that holds the coefficients to those of a geometric series, which they are where
/// orders are in proportion and nothing else tells them apart.
const TOWARDS_GEOMETRIC: f64 = 1e-4;

/// The ratio of orders that is taken at most where they do not fall off: the sum of what is left stays finite.
const LARGEST_RATIO: f64 = 0.98;

/// How often an order counts that stands for all after it, which fall off from it as it does from the one before: sizes
/// of both.
pub(crate) fn geometric_factor(before: f64, last: f64) -> f32 {
    let ratio = if before > 0.0 { last / before } else { 0.0 };
    (1.0 / (1.0 - ratio.min(LARGEST_RATIO))) as f32
}

/// Nodes with less than this part of the brightest light under the same sun matter less. Under each sun light is as
/// near: an observer sees those about his own, which in twilight have a millionth of the light of the brightest.
const DARK: f64 = 0.01;

/// The orders that are taken together, at most, without the first of them: three leave a third of what two leave.
pub const LAST: usize = 3;

/// What stands for all orders after one.
#[derive(Clone)]
pub struct Closing<const N: usize> {
    /// How often each of the last orders counts, [`LAST`] and one before them at most; all earlier ones count once.
    pub factors: Vec<Lanes<N>>,
    /// The ratio of the last two.
    pub ratio: [f32; N],
    /// How far the sum may be off, relative to all light under a sun.
    pub error: f64,
}

impl<const N: usize> Closing<N> {
    /// From the mean radiances at all nodes of an order and of those after it, [`LAST`] at most, and those of the sum
    /// of all up to the first of them. The nodes are those of so many suns, altitude after altitude. Behind the mean
    /// radiances of an order may stand what falls off with them, of each node again.
    fn new(orders: &[Vec<Lanes<N>>], sum: &[Lanes<N>], suns: usize) -> Self {
        let after = orders.len() - 1;
        let mut closing = Self { factors: vec![Lanes([1.0; N]); after], ratio: [0.0; N], error: 0.0 };
        let at = |means: &[Lanes<N>], band: usize| -> Vec<f64> {
            means.iter().map(|mean| f64::from(mean.0[band])).collect()
        };
        for band in 0..N {
            let orders: Vec<Vec<f64>> = orders.iter().map(|order| at(order, band)).collect();
            let of_band = OfBand::new(&orders, &at(sum, band), suns);
            for (factors, factor) in closing.factors.iter_mut().zip(&of_band.factors) {
                factors.0[band] = *factor as f32;
            }
            closing.ratio[band] = of_band.ratio as f32;
            closing.error = closing.error.max(of_band.error);
        }
        closing
    }

    /// This, which is near enough, and that of one order less, which is not: all of the latter where it is off by the
    /// tolerance, none where by twice that, and never more than leaves the error of both within it.
    fn mixed_with(self, before: &Self, tolerance: f64) -> Self {
        let beyond = before.error - tolerance;
        let of_this = (beyond / tolerance).max(beyond / (before.error - self.error)).min(1.0);
        let of_other = (1.0 - of_this) as f32;
        // The last factors of the two are those of an order and the one before it.
        let joined = self.factors.len() - 1;
        let others = before.factors.iter().skip(before.factors.len() - joined).copied().chain([Lanes::ZERO]);
        let mix = |(this, other): (&Lanes<N>, Lanes<N>)| {
            let mut mixed = this.scaled(of_this as f32);
            mixed.add_scaled(&other, of_other);
            mixed
        };
        Self {
            factors: self.factors.iter().zip(others).map(mix).collect(),
            error: (of_this * self.error + (1.0 - of_this) * before.error).min(tolerance),
            ..self
        }
    }
}

/// The orders of a light field, taken one after the other: those that are summed, and the last few, which are closed.
pub struct Series<const N: usize> {
    /// Mean radiances at all nodes of the last that is in the sum and of those after it.
    means: Vec<Vec<Lanes<N>>>,
    /// Those of the sum.
    sum: Vec<Lanes<N>>,
    suns: usize,
    /// How far the sum of all may be off.
    tolerance: f64,
    /// What stood for the rest with one order less.
    before: Option<Closing<N>>,
}

impl<const N: usize> Series<N> {
    /// From the mean radiances of the first order at so many nodes of so many suns, altitude after altitude, and what
    /// falls off with them.
    pub fn new(first: Vec<Lanes<N>>, nodes: usize, suns: usize, tolerance: f64) -> Self {
        Self { sum: first[..nodes].to_vec(), means: vec![first], suns, tolerance, before: None }
    }

    /// Takes the next order; what stands for all after the sum, once two orders follow it. Where [`LAST`] follow it
    /// already, the first of them joins it.
    pub fn close(&mut self, next: Vec<Lanes<N>>) -> Option<Closing<N>> {
        let joins = self.means.len() > LAST;
        if joins {
            self.means.remove(0);
            self.sum.iter_mut().zip(&self.means[0]).for_each(|(sum, mean)| sum.add_scaled(mean, 1.0));
        }
        self.means.push(next);
        if self.means.len() < 3 {
            return None;
        }
        let mut closing = Closing::new(&self.means, &self.sum, self.suns);
        if joins {
            closing.factors.insert(0, Lanes([1.0; N]));
        }
        Some(match self.before.replace(closing.clone()) {
            Some(before) if closing.error <= self.tolerance => closing.mixed_with(&before, self.tolerance),
            _ => closing,
        })
    }
}

struct OfBand {
    factors: [f64; LAST],
    ratio: f64,
    error: f64,
}

impl OfBand {
    fn new(orders: &[Vec<f64>], sum: &[f64], suns: usize) -> Self {
        let after = orders.len() - 1;
        let total = |order: usize| orders[order][..sum.len()].iter().sum::<f64>();
        let before = total(after - 1);
        let ratio = if before > 0.0 { (total(after) / before).clamp(0.0, LARGEST_RATIO) } else { 0.0 };
        let left = 1.0 / (1.0 - ratio);
        let mut factors = [1.0; LAST];
        factors[after - 1] = left;
        let dark = dark(sum, suns);
        // What falls from an order to the next, and what the geometric series leaves of the first, relative to the
        // light at the node.
        let falls = |order: usize, node: usize| orders[order][node] - orders[order + 1][node];
        let residual = |factors: &[f64], node: usize| {
            let taken: f64 = (0..after).map(|order| factors[order] * falls(order, node)).sum();
            orders[0][node] - taken
        };
        let (mut products, mut target) = ([[0.0; LAST]; LAST], [0.0; LAST]);
        for node in (0..orders[0].len()).filter(|&node| dark[node % suns] > 0.0) {
            let square = sum[node % sum.len()].max(dark[node % suns]).powi(-2);
            let rest = residual(&factors, node);
            for i in 0..after {
                target[i] += falls(i, node) * rest * square;
                (0..after).for_each(|j| products[i][j] += falls(i, node) * falls(j, node) * square);
            }
        }
        let change = least(products, target, after);
        factors.iter_mut().zip(change).for_each(|(factor, change)| *factor += change);
        let off = |node: usize| {
            let light: f64 = sum[node] + (0..after).map(|order| factors[order] * orders[order + 1][node]).sum::<f64>();
            let dark = dark[node % suns];
            if dark > 0.0 { residual(&factors, node).abs() * ratio * left / light.max(dark) } else { 0.0 }
        };
        Self { factors, ratio, error: (0..sum.len()).map(off).fold(0.0, f64::max) }
    }
}

/// For each sun a part, [`DARK`], of the brightest light under it.
pub(crate) fn dark(sum: &[f64], suns: usize) -> Vec<f64> {
    let brightest = |sun: usize| sum.iter().skip(sun).step_by(suns).copied().fold(0.0, f64::max);
    (0..suns).map(|sun| DARK * brightest(sun)).collect()
}

/// The solution of `count` normal equations whose diagonal is a little larger; none where they tell nothing.
fn least(mut products: [[f64; LAST]; LAST], mut target: [f64; LAST], count: usize) -> [f64; LAST] {
    (0..count).for_each(|i| products[i][i] *= 1.0 + TOWARDS_GEOMETRIC);
    for column in 0..count {
        if products[column][column] <= 0.0 {
            return [0.0; LAST];
        }
        for row in column + 1..count {
            let part = products[row][column] / products[column][column];
            (column..count).for_each(|i| products[row][i] -= part * products[column][i]);
            target[row] -= part * target[column];
        }
    }
    let mut solution = [0.0; LAST];
    for row in (0..count).rev() {
        let known: f64 = (row + 1..count).map(|i| products[row][i] * solution[i]).sum();
        solution[row] = (target[row] - known) / products[row][row];
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orders of an operator with these eigenvalues, from a first order, at nodes that mix its parts.
    fn orders(eigenvalues: &[f64], count: i32) -> (Vec<Vec<f64>>, Vec<f64>) {
        let part = |i: u32, k: usize| 0.3f64.powi(k as i32) * (f64::from(i) * 0.2 * k as f64).cos();
        let sum = |i: u32, of: &dyn Fn(f64) -> f64| -> f64 {
            eigenvalues.iter().enumerate().map(|(k, &value)| part(i, k) * of(value)).sum()
        };
        let order = |n: i32| (0..20).map(|i| sum(i, &|value| value.powi(n))).collect();
        ((0..count).map(order).collect(), (0..20).map(|i| sum(i, &|value| 1.0 / (1.0 - value))).collect())
    }

    fn worst(eigenvalues: &[f64], count: i32) -> (f64, f64) {
        let (orders, all) = orders(eigenvalues, count);
        let closing = OfBand::new(&orders, &orders[0], 1);
        let sum = |i: usize| {
            orders[0][i] + orders[1..].iter().zip(closing.factors).map(|(order, factor)| factor * order[i]).sum::<f64>()
        };
        let off = (0..20).map(|i| (sum(i) / all[i] - 1.0).abs()).fold(0.0, f64::max);
        (off, closing.error)
    }

    #[test]
    fn a_geometric_series_is_summed_exactly() {
        for count in [3, 4] {
            let (off, error) = worst(&[0.6], count);
            assert!(off < 1e-9 && error < 1e-9, "{count} orders: {off:e}, {error:e}");
        }
    }

    #[test]
    fn as_many_series_as_orders_are_summed_within_the_error_that_is_told() {
        let two: [&[f64]; 3] = [&[0.5, 0.2], &[0.8, 0.4], &[0.3, -0.1]];
        let three: [&[f64]; 2] = [&[0.5, 0.2, 0.05], &[0.8, 0.4, 0.1]];
        for (count, eigenvalues) in two.map(|two| (3, two)).into_iter().chain(three.map(|three| (4, three))) {
            let (off, error) = worst(eigenvalues, count);
            // The ridge leaves 1e-4 of a small difference; the error is told from the residual and the larger
            // eigenvalue.
            assert!(off < 2e-3 && off <= 1.5 * error + 1e-6, "{eigenvalues:?}: {off:e}, told {error:e}");
        }
    }

    #[test]
    fn another_order_leaves_less() {
        let series = [0.7, 0.3, 0.1];
        assert!(worst(&series, 4).0 < 0.5 * worst(&series, 3).0);
    }

    /// How many orders are taken until the rest is near enough, and the sum of all at a node; without mixing that of
    /// the last closing.
    fn taken(largest: f64, mixes: bool) -> (usize, f64) {
        let (orders, _) = orders(&[largest, 0.9 * largest, 0.6 * largest, -0.5 * largest, 0.3, 0.2], 40);
        let lanes = |order: &[f64]| -> Vec<Lanes<1>> { order.iter().map(|&mean| Lanes([mean as f32])).collect() };
        let mut series = Series::new(lanes(&orders[0]), 20, 1, TOLERANCE);
        for n in 1..orders.len() {
            let closing = series.close(lanes(&orders[n])).filter(|closing| closing.error <= TOLERANCE);
            if let Some(closing) = closing {
                let closing = if mixes { closing } else { series.before.unwrap() };
                let last = n + 1 - closing.factors.len();
                let factor =
                    |order: usize| order.checked_sub(last).map_or(1.0, |at| f64::from(closing.factors[at].0[0]));
                return (n, (0..=n).map(|order| factor(order) * orders[order][7]).sum());
            }
        }
        panic!("no end of orders");
    }

    const TOLERANCE: f64 = 1e-3;

    #[test]
    fn no_sum_jumps_where_one_order_more_is_taken() {
        let walk = |mixes: bool| -> Vec<(usize, f64)> {
            (0..400).map(|step| taken(0.3 + 0.001 * f64::from(step), mixes)).collect()
        };
        let jump = |sums: Vec<(usize, f64)>| {
            let change = |four: &[(usize, f64)], i: usize| four[i + 1].1 - four[i].1;
            let jumps = sums.windows(4).map(|f| (change(f, 1) - 0.5 * (change(f, 0) + change(f, 2))).abs() / f[1].1);
            jumps.fold(0.0, f64::max)
        };
        let sums = walk(true);
        assert!(sums[0].0 + 2 < sums[399].0, "{:?}, {:?}", sums[0], sums[399]);
        let (mixed, alone) = (jump(sums), jump(walk(false)));
        // A step of the largest eigenvalue by 0.001 may move the mixture by a tenth of the tolerance.
        assert!(mixed < 0.1 * TOLERANCE && alone > 0.3 * TOLERANCE, "{mixed:e}, {alone:e}");
    }

    #[test]
    fn under_a_dark_sun_light_is_as_near() {
        // Two suns, one with a millionth of the other's light and orders that fall off more slowly.
        let (bright, dim) = (orders(&[0.3, 0.1], 3), orders(&[0.7, 0.4], 3));
        let both: Vec<Vec<f64>> = (0..3)
            .map(|n| bright.0[n].iter().zip(&dim.0[n]).flat_map(|(bright, dim)| [*bright, 1e-6 * dim]).collect())
            .collect();
        let told = |suns: usize| OfBand::new(&both, &both[0], suns).error;
        // As one sun, the negative control, nothing of the dark one counts.
        assert!(told(2) > 0.01 && told(1) < 0.1 * told(2), "{:e}, {:e}", told(2), told(1));
    }

    #[test]
    fn the_negative_control_is_off() {
        let (orders, all) = orders(&[0.8, 0.4], 3);
        let without: f64 = orders.iter().map(|order| order[0]).sum();
        assert!((without / all[0] - 1.0).abs() > 0.3);
    }
}
