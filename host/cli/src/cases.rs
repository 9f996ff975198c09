//! The cases of a table: a sky for each row, by the keys of a scene that its header names.

use std::collections::BTreeMap;
use std::path::Path;

use sorairo::rows::Row;
use sorairo::scene::file::Draft;
use sorairo::scene::keys::{self, Key};
use sorairo::scene::{Preset, ValidScene};
use sorairo::words::words;

use crate::error::{Error, Result};
use crate::ranges::MOST_FRAMES;
use crate::table::Table;
use crate::values::Values;

/// A table of cases.
pub struct Cases {
    /// Its flag and its file.
    table: String,
    /// What its columns are.
    pub keys: Vec<&'static Key>,
    rows: Vec<Row>,
}

impl Cases {
    /// Reads a CSV file: a header of keys, and a row for each case. Lines that begin with # are comments.
    ///
    /// # Errors
    ///
    /// A file that cannot be read; a column that is no key, or one that stands there twice; rows of another length,
    /// none, or too many.
    pub fn read(path: &Path) -> Result<Self> {
        let table = Table::read("--table", path)?;
        let mut rows = table.rows(MOST_FRAMES as usize);
        let Some(header) = rows.next().transpose()? else {
            return Err(Error::request(format!("{} has no header", table.name)));
        };
        let keys = columns(&header).map_err(|complaint| table.wrong(&complaint))?;
        let of_all = |row: Result<Row>| {
            let row = row?;
            let (found, wanted) = (row.cells.len(), keys.len());
            let complaint = || row.wrong(&format!("the row has {found} values, and the header {wanted}"));
            if found == wanted { Ok(row) } else { Err(table.wrong(&complaint())) }
        };
        let rows: Vec<_> = rows.map(of_all).collect::<Result<_>>()?;
        if rows.is_empty() {
            return Err(Error::request(format!("{} has no row under its header", table.name)));
        }
        Ok(Self { table: table.name.clone(), keys, rows })
    }

    /// The scene of each case, over values that all share.
    ///
    /// # Errors
    ///
    /// The first row that is no scene, with its line and its column.
    pub fn scenes(&self, shared: &Values, draft: &Draft) -> Result<Vec<ValidScene>> {
        let mut drafts = BTreeMap::new();
        self.rows.iter().map(|row| self.scene(row, shared, draft, &mut drafts)).collect()
    }

    /// The scene of a row. `drafts` are those over the presets that rows have named so far.
    fn scene<'a>(
        &'a self,
        row: &'a Row,
        shared: &Values,
        draft: &Draft,
        drafts: &mut BTreeMap<&'a str, Draft>,
    ) -> Result<ValidScene> {
        let cells = self.keys.iter().map(|key| key.name).zip(row.cells.iter().map(String::as_str));
        let wrong = |error| self.wrong(row, &error);
        let mut begun = draft;
        if let Some((_, name)) = cells.clone().find(|(key, _)| *key == "preset") {
            if !drafts.contains_key(name) {
                drafts.insert(name, begun_as(draft, name).map_err(wrong)?);
            }
            begun = &drafts[name];
        }
        shared.with_cells(cells).over(begun.clone()).map_err(wrong)
    }

    /// What is wrong with a row, with its line and its column.
    fn wrong(&self, row: &Row, error: &sorairo::Error) -> Error {
        let key = match error {
            sorairo::Error::OutOfRange { key, .. } | sorairo::Error::NotAllowed { key, .. } => Some(*key),
            _ => None,
        };
        let column = self.keys.iter().position(|known| Some(known.name) == key);
        let column = column.map(|column| format!(", column {}", column + 1)).unwrap_or_default();
        Error::request(format!("{}, line {}{column}: {error}", self.table, row.line))
    }

    /// The cells of each case, as they stand in the file.
    pub fn cells(&self) -> impl Iterator<Item = Vec<&str>> {
        self.rows.iter().map(|row| row.cells.iter().map(String::as_str).collect())
    }
}

/// A draft over the preset of a name.
fn begun_as(draft: &Draft, name: &str) -> sorairo::Result<Draft> {
    let Ok(preset) = name.parse() else {
        let words: Vec<_> = words::<Preset>().into_iter().map(|word| word.name).collect();
        return Err(sorairo::Error::not_allowed("preset", format!("is {name:?}; it may be {}", words.join(", "))));
    };
    draft.with_preset(preset)
}

