//! The command that renders a sky.

use std::path::PathBuf;

use sorairo::{Device, Report};

use crate::arguments::RenderArguments;
use crate::error::Result;
use crate::memory;
use crate::output::{print_line, print_note, refuse_scene_as_output};
use crate::polarisation_map;
use crate::progress::Progress;

/// `sorairo render`.
pub fn run(arguments: &RenderArguments) -> Result<()> {
    if let Some(shown) = arguments.show {
        return polarisation_map::run(arguments, shown);
    }
    let scene = arguments.scene.scene()?;
    let request = arguments.request();
    refuse_scene_as_output(arguments.scene.scene.as_deref(), request.files().iter())?;
    let device = memory::device(&arguments.scene.device)?;
    let progress = Progress::start();
    let (open, stage) = (|| Device::open(&device), |stage: &str| progress.stage(stage));
    let report = sorairo::render(&scene, &request, open, stage);
    drop(progress);
    let report = report?;
    print_note(&summary(&report));
    if arguments.json {
        return print_line(&serde_json::to_string(&report).expect("a report is plain data"));
    }
    if arguments.explain {
        print_note(&times(&report));
        print_line(&report.explain.join("\n"))?;
    }
    Ok(())
}

/// A rendering in a line: the files, what they show, and how long it took.
fn summary(report: &Report) -> String {
    let output = |path: &PathBuf| {
        let replaced = if report.replaced.contains(path) { " (replaced)" } else { "" };
        format!("{}{replaced}", path.display())
    };
    let outputs: Vec<_> = report.outputs.iter().map(output).collect();
    let of_exr =
        if report.exr_exposure_ev == 0.0 { String::new() } else { format!(", EXR {:+} EV", report.exr_exposure_ev) };
    format!(
        "{}: {}x{}, sun {:.2}° high at azimuth {:.2}°, exposure {:+.2} EV{of_exr}, {:.2} s on {}",
        outputs.join(", "),
        report.width,
        report.height,
        report.sun_elevation,
        report.sun_azimuth,
        report.exposure_ev,
        report.total_ms / 1e3,
        report.device,
    )
}

/// What took how long.
fn times(report: &Report) -> String {
    format!(
        "{} samples per piece, {}; plan {:.1} ms, kernels {:.1} ms, read-back {:.1} ms, encoding {:.1} ms, total {:.1} ms",
        report.steps,
        report.path,
        report.plan_ms,
        report.kernel_ms,
        report.readback_ms,
        report.encode_ms,
        report.total_ms
    )
}
