//! A user's spectral table.

use std::path::Path;
use std::sync::Arc;

use super::mean::{self, Window};
use super::named_file::NamedFile;
use super::range::{END, START, STEP};
use super::table::Table;
use crate::input::{self, LARGEST_TABLE, shown};

/// The wavelengths (nm) that a user table must cover: those of the observer's sum.
pub const NEEDED_RANGE: (f64, f64) = (START, END);

/// A spectrum from a user: the name of a CSV file, and its content.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFile {
    /// Its name.
    pub file: NamedFile,
    table: Arc<Table<1>>,
}

impl TableFile {
    /// Reads `wavelength_nm, value` rows; see [`Table::parse`]. They must cover [`NEEDED_RANGE`].
    ///
    /// # Errors
    ///
    /// One sentence with the file's name, and the line where there is one.
    pub fn read(path: &Path) -> Result<Self, String> {
        let name = path.display();
        let text = input::read_text(path, LARGEST_TABLE).map_err(|complaint| format!("{name} {complaint}"))?;
        let table = Table::parse(&text).map_err(|complaint| format!("{name}, {complaint}"))?;
        let ((shortest, longest), (first, last)) = (NEEDED_RANGE, table.range());
        let missing: Vec<String> = [(shortest, first), (last, longest)]
            .iter()
            .filter(|(from, to)| from < to)
            .map(|(from, to)| format!("{} to {} nm", shown(from.max(shortest)), shown(to.min(longest))))
            .collect();
        if !missing.is_empty() {
            return Err(format!(
                "{name} holds {} to {} nm; {} are missing of {shortest} to {longest} nm, which colours need",
                shown(first),
                shown(last),
                missing.join(" and ")
            ));
        }
        Ok(Self { file: NamedFile::new(path), table: Arc::new(table) })
    }

    /// One that is no file.
    pub(crate) fn holding(name: &str, table: Table<1>) -> Self {
        Self { file: NamedFile::nowhere(Path::new(name)), table: Arc::new(table) }
    }

    /// The name of the file.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// The CRC-32 of what it holds, by which a file that has changed is told from before.
    pub fn checksum(&self) -> u32 {
        checksum_of(self.table.rows().flat_map(|(wavelength, [value])| [wavelength, value]))
    }

    /// The same file with means over what a value stands for, weighed by a table, in the place of what it holds; itself
    /// where all of its rows are nodes of the sum that is meant. See [`mean`].
    pub(crate) fn over(&self, window: Window, weighed_by: Option<&Table<1>>) -> Self {
        if matches!(window, Window::Node(step) if self.table.is_on_steps(step)) {
            return self.clone();
        }
        Self { table: Arc::new(mean::over(window, &self.table, weighed_by)), ..self.clone() }
    }

    /// Whether a sum over the observer's nodes misses nothing between them.
    pub(crate) fn is_on_steps(&self) -> bool {
        self.table.is_on_steps(STEP)
    }

    /// What it holds.
    pub fn table(&self) -> &Table<1> {
        &self.table
    }
}

/// The CRC-32 of numbers.
pub(crate) fn checksum_of(numbers: impl Iterator<Item = f64>) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    numbers.for_each(|number| hasher.update(&number.to_le_bytes()));
    hasher.finalize()
}
