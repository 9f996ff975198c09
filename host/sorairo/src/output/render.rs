//! From a scene to files.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::Scope;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::device::{Device, DeviceKind, Times};
use crate::error::{Error, Result};
use crate::measure::broadband::Broadband;
use crate::measure::irradiance::SkyLight;
use crate::output::files::{self, Format, Image, Replace, Staged, Sunlight, Writer};
use sorairo_shared::variant::PixelFormat;

use crate::measure::spectral_irradiance::SpectralIrradiance;
use crate::measure::spectrum;
use crate::measure::stokes::StokesFrame;
use crate::measure::stokes_image::StokesImage;
use crate::output::encoding::spectral::Spectra;
use crate::plan::explain::{below_the_horizon, explain};
use crate::plan::lookup::Lookup;
use crate::plan::picture::sun_disc::Sun;
use crate::plan::{LightFields, Plan};
use crate::scene::{ColourObserver, ColourPath, Exposure, ExrDepth, Fit, Rgb, ValidScene, WhiteBalance};

/// The files to render of a scene.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Files to write.
    pub outputs: Vec<PathBuf>,
    /// Whether every EXR file is spectral, whatever its name.
    pub spectral: bool,
    /// Wavelengths of spectral files (nm, in the range of the scene, without duplicates); by default
    /// [`files::default_wavelengths`].
    pub wavelengths: Option<Vec<f64>>,
    /// The reference plane of polarisation in spectral EXR files, which then hold the Stokes parameters `S1`, `S2` and
    /// `S3` (0) in addition to radiance; `None` for radiance alone.
    pub stokes: Option<StokesFrame>,
    /// Whether the scene is rendered twice: into the outputs without the sun's disc, for lighting, and into a file
    /// beside each of them with the disc, for camera rays: `sky.sun.exr` beside `sky.exr`. All are renamed into place
    /// together, and have one exposure. Applies to `.png`, `.exr` and `.hdr`, with an optional USD scene.
    pub split_sun: bool,
    /// Whether to compute the downwelling irradiance.
    pub sky_light: bool,
    /// The existing files that it may replace.
    pub replace: Replace,
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

    /// Every file that it writes.
    pub fn files(&self) -> Vec<PathBuf> {
        self.outputs.iter().cloned().chain(self.beside()).collect()
    }

    /// The files with the sun's disc, if it splits off the sun.
    fn beside(&self) -> impl Iterator<Item = PathBuf> {
        let is_rgb = |path: &&PathBuf| Format::of(path, self.spectral).is_ok_and(Format::is_rgb);
        self.outputs.iter().filter(move |path| self.split_sun && is_rgb(path)).map(|path| with_sun(path))
    }

    /// Whether every file exists, is complete, and was made of this scene by this version of the program.
    pub fn is_finished(&self, scene: &ValidScene, light_fields: &LightFields) -> bool {
        if self.split_sun {
            // What exposes both follows from their plans.
            let are_there = self.files().iter().all(|path| path.is_file());
            return are_there
                && Job::all(scene, self, light_fields).is_ok_and(|jobs| jobs.iter().all(Job::is_finished));
        }
        let Ok((scene, formats, spectra)) = self.checked(scene) else { return false };
        let scene = scene.as_asked();
        self.outputs.iter().zip(formats).all(|(path, format)| files::is_finished(path, format, &scene, &spectra))
    }

    /// The text of all properties that [`Request::is_finished`] checks.
    ///
    /// # Errors
    ///
    /// Those of [`Format::of`], and of wavelengths that no file can hold.
    pub fn signature(&self, scene: &ValidScene) -> Result<String> {
        let (scene, formats, spectra) = self.checked(scene)?;
        let scene = scene.as_asked();
        let split = if self.split_sun { "split" } else { "" };
        let signatures = formats.into_iter().map(|format| files::signature(format, &scene, &spectra));
        Ok(signatures.chain([split.into()]).collect())
    }

    /// What it shows of a scene, polarised where Stokes vectors are asked for; its files' formats, and the spectra of
    /// those that have any.
    fn checked(&self, scene: &ValidScene) -> Result<(ValidScene, Vec<Format>, Spectra)> {
        let formats = self.formats()?;
        let wavelengths = files::wavelengths(scene, self.wavelengths.as_deref(), self.spectral, &formats)?;
        let scene = match self.stokes {
            Some(_) if !formats.contains(&Format::SpectralExr) => {
                return Err(Error::not_allowed(
                    "stokes",
                    "is of spectral EXR files, and there is none: NAME.spectral.exr",
                ));
            }
            Some(_) => scene.polarised()?,
            None => scene.clone(),
        };
        Ok((scene, formats, Spectra { wavelengths, stokes: self.stokes }))
    }
}

