//! Files that are written while their pixels are computed.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{Scope, ScopedJoinHandle};

use sorairo_shared::frame::Pixel;

use super::{Format, Staged, exr, png, stage};
use crate::error::{Error, Result};
use crate::scene::Scene;

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
    pub pixel: Pixel,
    /// Factor from linear RGB to a picture's linear value, where the pixels arrive linear.
    pub exposure: f32,
    /// What it shows.
    pub scene: Scene,
}

/// A file that is encoded on a thread of its own while its rows arrive.
pub struct Writer<'scope> {
    rows: SyncSender<Arc<[u32]>>,
    thread: ScopedJoinHandle<'scope, Result<Staged>>,
}

impl<'scope> Writer<'scope> {
    /// Begins a file.
    pub fn start(scope: &'scope Scope<'scope, '_>, path: PathBuf, format: Format, image: Image) -> Self {
        let (rows, received) = sync_channel(WAITING);
        let thread = scope.spawn(move || encode(&path, format, image, received));
        Self { rows, thread }
    }

    /// Takes the next rows. An encoder that has failed says so in [`Writer::finish`].
    ///
    /// # Errors
    ///
    /// [`Error::Failure`] if the encoder has failed.
    pub fn take(&self, rows: Arc<[u32]>) -> Result<()> {
        self.rows.send(rows).map_err(|_| Error::failure("a file cannot be written"))
    }

    /// The whole file, beside its place.
    ///
    /// # Errors
    ///
    /// [`Error::Failure`] if it could not be written.
    pub fn finish(self) -> Result<Staged> {
        drop(self.rows);
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

/// Writes a whole image beside the place that `path` names.
///
/// # Errors
///
/// [`Error::Failure`] if it cannot be written.
pub fn write(path: &Path, format: Format, image: Image, words: &[u32]) -> Result<Staged> {
    encode(path, format, image, std::iter::once(words))
}

fn encode(
    path: &Path,
    format: Format,
    image: Image,
    strips: impl IntoIterator<Item: AsRef<[u32]> + Sync>,
) -> Result<Staged> {
    let Image { width, height, pixel, exposure, scene } = image;
    let mut strips = strips.into_iter();
    stage(path, |output| match format {
        Format::Png => png::encode(output, width, height, Some(&scene), |picture| {
            strips.try_for_each(|rows| match pixel {
                Pixel::Picture => picture.write_all(&png::unpack(rows.as_ref())),
                Pixel::LinearRgb => picture.write_all(&png::expose(bytemuck::cast_slice(rows.as_ref()), exposure)),
                Pixel::HalfRgb => Err(io::Error::other("half floats are no picture")),
            })
        }),
        Format::Exr => exr::encode(output, exr::header(width, height, &scene), |lines| {
            let line_words = (width * pixel.words()) as usize;
            strips.try_for_each(|rows| {
                let rows = rows.as_ref();
                lines.write(rows.len() / line_words, |line| {
                    let words = &rows[line * line_words..][..line_words];
                    match pixel {
                        Pixel::HalfRgb => exr::line_of_halves(words),
                        _ => exr::line_of_floats(bytemuck::cast_slice(words), scene.render.exr),
                    }
                })
            })
        }),
    })
}
