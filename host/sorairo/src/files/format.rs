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
    /// Radiance at many wavelengths, as the program Radiance holds it.
    RadiancePicture,
    /// The sky and the sun as a scene of the program Radiance, around a picture beside it.
    RadianceScene,
}

impl Format {
    /// The format that a file name asks for: its extension, and whether `.spectral` stands before `.exr`. With `spectral` every EXR
    /// file is a spectral one.
    ///
    /// # Errors
    ///
    /// [`Error::FileName`] for an extension other than `png`, `exr`, `hsr` and `rad`.
    pub fn of(path: &Path, spectral: bool) -> Result<Self> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().to_lowercase());
        let named_spectral = stem.is_some_and(|stem| stem.ends_with(".spectral"));
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") if spectral || named_spectral => Ok(Self::SpectralExr),
            Some("exr") => Ok(Self::Exr),
            Some("hsr") => Ok(Self::RadiancePicture),
            Some("rad") => Ok(Self::RadianceScene),
            _ => {
                let complaint = "the file name must end in .png, .exr, .hsr or .rad".into();
                Err(Error::FileName { path: path.to_owned(), complaint })
            }
        }
    }

    /// Whether a file of it holds radiance at wavelengths.
    pub fn is_spectral(self) -> bool {
        matches!(self, Self::SpectralExr | Self::RadiancePicture)
    }
}
