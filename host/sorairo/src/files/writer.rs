//! Files that are written while their pixels are computed.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{Builder, Scope, ScopedJoinHandle};

use sorairo_shared::variant::PixelFormat;

use super::format::Format;
use super::label::{SCENE, scene_text};
use super::staged::{Staged, stage};
use super::{exr, png, radiance_picture, radiance_scene};
use crate::error::{Error, Result};
use crate::plan::Plan;
use crate::plan::colour_space::ColourSpace;
use crate::scene::{Scene, ValidScene};

/// Strips that may wait for an encoder before the device does.
const WAITING: usize = 2;

/// The image that a file holds.
#[derive(Clone, Debug)]
pub struct Image {
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
    /// How a pixel arrives.
    pub pixel: PixelFormat,
    /// Factor from linear RGB to a picture's linear value, where the pixels arrive linear.
    pub exposure: f32,
    /// What it shows.
    pub scene: Scene,
    /// The space of linear pixels.
    pub space: ColourSpace,
    /// The space in which a picture shows them.
    pub display: ColourSpace,
    /// Wavelengths (nm) whose radiance follows the linear RGB of each pixel; none but for spectral files.
    pub wavelengths: Vec<f64>,
    /// Irradiance of the sun on a surface that faces it, at each wavelength (W·m⁻²·nm⁻¹); none but for scenes of Radiance.
    pub sun: Vec<f64>,
}

impl Image {
    /// That of a plan of a scene.
    pub fn of(plan: &Plan, scene: &ValidScene) -> Self {
        Self {
            width: plan.width(),
            height: plan.height(),
            pixel: plan.pixel,
            exposure: plan.uniform.exposure,
            scene: scene.as_asked(),
            space: plan.sky.space,
            display: plan.sky.display(),
            wavelengths: plan.spectral.clone(),
            sun: Vec::new(),
        }
    }

    pub(super) fn pixel_words(&self) -> usize {
        self.pixel.words() as usize + self.wavelengths.len()
    }
}

/// A file that is encoded on a thread of its own while its rows arrive.
pub struct Writer<'scope> {
    path: PathBuf,
    rows: SyncSender<Arc<[u32]>>,
    thread: ScopedJoinHandle<'scope, Result<Staged>>,
}

impl<'scope> Writer<'scope> {
    /// Begins a file.
    ///
    /// # Errors
    ///
    /// [`Error::Thread`] if there can be no thread for it.
    pub fn start(scope: &'scope Scope<'scope, '_>, path: PathBuf, format: Format, image: Image) -> Result<Self> {
        let (rows, received) = sync_channel(WAITING);
        let encoded = path.clone();
        let encoding = move || encode(&encoded, format, image, received);
        let thread = Builder::new().spawn_scoped(scope, encoding).map_err(Error::Thread)?;
        Ok(Self { path, rows, thread })
    }

    /// Takes the next rows. An encoder that has failed says so in [`Writer::finish`].
    ///
    /// # Errors
    ///
    /// [`Error::Write`] if the encoder has failed.
    pub fn take(&self, rows: Arc<[u32]>) -> Result<()> {
        self.rows
            .send(rows)
            .map_err(|_| Error::Write { path: self.path.clone(), reason: "its encoder has ended".into() })
    }

    /// The whole file, beside its place.
    ///
    /// # Errors
    ///
    /// [`Error::Write`] if it could not be written.
    pub fn finish(self) -> Result<Staged> {
        drop(self.rows);
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

/// Writes a whole image beside the place that `path` names.
///
/// # Errors
///
/// [`Error::Write`] if it cannot be written.
pub fn write(path: &Path, format: Format, image: Image, words: &[u32]) -> Result<Staged> {
    encode(path, format, image, std::iter::once(words))
}

fn encode(
    path: &Path,
    format: Format,
    image: Image,
    strips: impl IntoIterator<Item: AsRef<[u32]> + Sync>,
) -> Result<Staged> {
    let Image { width, height, pixel, scene, wavelengths, sun, .. } = &image;
    let (width, height, pixel_words) = (*width, *height, image.pixel_words());
    let mut strips = strips.into_iter();
    let of_file = if format == Format::Exr { &[] } else { wavelengths.as_slice() };
    stage(path, |output| match format {
        Format::Png => png::encode(output, width, height, Some((SCENE, scene_text(scene))), |picture| {
            let mut row = 0;
            strips.try_for_each(|rows| match pixel {
                PixelFormat::Picture => picture.write_all(&png::unpack(rows.as_ref())),
                PixelFormat::LinearRgb => {
                    let pixels = bytemuck::cast_slice(rows.as_ref());
                    let bytes = png::expose(&image, pixels, row);
                    row += pixels.len() / (width as usize * pixel_words);
                    picture.write_all(&bytes)
                }
                PixelFormat::HalfRgb | PixelFormat::LinearRgba => Err(io::Error::other("texels are no picture")),
            })
        }),
        Format::Exr | Format::SpectralExr => exr::encode(output, exr::header(width, height, scene, of_file), |lines| {
            let line_words = width as usize * pixel_words;
            strips.try_for_each(|rows| {
                let rows = rows.as_ref();
                lines.write(rows.len() / line_words, |line| {
                    let words = &rows[line * line_words..][..line_words];
                    match pixel {
                        PixelFormat::HalfRgb => exr::line_of_halves(words),
                        _ => {
                            let pixels = bytemuck::cast_slice(words);
                            exr::line_of_floats(pixels, pixel_words, of_file.len(), scene.render.exr)
                        }
                    }
                })
            })
        }),
        Format::RadiancePicture => {
            let header = |checksum| radiance_picture::header(width, height, scene, wavelengths, checksum);
            radiance_picture::encode(output, header, |write| {
                let pixels = |rows: &[u32]| radiance_picture::bytes(bytemuck::cast_slice(rows), pixel_words, width);
                strips.try_for_each(|rows| write(&pixels(rows.as_ref())))
            })
        }
        Format::RadianceScene => {
            strips.for_each(drop);
            radiance_scene::encode(output, path, scene, wavelengths, sun)
        }
    })
}
