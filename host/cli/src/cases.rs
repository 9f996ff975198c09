//! The cases of a table: a sky for each row, by the keys of a scene that its header names.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};
use sorairo::scene::ValidScene;
use sorairo::scene::file::Draft;
use sorairo::scene::keys::{self, Key};

use crate::error::{Error, Result};
use crate::ranges::MOST_FRAMES;
use crate::values::Values;

/// A table of cases.
pub struct Cases {
    file: String,
    /// What its columns are.
    pub keys: Vec<&'static Key>,
    rows: Vec<Row>,
}

/// A case.
struct Row {
    /// Its line in the file, from 1.
    line: u64,
    cells: Vec<String>,
}

impl Cases {
    /// Reads a CSV file: a header of keys, and a row for each case. Lines that begin with # are comments.
    ///
    /// # Errors
    ///
    /// A file that cannot be read; a column that is no key, or one that stands there twice; rows of another length, none, or too many.
    pub fn read(path: &Path) -> Result<Self> {
        let file = path.display().to_string();
        let wrong = |complaint: String| Error::request(format!("--table {file}{complaint}"));
        let reader = ReaderBuilder::new().comment(Some(b'#')).trim(Trim::All).from_path(path);
        let mut reader = reader.map_err(|error| wrong(format!(": {error}")))?;
        let header = reader.headers().map_err(|error| wrong(reason(&error)))?.clone();
        let keys = columns(&header).map_err(|(column, complaint)| {
            wrong(format!(", line {}, column {column}: {complaint}", header.position().map_or(1, csv::Position::line)))
        })?;
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| wrong(reason(&error)))?;
            let line = record.position().map_or(0, csv::Position::line);
            rows.push(Row { line, cells: record.iter().map(str::to_owned).collect() });
            if rows.len() > MOST_FRAMES as usize {
                return Err(wrong(format!(" has more than {MOST_FRAMES} rows")));
            }
        }
        if rows.is_empty() {
            return Err(wrong(" has no row under its header".into()));
        }
        Ok(Self { file, keys, rows })
    }

    /// The scene of each case, over values that all share.
    ///
    /// # Errors
    ///
    /// The first row that is no scene, with its line and its column.
    pub fn scenes(&self, shared: &Values, draft: &Draft) -> Result<Vec<ValidScene>> {
        self.rows.iter().map(|row| self.scene(row, shared, draft)).collect()
    }

    fn scene(&self, row: &Row, shared: &Values, draft: &Draft) -> Result<ValidScene> {
        let cells = self.keys.iter().map(|key| key.name).zip(row.cells.iter().map(String::as_str));
        shared.with_cells(cells).over(draft.clone()).map_err(|error| {
            let key = match &error {
                sorairo::Error::OutOfRange { key, .. } | sorairo::Error::NotAllowed { key, .. } => Some(*key),
                _ => None,
            };
            let column = self.keys.iter().position(|known| Some(known.name) == key);
            let column = column.map(|column| format!(", column {}", column + 1)).unwrap_or_default();
            Error::request(format!("--table {}, line {}{column}: {error}", self.file, row.line))
        })
    }

    /// The cells of each case, as they stand in the file.
    pub fn cells(&self) -> impl Iterator<Item = &[String]> {
        self.rows.iter().map(|row| &row.cells[..])
    }
}

/// The keys of a header, or the column that is none and why.
fn columns(header: &StringRecord) -> std::result::Result<Vec<&'static Key>, (usize, String)> {
    let mut found: Vec<&'static Key> = Vec::new();
    for (column, name) in header.iter().enumerate() {
        let wrong = |complaint: String| Err((column + 1, complaint));
        let Some(key) = keys::find(name) else {
            let shown: String = name.chars().take(60).collect();
            return wrong(format!("{shown:?} is no key of a scene; `sorairo scene reference` lists all of them"));
        };
        if key.name == "preset" {
            return wrong("the preset is that of all cases: give --preset, or a scene file".into());
        }
        if found.iter().any(|before| before.name == key.name) {
            return wrong(format!("{name} stands there twice"));
        }
        found.push(key);
    }
    Ok(found)
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
mod tests {
    use sorairo::scene::Preset;

    use super::*;

    fn scenes(text: &str) -> Result<Vec<ValidScene>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cases.csv");
        std::fs::write(&path, text).unwrap();
        Cases::read(&path)?.scenes(&Values::default(), &Draft::of(Preset::Standard))
    }

    #[test]
    fn each_row_is_a_scene() {
        let scenes = scenes("# a comment\nsun.elevation, atmosphere.aerosol.optical_depth,ground.albedo,sun.disc,render.steps\n10,0.1,grass,true,16\n-2.5,0,0.3,false,24\n").unwrap();
        let found: Vec<_> = scenes
            .iter()
            .map(|scene| {
                (scene.sun.elevation, scene.atmosphere.aerosol.optical_depth, scene.sun.disc, scene.render.steps)
            })
            .collect();
        assert_eq!(found, [(10.0, 0.1, true, Some(16)), (-2.5, 0.0, false, Some(24))]);
        assert!(scenes[0].ground.albedo.at(800.0) > 0.3 && scenes[1].ground.albedo.at(800.0) == 0.3);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        for (text, words) in [
            ("sun.elevation,moon\n1,2\n", "line 1, column 2: \"moon\" is no key"),
            ("sun.elevation,sun.elevation\n1,2\n", "line 1, column 2: sun.elevation stands there twice"),
            ("preset\nearth\n", "column 1: the preset is that of all cases"),
            ("sun.elevation\n1\n100\n", "line 3, column 1: sun.elevation is 100; it must lie"),
            ("sun.elevation\nhigh\n", "line 2: sun.elevation: invalid type: string \"high\""),
            ("sun.elevation,sun.azimuth\n1\n", "line 2: the row has 1 values, and the header 2"),
            ("sun.elevation\n", "has no row"),
            ("sun.elevation\nnan\n", "line 2, column 1: sun.elevation is NaN"),
        ] {
            let error = scenes(text).expect_err(text);
            assert!(error.exit_code() == 2 && error.to_string().contains(words), "{text:?}: {error}");
        }
    }
}
