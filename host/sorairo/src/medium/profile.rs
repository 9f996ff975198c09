//! Profiles of air and ozone over altitude.

use std::sync::OnceLock;

use serde::{Deserialize, Serialize};
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

use crate::spectra::table::Table;

/// How the densities of air and of ozone fall and rise with altitude. Of a measured profile the shape is taken; how much there is in all,
/// the optical depths and the column of ozone say.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Profile {
    /// Air that falls off by its scale height, and ozone as a tent.
    #[default]
    Exponential,
    /// Measured: US Standard Atmosphere 1976.
    UsStandard,
    /// Measured: the tropics (AFGL).
    Tropical,
    /// Measured: middle latitudes in summer (AFGL).
    MidlatitudeSummer,
    /// Measured: middle latitudes in winter (AFGL).
    MidlatitudeWinter,
    /// Measured: below the Arctic Circle in summer (AFGL).
    SubarcticSummer,
    /// Measured: below the Arctic Circle in winter (AFGL).
    SubarcticWinter,
}

/// Densities at some altitudes, between which their logarithms are monotone cubics (Fritsch and Butland 1984,
/// <https://doi.org/10.1137/0905021>).
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// Altitudes (km), increasing.
    altitudes: Vec<f64>,
    /// Logarithms of the densities of air and of ozone (molecules per cm³).
    logarithms: Vec<[f64; 2]>,
    /// Their slopes (km⁻¹).
    slopes: Vec<[f64; 2]>,
}

/// What was measured at an altitude. Densities in molecules per cm³.
#[derive(Clone, Copy, Debug)]
pub struct Level {
    /// Altitude (km).
    pub altitude: f64,
    /// Pressure (hPa).
    pub pressure: f64,
    /// Temperature (K).
    pub temperature: f64,
    /// Air.
    pub air: f64,
    /// Water vapour.
    pub water: f64,
    /// Ozone.
    pub ozone: f64,
    /// Nitrogen dioxide.
    pub nitrogen_dioxide: f64,
}

/// Densities of air and of ozone at an altitude (molecules per cm³), and by how much they grow with it relative to themselves (km⁻¹).
#[derive(Clone, Copy, Debug)]
pub struct Density {
    /// Air and ozone.
    pub value: [f64; 2],
    /// The slopes of their logarithms.
    pub growth: [f64; 2],
}

impl Profile {
    /// Whether it has no closed form.
    pub fn is_measured(self) -> bool {
        self != Self::Exponential
    }

    /// Its levels; none of the exponential.
    ///
    /// Anderson, Clough, Kneizys, Chetwynd and Shettle 1986, *AFGL atmospheric constituent profiles*, AFGL-TR-86-0110: 50 levels from
    /// 0 to 120 km.
    pub fn levels(self) -> Option<Levels> {
        let levels = self.measured()?;
        let altitudes: Vec<f64> = levels.iter().map(|level| level.altitude).collect();
        let logarithms: Vec<_> = levels.iter().map(|level| [level.air.ln(), level.ozone.ln()]).collect();
        let slopes = slopes(&altitudes, &logarithms);
        Some(Levels { altitudes, logarithms, slopes })
    }

    /// What was measured, at any altitude (km): the temperature is straight between levels, and so are the logarithms of all else.
    pub fn level(self, altitude: f64) -> Option<Level> {
        let levels = self.measured()?;
        let after = levels.partition_point(|level| level.altitude <= altitude).clamp(1, levels.len() - 1);
        let (low, high) = (&levels[after - 1], &levels[after]);
        let part = (altitude - low.altitude) / (high.altitude - low.altitude);
        let mix = |of: fn(&Level) -> f64| of(low) * (of(high) / of(low)).powf(part);
        Some(Level {
            altitude,
            pressure: mix(|level| level.pressure),
            temperature: low.temperature + part * (high.temperature - low.temperature),
            air: mix(|level| level.air),
            water: mix(|level| level.water),
            ozone: mix(|level| level.ozone),
            nitrogen_dioxide: mix(|level| level.nitrogen_dioxide),
        })
    }

    /// Temperature of its ozone (K), each molecule alike; of the exponential, that of the US Standard Atmosphere.
    pub fn ozone_temperature(self) -> f64 {
        let profile = if self.is_measured() { self } else { Self::UsStandard };
        let levels = profile.measured().expect("it is measured");
        let [heat, ozone] = vertical(&levels, |level| [level.ozone * level.temperature, level.ozone]);
        heat / ozone
    }

    /// What was measured at its levels.
    pub fn measured(self) -> Option<Vec<Level>> {
        /// Of an atmosphere: pressure, temperature, air, water vapour and ozone.
        const OF_ATMOSPHERE: usize = 5;
        static TABLE: OnceLock<Table<31>> = OnceLock::new();
        let table = TABLE.get_or_init(|| {
            Table::parse(include_str!("../../data/afgl_atmospheres.csv"))
                .expect("the tables in the program are well formed")
        });
        let at = OF_ATMOSPHERE * (self as usize).checked_sub(1)?;
        let part = |air: f64, ppmv: f64| air * ppmv * 1e-6;
        let level = |(altitude, row): (f64, [f64; 31])| {
            let [pressure, temperature, air, water, ozone] = std::array::from_fn(|i| row[at + i]);
            let (water, ozone, nitrogen_dioxide) = (part(air, water), part(air, ozone), part(air, row[30]));
            Level { altitude, pressure, temperature, air, water, ozone, nitrogen_dioxide }
        };
        Some(table.rows().map(level).collect())
    }
}

