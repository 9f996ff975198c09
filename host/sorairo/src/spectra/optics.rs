//! Optical properties of the scene's atmosphere and sun at any wavelength.

use sorairo_shared::scattering::Bands;

use crate::scene::{AlbedoSpectrum, OzoneCrossSection, Scene, SunSpectrum};
use crate::spectra::tables;
use crate::spectra::vec4;

/// One Dobson unit: molecules per m².
const DOBSON_UNIT: f64 = 2.687e20;
const METRES_PER_KM: f64 = 1000.0;

/// The scene's coefficients as functions of the wavelength.
#[derive(Clone, Debug)]
pub struct Optics {
    air_scattering: f64,
    aerosol_extinction: f64,
    angstrom_exponent: f64,
    /// Of aerosol whose albedo is the same at every wavelength.
    single_scattering_albedo: f64,
    albedo_spectrum: AlbedoSpectrum,
    /// Molecules per m³ where ozone is densest.
    ozone_peak_density: f64,
    cross_section: OzoneCrossSection,
    sun: SunSpectrum,
    /// Distance of the sun (astronomical units).
    pub sun_distance: f64,
    /// The wavelengths (nm) at which all of this is known.
    pub known_wavelengths: (f64, f64),
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
    /// Those of a scene.
    pub fn new(scene: &Scene) -> Self {
        let a = &scene.atmosphere;
        // The tent's column is half its base times its height.
        let half_base = (a.ozone.top - a.ozone.bottom) / 2.0 * METRES_PER_KM;
        Self {
            air_scattering: a.air.scattering,
            aerosol_extinction: a.aerosol.optical_depth / a.aerosol.scale_height,
            angstrom_exponent: a.aerosol.angstrom_exponent,
            single_scattering_albedo: a.aerosol.single_scattering_albedo,
            albedo_spectrum: a.aerosol.single_scattering_albedo_spectrum.clone(),
            // Without ozone its layer may be anywhere, and as thin as nothing.
            ozone_peak_density: if a.ozone.column > 0.0 { a.ozone.column * DOBSON_UNIT / half_base } else { 0.0 },
            cross_section: a.ozone.cross_section.clone(),
            sun: scene.sun.spectrum.clone(),
            sun_distance: scene.sun.distance,
            known_wavelengths: scene.known_wavelengths(),
        }
    }

    /// The coefficients at a wavelength (nm).
    pub fn at(&self, wavelength: f64) -> Coefficients {
        let micrometres = wavelength / 1000.0;
        let aerosol_extinction = self.aerosol_extinction * micrometres.powf(-self.angstrom_exponent);
        Coefficients {
            air_scattering: self.air_scattering / micrometres.powi(4),
            aerosol_scattering: self.aerosol_albedo(wavelength) * aerosol_extinction,
            aerosol_extinction,
            ozone_absorption: self.ozone_peak_density * self.ozone_cross_section(wavelength) * METRES_PER_KM,
        }
    }

    /// Single-scattering albedo of aerosol.
    fn aerosol_albedo(&self, wavelength: f64) -> f64 {
        match &self.albedo_spectrum {
            AlbedoSpectrum::Grey => self.single_scattering_albedo,
            AlbedoSpectrum::MarsDust => tables::mars_dust_albedo().at(wavelength)[0],
            AlbedoSpectrum::File(file) => file.table().at(wavelength)[0],
        }
    }

    /// Absorption cross-section of ozone (m²).
    fn ozone_cross_section(&self, wavelength: f64) -> f64 {
        match &self.cross_section {
            OzoneCrossSection::At233K => tables::ozone_cross_section().at(wavelength)[0],
            OzoneCrossSection::File(file) => file.table().at(wavelength)[0],
        }
    }

    /// Solar irradiance at the top of the atmosphere (W·m⁻²·nm⁻¹; for the flat sun 1 at 1 au).
    pub fn solar_irradiance(&self, wavelength: f64) -> f64 {
        let at_1_au = match &self.sun {
            SunSpectrum::AstmG173 => tables::solar_irradiance().at(wavelength)[0],
            SunSpectrum::Flat => 1.0,
            SunSpectrum::File(file) => file.table().at(wavelength)[0],
        };
        at_1_au / self.sun_distance.powi(2)
    }

    /// Optical depth, at the observer's shortest wavelength and on a level ray, of what the exponential profiles of the scene
    /// hold above the top of the atmosphere.
    pub fn depth_above_top(&self, scene: &Scene) -> f64 {
        self.depth_above(scene, scene.atmosphere.top_radius)
    }

    /// Optical depth, at the observer's shortest wavelength, of the exponential profiles on a level ray from the ground.
    pub fn level_depth(&self, scene: &Scene) -> f64 {
        self.depth_above(scene, scene.atmosphere.ground_radius)
    }

    /// Optical depth of the exponential profiles on a level ray from a distance from the planet's centre (km).
    fn depth_above(&self, scene: &Scene, radius: f64) -> f64 {
        let a = &scene.atmosphere;
        let coefficients = self.at(super::observer::START);
        let level = |scale_height: f64, extinction: f64| {
            let column = (std::f64::consts::FRAC_PI_2 * radius * scale_height).sqrt();
            extinction * column * (-(radius - a.ground_radius) / scale_height).exp()
        };
        level(a.air.scale_height, coefficients.air_scattering)
            + level(a.aerosol.scale_height, coefficients.aerosol_extinction)
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
        }
    }
}
