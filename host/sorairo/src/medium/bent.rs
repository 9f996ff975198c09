//! Rays that air bends, by quadrature over a profile.
//!
//! A ray whose zenith angle is `z` at a radius `r` keeps `p = n r sin z` (Bouguer's law) with the refractive index `n`.
//! Over an altitude `dz` it crosses `ds = n r / √((n r)² - p²) dz`. Its bending is
//! `δ = -∫ (dn/dz) / n · p / √((n r)² - p²) dz`. Straight rays are those of `n = 1`.

use std::f64::consts::{FRAC_PI_2, PI};

use rayon::prelude::*;
use sorairo_shared::medium::tables::{ALTITUDES, SUNS};

use super::aerosol::Lane;
use super::gases::{CLASSES, Gases};
use super::profile::{Density, Levels, Profile};

/// What the tables of an air depend on.
#[derive(Clone, Debug, PartialEq)]
pub struct Air {
    /// The profile of air and ozone; one that is measured.
    pub profile: Profile,
    /// Radius of the ground (km).
    pub ground_radius: f64,
    /// Height of the top of the atmosphere above the ground (km).
    pub depth: f64,
    /// Altitude of the ground in the profile (km).
    pub site: f64,
    /// Vertical column densities (km) of air over the sea and of ozone over the ground, to which the relative densities
    /// are scaled.
    pub columns: [f64; 2],
    /// Where aerosol lies.
    pub aerosol: Lane,
    /// `n - 1` at the sea; 0 for straight sunlight.
    pub refractivity: f64,
}

/// `n - 1` of air at 550 nm, 15 °C and 1013.25 hPa (Ciddor 1996, <https://doi.org/10.1364/AO.35.001566>), and the
/// molecules per cm³ that it has there.
const REFRACTIVITY: f64 = 2.778e-4;
const OF_DENSITY: f64 = 2.547e19;

/// `n - 1` of a profile on the ground at a pressure relative to the profile's own.
pub fn refractivity(profile: &Profile, pressure: f64) -> f64 {
    profile.levels().map_or(0.0, |levels| REFRACTIVITY * levels.at(0.0).value[0] / OF_DENSITY * pressure)
}

/// Panels of a column's quadrature, each with three nodes of Gauss-Legendre.
const PANELS: usize = 40;
const NODES: usize = 3 * PANELS;

/// How far above the top of the atmosphere columns reach (km): a ray that grazes the top ends as smoothly there as the
/// profile does.
const ABOVE_TOP: f64 = 20.0;

/// Air, aerosol, ozone, pairs of oxygen and water vapour, in this order.
pub(super) const CONSTITUENTS: usize = 5;

/// The densities of an air, relative to those whose columns it shall have.
#[derive(Debug)]
pub(super) struct Layers {
    pub(super) air: Air,
    levels: Levels,
    gases: Gases,
    /// What densities of the levels are multiplied with.
    scale: [f64; CONSTITUENTS],
    /// The density of air at the sea.
    ground: f64,
    /// Places on [0, 1] and weights.
    rule: [[f64; 2]; NODES],
}

/// A node of the quadrature over altitude.
struct Node {
    /// Height above the row (km).
    above: f64,
    densities: [f64; CONSTITUENTS],
    straight: Step,
    bent: Step,
    /// `-dn/dz / n` times the height that it stands for.
    bend: f64,
}

/// A node as a ray crosses it.
struct Step {
    /// `(n r)²` less that of the row (km²), without the difference of what is almost alike.
    square: f64,
    /// `n r` times the height that it stands for (km²).
    length: f64,
}

/// An altitude from which rays go outwards.
pub(super) struct Row {
    pub(super) radius: f64,
    pub(super) index: f64,
    pub(super) densities: [f64; CONSTITUENTS],
    nodes: [Node; NODES],
}

/// What a ray crosses up to space: column densities (km) and its bending (radians).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Crossed {
    pub(super) along: [f64; CONSTITUENTS],
    pub(super) bending: f64,
}

impl Layers {
    pub(super) fn new(air: Air) -> Self {
        const MEASURED: &str = "tables are those of a measured profile";
        let levels = air.profile.levels().expect(MEASURED);
        let gases = Gases::of(air.profile.measured().expect(MEASURED));
        let outer = 0.5 - 0.15f64.sqrt();
        let of_panel = [(outer, 5.0 / 18.0), (0.5, 8.0 / 18.0), (1.0 - outer, 5.0 / 18.0)];
        let rule = std::array::from_fn(|node| {
            let (place, weight) = of_panel[node % 3];
            [((node / 3) as f64 + place) / PANELS as f64, weight / PANELS as f64]
        });
        let ground = levels.at(0.0).value[0];
        let layers = Self { air, levels, gases, scale: [1.0; CONSTITUENTS], ground, rule };
        let [[_, of_aerosol, of_ozone, of_pairs, of_water]] = layers.row(0.0).straight([1.0]);
        let [[of_air, ..]] = layers.row(-layers.air.site).straight([1.0]);
        let [column, ozone] = layers.air.columns;
        let aerosol = &layers.air.aerosol;
        // The edges of layers fall between the nodes of the quadrature.
        let of_layers = if aerosol.is_exponential() { 1.0 } else { aerosol.scale_height / of_aerosol };
        Self { scale: [column / of_air, of_layers, ozone / of_ozone, 1.0 / of_pairs, 1.0 / of_water], ..layers }
    }

