//! The tables of [`sorairo_shared::medium::tables`], made from a profile by quadrature.
//!
//! A ray whose zenith angle is `z` at a radius `r` keeps `p = n r sin z` (Bouguer's law) with the refractive index `n`.
//! Over an altitude `dz` it crosses `ds = n r / √((n r)² - p²) dz`. Its bending is
//! `δ = -∫ (dn/dz) / n · p / √((n r)² - p²) dz`. Straight rays are those of `n = 1`.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::{Arc, Mutex};

use rayon::prelude::*;
use sorairo_shared::glam::{Vec2, Vec3, Vec4};
use sorairo_shared::medium::tables::{
    ALTITUDES, AXIS_SPREAD, EDGE, ENTRIES, GASES, SEEN, SUN, SUN_GASES, SUNS, VIEW, VIEW_GASES, VIEWS,
};

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

/// The tables of an air.
#[derive(Debug)]
pub struct Tables {
    /// Their entries; see [`sorairo_shared::medium::tables`].
    pub entries: Vec<Vec4>,
    /// A number that tells them from others; not 0.
    pub number: u32,
    /// The cone nearest to the planet's shadow: offset (km), slope and where it begins (km); see
    /// [`sorairo_shared::geometry::Shadow`].
    pub shadow: [f64; 3],
    layers: Layers,
    level: LevelRays,
}

/// A beam of sunlight to a place.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// Column densities of air, aerosol and ozone along it (km).
    pub along: [f64; 3],
    /// What absorbs along it, class by class; see [`super::gases`].
    pub gases: [f64; CLASSES],
    /// Zenith angle, without air, of the sun that it comes from (radians).
    pub sun: f64,
}

/// `n - 1` of air at 550 nm, 15 °C and 1013.25 hPa (Ciddor 1996, <https://doi.org/10.1364/AO.35.001566>), and the
/// molecules per cm³ that it has there.
const REFRACTIVITY: f64 = 2.778e-4;
const OF_DENSITY: f64 = 2.547e19;

/// `n - 1` of a profile on the ground at a pressure relative to the profile's own.
pub fn refractivity(profile: &Profile, pressure: f64) -> f64 {
    profile.levels().map_or(0.0, |levels| REFRACTIVITY * levels.at(0.0).value[0] / OF_DENSITY * pressure)
}

/// Airs whose tables are kept.
const KEPT: usize = 8;

impl Tables {
    /// The tables of an air: those made last are kept.
    pub fn of(air: &Air) -> Arc<Self> {
        static MADE: Mutex<Vec<(Air, Arc<Tables>)>> = Mutex::new(Vec::new());
        let lock = || MADE.lock().expect("no holder of this lock panics");
        if let Some((_, found)) = lock().iter().find(|(known, _)| known == air) {
            return Arc::clone(found);
        }
        let made = Arc::new(Self::new(air));
        let mut kept = lock();
        kept.truncate(KEPT - 1);
        kept.insert(0, (air.clone(), Arc::clone(&made)));
        made
    }

    /// The beam on which the sun is seen at a zenith angle (radians) from an altitude inside the atmosphere (km); none
    /// out of the ground.
    pub fn beam(&self, altitude: f64, seen: f64) -> Option<Beam> {
        let row = self.layers.row(altitude);
        (seen <= self.level.lowest_seen(&row)).then(|| {
            let [Crossed { along: [air, aerosol, ozone, ..], bending }] = self.level.crossed(&row, [seen]);
            let along = [air, aerosol, ozone];
            Beam { along, gases: self.gases(&row, seen), sun: seen + bending }
        })
    }

    /// What absorbs on the ray on which the sun is seen at a zenith angle (radians).
    fn gases(&self, row: &Row, seen: f64) -> [f64; CLASSES] {
        if seen <= FRAC_PI_2 {
            return row.gases(&self.layers, seen.cos());
        }
        let level = self.level.altitude(&self.layers, row.index * row.radius * seen.sin());
        let both = self.layers.row(level).gases(&self.layers, 0.0);
        let behind = row.gases(&self.layers, -seen.cos());
        std::array::from_fn(|i| (2.0 * both[i] - behind[i]).max(0.0))
    }

    /// Zenith angle (radians) at which a sun is seen from an altitude inside the atmosphere (km), by that without air;
    /// of one below the horizon, that of the horizon.
    pub fn seen(&self, altitude: f64, sun: f64) -> f64 {
        let row = self.layers.row(altitude);
        let (mut high, mut low) = (0.0, self.level.lowest_seen(&row));
        // A zenith angle in f64 has no more digits.
        for _ in 0..52 {
            let middle = 0.5 * (high + low);
            let seen = middle + self.level.crossed(&row, [middle])[0].bending;
            if seen < sun { high = middle } else { low = middle }
        }
        0.5 * (high + low)
    }

