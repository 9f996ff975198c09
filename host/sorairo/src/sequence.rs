//! Frames one after the other: while one is computed, the next is planned and the one before is encoded.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use crate::device::Device;
use crate::error::{Error, Result};
use crate::files;
use crate::render::{Files, Job, Request};
use crate::scene::Scene;

/// One frame of a sequence.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Its number, from 0.
    pub number: u32,
    /// What it shows.
    pub scene: Scene,
    /// The files that it fills.
    pub request: Request,
}

/// How a frame ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// It was rendered.
    Rendered,
    /// Its files were there already, whole, and show its scene.
    Found,
}

/// Most frames of a sequence.
pub const MOST_FRAMES: u32 = 100_000;

/// A value of `--frames`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameChoice {
    /// How many frames there are.
    Count(u32),
    /// Which of them to render: the numbers of the first and the last.
    Part(u32, u32),
}

impl FrameChoice {
    /// How many frames there are, if that is what it says.
    pub fn count(&self) -> Option<u32> {
        match *self {
            Self::Count(count) => Some(count),
            Self::Part(..) => None,
        }
    }

    /// The numbers of the first and the last frame to render, if that is what it says.
    pub fn part(&self) -> Option<(u32, u32)> {
        match *self {
            Self::Count(_) => None,
            Self::Part(first, last) => Some((first, last)),
        }
    }
}

impl FromStr for FrameChoice {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let number = |text: &str| text.trim().parse().ok();
        let choice = match text.split_once('-') {
            Some((first, last)) => {
                number(first).zip(number(last)).filter(|(first, last)| first <= last).map(|(a, b)| Self::Part(a, b))
            }
            None => number(text).map(Self::Count),
        };
        choice.ok_or_else(|| {
            format!("a number of frames such as 48, or the first and the last to render such as 0-9, is wanted, not {text:?}")
        })
    }
}

/// Elevations of the sun (degrees) from `A:B:STEP`: from A to B, which is included if it falls on a step; downwards if B is
/// below A.
///
/// # Errors
///
/// A sentence that says how elevations are written.
pub fn parse_elevations(text: &str) -> std::result::Result<Vec<f64>, String> {
    let allowed = || {
        format!(
            "elevations are A:B:STEP in degrees, such as -6:60:0.5, of at most {MOST_FRAMES} steps from A towards B, not {text:?}"
        )
    };
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite()).ok_or_else(allowed);
    let parts: Vec<f64> = text.split(':').map(number).collect::<std::result::Result<_, _>>()?;
    let [first, last, step] = parts[..] else { return Err(allowed()) };
    let step = if last < first { -step.abs() } else { step };
    let steps = (last - first) / step;
    if step == 0.0 || parts[2] < 0.0 && last >= first || steps >= f64::from(MOST_FRAMES) {
        return Err(allowed());
    }
    // Half a thousandth of a step lets the end be reached in spite of rounding.
    let steps = (steps + 5e-4).floor() as u32;
    // Steps of 0.1 reach 0.3 and not 0.30000000000000004, which would be another scene than a person's 0.3.
    // Nor -0, which is written otherwise than 0.
    let decimal = |elevation: f64| (elevation * 1e9).round() / 1e9 + 0.0;
    Ok((0..=steps).map(|i| decimal(first + step * f64::from(i))).collect())
}

/// The frames that show scenes, numbered from 0. Each is asked for as `request` says, whose outputs are the patterns of its file names; see
/// [`numbered`].
///
/// # Errors
///
/// [`Error::FileName`] for a pattern without a place for the number or of another format, [`Error::SharedFile`] for a file that
/// two frames or patterns share.
pub fn frames(scenes: Vec<Scene>, request: &Request) -> Result<Vec<Frame>> {
    request.formats()?;
    let mut names = HashSet::new();
    let frame = |(number, scene)| {
        let outputs: Vec<_> = request.outputs.iter().map(|pattern| numbered(pattern, number)).collect::<Result<_>>()?;
        match outputs.iter().find(|&path| !names.insert(path.clone())) {
            Some(path) => Err(Error::SharedFile { path: path.clone(), how: "a file of two frames" }),
            None => Ok(Frame { number, scene, request: Request { outputs, ..request.clone() } }),
        }
    };
    (0..).zip(scenes).map(frame).collect()
}

/// Makes the folders of frames where they are missing.
///
/// # Errors
///
/// [`Error::FileName`] if one cannot be made.
pub fn make_folders(frames: &[Frame]) -> Result<()> {
    // The number stands in the file name, so that all frames have the folders of any.
    let outputs = frames.first().map_or(&[][..], |frame| &frame.request.outputs);
    outputs.iter().try_for_each(|path| files::make_folder(path))
}

/// Whether the files of all frames are whole and show their scenes, as [`sequence`] leaves them.
pub fn are_finished<'a>(frames: impl Iterator<Item = &'a Frame> + Clone) -> bool {
    let is_there = |frame: &Frame| frame.request.outputs.iter().all(|path| path.is_file());
    // A missing file is told at once; decoding takes its time.
    frames.clone().all(is_there) && frames.into_iter().all(|frame| frame.request.is_finished(&frame.scene))
}

