//! The command that renders sequences.

use std::path::PathBuf;
use std::time::Instant;

use serde::Serialize;
use sorairo::files::Replace;
use sorairo::sequence::{self, Ended, Frame, Measured};
use sorairo::{Device, DeviceKind, Shown};

use crate::arguments::SequenceArguments;
use crate::cases::Cases;
use crate::contact_sheet::contact_sheet;
use crate::error::Result;
use crate::frames;
use crate::known;
use crate::manifest::{self, Lights};
use crate::memory;
use crate::output::{print_line, print_note, refuse_scene_as_output};
use crate::progress::FrameProgress;

/// What a run did, as `--json` prints it.
#[derive(Serialize)]
struct Summary {
    /// Name of the device.
    device: String,
    /// `gpu` or `cpu`.
    backend: DeviceKind,
    /// Frames of the whole sequence.
    count: usize,
    /// Frames that this run rendered.
    rendered: u32,
    /// Frames that this run rendered in the place of other files.
    replaced: u32,
    /// Frames of this run that were there already.
    skipped: u32,
    /// Time from the first frame to the last (s).
    seconds: f64,
    /// Frames rendered in a second.
    frames_per_second: f64,
    /// The contact sheet, if every frame is there.
    contact_sheet: Option<String>,
    /// The manifest of a table's frames, if every frame is there.
    #[serde(skip_serializing_if = "Option::is_none")]
    manifest: Option<String>,
    /// The frames of this run.
    frames: Vec<FrameReport>,
}

/// A frame, as `--json` lists it.
#[derive(Serialize)]
struct FrameReport {
    /// Its number.
    number: u32,
    /// Whether this run rendered it; it was there already otherwise.
    rendered: bool,
    /// Elevation of the sun (degrees).
    sun_elevation: f64,
    /// Azimuth of the sun, clockwise from north (degrees).
    sun_azimuth: f64,
    /// Whether the sun's disc is in the image where it can be seen.
    sun_disc: bool,
    #[serde(flatten)]
    shown: Option<Shown>,
    /// Its files.
    outputs: Vec<String>,
}

impl FrameReport {
    fn new(frame: &Frame, ended: Ended, shown: Option<Shown>) -> Self {
        let sun = &frame.scene.sun;
        Self {
            number: frame.number,
            rendered: ended != Ended::Found,
            sun_elevation: sun.elevation,
            sun_azimuth: sun.azimuth,
            sun_disc: sun.disc && !frame.request.split_sun,
            shown,
            outputs: frame.request.files().iter().map(|path| path.to_string_lossy().into_owned()).collect(),
        }
    }
}

/// `sorairo sequence`.
pub fn run(arguments: &SequenceArguments) -> Result<()> {
    let cases = arguments.table.as_deref().map(Cases::read).transpose()?;
    let frames = frames::all(arguments, cases.as_ref())?;
    let chosen = frames::chosen(arguments, &frames)?;
    let sheet = contact_sheet_path(&frames);
    let manifest = cases.is_some().then(|| manifest::path(&frames));
    let check_beside = |replaces: Replace| {
        replaces.check(&sheet)?;
        manifest.as_ref().map_or(Ok(()), |path| replaces.check_by(path, manifest::is_own))
    };
    let files: Vec<_> = frames.iter().flat_map(|frame| frame.request.files()).collect();
    refuse_scene_as_output(arguments.scene.as_deref(), files.iter().chain([&sheet]))?;
    // Nobody names the sheet and the manifest.
    check_beside(if arguments.replace.force { Replace::All } else { Replace::Own })?;
    let mut device = Device::open(&memory::device(&arguments.device)?)?;
    sequence::make_folders(&chosen)?;
    let (mut rendered, mut replaced, mut skipped, mut reports) = (0, 0, 0, Vec::new());
    let start = Instant::now();
    let measured = match &cases {
        _ if arguments.json => Measured::All,
        // Tasks that render a part do not know whether they are the last, which writes the manifest.
        Some(_) if chosen.len() == frames.len() => Measured::Rendered,
        _ => Measured::None,
    };
    let mut lights = Lights::new();
    let mut progress = FrameProgress::start(chosen.len(), "0 skipped");
    let outcome = sequence::sequence(&chosen, measured, &mut device, &mut |frame, ended, shown| {
        lights.extend(shown.map(|shown| (frame.number, shown.sky_light)));
        reports.push(FrameReport::new(frame, ended, shown));
        match ended {
            Ended::Rendered { replaced: has_replaced, .. } => {
                rendered += 1;
                replaced += u32::from(has_replaced);
            }
            Ended::Found => skipped += 1,
        }
        progress.ended(ended);
    });
    drop(progress);
    outcome?;
    let seconds = start.elapsed().as_secs_f64();
    let is_other = |frame: &&Frame| chosen.binary_search_by_key(&frame.number, |chosen| chosen.number).is_err();
    let made_of = || known::made_of(&frames, cases.as_ref());
    // A task that is run again when all is done has nothing to add, and no need to read every frame of the others.
    let is_known = rendered == 0 && known::are_whole(&frames, &made_of()?, &sheet, manifest.as_deref());
    let is_whole = is_known || sequence::are_finished(frames.iter().filter(is_other));
    if is_whole && !is_known {
        check_beside(arguments.replace.or(Replace::All))?;
        let write = |cases| manifest::write(cases, &frames, lights, known::noted_manifest(&sheet).as_deref());
        let checksum = cases.as_ref().map(write).transpose()?;
        contact_sheet(&sheet, &frames, &known::note(&made_of()?, checksum.as_deref()), &mut device)?;
    }
    let summary = Summary {
        device: device.name,
        backend: device.kind,
        count: frames.len(),
        rendered,
        replaced,
        skipped,
        seconds,
        frames_per_second: f64::from(rendered) / seconds,
        contact_sheet: is_whole.then(|| sheet.to_string_lossy().into_owned()),
        manifest: manifest.filter(|_| is_whole).map(|path| path.to_string_lossy().into_owned()),
        frames: reports,
    };
    print_note(&in_a_line(&summary));
    if arguments.json {
        print_line(&serde_json::to_string(&summary).expect("a summary is plain data"))?;
    }
    Ok(())
}

/// The contact sheet beside the frames.
fn contact_sheet_path(frames: &[Frame]) -> PathBuf {
    let frame = frames.first().and_then(|frame| frame.request.outputs.first());
    frame.map(|path| path.with_file_name("contact.png")).unwrap_or_default()
}

fn in_a_line(summary: &Summary) -> String {
    let Summary { device, count, rendered, replaced, skipped, seconds, frames_per_second, .. } = summary;
    let replaced = if *replaced > 0 { format!("{replaced} of them replaced, ") } else { String::new() };
    let sheet = match &summary.contact_sheet {
        Some(path) => format!("contact sheet {path}"),
        None => "no contact sheet, because frames are missing".into(),
    };
    format!(
        "{rendered} frames rendered, {replaced}{skipped} skipped, of {count}, in {seconds:.1} s ({frames_per_second:.1} frames/s) on {device}; {sheet}"
    )
}
