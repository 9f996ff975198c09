//! The tables (CSV) that flags name.

use std::path::Path;

use sorairo::rows::{self, Row};

use crate::error::{Error, Result};

/// Largest table of a flag (bytes).
const LARGEST: u64 = 32 << 20;

/// A table.
pub struct Table {
    /// The flag and its file, with which every complaint begins.
    pub name: String,
    text: String,
}

impl Table {
    /// Reads the file of a flag.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or is too large.
    pub fn read(flag: &str, path: &Path) -> Result<Self> {
        let name = format!("{flag} {}", path.display());
        match rows::read(path, LARGEST) {
            Ok(text) => Ok(Self { name, text }),
            Err(complaint) => Err(Error::request(format!("{name} {complaint}"))),
        }
    }

    /// The rows, as [`rows::rows`] takes them. One that cannot be read and the first beyond a header and `most` are
    /// errors.
    pub fn rows(&self, most: usize) -> impl Iterator<Item = Result<Row>> {
        rows::rows(&self.text).enumerate().map(move |(before, row)| match row {
            Ok(_) if before > most => Err(Error::request(format!("{} has more than {most} rows", self.name))),
            row => row.map_err(|complaint| self.wrong(&complaint)),
        })
    }

    /// What is wrong at a place of the table.
    pub fn wrong(&self, complaint: &str) -> Error {
        Error::request(format!("{}, {complaint}", self.name))
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
    fn there_are_no_more_rows_than_were_asked_for() {
        let lines = |most| {
            let read = |path: &Path| {
                Table::read("--table", path)?.rows(most).map(|row| Ok(row?.line)).collect::<Result<Vec<_>>>()
            };
            read_text("# c\r\na, b\n\n1 ,2\n# d\n\n3,4\n", read)
        };
        assert_eq!(lines(2).unwrap(), [2, 4, 7]);
        assert!(lines(1).unwrap_err().to_string().ends_with("table.csv has more than 1 rows"));
    }

    #[cfg(unix)]
    #[test]
    fn a_table_without_end_is_refused() {
        for path in ["/dev/zero", "/dev/urandom"] {
            let error = Table::read("--table", Path::new(path)).err().unwrap().to_string();
            assert!(error.ends_with("is larger than 32768 KiB, the most that is read"), "{error}");
        }
    }
}
