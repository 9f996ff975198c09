//! A radiosonde's sounding as the University of Wyoming lists it: text in columns of fixed width, with units and a rule
//! of dashes under their names.
//!
//! ```text
//!    PRES   HGHT   TEMP   DWPT   RELH   MIXR   DRCT   SKNT   THTA   THTE   THTV
//!     hPa     m      C      C      %    g/kg    deg   knot     K      K      K
//! -----------------------------------------------------------------------------
//!   979.0    288   24.0   23.0     94  18.45      0      0  299.0  353.0  302.2
//! ```
//!
//! A balloon bursts at some 30 km. From there the US Standard Atmosphere goes on, its pressure multiplied by what the
//! sonde found at its last level; from the lowest level down to the sea, 6.5 K/km and the weight of air. Levels are
//! kept 0.1 km apart.

use super::levels::{WEIGHT, at_altitude, us_standard};
use crate::spectra::columns_file::Columns;

/// The columns that are read, and their units.
const WANTED: [(&str, &str); 5] = [("PRES", "hPa"), ("HGHT", "m"), ("TEMP", "C"), ("DWPT", "C"), ("MIXR", "g/kg")];

/// The least distance of two levels (km): nearer to each other, air over hot ground grows denser with altitude.
const APART: f64 = 0.1;

/// How far above its last level the standard atmosphere begins (km).
const ABOVE: f64 = 1.0;

/// Warming towards the ground (K/km) of the US Standard Atmosphere.
const LAPSE: f64 = 6.5;

/// The radius (km) by which the US Standard Atmosphere turns geopotential altitudes into geometric ones.
const RADIUS: f64 = 6356.766;

/// The line that names the columns.
fn is_head(line: &str) -> bool {
    let mut words = line.split_whitespace();
    words.next() == Some("PRES") && words.next() == Some("HGHT")
}

/// Whether a text is such a list.
pub fn is_listing(text: &str) -> bool {
    text.lines().any(is_head)
}

/// One level.
#[derive(Clone, Copy, Debug)]
struct Reading {
    line: u64,
    /// Altitude (km).
    altitude: f64,
    /// Pressure (hPa).
    pressure: f64,
    /// Temperature (K).
    temperature: f64,
    /// Water vapour (ppmv).
    water: f64,
}

/// The columns of a profile: altitude, pressure, temperature and water vapour.
///
/// # Errors
///
/// One sentence, with line, column and unit.
pub fn columns(text: &str) -> Result<Columns, String> {
    let readings = continued(readings(text)?);
    Ok(Columns {
        heads: None,
        names: ["altitude_km", "pressure_hpa", "temperature_k", "water_ppmv"].map(String::from).into(),
        lines: readings.iter().map(|reading| reading.line).collect(),
        rows: readings
            .iter()
            .map(|reading| (reading.altitude, vec![reading.pressure, reading.temperature, reading.water]))
            .collect(),
    })
}

/// The levels of a list.
fn readings(text: &str) -> Result<Vec<Reading>, String> {
    let mut lines = (1..).zip(text.lines()).skip_while(|(_, line)| !is_head(line));
    let (at, head) = lines.next().expect("it is a list");
    let places = places(head);
    let place = |name: &str| places.iter().position(|(known, _)| *known == name);
    let missing = |name: &str| format!("line {at}: no column is called {name}");
    let found = WANTED.map(|(name, _)| place(name).ok_or_else(|| missing(name)));
    let [pressure, height, temperature, dew, mixing] = found;
    let columns = [pressure?, height?, temperature?, dew?, mixing?];
    let units = lines.next().map_or("", |(_, line)| line).split_whitespace().collect::<Vec<_>>();
    for ((name, wanted), column) in WANTED.iter().zip(columns) {
        match units.get(column) {
            Some(unit) if unit == wanted => {}
            found => {
                let found = found.unwrap_or(&"none");
                return Err(format!("line {}: the unit of {name} is {found}; {wanted} is wanted", at + 1));
            }
        }
    }
    let mut readings: Vec<Reading> = Vec::new();
    for (line, text) in lines.skip_while(|(_, line)| line.trim_start().starts_with("---")) {
        let is_row = text.trim_start().starts_with(|c: char| c.is_ascii_digit());
        if !is_row {
            break;
        }
        let Some(reading) = reading(line, text, &places, columns)? else { continue };
        if readings.last().is_none_or(|last| reading.altitude >= last.altitude + APART) {
            readings.push(reading);
        }
    }
    match readings.len() {
        0 | 1 => Err(format!("line {at}: fewer than two levels with a temperature follow")),
        _ => Ok(readings),
    }
}