    pub(super) fn altitude(&self, i: usize) -> f64 {
        self.air.depth * part(i, ALTITUDES).powi(2)
    }

    /// Relative densities at an altitude (km), of gases per km of the columns over the ground.
    fn densities(&self, altitude: f64) -> [f64; CONSTITUENTS] {
        self.relative(self.level(altitude), altitude)
    }

    /// The densities of the profile at an altitude above the ground (km).
    fn level(&self, altitude: f64) -> Density {
        self.levels.at(altitude + self.air.site)
    }

    fn relative(&self, density: Density, altitude: f64) -> [f64; CONSTITUENTS] {
        let [air, ozone] = density.value;
        let [pairs, water] = self.gases.pairs_and_water(altitude + self.air.site);
        let values = [air, self.air.aerosol.density(altitude), ozone, pairs, water];
        std::array::from_fn(|i| self.scale[i] * values[i])
    }

    /// `n - 1` where air has this density.
    fn excess(&self, density: Density) -> f64 {
        self.air.refractivity * density.value[0] / self.ground
    }

    /// What rays from an altitude (km) outwards cross.
    pub(super) fn row(&self, altitude: f64) -> Row {
        let height = (self.air.depth + ABOVE_TOP - altitude).sqrt();
        let radius = self.air.ground_radius + altitude;
        let index = 1.0 + self.excess(self.level(altitude));
        let node = |[place, weight]: [f64; 2]| {
            let u = place * height;
            let (above, weight) = (u * u, 2.0 * u * weight * height);
            let density = self.level(altitude + above);
            let excess = self.excess(density);
            let step = |start: f64, here: f64| Step { square: (here - start) * (here + start), length: weight * here };
            Node {
                above,
                densities: self.relative(density, altitude + above),
                straight: step(radius, radius + above),
                bent: step(index * radius, (1.0 + excess) * (radius + above)),
                bend: -weight * excess * density.growth[0] / (1.0 + excess),
            }
        };
        Row { radius, index, densities: self.densities(altitude), nodes: self.rule.map(node) }
    }
}

impl Row {
    /// Column densities (km) along straight rays with the cosines `mu >= 0` of the zenith angle.
    pub(super) fn straight<const N: usize>(&self, mu: [f64; N]) -> [[f64; CONSTITUENTS]; N] {
        let squares = mu.map(|mu| (self.radius * mu).powi(2));
        let mut along = [[0.0; N]; CONSTITUENTS];
        for Node { densities, straight, .. } in &self.nodes {
            add_to_each(&mut along, densities, &straight.lengths(&squares));
        }
        std::array::from_fn(|i| along.map(|column| column[i]))
    }

    /// What bent rays outwards cross that have the cosines `mu >= 0` of the zenith angle here.
    pub(super) fn outwards<const N: usize>(&self, mu: [f64; N]) -> [Crossed; N] {
        let start = self.index * self.radius;
        let squares = mu.map(|mu| (start * mu).powi(2));
        let (mut along, mut bending) = ([[0.0; N]; CONSTITUENTS], [[0.0; N]]);
        for Node { densities, bent, bend, .. } in &self.nodes {
            let lengths = bent.lengths(&squares);
            add_to_each(&mut along, densities, &lengths);
            add_to_each(&mut bending, &[bend / bent.length], &lengths);
        }
        let invariant = |i: usize| start * (1.0 - mu[i] * mu[i]).sqrt();
        std::array::from_fn(|i| Crossed { along: along.map(|column| column[i]), bending: bending[0][i] * invariant(i) })
    }

    /// What absorbs on such a ray.
    pub(super) fn gases(&self, layers: &Layers, mu: f64) -> [f64; CLASSES] {
        let altitude = self.radius - layers.air.ground_radius + layers.air.site;
        let square = (self.index * self.radius * mu).powi(2);
        let mut along = [0.0; CLASSES];
        for Node { above, bent, .. } in &self.nodes {
            let [length] = bent.lengths(&[square]);
            along.iter_mut().zip(layers.gases.at(altitude + above)).for_each(|(sum, value)| *sum += value * length);
        }
        along
    }
}

