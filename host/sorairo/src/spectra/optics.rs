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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Preset;

    fn at(scene: &Scene, wavelength: f64) -> Coefficients {
        Optics::new(scene).at(wavelength)
    }

    /// Optical depth of a column of air, as the published ones end nowhere.
    fn air_depth(scene: &Scene, wavelength: f64) -> f64 {
        at(scene, wavelength).air_scattering * scene.atmosphere.air.scale_height
    }

    #[track_caller]
    fn assert_close(value: f64, published: f64, tolerance: f64) {
        assert!((value / published - 1.0).abs() <= tolerance, "{value} instead of {published}");
    }

    #[test]
    fn the_earths_air_is_that_of_its_source() {
        // Bruneton and Neyret 2008, Sec. 2.1, in three digits, with a scale height of 8 km (DOI 10.1111/j.1467-8659.2008.01245.x).
        let scene = Scene::preset(Preset::Earth);
        for (wavelength, per_km) in [(680.0, 5.8e-3), (550.0, 13.5e-3), (440.0, 33.1e-3)] {
            assert_close(at(&scene, wavelength).air_scattering, per_km, 5e-3);
        }
        assert_eq!(scene.atmosphere.air.scale_height, 8.0);
    }

    /// Rayleigh optical depth of the standard atmosphere at sea level: Bodhaine, Wood, Dutton and Slusser 1999, Eq. 30, which
    /// gives their table within 0.01 % (DOI 10.1175/1520-0426(1999)016<1854:ORODC>2.0.CO;2).
    fn standard_air_depth(wavelength: f64) -> f64 {
        let square = (wavelength / 1000.0).powi(2);
        let over = 1.045_599_6 - 341.290_61 / square - 0.902_308_50 * square;
        0.002_152_0 * over / (1.0 + 0.002_705_988_9 / square - 85.968_563 * square)
    }

    #[test]
    fn the_earths_air_is_7_to_14_percent_thicker_than_the_standard_atmosphere() {
        let scene = Scene::preset(Preset::Earth);
        // λ⁻⁴ without dispersion grows apart from it with the wavelength.
        let ratios = [400.0, 500.0, 600.0, 700.0, 780.0].map(|nm| air_depth(&scene, nm) / standard_air_depth(nm));
        assert!(ratios.windows(2).all(|pair| pair[0] < pair[1]), "{ratios:?}");
        assert!(ratios.iter().all(|ratio| (1.07..1.145).contains(ratio)), "{ratios:?}");
        assert_close(standard_air_depth(550.0), 0.0971, 1e-3);
    }

    #[test]
    fn air_scatters_as_the_fourth_power_of_the_wavelength() {
        let scene = Scene::preset(Preset::Earth);
        assert_close(at(&scene, 400.0).air_scattering / at(&scene, 800.0).air_scattering, 16.0, 1e-14);
        assert_close(at(&scene, 1000.0).air_scattering, scene.atmosphere.air.scattering, 1e-15);
    }

    #[test]
    fn ozone_absorbs_as_published() {
        let mut scene = Scene::preset(Preset::Earth);
        let tent = |scene: &Scene| (scene.atmosphere.ozone.top - scene.atmosphere.ozone.bottom) / 2.0;
        let depth = |scene: &Scene, wavelength| at(scene, wavelength).ozone_absorption * tent(scene);
        assert_eq!(scene.atmosphere.ozone.column, 300.0);
        // 3 mm of ozone at 0 °C and 1 atm hold 101325 Pa / (k 273.15 K) molecules per m³, each of 5.019e-25 m² at 600 nm (Serdyuchenko
        // et al. 2014, DOI 10.5194/amt-7-625-2014). A Dobson unit of four digits is 8e-5 more.
        let molecules = 3e-3 * 101_325.0 / (1.380_649e-23 * 273.15);
        assert_close(depth(&scene, 600.0), molecules * 5.019e-25, 1e-4);
        // Solar models take 0.119 and 0.120 per cm of ozone at 593 and 610 nm (Bird and Riordan 1986, Table 1); such measured
        // coefficients are uncertain to 10 to 20 % as spectrophotometry of the sun found.
        assert_close(depth(&scene, 593.0), 0.3 * 0.119, 0.1);
        assert_close(depth(&scene, 610.0), 0.3 * 0.120, 0.1);
        // What a column absorbs does not depend on where it is.
        let before = depth(&scene, 600.0);
        (scene.atmosphere.ozone.bottom, scene.atmosphere.ozone.peak, scene.atmosphere.ozone.top) = (15.0, 18.0, 35.0);
        assert_close(depth(&scene, 600.0), before, 1e-14);
        scene.atmosphere.ozone.column = 0.0;
        assert_eq!(depth(&scene, 600.0), 0.0);
    }

    #[test]
    fn aerosol_follows_angstroms_law() {
        // Optical depths at 550 nm of OPAC's continental polluted and clean aerosol (Hess, Koepke and Schult 1998, DOI
        // 10.1175/1520-0477(1998)079<0831:OPOAAC>2.0.CO;2), which the presets name in three digits at 1 µm.
        for (preset, published, albedo) in [(Preset::Hazy, 0.327, 0.892), (Preset::Mountain, 0.064, 0.972)] {
            let scene = Scene::preset(preset);
            let c = at(&scene, 550.0);
            assert_close(c.aerosol_extinction * scene.atmosphere.aerosol.scale_height, published, 3e-3);
            assert_close(c.aerosol_scattering / c.aerosol_extinction, albedo, 1e-12);
        }
        // τ(λ) = β λ^−α with λ in µm (Ångström 1929): of α = 1.3, half the wavelength is 2^1.3 times as thick.
        let hazy = Scene::preset(Preset::Hazy);
        assert_close(at(&hazy, 400.0).aerosol_extinction / at(&hazy, 800.0).aerosol_extinction, 2.462_288_8, 1e-7);
        let grey = Scene::preset(Preset::Earth);
        assert_close(at(&grey, 380.0).aerosol_extinction, 5.328e-3 / 1.2, 1e-14);
    }

    #[test]
    fn martian_air_and_dust_are_those_of_their_sources() {
        let scene = Scene::preset(Preset::Mars);
        // 0.00267 at 550 nm, see the preset.
        assert_close(air_depth(&scene, 550.0), 0.002_67, 5e-3);
        let albedo = |wavelength| at(&scene, wavelength).aerosol_scattering / at(&scene, wavelength).aerosol_extinction;
        // Wolff et al. 2009 (DOI 10.1029/2009JE003350).
        for (wavelength, published) in [(388.0, 0.73), (650.0, 0.967), (700.0, 0.975)] {
            assert_close(albedo(wavelength), published, 1e-12);
        }
    }
}
