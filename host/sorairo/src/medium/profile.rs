//! Profiles of air and ozone over altitude.

use serde::{Deserialize, Serialize};
use strum::{EnumIter, EnumMessage, EnumString, IntoEnumIterator, IntoStaticStr};

use super::levels::{Level, WEIGHT, at_altitude, atmosphere};
use super::sounding;
use crate::spectra::columns_file::{Columns, FileOf, FromColumns};
use crate::spectra::named_file::{is_table_file, is_text_file};
use crate::words::{word, words};

/// The profile of the densities of air and ozone over altitude. Only the shape of a measured profile is used; optical
/// depths and the column of ozone set the amounts.
#[derive(
    Clone, Debug, Default, PartialEq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(try_from = "String", into = "String")]
#[strum(serialize_all = "kebab-case")]
pub enum Profile {
    /// Exponential air by its scale height, and ozone as a tent.
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
    /// A user table, pressure, temperature and absorbers over altitude, or a radiosonde's sounding.
    #[strum(disabled)]
    File(FileOf<OwnProfile>),
}

impl TryFrom<String> for Profile {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        if is_table_file(&name) || is_text_file(&name) {
            return FileOf::try_from(name).map(Self::File);
        }
        name.parse().map_err(|_| {
            let names: Vec<_> = words::<Self>().into_iter().map(|word| word.name).collect();
            format!("{name:?} is neither {} nor the name of a .csv or .txt file", names.join(" nor "))
        })
    }
}

impl From<Profile> for String {
    fn from(profile: Profile) -> Self {
        match profile {
            Profile::File(file) => file.into(),
            named => word(named).into(),
        }
    }
}

/// A user profile.
#[derive(Debug)]
pub struct OwnProfile(Vec<Level>);

/// The minimum height of a user profile (km): a hundredth of what scatters at dusk is above.
pub const LOWEST_END: f64 = 60.0;

impl FromColumns for OwnProfile {
    /// Those of a table, or of a sounding as the University of Wyoming lists it.
    fn columns(text: &str) -> Result<Columns, String> {
        if sounding::is_listing(text) { sounding::columns(text) } else { Columns::parse(text) }
    }

    /// Columns by their names: `altitude_km`, `pressure_hpa` and `temperature_k`; `water_ppmv`, `ozone_ppmv` and
    /// `no2_ppmv` are mixing ratios, in place of which those of the US Standard Atmosphere stand.
    fn from_columns(columns: &Columns) -> Result<Self, String> {
        const WANTED: [&str; 6] =
            ["altitude_km", "pressure_hpa", "temperature_k", "water_ppmv", "ozone_ppmv", "no2_ppmv"];
        if let Some(other) = columns.names.iter().find(|name| !WANTED.contains(&name.as_str())) {
            return Err(format!("a column is called {other:?}; a profile has {}", WANTED.join(", ")));
        }
        let place = |name: &str| columns.names.iter().position(|known| known == name);
        let [Some(0), Some(pressure), Some(temperature)] = [0, 1, 2].map(|i| place(WANTED[i])) else {
            return Err(format!(
                "the first row must name the columns: {}, and more if they are known",
                WANTED[..3].join(", ")
            ));
        };
        let ratios = [3, 4, 5].map(|i| place(WANTED[i]));
        let mut levels: Vec<Level> = Vec::new();
        for ((altitude, values), line) in columns.rows.iter().zip(&columns.lines) {
            let standard = Profile::UsStandard.level(*altitude).expect("it is measured");
            let (pressure, temperature) = (values[pressure - 1], values[temperature - 1]);
            if !(100.0..=400.0).contains(&temperature) || pressure <= 0.0 {
                return Err(format!(
                    "line {line}: {pressure} hPa and {temperature} K; air has more than 0 hPa, and 100 to 400 K"
                ));
            }
            let air = pressure * PER_HPA / temperature;
            let of = |i: usize, of_standard: f64| {
                let ratio = ratios[i].map_or(of_standard / standard.air, |column| values[column - 1] * 1e-6);
                // A logarithm of nothing there is none.
                air * ratio.max(1e-16)
            };
            let level = Level {
                altitude: *altitude,
                pressure,
                temperature,
                air,
                water: of(0, standard.water),
                ozone: of(1, standard.ozone),
                nitrogen_dioxide: of(2, standard.nitrogen_dioxide),
            };
            if let Some(below) = levels.last() {
                check_step(below, &level).map_err(|complaint| format!("line {line}: {complaint}"))?;
            }
            levels.push(level);
        }
        let [first, last] = [levels[0].altitude, levels[levels.len() - 1].altitude];
        if first > 0.5 || last < LOWEST_END {
            return Err(format!(
                "it holds {first} to {last} km; a profile begins at the sea and reaches {LOWEST_END} km or more"
            ));
        }
        Ok(Self(levels))
    }
}

