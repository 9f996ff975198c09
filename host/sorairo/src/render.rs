//! From a scene to files.

use std::path::PathBuf;
use std::sync::Arc;
use std::thread::Scope;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::device::{Device, DeviceKind, Times};
use crate::error::{Error, Result};
use crate::files::{self, Format, Image, Staged, Writer};
use crate::input::shown;
use crate::irradiance::SkyLight;
use sorairo_shared::variant::PixelFormat;

use crate::plan::Plan;
use crate::plan::explain::explain;
use crate::plan::lookup::Lookup;
use crate::scene::{ColourObserver, ColourPath, ExrDepth, Fit, Rgb, Scene, ValidScene, WhiteBalance};

/// Wavelengths (nm) of a spectral file, if none are asked for: 380 to 780 by 10.
pub fn default_wavelengths() -> Vec<f64> {
    (0..=40).map(|i| 380.0 + 10.0 * f64::from(i)).collect()
}

/// Most wavelengths of a spectral file.
pub const MOST_WAVELENGTHS: usize = 512;

/// What to make of a scene.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Files to write.
    pub outputs: Vec<PathBuf>,
    /// Whether every EXR file is spectral, whatever its name.
    pub spectral: bool,
    /// Wavelengths of spectral files (nm, where the scene is known, no two the same); [`default_wavelengths`] if none are given.
    pub wavelengths: Option<Vec<f64>>,
    /// Whether to measure the downwelling irradiance.
    pub sky_light: bool,
}

impl Request {
    /// The files' formats, in their order.
    ///
    /// # Errors
    ///
    /// Those of [`Format::of`].
    pub fn formats(&self) -> Result<Vec<Format>> {
        self.outputs.iter().map(|path| Format::of(path, self.spectral)).collect()
    }

    /// Whether every file is there already, whole, and made of this scene by this version of the program.
    pub fn is_finished(&self, scene: &Scene) -> bool {
        let Ok(formats) = self.formats() else { return false };
        let Ok(wavelengths) = wavelengths(scene, self, &formats) else { return false };
        self.outputs.iter().zip(formats).all(|(path, format)| files::is_finished(path, format, scene, &wavelengths))
    }
}

/// What a rendering did, as `--json` prints it.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Name of the device.
    pub device: String,
    /// What kind of device.
    pub backend: DeviceKind,
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
    /// Elevation of the sun (degrees).
    pub sun_elevation: f64,
    /// Azimuth of the sun, clockwise from north (degrees).
    pub sun_azimuth: f64,
    /// The fit through the bands.
    pub fit: Fit,
    /// How the fit became a colour.
    pub color: ColourPath,
    /// The space of linear RGB.
    pub rgb: Rgb,
    /// The colour observer.
    pub observer: ColourObserver,
    /// Which light became the white of the RGB space.
    pub white_balance: WhiteBalance,
    /// Samples per piece.
    pub steps: u32,
    /// Whether pixels were integrated or looked up, and why.
    pub path: Lookup,
    /// What the plan skips, and what that saves.
    pub explain: Vec<String>,
    /// Factor from linear RGB to the picture's linear value, as a power of two.
    pub exposure_ev: f32,
    /// The downwelling irradiance, if it was asked for.
    #[serde(flatten)]
    pub sky_light: Option<SkyLight>,
    /// Time to decide what to compute (ms).
    pub plan_ms: f64,
    /// Time of the kernels (ms).
    pub kernel_ms: f64,
    /// Time to bring the pixels back (ms).
    pub readback_ms: f64,
    /// Time until the files were written once the last pixel was back (ms); until then encoding runs beside the kernels.
    pub encode_ms: f64,
    /// All of it (ms).
    pub total_ms: f64,
    /// The files written.
    #[serde(serialize_with = "as_text")]
    pub outputs: Vec<PathBuf>,
}

/// Paths as text, whatever bytes their names hold.
fn as_text<S: serde::Serializer>(paths: &[PathBuf], serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_seq(paths.iter().map(|path| path.to_string_lossy()))
}