impl Step {
    /// The lengths (km) of rays through it, by the squares of what `n r cos z` is on the row.
    fn lengths<const N: usize>(&self, squares: &[f64; N]) -> [f64; N] {
        // Of rays side by side, which a processor computes together.
        squares.map(|square| self.length / (self.square + square).max(1e-12).sqrt())
    }
}

/// Adds values times the length of each ray.
fn add_to_each<const N: usize, const C: usize>(sums: &mut [[f64; N]; C], values: &[f64; C], lengths: &[f64; N]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        sum.iter_mut().zip(lengths).for_each(|(sum, length)| *sum += value * length);
    }
}

/// Altitudes of level rays.
const LEVEL_RAYS: usize = 288;

/// Rays from an altitude, by the zenith angle at which the sun is seen: a multiple of [`LANES`].
const SEEN_SUNS: usize = 160;

/// Rays that are computed side by side; the view rays of a row are a multiple of it too.
pub(super) const LANES: usize = 8;

/// Level rays from every altitude, one of which each ray becomes that comes down and goes up again.
#[derive(Debug)]
pub(super) struct LevelRays {
    /// `n r` (km), increasing.
    products: Vec<f64>,
    crossed: Vec<Crossed>,
}

/// The sun from an altitude.
#[derive(Clone, Copy)]
pub(super) struct SeenSun {
    /// Zenith angle at which it is seen (radians).
    pub(super) seen: f64,
    pub(super) along: [f64; CONSTITUENTS],
    /// See [`sorairo_shared::medium::tables`].
    pub(super) spread: f64,
}

impl LevelRays {
    pub(super) fn new(layers: &Layers) -> Self {
        let altitudes = (0..LEVEL_RAYS).map(|i| layers.air.depth * part(i, LEVEL_RAYS).powi(2));
        let of_altitude = |altitude: f64| {
            let row = layers.row(altitude);
            (row.index * row.radius, row.outwards([0.0])[0])
        };
        let (products, crossed) = altitudes.collect::<Vec<_>>().into_par_iter().map(of_altitude).unzip();
        Self { products, crossed }
    }

    /// The level ray above one whose `n r` is this (km), and how much it weighs beside that below.
    fn place(&self, product: f64) -> (usize, f64) {
        let after = self.products.partition_point(|&level| level <= product).clamp(1, self.products.len() - 1);
        let (low, high) = (self.products[after - 1], self.products[after]);
        (after, ((product - low) / (high - low)).clamp(0.0, 1.0))
    }

    /// The altitude (km) where a ray is level whose `n r` is this (km).
    pub(super) fn altitude(&self, layers: &Layers, product: f64) -> f64 {
        let (after, share) = self.place(product);
        let of = |i: usize| layers.air.depth * part(i, LEVEL_RAYS).powi(2);
        of(after - 1) * (1.0 - share) + of(after) * share
    }

    /// What a level ray crosses whose `n r` is this (km).
    pub(super) fn at(&self, product: f64) -> Crossed {
        let (after, share) = self.place(product);
        let [below, above] = [self.crossed[after - 1], self.crossed[after]];
        let mix = |a: f64, b: f64| (a.max(1e-300).ln() * (1.0 - share) + b.max(1e-300).ln() * share).exp();
        Crossed {
            along: std::array::from_fn(|i| mix(below.along[i], above.along[i])),
            bending: mix(below.bending, above.bending),
        }
    }

    /// What the rays cross on which the sun is seen at zenith angles (radians).
    pub(super) fn crossed<const N: usize>(&self, row: &Row, seen: [f64; N]) -> [Crossed; N] {
        let outwards = row.outwards(seen.map(|seen| seen.cos().abs()));
        std::array::from_fn(|ray| {
            let outwards = outwards[ray];
            if seen[ray] <= FRAC_PI_2 {
                return outwards;
            }
            let level = self.at(row.index * row.radius * seen[ray].sin());
            Crossed {
                along: std::array::from_fn(|i| 2.0 * level.along[i] - outwards.along[i]),
                bending: 2.0 * level.bending - outwards.bending,
            }
        })
    }

    /// Zenith angle of the ray that touches the ground (radians).
    pub(super) fn lowest_seen(&self, row: &Row) -> f64 {
        PI - (self.products[0] / (row.index * row.radius)).min(1.0).asin()
    }

    /// Zenith angle, without air, of the lowest sun that is seen (radians).
    pub(super) fn lowest_sun(&self, row: &Row) -> f64 {
        let seen = self.lowest_seen(row);
        seen + self.crossed(row, [seen])[0].bending
    }

