//! Frames in a pipeline: while one is computed, the next is planned and the previous one is encoded.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::Builder;

use sorairo_shared::variant::PixelFormat;

use crate::device::Device;
use crate::error::{Error, Result};
use crate::output::files;
use crate::output::render::{self, Files, Job, Request, Shown};
use crate::plan::{LightFields, Plan};
use crate::scene::{Exposure, ValidScene};

/// One frame of a sequence.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Frame {
    /// Its number, from 0.
    pub number: u32,
    /// Its scene.
    pub scene: ValidScene,
    /// Its files.
    pub request: Request,
}

/// The outcome of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// It was rendered.
    Rendered {
        /// Whether every pixel was integrated, which takes several times as long as with the sky lookup.
        direct: bool,
        /// Whether one of its files replaced another.
        replaced: bool,
    },
    /// Its files existed, complete and with its scene.
    Found,
}

/// The frames of scenes, numbered from 0. Each follows `request`, whose outputs are patterns of file names; see
/// [`numbered`].
///
/// # Errors
///
/// [`Error::FileName`] for a pattern without a place for the number, or of an unknown format; [`Error::SharedFile`] for
/// a file that two frames or patterns share.
pub fn frames(scenes: Vec<ValidScene>, request: &Request) -> Result<Vec<Frame>> {
    request.formats()?;
    let mut names = HashSet::new();
    let frame = |(number, scene)| {
        let outputs: Vec<_> = request.outputs.iter().map(|pattern| numbered(pattern, number)).collect::<Result<_>>()?;
        let request = Request { outputs, ..request.clone() };
        match request.files().into_iter().find(|path| !names.insert(path.clone())) {
            Some(path) => Err(Error::SharedFile { path, how: "a file of two frames" }),
            None => Ok(Frame { number, scene, request }),
        }
    };
    (0..).zip(scenes).map(frame).collect()
}

/// The frame whose automatic exposure applies to all frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SharedExposure {
    /// The first frame.
    First,
    /// The brightest frame, so that no frame is overexposed. The keys alone determine it, so a process plans one sky,
    /// whatever the number of frames. Of frames that differ only in the position of the sun, it is the one with the
    /// highest sun.
    Brightest,
}

/// The scenes with one exposure for all. It depends on the scenes alone, so processes that render parts of a sequence
/// agree.
///
/// # Errors
///
/// [`Error::OutOfRange`] for an exposure out of range.
pub fn share_exposure(scenes: Vec<ValidScene>, of: SharedExposure) -> Result<Vec<ValidScene>> {
    let of = match of {
        SharedExposure::First => scenes.first(),
        SharedExposure::Brightest => brightest(&scenes),
    };
    let Some(of) = of.cloned() else { return Ok(scenes) };
    let plan = Plan::new(&of.exposed(Exposure::Auto)?, PixelFormat::Picture);
    // Devices and machines may differ in the last digit, and a part of a sequence may be rendered on any.
    let stops = (100.0 * f64::from(plan.uniform.exposure).log2()).round() / 100.0;
    scenes.into_iter().map(|scene| scene.exposed(Exposure::Stops(stops))).collect()
}

/// The scene whose sky is expected to be the brightest; of equal ones the first.
fn brightest(scenes: &[ValidScene]) -> Option<&ValidScene> {
    let brighter = |a: &(f64, f64, _), b: &(f64, f64, _)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1));
    let rated = scenes.iter().map(|scene| (expected_brightness(scene), scene.sun.elevation, scene));
    rated.rev().max_by(brighter).map(|(.., scene)| scene)
}

