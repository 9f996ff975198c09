//! From a scene to files.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::Serialize;
use sorairo_shared::sky_spectrum::RGB_WORDS;

use crate::PixelFormat;
use crate::backend::{Device, Run};
use crate::error::{Error, Result};
use crate::irradiance::SkyLight;
use crate::output::exr::Labels;
use crate::output::spectral::SpectralImage;
use crate::output::{self, Format, LinearImage, Staged};
use crate::plan::Plan;
use crate::plan::colour_space::ColourSpace;
use crate::plan::explain::explain;
use crate::plan::path::Path;
use crate::scene::{ColorObserver, ColorPath, ExrDepth, Fit, Rgb, Scene, Size, WhiteBalance};
use crate::tables::MEASURED_RANGE;

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
    /// Wavelengths of spectral files (nm, 360 to 830, no two the same); [`default_wavelengths`] if none are given.
    pub wavelengths: Option<Vec<f64>>,
    /// Whether to measure the light that the sky throws on level ground.
    pub sky_light: bool,
}

/// What a rendering did, as `--json` prints it.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Name of the device.
    pub device: String,
    /// `gpu` or `cpu`.
    pub backend: &'static str,
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
    /// The fit through the bands.
    pub fit: Fit,
    /// How the fit became a colour.
    pub color: ColorPath,
    /// The space of linear RGB.
    pub rgb: Rgb,
    /// The colour observer.
    pub observer: ColorObserver,
    /// Which light became the white of the RGB space.
    pub white_balance: WhiteBalance,
    /// Samples on each piece of a ray.
    pub steps: u32,
    /// Whether pixels were integrated or looked up, and why.
    pub path: Path,
    /// What the plan skips, and what that saves.
    pub explain: Vec<String>,
    /// Factor from linear RGB to the picture's linear value, as a power of two.
    pub exposure_ev: f32,
    /// The light that the sky throws on level ground, if it was asked for.
    #[serde(flatten)]
    pub sky_light: Option<SkyLight>,
    /// Time to decide what to compute (ms).
    pub plan_ms: f64,
    /// Time of the kernels (ms).
    pub kernel_ms: f64,
    /// Time to bring the pixels back (ms).
    pub readback_ms: f64,
    /// Time to encode and write the files (ms).
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

/// Renders a scene into files; the device is opened once the request is known to be right.
///
/// # Errors
///
/// [`Error::Request`] for a wrong scene, device or file name, before any work; [`Error::Failure`] for a failed device or file.
pub fn render(
    scene: &Scene,
    request: &Request,
    open: impl FnOnce() -> Result<Device>,
    stage: impl Fn(&str),
) -> Result<Report> {
    let start = Instant::now();
    let outputs = &request.outputs;
    let formats: Vec<Format> = outputs.iter().map(|path| Format::of(path, request.spectral)).collect::<Result<_>>()?;
    let spectral = wavelengths(request, &formats)?;
    // A picture alone is packed on the device, 4 bytes a pixel; a linear image serves for both.
    let pixel = match (formats.as_slice(), scene.render.exr) {
        _ if spectral.is_some() => PixelFormat::LinearRgb,
        (formats, _) if !formats.contains(&Format::Exr) => PixelFormat::Picture,
        (formats, ExrDepth::Half) if !formats.contains(&Format::Png) => PixelFormat::HalfRgb,
        _ => PixelFormat::LinearRgb,
    };
    let mut plan = Plan::new(scene, pixel)?;
    if let Some(wavelengths) = spectral {
        plan = plan.with_spectrum(&wavelengths)?;
    }
    for path in outputs {
        output::check_writable(path)?;
    }
    output::check_distinct(outputs)?;
    check_memory(scene.camera.size, plan.pixel_words())?;
    let planned = start.elapsed();
    stage("opening the device");
    let device = open()?;
    stage("computing the sky");
    let run = device.backend.run(&plan, plan.kernel())?;
    stage("writing files");
    let encoding = Instant::now();
    let (kernel, readback) = (run.kernel, run.readback);
    write(scene, &plan, run, &formats, outputs)?;
    let encoded = encoding.elapsed();
    Ok(Report {
        device: device.name,
        backend: device.kind,
        width: plan.width(),
        height: plan.height(),
        fit: scene.render.fit,
        color: scene.render.color,
        rgb: plan.space.rgb,
        observer: plan.observer,
        white_balance: scene.render.white_balance,
        steps: plan.steps(),
        path: plan.path.clone(),
        explain: explain(&plan, scene.camera.projection),
        exposure_ev: plan.frame.exposure.log2(),
        sky_light: request.sky_light.then(|| SkyLight::new(&plan)),
        plan_ms: ms(planned),
        kernel_ms: ms(kernel),
        readback_ms: ms(readback),
        encode_ms: ms(encoded),
        total_ms: ms(start.elapsed()),
        outputs: outputs.to_vec(),
    })
}