/// The report of a rendering, as `--json` prints it.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Report {
    /// Name of the device.
    pub device: String,
    /// What kind of device.
    pub backend: DeviceKind,
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
    /// Elevation of the sun (degrees), without refraction.
    pub sun_elevation: f64,
    /// Apparent elevation (degrees); `None` without refraction, or with the sun's centre below the horizon.
    pub sun_apparent_elevation: Option<f64>,
    /// Azimuth of the sun, clockwise from north (degrees).
    pub sun_azimuth: f64,
    /// Whether the image includes the sun's disc where it is visible; if so, a program must not add a sun of its own.
    pub sun_disc: bool,
    /// The fit through the bands.
    pub fit: Fit,
    /// The computation of the colour from the fit.
    pub color: ColourPath,
    /// The space of linear RGB.
    pub rgb: Rgb,
    /// The colour observer.
    pub observer: ColourObserver,
    /// The light adapted to the white of the RGB space.
    pub white_balance: WhiteBalance,
    /// Samples per piece.
    pub steps: u32,
    /// Whether pixels were integrated or looked up, with the reason.
    pub path: Lookup,
    /// What the plan omits, and the time saved.
    pub explain: Vec<String>,
    /// Exposure of the picture (stops).
    pub exposure_ev: f32,
    /// Exposure of the values of EXR files (stops), as their headers say.
    pub exr_exposure_ev: f32,
    /// The downwelling irradiance, if requested.
    #[serde(flatten)]
    pub sky_light: Option<SkyLight>,
    /// Irradiance by the sun and the sky from 280 to 2500 nm, if known.
    #[serde(flatten)]
    pub broadband: Option<Broadband>,
    /// The same at the wavelengths of spectral files, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spectral_irradiance: Option<SpectralIrradiance>,
    /// Time of the plan (ms).
    pub plan_ms: f64,
    /// Time of the kernels (ms).
    pub kernel_ms: f64,
    /// Time of the read-back (ms).
    pub readback_ms: f64,
    /// Time from the last pixel until the files were written (ms); before that, encoding overlaps with the kernels.
    pub encode_ms: f64,
    /// Total time (ms).
    pub total_ms: f64,
    /// The files written.
    #[serde(serialize_with = "as_text")]
    pub outputs: Vec<PathBuf>,
    /// The written files that replaced another.
    #[serde(serialize_with = "as_text")]
    pub replaced: Vec<PathBuf>,
}

/// Paths as text, with any bytes in their names.
fn as_text<S: serde::Serializer>(paths: &[PathBuf], serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_seq(paths.iter().map(|path| path.to_string_lossy()))
}

