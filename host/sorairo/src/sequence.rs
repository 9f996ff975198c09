//! Frames one after the other: while one is computed, the next is planned and the one before is encoded.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::Builder;

use rayon::prelude::*;
use sorairo_shared::variant::PixelFormat;

use crate::device::Device;
use crate::error::{Error, Result};
use crate::files;
use crate::plan::{LightFields, Plan};
use crate::render::{Files, Job, Request, Shown};
use crate::scene::{Exposure, Scene, ValidScene};

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
    Rendered {
        /// Whether every pixel was integrated, which takes several times as long as the sky lookup.
        direct: bool,
        /// Whether a file of it took the place of another.
        replaced: bool,
    },
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

/// Which frame's automatic exposure all frames have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SharedExposure {
    /// That of the first.
    First,
    /// That of the brightest, so that no frame is brighter than it may be. Of frames that differ in their sun alone it is the one with the
    /// highest sun.
    Brightest,
}

/// The scenes with one exposure for all, which depends on all of them and on nothing else: processes that render parts of a sequence find the
/// same.
///
/// # Errors
///
/// [`Error::OutOfRange`] for an exposure that may not be asked for.
pub fn share_exposure(scenes: Vec<ValidScene>, of: SharedExposure) -> Result<Vec<ValidScene>> {
    let candidates = match of {
        SharedExposure::First => scenes.iter().take(1).collect(),
        SharedExposure::Brightest => highest_suns(&scenes),
    };
    let stops = |scene: &&ValidScene| -> Result<f64> {
        let scene = ValidScene::clone(scene).exposed(Exposure::Auto)?;
        Ok(f64::from(Plan::new(&scene, PixelFormat::Picture).uniform.exposure).log2())
    };
    let stops: Vec<f64> = candidates.par_iter().map(stops).collect::<Result<_>>()?;
    let Some(least) = stops.into_iter().min_by(f64::total_cmp) else { return Ok(scenes) };
    // Devices and machines may differ in the last digit, and a part of a sequence may be rendered on any.
    let exposure = Exposure::Stops((100.0 * least).round() / 100.0);
    scenes.into_iter().map(|scene| scene.exposed(exposure)).collect()
}

/// Of scenes that differ in their sun's place alone, the one with the highest sun; one for each other sky.
fn highest_suns(scenes: &[ValidScene]) -> Vec<&ValidScene> {
    let mut highest: Vec<(Scene, &ValidScene)> = Vec::new();
    for scene in scenes {
        let mut sky = scene.clone().into_scene();
        (sky.sun.elevation, sky.sun.azimuth) = (0.0, 0.0);
        match highest.iter_mut().find(|(other, _)| *other == sky) {
            Some((_, known)) if known.sun.elevation < scene.sun.elevation => *known = scene,
            Some(_) => {}
            None => highest.push((sky, scene)),
        }
    }
    highest.into_iter().map(|(_, scene)| scene).collect()
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
    // A missing file is told at once; reading takes its time.
    frames.clone().all(is_there) && frames.into_iter().all(|frame| frame.request.is_finished(&frame.scene))
}

/// Renders the frames that are not there yet, in their order.
///
/// A frame counts as there if each of its files is whole to the byte and names the same scene and version of the program.
/// `ended` is called for each frame, in their order, with what it shows where its request asks for the sky's light. No file holds that light, so it
/// is computed for frames that are there already too, some hundredths of a second each. After an error the frames before it are whole and in place.
///
/// # Errors
///
/// Those of [`Job::new`] and [`Job::compute`], with the number of the frame.
pub fn sequence(frames: &[Frame], device: &mut Device, ended: &mut OnEnd<'_>) -> Result<()> {
    std::thread::scope(|scope| {
        let (planned, jobs) = sync_channel(1);
        let (computed, files) = sync_channel(1);
        Builder::new().spawn_scoped(scope, move || plan(frames, &planned)).map_err(Error::Thread)?;
        let finishing = Builder::new().spawn_scoped(scope, move || finish(&files, ended)).map_err(Error::Thread)?;
        let computing = jobs.iter().try_for_each(|(frame, work): (&Frame, Result<Work>)| {
            let Work { job, shown } = work.map_err(|error| of_frame(frame, error))?;
            let files = match job {
                Some(job) => {
                    let replaced = !job.replaced().is_empty();
                    let (_, files) = job.compute(scope, device).map_err(|error| of_frame(frame, error))?;
                    Some((files, Ended::Rendered { direct: job.is_direct(), replaced }))
                }
                None => None,
            };
            // The receiver ends early only with an error of its own, which is the one to tell.
            computed.send(Computed { frame, files, shown }).map_err(|_| writer_ended())
        });
        // Ends the planner, if it has not ended.
        drop(jobs);
        drop(computed);
        let finished = finishing.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        finished.and(computing)
    })
}

/// Plans each frame that is not there yet, one ahead of the device.
fn plan<'a>(frames: &'a [Frame], work: &SyncSender<(&'a Frame, Result<Work>)>) {
    let light_fields = LightFields::default();
    for frame in frames {
        if work.send((frame, Work::of(frame, &light_fields))).is_err() {
            return;
        }
    }
}

/// What is to be done for a frame.
struct Work {
    /// Its rendering, if it is not there yet.
    job: Option<Job>,
    shown: Option<Shown>,
}

impl Work {
    fn of(frame: &Frame, light_fields: &LightFields) -> Result<Self> {
        let Frame { scene, request, .. } = frame;
        let job = if request.is_finished(scene) { None } else { Some(Job::new(scene, request, light_fields)?) };
        let shown = match &job {
            _ if !request.sky_light => None,
            Some(job) => Some(job.shown()),
            None => Some(Shown::of_request(request, scene, light_fields)?),
        };
        Ok(Self { job, shown })
    }
}

/// A frame whose pixels are computed.
struct Computed<'a, 'scope> {
    frame: &'a Frame,
    /// Its files and how it ends with them, unless they are there already.
    files: Option<(Files<'scope>, Ended)>,
    shown: Option<Shown>,
}

/// What is called when a frame has ended.
pub type OnEnd<'a> = dyn FnMut(&Frame, Ended, Option<Shown>) + Send + 'a;

/// Puts the files of each frame into their places once they are encoded.
fn finish(computed: &Receiver<Computed<'_, '_>>, ended: &mut OnEnd<'_>) -> Result<()> {
    for Computed { frame, files, shown } in computed {
        let how = match files {
            Some((files, how)) => files.finish().map(|()| how).map_err(|error| of_frame(frame, error))?,
            None => Ended::Found,
        };
        ended(frame, how, shown);
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
