//! How a light field was made, and how far it may be off.

use crate::plan::light_field::grid::Grid;
use crate::plan::light_field::orders::series::Closing;
use crate::plan::light_field::resolution::Resolution;

/// How a light field was made.
#[derive(Clone, Debug, Default)]
pub struct OrdersMade {
    /// Orders that were computed.
    pub computed: u32,
    /// The ratio of the last two at each band of the first group; none where so many were asked for.
    pub ratio: [f32; 4],
    /// How far the sum of all orders may be off, relative to all light.
    pub error: f64,
    /// How far the resolution may be off; see [`Resolution::leaves`].
    pub leaves: f64,
    /// Whether what remains of the orders is that of a plane atmosphere.
    pub thick: bool,
    /// How far it should be off at most; see [`Resolution::tolerance`].
    pub tolerance: f64,
    /// What moments of a higher degree would add; see [`Resolution::beyond_degree`].
    pub beyond_degree: f64,
    /// The highest degree of its moments.
    pub degree: usize,
    /// Altitudes and suns at which it is known.
    pub nodes: [usize; 2],
}

impl OrdersMade {
    /// Of the first order alone.
    pub(crate) fn of(resolution: &Resolution, grid: &Grid) -> Self {
        Self {
            computed: 1,
            degree: resolution.first.degree,
            tolerance: resolution.tolerance,
            leaves: resolution.leaves,
            thick: resolution.plane,
            beyond_degree: resolution.beyond_degree,
            nodes: [grid.altitudes.len(), grid.suns.len()],
            ..Self::default()
        }
    }

    /// How far the light may be off, relative to all of it: by its orders and by its resolution.
    pub fn told(&self) -> f64 {
        self.error + self.leaves
    }

    /// Takes what stands for the rest; whether it is near enough, or as near as it gets.
    pub(crate) fn is_closed_by<const N: usize>(&mut self, closing: &Closing<N>) -> bool {
        self.error = closing.error;
        self.ratio = std::array::from_fn(|i| closing.ratio[i]);
        self.error <= self.tolerance || self.computed == MOST
    }
}

/// The most orders that are computed before what is left is taken as it is.
pub(crate) const MOST: u32 = 24;