/// The wavelengths of the spectral files that a request asks for (nm, increasing), if it does.
fn wavelengths(request: &Request, formats: &[Format]) -> Result<Option<Vec<f64>>> {
    if !formats.contains(&Format::SpectralExr) {
        let refuse = |flag| {
            Err(Error::request(format!(
                "{flag} needs a spectral file: -o NAME.spectral.exr, or -o NAME.exr with --spectral"
            )))
        };
        return match request {
            Request { spectral: true, .. } => refuse("--spectral"),
            Request { wavelengths: Some(_), .. } => refuse("--wavelengths"),
            _ => Ok(None),
        };
    }
    let mut wavelengths = request.wavelengths.clone().unwrap_or_else(default_wavelengths);
    let count = wavelengths.len();
    if !(1..=MOST_WAVELENGTHS).contains(&count) {
        return Err(Error::request(format!(
            "--wavelengths holds {count} wavelengths; a spectral file takes 1 to {MOST_WAVELENGTHS} of them"
        )));
    }
    let (shortest, longest) = MEASURED_RANGE;
    if let Some(outside) = wavelengths.iter().find(|&&nm| !(shortest..=longest).contains(&nm)) {
        return Err(Error::request(format!(
            "--wavelengths holds {outside}; wavelengths must lie between {shortest} and {longest} nm"
        )));
    }
    wavelengths.sort_by(f64::total_cmp);
    match wavelengths.windows(2).find(|pair| pair[1] - pair[0] < CLOSEST_WAVELENGTHS) {
        Some(pair) => Err(Error::request(format!(
            "--wavelengths holds {} and {}; wavelengths must lie at least {CLOSEST_WAVELENGTHS} nm apart",
            pair[0], pair[1]
        ))),
        None => Ok(Some(wavelengths)),
    }
}

/// Wavelengths (nm) closer than this have the same name in a spectral file.
const CLOSEST_WAVELENGTHS: f64 = 1e-5;

/// Checks, before any work, that the image and its encoding fit into memory.
fn check_memory(size: Size, pixel_words: u32) -> Result<()> {
    // A pixel as the device left it, its three bytes of a picture, and about as much for the encoder; beside a spectrum, its
    // linear RGB once more.
    let rgb = if pixel_words > RGB_WORDS { 4 * u64::from(RGB_WORDS) } else { 0 };
    let bytes_per_pixel = 4 * u64::from(pixel_words) + rgb + 8;
    let bytes = u64::from(size.width) * u64::from(size.height) * bytes_per_pixel;
    let room = usize::try_from(bytes).is_ok_and(|bytes| {
        let mut trial = Vec::<u8>::new();
        let room = trial.try_reserve_exact(bytes).is_ok();
        // Or else the compiler may leave out the allocation, and the answer with it.
        std::hint::black_box(&trial);
        room
    });
    if room {
        return Ok(());
    }
    let gib = bytes as f64 / f64::from(1 << 30);
    Err(Error::request(format!("--size {size} (camera.size) takes {gib:.1} GiB of memory, more than there is")))
}

/// Encodes every file before the first takes its place, so that a failure leaves all of them as they were.
fn write(scene: &Scene, plan: &Plan, run: Run, formats: &[Format], outputs: &[PathBuf]) -> Result<()> {
    let (width, height) = (plan.width(), plan.height());
    let (labels, depth) = (Labels::of(scene), scene.render.exr);
    let picture = |path: &PathBuf, rgb: &[u8]| output::png::write(path, width, height, rgb);
    let staged: Vec<Staged> = match plan.pixel {
        PixelFormat::Picture => {
            let rgb = output::png::unpack(&run.words);
            outputs.iter().map(|path| picture(path, &rgb)).collect::<Result<_>>()?
        }
        PixelFormat::HalfRgb => outputs
            .iter()
            .map(|path| output::exr::write_half(path, width as usize, height as usize, &labels, &run.words))
            .collect::<Result<_>>()?,
        PixelFormat::LinearRgb => {
            let values: &[f32] = bytemuck::cast_slice(&run.words);
            if let Some(value) = values.iter().find(|value| !(value.is_finite() && **value >= 0.0)) {
                return Err(Error::failure(format!("the device computed a pixel of {value}; nothing was written")));
            }
            let (width, height) = (width as usize, height as usize);
            let (rgb, words) = if plan.spectral.is_empty() {
                (bytemuck::allocation::cast_vec(run.words), Vec::new())
            } else {
                let pixels = values.chunks(plan.pixel_words() as usize);
                (pixels.flat_map(|pixel| &pixel[..RGB_WORDS as usize]).copied().collect(), run.words)
            };
            let image = LinearImage { width, height, rgb };
            let spectral = SpectralImage { width, height, wavelengths: &plan.spectral, words: &words };
            let display = ColourSpace::new(Rgb::Srgb, scene.render.white_balance, scene.render.observer, &plan.optics);
            let encode = |(path, format): (&PathBuf, &Format)| match format {
                Format::SpectralExr => output::spectral::write(path, &spectral, &labels, depth),
                Format::Exr => output::exr::write(path, &image, &labels, depth),
                Format::Png => picture(path, &output::png::expose(&image, plan.frame.exposure, &plan.space, &display)),
            };
            outputs.iter().zip(formats).map(encode).collect::<Result<_>>()?
        }
    };
    staged.into_iter().try_for_each(Staged::commit)
}
