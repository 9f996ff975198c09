//! Processes that are started anew: a cold one that renders a picture, and the window.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use serde::{Deserialize, Serialize};
use sorairo::{Device, DeviceKind};

use super::extent::Extent;
use crate::problem::{Error, Result};
use crate::timing::Spread;

/// What the window shows while its sun moves, as `sorairo view --frames` counts it.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Window {
    pub(super) size: String,
    /// In each of some runs.
    pub(super) skies: u32,
    pub(super) skies_per_second: Spread,
    /// Skies whose pixels were read back, in all runs.
    pub(super) read_back: u32,
}

/// What `sorairo view --frames N --json` prints.
#[derive(Deserialize)]
struct Count {
    size: String,
    skies_per_second: f64,
    read_back: u32,
}

/// Starts this program anew and renders a picture, several times.
pub(super) fn cold_process(folder: &Path, device: &str, kind: DeviceKind, extent: Extent) -> Result<Spread> {
    let program = program()?;
    let picture = folder.join(".first-picture.png");
    let mut durations = Vec::new();
    for _ in 0..extent.care.rounds {
        let start = Instant::now();
        let status = Command::new(&program)
            .args([
                "render",
                "--size",
                "1024x512",
                "--device",
                if kind == DeviceKind::Cpu { "cpu" } else { device },
                "-o",
            ])
            .arg(&picture)
            .stderr(Stdio::null())
            .status()
            .map_err(not_started)?;
        durations.push(start.elapsed());
        if !status.success() {
            return Err(Error::Nothing("a cold process did not render its picture".into()));
        }
    }
    // What is left of it is no part of the report.
    let _ = std::fs::remove_file(&picture);
    Ok(Spread::of(durations))
}

/// Opens the window several times, and has it count its skies.
pub(super) fn window(device: &Device, extent: Extent) -> Result<Option<Window>> {
    let mut runs = Vec::new();
    for _ in 0..extent.windows {
        let skies = extent.skies.to_string();
        let name = if device.kind == DeviceKind::Cpu { "cpu" } else { &device.name };
        let counting = ["view", "--projection", "perspective", "--frames", &skies, "--json", "--device", name];
        let ended = Command::new(program()?).args(counting).stderr(Stdio::null()).output().map_err(not_started)?;
        if !ended.status.success() {
            return Ok(None);
        }
        let unread = |error| Error::Nothing(format!("the window's count cannot be read: {error}"));
        runs.push(serde_json::from_slice::<Count>(&ended.stdout).map_err(unread)?);
    }
    let mut rates: Vec<f64> = runs.iter().map(|run| run.skies_per_second).collect();
    rates.sort_by(f64::total_cmp);
    Ok(Some(Window {
        size: runs[0].size.clone(),
        skies: extent.skies,
        skies_per_second: Spread { median: rates[extent.windows / 2], min: rates[0], max: rates[extent.windows - 1] },
        read_back: runs.iter().map(|run| run.read_back).sum(),
    }))
}

fn not_started(error: std::io::Error) -> Error {
    Error::Nothing(format!("the program cannot be started anew: {error}"))
}

/// This program.
fn program() -> Result<PathBuf> {
    std::env::current_exe().map_err(not_started)
}

/// The largest resident memory of this process (MiB), as Linux tells it.
pub(super) fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse::<f64>().ok().map(|kib| kib / 1024.0)
}
