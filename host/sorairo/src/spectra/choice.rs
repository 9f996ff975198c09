//! The choice of a spectrum: a built-in one, or a user table.

use std::path::Path;

use serde::{Deserialize, Serialize};
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

use super::mean::{self, Window};
use super::measured;
use super::named_file::is_table_file;
use super::range::{MEASURED_RANGE, RANGE_OF_BEAMS, STEP};
use super::table::Table;
use super::table_file::TableFile;
use crate::medium::gases::ozone_cross_section;
use crate::words::{Words, word, words};

/// The sun's spectrum at the top of the atmosphere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr)]
#[serde(try_from = "String", into = "String")]
#[strum(serialize_all = "kebab-case")]
pub enum SunSpectrum {
    /// Measured: ASTM G173-03 extraterrestrial (W·m⁻²·nm⁻¹).
    AstmG173,
    /// Measured from orbit to 0.3 %: TSIS-1 HSRS (Coddington et al. 2021, W·m⁻²·nm⁻¹).
    #[strum(serialize = "tsis-1")]
    Tsis1,
    /// 1 at every wavelength, so that radiance is in sr⁻¹.
    Flat,
    /// A user table (W·m⁻²·nm⁻¹).
    #[strum(disabled)]
    File(TableFile),
}

impl SunSpectrum {
    /// Irradiance at a wavelength (nm), at a distance of 1 au.
    pub fn at(&self, wavelength: f64) -> f64 {
        match self {
            Self::Flat => 1.0,
            measured => measured.table().expect("the others are tables").at(wavelength)[0],
        }
    }

    /// What it is by; none if it is the same at every wavelength.
    pub(super) fn table(&self) -> Option<&Table<1>> {
        match self {
            Self::AstmG173 => Some(measured::solar_irradiance()),
            Self::Tsis1 => Some(measured::solar_irradiance_from_orbit()),
            Self::Flat => None,
            Self::File(file) => Some(file.table()),
        }
    }

    /// The same in means over what a value stands for; see [`super::mean`].
    pub(super) fn over(&self, window: Window) -> Self {
        match (self, window) {
            (Self::AstmG173, Window::Node(STEP)) => Self::File(measured::solar_irradiance_over_steps().clone()),
            (Self::Flat, _) => Self::Flat,
            (Self::File(file), _) => Self::File(file.over(window, None)),
            (measured, _) => {
                let table = measured.table().expect("the others are tables");
                Self::File(TableFile::holding(word(measured.clone()), mean::over(window, table, None)))
            }
        }
    }
}

/// How the scattering of air depends on the wavelength, and how it depolarises.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum AirSpectrum {
    /// λ⁻⁴, without depolarisation (the paper's Eq. 3).
    FourthPower,
    /// Measured: with the dispersion and depolarisation of air (Bodhaine et al. 1999).
    Bodhaine,
}

impl AirSpectrum {
    /// Scattering at a wavelength (µm) relative to that at 1 µm.
    ///
    /// Bodhaine, Wood, Dutton and Slusser 1999, Eq. 29, by which their table is met within 0.01 % from 250 to 850 nm
    /// (DOI 10.1175/1520-0426(1999)016<1854:ORODC>2.0.CO;2).
    pub fn relative(self, micrometres: f64) -> f64 {
        let cross_section = |square: f64| {
            (1.045_599_6 - 341.290_61 / square - 0.902_308_50 * square)
                / (1.0 + 0.002_705_988_9 / square - 85.968_563 * square)
        };
        match self {
            Self::FourthPower => 1.0 / micrometres.powi(4),
            Self::Bodhaine => cross_section(micrometres * micrometres) / cross_section(1.0),
        }
    }

    /// Anisotropy of the phase function; see [`sorairo_shared::medium::phase::air_phase`].
    ///
    /// From the King factor `F` of air at 550 nm (Bodhaine et al. 1999, Eqs. 5, 6 and 23): the depolarisation is
    /// `ρ = 6 (F - 1)/(3 + 7 F)`. From 400 to 700 nm it changes the phase function by 0.1 % at most.
    pub fn anisotropy(self) -> f64 {
        const SQUARE: f64 = 0.55 * 0.55;
        let depolarisation = match self {
            Self::FourthPower => 0.0,
            Self::Bodhaine => {
                let nitrogen = 1.034 + 3.17e-4 / SQUARE;
                let oxygen = 1.096 + 1.385e-3 / SQUARE + 1.448e-4 / (SQUARE * SQUARE);
                let (argon, carbon_dioxide) = (1.0, 1.15);
                let parts = [(78.084, nitrogen), (20.946, oxygen), (0.934, argon), (0.036, carbon_dioxide)];
                let king = parts.map(|(part, factor)| part * factor).iter().sum::<f64>()
                    / parts.map(|(part, _)| part).iter().sum::<f64>();
                6.0 * (king - 1.0) / (3.0 + 7.0 * king)
            }
        };
        (1.0 - depolarisation) / (1.0 + 0.5 * depolarisation)
    }
}

/// The albedo of the ground: that of a surface, alike at every wavelength or by wavelength.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr)]
#[serde(try_from = "AlbedoText", into = "AlbedoText")]
#[strum(serialize_all = "kebab-case")]
pub enum GroundAlbedo {
    /// The same at every wavelength.
    #[strum(disabled)]
    Grey(f64),
    /// Green grass.
    Grass,
    /// Bare soil.
    Soil,
    /// Desert sand.
    Sand,
    /// Fresh snow.
    Snow,
    /// The open sea.
    Sea,
    /// Concrete.
    Concrete,
    /// A user table (0 to 1).
    #[strum(disabled)]
    File(TableFile),
}

