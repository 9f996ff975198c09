//! The frames that the flags of a sequence amount to.

use sorairo::scene::place::{Place, evenly};
use sorairo::sequence::{self, Frame};

use crate::arguments::{SequenceArguments, SunFlags};
use crate::error::{Error, Result};
use crate::ranges::{FrameChoice, MOST_FRAMES};

/// Every frame of a sequence, whichever of them are to be rendered.
///
/// # Errors
///
/// Flags that contradict each other, a wrong scene or file name.
pub fn all(arguments: &SequenceArguments) -> Result<Vec<Frame>> {
    let file = arguments.sky.read(arguments.scene.as_deref())?;
    let suns = suns(arguments, file.as_ref().and_then(|file| file.sun_from.place))?;
    let scenes: Vec<_> = suns.into_iter().map(|sun| arguments.sky.over(file.as_ref(), sun)).collect::<Result<_>>()?;
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

/// The sun of each frame; `place` is that of the scene file.
fn suns(arguments: &SequenceArguments, place: Option<Place>) -> Result<Vec<SunFlags>> {
    let counts: Vec<u32> = arguments.frames.iter().filter_map(FrameChoice::count).collect();
    if let Some(elevations) = &arguments.sun_elevation {
        return match counts[..] {
            [] => Ok(elevations.iter().map(|&e| SunFlags { sun_elevation: Some(e), time: None }).collect()),
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
    if arguments.sky.place.or(place).is_none() {
        return Err(Error::request("--from and --to need a place: give --place (sun.place) too"));
    }
    match counts[..] {
        [count @ 2..=MOST_FRAMES] => {
            let at = |time| SunFlags { sun_elevation: None, time: Some(time) };
            Ok(evenly(from, to, count).map(at).collect())
        }
        [count] => Err(Error::request(format!(
            "--frames {count}: from --from to --to there must be 2 to {MOST_FRAMES} frames"
        ))),
        [] => Err(Error::request("--from and --to need --frames N, such as --frames 48: how many frames there are")),
        [first, second, ..] => Err(Error::request(format!(
            "--frames {first} and --frames {second}: how many frames there are is said once"
        ))),
    }
}