    /// Zenith angle (radians), without air, of the lowest sun that is seen from an altitude inside the atmosphere (km).
    pub fn lowest_sun(&self, altitude: f64) -> f64 {
        self.level.lowest_sun(&self.layers.row(altitude))
    }

    fn new(air: &Air) -> Self {
        let layers = Layers::new(air.clone());
        let level = LevelRays::new(&layers);
        let rows: Vec<TableRow> =
            (0..ALTITUDES).into_par_iter().map(|i| level.of_altitude(&layers, layers.altitude(i))).collect();
        let mut entries = vec![Vec4::ZERO; ENTRIES];
        let mut edge = Vec::new();
        for (i, TableRow { densities, lowest, view, suns }) in rows.iter().enumerate() {
            entries[i] = logarithms(densities).extend(*lowest as f32);
            entries[GASES + i] = (logarithms_of_gases(densities), Vec2::ZERO).into();
            edge.push((layers.altitude(i), *lowest));
            for (j, along) in view.iter().enumerate() {
                entries[VIEW + i * VIEWS + j] = logarithms(along).extend(0.0);
                entries[VIEW_GASES + i * VIEWS + j] = gases_and_next(view, j, |along| along);
            }
            for (j, sun) in suns.iter().enumerate() {
                entries[SUN + i * SUNS + j] = logarithms(&sun.along).extend(sun.spread as f32);
                entries[SUN_GASES + i * SUNS + j] = gases_and_next(suns, j, |sun| &sun.along);
            }
        }
        for (j, sun) in rows[0].suns.iter().enumerate() {
            entries[SEEN + j] = Vec4::splat(sun.seen.cos().max(0.0) as f32);
        }
        let shadow = shadow(air, &edge, &mut entries[EDGE..]);
        Self { number: number_of(&entries), entries, shadow, layers, level }
    }
}

/// What the tables hold at an altitude.
struct TableRow {
    densities: [f64; CONSTITUENTS],
    /// Zenith angle of the lowest sun that is seen (radians).
    lowest: f64,
    /// Column densities of view rays (km).
    view: Vec<[f64; CONSTITUENTS]>,
    suns: Vec<SeenSun>,
}

/// Where an entry stands along an axis, from 0 to 1.
fn part(entry: usize, entries: usize) -> f64 {
    entry as f64 / (entries - 1) as f64
}

/// Column densities (km) along the view rays of a row of the table, which is so far from the planet's centre (km).
fn straight(row: &Row, radius: f64) -> Vec<[f64; CONSTITUENTS]> {
    let spread = (radius * f64::from(AXIS_SPREAD)).sqrt();
    let mu = |j: usize| {
        let x = part(j, VIEWS);
        (1.0 - x) / (1.0 + spread * x)
    };
    (0..VIEWS / LANES).flat_map(|block| row.straight::<LANES>(std::array::from_fn(|i| mu(block * LANES + i)))).collect()
}

/// A natural logarithm, of what has no smaller one in single precision.
fn logarithm(value: f64) -> f32 {
    /// `e` to this power is 1e-35.
    const SMALLEST: f64 = -80.0;
    value.max(0.0).ln().max(SMALLEST) as f32
}

/// Natural logarithms of air, aerosol and ozone.
fn logarithms([air, aerosol, ozone, ..]: &[f64; CONSTITUENTS]) -> Vec3 {
    [*air, *aerosol, *ozone].map(logarithm).into()
}

/// Those of the gases.
fn logarithms_of_gases([.., pairs, water]: &[f64; CONSTITUENTS]) -> Vec2 {
    [*pairs, *water].map(logarithm).into()
}

/// Those of the gases in a direction and in the next, of which the last has none.
fn gases_and_next<T>(row: &[T], j: usize, along: impl Fn(&T) -> &[f64; CONSTITUENTS]) -> Vec4 {
    let at = |j: usize| logarithms_of_gases(along(&row[j.min(row.len() - 1)]));
    (at(j), at(j + 1)).into()
}