/// Milliseconds of a duration.
fn ms(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

/// A scene that is planned, and the files that it is to fill: all that can be wrong with them was checked.
pub struct Job {
    /// What to compute.
    pub plan: Plan,
    outputs: Vec<PathBuf>,
    formats: Vec<Format>,
    scene: ValidScene,
}

impl Job {
    /// Plans a scene for files.
    ///
    /// # Errors
    ///
    /// What is wrong with the files' names, or with what is asked of them.
    pub fn new(scene: &ValidScene, request: &Request) -> Result<Self> {
        let outputs = &request.outputs;
        let formats = request.formats()?;
        let spectral = wavelengths(scene, request, &formats)?;
        // A picture alone is packed on the device, 4 bytes a pixel; a linear image serves for both.
        let pixel = match (formats.as_slice(), scene.render.exr) {
            _ if !spectral.is_empty() => PixelFormat::LinearRgb,
            (formats, _) if !formats.contains(&Format::Exr) => PixelFormat::Picture,
            (formats, ExrDepth::Half) if !formats.contains(&Format::Png) => PixelFormat::HalfRgb,
            _ => PixelFormat::LinearRgb,
        };
        if scene.sun.disc && scene.render.exr == ExrDepth::Half && formats.contains(&Format::Exr) {
            return Err(Error::not_allowed(
                "sun.disc",
                "needs render.exr = f32: the disc is brighter than half floats reach",
            ));
        }
        for path in outputs {
            files::check_writable(path)?;
        }
        files::check_distinct(outputs)?;
        for (path, &format) in outputs.iter().zip(&formats) {
            files::check_room(path, format, scene.camera.size, scene.render.exr, spectral.len() as u64)?;
        }
        let mut plan = Plan::new(scene, pixel);
        if !spectral.is_empty() {
            plan = plan.with_spectrum(&spectral)?;
        }
        Ok(Self { plan, outputs: outputs.clone(), formats, scene: scene.clone() })
    }

    /// Computes the pixels; each file is encoded meanwhile, on a thread of its own.
    ///
    /// # Errors
    ///
    /// [`Error::Device`] if every device failed, [`Error::NotAllowed`] if the image is too wide for the device,
    /// [`Error::Write`] if a file cannot be written.
    pub fn compute<'scope>(
        &self,
        scope: &'scope Scope<'scope, '_>,
        device: &mut Device,
    ) -> Result<(Times, Files<'scope>)> {
        let plan = &self.plan;
        let image = Image::of(plan, &self.scene);
        let begin = |(path, &format): (&PathBuf, &Format)| Writer::start(scope, path.clone(), format, image.clone());
        let files = Files { writers: self.outputs.iter().zip(&self.formats).map(begin).collect() };
        let computing = device.rows(plan, plan.kernel(), &mut |_, rows| {
            check_rows(plan.pixel, rows)?;
            let rows: Arc<[u32]> = rows.into();
            files.writers.iter().try_for_each(|writer| writer.take(Arc::clone(&rows)))
        });
        match computing {
            Ok(times) => Ok((times, files)),
            // An encoder that failed knows why.
            Err(error @ Error::Write { .. }) => Err(files.staged().err().unwrap_or(error)),
            Err(error) => Err(error),
        }
    }
}

/// The files of a job whose pixels are computed.
#[must_use = "files that are not finished are removed"]
pub struct Files<'scope> {
    writers: Vec<Writer<'scope>>,
}

impl Files<'_> {
    /// Waits for the encoders. Every file is whole before the first takes its place, so that a failure leaves all of them as
    /// they were.
    ///
    /// # Errors
    ///
    /// [`Error::Write`] if a file cannot be written.
    pub fn finish(self) -> Result<()> {
        self.staged()?.into_iter().try_for_each(Staged::commit)
    }

    fn staged(self) -> Result<Vec<Staged>> {
        self.writers.into_iter().map(Writer::finish).collect()
    }
}