/// The names of columns, and where each ends.
fn places(head: &str) -> Vec<(&str, usize)> {
    head.split_whitespace().map(|name| (name, name.as_ptr() as usize - head.as_ptr() as usize + name.len())).collect()
}

/// What a row says; nothing where it has no temperature, as below the ground.
fn reading(line: u64, text: &str, places: &[(&str, usize)], columns: [usize; 5]) -> Result<Option<Reading>, String> {
    let number = |column: usize| {
        let start = column.checked_sub(1).map_or(0, |before| places[before].1);
        let cell = text.get(start..places[column].1.min(text.len())).unwrap_or_default().trim();
        let wrong = || format!("line {line}: {} is {cell:?}, which is no number", places[column].0);
        if cell.is_empty() { Ok(None) } else { cell.parse::<f64>().map(Some).map_err(|_| wrong()) }
    };
    let [pressure, height, temperature, dew, mixing] = columns.map(number);
    let (Some(pressure), Some(height), Some(celsius)) = (pressure?, height?, temperature?) else { return Ok(None) };
    if !(0.1..=1200.0).contains(&pressure) || !(-120.0..=70.0).contains(&celsius) {
        return Err(format!(
            "line {line}: {pressure} hPa and {celsius} °C; 0.1 to 1200 hPa and -120 to 70 °C are allowed"
        ));
    }
    let height = 1e-3 * height;
    let altitude = RADIUS * height / (RADIUS - height);
    let standard = at_altitude(us_standard(), altitude);
    let water = match (mixing?, dew?) {
        (Some(mixing), _) => of_mixing(1e-3 * mixing),
        (None, Some(dew)) => 1e6 * vapour_pressure(dew) / pressure,
        (None, None) => 1e6 * standard.water / standard.air,
    };
    Ok(Some(Reading { line, altitude, pressure, temperature: celsius + 273.15, water }))
}

/// Parts per million of the molecules of moist air, by the mass of vapour over that of dry air.
fn of_mixing(ratio: f64) -> f64 {
    /// The mass of a molecule of water over that of air.
    const WATER: f64 = 0.62198;
    1e6 * ratio / (WATER + ratio)
}

/// Vapour pressure (hPa) at a dew point (°C): Bolton 1980 (DOI 10.1175/1520-0493(1980)108<1046:TCOEPT>2.0.CO;2), Eq.
/// 10.
fn vapour_pressure(dew: f64) -> f64 {
    6.112 * (17.67 * dew / (dew + 243.5)).exp()
}