/// The keys of a header, or the column that is none and why.
fn columns(header: &Row) -> std::result::Result<Vec<&'static Key>, String> {
    let mut found: Vec<&'static Key> = Vec::new();
    for (column, name) in header.cells.iter().enumerate() {
        let wrong = |complaint: String| Err(header.wrong_in(column, &complaint));
        let Some(key) = keys::find(name) else {
            let shown: String = name.chars().take(60).collect();
            return wrong(format!("{shown:?} is no key of a scene; `sorairo scene reference` lists all of them"));
        };
        if found.iter().any(|before| before.name == key.name) {
            return wrong(format!("{name} stands there twice"));
        }
        found.push(key);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::tests::{read_text, refuses};
    use crate::values::{Given, Value};

    fn scenes(path: &Path) -> Result<Vec<ValidScene>> {
        Cases::read(path)?.scenes(&Values::default(), &Draft::of(Preset::Standard))
    }

    #[test]
    fn each_row_is_a_scene() {
        let scenes = read_text("# a comment\nsun.elevation, atmosphere.aerosol.optical_depth,ground.albedo,sun.disc,render.steps\n10,0.1,grass,TRUE,16\n-2.5,0,0.3,False,24.0\n", scenes).unwrap();
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
    fn a_row_says_its_keys_in_spite_of_flags_and_its_own_preset() {
        let depth = "atmosphere.aerosol.optical_depth";
        let flag = Value { key: depth, said: "--aerosol", given: Given::DepthAt(0.5, 1000.0) };
        let shared: Values = [flag].into_iter().collect();
        let draft = Draft::parse("sun.elevation = 7", "a.toml", Path::new(""), None).unwrap();
        let depths = |table: &str| {
            let scenes = read_text(table, |path| Cases::read(path)?.scenes(&shared, &draft)).unwrap();
            assert!(scenes.iter().all(|scene| scene.sun.elevation == 7.0));
            scenes.iter().map(|scene| scene.atmosphere.aerosol.optical_depth).collect::<Vec<_>>()
        };
        assert_eq!(depths(&format!("{depth}\n0.25\n")), [0.25]);
        assert_eq!(depths("render.steps\n20\n"), [0.5]);
        let scenes = read_text("preset,ground.albedo\nmars,0.5\npaper,0.5\nmars,0\n", |path| {
            Cases::read(path)?.scenes(&Values::default(), &draft)
        });
        let scenes = scenes.unwrap();
        let radii: Vec<_> = scenes.iter().map(|scene| scene.atmosphere.ground_radius).collect();
        assert_eq!(radii, [3389.5, 6360.0, 3389.5]);
        assert!(scenes.iter().all(|scene| scene.sun.elevation == 7.0));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        let cases = [
            ("sun.elevation,moon\n1,2\n", "line 1, column 2: \"moon\" is no key"),
            ("sun.elevation,sun.elevation\n1,2\n", "line 1, column 2: sun.elevation stands there twice"),
            ("sun.elevation,preset\n3,mars\n3,moon\n", "line 3, column 2: preset is \"moon\"; it may be standard, "),
            ("render.bands\nblue\n", "line 2: render.bands: wavelengths are START:END:STEP or a list"),
            ("sun.disc\nyes\n", "line 2: sun.disc: invalid type: string \"yes\""),
            ("sun.elevation\n1\n100\n", "line 3, column 1: sun.elevation is 100; it must lie"),
            ("sun.elevation\n1\n\n# a comment\n100\n", "line 5, column 1: sun.elevation is 100; it must lie"),
            ("# a comment\nsun.elevation,sun.azimuth\n\n1\n", "line 4: the row has 1 values, and the header 2"),
            ("sun.elevation\nhigh\n", "line 2: sun.elevation: invalid type: string \"high\""),
            ("sun.elevation,sun.azimuth\n1\n", "line 2: the row has 1 values, and the header 2"),
            ("sun.elevation\n", "has no row"),
            ("sun.elevation;sun.azimuth\n1;2\n", "line 1: semicolons part the cells; commas are wanted"),
            ("sun.elevation,sun.azimuth\n1;2\n", "line 2: semicolons part the cells"),
            ("", "has no header"),
            ("sun.elevation\nnan\n", "line 2, column 1: sun.elevation is NaN"),
        ];
        refuses(scenes, &cases);
    }
}