/// Milliseconds of a duration.
fn ms(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

/// A planned scene and its files, with all checks done.
pub struct Job {
    /// Files of linear pixels before those of pictures.
    parts: Vec<Part>,
    outputs: Vec<PathBuf>,
    replace: Replace,
    scene: ValidScene,
}

/// Files whose pixels are the same.
struct Part {
    plan: Plan,
    /// The width of the bands of its spectra (nm), where these are no values at wavelengths.
    bands: Option<f64>,
    /// The plane from which their Stokes parameters count, where they have any.
    stokes: Option<StokesFrame>,
    outputs: Vec<(PathBuf, Format)>,
}

impl Job {
    /// Plans a scene for files; see [`Plan::with_light_fields`].
    ///
    /// # Errors
    ///
    /// What is wrong with the files' names, or with what is asked of them.
    pub fn new(scene: &ValidScene, request: &Request, light_fields: &LightFields) -> Result<Self> {
        let outputs = &request.outputs;
        let (polarised, formats, spectra) = request.checked(scene)?;
        let (scene, spectral) = (&polarised, &spectra.wavelengths);
        files::check_scenes(outputs, &formats, scene)?;
        for path in outputs {
            files::check_writable(path)?;
        }
        files::check_distinct(outputs)?;
        for (path, &format) in outputs.iter().zip(&formats) {
            files::check_room(path, format, scene.camera.size, scene.render.exr, spectra.channels() as u64)?;
        }
        let has_bands = formats.contains(&Format::RadiancePicture);
        let (pictures, linear): (Vec<_>, Vec<_>) =
            outputs.iter().cloned().zip(formats).partition(|(_, format)| *format == Format::Png);
        let mut parts = Vec::new();
        let has_spectra = linear.iter().any(|(_, format)| *format == Format::SpectralExr);
        let (bands, points): (Vec<_>, Vec<_>) = linear.into_iter().partition(|(_, format)| match format {
            Format::RadiancePicture | Format::RadianceScene => true,
            // What holds no spectrum goes along with what does.
            _ => has_bands && !has_spectra,
        });
        let linear = || Plan::with_light_fields(scene, PixelFormat::LinearRgb, light_fields);
        if !points.is_empty() {
            let plan = if has_spectra { linear().with_spectrum(spectral)? } else { linear() };
            parts.push(Part { plan, bands: None, stokes: spectra.stokes.filter(|_| has_spectra), outputs: points });
        }
        if !bands.is_empty() {
            let width = files::band_width(spectral);
            let plan = linear().with_bands(spectral, width)?;
            parts.push(Part { plan, bands: Some(width), stokes: None, outputs: bands });
        }
        if !pictures.is_empty() || parts.is_empty() {
            let plan = Plan::with_light_fields(scene, PixelFormat::Picture, light_fields);
            parts.push(Part { plan, bands: None, stokes: None, outputs: pictures });
        }
        Ok(Self { parts, outputs: outputs.clone(), replace: request.replace, scene: scene.clone() })
    }

    /// The plan of its linear pixels, or of its picture where that is all there is.
    pub fn plan(&self) -> &Plan {
        &self.first().plan
    }

    fn first(&self) -> &Part {
        self.parts.first().expect("a job has a plan")
    }

    /// The plan of its picture, or of its linear pixels likewise.
    fn picture(&self) -> &Plan {
        &self.parts.last().expect("a job has a plan").plan
    }

    /// What its plans do and leave out.
    fn explain(&self) -> Vec<String> {
        let mut lines = explain(self.plan(), self.scene.camera.projection);
        let below = |part: &Part| {
            let names: Vec<_> = part.outputs.iter().map(|(path, _)| path.to_string_lossy()).collect();
            below_the_horizon(&part.plan, &names.join(", "))
        };
        lines.extend(self.parts.iter().filter_map(below));
        lines
    }

    /// The jobs of a request: one, or two of one sky where the sun is split off, the one without its disc first.
    ///
    /// # Errors
    ///
    /// [`Error::FileName`] for a file of another format than the sun may be split off; those of [`Job::new`].
    pub fn all(scene: &ValidScene, request: &Request, light_fields: &LightFields) -> Result<Vec<Self>> {
        match request.split_sun {
            true => split(scene, request, light_fields),
            false => Ok(vec![Self::new(scene, request, light_fields)?]),
        }
    }

    /// Whether its files, which hold no spectra, are there already, whole, and made of its scene.
    fn is_finished(&self) -> bool {
        let scene = self.scene.as_asked();
        let mut files = self.parts.iter().flat_map(|part| &part.outputs);
        files.all(|(path, format)| files::is_finished(path, *format, &scene, &Spectra::default()))
    }

    /// Its outputs that would take the place of a file.
    pub fn replaced(&self) -> Vec<PathBuf> {
        self.outputs.iter().filter(|path| path.is_file()).cloned().collect()
    }

    /// Checks that every file that is there may be replaced.
    fn check_replaced(&self) -> Result<()> {
        self.outputs.iter().try_for_each(|path| self.replace.check(path))
    }

    /// What the image shows.
    pub fn shown(&self) -> Shown {
        Shown::of(self.plan(), self.picture())
    }

    /// Whether every pixel is integrated, none interpolated from a sky lookup.
    pub fn is_direct(&self) -> bool {
        self.plan().lookup.size.is_none()
    }
}

impl Part {
    /// The sun of its spectra.
    fn sun(&self) -> Sun<'_> {
        let Plan { sky, .. } = &self.plan;
        match self.bands {
            Some(width) => Sun::over_bands(sky, self.plan.wavelengths(), width),
            None => Sun::at(sky, self.plan.wavelengths()),
        }
    }

    /// Begins its files, each encoded on a thread of its own.
    fn begin<'scope>(&self, scope: &'scope Scope<'scope, '_>, scene: &ValidScene) -> Result<Files<'scope>> {
        let plan = &self.plan;
        let mut image = Image::of(plan, scene);
        image.spectra.stokes = self.stokes;
        if self.outputs.iter().any(|(_, format)| format.is_scene()) {
            let sun = self.sun();
            image.sun = Sunlight {
                spectrum: sun.spectral_irradiance(|_| 1.0),
                rgb: plan.sky.sun_irradiance().rgb.to_array(),
                across: sun.across(),
            };
        }
        let begin = |(path, format): &(PathBuf, Format)| Writer::start(scope, path.clone(), *format, image.clone());
        Ok(Files { writers: self.outputs.iter().map(begin).collect::<Result<_>>()? })
    }

    /// Computes the pixels of its files.
    fn fill(&self, files: &Files<'_>, device: &mut Device) -> Result<Times> {
        let plan = &self.plan;
        let spectral = plan.spectral.as_deref();
        let stokes = self.stokes.zip(spectral).map(|(frame, spectral)| StokesImage::new(&plan.sky, spectral, frame));
        device.rows(plan, plan.kernel(), &mut |first, rows| {
            check_rows(plan.pixel, rows)?;
            let rows: Arc<[u32]> = match &stokes {
                Some(stokes) => stokes.beside(first, rows).into(),
                None => rows.into(),
            };
            files.writers.iter().try_for_each(|writer| writer.take(Arc::clone(&rows)))
        })
    }
}

