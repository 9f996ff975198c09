//! Means of tables over what a node of the observer's sum, or a band, stands for.
//!
//! The sum over the nodes, `Σ f(λ_i) Δλ`, is the integral of the straight lines between them. A factor of `f` that
//! varies between the nodes, such as the sun's spectrum by its lines, therefore counts with its mean under the hat of a
//! node, which falls to zero at the next ones:
//!
//! ```text
//! v_i = ∫ h(λ - λ_i) w(λ) v(λ) dλ / ∫ h(λ - λ_i) w(λ) dλ,   h(x) = max(0, 1 - |x|/Δλ)
//! ```
//!
//! The value of a band is the same mean with an `h` of 1 within it.
//!
//! `w` is what lights `v`: where both vary, the mean of their product is the product of these means.

use super::range::{MEASURED_RANGE, STEP};
use super::table::Table;

/// What a value stands for.
#[derive(Clone, Copy, Debug)]
pub enum Window {
    /// A node of a sum, from whose wavelength the next ones are so far away (nm): the hat `h`.
    Node(f64),
    /// A band so wide (nm) about its wavelength.
    Band(f64),
}

impl Window {
    /// A node of the observer's sum.
    pub const STEP: Self = Self::Node(STEP);

    /// The middles of stretches of at most a nanometre of it about a wavelength (nm), with their weights.
    pub(crate) fn nodes(self, nm: f64) -> Vec<(f64, f64)> {
        let reach = self.reach();
        let count = (2.0 * reach).ceil().max(1.0);
        let offset = |i: u32| 2.0 * reach * ((f64::from(i) + 0.5) / count - 0.5);
        (0..count as u32).map(offset).map(|offset| (nm + offset, self.weight(offset.abs()))).collect()
    }

    /// How far it reaches (nm).
    fn reach(self) -> f64 {
        match self {
            Self::Node(step) => step,
            Self::Band(width) => 0.5 * width,
        }
    }

    /// Its weight so far from its wavelength (nm), within its reach.
    fn weight(self, distance: f64) -> f64 {
        match self {
            Self::Node(step) => 1.0 - distance / step,
            Self::Band(_) => 1.0,
        }
    }
}

/// A table of means at every nanometre of [`MEASURED_RANGE`] that a table holds, weighed by another; straight between
/// them.
pub fn over(window: Window, of: &Table<1>, weighed_by: Option<&Table<1>>) -> Table<1> {
    let (first, last) = of.range();
    let (first, last) = (first.max(MEASURED_RANGE.0), last.min(MEASURED_RANGE.1));
    let whole = (first.floor() as u32 + 1..last.ceil() as u32).map(f64::from);
    let at = [first].into_iter().chain(whole).chain([last]);
    let mut knots: Vec<f64> =
        of.wavelengths().iter().chain(weighed_by.map_or(&[][..], Table::wavelengths)).copied().collect();
    knots.sort_by(f64::total_cmp);
    let value = |nm: f64| of.at(nm)[0];
    let weight = |nm: f64| weighed_by.map_or(1.0, |table| table.at(nm)[0]);
    let mean = |nm: f64| {
        let integral = |f: &dyn Fn(f64) -> f64| under(window, nm, of.range(), &knots, f);
        match integral(&weight) {
            // What nothing lights is not seen, whatever it is.
            0.0 => integral(&value) / integral(&|_| 1.0),
            light => integral(&|nm| weight(nm) * value(nm)) / light,
        }
    };
    Table::of(at.map(|nm| (nm, [mean(nm)])))
}

/// Integral of a function times the weight of a window at a wavelength (nm), within a range; exact if the function is a
/// product of two that are straight between knots (nm, in order).
fn under(window: Window, nm: f64, (first, last): (f64, f64), knots: &[f64], f: &dyn Fn(f64) -> f64) -> f64 {
    let (low, high) = ((nm - window.reach()).max(first), (nm + window.reach()).min(last));
    let within = &knots[knots.partition_point(|&knot| knot <= low)..knots.partition_point(|&knot| knot < high)];
    let centre = within.partition_point(|&knot| knot < nm);
    let product = |x: f64| f(x) * window.weight((x - nm).abs());
    let edges = [low].into_iter().chain(within[..centre].iter().copied()).chain([nm]);
    let edges = edges.chain(within[centre..].iter().copied()).chain([high]);
    let mut sum = 0.0;
    let mut before = low;
    for edge in edges {
        // Simpson's rule, which is exact for cubics.
        let middle = 0.5 * (before + edge);
        sum += (edge - before) / 6.0 * (product(before) + 4.0 * product(middle) + product(edge));
        before = edge;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(value: impl Fn(f64) -> f64) -> Table<1> {
        Table::of((0..=4500).map(|i| 360.0 + 0.1 * f64::from(i)).map(|nm| (nm, [value(nm)])))
    }

    #[test]
    fn what_is_straight_is_its_own_mean() {
        let line = table(|nm| 3.0 + 0.01 * nm);
        let means = over(Window::STEP, &line, None);
        for nm in [365.0, 432.5, 600.0, 805.0] {
            assert!((means.at(nm)[0] / line.at(nm)[0] - 1.0).abs() < 1e-12, "{nm} nm");
        }
        assert_eq!(means.range(), (360.0, 810.0));
    }

    #[test]
    fn peaks_count_alike_wherever_they_lie() {
        for shift in [0.0, 1.0, 2.0, 3.3] {
            // A peak of a nanometre in each five, of mean 1.
            let peaks = table(|nm| if (nm + shift).rem_euclid(5.0) < 0.95 { 5.0 } else { 0.0 });
            let means = over(Window::STEP, &peaks, None);
            for nm in [400.0, 555.0, 700.0] {
                // The edges of the peaks are a tenth of a nanometre wide.
                assert!((means.at(nm)[0] - 1.0).abs() < 1e-2, "{shift} at {nm} nm: {}", means.at(nm)[0]);
            }
        }
    }

    #[test]
    fn what_shines_where_nothing_reflects_gives_no_light() {
        let even = table(|nm| if nm.rem_euclid(2.0) < 1.0 { 1.0 } else { 0.0 });
        let odd = table(|nm| if nm.rem_euclid(2.0) < 1.0 { 0.0 } else { 1.0 });
        // A tenth of a nanometre of every one is an edge.
        assert!(over(Window::STEP, &even, Some(&odd)).at(550.0)[0] < 0.05);
        assert!(over(Window::STEP, &even, Some(&even)).at(550.0)[0] > 0.95);
        assert!((over(Window::STEP, &even, None).at(550.0)[0] - 0.5).abs() < 0.03);
    }
}
