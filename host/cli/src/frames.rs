//! The frames that the flags of a sequence amount to.

use sorairo::low_level::sequence::{self, Frame};
use sorairo::scene::place::evenly;

use crate::arguments::SequenceArguments;
use crate::error::{Error, Result};
use crate::flags::Values;
use crate::ranges::{FrameChoice, MOST_FRAMES};

/// Every frame of a sequence, whichever of them are to be rendered.
///
/// # Errors
///
/// Flags that contradict each other, a wrong scene or file name.
pub fn all(arguments: &SequenceArguments) -> Result<Vec<Frame>> {
    let draft = arguments.sky.0.draft(arguments.scene.as_deref())?;
    let has_place = arguments.sky.0.has("sun.place") || draft.scene().sun.place.is_some();
    let suns = suns(arguments, has_place)?;
    let scenes: Vec<_> = suns.iter().map(|values| values.over(draft.clone())).collect::<sorairo::Result<_>>()?;
    Ok(sequence::frames(scenes, &arguments.spectral.request(arguments.output.clone()))?)
}

/// The frames that are to be rendered, in the order of their numbers.
///
/// # Errors
///
/// A part beyond the last frame.
pub fn chosen(choices: &[FrameChoice], frames: &[Frame]) -> Result<Vec<Frame>> {
    let parts: Vec<_> = choices.iter().filter_map(FrameChoice::part).collect();
    if let Some((first, last)) = parts.iter().find(|(_, last)| *last as usize >= frames.len()) {
        let count = frames.len();
        return Err(Error::request(format!(
            "--frames {first}-{last}: the sequence has {count} frames, with the numbers 0 to {}",
            count - 1
        )));
    }
    let is_chosen = |frame: &&Frame| parts.is_empty() || parts.iter().any(|(a, b)| (*a..=*b).contains(&frame.number));
    Ok(frames.iter().filter(is_chosen).cloned().collect())
}

/// The values of the flags for each frame, with its sun.
fn suns(arguments: &SequenceArguments, has_place: bool) -> Result<Vec<Values>> {
    let sky = &arguments.sky.0;
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
