//! Aerosol as a scene says it: by the keys of one, or as a list of several.

use std::sync::Arc;

use documented::DocumentedFields;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::{Error, Result, check_range};
use crate::medium::aerosol::{self, AerosolKind, Layer, Mixture, Phase, Scattering};
use crate::medium::profile::Profile;
use crate::spectra::choice::AlbedoSpectrum;
use crate::spectra::columns_file::{Columns, FileOf, FromColumns};
use crate::spectra::named_file::{NamedFile, is_table_file};
use crate::spectra::table::Table;

/// Aerosol: scatters and absorbs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Aerosol {
    /// Kind of aerosol; each but `plain` has spectra and a phase function in place of exponent, albedo and asymmetry.
    pub kind: AerosolKind,
    /// Vertical optical depth of aerosol at 1 µm: extinction at the ground times the scale height.
    pub optical_depth: f64,
    /// Ångström exponent α of the extinction by aerosol, which varies as λ^-α.
    pub angstrom_exponent: f64,
    /// Scale height of aerosol (km).
    pub scale_height: f64,
    /// Single-scattering albedo of aerosol at every wavelength: the fraction of the extinction that is scattering.
    pub single_scattering_albedo: f64,
    /// Single-scattering albedo of aerosol by wavelength, in place of `single_scattering_albedo`; a file holds 0 to 1.
    pub single_scattering_albedo_spectrum: AlbedoSpectrum,
    /// Asymmetry of the Cornette-Shanks phase function of aerosol.
    pub asymmetry: f64,
    /// Several aerosols, in place of the one of the other keys; in a file each is a table `[[atmosphere.aerosol]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub modes: Vec<AerosolMode>,
}

impl Default for Aerosol {
    fn default() -> Self {
        Self {
            kind: AerosolKind::Plain,
            optical_depth: 5.328e-3,
            angstrom_exponent: 0.0,
            scale_height: 1.2,
            single_scattering_albedo: 0.9,
            single_scattering_albedo_spectrum: AlbedoSpectrum::Grey,
            asymmetry: 0.8,
            modes: Vec::new(),
        }
    }
}

/// Optical depth of the plain aerosol of clean country at 1 µm: 0.064 at 550 nm.
pub(super) const CLEAN_COUNTRY: f64 = 0.0294;

/// OPAC's *continental clean* aerosol in numbers (Hess, Koepke and Schult 1998): single-scattering albedo 0.972 and
/// asymmetry 0.709 at 550 nm; the Ångström exponent 1.3 lies between those that OPAC gives below and above 500 nm.
pub(super) fn clean_country(aerosol: &mut Aerosol) {
    aerosol.angstrom_exponent = 1.3;
    aerosol.optical_depth = CLEAN_COUNTRY;
    aerosol.scale_height = 2.0;
    aerosol.single_scattering_albedo = 0.972;
    aerosol.asymmetry = 0.709;
}

/// One aerosol of several: what is not said is that of its kind; without a kind, that of the aerosol of clean country
/// in numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct AerosolMode {
    /// Kind of aerosol: one of the words of `atmosphere.aerosol.kind`.
    pub kind: AerosolKind,
    /// Vertical optical depth at the reference wavelength, 0 to 1000. Default: OPAC's value for the kind at 550 nm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub optical_depth: Option<f64>,
    /// Wavelength of the optical depth (nm). Default: 550.
    pub reference_wavelength: f64,
    /// Ångström exponent of the extinction, -5 to 5. Default: the spectrum of the kind, or 1.3.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angstrom_exponent: Option<f64>,
    /// Extinction by wavelength in place of the exponent: a file of `wavelength_nm,extinction`, in any unit;
    /// extrapolated as a power of the wavelength.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extinction: Option<FileOf<ExtinctionRows>>,
    /// Single-scattering albedo: a number, a kind, `mars-dust` or a file of `wavelength_nm,albedo`. Default: that of
    /// the kind, or 0.972.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub single_scattering_albedo: Option<ModeAlbedo>,
    /// Asymmetry of the phase function of Cornette and Shanks, -0.9 to 0.99. Default: 0.709.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub asymmetry: Option<f64>,
    /// Phase function: `cornette-shanks`, a kind, or a file with `angle_deg` and one column per wavelength, whose name
    /// is the wavelength in nm. Default: that of the kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase_function: Option<PhaseFunction>,
    /// Density over the altitude above the ground: a scale height (km), `[bottom, top]` (km), or a file of
    /// `altitude_km,density`. Default: the layers of the kind, or 2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<AerosolProfile>,
}

