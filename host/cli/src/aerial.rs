//! The command that writes the air before an image.

use sorairo::aerial::{AerialReport, AerialRequest, aerial};

use crate::arguments::{AerialArguments, scene};
use crate::error::Result;
use crate::output::{print_line, print_note, refuse_scene_as_output};
use crate::progress::Progress;

/// `sorairo aerial`.
pub fn run(arguments: &AerialArguments) -> Result<()> {
    let scene = scene(arguments.scene.as_deref(), &arguments.flags.0)?;
    let request = arguments.request();
    refuse_scene_as_output(arguments.scene.as_deref(), std::iter::once(&request.output))?;
    let progress = Progress::start();
    progress.stage("walking through the air");
    let report = aerial(&scene, &request);
    drop(progress);
    let report = report?;
    print_note(&summary(&request, &report));
    if arguments.json {
        return print_line(&serde_json::to_string(&report).expect("a report is plain data"));
    }
    Ok(())
}

fn summary(request: &AerialRequest, report: &AerialReport) -> String {
    let AerialReport { width, height, sky_pixels, farthest_km, .. } = report;
    format!(
        "{}: {width}x{height}, things up to {farthest_km:.3} km away, {sky_pixels} pixels of sky",
        request.output.display()
    )
}