/// Renders the frames that are not there yet, in their order.
///
/// A frame counts as there if each of its files decodes to its end and names the same scene and version of the program.
/// `ended` is called for each frame, in their order. After an error the frames before it are whole and in place.
///
/// # Errors
///
/// Those of [`Job::new`] and [`Job::compute`], with the number of the frame.
pub fn sequence(frames: &[Frame], device: &mut Device, ended: &mut (dyn FnMut(&Frame, Ended) + Send)) -> Result<()> {
    std::thread::scope(|scope| {
        let (planned, jobs) = sync_channel(1);
        let (computed, files) = sync_channel(1);
        scope.spawn(move || plan(frames, &planned));
        let finishing = scope.spawn(move || finish(&files, ended));
        let computing = jobs.iter().try_for_each(|(frame, job): (&Frame, Result<Option<Job>>)| {
            let files = match job.map_err(|error| of_frame(frame, error))? {
                Some(job) => Some(job.compute(scope, device).map_err(|error| of_frame(frame, error))?.1),
                None => None,
            };
            // The receiver ends early only with an error of its own, which is the one to tell.
            computed.send((frame, files)).map_err(|_| writer_ended())
        });
        // Ends the planner, if it has not ended.
        drop(jobs);
        drop(computed);
        let finished = finishing.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        finished.and(computing)
    })
}

/// Plans each frame that is not there yet, one ahead of the device.
fn plan<'a>(frames: &'a [Frame], jobs: &SyncSender<(&'a Frame, Result<Option<Job>>)>) {
    for frame in frames {
        let job = if frame.request.is_finished(&frame.scene) {
            Ok(None)
        } else {
            Job::new(&frame.scene, &frame.request).map(Some)
        };
        if jobs.send((frame, job)).is_err() {
            return;
        }
    }
}

/// Puts the files of each frame into their places once they are encoded.
fn finish(files: &Receiver<(&Frame, Option<Files<'_>>)>, ended: &mut (dyn FnMut(&Frame, Ended) + Send)) -> Result<()> {
    for (frame, files) in files {
        let how = if files.is_some() { Ended::Rendered } else { Ended::Found };
        files.map_or(Ok(()), Files::finish).map_err(|error| of_frame(frame, error))?;
        ended(frame, how);
    }
    Ok(())
}

fn of_frame(frame: &Frame, error: Error) -> Error {
    Error::InFrame { number: frame.number, error: Box::new(error) }
}

/// What is told where a file's own error is not known yet.
fn writer_ended() -> Error {
    Error::Write { path: PathBuf::from("a file"), reason: "its writer has ended".into() }
}

/// The file of a frame: a run of `#` in the name becomes the number with at least as many digits.
///
/// # Errors
///
/// [`Error::FileName`] if the name holds no `#`, or more than one run.
pub fn numbered(path: &Path, number: u32) -> Result<PathBuf> {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let wrong = || Error::FileName {
        path: path.to_owned(),
        complaint: "the file name needs one run of # for the frame's number, such as sky.####.exr".into(),
    };
    let start = name.find('#').ok_or_else(wrong)?;
    let digits = name[start..].chars().take_while(|&c| c == '#').count();
    let (before, after) = (&name[..start], &name[start + digits..]);
    if after.contains('#') {
        return Err(wrong());
    }
    Ok(path.with_file_name(format!("{before}{number:0digits$}{after}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_of_hashes_becomes_the_number() {
        let of = |name: &str, number| numbered(Path::new(name), number).map(|path| path.display().to_string());
        assert_eq!(of("out/sky.####.exr", 7).unwrap(), "out/sky.0007.exr");
        assert_eq!(of("#.png", 123).unwrap(), "123.png");
        assert!(of("sky.png", 1).is_err() && of("a#b#.png", 1).is_err());
    }

    #[test]
    fn elevations_rise_or_sink_in_steps_and_include_an_end_that_a_step_reaches() {
        assert_eq!(parse_elevations("-6:60:0.5").unwrap().len(), 133);
        assert_eq!(parse_elevations("0:0.5:0.1").unwrap(), [0.0, 0.1, 0.2, 0.3, 0.4, 0.5]);
        assert_eq!(parse_elevations("2:-2.9:2").unwrap(), [2.0, 0.0, -2.0]);
        assert_eq!(parse_elevations("1:0:-0.5").unwrap(), [1.0, 0.5, 0.0]);
        assert_eq!(parse_elevations("7:7:1").unwrap(), [7.0]);
        for bad in ["", "5", "0:5", "0:5:0", "0:0:0", "0:5:-1", "0:5:1:2", "0:nan:1", "0:5:inf", "a:b:c", "0:90:1e-4"] {
            let sentence = parse_elevations(bad).unwrap_err();
            assert!(sentence.contains("A:B:STEP") && sentence.contains(bad), "{sentence}");
        }
    }

    #[test]
    fn frames_are_a_number_of_them_or_a_part() {
        assert_eq!("48".parse(), Ok(FrameChoice::Count(48)));
        assert_eq!("0-9".parse(), Ok(FrameChoice::Part(0, 9)));
        assert_eq!("7-7".parse(), Ok(FrameChoice::Part(7, 7)));
        for bad in ["", "-", "-1", "9-0", "1.5", "0-9-12", "all", "99999999999"] {
            assert!(bad.parse::<FrameChoice>().is_err(), "{bad}");
        }
    }

    #[test]
    fn no_two_frames_share_a_file() {
        let frames = |patterns: &[&str]| {
            let outputs = patterns.iter().map(PathBuf::from).collect();
            super::frames(vec![Scene::default(); 12], &Request { outputs, ..Request::default() })
        };
        assert_eq!(
            frames(&["a/#.png", "b/#.png"]).unwrap()[11].request.outputs,
            [Path::new("a/11.png"), Path::new("b/11.png")]
        );
        for shared in [["a#.png", "a#.png"], ["a#.png", "a1#.png"]] {
            assert!(frames(&shared).unwrap_err().to_string().contains("two frames"), "{shared:?}");
        }
    }
}
