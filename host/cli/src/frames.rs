//! The frames that the flags of a sequence amount to.

use std::ops::RangeInclusive;

use sorairo::scene::place::evenly;
use sorairo::scene::rules::CAMERA;
use sorairo::scene::{Exposure, Render, ValidScene};
use sorairo::sequence::{self, Frame};

use crate::arguments::SequenceArguments;
use crate::cases::Cases;
use crate::error::{Error, Result};
use crate::ranges::{FrameChoice, FrameExposure, MOST_FRAMES};
use crate::values::Values;

/// Every frame of a sequence, whichever of them are to be rendered.
///
/// # Errors
///
/// Flags that contradict each other, a wrong scene or file name.
pub fn all(arguments: &SequenceArguments, cases: Option<&Cases>) -> Result<Vec<Frame>> {
    let draft = arguments.sky.0.draft(arguments.scene.as_deref())?;
    let request = arguments.request();
    let exposure = exposure(arguments, &draft.scene().render);
    let sky = match exposure {
        FrameExposure::Own(exposure) => arguments.sky.0.with_exposure(exposure),
        FrameExposure::Shared(_) => arguments.sky.0.clone(),
    };
    if let Some(cases) = cases {
        if let Some(count) = arguments.frames.iter().find_map(FrameChoice::count) {
            return Err(Error::request(format!(
                "--frames {count}: the rows of --table say how many frames there are; only parts such as --frames 0-9 are allowed with it"
            )));
        }
        return Ok(sequence::frames(exposed(cases.scenes(&sky, &draft)?, exposure)?, &request)?);
    }
    let has_place = arguments.sky.0.has("sun.place") || draft.scene().sun.place.is_some();
    let suns = suns(arguments, &sky, has_place)?;
    let scenes: Vec<_> = suns.iter().map(|values| values.over(draft.clone())).collect::<sorairo::Result<_>>()?;
    Ok(sequence::frames(exposed(scenes, exposure)?, &request)?)
}

/// How the frames are exposed, over the exposure of their scene.
fn exposure(arguments: &SequenceArguments, of_scene: &Render) -> FrameExposure {
    let has_camera = of_scene.iso.is_some() || CAMERA.iter().any(|key| arguments.sky.0.has(key));
    // The cases of a table are no motion: each is a picture by itself.
    let is_metered = of_scene.exposure == Exposure::Auto && !has_camera;
    let adapts = is_metered && arguments.table.is_none();
    let own = if adapts { Exposure::Adapt } else { of_scene.exposure };
    arguments.exposure.unwrap_or(FrameExposure::Own(own))
}

fn exposed(scenes: Vec<ValidScene>, exposure: FrameExposure) -> sorairo::Result<Vec<ValidScene>> {
    match exposure {
        FrameExposure::Own(_) => Ok(scenes),
        FrameExposure::Shared(of) => sequence::share_exposure(scenes, of),
    }
}

/// The frames that are to be rendered, in the order of their numbers.
///
/// # Errors
///
/// A part beyond the last frame.
pub fn chosen(arguments: &SequenceArguments, frames: &[Frame]) -> Result<Vec<Frame>> {
    let parts = arguments.frames.iter().filter_map(FrameChoice::part);
    let parts = parts.map(|(first, last)| (format!("--frames {first}-{last}"), first..=last));
    let single = arguments.frame.iter().map(|&number| (format!("--frame {number}"), number..=number));
    let parts: Vec<(String, RangeInclusive<u32>)> = parts.chain(single).collect();
    if let Some((flag, _)) = parts.iter().find(|(_, numbers)| *numbers.end() as usize >= frames.len()) {
        let count = frames.len();
        return Err(Error::request(format!(
            "{flag}: the sequence has {count} frames, with the numbers 0 to {}",
            count - 1
        )));
    }
    let is_chosen =
        |frame: &&Frame| parts.is_empty() || parts.iter().any(|(_, numbers)| numbers.contains(&frame.number));
    Ok(frames.iter().filter(is_chosen).cloned().collect())
}

/// The values of the flags for each frame, with its sun.
fn suns(arguments: &SequenceArguments, sky: &Values, has_place: bool) -> Result<Vec<Values>> {
    let counts: Vec<u32> = arguments.frames.iter().filter_map(FrameChoice::count).collect();
    if let Some(elevations) = &arguments.sun_elevation {
        return match counts[..] {
            [] => Ok(elevations.iter().map(|&elevation| sky.with_elevation(elevation)).collect()),
            [count, ..] => Err(Error::request(format!(
                "--frames {count}: the steps of --sun-elevation say how many frames there are; only parts such as --frames 0-9 \
                 are allowed with it"
            ))),
        };
    }
    let (from, to) = arguments.from.zip(arguments.to).expect("without elevations the two times are required");
    if from >= to {
        return Err(Error::request(format!("--to {to} must be later than --from {from}")));
    }
    if !has_place {
        return Err(Error::request("--from and --to need a place: give --place (sun.place) too"));
    }
    match counts[..] {
        [count @ 2..=MOST_FRAMES] => Ok(evenly(from, to, count).map(|time| sky.with_time(time)).collect()),
        [count] => Err(Error::request(format!(
            "--frames {count}: from --from to --to there must be 2 to {MOST_FRAMES} frames"
        ))),
        [] => Err(Error::request("--from and --to need --frames N, such as --frames 48: how many frames there are")),
        [first, second, ..] => Err(Error::request(format!(
            "--frames {first} and --frames {second}: how many frames there are is said once"
        ))),
    }
}
