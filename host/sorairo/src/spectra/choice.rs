//! Which spectrum: one that travels with the program, or a table of a person's own.

use std::path::Path;

use serde::{Deserialize, Serialize};
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

use super::measured;
use super::table_file::TableFile;
use crate::words::{Words, word, words};

/// The sun's spectrum at the top of the atmosphere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr)]
#[serde(try_from = "String", into = "String")]
#[strum(serialize_all = "kebab-case")]
pub enum SunSpectrum {
    /// Measured: ASTM G173-03 extraterrestrial (W·m⁻²·nm⁻¹).
    AstmG173,
    /// 1 at every wavelength, so that radiance is in sr⁻¹.
    Flat,
    /// A person's table (W·m⁻²·nm⁻¹).
    #[strum(disabled)]
    File(TableFile),
}

impl SunSpectrum {
    /// Irradiance at a wavelength (nm), at a distance of 1 au.
    pub fn at(&self, wavelength: f64) -> f64 {
        match self {
            Self::AstmG173 => measured::solar_irradiance().at(wavelength)[0],
            Self::Flat => 1.0,
            Self::File(file) => file.table().at(wavelength)[0],
        }
    }
}

/// The single-scattering albedo of aerosol as a spectrum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr)]
#[serde(try_from = "String", into = "String")]
#[strum(serialize_all = "kebab-case")]
pub enum AlbedoSpectrum {
    /// The same at every wavelength: `single_scattering_albedo`.
    Grey,
    /// Martian dust, which absorbs blue light (Wolff et al. 2009).
    MarsDust,
    /// A person's table (0 to 1).
    #[strum(disabled)]
    File(TableFile),
}

impl AlbedoSpectrum {
    /// The albedo at a wavelength (nm); `grey` where it is the same at every wavelength.
    pub fn at(&self, wavelength: f64, grey: f64) -> f64 {
        match self {
            Self::Grey => grey,
            Self::MarsDust => measured::mars_dust_albedo().at(wavelength)[0],
            Self::File(file) => file.table().at(wavelength)[0],
        }
    }
}

/// The absorption cross-section of ozone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr)]
#[serde(try_from = "String", into = "String")]
#[strum(serialize_all = "kebab-case")]
pub enum OzoneCrossSection {
    /// Measured at 233 K (Serdyuchenko et al. 2014).
    #[strum(serialize = "233k")]
    At233K,
    /// A person's table (m²).
    #[strum(disabled)]
    File(TableFile),
}

impl OzoneCrossSection {
    /// The cross-section at a wavelength in nm (m²).
    pub fn at(&self, wavelength: f64) -> f64 {
        match self {
            Self::At233K => measured::ozone_cross_section().at(wavelength)[0],
            Self::File(file) => file.table().at(wavelength)[0],
        }
    }
}

/// A spectrum by the name of one that travels with the program, or of a CSV file.
fn named_or_file<T: Words>(text: &str, file: fn(TableFile) -> T) -> std::result::Result<T, String> {
    if is_table_file(text) {
        return TableFile::read(Path::new(text)).map(file);
    }
    text.parse().map_err(|_| {
        let names: Vec<_> = words::<T>().into_iter().map(|word| word.name).collect();
        format!("{text:?} is neither {} nor the name of a .csv file", names.join(" nor "))
    })
}

/// Whether a value is the name of a CSV file.
pub(crate) fn is_table_file(text: &str) -> bool {
    Path::new(text).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

/// Gives spectra their text form in scene files, and says which table a person gave.
macro_rules! spectrum_in_files {
    ($name:ident) => {
        impl TryFrom<String> for $name {
            type Error = String;

            fn try_from(text: String) -> std::result::Result<Self, String> {
                named_or_file(&text, Self::File)
            }
        }

        impl From<$name> for String {
            fn from(spectrum: $name) -> Self {
                match spectrum {
                    $name::File(file) => file.path().to_string_lossy().into_owned(),
                    named => word(named).into(),
                }
            }
        }

        impl $name {
            /// The person's table, where there is one.
            pub fn file(&self) -> Option<&TableFile> {
                match self {
                    Self::File(file) => Some(file),
                    _ => None,
                }
            }
        }
    };
}

spectrum_in_files!(SunSpectrum);
spectrum_in_files!(AlbedoSpectrum);
spectrum_in_files!(OzoneCrossSection);