    /// The suns of a row of the table.
    pub(super) fn bent(&self, row: &Row, lowest: f64) -> Vec<SeenSun> {
        let lowest_seen = self.lowest_seen(row);
        let seen: Vec<f64> = (0..SEEN_SUNS).map(|i| lowest_seen * (1.0 - (1.0 - part(i, SEEN_SUNS)).powi(2))).collect();
        let (blocks, _) = seen.as_chunks::<LANES>();
        let crossed: Vec<Crossed> = blocks.iter().flat_map(|&seen| self.crossed(row, seen)).collect();
        let suns: Vec<f64> = seen.iter().zip(&crossed).map(|(seen, crossed)| seen + crossed.bending).collect();
        let logarithms: Vec<[f64; CONSTITUENTS]> =
            crossed.iter().map(|crossed| crossed.along.map(|along| along.max(1e-300).ln())).collect();
        let at = |sun: f64| {
            let last = suns.len() - 1;
            let first = suns.partition_point(|&below| below <= sun).clamp(2, last - 1) - 2;
            let cubic = Cubic::new(std::array::from_fn(|i| suns[first + i]), sun);
            let seen_at = cubic.value(std::array::from_fn(|i| seen[first + i]));
            let slope = cubic.slope(std::array::from_fn(|i| seen[first + i]));
            let spread = if sun > 1e-6 { seen_at.sin() / sun.sin() * slope } else { slope * slope };
            let along = |c: usize| cubic.value(std::array::from_fn(|i| logarithms[first + i][c])).exp();
            SeenSun { seen: seen_at, along: std::array::from_fn(along), spread }
        };
        (0..SUNS).map(|j| at(lowest * (1.0 - (1.0 - part(j, SUNS)).powi(2)))).collect()
    }
}

/// The cubic through four places.
struct Cubic {
    weights: [f64; 4],
    slopes: [f64; 4],
}

impl Cubic {
    fn new(places: [f64; 4], at: f64) -> Self {
        let others = |i: usize| (0..4).filter(move |&j| j != i);
        let below = |i: usize| others(i).map(|j| places[i] - places[j]).product::<f64>();
        let weight = |i: usize| others(i).map(|j| at - places[j]).product::<f64>() / below(i);
        let slope = |i: usize| {
            let without = |left: usize| others(i).filter(|&j| j != left).map(|j| at - places[j]).product::<f64>();
            others(i).map(without).sum::<f64>() / below(i)
        };
        Self { weights: std::array::from_fn(weight), slopes: std::array::from_fn(slope) }
    }

    fn value(&self, values: [f64; 4]) -> f64 {
        self.weights.iter().zip(values).map(|(weight, value)| weight * value).sum()
    }

    fn slope(&self, values: [f64; 4]) -> f64 {
        self.slopes.iter().zip(values).map(|(slope, value)| slope * value).sum()
    }
}

/// Where an entry stands along an axis, from 0 to 1.
pub(super) fn part(entry: usize, entries: usize) -> f64 {
    entry as f64 / (entries - 1) as f64
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn air(refraction: bool) -> Air {
        let profile = Profile::UsStandard;
        Air {
            ground_radius: 6371.0,
            depth: 100.0,
            site: 0.0,
            columns: [8.0, 15.0],
            aerosol: Lane::exponential(1.2),
            refractivity: if refraction { refractivity(&profile, 1.0) } else { 0.0 },
            profile,
        }
    }

    /// Refraction (arc minutes) and air mass at which the sun is seen (degrees), and the air mass.
    fn seen(elevation: f64) -> (f64, f64) {
        let air = air(true);
        let layers = Layers::new(air.clone());
        let [crossed] = layers.row(0.0).outwards([elevation.to_radians().sin()]);
        (crossed.bending.to_degrees() * 60.0, crossed.along[0] / air.columns[0])
    }

    #[test]
    fn air_masses_are_those_of_kasten_and_young() {
        // Kasten and Young 1989, Eq. 3 (DOI 10.1364/AO.28.004735): relative optical air mass by apparent elevation.
        for (elevation, published) in
            [(0.0, 37.92), (1.0, 26.31), (2.0, 19.43), (5.0, 10.31), (10.0, 5.585), (30.0, 1.994)]
        {
            let (_, found) = seen(elevation);
            // Theirs is of the ISO atmosphere of 1972, whose lowest kilometres are a little denser.
            assert!(
                (found / published - 1.0).abs() < 5e-3 + if elevation == 0.0 { 4e-3 } else { 0.0 },
                "{elevation}: {found}"
            );
        }
    }

    #[test]
    fn the_setting_sun_is_lifted_as_observed() {
        // Bennett 1982 (DOI 10.1017/S0373463300022037), for 10 °C and 1010 hPa; at 15 °C it is 2 % less. The horizon's
        // depends on the lowest air besides.
        for (elevation, minutes) in [(0.0, 34.5), (1.0, 24.4), (5.0, 9.9), (10.0, 5.4)] {
            let (found, _) = seen(elevation);
            assert!((found / minutes - 1.0).abs() < 0.06, "{elevation}: {found}' instead of {minutes}'");
        }
    }
}