impl Default for AerosolMode {
    fn default() -> Self {
        Self {
            kind: AerosolKind::Plain,
            optical_depth: None,
            reference_wavelength: 550.0,
            angstrom_exponent: None,
            extinction: None,
            single_scattering_albedo: None,
            asymmetry: None,
            phase_function: None,
            profile: None,
        }
    }
}

/// Logarithms of wavelengths (nm) and of the extinction there, to any scale.
#[derive(Debug)]
pub struct ExtinctionRows(Arc<[(f64, f64)]>);

impl FromColumns for ExtinctionRows {
    fn from_columns(columns: &Columns) -> std::result::Result<Self, String> {
        let pairs = columns.pairs("more than 0", |value| value > 0.0)?;
        Ok(Self(pairs.into_iter().map(|(nm, value)| (nm.ln(), value.ln())).collect()))
    }
}

/// Albedos at wavelengths (nm).
#[derive(Debug)]
pub struct AlbedoRows(Table<1>);

impl FromColumns for AlbedoRows {
    fn from_columns(columns: &Columns) -> std::result::Result<Self, String> {
        let pairs = columns.pairs("at most 1", |value| value <= 1.0)?;
        Ok(Self(Table::of(pairs.into_iter().map(|(nm, value)| (nm, [value])))))
    }
}

impl FromColumns for Phase {
    fn from_columns(columns: &Columns) -> std::result::Result<Self, String> {
        let Some(wavelengths) = &columns.heads else {
            return Err("the first row must name its columns: angle_deg and a wavelength in nm for each".into());
        };
        let is_in_order = wavelengths.windows(2).all(|pair| pair[0] < pair[1]);
        let ends = [columns.rows[0].0, columns.rows[columns.rows.len() - 1].0];
        if wavelengths.len() != columns.rows[0].1.len() || !is_in_order {
            return Err("the wavelengths that name the columns must increase, one for each".into());
        }
        if ends[0] > 1.0 || !(170.0..=180.0).contains(&ends[1]) {
            return Err(format!("the angles lie between {} and {}; 0 to 180 degrees are wanted", ends[0], ends[1]));
        }
        let row = |((angle, values), line): (&(f64, Vec<f64>), &u64)| match values.iter().all(|value| *value > 0.0) {
            true => Ok((angle.to_radians(), values.clone())),
            false => Err(format!("line {line}: a phase function is more than 0 at every angle")),
        };
        let rows = columns.rows.iter().zip(&columns.lines).map(row).collect::<std::result::Result<Vec<_>, _>>()?;
        Ok(Self::new(wavelengths, rows.into_iter()))
    }
}

impl FromColumns for Layer {
    fn from_columns(columns: &Columns) -> std::result::Result<Self, String> {
        let levels = columns.pairs("0 or more", |value| value >= 0.0)?;
        match levels.iter().any(|(_, density)| *density > 0.0) {
            true => Ok(Self::Levels(levels.into())),
            false => Err("there is nothing at any altitude".into()),
        }
    }
}

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