impl Levels {
    /// The densities at an altitude (km): beyond the last level they fall as between the last two.
    pub fn at(&self, altitude: f64) -> Density {
        let after = self.altitudes.partition_point(|&level| level <= altitude).clamp(1, self.altitudes.len() - 1);
        let (low, high) = (self.altitudes[after - 1], self.altitudes[after]);
        let (below, above) = (self.logarithms[after - 1], self.logarithms[after]);
        let (length, part) = (high - low, (altitude - low) / (high - low));
        let both: [(f64, f64); 2] = std::array::from_fn(|i| {
            let (first, last) = (self.slopes[after - 1][i] * length, self.slopes[after][i] * length);
            let rise = above[i] - below[i];
            if part > 1.0 {
                return (above[i] + last * (part - 1.0), last / length);
            }
            let (c2, c3) = (3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise);
            let value = below[i] + part * (first + part * (c2 + part * c3));
            (value, (first + part * (2.0 * c2 + part * 3.0 * c3)) / length)
        });
        Density { value: both.map(|(value, _)| value.exp()), growth: both.map(|(_, growth)| growth) }
    }
}

/// Vertical columns of what falls by the same part over every stretch between two levels (times km).
pub(super) fn vertical<const N: usize>(levels: &[Level], of: impl Fn(&Level) -> [f64; N]) -> [f64; N] {
    let mut sum = [0.0; N];
    for pair in levels.windows(2) {
        let (low, high) = (of(&pair[0]), of(&pair[1]));
        for i in 0..N {
            let fall = (low[i] / high[i]).ln();
            let mean = if fall.abs() < 1e-6 { low[i] } else { (low[i] - high[i]) / fall };
            sum[i] += mean * (pair[1].altitude - pair[0].altitude);
        }
    }
    sum
}

/// The slopes at levels: the harmonic mean of those on either side, weighted by their lengths, or 0 where they differ in sign.
fn slopes(altitudes: &[f64], logarithms: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let last = altitudes.len() - 1;
    let length = |level: usize| altitudes[level + 1] - altitudes[level];
    let rise = |level: usize, i: usize| (logarithms[level + 1][i] - logarithms[level][i]) / length(level);
    let slope = |level: usize, i: usize| {
        if level == 0 || level == last {
            return rise(level.min(last - 1), i);
        }
        let (below, above) = (rise(level - 1, i), rise(level, i));
        let (of_below, of_above) = (length(level - 1) + 2.0 * length(level), 2.0 * length(level - 1) + length(level));
        if below * above > 0.0 { (of_below + of_above) / (of_above / below + of_below / above) } else { 0.0 }
    };
    (0..=last).map(|level| std::array::from_fn(|i| slope(level, i))).collect()
}

#[cfg(test)]
mod tests {
    use strum::IntoEnumIterator;

    use super::*;

    /// Molecules per cm² above an altitude (km), by midpoints every 10 m.
    fn columns(levels: &Levels) -> [f64; 2] {
        let at = |i| levels.at(0.01 * (f64::from(i) + 0.5)).value;
        (0..12_000).map(at).fold([0.0; 2], |sum, [air, ozone]| [sum[0] + air * 1e3, sum[1] + ozone * 1e3])
    }

    #[test]
    fn the_standard_atmosphere_is_the_published_one() {
        // Number densities (cm⁻³) of the US Standard Atmosphere 1976 (NOAA-S/T 76-1562); the AFGL's have four digits.
        let levels = Profile::UsStandard.levels().unwrap();
        for (altitude, published) in
            [(0.0, 2.547e19), (5.0, 1.531e19), (11.0, 7.585e18), (20.0, 1.849e18), (50.0, 2.135e16)]
        {
            let [found, _] = levels.at(altitude).value;
            assert!((found / published - 1.0).abs() < 3e-3, "{altitude} km: {found:e}, not {published:e}");
        }
    }

    #[test]
    fn each_atmosphere_has_the_air_of_its_pressure_and_ozone_of_its_latitude() {
        for profile in Profile::iter().filter(|profile| profile.is_measured()) {
            let levels = profile.levels().unwrap();
            // A pressure of 1013 to 1018 hPa holds 2.14e25 to 2.17e25 molecules per cm² (of 28.96 g/mol under 9.8 m/s²).
            let [air, ozone] = columns(&levels);
            assert!((2.13e25..2.18e25).contains(&air), "{profile:?}: {air:e}");
            // Climates of ozone lie between 250 and 500 DU.
            let dobson = ozone / 2.687e16;
            assert!((250.0..500.0).contains(&dobson), "{profile:?}: {dobson}");
        }
    }
}
