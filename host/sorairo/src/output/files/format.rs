//! Formats of output files.

use std::path::Path;

use crate::error::{Error, Result};

/// The format of an output file, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// 8 bit sRGB picture, exposed.
    Png,
    /// Linear RGB, unexposed.
    Exr,
    /// Linear RGB of 8 bits and a shared exponent, unexposed.
    Hdr,
    /// Radiance at many wavelengths, and the linear RGB.
    SpectralExr,
    /// Radiance at many wavelengths, as the program Radiance holds it.
    RadiancePicture,
    /// The sky and the sun as a scene of the program Radiance, around a picture beside it.
    RadianceScene,
    /// The sky and the sun as lights of Universal Scene Description, around a map beside it.
    UsdScene,
}

/// Extensions, and what they ask for.
const EXTENSIONS: [(&str, Format); 6] = [
    ("png", Format::Png),
    ("exr", Format::Exr),
    ("hdr", Format::Hdr),
    ("hsr", Format::RadiancePicture),
    ("rad", Format::RadianceScene),
    ("usda", Format::UsdScene),
];

impl Format {
    /// The format that a file name asks for: its extension, and whether `.spectral` stands before `.exr`. With
    /// `spectral` every EXR file is a spectral one.
    ///
    /// # Errors
    ///
    /// [`Error::FileName`] for an extension of no format.
    pub fn of(path: &Path, spectral: bool) -> Result<Self> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().to_lowercase());
        let named_spectral = stem.is_some_and(|stem| stem.ends_with(".spectral"));
        match EXTENSIONS.iter().find(|(name, _)| extension.as_deref() == Some(*name)) {
            Some((_, Self::Exr)) if spectral || named_spectral => Ok(Self::SpectralExr),
            Some((_, format)) => Ok(*format),
            None => {
                let complaint = format!("the file name must end in {}", Self::extensions());
                Err(Error::FileName { path: path.to_owned(), complaint })
            }
        }
    }

    /// What a file name may end in, in words.
    pub fn extensions() -> String {
        let [others @ .., last] = EXTENSIONS.map(|(name, _)| format!(".{name}"));
        format!("{} or {last}", others.join(", "))
    }

    /// Whether a file of it holds radiance at wavelengths.
    pub fn is_spectral(self) -> bool {
        matches!(self, Self::SpectralExr | Self::RadiancePicture)
    }

    /// Whether it is a scene of another program, around a picture beside it.
    pub fn is_scene(self) -> bool {
        matches!(self, Self::RadianceScene | Self::UsdScene)
    }

    /// Whether a file of it holds RGB and nothing else: it shows what one camera sees.
    pub fn is_rgb(self) -> bool {
        matches!(self, Self::Png | Self::Exr | Self::Hdr)
    }
}
