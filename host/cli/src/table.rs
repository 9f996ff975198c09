//! The tables (CSV) that flags name. Lines that begin with # are comments.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use csv::{Position, Reader, ReaderBuilder, StringRecord, Trim};

use crate::error::{Error, Result};

/// A table that is being read.
pub struct Table {
    /// The flag and its file, with which every complaint begins.
    pub name: String,
    text: Arc<[u8]>,
    reader: Reader<Cursor<Arc<[u8]>>>,
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
        let text: Arc<[u8]> = std::fs::read(path).map_err(|error| wrong(&name, &format!(": {error}")))?.into();
        Ok(Self { name, reader: builder.from_reader(Cursor::new(Arc::clone(&text))), text })
    }

    /// The header of a table that has one.
    ///
    /// # Errors
    ///
    /// A header that cannot be read.
    pub fn header(&mut self) -> Result<Row> {
        let Self { name, text, reader } = self;
        let cells = reader.headers().cloned().map_err(|error| wrong(name, &reason(&error, text)))?;
        Ok(Row { line: line(cells.position(), text), cells })
    }

    /// The rows below the header, or all where there is none. A row that cannot be read, one of another length than the header and the first
    /// beyond `most` are errors.
    pub fn rows(&mut self, most: usize) -> impl Iterator<Item = Result<Row>> {
        let Self { name, text, reader } = self;
        reader.records().enumerate().map(move |(before, record)| {
            let cells = record.map_err(|error| wrong(name, &reason(&error, text)))?;
            if before == most {
                return Err(wrong(name, &format!(" has more than {most} rows")));
            }
            Ok(Row { line: line(cells.position(), text), cells })
        })
    }
}

/// What is wrong with a table, by its name.
pub fn wrong(name: &str, complaint: &str) -> Error {
    Error::request(format!("{name}{complaint}"))
}

/// The line of a row in a text, from 1.
fn line(position: Option<&Position>, text: &[u8]) -> u64 {
    let Some(position) = position else { return 1 };
    // The reader counts from where it stood, which is before the empty lines and the comments that it skips.
    let rest = text[position.byte() as usize..].split(|&byte| byte == b'\n');
    let skipped = rest.take_while(|line| line.is_empty() || *line == b"\r" || line.starts_with(b"#")).count();
    position.line() + skipped as u64
}

/// What is wrong with a row, in one line with its place.
fn reason(error: &csv::Error, text: &[u8]) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = line(pos.as_ref(), text);
            format!(", line {line}: the row has {len} values, and the header {expected_len}")
        }
        csv::ErrorKind::Utf8 { pos, .. } => {
            format!(", line {}: it is not UTF-8", line(pos.as_ref(), text))
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
            read_text("# c\r\na, b\n\n1 ,2\n# d\n\n3,4\n", |path| {
                let mut table = Table::open("--table", path, true)?;
                let Row { line, cells } = table.header()?;
                assert_eq!((line, &cells), (2, &StringRecord::from(vec!["a", "b"])));
                let rows: Result<Vec<_>> = table.rows(most).collect();
                Ok(rows?.iter().map(|row| (row.line, row.cells[0].to_owned())).collect::<Vec<_>>())
            })
        };
        assert_eq!(lines(2).unwrap(), [(4, "1".to_owned()), (7, "3".to_owned())]);
        assert!(lines(1).unwrap_err().to_string().ends_with("table.csv has more than 1 rows"));
    }
}
