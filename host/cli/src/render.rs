//! The command that renders a sky.

use std::path::PathBuf;

use sorairo::low_level::device;
use sorairo::low_level::render::{self, Report};

use crate::arguments::RenderArguments;
use crate::error::Result;
use crate::memory;
use crate::output::{print_line, print_note, refuse_scene_as_output};
use crate::progress::Progress;

/// `sorairo render`.
pub fn run(arguments: &RenderArguments) -> Result<()> {
    let scene = arguments.scene.scene()?;
    let request = arguments.request();
    refuse_scene_as_output(arguments.scene.scene.as_deref(), request.outputs.iter())?;
    let device = memory::device(&arguments.scene.device)?;
    let progress = Progress::start();
    let (open, stage) = (|| device::open(&device), |stage: &str| progress.stage(stage));
    let report = match arguments.split_sun {
        true => render::render_split(&scene, &request, open, stage),
        false => render::render(&scene, &request, open, stage),
    };
    drop(progress);
    let report = report?;
    print_note(&summary(&report));
    if arguments.json {
        return print_line(&serde_json::to_string(&report).expect("a report is plain data"));
    }
    if arguments.explain { print_line(&report.explain.join("\n")) } else { Ok(()) }
}

/// A rendering in two lines.
fn summary(report: &Report) -> String {
    let output = |path: &PathBuf| {
        let replaced = if report.replaced.contains(path) { " (replaced)" } else { "" };
        format!("{}{replaced}", path.display())
    };
    let outputs: Vec<_> = report.outputs.iter().map(output).collect();
    format!(
        "{}: {}x{} pixels, sun at elevation {:.2}°, azimuth {:.2}°, exposure {:+.2} EV, {}{} samples per piece, {}\n{}: plan {:.1} ms, kernels {:.1} ms, read-back {:.1} ms, \
         encoding {:.1} ms, total {:.1} ms",
        outputs.join(", "),
        report.width,
        report.height,
        report.sun_elevation,
        report.sun_azimuth,
        report.exposure_ev,
        if report.exr_exposure_ev == 0.0 { String::new() } else { format!("of EXR {:+} EV, ", report.exr_exposure_ev) },
        report.steps,
        report.path,
        report.device,
        report.plan_ms,
        report.kernel_ms,
        report.readback_ms,
        report.encode_ms,
        report.total_ms
    )
}
