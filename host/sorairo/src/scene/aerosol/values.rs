//! Values of a mode that are a number, a word or a file.

use serde::{Deserialize, Serialize};

use super::files::AlbedoRows;
use crate::medium::aerosol::{AerosolKind, Layer, Phase};
use crate::spectra::columns_file::FileOf;
use crate::spectra::named_file::is_table_file;

/// What a value of a mode is written as.
#[derive(Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "this is a number, a word, the name of a .csv file, or for a profile [bottom, top] in km"
)]
enum Said {
    Number(f64),
    Pair([f64; 2]),
    Text(String),
}

/// The single-scattering albedo of a mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Said", into = "Said")]
#[non_exhaustive]
pub enum ModeAlbedo {
    /// The same at every wavelength.
    Grey(f64),
    /// That of Martian dust.
    MarsDust,
    /// That of a kind.
    Kind(AerosolKind),
    /// Of a file.
    File(FileOf<AlbedoRows>),
}

impl TryFrom<Said> for ModeAlbedo {
    type Error = String;

    fn try_from(said: Said) -> std::result::Result<Self, String> {
        match said {
            Said::Number(albedo) => Ok(Self::Grey(albedo)),
            Said::Text(name) if is_table_file(&name) => FileOf::try_from(name).map(Self::File),
            Said::Text(name) if name == "mars-dust" => Ok(Self::MarsDust),
            Said::Text(name) => kind(&name).map(Self::Kind),
            Said::Pair(_) => {
                Err("an albedo is a number, a kind of aerosol, mars-dust or the name of a .csv file".into())
            }
        }
    }
}

impl From<ModeAlbedo> for Said {
    fn from(albedo: ModeAlbedo) -> Self {
        match albedo {
            ModeAlbedo::Grey(albedo) => Self::Number(albedo),
            ModeAlbedo::MarsDust => Self::Text("mars-dust".into()),
            ModeAlbedo::Kind(kind) => Self::Text(crate::words::word(kind).into()),
            ModeAlbedo::File(file) => Self::Text(file.into()),
        }
    }
}

/// The phase function of a mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
#[non_exhaustive]
pub enum PhaseFunction {
    /// That of Cornette and Shanks.
    CornetteShanks,
    /// That of a kind.
    Kind(AerosolKind),
    /// Of a file.
    File(FileOf<Phase>),
}

impl TryFrom<String> for PhaseFunction {
    type Error = String;

    fn try_from(name: String) -> std::result::Result<Self, String> {
        if is_table_file(&name) {
            return FileOf::try_from(name).map(Self::File);
        }
        if name == "cornette-shanks" { Ok(Self::CornetteShanks) } else { kind(&name).map(Self::Kind) }
    }
}

impl From<PhaseFunction> for String {
    fn from(phase: PhaseFunction) -> Self {
        match phase {
            PhaseFunction::CornetteShanks => "cornette-shanks".into(),
            PhaseFunction::Kind(kind) => crate::words::word(kind).into(),
            PhaseFunction::File(file) => file.into(),
        }
    }
}

/// Where a mode lies above the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Said", into = "Said")]
#[non_exhaustive]
pub enum AerosolProfile {
    /// It falls off by a scale height (km).
    ScaleHeight(f64),
    /// It lies alike between two altitudes (km).
    Between([f64; 2]),
    /// Altitudes (km) and densities of a file.
    File(FileOf<Layer>),
}

impl TryFrom<Said> for AerosolProfile {
    type Error = String;

    fn try_from(said: Said) -> std::result::Result<Self, String> {
        match said {
            Said::Number(height) => Ok(Self::ScaleHeight(height)),
            Said::Pair(ends) => Ok(Self::Between(ends)),
            Said::Text(name) if is_table_file(&name) => FileOf::try_from(name).map(Self::File),
            Said::Text(_) => {
                Err("a profile is a scale height in km, [bottom, top] in km, or the name of a .csv file".into())
            }
        }
    }
}

impl From<AerosolProfile> for Said {
    fn from(profile: AerosolProfile) -> Self {
        match profile {
            AerosolProfile::ScaleHeight(height) => Self::Number(height),
            AerosolProfile::Between(ends) => Self::Pair(ends),
            AerosolProfile::File(file) => Self::Text(file.into()),
        }
    }
}

/// A kind that has optics of its own.
fn kind(name: &str) -> std::result::Result<AerosolKind, String> {
    let found = name.parse::<AerosolKind>().ok().filter(|kind| kind.known().is_some());
    found.ok_or_else(|| format!("{name:?} is no kind of aerosol, and not the name of a .csv file"))
}