/// Molecules per cm³ of a gas of 1 hPa at 1 K: 1e-4 over Boltzmann's constant in J/K.
const PER_HPA: f64 = 7.242_971_6e18;

/// Checks that the air of a level lies on that of the one below as its weight asks for.
fn check_step(below: &Level, level: &Level) -> Result<(), String> {
    /// What water, gravity aloft and a temperature that is not straight between two levels change.
    const ROOM: f64 = 0.1;
    if level.air >= below.air {
        return Err(format!("air grows denser from {} to {} km", below.altitude, level.altitude));
    }
    let expected = WEIGHT * (level.altitude - below.altitude) * 2.0 / (below.temperature + level.temperature);
    let found = (below.pressure / level.pressure).ln();
    if (found / expected - 1.0).abs() > ROOM + 0.02 / expected {
        let complaint = format!(
            "pressure falls from {} to {} hPa between {} and {} km; by weight and temperature it falls to {:.4}",
            below.pressure,
            level.pressure,
            below.altitude,
            level.altitude,
            below.pressure * (-expected).exp()
        );
        return Err(complaint);
    }
    Ok(())
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

/// Densities of air and of ozone at an altitude (molecules per cm³), and by how much they grow with it relative to
/// themselves (km⁻¹).
#[derive(Clone, Copy, Debug)]
pub struct Density {
    /// Air and ozone.
    pub value: [f64; 2],
    /// The slopes of their logarithms.
    pub growth: [f64; 2],
}

impl Profile {
    /// Whether it has no closed form.
    pub fn is_measured(&self) -> bool {
        *self != Self::Exponential
    }

    /// Its levels; none of the exponential.
    ///
    /// Anderson, Clough, Kneizys, Chetwynd and Shettle 1986, *AFGL atmospheric constituent profiles*, AFGL-TR-86-0110:
    /// 50 levels from 0 to 120 km.
    pub fn levels(&self) -> Option<Levels> {
        let levels = self.measured()?;
        let altitudes: Vec<f64> = levels.iter().map(|level| level.altitude).collect();
        let logarithms: Vec<_> = levels.iter().map(|level| [level.air.ln(), level.ozone.ln()]).collect();
        let slopes = slopes(&altitudes, &logarithms);
        Some(Levels { altitudes, logarithms, slopes })
    }

    /// What was measured, at any altitude (km); see [`at_altitude`].
    pub fn level(&self, altitude: f64) -> Option<Level> {
        Some(at_altitude(self.measured()?, altitude))
    }

    /// Temperature of its ozone (K), each molecule alike; of the exponential, that of the US Standard Atmosphere.
    pub fn ozone_temperature(&self) -> f64 {
        let profile = if self.is_measured() { self } else { &Self::UsStandard };
        let levels = profile.measured().expect("it is measured");
        let [heat, ozone] = vertical(levels, |level| [level.ozone * level.temperature, level.ozone]);
        heat / ozone
    }

    /// The levels of the measurement or of a user table.
    pub fn measured(&self) -> Option<&[Level]> {
        if let Self::File(file) = self {
            return Some(&file.value.0);
        }
        let place = Self::iter().position(|profile| profile == *self).expect("the others are listed");
        Some(atmosphere(place.checked_sub(1)?))
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

/// The slopes at levels: the harmonic mean of those on either side, weighted by their lengths, or 0 where they differ
/// in sign.
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
            // A pressure of 1013 to 1018 hPa holds 2.14e25 to 2.17e25 molecules per cm² (of 28.96 g/mol under 9.8
            // m/s²).
            let [air, ozone] = columns(&levels);
            assert!((2.13e25..2.18e25).contains(&air), "{profile:?}: {air:e}");
            // Climates of ozone lie between 250 and 500 DU.
            let dobson = ozone / 2.687e16;
            assert!((250.0..500.0).contains(&dobson), "{profile:?}: {dobson}");
        }
    }

    /// A table of the US Standard Atmosphere, of which a change makes lines.
    fn table(change: impl Fn(&Level) -> Option<[f64; 4]>) -> String {
        let levels = Profile::UsStandard.measured().unwrap();
        let row = |level: &Level| {
            let [altitude, pressure, temperature, ozone] = change(level)?;
            Some(format!("{altitude},{pressure},{temperature},{ozone}\n"))
        };
        let rows: String = levels.iter().filter_map(row).collect();
        format!("altitude_km,pressure_hpa,temperature_k,ozone_ppmv\n{rows}")
    }

    fn read(text: &str) -> Result<Profile, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("own.csv");
        std::fs::write(&path, text).unwrap();
        Profile::try_from(path.to_str().unwrap().to_owned())
    }

    fn as_it_is(level: &Level) -> [f64; 4] {
        [level.altitude, level.pressure, level.temperature, level.ozone / level.air * 1e6]
    }

    #[test]
    fn a_table_of_the_standard_atmosphere_is_the_standard_atmosphere() {
        let own = read(&table(|level| Some(as_it_is(level)))).unwrap();
        for altitude in [0.0, 3.3, 11.0, 25.0, 47.5, 80.0] {
            let [own, standard] = [&own, &Profile::UsStandard].map(|profile| profile.level(altitude).unwrap());
            for (own, standard) in [
                (own.air, standard.air),
                (own.ozone, standard.ozone),
                (own.water, standard.water),
                (own.pressure, standard.pressure),
            ] {
                // AFGL's densities and pressures have three or four digits.
                assert!((own / standard - 1.0).abs() < 4e-3, "{altitude} km: {own:e}, {standard:e}");
            }
        }
        assert!((own.ozone_temperature() - Profile::UsStandard.ozone_temperature()).abs() < 0.5);
    }

    #[test]
    fn a_table_that_is_no_atmosphere_is_refused_by_its_line() {
        let wrong = |change: &dyn Fn(&Level) -> Option<[f64; 4]>| read(&table(change)).unwrap_err();
        let at = |altitude: f64, with: &dyn Fn([f64; 4]) -> [f64; 4]| {
            wrong(&|level| Some(if level.altitude == altitude { with(as_it_is(level)) } else { as_it_is(level) }))
        };
        for (found, words) in [
            (
                wrong(&|level| (level.altitude < 30.5).then(|| as_it_is(level))),
                "it holds 0 to 30 km; a profile begins at the sea and reaches 60 km",
            ),
            (at(5.0, &|[z, p, t, o]| [z, 1.7 * p, t, o]), "line 7: air grows denser from 4 to 5 km"),
            (at(5.0, &|[z, p, t, o]| [z, 0.8 * p, t, o]), "line 7: pressure falls from 616.6 to"),
            (at(5.0, &|[z, p, t, o]| [z, p, t - 273.15, o]), "line 7"),
            (at(5.0, &|[z, p, t, _]| [z, p, t, -999.0]), "line 7: column 4 is \"-999\""),
            (
                read("altitude_km,pressure\n0,1013\n1,900\n").unwrap_err(),
                "a column is called \"pressure\"; a profile has altitude_km, pressure_hpa",
            ),
            (
                read("0,1013,288\n100,0.1,200\n").unwrap_err(),
                "the first row must name the columns: altitude_km, pressure_hpa, temperature_k",
            ),
            (Profile::try_from("own".to_owned()).unwrap_err(), "\"own\" is neither exponential nor us-standard"),
        ] {
            assert!(found.contains(words), "{found}\nwithout: {words}");
        }
    }
}
