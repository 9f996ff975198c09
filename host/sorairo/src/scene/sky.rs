//! The sky: the sun, the observer, the planet and what surrounds it.

use documented::DocumentedFields;
use serde::{Deserialize, Serialize};

use super::aerosol::{self, Aerosol};
use super::place::{Place, Time};
pub use crate::medium::gases::STANDARD_PRESSURE;
use crate::medium::profile::Profile;
use crate::spectra::choice::{AirSpectrum, GroundAlbedo, OzoneCrossSection, SunSpectrum};

/// The sun.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Sun {
    /// Elevation of the sun above the horizon (degrees), without refraction.
    pub elevation: f64,
    /// Whether `elevation` is the apparent elevation, raised by refraction.
    pub apparent: bool,
    /// Azimuth of the sun, clockwise from north (degrees).
    pub azimuth: f64,
    /// Latitude and longitude of the observer on the Earth (degrees north, degrees east), for the sun's position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<Place>,
    /// Date, time of day and offset from UTC, for the sun's position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<Time>,
    /// Solar irradiance by wavelength at the top of the atmosphere, at a distance of 1 au; a file holds W·m⁻²·nm⁻¹.
    pub spectrum: SunSpectrum,
    /// Distance of the sun (astronomical units, au): irradiance is inverse to its square; a place and a time determine
    /// it.
    pub distance: f64,
    /// Whether images show the sun's disc, with limb darkening and attenuation by the air.
    pub disc: bool,
}

impl Default for Sun {
    fn default() -> Self {
        Self {
            elevation: 30.0,
            apparent: false,
            azimuth: 0.0,
            place: None,
            time: None,
            spectrum: SunSpectrum::AstmG173,
            distance: 1.0,
            disc: false,
        }
    }
}

/// The observer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Observer {
    /// Altitude of the observer above the ground (km).
    pub altitude: f64,
}

impl Default for Observer {
    fn default() -> Self {
        Self { altitude: 0.0 }
    }
}

/// The site.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Site {
    /// Altitude of the ground above the sea (km), where a measured profile begins; `observer.altitude` starts there.
    pub altitude: f64,
}

/// The ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Ground {
    /// Albedo of the Lambertian ground: a number, the spectrum of a surface, or a file of 0 to 1.
    pub albedo: GroundAlbedo,
}

impl Default for Ground {
    fn default() -> Self {
        // That of Bruneton's demonstration of precomputed atmospheric scattering (2017).
        Self { albedo: GroundAlbedo::Grey(0.1) }
    }
}

/// The planet and its atmosphere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct AtmosphereScene {
    /// Radius of the ground sphere (km).
    pub ground_radius: f64,
    /// Radius of the top of the atmosphere (km).
    pub top_radius: f64,
    /// Profile of air and ozone over altitude: by `air.scale_height` and the ozone tent, or measured; other keys set
    /// amounts.
    pub profile: Profile,
    /// Whether air refracts sunlight, which raises the sun and spreads its light; requires a measured profile of the
    /// Earth.
    pub refraction: bool,
    /// Air.
    pub air: Air,
    /// Aerosol.
    #[serde(with = "aerosol")]
    pub aerosol: Aerosol,
    /// Ozone.
    pub ozone: Ozone,
    /// Water vapour.
    pub water: Water,
}

impl Default for AtmosphereScene {
    fn default() -> Self {
        Self {
            ground_radius: 6360.0,
            top_radius: 6460.0,
            profile: Profile::Exponential,
            refraction: false,
            air: Air::default(),
            aerosol: Aerosol::default(),
            ozone: Ozone::default(),
            water: Water::default(),
        }
    }
}

/// Air: scatters by Rayleigh's law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Air {
    /// Scattering coefficient of air at the ground and 1 µm (km⁻¹): `4πk` of the paper's Eq. 3 in µm⁴·km⁻¹.
    pub scattering: f64,
    /// Wavelength dependence of the scattering by air.
    pub spectrum: AirSpectrum,
    /// Pressure of air at the ground (hPa), to which its scattering is proportional; `scattering` is that at 1013.25
    /// hPa.
    pub pressure: f64,
    /// Scale height of air (km).
    pub scale_height: f64,
}

impl Default for Air {
    fn default() -> Self {
        Self {
            scattering: 1.240_62e-3,
            spectrum: AirSpectrum::FourthPower,
            pressure: STANDARD_PRESSURE,
            scale_height: 8.0,
        }
    }
}

/// Ozone: absorbs, in a layer whose density is a tent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Ozone {
    /// Vertical column density of ozone (Dobson units).
    pub column: f64,
    /// Altitude of the lower edge of the ozone layer (km).
    pub bottom: f64,
    /// Altitude of the largest density of the ozone layer (km).
    pub peak: f64,
    /// Altitude of the upper edge of the ozone layer (km).
    pub top: f64,
    /// Absorption cross-section of ozone; a file holds m² (1 cm² is 1e-4 m²).
    pub cross_section: OzoneCrossSection,
}

impl Default for Ozone {
    fn default() -> Self {
        Self { column: 300.0, bottom: 10.0, peak: 25.0, top: 40.0, cross_section: OzoneCrossSection::At233K }
    }
}

/// Water vapour: absorbs, in a measured profile, whose shape it has.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Water {
    /// Precipitable water over the ground (cm).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<f64>,
}
