//! Optical properties of an atmosphere and its sun at any wavelength.

use sorairo_shared::glam::Vec4;
use sorairo_shared::single::Bands;

use super::choice::{AirSpectrum, AlbedoSpectrum, GroundAlbedo, OzoneCrossSection, SunSpectrum};
use super::observer;

const METRES_PER_KM: f64 = 1000.0;

/// What an atmosphere and its sun are made of, and hence their coefficients at any wavelength.
#[derive(Clone, Debug)]
pub struct Optics {
    /// Radius of the ground (km).
    pub ground_radius: f64,
    /// Radius of the top of the atmosphere (km).
    pub top_radius: f64,
    /// Scattering coefficient of air at the ground and 1 µm (km⁻¹).
    pub air_scattering: f64,
    /// How it depends on the wavelength.
    pub air_spectrum: AirSpectrum,
    /// Scale height of air (km).
    pub air_scale_height: f64,
    /// Extinction coefficient of aerosol at the ground and 1 µm (km⁻¹).
    pub aerosol_extinction: f64,
    /// Ångström exponent of that extinction.
    pub angstrom_exponent: f64,
    /// Scale height of aerosol (km).
    pub aerosol_scale_height: f64,
    /// Single-scattering albedo of aerosol where it is the same at every wavelength.
    pub single_scattering_albedo: f64,
    /// Single-scattering albedo of aerosol by wavelength.
    pub albedo_spectrum: AlbedoSpectrum,
    /// Molecules of ozone per m³ where it is densest.
    pub ozone_peak_density: f64,
    /// Absorption cross-section of ozone.
    pub cross_section: OzoneCrossSection,
    /// Albedo of the ground.
    pub ground_albedo: GroundAlbedo,
    /// Spectrum of the sun.
    pub sun: SunSpectrum,
    /// Distance of the sun (astronomical units).
    pub sun_distance: f64,
}

/// Coefficients at one wavelength (km⁻¹, at the ground, ozone at its peak).
#[derive(Clone, Copy, Debug)]
pub struct Coefficients {
    /// Scattering by air.
    pub air_scattering: f64,
    /// Scattering by aerosol.
    pub aerosol_scattering: f64,
    /// Extinction by aerosol.
    pub aerosol_extinction: f64,
    /// Absorption by ozone.
    pub ozone_absorption: f64,
}

impl Optics {
    /// The coefficients at a wavelength (nm).
    pub fn at(&self, wavelength: f64) -> Coefficients {
        let micrometres = wavelength / 1000.0;
        let aerosol_extinction = self.aerosol_extinction * micrometres.powf(-self.angstrom_exponent);
        Coefficients {
            air_scattering: self.air_scattering * self.air_spectrum.relative(micrometres),
            aerosol_scattering: self.albedo_spectrum.at(wavelength, self.single_scattering_albedo) * aerosol_extinction,
            aerosol_extinction,
            ozone_absorption: self.ozone_peak_density * self.cross_section.at(wavelength) * METRES_PER_KM,
        }
    }

    /// Solar irradiance at the top of the atmosphere (W·m⁻²·nm⁻¹; for the flat sun 1 at 1 au).
    pub fn solar_irradiance(&self, wavelength: f64) -> f64 {
        self.sun.at(wavelength) / self.sun_distance.powi(2)
    }

    /// Optical depth, at the observer's shortest wavelength and on a level ray, of what the exponential profiles hold above the
    /// top of the atmosphere.
    pub fn depth_above_top(&self) -> f64 {
        self.depth_above(self.top_radius)
    }

    /// Optical depth, at the observer's shortest wavelength, of the exponential profiles on a level ray from the ground.
    pub fn level_depth(&self) -> f64 {
        self.depth_above(self.ground_radius)
    }

    /// Optical depth of the exponential profiles on a level ray from a distance from the planet's centre (km).
    fn depth_above(&self, radius: f64) -> f64 {
        let coefficients = self.at(observer::START);
        let level = |scale_height: f64, extinction: f64| {
            let column_density = (std::f64::consts::FRAC_PI_2 * radius * scale_height).sqrt();
            extinction * column_density * (-(radius - self.ground_radius) / scale_height).exp()
        };
        level(self.air_scale_height, coefficients.air_scattering)
            + level(self.aerosol_scale_height, coefficients.aerosol_extinction)
    }

    /// The coefficients at four wavelengths (nm), as the kernels take them.
    pub fn bands(&self, wavelengths: [f64; 4]) -> Bands {
        let at = wavelengths.map(|wavelength| self.at(wavelength));
        let solar_irradiance = vec4(wavelengths.map(|wavelength| self.solar_irradiance(wavelength)));
        Bands {
            air_scattering: vec4(at.map(|c| c.air_scattering)),
            aerosol_scattering: vec4(at.map(|c| c.aerosol_scattering)),
            aerosol_extinction: vec4(at.map(|c| c.aerosol_extinction)),
            ozone_absorption: vec4(at.map(|c| c.ozone_absorption)),
            solar_irradiance,
            fit_irradiance: solar_irradiance,
            albedo: vec4(wavelengths.map(|wavelength| self.ground_albedo.at(wavelength))),
        }
    }
}

/// Four values as the kernels take them.
pub(crate) fn vec4(values: [f64; 4]) -> Vec4 {
    Vec4::from_array(values.map(|value| value as f32))
}
