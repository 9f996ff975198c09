//! Files: written beside their place and renamed into it when all are whole, so that no reader ever sees half of one.

pub mod exr;
pub mod png;
mod signature;
pub mod spectral;
mod staged;
pub mod text;
mod writer;

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::scene::{ExrDepth, Size};
pub use signature::is_finished;
pub use staged::{Staged, abandon, stage};
pub use writer::{Image, Writer, write};

/// The format of an output file, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8 bit sRGB picture, exposed.
    Png,
    /// Linear RGB, unexposed.
    Exr,
    /// Radiance at many wavelengths, and the linear RGB.
    SpectralExr,
}

impl Format {
    /// The format that a file name asks for: its extension, and whether `.spectral` stands before it. With `spectral` every EXR
    /// file is a spectral one.
    ///
    /// # Errors
    ///
    /// [`Error::Request`] for an extension other than `png` and `exr`.
    pub fn of(path: &Path, spectral: bool) -> Result<Self> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().to_lowercase());
        let named_spectral = stem.is_some_and(|stem| stem.ends_with(".spectral"));
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") if spectral || named_spectral => Ok(Self::SpectralExr),
            Some("exr") => Ok(Self::Exr),
            _ => Err(Error::request(format!("-o {}: the file name must end in .png or .exr", path.display()))),
        }
    }
}

/// Checks, before any work, that a file can be written where `path` says.
///
/// # Errors
///
/// [`Error::Request`] if the folder does not exist or does not take new files, or the path is a folder.
pub fn check_writable(path: &Path) -> Result<()> {
    let refuse = |reason: String| Err(Error::request(format!("-o {} cannot be written: {reason}", path.display())));
    if path.is_dir() {
        return refuse("it is a folder".into());
    }
    match staged::create(&folder(path)) {
        Ok(_) => {
            staged::remove_abandoned(&folder(path));
            Ok(())
        }
        Err(error) => refuse(plain(&error)),
    }
}

/// Makes the folder of a file where it is missing.
///
/// # Errors
///
/// [`Error::Request`] if it cannot be made.
pub fn make_folder(path: &Path) -> Result<()> {
    let folder = folder(path);
    std::fs::create_dir_all(&folder).map_err(|error| {
        let (path, folder, reason) = (path.display(), folder.display(), plain(&error));
        Error::request(format!("-o {path}: the folder {folder} cannot be made: {reason}"))
    })
}

/// Checks, before any work, that a file is not certain to fill its disk: that the disk has room for the least that the file's
/// compression can leave. A spectral file holds radiance at so many wavelengths.
///
/// # Errors
///
/// [`Error::Request`] that names the least, and what is free.
pub fn check_room(path: &Path, format: Format, size: Size, depth: ExrDepth, wavelengths: u64) -> Result<()> {
    // Deflate leaves at least a part in 1032; a run of at most 128 equal bytes in EXR leaves two.
    let bytes_per_channel = if depth == ExrDepth::Full { 4 } else { 2 };
    let (bytes_per_pixel, strongest) = match format {
        Format::Png => (3, 1032),
        Format::Exr => (3 * bytes_per_channel, 64),
        Format::SpectralExr => ((3 + wavelengths) * bytes_per_channel, 64),
    };
    let least = u64::from(size.width) * u64::from(size.height) * bytes_per_pixel / strongest;
    match fs4::available_space(folder(path)) {
        Ok(free) if free < least => {
            let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
            Err(Error::request(format!(
                "-o {}: an image of {size} pixels (--size, camera.size) takes at least {:.1} GiB, and {:.1} GiB are free there",
                path.display(),
                gib(least),
                gib(free)
            )))
        }
        // Where the free space is not known the disk has the last word.
        _ => Ok(()),
    }
}

/// Checks that no two paths name one file.
///
/// # Errors
///
/// [`Error::Request`] that names the path given twice.
pub fn check_distinct(paths: &[PathBuf]) -> Result<()> {
    let places: Vec<_> = paths.iter().map(|path| (folder(path).canonicalize().ok(), path.file_name())).collect();
    match (1..places.len()).find(|&i| places[..i].contains(&places[i])) {
        Some(i) => {
            let path = paths[i].display();
            Err(Error::request(format!("-o {path} is given twice; every output needs a name of its own")))
        }
        None => Ok(()),
    }
}

fn unwritable(path: &Path, error: &std::io::Error) -> Error {
    Error::failure(format!("-o {} cannot be written: {}", path.display(), plain(error)))
}

fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// The operating system's own words, without the temporary file's name.
fn plain(error: &std::io::Error) -> String {
    match (error.raw_os_error(), error.kind()) {
        (Some(code), _) => std::io::Error::from_raw_os_error(code).to_string(),
        (None, std::io::ErrorKind::NotFound) => "the folder does not exist".into(),
        (None, std::io::ErrorKind::PermissionDenied) => "permission denied".into(),
        _ => error.to_string(),
    }
}