/// How bright a sky is expected to be beside others, by its keys alone: the light of 550 nm that the air above the
/// observer scatters once from a sun as high as this. It grows with the sun's elevation, whatever else a sky has.
fn expected_brightness(scene: &ValidScene) -> f64 {
    const WAVELENGTH: f64 = 550.0;
    let optics = scene.optics();
    let coefficients = optics.at(WAVELENGTH);
    let above = |scale_height: f64| scale_height * (-scene.observer.altitude / scale_height).exp();
    // Of what aerosol scatters, that which does not go on as the sun's light did: around the sun it brightens little of
    // a sky.
    let aside = 1.0 - optics.aerosol.asymmetry();
    let depth = coefficients.air_scattering * above(optics.air_scale_height)
        + aside * coefficients.aerosol_scattering * above(optics.aerosol.lane.scale_height);
    let sine = scene.sun.elevation.to_radians().sin();
    // The sine of a high sun, and on a round planet more than nothing of a low one.
    let level = 0.5 * (sine + sine.hypot(0.02));
    // From the horizon down a sky loses more than two powers of ten in six degrees: 600, 3 and 0.008 lx at 0, -6 and
    // -12 degrees.
    let twilight = 10_f64.powf(scene.sun.elevation.min(0.0) / 3.0);
    optics.solar_irradiance(WAVELENGTH) * level * -(-depth / level).exp_m1() * twilight
}

/// Creates missing folders of frames.
///
/// # Errors
///
/// [`Error::FileName`] if a folder cannot be created.
pub fn make_folders(frames: &[Frame]) -> Result<()> {
    // The number stands in the file name, so that all frames have the folders of any.
    let outputs = frames.first().map_or(&[][..], |frame| &frame.request.outputs);
    outputs.iter().try_for_each(|path| files::make_folder(path))
}

/// Whether the files of all frames are whole and show their scenes, as [`sequence`] leaves them.
pub fn are_finished<'a>(frames: impl Iterator<Item = &'a Frame> + Clone) -> bool {
    let is_there = |frame: &Frame| frame.request.files().iter().all(|path| path.is_file());
    let light_fields = LightFields::default();
    // A missing file is told at once; reading takes its time.
    frames.clone().all(is_there)
        && frames.into_iter().all(|frame| frame.request.is_finished(&frame.scene, &light_fields))
}

/// The frames whose irradiance is computed. No file holds it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Measured {
    /// None.
    None,
    /// Rendered frames, whose skies are planned anyway.
    Rendered,
    /// Skipped frames too, at some hundredths of a second each.
    All,
}

