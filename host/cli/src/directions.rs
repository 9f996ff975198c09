//! The directions of a table: an elevation, or an angle from the zenith, and an azimuth in each row.

use std::path::Path;

use sorairo::Direction;
use sorairo::rows::Row;

use crate::error::{Error, Result};
use crate::table::Table;

/// Most rows of a table.
const MOST: usize = 1_000_000;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Angle {
    Elevation,
    Zenith,
    Azimuth,
}

/// A column: its angle, and whether it is in radians and not in degrees.
type Column = (Angle, bool);

/// The columns of a table without a header.
const UNNAMED: [Column; 2] = [(Angle::Elevation, false), (Angle::Azimuth, false)];

/// Reads a CSV file, whose first row may name the columns.
///
/// # Errors
///
/// A file that cannot be read, a column of another name, the first row that is no direction, no row or too many.
pub fn read(path: &Path) -> Result<Vec<Direction>> {
    let table = Table::read("--directions", path)?;
    let mut columns = UNNAMED;
    let mut directions = Vec::new();
    for (before, row) in table.rows(MOST).enumerate() {
        let row = row?;
        if before == 0 && row.cells.iter().all(|cell| cell.parse::<f64>().is_err()) {
            columns = named(&row).map_err(|complaint| table.wrong(&complaint))?;
            continue;
        }
        let found = direction(&row.cells, columns);
        directions.push(found.map_err(|complaint| table.wrong(&row.wrong(&complaint)))?);
    }
    if directions.is_empty() { Err(Error::request(format!("{} has no row", table.name))) } else { Ok(directions) }
}

/// The columns that a header names.
fn named(header: &Row) -> std::result::Result<[Column; 2], String> {
    let mut columns = Vec::new();
    for (at, name) in header.cells.iter().enumerate() {
        let shown: String = name.chars().take(60).collect();
        let Some(column) = column(name) else {
            return Err(header.wrong_in(
                at,
                &format!(
                    "{shown:?} is no column of directions; they are elevation or zenith, and azimuth, with _deg or _rad"
                ),
            ));
        };
        columns.push(column);
    }
    match columns[..] {
        [(Angle::Azimuth, _), (Angle::Azimuth, _)] => {}
        [first, second] if first.0 == Angle::Azimuth || second.0 == Angle::Azimuth => return Ok([first, second]),
        _ => {}
    }
    Err(header.wrong("an azimuth is wanted, and one elevation or zenith"))
}

/// What a column of a name holds: an angle, and its unit if the name has one.
fn column(name: &str) -> Option<Column> {
    let name = name.to_lowercase().replace('°', " deg ");
    let words = name.split(|c: char| !c.is_alphanumeric()).filter(|word| !["", "view", "angle"].contains(word));
    let (angle, unit) = match words.collect::<Vec<_>>()[..] {
        [angle] => (angle, "deg"),
        [angle, unit] => (angle, unit),
        _ => return None,
    };
    let angle = match angle {
        "elevation" => Angle::Elevation,
        "zenith" => Angle::Zenith,
        "azimuth" => Angle::Azimuth,
        _ => return None,
    };
    match unit {
        "deg" | "degree" | "degrees" => Some((angle, false)),
        "rad" | "radian" | "radians" => Some((angle, true)),
        _ => None,
    }
}

fn direction(cells: &[String], columns: [Column; 2]) -> std::result::Result<Direction, String> {
    let numbers: Vec<f64> = cells.iter().filter_map(|cell| cell.parse().ok()).collect();
    let wanted = || {
        if columns == UNNAMED {
            return "an elevation and an azimuth in degrees are wanted, such as 20,90".into();
        }
        format!("two numbers are wanted, as the header says, not {} cells that hold {}", cells.len(), numbers.len())
    };
    let pair: [f64; 2] = numbers[..].try_into().ok().filter(|_| cells.len() == 2).ok_or_else(wanted)?;
    let mut direction = Direction::new(0.0, 0.0);
    for ((angle, in_radians), number) in columns.into_iter().zip(pair) {
        let degrees = if in_radians { decimal(number.to_degrees()) } else { number };
        match angle {
            Angle::Azimuth => direction.azimuth = degrees,
            Angle::Elevation => direction.elevation = within_rounding(degrees, in_radians),
            Angle::Zenith if (-1e-3..=180.001).contains(&degrees) => {
                direction.elevation = within_rounding(decimal(90.0 - degrees), in_radians);
            }
            Angle::Zenith => return Err(format!("zenith is {degrees}; it must lie between 0 and 180 degrees")),
        }
    }
    direction.vector().map(|_| direction).map_err(|error| error.to_string())
}