/// What an image shows, beside its pixels.
#[derive(Clone, Copy, Debug, Serialize)]
#[non_exhaustive]
pub struct Shown {
    /// Exposure of the picture (stops).
    pub exposure_ev: f32,
    /// Exposure of the values of EXR files (stops), as their headers say.
    pub exr_exposure_ev: f32,
    /// What falls from its sky.
    #[serde(flatten)]
    pub sky_light: SkyLight,
}

impl Shown {
    fn of(plan: &Plan, picture: &Plan) -> Self {
        Self {
            exposure_ev: picture.exposure(),
            exr_exposure_ev: plan.linear_exposure(plan.sky.scene.render.exr),
            sky_light: SkyLight::new(&plan.sky),
        }
    }

    /// That of a request whose files are there already.
    ///
    /// # Errors
    ///
    /// Those of [`Format::of`].
    pub fn of_request(request: &Request, scene: &ValidScene, light_fields: &LightFields) -> Result<Self> {
        let picture = Plan::with_light_fields(scene, PixelFormat::Picture, light_fields);
        if request.formats()?.iter().all(|&format| format == Format::Png) {
            return Ok(Self::of(&picture, &picture));
        }
        Ok(Self::of(&Plan::with_light_fields(scene, PixelFormat::LinearRgb, light_fields), &picture))
    }
}

/// The files of a job whose pixels are computed.
#[must_use = "files that are not finished are removed"]
pub struct Files<'scope> {
    writers: Vec<Writer<'scope>>,
}

impl Files<'_> {
    /// Waits for the encoders. Every file is whole before the first takes its place, and a failure leaves all of them
    /// as they were.
    ///
    /// # Errors
    ///
    /// [`Error::Write`] if a file cannot be written.
    pub fn finish(self) -> Result<()> {
        files::commit_all(self.staged()?)
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
    let jobs = Job::all(scene, request, &LightFields::default())?;
    render_jobs(start, &jobs, request, open, stage)
}

/// The two jobs of a request that splits off the sun.
fn split(scene: &ValidScene, request: &Request, light_fields: &LightFields) -> Result<Vec<Job>> {
    let formats = request.formats()?;
    let mut named = request.outputs.iter().zip(&formats);
    if let Some((path, _)) = named.find(|(_, format)| !format.is_rgb() && **format != Format::UsdScene) {
        let complaint = "the sun's disc is split off .png, .exr and .hdr files alone; spectral files and scenes of Radiance never hold it";
        return Err(Error::FileName { path: path.clone(), complaint: complaint.into() });
    }
    files::check_distinct(&request.files())?;
    let of_seen = Request { outputs: request.beside().collect(), ..request.clone() };
    let mut seen = Job::new(&scene.with_disc(true)?, &of_seen, light_fields)?;
    let mut light = scene.with_disc(false)?;
    // Those of the brighter one hold for both, so that one file can take the place of the other.
    if formats.contains(&Format::Png) && !matches!(scene.render.exposure_of_pictures(), Exposure::Stops(_)) {
        light = light.exposed(Exposure::Stops(f64::from(seen.picture().exposure())))?;
    }
    if scene.render.exr == ExrDepth::Half && scene.render.exr_exposure == Exposure::Auto {
        let stops = Exposure::Stops(f64::from(seen.plan().linear_exposure(ExrDepth::Half)));
        light = light.exposed_linear(stops)?;
        seen = Job::new(&seen.scene.clone().exposed_linear(stops)?, &of_seen, light_fields)?;
    }
    Ok(vec![Job::new(&light, request, light_fields)?, seen])
}

