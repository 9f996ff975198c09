//! The optical properties of a scene.

use std::sync::Arc;

use super::keys;
use super::preset::Scene;
use super::sky::STANDARD_PRESSURE;
use crate::error::{Error, Result};
use crate::input::shown;
use crate::medium::bent::{Air, refractivity};
use crate::medium::gases::{Relative, SkyGases, water};
use crate::medium::tables::Tables;
use crate::spectra::choice::{AlbedoSpectrum, OrTable};
use crate::spectra::optics::Optics;
use crate::spectra::range::{MEASURED_RANGE, RANGE_OF_BEAMS};

/// One Dobson unit: molecules per m².
const DOBSON_UNIT: f64 = 2.687e20;
const METRES_PER_KM: f64 = 1000.0;

impl Scene {
    /// The optical properties of the atmosphere and the sun.
    #[doc(hidden)]
    pub fn optics(&self) -> Optics {
        let a = &self.atmosphere;
        // The tent's column density is half its base times its height.
        let half_base = (a.ozone.top - a.ozone.bottom) / 2.0 * METRES_PER_KM;
        Optics {
            ground_radius: a.ground_radius,
            top_radius: a.top_radius,
            air_scattering: a.air.scattering * self.relative_pressure(),
            air_spectrum: a.air.spectrum,
            air_scale_height: a.air.scale_height,
            aerosol: a.aerosol.mixture(&a.profile),
            // Without ozone its layer may be anywhere, and as thin as nothing.
            ozone_peak_density: if a.ozone.column > 0.0 { a.ozone.column * DOBSON_UNIT / half_base } else { 0.0 },
            forward_peak: 0.0,
            cross_section: a.ozone.cross_section.clone(),
            ozone_temperature: a.profile.ozone_temperature(),
            ozone_column: half_base / METRES_PER_KM,
            gases: self.gases().and_then(|relative| {
                SkyGases::new(&a.profile, self.site.altitude, relative, a.profile.ozone_temperature())
            }),
            ground_albedo: self.ground.albedo.clone(),
            sun: self.sun.spectrum.clone(),
            sun_distance: self.sun.distance,
        }
    }
}

impl Scene {
    /// The wavelengths (nm) at which the whole scene has data: those of [`MEASURED_RANGE`] within the range of user
    /// tables.
    pub fn known_wavelengths(&self) -> (f64, f64) {
        let ranges = keys::tables(self).map(|(_, file)| file.table().range());
        ranges.fold(MEASURED_RANGE, both)
    }

    /// The wavelengths (nm) at which the sun's beam has data: with a measured profile, whose absorbers are all known,
    /// those of [`RANGE_OF_BEAMS`] within the range of user tables of the sun and of ozone.
    pub fn known_wavelengths_of_beams(&self) -> (f64, f64) {
        if !self.atmosphere.profile.is_measured() {
            return self.known_wavelengths();
        }
        let files = [self.sun.spectrum.file(), self.atmosphere.ozone.cross_section.file()];
        files.into_iter().flatten().map(|file| file.table().range()).fold(RANGE_OF_BEAMS, both)
    }

    /// The wavelengths (nm) at which skylight through the lines of gases has data: with a measured profile, those of
    /// [`RANGE_OF_BEAMS`] where ground and aerosol have data too; none otherwise.
    pub fn known_wavelengths_of_skies(&self) -> (f64, f64) {
        if !self.atmosphere.profile.is_measured() {
            return (f64::INFINITY, f64::NEG_INFINITY);
        }
        let aerosol = self.atmosphere.aerosol.mixture(&self.atmosphere.profile);
        let parts = aerosol.albedo_spectra().map(AlbedoSpectrum::range).chain([self.ground.albedo.range()]);
        parts.fold(self.known_wavelengths_of_beams(), both)
    }

    /// Pressure of the air relative to that of the standard atmosphere, or to that of a measured profile at the site.
    pub fn relative_pressure(&self) -> f64 {
        let pressure = self.atmosphere.air.pressure;
        let site = (self.site.altitude > 0.0).then_some(self.site.altitude);
        match site.and_then(|altitude| self.atmosphere.profile.level(altitude)) {
            // The default stands for what was measured there.
            Some(_) if pressure == STANDARD_PRESSURE => 1.0,
            Some(there) => pressure / there.pressure,
            None => pressure / STANDARD_PRESSURE,
        }
    }