/// An elevation that is straight up or down, where its radians were rounded: tables say 1.5708 for π/2, which is
/// 90.0002 degrees.
fn within_rounding(elevation: f64, in_radians: bool) -> f64 {
    let is_rounded = in_radians && (90.0..90.001).contains(&elevation.abs());
    if is_rounded { 90.0_f64.copysign(elevation) } else { elevation }
}

/// Computed degrees, rounded to the digits of the input.
fn decimal(degrees: f64) -> f64 {
    (degrees * 1e9).round() / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::tests::{read_text, refuses};

    #[test]
    fn each_row_is_a_direction_whatever_its_columns_are_called() {
        let expected = [Direction::new(90.0, 0.0), Direction::new(-2.5, 180.0)];
        for text in [
            "90,0\n-2.5,180\n",
            "# a scan\nelevation, azimuth\n90 , 0\n\n-2.5,180",
            "azimuth,elevation\n0,90\n180,-2.5\n",
            "view_elevation,view_azimuth\n90,0\n-2.5,180\n",
            "zenith,azimuth\n0,0\n92.5,180\n",
            "\u{feff}\"Azimuth (°)\",\"Zenith angle [deg]\"\r\n\"0\",\"0\"\r\n\"180\",\"92.5\"\r\n",
            "elevation_rad,azimuth_deg\n1.5708,0\n-0.04363323129985824,180\n",
            "azimuth (radians),view zenith angle (rad)\n0,0\n3.141592653589793,1.6144295580947547\n",
        ] {
            assert_eq!(read_text(text, read).unwrap(), expected, "{text:?}");
        }
    }

    #[test]
    fn what_is_no_direction_is_told_with_its_place() {
        let cases = [
            ("", " has no row"),
            ("elevation,azimuth\n", " has no row"),
            ("90,0\n91,0\n", "line 2: view_elevation is 91; it must lie between -90 and 90"),
            ("90,0\n1,2,3\n", "line 2: an elevation and an azimuth"),
            ("90\n", "line 1: an elevation and an azimuth"),
            ("nan,0\n", "line 1: view_elevation is NaN"),
            ("a,b\n20,30\n", "line 1, column 1: \"a\" is no column of directions; they are elevation or zenith"),
            ("elevation,azimuth_gon\n20,30\n", "line 1, column 2: \"azimuth_gon\" is no column"),
            ("elevation,sun_azimuth\n20,30\n", "line 1, column 2: \"sun_azimuth\" is no column"),
            ("elevation,azimuth,elevation\n20,30,20\n", "line 1: an azimuth is wanted, and one elevation or zenith"),
            ("elevation,zenith\n20,70\n", "line 1: an azimuth is wanted, and one elevation or zenith"),
            ("azimuth,azimuth\n20,70\n", "line 1: an azimuth is wanted"),
            ("azimuth\n20\n", "line 1: an azimuth is wanted"),
            ("azimuth,elevation\n90,20\n90,x\n", "line 3: two numbers are wanted, as the header says"),
            ("azimuth,zenith\n90,200\n", "line 2: zenith is 200; it must lie between 0 and 180 degrees"),
            ("azimuth,zenith\n90,-1\n", "line 2: zenith is -1"),
            ("elevation_rad,azimuth_rad\n20,90\n", "line 2: view_elevation is 1145.9"),
            ("elevation;azimuth\n20;90\n", "line 1: semicolons part the cells"),
            ("20;90\n", "line 1: semicolons part the cells"),
            ("20\t90\n", "line 1: tabs part the cells"),
        ];
        refuses(read, &cases);
    }
}
