//! From a scene to files.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::PixelFormat;
use crate::backend::{Device, Run};
use crate::error::{Error, Result};
use crate::output::{self, Format, LinearImage, Staged};
use crate::plan::Plan;
use crate::plan::explain::explain;
use crate::plan::path::Path;
use crate::scene::{ColorPath, ExrDepth, Fit, Scene, Size};

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
    /// Elevation of the sun (degrees).
    pub sun_elevation: f64,
    /// Azimuth of the sun, clockwise from north (degrees).
    pub sun_azimuth: f64,
    /// The fit through the bands.
    pub fit: Fit,
    /// How the fit became a colour.
    pub color: ColorPath,
    /// Samples on each piece of a ray.
    pub steps: u32,
    /// Whether pixels were integrated or looked up, and why.
    pub path: Path,
    /// What the plan skips, and what that saves.
    pub explain: Vec<String>,
    /// Factor from linear RGB to the picture's linear value, as a power of two.
    pub exposure_ev: f32,
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
    outputs: &[PathBuf],
    open: impl FnOnce() -> Result<Device>,
    stage: impl Fn(&str),
) -> Result<Report> {
    let start = Instant::now();
    let formats: Vec<Format> = outputs.iter().map(|path| Format::of(path)).collect::<Result<_>>()?;
    // A picture alone is packed on the device, 4 bytes a pixel; a linear image serves for both.
    let pixel = match (formats.as_slice(), scene.render.exr) {
        (formats, _) if !formats.contains(&Format::Exr) => PixelFormat::Picture,
        (formats, ExrDepth::Half) if !formats.contains(&Format::Png) => PixelFormat::HalfRgb,
        _ => PixelFormat::LinearRgb,
    };
    let plan = Plan::new(scene, pixel)?;
    for path in outputs {
        output::check_writable(path)?;
    }
    output::check_distinct(outputs)?;
    check_memory(scene.camera.size, pixel)?;
    let planned = start.elapsed();
    stage("opening the device");
    let device = open()?;
    stage("computing the sky");
    let run = device.backend.run(&plan, plan.kernel())?;
    stage("writing files");
    let encoding = Instant::now();
    let (kernel, readback) = (run.kernel, run.readback);
    write(&plan, run, &formats, outputs, scene.render.exr)?;
    Ok(Report {
        device: device.name,
        backend: device.kind,
        width: plan.width(),
        height: plan.height(),
        sun_elevation: scene.sun.elevation,
        sun_azimuth: scene.sun.azimuth,
        fit: scene.render.fit,
        color: scene.render.color,
        steps: plan.steps(),
        path: plan.path.clone(),
        explain: explain(&plan, scene.camera.projection),
        exposure_ev: plan.frame.exposure.log2(),
        plan_ms: ms(planned),
        kernel_ms: ms(kernel),
        readback_ms: ms(readback),
        encode_ms: ms(encoding.elapsed()),
        total_ms: ms(start.elapsed()),
        outputs: outputs.to_vec(),
    })
}

/// Checks, before any work, that the image and its encoding fit into memory.
fn check_memory(size: Size, pixel: PixelFormat) -> Result<()> {
    // A pixel as the device left it, its three bytes of a picture, and about as much for the encoder.
    let bytes_per_pixel = 4 * u64::from(pixel.words()) + 8;
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
fn write(plan: &Plan, run: Run, formats: &[Format], outputs: &[PathBuf], depth: ExrDepth) -> Result<()> {
    let (width, height) = (plan.width(), plan.height());
    let picture = |path: &PathBuf, rgb: &[u8]| output::png::write(path, width, height, rgb);
    let staged: Vec<Staged> = match plan.pixel {
        PixelFormat::Picture => {
            let rgb = output::png::unpack(&run.words);
            outputs.iter().map(|path| picture(path, &rgb)).collect::<Result<_>>()?
        }
        PixelFormat::HalfRgb => outputs
            .iter()
            .map(|path| output::exr::write_half(path, width as usize, height as usize, &run.words))
            .collect::<Result<_>>()?,
        PixelFormat::LinearRgb => {
            let rgb = bytemuck::allocation::cast_vec(run.words);
            let image = LinearImage { width: width as usize, height: height as usize, rgb };
            if let Some(value) = image.rgb.iter().find(|value| !(value.is_finite() && **value >= 0.0)) {
                return Err(Error::failure(format!("the device computed a pixel of {value}; nothing was written")));
            }
            let encode = |(path, format): (&PathBuf, &Format)| match format {
                Format::Exr => output::exr::write(path, &image, depth),
                Format::Png => picture(path, &output::png::expose(&image, plan.frame.exposure)),
            };
            outputs.iter().zip(formats).map(encode).collect::<Result<_>>()?
        }
    };
    staged.into_iter().try_for_each(Staged::commit)
}
