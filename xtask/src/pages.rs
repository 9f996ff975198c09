//! The pages of figures: templates filled from the JSON that `sorairo bench`, `reproduce` and `stress` write. Shared
//! with the tests.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use minijinja::value::ViaDeserialize;
use minijinja::{Environment, UndefinedBehavior};
use serde_json::{Map, Value};

/// Where the figures lie, from the root of the repository.
pub const FIGURES: &str = "docs/figures";

/// Where the templates lie, one for a page of docs/.
const TEMPLATES: &str = "docs/templates";

/// Every page of figures: its place from the root of the repository, and its text.
///
/// A template sees the files of [`FIGURES`] by their names without `.json`, and three filters: `spread` writes a median
/// and its range, `fixed(n)` a number with n decimals, `short` one as a person would.
///
/// # Errors
///
/// A file that cannot be read, or a template that asks for a figure which the JSON lacks.
pub fn pages(root: &Path) -> Result<Vec<(PathBuf, String)>, Box<dyn Error>> {
    let figures = figures(&root.join(FIGURES))?;
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_trim_blocks(true);
    environment.set_lstrip_blocks(true);
    environment.set_keep_trailing_newline(true);
    environment.add_filter("spread", |times: ViaDeserialize<Spread>| times.text());
    environment.add_filter("fixed", |number: f64, decimals: usize| format!("{number:.decimals$}"));
    environment.add_filter("short", short);
    let mut pages = Vec::new();
    for path in files(&root.join(TEMPLATES), ".md.j2")? {
        let name = path.file_stem().and_then(|name| name.to_str()).ok_or("a template has a name")?;
        let text = environment.render_named_str(name, &fs::read_to_string(&path)?, &figures)?;
        pages.push((Path::new("docs").join(name), text));
    }
    Ok(pages)
}

/// The committed JSON, each file under its name.
fn figures(folder: &Path) -> Result<Map<String, Value>, Box<dyn Error>> {
    let mut figures = Map::new();
    for path in files(folder, ".json")? {
        let name = path.file_stem().and_then(|name| name.to_str()).ok_or("a file of figures has a name")?;
        figures.insert(name.to_owned(), serde_json::from_str(&fs::read_to_string(&path)?)?);
    }
    Ok(figures)
}

/// The files of a folder whose names end so, sorted.
fn files(folder: &Path, end: &str) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let entries: Result<Vec<_>, _> = fs::read_dir(folder)?.collect();
    let mut paths: Vec<PathBuf> = entries?.iter().map(fs::DirEntry::path).collect();
    paths.retain(|path| path.to_string_lossy().ends_with(end));
    paths.sort();
    Ok(paths)
}

/// A measured time (ms): the median of repeated runs, the shortest and the longest.
#[derive(serde::Deserialize)]
struct Spread {
    median: f64,
    min: f64,
    max: f64,
}

impl Spread {
    fn text(&self) -> String {
        let [median, min, max] = [self.median, self.min, self.max].map(three_digits);
        format!("{median} ({min}–{max})")
    }
}

/// A number with the digits that a measured time has: three, or all before its point.
fn three_digits(number: f64) -> String {
    let before_point = number.abs().max(1e-3).log10().floor() as i32 + 1;
    format!("{number:.*}", (3 - before_point).max(0) as usize)
}

/// A number as a person writes it: at most three decimals, or a power of ten.
fn short(number: f64) -> String {
    if number == 0.0 || (0.1..1e4).contains(&number.abs()) {
        ((number * 1e3).round() / 1e3).to_string()
    } else {
        format!("{number:.1e}")
    }
}