/// An albedo as it stands in a scene file.
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "an albedo is a number, the name of a surface or that of a .csv file")]
enum AlbedoText {
    Number(f64),
    Text(String),
}

impl TryFrom<AlbedoText> for GroundAlbedo {
    type Error = String;

    fn try_from(text: AlbedoText) -> std::result::Result<Self, String> {
        match text {
            AlbedoText::Number(albedo) => Ok(Self::Grey(albedo)),
            AlbedoText::Text(text) => named_or_file(&text, Self::File),
        }
    }
}

impl From<GroundAlbedo> for AlbedoText {
    fn from(albedo: GroundAlbedo) -> Self {
        match albedo {
            GroundAlbedo::Grey(albedo) => Self::Number(albedo),
            GroundAlbedo::File(file) => Self::Text(file.path().to_string_lossy().into_owned()),
            named => Self::Text(word(named).into()),
        }
    }
}

impl GroundAlbedo {
    /// The albedo at a wavelength (nm).
    pub fn at(&self, wavelength: f64) -> f64 {
        match self {
            Self::Grey(albedo) => *albedo,
            Self::Grass => measured::grass_albedo().at(wavelength)[0],
            Self::Soil => measured::soil_albedo().at(wavelength)[0],
            Self::Sand => measured::sand_albedo().at(wavelength)[0],
            Self::Snow => measured::snow_albedo().at(wavelength)[0],
            Self::Sea => measured::sea_albedo().at(wavelength)[0],
            Self::Concrete => measured::concrete_albedo().at(wavelength)[0],
            Self::File(file) => file.table().at(wavelength)[0],
        }
    }

    /// The wavelengths (nm) at which it is known: of a surface that was measured to its end, up to 2500 nm as at that.
    pub(crate) fn range(&self) -> (f64, f64) {
        match self {
            Self::Snow | Self::Sea => (RANGE_OF_BEAMS.0, MEASURED_RANGE.1),
            Self::File(file) => file.table().range(),
            Self::Grey(_) | Self::Grass | Self::Soil | Self::Sand | Self::Concrete => RANGE_OF_BEAMS,
        }
    }

    /// Whether no light comes back.
    pub fn is_black(&self) -> bool {
        *self == Self::Grey(0.0)
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
    /// A user table (0 to 1).
    #[strum(disabled)]
    File(TableFile),
}

impl AlbedoSpectrum {
    /// The wavelengths (nm) at which it is known.
    pub(crate) fn range(&self) -> (f64, f64) {
        match self {
            Self::Grey => RANGE_OF_BEAMS,
            Self::MarsDust => MEASURED_RANGE,
            Self::File(file) => file.table().range(),
        }
    }

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
    /// Measured at 233 K (Serdyuchenko et al. 2014); outside 360 to 830 nm that of `bogumil` at this temperature.
    #[strum(serialize = "233k")]
    At233K,
    /// Measured from 203 to 293 K (Bogumil et al. 2003), at the temperature of the ozone in the profile.
    Bogumil,
    /// A user table (m²).
    #[strum(disabled)]
    File(TableFile),
}

impl OzoneCrossSection {
    /// The cross-section (m²) at a wavelength (nm) of ozone of a temperature (K).
    pub fn at(&self, wavelength: f64, temperature: f64) -> f64 {
        let (shortest, longest) = MEASURED_RANGE;
        match self {
            Self::At233K if (shortest..=longest).contains(&wavelength) => {
                measured::ozone_cross_section().at(wavelength)[0]
            }
            Self::At233K => ozone_cross_section(wavelength, 233.0),
            Self::Bogumil => ozone_cross_section(wavelength, temperature),
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

/// A value that may be a user table.
pub trait OrTable {
    /// The user table, if any.
    fn file(&self) -> Option<&TableFile>;

    /// The same, to be changed.
    fn file_mut(&mut self) -> Option<&mut TableFile>;
}

/// Implements the access to a user table.
macro_rules! or_table {
    ($($name:ident),+) => {$(
        impl OrTable for $name {
            fn file(&self) -> Option<&TableFile> {
                if let Self::File(file) = self { Some(file) } else { None }
            }

            fn file_mut(&mut self) -> Option<&mut TableFile> {
                if let Self::File(file) = self { Some(file) } else { None }
            }
        }
    )+};
}

or_table!(SunSpectrum, GroundAlbedo, AlbedoSpectrum, OzoneCrossSection);

/// Gives spectra their text form in scene files.
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
    };
}

/// Gives what the sun lights its means.
macro_rules! lit_by_the_sun {
    ($name:ident) => {
        impl $name {
            /// The same in means over what a value stands for, as a sun lights it; see [`super::mean`].
            pub(super) fn over(&self, window: Window, sun: &SunSpectrum) -> Self {
                match self {
                    Self::File(file) => Self::File(file.over(window, sun.table())),
                    // What is built in is smooth.
                    other => other.clone(),
                }
            }
        }
    };
}

lit_by_the_sun!(GroundAlbedo);
lit_by_the_sun!(AlbedoSpectrum);
lit_by_the_sun!(OzoneCrossSection);

spectrum_in_files!(SunSpectrum);
spectrum_in_files!(AlbedoSpectrum);
spectrum_in_files!(OzoneCrossSection);
