//! The tables of [`sorairo_shared::medium::tables`], made from a profile by quadrature.

use std::f64::consts::FRAC_PI_2;
use std::sync::{Arc, Mutex};

use rayon::prelude::*;
use sorairo_shared::glam::{Vec2, Vec3, Vec4};
use sorairo_shared::medium::tables::{
    ALTITUDES, AXIS_SPREAD, EDGE, ENTRIES, GASES, SEEN, SUN, SUN_GASES, SUNS, VIEW, VIEW_GASES, VIEWS,
};

use super::bent::{Air, CONSTITUENTS, Crossed, LANES, Layers, LevelRays, Row, SeenSun, part};
use super::gases::CLASSES;

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
            (0..ALTITUDES).into_par_iter().map(|i| of_altitude(&level, &layers, layers.altitude(i))).collect();
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

/// What the tables hold at an altitude (km).
fn of_altitude(level: &LevelRays, layers: &Layers, altitude: f64) -> TableRow {
    let row = layers.row(altitude);
    let lowest = level.lowest_sun(&row);
    let view = straight(&row, layers.air.ground_radius + altitude);
    TableRow { densities: row.densities, lowest, view, suns: level.bent(&row, lowest) }
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
    use crate::medium::bent::tests::air;

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
