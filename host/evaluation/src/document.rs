//! Reports as files: text, tables, and the machine that they were made on.

use std::io::Write;
use std::path::Path;

use chrono::Utc;
use serde::Serialize;

use crate::problem::{Error, Result};
use sorairo::files::stage;
use sorairo::{Device, DeviceKind};

/// Where and when something was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// Name of the device that ran the kernels.
    pub device: String,
    /// What kind of device.
    pub backend: DeviceKind,
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
            date: Utc::now().format("%Y-%m-%d").to_string(),
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
/// [`Error::Folder`] if it cannot be made.
pub fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)
        .map_err(|error| Error::Folder { folder: folder.to_owned(), reason: error.to_string() })
}

/// Writes a text file.
///
/// # Errors
///
/// [`Error::Sky`] if it cannot be written.
pub fn write(path: &Path, text: &str) -> Result<()> {
    Ok(stage(path, |writer| writer.write_all(text.as_bytes()))?.commit()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_a_line_for_each_row() {
        assert_eq!(table(&["a", "b"], [vec!["1".into(), "2".into()]]), "| a | b |\n| --- | --- |\n| 1 | 2 |\n");
    }
}
