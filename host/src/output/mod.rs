//! Files: written beside their place and renamed into it when all are whole, so that no reader ever sees half of one.

pub mod exr;
pub mod png;
pub mod spectral;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::{Error, Result};

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

/// Linear RGB of an image, row by row from the top (radiance weighted by the observer, W·m⁻²·sr⁻¹).
pub struct LinearImage {
    /// Width (pixels).
    pub width: usize,
    /// Height (pixels).
    pub height: usize,
    /// Three values a pixel.
    pub rgb: Vec<f32>,
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
    match tempfile::Builder::new().prefix(".sorairo-").tempfile_in(folder(path)) {
        Ok(_) => Ok(()),
        Err(error) => refuse(plain(&error)),
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

/// A whole file beside its place. It disappears if it is dropped before [`Staged::commit`].
#[must_use = "a file that is not committed is removed"]
pub struct Staged {
    file: NamedTempFile,
    path: PathBuf,
}

impl Staged {
    /// Moves the file to its place, where an existing one stays until this moment.
    ///
    /// # Errors
    ///
    /// [`Error::Failure`] if it cannot be moved; nothing is left behind.
    pub fn commit(self) -> Result<()> {
        let Self { file, path } = self;
        file.persist(&path).map_err(|error| unwritable(&path, &error.error))?;
        Ok(())
    }
}

/// Writes a file by `write`, beside the place that `path` names.
///
/// # Errors
///
/// [`Error::Failure`] if anything fails; nothing is left behind.
pub fn stage(path: &Path, write: impl FnOnce(&mut BufWriter<&File>) -> std::io::Result<()>) -> Result<Staged> {
    let attempt = || -> std::io::Result<NamedTempFile> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(".sorairo-");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // A temporary file is private by default; this one becomes an ordinary file, subject to the umask.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let file = builder.tempfile_in(folder(path))?;
        let mut writer = BufWriter::new(file.as_file());
        write(&mut writer)?;
        writer.flush()?;
        drop(writer);
        Ok(file)
    };
    match attempt() {
        Ok(file) => Ok(Staged { file, path: path.to_owned() }),
        Err(error) => Err(unwritable(path, &error)),
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
