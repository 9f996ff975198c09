//! A spectral table of a person's own.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::mean;
use super::observer::{END, START, STEP};
use super::table::Table;
use crate::input::{self, LARGEST_TABLE, shown};

/// The wavelengths (nm) that a person's table must cover: those of the observer's sum.
pub const NEEDED_RANGE: (f64, f64) = (START, END);

/// A spectrum that a person gives: the name of a CSV file, and what it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFile {
    path: PathBuf,
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
        Ok(Self { path: path.to_owned(), table: Arc::new(table) })
    }

    /// One that is no file.
    pub(crate) fn holding(name: &str, table: Table<1>) -> Self {
        Self { path: name.into(), table: Arc::new(table) }
    }

    /// The name of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The CRC-32 of what it holds, by which a file that has changed is told from before.
    pub fn checksum(&self) -> u32 {
        let mut hasher = crc32fast::Hasher::new();
        let numbers = self.table.rows().flat_map(|(wavelength, [value])| [wavelength, value]);
        numbers.for_each(|number| hasher.update(&number.to_le_bytes()));
        hasher.finalize()
    }

    /// The same file with means over what a node of the observer's sum stands for, weighed by a table, in the place of what it holds; itself
    /// where all of its rows are nodes. See [`mean`].
    pub(crate) fn over_steps(&self, weighed_by: Option<&Table<1>>) -> Self {
        if self.is_on_steps() {
            return self.clone();
        }
        Self { path: self.path.clone(), table: Arc::new(mean::over_steps(&self.table, weighed_by)) }
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