    /// The gases of a measured profile, relative to those that were measured.
    #[doc(hidden)]
    pub fn gases(&self) -> Option<Relative> {
        let measured = water(&self.atmosphere.profile, self.site.altitude)?;
        let water = self.atmosphere.water.column.map_or(1.0, |column| column / measured);
        Some(Relative { water, pressure: self.relative_pressure() })
    }

    /// The tables of the air, where its profile has no closed form.
    #[doc(hidden)]
    pub fn tables(&self) -> Option<Arc<Tables>> {
        let a = &self.atmosphere;
        let aerosol = a.aerosol.mixture(&a.profile).lane;
        let air = Air {
            profile: a.profile.clone(),
            ground_radius: a.ground_radius,
            depth: a.top_radius - a.ground_radius,
            site: self.site.altitude,
            columns: [a.air.scale_height, 0.5 * (a.ozone.top - a.ozone.bottom)],
            aerosol,
            refractivity: if a.refraction { refractivity(&a.profile, self.relative_pressure()) } else { 0.0 },
        };
        a.profile.is_measured().then(|| Tables::of(&air))
    }

    /// The true elevation (degrees) of a sun with an apparent elevation (degrees).
    pub(super) fn elevation_of_apparent(&self, seen: f64) -> f64 {
        let beam = |tables: Arc<Tables>| tables.beam(self.observer.altitude, (90.0 - seen).to_radians());
        self.bending_air().and_then(beam).map_or(seen, |beam| 90.0 - beam.sun.to_degrees())
    }

    /// The apparent elevation (degrees) of the sun's centre; `None` below the horizon.
    pub fn apparent_elevation(&self) -> Option<f64> {
        let (sun, altitude) = ((90.0 - self.sun.elevation).to_radians(), self.observer.altitude);
        let tables = self.bending_air().filter(|tables| sun <= tables.lowest_sun(altitude))?;
        Some(90.0 - tables.seen(altitude, sun).to_degrees())
    }

    /// The air around the observer, if it refracts sunlight.
    fn bending_air(&self) -> Option<Arc<Tables>> {
        let a = &self.atmosphere;
        let is_around = self.observer.altitude <= a.top_radius - a.ground_radius;
        if a.refraction && is_around { self.tables() } else { None }
    }
}

/// What lies in both of two ranges.
fn both(known: (f64, f64), table: (f64, f64)) -> (f64, f64) {
    (known.0.max(table.0), known.1.min(table.1))
}

/// The contrast threshold of Koschmieder's visibility.
const LEAST_CONTRAST: f64 = 0.02;

/// Wavelength (nm) at which visibility is judged.
const OF_VISIBILITY: f64 = 550.0;

impl Scene {
    /// The optical depth of aerosol at 1 µm, of one at another wavelength (nm), by the aerosol's kind or its Ångström
    /// exponent.
    pub fn optical_depth_from(&self, depth: f64, wavelength: f64) -> f64 {
        let aerosol = &self.atmosphere.aerosol;
        match aerosol.kind.known() {
            Some(kind) => depth * kind.extinction(1000.0, wavelength),
            None => depth * (wavelength / 1000.0).powf(aerosol.angstrom_exponent),
        }
    }