/// Renders the missing frames, in order.
///
/// A frame exists if each of its files is complete to the byte and names the same scene and version of the program.
/// `ended` is called for each frame, in order, with its irradiance if requested. After an error, all earlier frames are
/// complete.
///
/// # Errors
///
/// Those of [`Job::all`] and [`render::compute`], with the number of the frame.
pub fn sequence(frames: &[Frame], measured: Measured, device: &mut Device, ended: &mut OnEnd<'_>) -> Result<()> {
    std::thread::scope(|scope| {
        let (planned, jobs) = sync_channel(1);
        let (computed, files) = sync_channel(1);
        Builder::new().spawn_scoped(scope, move || plan(frames, measured, &planned)).map_err(Error::Thread)?;
        let finishing = Builder::new().spawn_scoped(scope, move || finish(&files, ended)).map_err(Error::Thread)?;
        let computing = jobs.iter().try_for_each(|(frame, work): (&Frame, Result<Work>)| {
            let Work { jobs, shown } = work.map_err(|error| of_frame(frame, error))?;
            let files = match &jobs[..] {
                [] => None,
                [first, ..] => {
                    let replaced = jobs.iter().any(|job| !job.replaced().is_empty());
                    let (_, files) = render::compute(&jobs, scope, device).map_err(|error| of_frame(frame, error))?;
                    Some((files, Ended::Rendered { direct: first.is_direct(), replaced }))
                }
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
fn plan<'a>(frames: &'a [Frame], measured: Measured, work: &SyncSender<(&'a Frame, Result<Work>)>) {
    let light_fields = LightFields::default();
    for frame in frames {
        if work.send((frame, Work::of(frame, measured, &light_fields))).is_err() {
            return;
        }
    }
}

/// What is to be done for a frame.
struct Work {
    /// Its renderings, if it is not there yet.
    jobs: Vec<Job>,
    shown: Option<Shown>,
}

impl Work {
    fn of(frame: &Frame, measured: Measured, light_fields: &LightFields) -> Result<Self> {
        let Frame { scene, request, .. } = frame;
        let is_there = request.is_finished(scene, light_fields);
        let jobs = if is_there { Vec::new() } else { Job::all(scene, request, light_fields)? };
        let shown = match jobs.first() {
            Some(job) => (measured != Measured::None).then(|| job.shown()),
            None if measured == Measured::All => Some(Shown::of_request(request, scene, light_fields)?),
            None => None,
        };
        Ok(Self { jobs, shown })
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

    fn scene(toml: &str) -> ValidScene {
        let text = format!("render.orders = 1\n{toml}");
        crate::Scene::parse(&text, "a.toml", None).unwrap().validated().unwrap()
    }

    fn automatic(scene: &ValidScene) -> f64 {
        f64::from(Plan::new(scene, PixelFormat::Picture).uniform.exposure).log2()
    }

    fn shared(scenes: Vec<ValidScene>) -> f64 {
        let exposures = share_exposure(scenes, SharedExposure::Brightest).unwrap().into_iter();
        let stops = exposures.map(|scene| match scene.render.exposure {
            Exposure::Stops(stops) => stops,
            Exposure::Auto | Exposure::Adapt => panic!("not shared"),
        });
        stops.reduce(|a, b| if a == b { a } else { panic!("{a} and {b}") }).unwrap()
    }

    #[test]
    fn a_shared_exposure_is_that_of_the_brightest_sky() {
        let skies = |texts: &[&str]| texts.iter().map(|text| scene(text)).collect::<Vec<_>>();
        for of in [
            &["sun.elevation = 4", "sun.elevation = -8", "sun.elevation = 12"][..],
            &["sun.elevation = -3", "sun.elevation = -9", "preset = 'hazy'\nsun.elevation = -5"],
            &["sun.elevation = 30", "preset = 'hazy'\nsun.elevation = 30", "sun.elevation = 20"],
            &["sun.elevation = 30", "sun.elevation = 30\nsun.distance = 0.5", "sun.elevation = 40"],
            &["observer.altitude = 40\nsun.elevation = 50", "sun.elevation = 40", "sun.elevation = 0"],
            &["preset = 'mars'\nsun.elevation = 60", "sun.elevation = 60", "sun.elevation = 60\nsun.distance = 3"],
        ] {
            let scenes = skies(of);
            let least = scenes.iter().map(automatic).reduce(f64::min).unwrap();
            // A rule that looks at keys may take one sky for another that is nearly as bright: half a stop, where a
            // highlight keeps two.
            let shared = shared(scenes);
            assert!((shared - least).abs() < 0.5 && shared > least - 0.006, "{of:?}: {shared}, not {least}");
        }
    }

    #[test]
    fn a_common_exposure_plans_one_sky_however_many_there_are() {
        let cases = (0..3000).map(|i| {
            let depth = 0.01 + 1e-5 * f64::from(i);
            scene(&format!("sun.elevation = 30\natmosphere.aerosol.optical_depth = {depth}"))
        });
        let (scenes, start) = (cases.collect::<Vec<_>>(), std::time::Instant::now());
        let one = automatic(&scenes[2999]);
        let of_one = start.elapsed();
        let start = std::time::Instant::now();
        let found = shared(scenes);
        // A plan for each would take 3000 times as long as one; the rest of the work is less than a second.
        let most = 100 * of_one + std::time::Duration::from_secs(2);
        assert!(start.elapsed() < most, "{:?}, and one plan {of_one:?}", start.elapsed());
        assert!((found - one).abs() <= 0.005 + 1e-6, "{found} {one}");
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
