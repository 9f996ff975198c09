//! The directions of a table: an elevation and an azimuth in each row.

use std::path::Path;

use csv::StringRecord;
use sorairo::low_level::spectrum::Direction;

use crate::error::Result;
use crate::table::{Row, Table, wrong};

/// Most rows of a table.
const MOST: usize = 1_000_000;

/// Reads a CSV file. Lines that begin with # are comments, and the first other line may name the columns.
///
/// # Errors
///
/// A file that cannot be read, the first row that is no direction, no row or too many.
pub fn read(path: &Path) -> Result<Vec<Direction>> {
    let mut table = Table::open("--directions", path, false)?;
    let name = table.name.clone();
    let mut directions = Vec::new();
    for (before, row) in table.rows(MOST).enumerate() {
        let Row { line, cells } = row?;
        if before == 0 && cells.iter().all(|cell| cell.parse::<f64>().is_err()) {
            continue;
        }
        directions.push(direction(&cells).map_err(|complaint| wrong(&name, &format!(", line {line}: {complaint}")))?);
    }
    if directions.is_empty() { Err(wrong(&name, " has no row")) } else { Ok(directions) }
}

fn direction(row: &StringRecord) -> std::result::Result<Direction, String> {
    let numbers: Vec<f64> = row.iter().filter_map(|cell| cell.parse().ok()).collect();
    match numbers[..] {
        [elevation, azimuth] if row.len() == 2 => {
            let direction = Direction { elevation, azimuth };
            direction.vector().map(|_| direction).map_err(|error| error.to_string())
        }
        _ => Err("an elevation and an azimuth in degrees are wanted, such as 20,90".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::tests::{read_text, refuses};

    #[test]
    fn each_row_is_a_direction() {
        let expected = [Direction { elevation: 90.0, azimuth: 0.0 }, Direction { elevation: -2.5, azimuth: 180.0 }];
        for text in ["90,0\n-2.5,180\n", "# a scan\nelevation, azimuth\n90 , 0\n\n-2.5,180"] {
            assert_eq!(read_text(text, read).unwrap(), expected);
        }
        let cases = [
            ("", " has no row"),
            ("elevation,azimuth\n", " has no row"),
            ("90,0\n91,0\n", "line 2: view_elevation is 91; it must lie between -90 and 90"),
            ("90,0\n1,2,3\n", "line 2: an elevation and an azimuth"),
            ("90\n", "line 1: an elevation and an azimuth"),
            ("a,b\nc,d\n", "line 2: an elevation and an azimuth"),
            ("nan,0\n", "line 1: view_elevation is NaN"),
        ];
        refuses(read, &cases);
    }
}