/// Renders a scene into files; the device is opened once the request is known to be right.
///
/// # Errors
///
/// What is wrong with the device or the files' names, before any work; [`Error::Device`] or [`Error::Write`] for a
/// failed device or file.
pub fn render(
    scene: &ValidScene,
    request: &Request,
    open: impl FnOnce() -> Result<Device>,
    stage: impl Fn(&str),
) -> Result<Report> {
    let start = Instant::now();
    let job = Job::new(scene, request)?;
    let planned = start.elapsed();
    stage("opening the device");
    let mut device = open()?;
    stage("computing the sky");
    let (times, encoding) = std::thread::scope(|scope| {
        let (times, files) = job.compute(scope, &mut device)?;
        stage("writing files");
        let computed = Instant::now();
        files.finish().map(|()| (times, computed.elapsed()))
    })?;
    let plan = &job.plan;
    let sky_light = request.sky_light.then(|| {
        stage("measuring the sky's light");
        SkyLight::new(&plan.sky)
    });
    Ok(Report {
        device: device.name,
        backend: device.kind,
        width: plan.width(),
        height: plan.height(),
        sun_elevation: scene.sun.elevation,
        sun_azimuth: scene.sun.azimuth,
        fit: scene.render.fit,
        color: scene.render.color,
        rgb: plan.sky.space.rgb,
        observer: plan.sky.observer,
        white_balance: plan.sky.space.balance,
        steps: plan.samples_per_piece(),
        path: plan.lookup.clone(),
        explain: explain(plan, scene.camera.projection),
        exposure_ev: plan.uniform.exposure.log2(),
        sky_light,
        plan_ms: ms(planned),
        kernel_ms: ms(times.kernel),
        readback_ms: ms(times.readback),
        encode_ms: ms(encoding),
        total_ms: ms(start.elapsed()),
        outputs: request.outputs.clone(),
    })
}

/// The wavelengths of the spectral files that a request asks for (nm, increasing); none if it asks for no such file.
fn wavelengths(scene: &Scene, request: &Request, formats: &[Format]) -> Result<Vec<f64>> {
    if !formats.contains(&Format::SpectralExr) {
        let refuse = |key| Err(Error::NoSpectralFile { key });
        return match request {
            Request { spectral: true, .. } => refuse("spectral"),
            Request { wavelengths: Some(_), .. } => refuse("wavelengths"),
            _ => Ok(Vec::new()),
        };
    }
    let mut wavelengths = request.wavelengths.clone().unwrap_or_else(default_wavelengths);
    let refuse = |complaint| Err(Error::not_allowed("wavelengths", complaint));
    let count = wavelengths.len();
    if !(1..=MOST_WAVELENGTHS).contains(&count) {
        return refuse(format!("holds {count} wavelengths; a spectral file takes 1 to {MOST_WAVELENGTHS} of them"));
    }
    let (shortest, longest) = scene.optics().known_wavelengths();
    if let Some(outside) = wavelengths.iter().find(|&&nm| !(shortest..=longest).contains(&nm)) {
        return refuse(format!("holds {}; wavelengths must lie between {shortest} and {longest} nm", shown(*outside)));
    }
    wavelengths.sort_by(f64::total_cmp);
    match wavelengths.windows(2).find(|pair| pair[1] - pair[0] < CLOSEST_WAVELENGTHS) {
        Some(pair) => refuse(format!(
            "holds {} and {}; wavelengths must lie at least {CLOSEST_WAVELENGTHS} nm apart",
            pair[0], pair[1]
        )),
        None => Ok(wavelengths),
    }
}

/// Wavelengths (nm) closer than this have the same name in a spectral file.
const CLOSEST_WAVELENGTHS: f64 = 1e-5;

/// Refuses rows that hold what no kernel stores: the sentinel of a pixel that was never written, or what no radiance is.
fn check_rows(pixel: PixelFormat, rows: &[u32]) -> Result<()> {
    const OPAQUE: u32 = 0xff00_0000;
    const HALF_INFINITY: u32 = 0x7c00;
    let wrong = match pixel {
        PixelFormat::Picture => rows.iter().any(|&word| word & OPAQUE != OPAQUE),
        PixelFormat::LinearRgb | PixelFormat::LinearRgba => rows.iter().any(|&word| {
            let value = f32::from_bits(word);
            !(value.is_finite() && value >= 0.0)
        }),
        PixelFormat::HalfRgb => rows.iter().any(|&word| word & 0xffff >= HALF_INFINITY || word >> 16 >= HALF_INFINITY),
    };
    if wrong { Err(Error::Device("it left pixels that hold no radiance".into())) } else { Ok(()) }
}
