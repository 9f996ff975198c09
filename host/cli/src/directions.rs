//! The directions of a table: an elevation and an azimuth in each row.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};
use sorairo::low_level::spectrum::Direction;

use crate::error::{Error, Result};

/// Most directions of a table.
const MOST: usize = 1_000_000;

/// Reads a CSV file. Lines that begin with # are comments, and the first other line may name the columns.
///
/// # Errors
///
/// A file that cannot be read, the first row that is no direction, no row or too many.
pub fn read(path: &Path) -> Result<Vec<Direction>> {
    let wrong = |complaint: String| Error::request(format!("--directions {}{complaint}", path.display()));
    let reader =
        ReaderBuilder::new().comment(Some(b'#')).trim(Trim::All).has_headers(false).flexible(true).from_path(path);
    let mut reader = reader.map_err(|error| wrong(format!(": {error}")))?;
    let mut directions = Vec::new();
    let mut header_allowed = true;
    for record in reader.records() {
        let record = record.map_err(|error| wrong(format!(": {error}")))?;
        let is_header = header_allowed && record.iter().all(|cell| cell.parse::<f64>().is_err());
        header_allowed = false;
        if is_header {
            continue;
        }
        let line = record.position().map_or(0, csv::Position::line);
        directions.push(direction(&record).map_err(|complaint| wrong(format!(", line {line}: {complaint}")))?);
        if directions.len() > MOST {
            return Err(wrong(format!(" has more than {MOST} rows")));
        }
    }
    if directions.is_empty() { Err(wrong(" has no row".into())) } else { Ok(directions) }
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

    fn read_text(text: &str) -> Result<Vec<Direction>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("directions.csv");
        std::fs::write(&path, text).unwrap();
        read(&path)
    }

    #[test]
    fn each_row_is_a_direction() {
        let expected = [Direction { elevation: 90.0, azimuth: 0.0 }, Direction { elevation: -2.5, azimuth: 180.0 }];
        for text in ["90,0\n-2.5,180\n", "# a scan\nelevation, azimuth\n90 , 0\n\n-2.5,180"] {
            assert_eq!(read_text(text).unwrap(), expected);
        }
        for (text, words) in [
            ("", " has no row"),
            ("elevation,azimuth\n", " has no row"),
            ("90,0\n91,0\n", "line 2: view_elevation is 91; it must lie between -90 and 90"),
            ("90,0\n1,2,3\n", "line 2: an elevation and an azimuth"),
            ("90\n", "line 1: an elevation and an azimuth"),
            ("a,b\nc,d\n", "line 2: an elevation and an azimuth"),
            ("nan,0\n", "line 1: view_elevation is NaN"),
        ] {
            let error = read_text(text).expect_err(text);
            assert!(error.exit_code() == 2 && error.to_string().contains(words), "{text:?}: {error}");
        }
    }
}