/// A number that differs where entries do (FNV-1a); not 0.
fn number_of(entries: &[Vec4]) -> u32 {
    let hash = bytemuck::cast_slice::<Vec4, u8>(entries)
        .iter()
        .fold(0x811c_9dc5_u32, |hash, &byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    hash.max(1)
}

/// Panels of a column's quadrature, each with three nodes of Gauss-Legendre.
const PANELS: usize = 40;
const NODES: usize = 3 * PANELS;

/// How far above the top of the atmosphere columns reach (km): a ray that grazes the top ends as smoothly there as the
/// profile does.
const ABOVE_TOP: f64 = 20.0;

/// Air, aerosol, ozone, pairs of oxygen and water vapour, in this order.
const CONSTITUENTS: usize = 5;

/// The densities of an air, relative to those whose columns it shall have.
#[derive(Debug)]
struct Layers {
    air: Air,
    levels: Levels,
    gases: Gases,
    /// What densities of the levels are multiplied with.
    scale: [f64; CONSTITUENTS],
    /// The density of air at the sea.
    ground: f64,
    /// Places on [0, 1] and weights.
    rule: [[f64; 2]; NODES],
}

impl Layers {
    fn new(air: Air) -> Self {
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

    fn altitude(&self, i: usize) -> f64 {
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
    fn row(&self, altitude: f64) -> Row {
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
struct Row {
    radius: f64,
    index: f64,
    densities: [f64; CONSTITUENTS],
    nodes: [Node; NODES],
}

/// What a ray crosses up to space: column densities (km) and its bending (radians).
#[derive(Clone, Copy, Debug, Default)]
struct Crossed {
    along: [f64; CONSTITUENTS],
    bending: f64,
}

impl Row {
    /// Column densities (km) along straight rays with the cosines `mu >= 0` of the zenith angle.
    fn straight<const N: usize>(&self, mu: [f64; N]) -> [[f64; CONSTITUENTS]; N] {
        let squares = mu.map(|mu| (self.radius * mu).powi(2));
        let mut along = [[0.0; N]; CONSTITUENTS];
        for Node { densities, straight, .. } in &self.nodes {
            add_to_each(&mut along, densities, &straight.lengths(&squares));
        }
        std::array::from_fn(|i| along.map(|column| column[i]))
    }

    /// What bent rays outwards cross that have the cosines `mu >= 0` of the zenith angle here.
    fn outwards<const N: usize>(&self, mu: [f64; N]) -> [Crossed; N] {
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
    fn gases(&self, layers: &Layers, mu: f64) -> [f64; CLASSES] {
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

/// Level rays from every altitude, one of which each ray becomes that comes down and goes up again.
#[derive(Debug)]
struct LevelRays {
    /// `n r` (km), increasing.
    products: Vec<f64>,
    crossed: Vec<Crossed>,
}

/// Altitudes of level rays.
const LEVEL_RAYS: usize = 288;
/// Rays from an altitude, by the zenith angle at which the sun is seen: a multiple of [`LANES`].
const SEEN_SUNS: usize = 160;
/// Rays that are computed side by side; the view rays of a row are a multiple of it too.
const LANES: usize = 8;

/// The sun from an altitude.
#[derive(Clone, Copy)]
struct SeenSun {
    /// Zenith angle at which it is seen (radians).
    seen: f64,
    along: [f64; CONSTITUENTS],
    /// See [`sorairo_shared::medium::tables`].
    spread: f64,
}

impl LevelRays {
    fn new(layers: &Layers) -> Self {
        let altitudes = (0..LEVEL_RAYS).map(|i| layers.air.depth * part(i, LEVEL_RAYS).powi(2));
        let of_altitude = |altitude: f64| {
            let row = layers.row(altitude);
            (row.index * row.radius, row.outwards([0.0])[0])
        };
        let (products, crossed) = altitudes.collect::<Vec<_>>().into_par_iter().map(of_altitude).unzip();
        Self { products, crossed }
    }

    /// What the tables hold at an altitude (km).
    fn of_altitude(&self, layers: &Layers, altitude: f64) -> TableRow {
        let row = layers.row(altitude);
        let lowest = self.lowest_sun(&row);
        let view = straight(&row, layers.air.ground_radius + altitude);
        TableRow { densities: row.densities, lowest, view, suns: self.bent(&row, lowest) }
    }

    /// The altitude (km) where a ray is level whose `n r` is this (km).
    fn altitude(&self, layers: &Layers, product: f64) -> f64 {
        let after = self.products.partition_point(|&level| level <= product).clamp(1, self.products.len() - 1);
        let (low, high) = (self.products[after - 1], self.products[after]);
        let share = ((product - low) / (high - low)).clamp(0.0, 1.0);
        let of = |i: usize| layers.air.depth * part(i, LEVEL_RAYS).powi(2);
        of(after - 1) * (1.0 - share) + of(after) * share
    }

    /// What a level ray crosses whose `n r` is this (km).
    fn at(&self, product: f64) -> Crossed {
        let after = self.products.partition_point(|&level| level <= product).clamp(1, self.products.len() - 1);
        let (low, high) = (self.products[after - 1], self.products[after]);
        let share = ((product - low) / (high - low)).clamp(0.0, 1.0);
        let [below, above] = [self.crossed[after - 1], self.crossed[after]];
        let mix = |a: f64, b: f64| (a.max(1e-300).ln() * (1.0 - share) + b.max(1e-300).ln() * share).exp();
        Crossed {
            along: std::array::from_fn(|i| mix(below.along[i], above.along[i])),
            bending: mix(below.bending, above.bending),
        }
    }

    /// What the rays cross on which the sun is seen at zenith angles (radians).
    fn crossed<const N: usize>(&self, row: &Row, seen: [f64; N]) -> [Crossed; N] {
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
    fn lowest_seen(&self, row: &Row) -> f64 {
        PI - (self.products[0] / (row.index * row.radius)).min(1.0).asin()
    }

    /// Zenith angle, without air, of the lowest sun that is seen (radians).
    fn lowest_sun(&self, row: &Row) -> f64 {
        let seen = self.lowest_seen(row);
        seen + self.crossed(row, [seen])[0].bending
    }

    /// The suns of a row of the table.
    fn bent(&self, row: &Row, lowest: f64) -> Vec<SeenSun> {
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

/// The cone nearest to the edge of the planet's shadow, from altitudes (km) and the zenith angles of the lowest sun
/// that is seen there; the cones that the edge touches at each altitude become entries.
fn shadow(air: &Air, edge: &[(f64, f64)], entries: &mut [Vec4]) -> [f64; 3] {
    if air.refractivity == 0.0 {
        return [0.0; 3];
    }
    let point = |&(altitude, lowest): &(f64, f64)| {
        let radius = air.ground_radius + altitude;
        [-radius * lowest.cos(), radius * lowest.sin() - air.ground_radius]
    };
    let points: Vec<[f64; 2]> = edge.iter().map(point).collect();
    let last = points.len() - 1;
    for (i, &[x, y]) in points.iter().enumerate() {
        let [before, after] = [points[i.saturating_sub(1)], points[(i + 1).min(last)]];
        let slope = (before[1] - after[1]) / (after[0] - before[0]);
        entries[i] = Vec4::new((y + slope * x) as f32, slope as f32, 0.0, 0.0);
    }
    let count = points.len() as f64;
    let [x, y] = [0, 1].map(|i| points.iter().map(|point| point[i]).sum::<f64>() / count);
    let across = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum::<f64>();
    let along = points.iter().map(|point| (point[0] - x).powi(2)).sum::<f64>();
    let slope = across / along;
    [y - slope * x, -slope, points[0][0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn air(refraction: bool) -> Air {
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

    #[test]
    fn a_straight_table_is_the_bent_one_of_no_air() {
        let straight = Tables::new(&air(false));
        assert_eq!(straight.shadow, [0.0; 3]);
        assert!(straight.entries[SUN..SEEN].iter().all(|entry| (entry.w - 1.0).abs() < 1e-5));
        // At the zenith and from the ground, columns are those that were asked for.
        for first in [VIEW, SUN] {
            for (found, asked) in straight.entries[first].to_array().into_iter().zip([8.0, 1.2, 15.0]) {
                assert!((f64::from(found).exp() / asked - 1.0).abs() < 1e-5, "{found}, {asked}");
            }
        }
    }

    #[test]
    fn the_edge_of_the_shadow_touches_its_cones() {
        let air = air(true);
        let tables = Tables::new(&air);
        let [_, slope, begin] = tables.shadow;
        // The lowest sun that is seen from the ground stands 0.5 to 0.6° below the horizon; its light leaves the air
        // bent twice as far.
        assert!((0.009..0.0105).contains(&(begin / air.ground_radius)), "{begin}");
        assert!((0.016..0.021).contains(&slope), "{slope}");
        for i in [1, 20, 60, 126] {
            let (altitude, lowest) = (air.depth * part(i, ALTITUDES).powi(2), f64::from(tables.entries[i].w));
            let radius = air.ground_radius + altitude;
            let edge = tables.entries[EDGE + i];
            let cone = air.ground_radius + f64::from(edge.x) + f64::from(edge.y) * radius * lowest.cos();
            // Angles and offsets are rounded to single precision: 1e-7 of 2000 km.
            assert!((radius * lowest.sin() - cone).abs() < 1e-3, "{altitude} km: {}", radius * lowest.sin() - cone);
        }
    }
}
