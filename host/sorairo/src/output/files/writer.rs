//! Files that are written while their pixels are computed.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{Builder, Scope, ScopedJoinHandle};

use super::format::Format;
use super::staged::{Staged, stage};
use super::{hdr, radiance_picture, radiance_scene, usd_scene};
use crate::error::{Error, Result};
use crate::output::encoding::spectral::Spectra;
use crate::output::encoding::{Image, linear, picture};

/// Strips that may wait for an encoder before the device does.
const WAITING: usize = 2;

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
    let mut strips = strips.into_iter();
    stage(path, |output| match format {
        Format::Png => picture(output, &image, strips),
        Format::Exr => linear(output, &image, &Spectra::default(), strips),
        Format::SpectralExr => linear(output, &image, &image.spectra, strips),
        Format::Hdr => radiance_picture::encode(
            output,
            |checksum| hdr::header(&image.scene, checksum),
            |write| strips.try_for_each(|rows| write(&hdr::bytes(&image, rows.as_ref())?)),
        ),
        Format::RadiancePicture => {
            let Image { width, height, scene, spectra, .. } = &image;
            let header = |checksum| radiance_picture::header(*width, *height, scene, &spectra.wavelengths, checksum);
            radiance_picture::encode(output, header, |write| {
                let pixels =
                    |rows: &[u32]| radiance_picture::bytes(bytemuck::cast_slice(rows), image.pixel_words(), *width);
                strips.try_for_each(|rows| write(&pixels(rows.as_ref())))
            })
        }
        Format::RadianceScene => {
            strips.for_each(drop);
            radiance_scene::encode(output, path, &image.scene, &image.spectra.wavelengths, &image.sun.spectrum)
        }
        Format::UsdScene => {
            strips.for_each(drop);
            usd_scene::encode(output, path, &image)
        }
    })
}