    /// The optical depth of aerosol at 1 µm that gives a meteorological visibility (km, 2 % contrast).
    ///
    /// By Koschmieder's law (1924, *Theorie der horizontalen Sichtweite*) the contrast decreases as `exp(-σ V)`, where
    /// `σ` is the extinction of air and aerosol at the ground and 550 nm. With a contrast threshold of 0.02,
    /// `σ V = 3.912`.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] for a distance at which air alone leaves less contrast, or that is not positive.
    pub fn optical_depth_from_visibility(&self, visibility: f64) -> Result<f64> {
        let contrast = -LEAST_CONTRAST.ln();
        let air = self.optics().at(OF_VISIBILITY).air_scattering;
        let farthest = contrast / air;
        if visibility > 0.0 && visibility <= farthest {
            let extinction = contrast / visibility - air;
            return Ok(self.optical_depth_from(extinction * self.atmosphere.aerosol.scale_height, OF_VISIBILITY));
        }
        let complaint = format!(
            "is {}; it must be more than 0 and at most {farthest:.0} km, which air alone allows",
            shown(visibility)
        );
        Err(Error::not_allowed("visibility", complaint))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{AirSpectrum, Preset};
    use crate::spectra::optics::Coefficients;

    fn at(scene: &Scene, wavelength: f64) -> Coefficients {
        scene.optics().at(wavelength)
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
        // Bruneton and Neyret 2008, Sec. 2.1, in three digits, with a scale height of 8 km (DOI
        // 10.1111/j.1467-8659.2008.01245.x).
        let scene = Scene::preset(Preset::Earth);
        for (wavelength, per_km) in [(680.0, 5.8e-3), (550.0, 13.5e-3), (440.0, 33.1e-3)] {
            assert_close(at(&scene, wavelength).air_scattering, per_km, 5e-3);
        }
        assert_eq!(scene.atmosphere.air.scale_height, 8.0);
    }

    /// Rayleigh optical depth of the standard atmosphere at sea level: Bodhaine, Wood, Dutton and Slusser 1999, Eq. 30,
    /// which gives their table within 0.01 % (DOI 10.1175/1520-0426(1999)016<1854:ORODC>2.0.CO;2).
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
    fn the_standard_air_is_that_of_the_standard_atmosphere() {
        let scene = Scene::preset(Preset::Standard);
        for wavelength in [380.0, 450.0, 550.0, 650.0, 780.0] {
            // The scattering coefficient of the preset has six digits.
            assert_close(air_depth(&scene, wavelength), standard_air_depth(wavelength), 2e-6);
        }
        let mut high = scene;
        high.atmosphere.air.pressure = 700.0;
        assert_close(air_depth(&high, 550.0), 700.0 / 1013.25 * standard_air_depth(550.0), 2e-6);
    }

    #[test]
    fn molecules_depolarise_as_published() {
        // Bucholtz 1995, Table 1: a King factor of 1.048 at 550 nm is a depolarisation of 0.0279 to 0.0284 (DOI
        // 10.1364/AO.34.002765).
        let anisotropy = AirSpectrum::Bodhaine.anisotropy();
        let depolarisation = 2.0 * (1.0 - anisotropy) / (2.0 + anisotropy);
        assert!((0.0275..0.0288).contains(&depolarisation), "{depolarisation}");
        assert_eq!(AirSpectrum::FourthPower.anisotropy(), 1.0);
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
        // 3 mm of ozone at 0 °C and 1 atm hold 101325 Pa / (k 273.15 K) molecules per m³, each of 5.019e-25 m² from 600
        // to 610 nm (Serdyuchenko et al. 2014, DOI 10.5194/amt-7-625-2014). A Dobson unit of four digits is 8e-5 more.
        let molecules = 3e-3 * 101_325.0 / (1.380_649e-23 * 273.15);
        assert_close(depth(&scene, 605.0), molecules * 5.019e-25, 1e-4);
        // Solar models take 0.119 and 0.120 per cm of ozone at 593 and 610 nm (Bird and Riordan 1986, Table 1); such
        // measured coefficients are uncertain to 10 to 20 % as spectrophotometry of the sun found.
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
    fn aerosol_is_said_by_its_depth_at_any_wavelength_or_by_visibility() {
        let mut scene = Scene::preset(Preset::Standard);
        let height = scene.atmosphere.aerosol.scale_height;
        scene.atmosphere.aerosol.optical_depth = scene.optical_depth_from(0.2, 500.0);
        assert_close(at(&scene, 500.0).aerosol_extinction * height, 0.2, 1e-12);
        scene.atmosphere.aerosol.optical_depth = scene.optical_depth_from_visibility(23.0).unwrap();
        let extinction = at(&scene, 550.0).air_scattering + at(&scene, 550.0).aerosol_extinction;
        assert_close((-extinction * 23.0).exp(), 0.02, 1e-9);
        // Air scatters 0.0971/8 km⁻¹ at 550 nm and the ground (Bodhaine et al. 1999, over the scale height).
        let farthest = scene.optical_depth_from_visibility(1e3).unwrap_err().to_string();
        assert!(farthest.contains("visibility is 1000") && farthest.contains("at most 322 km"), "{farthest}");
        assert!(
            scene.optical_depth_from_visibility(0.0).is_err() && scene.optical_depth_from_visibility(f64::NAN).is_err()
        );
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
