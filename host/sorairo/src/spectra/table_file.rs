//! A spectral table of a person's own.

use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use super::mean::{self, Window};
use super::range::{END, START, STEP};
use super::table::Table;
use crate::input::{self, LARGEST_TABLE, shown};

/// The wavelengths (nm) that a person's table must cover: those of the observer's sum.
pub const NEEDED_RANGE: (f64, f64) = (START, END);

/// A spectrum that a person gives: the name of a CSV file, and what it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFile {
    path: PathBuf,
    /// The name by which images and other files know it; see [`TableFile::name_from`].
    name: PathBuf,
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
        let mut file = Self { path: path.to_owned(), name: PathBuf::new(), table: Arc::new(table) };
        file.name_from(Path::new("."));
        Ok(file)
    }

    /// Names it in files as it is found from a folder: that of the scene, which may move with it to another machine. Where the two have no folder in
    /// common its place tells of the machine alone, and its own name is left.
    pub(crate) fn name_from(&mut self, folder: &Path) {
        self.name = found_from(folder, &self.path).unwrap_or_else(|| self.path.clone());
    }

    /// The same with that name as its path.
    #[cfg(feature = "encoding")]
    pub(crate) fn as_named(&self) -> Self {
        Self { path: self.name.clone(), ..self.clone() }
    }

    /// One that is no file.
    pub(crate) fn holding(name: &str, table: Table<1>) -> Self {
        Self { path: name.into(), name: name.into(), table: Arc::new(table) }
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

/// The name of a file from a folder; none where there are no folders.
fn found_from(folder: &Path, file: &Path) -> Option<PathBuf> {
    let (folder, file) = (whole(folder)?, whole(file)?);
    let shared = folder.components().zip(file.components()).take_while(|(a, b)| a == b).map(|(shared, _)| shared);
    if !shared.clone().any(|part| matches!(part, Component::Normal(_))) {
        return file.file_name().map(PathBuf::from);
    }
    let shared = shared.count();
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    Some(up.chain(file.components().skip(shared)).collect())
}

/// A path from the root, without steps back.
fn whole(path: &Path) -> Option<PathBuf> {
    let mut whole = PathBuf::new();
    for part in std::path::absolute(Path::new(".").join(path)).ok()?.components() {
        if part == Component::ParentDir {
            whole.pop();
        } else {
            whole.push(part);
        }
    }
    Some(whole)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_named_as_it_is_found_from_the_scene() {
        for (folder, file, name) in [
            ("/home/a/work", "/home/a/work/x.csv", "x.csv"),
            ("/home/a/work", "/home/a/work/tables/x.csv", "tables/x.csv"),
            ("/home/a/work/", "/home/a/work/../tables/./x.csv", "../tables/x.csv"),
            ("/home/a/b/../work", "/home/a/tables/x.csv", "../tables/x.csv"),
            // As from a scene on standard input.
            ("/dev", "/home/a/x.csv", "x.csv"),
            (".", "tables/x.csv", "tables/x.csv"),
            ("", "x.csv", "x.csv"),
            ("scenes", "x.csv", "../x.csv"),
        ] {
            assert_eq!(found_from(Path::new(folder), Path::new(file)).unwrap(), Path::new(name), "{folder} {file}");
        }
    }
}
