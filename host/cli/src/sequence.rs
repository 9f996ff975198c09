//! The command that renders sequences.

use std::path::PathBuf;
use std::time::Instant;

use serde::Serialize;
use sorairo::low_level::device::{self, Device, DeviceKind};
use sorairo::low_level::sequence::{self, Ended, Frame};

use crate::arguments::SequenceArguments;
use crate::contact_sheet::contact_sheet;
use crate::error::Result;
use crate::frames;
use crate::output::{print_line, print_note};
use crate::progress::FrameProgress;

/// What a run did, as `--json` prints it.
#[derive(Serialize)]
struct Summary {
    /// Name of the device.
    device: String,
    /// `gpu` or `cpu`.
    backend: DeviceKind,
    /// Frames of the whole sequence.
    frames: usize,
    /// Frames that this run rendered.
    rendered: u32,
    /// Frames of this run that were there already.
    skipped: u32,
    /// Time from the first frame to the last (s).
    seconds: f64,
    /// Frames rendered in a second.
    frames_per_second: f64,
    /// The contact sheet, if it was written.
    contact_sheet: Option<String>,
}

/// `sorairo sequence`.
pub fn run(arguments: &SequenceArguments) -> Result<()> {
    let frames = frames::all(arguments)?;
    let chosen = frames::chosen(&arguments.frames, &frames)?;
    let mut device = device::open(&arguments.device)?;
    sequence::make_folders(&chosen)?;
    let (mut rendered, mut skipped) = (0, 0);
    let start = Instant::now();
    let mut progress = (!arguments.quiet).then(|| FrameProgress::start(chosen.len()));
    let outcome = sequence::sequence(&chosen, &mut device, &mut |_, ended| {
        match ended {
            Ended::Rendered => rendered += 1,
            Ended::Found => skipped += 1,
        }
        progress.iter_mut().for_each(|progress| progress.ended(ended));
    });
    drop(progress);
    outcome?;
    let seconds = start.elapsed().as_secs_f64();
    let is_other = |frame: &&Frame| chosen.binary_search_by_key(&frame.number, |chosen| chosen.number).is_err();
    let contact_sheet = if sequence::are_finished(frames.iter().filter(is_other)) {
        Some(sheet_beside(&frames, &mut device)?)
    } else {
        None
    };
    let summary = Summary {
        device: device.name,
        backend: device.kind,
        frames: frames.len(),
        rendered,
        skipped,
        seconds,
        frames_per_second: f64::from(rendered) / seconds,
        contact_sheet: contact_sheet.map(|path| path.to_string_lossy().into_owned()),
    };
    if !arguments.quiet {
        print_note(&in_a_line(&summary));
    }
    if arguments.json {
        print_line(&serde_json::to_string(&summary).expect("a summary is plain data"))?;
    }
    Ok(())
}

/// Writes the contact sheet beside the frames.
fn sheet_beside(frames: &[Frame], device: &mut Device) -> Result<PathBuf> {
    let frame = frames.first().and_then(|frame| frame.request.outputs.first());
    let path = frame.map(|path| path.with_file_name("contact.png")).unwrap_or_default();
    contact_sheet(&path, frames, device)?;
    Ok(path)
}

fn in_a_line(summary: &Summary) -> String {
    let Summary { device, frames, rendered, skipped, seconds, frames_per_second, .. } = summary;
    let sheet = match &summary.contact_sheet {
        Some(path) => format!("contact sheet {path}"),
        None => "no contact sheet, because frames are missing".into(),
    };
    format!(
        "{rendered} frames rendered, {skipped} skipped, of {frames}, in {seconds:.1} s ({frames_per_second:.1} frames/s) on {device}; {sheet}"
    )
}
