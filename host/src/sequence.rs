//! Frames one after the other: while one is computed, the next is planned and the one before is encoded.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use crate::backend::Device;
use crate::error::{Error, Result};
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
            computed.send((frame, files)).map_err(|_| Error::failure("a file cannot be written"))
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
    let named = |text: String| format!("frame {}: {text}", frame.number);
    match error {
        Error::Request(text) => Error::Request(named(text)),
        Error::Failure(text) => Error::Failure(named(text)),
        Error::Device(text) => Error::Device(named(text)),
    }
}

/// The file of a frame: a run of `#` in the name becomes the number with at least as many digits.
///
/// # Errors
///
/// [`Error::Request`] if the name holds no `#`, or more than one run.
pub fn numbered(path: &Path, number: u32) -> Result<PathBuf> {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let wrong = || {
        Error::request(format!(
            "-o {}: the file name needs one run of # for the frame's number, such as sky.####.exr",
            path.display()
        ))
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
}
