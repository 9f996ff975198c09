//! What is refused before any work: files that could not be written.

use std::ffi::OsStr;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::format::Format;
use super::place::{folder, names_folder, plain, refused, resolved};
use super::signature::is_own;
use super::{radiance_scene, staged, usd_scene};
use crate::error::{Error, Result};
use crate::scene::{ExrDepth, Scene, Size};

/// Checks, before any work, that a file can be written where `path` says.
///
/// # Errors
///
/// [`Error::NotWritable`] if the folder does not exist or does not take new files, or the path is no file name, or
/// something else than a file is there; [`Error::Write`] if the file system is full or takes no files at all.
pub fn check_writable(path: &Path) -> Result<()> {
    let refuse = |reason: String| Err(Error::NotWritable { path: path.to_owned(), reason });
    let place = match resolved(path) {
        Ok(place) => place,
        Err(error) => return refuse(plain(path, &error)),
    };
    match place.metadata() {
        Ok(there) if there.is_dir() => return refuse("it is a folder".into()),
        Ok(there) if !there.is_file() => return refuse("it is no ordinary file".into()),
        Err(error) if error.kind() != ErrorKind::NotFound => return refuse(plain(path, &error)),
        _ if names_folder(path) => return refuse("a file name does not end as that of a folder".into()),
        _ => {}
    }
    match staged::create(&folder(&place)) {
        Ok(_) => {
            staged::remove_abandoned(&folder(&place));
            Ok(())
        }
        Err(error) => Err(refused(path, &error)),
    }
}

/// Which files that are there already may be replaced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Replace {
    /// All.
    #[default]
    All,
    /// Those that this program wrote; see [`is_own`](super::is_own).
    Own,
    /// None.
    None,
}

impl Replace {
    /// Checks that an image may be written where `path` says.
    ///
    /// # Errors
    ///
    /// [`Error::FileExists`] or [`Error::ForeignFile`] if what is there must stay.
    pub fn check(self, path: &Path) -> Result<()> {
        self.check_by(path, is_own)
    }

    /// The same of a file of another kind; `is_own` says whether this program wrote what is there.
    ///
    /// # Errors
    ///
    /// Those of [`Self::check`].
    pub fn check_by(self, path: &Path, is_own: fn(&Path) -> bool) -> Result<()> {
        let path_of = || path.to_owned();
        match self {
            _ if path.symlink_metadata().is_err() => Ok(()),
            Self::None => Err(Error::FileExists { path: path_of() }),
            Self::Own if !is_own(path) => Err(Error::ForeignFile { path: path_of() }),
            Self::Own | Self::All => Ok(()),
        }
    }
}

/// Makes the folder of a file where it is missing.
///
/// # Errors
///
/// [`Error::FileName`] if it cannot be made.
pub fn make_folder(path: &Path) -> Result<()> {
    let folder = folder(path);
    std::fs::create_dir_all(&folder).map_err(|error| {
        let complaint = format!("the folder {} cannot be made: {}", folder.display(), plain(path, &error));
        Error::FileName { path: path.to_owned(), complaint }
    })
}

/// Checks, before any work, that a file is not certain to fill its disk: that the disk has room for the least that the
/// file's compression can leave. A spectral file holds radiance at so many wavelengths.
///
/// # Errors
///
/// [`Error::NoRoom`] that names the least, and what is free.
pub fn check_room(path: &Path, format: Format, size: Size, depth: ExrDepth, wavelengths: u64) -> Result<()> {
    // Deflate leaves at least a part in 1032, and EXR's other compressions leave more. Counts of equal bytes say 127
    // with two.
    let bytes_per_channel = if depth == ExrDepth::Full { 4 } else { 2 };
    let (bytes_per_pixel, strongest) = match format {
        Format::Png => (3, 1032),
        Format::Exr => (3 * bytes_per_channel, 1032),
        Format::SpectralExr => ((3 + wavelengths) * bytes_per_channel, 1032),
        Format::Hdr => (4, 64),
        Format::RadiancePicture => (wavelengths + 1, 1),
        Format::RadianceScene | Format::UsdScene => (0, 1),
    };
    let least = u64::from(size.width) * u64::from(size.height) * bytes_per_pixel / strongest;
    match fs4::available_space(folder(path)) {
        Ok(free) if free < least => Err(Error::NoRoom { path: path.to_owned(), size: size.to_string(), least, free }),
        // Where the free space is not known the disk has the last word.
        _ => Ok(()),
    }
}

/// Checks that no two paths name one file.
///
/// # Errors
///
/// [`Error::SharedFile`] that names the path given twice.
pub fn check_distinct(paths: &[PathBuf]) -> Result<()> {
    let place = |path: &PathBuf| {
        let place = resolved(path).unwrap_or_else(|_| path.clone());
        (folder(&place).canonicalize().ok(), place.file_name().map(OsStr::to_owned))
    };
    let places: Vec<_> = paths.iter().map(place).collect();
    match (1..places.len()).find(|&i| places[..i].contains(&places[i])) {
        Some(i) => Err(Error::SharedFile { path: paths[i].clone(), how: "given twice" }),
        None => Ok(()),
    }
}

/// Checks that each scene among the outputs has its picture beside it, and that the camera shows what it needs.
///
/// # Errors
///
/// [`Error::FileName`] for a scene without its picture, or for a name that its program cannot read;
/// [`Error::NotAllowed`] for a camera or a sun that such a scene does not take.
pub fn check_scenes(outputs: &[PathBuf], formats: &[Format], scene: &Scene) -> Result<()> {
    outputs.iter().zip(formats).try_for_each(|(path, format)| match format {
        Format::RadianceScene => radiance_scene::check(path, outputs, scene),
        Format::UsdScene => usd_scene::check(path, outputs, scene),
        _ => Ok(()),
    })
}
