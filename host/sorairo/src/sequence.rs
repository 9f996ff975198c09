//! Frames one after the other: while one is computed, the next is planned and the one before is encoded.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use crate::device::Device;
use crate::error::{Error, Result};
use crate::files;
use crate::render::{Files, Job, Request};
use crate::scene::ValidScene;

/// One frame of a sequence.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Its number, from 0.
    pub number: u32,
    /// What it shows.
    pub scene: ValidScene,
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

/// The frames that show scenes, numbered from 0. Each is asked for as `request` says, whose outputs are the patterns of its file names; see
/// [`numbered`].
///
/// # Errors
///
/// [`Error::FileName`] for a pattern without a place for the number or of another format, [`Error::SharedFile`] for a file that
/// two frames or patterns share.
pub fn frames(scenes: Vec<ValidScene>, request: &Request) -> Result<Vec<Frame>> {
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
    fn no_two_frames_share_a_file() {
        let frames = |patterns: &[&str]| {
            let outputs = patterns.iter().map(PathBuf::from).collect();
            super::frames(
                vec![crate::Scene::default().validated().unwrap(); 12],
                &Request { outputs, ..Request::default() },
            )
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
