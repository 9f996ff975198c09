//! `cargo xtask readme DIR`: puts the measured tables and pictures of a folder of reports into the README, so that none of
//! its figures is typed by hand.
//!
//! DIR holds `bench` (by `sorairo bench`), `speed` (by `sorairo bench --speed`) and `reproduce` (by `sorairo reproduce`).

use std::error::Error;
use std::fs;
use std::path::Path;

/// Fills the generated sections of the README at `root` from the reports in `reports`.
///
/// # Errors
///
/// A missing report, a part of one that is not found, or a file that cannot be written.
pub fn fill(root: &Path, reports: &Path) -> Result<String, Box<dyn Error>> {
    let bench = fs::read_to_string(reports.join("bench/report.md"))?;
    let speed = fs::read_to_string(reports.join("speed/speed.md"))?;
    let paper = fs::read_to_string(reports.join("reproduce/report.md"))?;
    for picture in ["bench/pareto.png", "reproduce/figure2.png"] {
        let name = Path::new(picture).file_name().ok_or("a picture has a name")?;
        fs::copy(reports.join(picture), root.join("docs/images").join(name))?;
    }
    let accuracy = format!(
        "{}\n\n{}\n\nThe paper's experiment (`sorairo reproduce`; no ozone, a flat sun):\n\n{}\n\n{}\n\n{}",
        between(&bench, "# Run time against error\n", "## The default")?
            .replace("(pareto.png)", "(docs/images/pareto.png)"),
        between(&bench, "what nothing beats\n", "## GPU-resident")?,
        "![The sky by every fit, and its colour error](docs/images/figure2.png)",
        all_suns(between(&paper, "chosen for colour.\n", "\nThe paper states")?),
        between(&paper, "## Run time\n", "")?,
    );
    let speed = format!(
        "{}\n\n{}\n\n{}",
        between(&speed, "# Speed\n", "![Time")?,
        between(&speed, "pixels once\n", "## Tables")?,
        between(&bench, "read back, then fit\n", "")?,
    );
    let path = root.join("README.md");
    let readme = fs::read_to_string(&path)?;
    let readme = replaced(&readme, "accuracy", &accuracy)?;
    fs::write(&path, replaced(&readme, "speed", &speed)?)?;
    Ok("README.md and docs/images hold the figures of the reports".into())
}

/// The text between two marks, trimmed; an empty end mark is the end of the text.
fn between<'a>(text: &'a str, start: &str, end: &str) -> Result<&'a str, String> {
    let from = text.find(start).ok_or_else(|| format!("no {start:?} in a report"))? + start.len();
    let rest = &text[from..];
    let to =
        if end.is_empty() { rest.len() } else { rest.find(end).ok_or_else(|| format!("no {end:?} in a report"))? };
    Ok(rest[..to].trim())
}

/// A table without its rows for single suns.
fn all_suns(table: &str) -> String {
    table.lines().filter(|line| !line.contains('°')).collect::<Vec<_>>().join("\n")
}

fn replaced(readme: &str, section: &str, text: &str) -> Result<String, String> {
    let start = format!("<!-- generated: {section} -->\n");
    let old = between(readme, &start, "<!-- /generated -->")?;
    Ok(readme.replacen(&format!("{start}{old}"), &format!("{start}{text}"), 1))
}