impl AerosolMode {
    /// The files that it reads: each one's name and the CRC-32 of what it holds.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&NamedFile, u32)> {
        let extinction = self.extinction.iter().map(|file| (&file.file, file.checksum));
        let albedo = match &self.single_scattering_albedo {
            Some(ModeAlbedo::File(file)) => Some((&file.file, file.checksum)),
            _ => None,
        };
        let phase = match &self.phase_function {
            Some(PhaseFunction::File(file)) => Some((&file.file, file.checksum)),
            _ => None,
        };
        let profile = match &self.profile {
            Some(AerosolProfile::File(file)) => Some((&file.file, file.checksum)),
            _ => None,
        };
        extinction.chain(albedo).chain(phase).chain(profile)
    }

    /// Their names, to be changed.
    pub(crate) fn names_mut(&mut self) -> impl Iterator<Item = &mut NamedFile> {
        let extinction = self.extinction.iter_mut().map(|file| &mut file.file);
        let albedo = match &mut self.single_scattering_albedo {
            Some(ModeAlbedo::File(file)) => Some(&mut file.file),
            _ => None,
        };
        let phase = match &mut self.phase_function {
            Some(PhaseFunction::File(file)) => Some(&mut file.file),
            _ => None,
        };
        let profile = match &mut self.profile {
            Some(AerosolProfile::File(file)) => Some(&mut file.file),
            _ => None,
        };
        extinction.chain(albedo).chain(phase).chain(profile)
    }

    /// What the kernels take of it, in air of a profile.
    fn optics(&self, profile: &Profile) -> aerosol::Mode {
        let mut plain = Aerosol::default();
        clean_country(&mut plain);
        let known = self.kind.known();
        let usual = self.kind.usual();
        let exponent = self.angstrom_exponent.unwrap_or(plain.angstrom_exponent);
        let asymmetry = self.asymmetry.unwrap_or(plain.asymmetry);
        let grey = |albedo| aerosol::Albedo::Spectrum(AlbedoSpectrum::Grey, albedo);
        let of_kind = |kind: AerosolKind| kind.known().expect("a kind that is named has optics");
        aerosol::Mode {
            depth: self.optical_depth.or(usual.as_ref().map(|(depth, _)| *depth)).unwrap_or(0.0),
            reference: self.reference_wavelength,
            extinction: match (&self.extinction, self.angstrom_exponent, known) {
                (Some(file), ..) => aerosol::Extinction::Rows(Arc::clone(&file.value.0)),
                (None, None, Some(kind)) => aerosol::Extinction::Kind(kind),
                (None, ..) => aerosol::Extinction::Power(exponent),
            },
            albedo: match (&self.single_scattering_albedo, known) {
                (Some(ModeAlbedo::Grey(albedo)), _) => grey(*albedo),
                (Some(ModeAlbedo::MarsDust), _) => aerosol::Albedo::Spectrum(AlbedoSpectrum::MarsDust, 1.0),
                (Some(ModeAlbedo::Kind(kind)), _) => aerosol::Albedo::Kind(of_kind(*kind)),
                (Some(ModeAlbedo::File(file)), _) => aerosol::Albedo::Rows(Arc::new(file.value.0.clone())),
                (None, Some(kind)) => aerosol::Albedo::Kind(kind),
                (None, None) => grey(plain.single_scattering_albedo),
            },
            scattering: match (&self.phase_function, self.asymmetry, known) {
                (Some(PhaseFunction::File(file)), ..) => Scattering::Tabulated(file.value.clone()),
                (Some(PhaseFunction::Kind(kind)), ..) => Scattering::Tabulated(of_kind(*kind).phase().clone()),
                (None, None, Some(kind)) => Scattering::Tabulated(kind.phase().clone()),
                (Some(PhaseFunction::CornetteShanks) | None, ..) => Scattering::CornetteShanks(asymmetry),
            },
            layer: match (&self.profile, usual) {
                (Some(AerosolProfile::ScaleHeight(height)), _) => Layer::Exponential(*height),
                (Some(AerosolProfile::Between([bottom, top])), _) => Layer::even(*bottom, *top),
                (Some(AerosolProfile::File(file)), _) => (*file.value).clone(),
                (None, Some((_, layer))) if profile.is_measured() => layer,
                (None, _) => Layer::Exponential(plain.scale_height),
            },
        }
    }

    fn check(&self) -> Result<()> {
        const KEY: &str = "atmosphere.aerosol";
        let numbers = [
            ("optical_depth", self.optical_depth, (0.0, 1000.0), ""),
            ("reference_wavelength", Some(self.reference_wavelength), (200.0, 4000.0), " nm"),
            ("angstrom_exponent", self.angstrom_exponent, (-5.0, 5.0), ""),
            ("asymmetry", self.asymmetry, (-0.9, 0.99), ""),
        ];
        let not_allowed = |complaint: String| Err(Error::not_allowed(KEY, complaint));
        for (name, number, (low, high), unit) in numbers {
            if number.is_some_and(|number| check_range(KEY, number, (low, high), "").is_err()) {
                let number = number.expect("there is one");
                return not_allowed(format!(
                    "has a mode whose {name} is {number}; it must lie between {low} and {high}{unit}"
                ));
            }
        }
        match (&self.single_scattering_albedo, &self.profile) {
            (Some(ModeAlbedo::Grey(albedo)), _) if !(0.0..=1.0).contains(albedo) => not_allowed(format!(
                "has a mode whose single_scattering_albedo is {albedo}; it must lie between 0 and 1"
            )),
            (_, Some(AerosolProfile::ScaleHeight(height))) if !(0.05..=100.0).contains(height) => not_allowed(format!(
                "has a mode whose profile is {height}; a scale height must lie between 0.05 and 100 km"
            )),
            (_, Some(AerosolProfile::Between([bottom, top]))) if !(*bottom >= 0.0 && top - bottom >= 0.5) => {
                not_allowed(format!(
                    "has a mode whose profile is [{bottom}, {top}]; a layer is 0.5 km thick or more, above the ground"
                ))
            }
            _ if self.kind == AerosolKind::Plain && self.optical_depth.is_none() => {
                not_allowed("has a mode with neither a kind nor an optical_depth".into())
            }
            _ => Ok(()),
        }
    }
}

