//! Reports as files: text, tables, and the machine that they were made on.

use std::io::Write;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::Serialize;

use sorairo::device::Device;
use sorairo::files::stage;
use sorairo::{Error, Result};

/// Where and when something was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// Name of the device that ran the kernels.
    pub device: String,
    /// `gpu` or `cpu`.
    pub backend: &'static str,
    /// Name of the processor, where the system tells.
    pub processor: String,
    /// Threads that the processor runs at once.
    pub threads: usize,
    /// Operating system and instruction set.
    pub system: String,
    /// Day of the measurement (year-month-day, UTC).
    pub date: String,
    /// Version of sorairo.
    pub version: &'static str,
}

impl Machine {
    /// This one, with one of its devices.
    pub fn new(device: &Device) -> Self {
        let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let name = cpu.lines().find(|line| line.starts_with("model name")).and_then(|line| line.split_once(": "));
        Self {
            device: device.name.clone(),
            backend: device.kind,
            processor: name.map_or("unknown processor", |(_, name)| name).to_owned(),
            threads: rayon::current_num_threads(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            date: date(SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs() / 86_400)),
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

impl std::fmt::Display for Machine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { device, processor, threads, system, date, version, .. } = self;
        write!(f, "{device}; {processor}, {threads} threads, {system}; {date}, sorairo {version}")
    }
}

/// Year-month-day of a number of days since 1970-01-01 (Hinnant 2013, *chrono-compatible low-level date algorithms*).
fn date(days: u64) -> String {
    let shifted = days + 719_468;
    let era = shifted / 146_097;
    let day_of_era = shifted % 146_097;
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    format!("{year}-{month:02}-{day:02}")
}

/// A table in Markdown.
pub fn table(head: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut text = format!("| {} |\n|{}\n", head.join(" | "), " --- |".repeat(head.len()));
    for row in rows {
        text.push_str(&format!("| {} |\n", row.join(" | ")));
    }
    text
}

/// Makes the folder of a report.
///
/// # Errors
///
/// [`Error::Request`] if it cannot be made.
pub fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)
        .map_err(|error| Error::request(format!("--out {} cannot be made: {error}", folder.display())))
}

/// Writes a text file.
///
/// # Errors
///
/// [`Error::Failure`] if it cannot be written.
pub fn write(path: &Path, text: &str) -> Result<()> {
    stage(path, |writer| writer.write_all(text.as_bytes()))?.commit()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (days, expected) in
            [(0, "1970-01-01"), (11_016, "2000-02-29"), (11_017, "2000-03-01"), (20_453, "2025-12-31")]
        {
            assert_eq!(date(days), expected);
        }
    }

    #[test]
    fn a_table_has_a_line_for_each_row() {
        assert_eq!(table(&["a", "b"], [vec!["1".into(), "2".into()]]), "| a | b |\n| --- | --- |\n| 1 | 2 |\n");
    }
}