/// The file beside another that shows the same sky with the sun's disc.
fn with_sun(path: &Path) -> PathBuf {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_extension(format!("sun.{extension}"))
}

/// Computes the pixels of jobs of one sky; their files are encoded meanwhile.
///
/// # Errors
///
/// [`Error::FileExists`] or [`Error::ForeignFile`] if a file that is there must stay; [`Error::Device`] if every device
/// failed, [`Error::NotAllowed`] if the image is too wide for the device, [`Error::Write`] if a file cannot be written.
pub fn compute<'scope>(
    jobs: &[Job],
    scope: &'scope Scope<'scope, '_>,
    device: &mut Device,
) -> Result<(Times, Files<'scope>)> {
    jobs.iter().try_for_each(Job::check_replaced)?;
    let parts: Vec<_> = jobs.iter().flat_map(|job| job.parts.iter().map(|part| (part, &job.scene))).collect();
    let begun: Vec<Files<'_>> = parts.iter().map(|(part, scene)| part.begin(scope, scene)).collect::<Result<_>>()?;
    let mut times = Times::default();
    let filled = parts.iter().zip(&begun).try_for_each(|((part, _), files)| {
        times += part.fill(files, device)?;
        Ok(())
    });
    let files = Files { writers: begun.into_iter().flat_map(|files| files.writers).collect() };
    match filled {
        Ok(()) => {}
        // An encoder that failed knows why.
        Err(error @ Error::Write { .. }) => return Err(files.staged().err().unwrap_or(error)),
        Err(error) => return Err(error),
    }
    Ok((times, files))
}

/// Renders jobs of one sky, and reports the first. All files take their places together.
fn render_jobs(
    start: Instant,
    jobs: &[Job],
    request: &Request,
    open: impl FnOnce() -> Result<Device>,
    stage: impl Fn(&str),
) -> Result<Report> {
    let (job, scene) = jobs.first().map(|job| (job, &job.scene)).expect("there is a job");
    let planned = start.elapsed();
    stage("opening the device");
    let mut device = open()?;
    let replaced = jobs.iter().flat_map(Job::replaced).collect();
    stage("computing the sky");
    let (times, encoding) = std::thread::scope(|scope| {
        let (times, files) = compute(jobs, scope, &mut device)?;
        stage("writing files");
        let computed = Instant::now();
        files.finish().map(|()| (times, computed.elapsed()))
    })?;
    let plan = job.plan();
    let sky_light = request.sky_light.then(|| {
        stage("measuring the sky's light");
        SkyLight::new(&plan.sky)
    });
    let broadband = if request.sky_light { Broadband::new(&plan.sky) } else { None };
    let spectral = plan.spectral.as_ref().filter(|_| request.sky_light);
    let spectral_irradiance = spectral.map(|spectral| {
        let (spectra, sun) = (spectrum::Spectra::planned(Arc::clone(spectral)), job.first().sun());
        SpectralIrradiance::by(&spectra, &plan.sky, &sun, plan.wavelengths())
    });
    Ok(Report {
        device: device.name,
        backend: device.kind,
        width: plan.width(),
        height: plan.height(),
        sun_elevation: scene.sun.elevation,
        sun_apparent_elevation: scene.apparent_elevation(),
        sun_azimuth: scene.sun.azimuth,
        sun_disc: scene.sun.disc,
        fit: scene.render.fit,
        color: scene.render.color,
        rgb: plan.sky.space.rgb,
        observer: plan.sky.observer,
        white_balance: plan.sky.space.balance,
        steps: plan.samples_per_piece(),
        path: plan.lookup.clone(),
        explain: job.explain(),
        exposure_ev: job.picture().exposure(),
        exr_exposure_ev: plan.linear_exposure(scene.render.exr),
        sky_light,
        broadband,
        spectral_irradiance,
        plan_ms: ms(planned),
        kernel_ms: ms(times.kernel),
        readback_ms: ms(times.readback),
        encode_ms: ms(encoding),
        total_ms: ms(start.elapsed()),
        outputs: jobs.iter().flat_map(|job| &job.outputs).cloned().collect(),
        replaced,
    })
}

/// Refuses rows that hold what no kernel stores: the sentinel of a pixel that was never written, or what no radiance
/// is.
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