impl Aerosol {
    /// What the kernels take of the aerosol, in air of a profile.
    pub(crate) fn mixture(&self, profile: &Profile) -> Mixture {
        if self.modes.is_empty() {
            return Mixture::new(vec![self.as_one()]);
        }
        Mixture::new(self.modes.iter().map(|mode| mode.optics(profile)).collect())
    }

    /// The one that the keys say.
    fn as_one(&self) -> aerosol::Mode {
        let known = self.kind.known();
        aerosol::Mode {
            depth: self.optical_depth,
            reference: 1000.0,
            extinction: known.map_or(aerosol::Extinction::Power(self.angstrom_exponent), aerosol::Extinction::Kind),
            albedo: known.map_or_else(
                || {
                    let spectrum = self.single_scattering_albedo_spectrum.clone();
                    aerosol::Albedo::Spectrum(spectrum, self.single_scattering_albedo)
                },
                aerosol::Albedo::Kind,
            ),
            scattering: known
                .map_or(Scattering::CornetteShanks(self.asymmetry), |kind| Scattering::Tabulated(kind.phase().clone())),
            layer: Layer::Exponential(self.scale_height),
        }
    }

    /// Whether there is any.
    pub fn is_there(&self) -> bool {
        if self.modes.is_empty() { self.optical_depth > 0.0 } else { self.mixture(&Profile::UsStandard).is_there() }
    }

    /// Checks the modes in air of a profile.
    pub(super) fn check_modes(&self, profile: &Profile) -> Result<()> {
        self.modes.iter().try_for_each(AerosolMode::check)?;
        if profile.is_measured() || self.mixture(profile).lane.is_exponential() {
            return Ok(());
        }
        let complaint =
            "has modes that do not fall off alike by one scale height, which needs a measured atmosphere.profile";
        Err(Error::not_allowed("atmosphere.aerosol", complaint))
    }
}

/// Aerosol in a scene: a table of keys, or an array of modes.
#[derive(Deserialize)]
#[serde(untagged)]
enum OneOrMany {
    Many(Vec<AerosolMode>),
    One(Box<Aerosol>),
}

/// Writes the keys of one aerosol, or the modes of several.
pub(super) fn serialize<S: Serializer>(aerosol: &Aerosol, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    if aerosol.modes.is_empty() { aerosol.serialize(serializer) } else { aerosol.modes.serialize(serializer) }
}

/// Reads either.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Aerosol, D::Error> {
    Ok(match OneOrMany::deserialize(deserializer)? {
        OneOrMany::One(aerosol) => *aerosol,
        OneOrMany::Many(modes) => Aerosol { modes, ..Aerosol::default() },
    })
}
