//! Aerosol as a scene says it: by the keys of one, or as a list of several.

mod aeronet;
mod clean_country;
mod files;
mod mode;
mod values;

use documented::DocumentedFields;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

pub use self::aeronet::Aeronet;
pub(super) use self::clean_country::CLEAN_COUNTRY;
pub use self::mode::AerosolMode;
pub use self::values::{AerosolProfile, ModeAlbedo, PhaseFunction};
use super::place::Time;
use crate::error::{Error, Result};
use crate::medium::aerosol::{self, AerosolKind, Layer, Mixture, Scattering};
use crate::medium::profile::Profile;
use crate::spectra::choice::AlbedoSpectrum;

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

/// Makes an aerosol that of clean country.
pub(super) fn clean_country(aerosol: &mut Aerosol) {
    aerosol.angstrom_exponent = CLEAN_COUNTRY.angstrom_exponent;
    aerosol.optical_depth = CLEAN_COUNTRY.optical_depth;
    aerosol.scale_height = CLEAN_COUNTRY.scale_height;
    aerosol.single_scattering_albedo = CLEAN_COUNTRY.single_scattering_albedo;
    aerosol.asymmetry = CLEAN_COUNTRY.asymmetry;
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

    /// The same whose modes from files of AERONET have their rows: those that were chosen, or the nearest to a time.
    pub(super) fn at(&self, time: Option<Time>) -> Result<Self> {
        let mut chosen = self.clone();
        for aeronet in chosen.modes.iter_mut().filter_map(|mode| mode.aeronet.as_mut()) {
            let at = aeronet.at(time).map_err(|complaint| Error::not_allowed("atmosphere.aerosol", complaint))?;
            *aeronet = at;
        }
        Ok(chosen)
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
