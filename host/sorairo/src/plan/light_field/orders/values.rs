//! The moments of a light field at the nodes of a table.

use sorairo_shared::light_field::moments::Moments;
use sorairo_shared::light_field::polarisation;
use sorairo_shared::light_field::table::{MomentTable, TILE, suns_of_tile, wavelengths_of_tile};
use sorairo_shared::value::{Lanes, Value};

use crate::plan::light_field::grid::Grid;
use crate::plan::light_field::orders::series::geometric_factor;
use crate::plan::light_field::setting::Couplings;

/// Moments of a light field at the nodes of a grid, and the irradiance of the ground.
#[derive(Clone)]
pub struct Values<const N: usize> {
    /// Which moments.
    pub(crate) of: Moments,
    /// The moments of each altitude and sun.
    pub(crate) values: Vec<Lanes<N>>,
    /// Those of polarised light, [`polarisation::MOMENTS`] of each; none where light is taken as natural.
    pub(crate) polarised: Vec<Lanes<N>>,
    /// Irradiance of the ground under each sun.
    pub(crate) irradiance: Vec<Lanes<N>>,
}

/// Moments at the nodes of a grid, tile after tile of the wavelengths.
pub struct Tiles {
    /// Which moments.
    pub(crate) of: Moments,
    values: Vec<f32>,
    altitudes: usize,
    couplings: Option<Couplings>,
}

impl Tiles {
    /// As the gathering takes them.
    pub fn table<'a>(&'a self, grid: &'a Grid, logarithmic: bool) -> MomentTable<'a> {
        let Self { of, values, altitudes, couplings } = self;
        MomentTable {
            moments: *of,
            couplings: *couplings,
            values,
            altitudes: *altitudes,
            suns: grid.sun_angles.axis(),
            logarithmic,
        }
    }
}

impl<const N: usize> Values<N> {
    /// Those of the moments, as the gathering takes them, that are among `of`; and those of polarised light.
    pub(crate) fn tiles(&self, grid: &Grid, of: Moments, couplings: Option<Couplings>) -> Tiles {
        let of = Moments { degree: of.degree.min(self.of.degree), azimuthal: of.azimuthal.min(self.of.azimuthal) };
        let (lanes, together) = (wavelengths_of_tile::<N>(), suns_of_tile::<N>());
        let taken: Vec<usize> =
            (0..=of.azimuthal).flat_map(|m| self.of.first(m)..=self.of.first(m) + of.degree - m).collect();
        let (altitudes, suns) = (grid.altitudes.len(), grid.suns.len());
        let of_node = of.count() + if self.polarised.is_empty() { 0 } else { polarisation::MOMENTS };
        let mut values = Vec::with_capacity(altitudes * suns.next_multiple_of(together) * of_node * N);
        for tile in 0..N / lanes {
            for altitude in 0..altitudes {
                let at_altitude = |of_all: &[Lanes<N>]| {
                    let count = of_all.len() / altitudes;
                    altitude * count..(altitude + 1) * count
                };
                let radiance = &self.values[at_altitude(&self.values)];
                let polarised = &self.polarised[at_altitude(&self.polarised)];
                for first in (0..suns).step_by(together) {
                    for (of_all, count, taken) in
                        [(radiance, self.of.count(), &taken[..]), (polarised, polarisation::MOMENTS, &[0, 1, 2])]
                    {
                        let group = of_all.chunks_exact(count).skip(first).take(together);
                        for &at in taken.iter().filter(|_| !of_all.is_empty()) {
                            group.clone().for_each(|of_sun| {
                                values.extend_from_slice(&of_sun[at].0[tile * lanes..][..lanes]);
                            });
                            // Where suns do not fill a tile, the rest of it is dark.
                            values.resize(values.len().next_multiple_of(TILE), 0.0);
                        }
                    }
                }
            }
        }
        Tiles { of, values, altitudes, couplings }
    }

    /// The mean radiances, `l = 0`, at all nodes.
    pub(crate) fn means(&self) -> Vec<Lanes<N>> {
        self.values.iter().step_by(self.of.count()).copied().collect()
    }

    /// The same, and behind them `E_20`, which mixes with them from order to order.
    pub(crate) fn falling_together(&self) -> Vec<Lanes<N>> {
        let polarised = self.polarised.iter().step_by(polarisation::MOMENTS);
        self.means().into_iter().chain(polarised.copied()).collect()
    }

    /// Adds the moments of polarised light of the last orders and of all that follow: of what is the same all around
    /// with the factors of radiance, with which it mixes. Other azimuthal numbers fall off by themselves, and faster:
    /// the geometric series of each stands for what follows.
    pub(crate) fn close_polarised(&mut self, last: &[Self], of_radiance: &[Lanes<N>]) {
        let size = |order: &Self, m: usize, lane: usize| {
            let of_m = order.polarised.iter().skip(m).step_by(polarisation::MOMENTS);
            of_m.map(|moment| f64::from(moment.0[lane].abs())).sum::<f64>()
        };
        for (number, order) in last.iter().enumerate() {
            let factors: [Lanes<N>; polarisation::MOMENTS] = std::array::from_fn(|m| {
                if m == 0 {
                    return of_radiance[number];
                }
                Lanes(std::array::from_fn(|lane| {
                    if number + 1 < last.len() || number == 0 {
                        return 1.0;
                    }
                    geometric_factor(size(&last[number - 1], m, lane), size(order, m, lane))
                }))
            });
            let moments = self.polarised.iter_mut().zip(&order.polarised);
            for (i, (to, from)) in moments.enumerate() {
                to.add_product(from, &factors[i % polarisation::MOMENTS]);
            }
        }
    }

    /// Adds another light field, times a factor at each band, as far as both have the same moments.
    pub(crate) fn add(&mut self, other: &Self, factor: Lanes<N>) {
        self.add_radiance(other, factor);
        let polarised = self.polarised.iter_mut().zip(&other.polarised);
        polarised.for_each(|(to, from)| to.add_product(from, &factor));
    }

    /// The same without the moments of polarised light.
    pub(crate) fn add_radiance(&mut self, other: &Self, factor: Lanes<N>) {
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
