//! `cargo xtask docs [DIR]`: writes the pages of figures, after taking the figures and pictures from a folder of
//! reports.

use std::error::Error;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::pages::{FIGURES, pages};

/// Where pictures lie, from the root of the repository.
const IMAGES: &str = "docs/images";

/// Each command's report in DIR, the name that its JSON takes in docs/figures, and its pictures.
const REPORTS: [(&str, &str, &[&str]); 4] = [
    ("bench/bench.json", "bench.json", &["bench/pareto.png", "bench/light_field.png"]),
    ("speed/speed.json", "speed.json", &["speed/speed.png"]),
    ("reproduce/report.json", "reproduce.json", &["reproduce/figure2.png"]),
    ("stress/stress.json", "stress.json", &["stress/integral.png", "stress/solve.png"]),
];

/// Writes every page of figures from the JSON in docs/figures.
///
/// # Errors
///
/// Those of [`pages`], or a page that cannot be written.
pub fn write(root: &Path) -> Result<String, Box<dyn Error>> {
    let pages = pages(root)?;
    for (path, text) in &pages {
        fs::write(root.join(path), text)?;
    }
    Ok(format!("{} pages written from {FIGURES}", pages.len()))
}

/// Takes the figures and pictures of a folder of reports, then writes the pages.
///
/// # Errors
///
/// A missing report, or a file that cannot be written.
pub fn take(root: &Path, reports: &Path) -> Result<String, Box<dyn Error>> {
    for (report, name, pictures) in REPORTS {
        let text = fs::read_to_string(reports.join(report)).map_err(|error| format!("{report}: {error}"))?;
        let mut figures: Value = serde_json::from_str(&text)?;
        keep_the_best(&mut figures);
        fs::write(root.join(FIGURES).join(name), format!("{figures:#}\n"))?;
        for picture in pictures {
            let name = Path::new(picture).file_name().ok_or("a picture has a name")?;
            fs::copy(reports.join(picture), root.join(IMAGES).join(name))?;
        }
    }
    write(root)
}

/// Of the configurations of a bench keeps those that a page shows: the default, and what nothing beats.
fn keep_the_best(figures: &mut Value) {
    if let Some(configurations) = figures.get_mut("configurations").and_then(Value::as_array_mut) {
        configurations.retain(|configuration| configuration["default"] == true || configuration["unbeaten"] == true);
    }
}