/// The same down to the sea and up to where the standard atmosphere ends.
fn continued(mut readings: Vec<Reading>) -> Vec<Reading> {
    let (lowest, highest) = (readings[0], readings[readings.len() - 1]);
    if lowest.altitude > 0.0 {
        let temperature = lowest.temperature + LAPSE * lowest.altitude;
        let fall = WEIGHT * lowest.altitude * 2.0 / (lowest.temperature + temperature);
        readings.insert(0, Reading { altitude: 0.0, pressure: lowest.pressure * fall.exp(), temperature, ..lowest });
    }
    let standard = at_altitude(us_standard(), highest.altitude);
    let scale = highest.pressure / standard.pressure;
    let above = us_standard().iter();
    readings.extend(above.filter(|level| level.altitude >= highest.altitude + ABOVE).map(|level| Reading {
        line: highest.line,
        altitude: level.altitude,
        pressure: scale * level.pressure,
        temperature: level.temperature,
        water: 1e6 * level.water / level.air,
    }));
    readings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::levels::Level;
    use crate::medium::profile::OwnProfile;
    use crate::spectra::columns_file::FromColumns;

    const HEAD: &str = "<HTML><H2>11120 LOWI Innsbruck-Flughafen Observations at 03Z 17 Sep 2018</H2>\n<PRE>\n\
-----------------------------------------------------------------------------
   PRES   HGHT   TEMP   DWPT   RELH   MIXR   DRCT   SKNT   THTA   THTE   THTV
    hPa     m      C      C      %    g/kg    deg   knot     K      K      K\n\
-----------------------------------------------------------------------------\n";

    /// A listing of the US Standard Atmosphere, up to an altitude (km).
    fn listing(up_to: f64) -> String {
        let levels = us_standard().iter().filter(|level| level.altitude <= up_to);
        let row = |level: &Level| {
            let (ratio, height) = (level.water / level.air, level.altitude * RADIUS / (RADIUS + level.altitude));
            let celsius = level.temperature - 273.15;
            let mixing = 1e3 * 0.62198 * ratio / (1.0 - ratio);
            format!("{:7.1}{:7.0}{celsius:7.1}              {mixing:7.2}    180      4\n", level.pressure, 1e3 * height)
        };
        format!("{HEAD} 1020.0    -60\n{}</PRE>\nStation identifier: LOWI\n", levels.map(row).collect::<String>())
    }

    #[test]
    fn a_listing_of_the_standard_atmosphere_is_the_standard_atmosphere() {
        for up_to in [12.0, 30.0] {
            let text = listing(up_to);
            assert!(is_listing(&text));
            let columns = columns(&text).unwrap();
            OwnProfile::from_columns(&columns).unwrap();
            assert!(columns.rows[0].0 == 0.0 && columns.rows.last().unwrap().0 == 120.0);
            for (altitude, values) in &columns.rows {
                let level = at_altitude(us_standard(), *altitude);
                // A digit of 0.1 hPa at the last level, 1.2 % at 30 km; 0.1 K, and 0.005 g/kg of vapour.
                let room = if up_to > 12.0 { 6e-3 } else { 1e-3 };
                assert!((values[0] / level.pressure - 1.0).abs() < room, "{altitude}: {values:?}");
                assert!((values[1] - level.temperature).abs() < 0.11, "{altitude}: {values:?}");
                assert!((values[2] - 1e6 * level.water / level.air).abs() < 10.0, "{altitude}: {values:?}");
            }
        }
    }

    #[test]
    fn vapour_is_that_of_the_mixing_ratio_or_of_the_dew_point() {
        let of = |row: &str| columns(&format!("{HEAD}{row}  500.0   5720  -14.9\n")).unwrap().rows;
        // A row that the University of Wyoming printed.
        let row = "  979.0    288   24.0   23.0     94  18.45      0      0  299.0  353.0  302.2\n";
        let (mixing, dew) = (of(row), of(&row.replace("18.45", "     ")));
        // Some 34 m of that air weigh 3.8 hPa.
        assert!(mixing[0].0 == 0.0 && (mixing[0].1[0] - 1011.9).abs() < 0.5, "{mixing:?}");
        // Formulas for the vapour pressure at 23 °C agree within 0.5 %.
        let part = mixing[1].1[2] / dew[1].1[2] - 1.0;
        assert!(part != 0.0 && part.abs() < 5e-3, "{mixing:?}, {dew:?}");
    }

    #[test]
    fn what_is_wrong_is_named_by_line_and_column() {
        let wrong = |change: &dyn Fn(&str) -> String| columns(&change(&listing(12.0))).unwrap_err();
        for (found, words) in [
            (wrong(&|text| text.replace("m      C ", "ft     C ")), "line 5: the unit of HGHT is ft; m is wanted"),
            (wrong(&|text| text.replace(" MIXR", " MIXX")), "line 4: no column is called MIXR"),
            (wrong(&|text| text.replace("   15.1", "   1x.1")), "line 8: TEMP is \"1x.1\", which is no number"),
            (wrong(&|text| text.replace("   15.1", "  288.2")), "line 8: 1013 hPa and 288.2 °C; 0.1 to 1200 hPa and"),
            (wrong(&|text| text[..480].into()), "fewer than two levels with a temperature follow"),
        ] {
            assert!(found.contains(words), "{found}\nwithout: {words}");
        }
    }
}
