//! Files of columns of numbers that are no spectra of colours: they may begin and end anywhere.

use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::named_file::NamedFile;
use super::table_file::checksum_of;
use crate::input::{self, LARGEST_TABLE, shown};
use crate::rows::{Row, rows};

/// The numbers of a file.
#[derive(Debug)]
pub struct Columns {
    /// The numbers in the heads of the columns after the first, where each has one.
    pub heads: Option<Vec<f64>>,
    /// The names of all columns, where the first row has them.
    pub names: Vec<String>,
    /// The first column, which increases, and the others.
    pub rows: Vec<(f64, Vec<f64>)>,
    /// The line of the text where each row stood.
    pub lines: Vec<u64>,
}

impl Columns {
    /// Reads a table.
    ///
    /// # Errors
    ///
    /// One sentence, with the line where there is one.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut columns = Self { heads: None, names: Vec::new(), rows: Vec::new(), lines: Vec::new() };
        for (before, row) in rows(text).enumerate() {
            let row = row?;
            if before == 0 && row.cells[0].parse::<f64>().is_err() {
                columns.heads = row.cells[1..].iter().map(|cell| number_in(cell)).collect();
                columns.names = row.cells;
                continue;
            }
            columns.add(&row).map_err(|complaint| row.wrong(&complaint))?;
        }
        match columns.rows.len() {
            0 | 1 => Err(format!("a table needs at least two rows, and this has {}", columns.rows.len())),
            _ => Ok(columns),
        }
    }

    fn add(&mut self, row: &Row) -> Result<(), String> {
        let number = |(column, cell): (usize, &String)| match cell.parse::<f64>() {
            Ok(number) if number.is_finite() && number >= 0.0 => Ok(number),
            _ => Err(format!("column {} is {cell:?}; it must be a number of 0 or more", column + 1)),
        };
        let numbers = row.cells.iter().enumerate().map(number).collect::<Result<Vec<_>, _>>()?;
        let wanted = self.rows.first().map_or(numbers.len().max(2), |(_, first)| first.len() + 1);
        if numbers.len() != wanted {
            return Err(format!("{} columns instead of {wanted}", numbers.len()));
        }
        if let Some((last, _)) = self.rows.last().filter(|(last, _)| *last >= numbers[0]) {
            return Err(format!("{} follows {}; the first column must increase", shown(numbers[0]), shown(*last)));
        }
        self.rows.push((numbers[0], numbers[1..].to_vec()));
        self.lines.push(row.line);
        Ok(())
    }

    /// The second column, where it is the last and each of its values is allowed.
    ///
    /// # Errors
    ///
    /// A sentence with the line.
    pub fn pairs(&self, allowed: &str, is_allowed: impl Fn(f64) -> bool) -> Result<Vec<(f64, f64)>, String> {
        let pair = |((at, values), line): (&(f64, Vec<f64>), &u64)| match values[..] {
            [value] if is_allowed(value) => Ok((*at, value)),
            [value] => Err(format!("line {line}: column 2 is {}; it must be {allowed}", shown(value))),
            _ => Err(format!("line {line}: {} columns instead of 2", values.len() + 1)),
        };
        self.rows.iter().zip(&self.lines).map(pair).collect()
    }
}

/// The number in the head of a column, such as `440`, `440 nm` or `phase_440nm`.
fn number_in(head: &str) -> Option<f64> {
    let start = head.find(|c: char| c.is_ascii_digit())?;
    let rest = &head[start..];
    let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
    rest[..end].parse().ok()
}

/// What is made of the columns of a file.
pub trait FromColumns: Sized {
    /// The columns of a text: those of a table.
    ///
    /// # Errors
    ///
    /// One sentence, with the line where there is one.
    fn columns(text: &str) -> Result<Columns, String> {
        Columns::parse(text)
    }

    /// What the columns say.
    ///
    /// # Errors
    ///
    /// One sentence, with the line where there is one.
    fn from_columns(columns: &Columns) -> Result<Self, String>;
}

/// What a file of columns says, and its name.
#[derive(Debug, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String", bound = "T: FromColumns")]
pub struct FileOf<T: FromColumns> {
    /// Its name.
    pub file: NamedFile,
    /// The CRC-32 of what it holds.
    pub checksum: u32,
    /// What it says.
    pub value: Arc<T>,
}

impl<T: FromColumns> Clone for FileOf<T> {
    fn clone(&self) -> Self {
        Self { file: self.file.clone(), checksum: self.checksum, value: Arc::clone(&self.value) }
    }
}

impl<T: FromColumns> PartialEq for FileOf<T> {
    fn eq(&self, other: &Self) -> bool {
        (&self.file, self.checksum) == (&other.file, other.checksum)
    }
}

impl<T: FromColumns> TryFrom<String> for FileOf<T> {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let path = Path::new(&name);
        let text = input::read_text(path, LARGEST_TABLE).map_err(|complaint| format!("{name} {complaint}"))?;
        let columns = T::columns(&text).map_err(|complaint| format!("{name}, {complaint}"))?;
        let value = T::from_columns(&columns).map_err(|complaint| format!("{name}, {complaint}"))?;
        let numbers = columns.rows.iter().flat_map(|(first, others)| [*first].into_iter().chain(others.clone()));
        let checksum = checksum_of(numbers.chain(columns.heads.iter().flatten().copied()));
        Ok(Self { file: NamedFile::new(path), checksum, value: Arc::new(value) })
    }
}

impl<T: FromColumns> From<FileOf<T>> for String {
    fn from(file: FileOf<T>) -> Self {
        file.file.path().to_string_lossy().into_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_headed_by_the_numbers_in_their_names() {
        let columns = Columns::parse("# of a day\nangle_deg, 440, phase_675nm\n0, 60, 50\n180, 0.2, 0.25\n").unwrap();
        assert_eq!(columns.heads, Some(vec![440.0, 675.0]));
        assert_eq!(columns.rows, [(0.0, vec![60.0, 50.0]), (180.0, vec![0.2, 0.25])]);
        assert_eq!(Columns::parse("altitude_km,density\n0,1\n2,0\n").unwrap().heads, None);
    }

    #[test]
    fn a_bad_row_is_named_by_its_line() {
        for (text, words) in [
            ("0,1\n1,-999\n", "line 2: column 2 is \"-999\"; it must be a number of 0 or more"),
            ("0,1\n1,2,3\n", "line 2: 3 columns instead of 2"),
            ("a,b\n2,1\n1,2\n", "line 3: 1 follows 2; the first column must increase"),
            ("0\n1\n", "line 1: 1 columns instead of 2"),
            ("0,1\n", "two rows, and this has 1"),
        ] {
            let error = Columns::parse(text).unwrap_err();
            assert!(error.contains(words), "{text:?}: {error}");
        }
        let pairs = Columns::parse("0,1\n1,2\n").unwrap().pairs("at most 1", |value| value <= 1.0);
        assert_eq!(pairs.unwrap_err(), "line 2: column 2 is 2; it must be at most 1");
    }
}
