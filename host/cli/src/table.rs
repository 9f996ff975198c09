//! The tables (CSV) that flags name. Lines that begin with # are comments.

use std::fs::File;
use std::path::Path;

use csv::{Reader, ReaderBuilder, StringRecord, Trim};

use crate::error::{Error, Result};

/// A table that is being read.
pub struct Table {
    /// The flag and its file, with which every complaint begins.
    pub name: String,
    reader: Reader<File>,
}

/// A row.
pub struct Row {
    /// Its line in the file, from 1.
    pub line: u64,
    /// Its cells, without the spaces around them.
    pub cells: StringRecord,
}

impl Table {
    /// Opens the file of a flag.
    ///
    /// # Errors
    ///
    /// A file that cannot be read.
    pub fn open(flag: &str, path: &Path, has_header: bool) -> Result<Self> {
        let name = format!("{flag} {}", path.display());
        let mut builder = ReaderBuilder::new();
        builder.comment(Some(b'#')).trim(Trim::All).has_headers(has_header).flexible(!has_header);
        let reader = builder.from_path(path).map_err(|error| wrong(&name, &format!(": {error}")))?;
        Ok(Self { name, reader })
    }

    /// The header of a table that has one.
    ///
    /// # Errors
    ///
    /// A header that cannot be read.
    pub fn header(&mut self) -> Result<Row> {
        let cells = self.reader.headers().cloned().map_err(|error| wrong(&self.name, &reason(&error)))?;
        Ok(Row { line: cells.position().map_or(1, csv::Position::line), cells })
    }

    /// The rows below the header, or all where there is none. A row that cannot be read, one of another length than the header and the first
    /// beyond `most` are errors.
    pub fn rows(&mut self, most: usize) -> impl Iterator<Item = Result<Row>> {
        let name = &self.name;
        self.reader.records().enumerate().map(move |(before, record)| {
            let cells = record.map_err(|error| wrong(name, &reason(&error)))?;
            if before == most {
                return Err(wrong(name, &format!(" has more than {most} rows")));
            }
            Ok(Row { line: cells.position().map_or(0, csv::Position::line), cells })
        })
    }
}

/// What is wrong with a table, by its name.
pub fn wrong(name: &str, complaint: &str) -> Error {
    Error::request(format!("{name}{complaint}"))
}

/// What is wrong with a row, in one line with its place.
fn reason(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = pos.as_ref().map_or(0, csv::Position::line);
            format!(", line {line}: the row has {len} values, and the header {expected_len}")
        }
        csv::ErrorKind::Utf8 { pos, .. } => {
            format!(", line {}: it is not UTF-8", pos.as_ref().map_or(0, csv::Position::line))
        }
        _ => format!(": {error}"),
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// What is read of a file that holds a text.
    pub fn read_text<T>(text: &str, read: impl Fn(&Path) -> Result<T>) -> Result<T> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        std::fs::write(&path, text).unwrap();
        read(&path)
    }

    /// Texts that are refused, each as a wrong request with these words.
    pub fn refuses<T>(read: impl Fn(&Path) -> Result<T>, cases: &[(&str, &str)]) {
        for (text, words) in cases {
            let error = read_text(text, &read).err().unwrap_or_else(|| panic!("{text:?}"));
            assert!(error.exit_code() == 2 && error.to_string().contains(words), "{text:?}: {error}");
        }
    }

    #[test]
    fn a_row_knows_its_line_and_there_are_no_more_than_were_asked_for() {
        let lines = |most| {
            read_text("# c\na, b\n\n1 ,2\n3,4\n", |path| {
                let mut table = Table::open("--table", path, true)?;
                assert_eq!(&table.header()?.cells, vec!["a", "b"]);
                let rows: Result<Vec<_>> = table.rows(most).collect();
                Ok(rows?.iter().map(|row| (row.line, row.cells[0].to_owned())).collect::<Vec<_>>())
            })
        };
        assert_eq!(lines(2).unwrap(), [(4, "1".to_owned()), (5, "3".to_owned())]);
        assert!(lines(1).unwrap_err().to_string().ends_with("table.csv has more than 1 rows"));
    }
}
