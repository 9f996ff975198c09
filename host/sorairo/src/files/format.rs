//! Formats of output files.

use std::path::Path;

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
    /// [`Error::FileName`] for an extension other than `png` and `exr`.
    pub fn of(path: &Path, spectral: bool) -> Result<Self> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().to_lowercase());
        let named_spectral = stem.is_some_and(|stem| stem.ends_with(".spectral"));
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") if spectral || named_spectral => Ok(Self::SpectralExr),
            Some("exr") => Ok(Self::Exr),
            _ => {
                let complaint = "the file name must end in .png or .exr".into();
                Err(Error::FileName { path: path.to_owned(), complaint })
            }
        }
    }
}
