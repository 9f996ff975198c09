//! `cargo xtask readme DIR`: puts the measured tables and pictures of a folder of reports into the README, so that none of
//! its figures is typed by hand.
//!
//! DIR holds `bench` (by `sorairo bench`), `speed` (by `sorairo bench --speed`), `reproduce` (by `sorairo reproduce`) and `stress`
//! (by `sorairo stress`).

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
    let stress = fs::read_to_string(reports.join("stress/stress.json"))?;
    for picture in ["bench/pareto.png", "reproduce/figure2.png", "stress/solve.png", "stress/integral.png"] {
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
    let readme = replaced(&readme, "speed", &speed)?;
    fs::write(&path, replaced(&readme, "reliability", &reliability(&serde_json::from_str(&stress)?)?)?)?;
    Ok("README.md and docs/images hold the figures of the reports".into())
}

/// What the random sweeps tried, and what failed.
fn reliability(stress: &serde_json::Value) -> Result<String, String> {
    let text = |value: &serde_json::Value, key: &str| {
        let found = value.get(key).ok_or_else(|| format!("no {key} in stress.json"))?;
        Ok::<_, String>(found.as_str().map_or_else(|| found.to_string(), str::to_owned))
    };
    let machine = stress.get("machine").ok_or("no machine in stress.json")?;
    let [device, processor, date] = ["device", "processor", "date"].map(|key| text(machine, key));
    let mut lines = vec![
        format!("On {} and the CPU ({}), {}.", device?, processor?, date?),
        String::new(),
        "| what was tried | cases | failures | worst | bound | seed |".into(),
        "| --- | --- | --- | --- | --- | --- |".into(),
    ];
    let outcomes = stress.get("outcomes").and_then(serde_json::Value::as_array).ok_or("no outcomes in stress.json")?;
    for outcome in outcomes {
        let number = |key: &str| outcome.get(key).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
        let [subject, cases, failures, seed] = ["subject", "cases", "failures", "seed"].map(|key| text(outcome, key));
        let [worst, bound] = ["worst", "bound"].map(|key| figure(number(key)));
        lines.push(format!("| {} | {} | {} | {worst} | {bound} | {} |", subject?, cases?, failures?, seed?));
    }
    for outcome in outcomes.iter().filter(|outcome| outcome.get("judged_apart").is_some_and(|count| *count != 0)) {
        let [subject, count, how] = ["subject", "judged_apart", "apart"].map(|key| text(outcome, key));
        lines.push(format!("\nOf the {}, {} were {}.", subject?, count?, how?));
    }
    lines.push("\n![Error of the ray integral over altitude, view and sun](docs/images/integral.png)".into());
    lines.push("\n![Error of a cubic through four bands in three forms](docs/images/solve.png)".into());
    Ok(lines.join("\n"))
}

/// A number as a person writes it: three digits after the point, or a power of ten.
fn figure(number: f64) -> String {
    if number == 0.0 || (0.1..1e4).contains(&number) {
        ((number * 1e3).round() / 1e3).to_string()
    } else {
        format!("{number:.1e}")
    }
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
    const END: &str = "<!-- /generated -->";
    let start = format!("<!-- generated: {section} -->\n");
    let from = readme.find(&start).ok_or_else(|| format!("no section {section} in the README"))? + start.len();
    let to = from + readme[from..].find(END).ok_or_else(|| format!("section {section} of the README has no end"))?;
    Ok(format!("{}{text}\n{}", &readme[..from], &readme[to..]))
}
