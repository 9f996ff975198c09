//! The moments of a light field at the nodes of a table.

use sorairo_shared::light_field::moments::Moments;
use sorairo_shared::light_field::table::{MomentTable, TILE, suns_of_tile, wavelengths_of_tile};
use sorairo_shared::value::{Lanes, Value};

use crate::plan::light_field::grid::Grid;

/// Moments of a light field at the nodes of a grid, and the irradiance of the ground.
#[derive(Clone)]
pub struct Values<const N: usize> {
    /// Which moments.
    pub(crate) of: Moments,
    /// The moments of each altitude and sun.
    pub(crate) values: Vec<Lanes<N>>,
    /// Irradiance of the ground under each sun.
    pub(crate) irradiance: Vec<Lanes<N>>,
}

/// Moments at the nodes of a grid, tile after tile of the wavelengths.
pub struct Tiles {
    /// Which moments.
    pub(crate) of: Moments,
    values: Vec<f32>,
    altitudes: usize,
}

impl Tiles {
    /// As the gathering takes them.
    pub fn table<'a>(&'a self, grid: &'a Grid, logarithmic: bool) -> MomentTable<'a> {
        let Self { of, values, altitudes } = self;
        MomentTable { moments: *of, values, altitudes: *altitudes, suns: grid.sun_angles.axis(), logarithmic }
    }
}

impl<const N: usize> Values<N> {
    /// Those of the moments, as the gathering takes them, that are among `of`.
    pub(crate) fn tiles(&self, grid: &Grid, of: Moments) -> Tiles {
        let of = Moments { degree: of.degree.min(self.of.degree), azimuthal: of.azimuthal.min(self.of.azimuthal) };
        let (lanes, together) = (wavelengths_of_tile::<N>(), suns_of_tile::<N>());
        let taken: Vec<usize> =
            (0..=of.azimuthal).flat_map(|m| self.of.first(m)..=self.of.first(m) + of.degree - m).collect();
        let (altitudes, suns) = (grid.altitudes.len(), grid.suns.len());
        let mut values = Vec::with_capacity(altitudes * suns.next_multiple_of(together) * of.count() * N);
        for tile in 0..N / lanes {
            for suns in self.values.chunks_exact(suns * self.of.count()) {
                for group in suns.chunks(together * self.of.count()) {
                    for &at in &taken {
                        let moment = group.iter().skip(at).step_by(self.of.count());
                        moment.for_each(|values_of| values.extend_from_slice(&values_of.0[tile * lanes..][..lanes]));
                        // Where suns do not fill a tile, the rest of it is dark.
                        values.resize(values.len().next_multiple_of(TILE), 0.0);
                    }
                }
            }
        }
        Tiles { of, values, altitudes: grid.altitudes.len() }
    }

    /// The mean radiances, `l = 0`, at all nodes.
    pub(crate) fn means(&self) -> Vec<Lanes<N>> {
        self.values.iter().step_by(self.of.count()).copied().collect()
    }

    /// Adds another light field, times a factor at each band, as far as both have the same moments.
    pub(crate) fn add(&mut self, other: &Self, factor: Lanes<N>) {
        let degree = self.of.degree.min(other.of.degree);
        for (to, from) in self.values.chunks_mut(self.of.count()).zip(other.values.chunks(other.of.count())) {
            for m in 0..=self.of.azimuthal.min(other.of.azimuthal).min(degree) {
                let count = degree + 1 - m;
                let from = &from[other.of.first(m)..][..count];
                to[self.of.first(m)..].iter_mut().zip(from).for_each(|(to, from)| to.add_product(from, &factor));
            }
        }
        self.irradiance.iter_mut().zip(&other.irradiance).for_each(|(to, from)| to.add_product(from, &factor));
    }
}
