//! Memory in which light is gathered along one ray after the other.

use sorairo_shared::light_field::gather::{Scratch, scratch_sizes};
use sorairo_shared::light_field::table::MomentTable;

/// Room in which light is gathered along one ray after the other.
pub struct Room {
    sums: Vec<f32>,
    sources: Vec<f32>,
    logarithms: Vec<f32>,
    scales: Vec<f32>,
    light: Vec<f32>,
}

impl Room {
    /// For a table of `N` wavelengths and so many sights.
    pub fn new<const N: usize>(table: &MomentTable, sights: usize) -> Self {
        let [sums, sources, logarithms, scales, light] =
            scratch_sizes::<N>(table.suns.count, table.moments, table.polarised(), sights).map(|size| vec![0.0; size]);
        Self { sums, sources, logarithms, scales, light }
    }

    /// As the gathering takes it.
    pub fn scratch(&mut self) -> Scratch<'_> {
        let Self { sums, sources, logarithms, scales, light } = self;
        Scratch { sums, sources, logarithms, scales, light }
    }
}
