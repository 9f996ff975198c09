//! A complete scene, and its presets.

use documented::DocumentedFields;
use serde::{Deserialize, Serialize};
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

use super::aerosol::clean_country;
use super::camera::CameraScene;
use super::orders::Orders;
use super::settings::Render;
use super::sky::{AtmosphereScene, Ground, Observer, Site, Sun};
use crate::medium::aerosol::AerosolKind;
use crate::medium::profile::Profile;
use crate::spectra::choice::{AirSpectrum, AlbedoSpectrum, GroundAlbedo, SunSpectrum};

/// A complete description of one sky, read from TOML. Every key has a default, that of the preset.
///
/// A scene starts as that of a preset; its keys override values. The preset cannot be changed afterwards:
///
/// ```
/// use sorairo::{Preset, Scene};
///
/// let mut scene = Scene::preset(Preset::Hazy);
/// scene.sun.elevation = 8.0;
/// assert!(scene.atmosphere.aerosol.optical_depth > Scene::default().atmosphere.aerosol.optical_depth);
/// ```
///
/// ```compile_fail,E0616
/// # use sorairo::{Preset, Scene};
/// let mut scene = Scene::default();
/// scene.preset = Preset::Hazy; // would leave the air as clean as it is
/// ```
///
/// [`Scene::parse`] and [`Scene::read`] apply presets too. The implementation of serde reads only scenes that it wrote,
/// in which no key is missing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Scene {
    /// Named atmosphere that supplies the value of every key that is not given.
    pub(crate) preset: Preset,
    /// The sun: position and spectrum.
    pub sun: Sun,
    /// The observer.
    pub observer: Observer,
    /// Where the ground is.
    pub site: Site,
    /// The planet and what surrounds it.
    pub atmosphere: AtmosphereScene,
    /// The ground.
    pub ground: Ground,
    /// The camera.
    pub camera: CameraScene,
    /// How to render.
    pub render: Render,
}

/// A named atmosphere.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
#[non_exhaustive]
pub enum Preset {
    /// Measured: US Standard Atmosphere with ozone, water vapour and refraction, clean continental aerosol, over grass.
    #[default]
    Standard,
    /// The Earth's atmosphere with the constants of Bruneton and Neyret: air 7 to 14 % thicker, hardly any aerosol.
    Earth,
    /// The setting of Takahashi and Dobashi: no ozone, a solar irradiance of 1 at every wavelength.
    Paper,
    /// Polluted continental air in summer: much aerosol, with absorption as a tenth of its extinction.
    Hazy,
    /// Clean air, seen from an altitude of 3 km.
    Mountain,
    /// Mars on a clear day, seen from the ground.
    Mars,
    /// The Earth's atmosphere without ozone.
    NoOzone,
}

impl Default for Scene {
    fn default() -> Self {
        Self::preset(Preset::default())
    }
}

impl Scene {
    /// The scene of a preset.
    pub fn preset(preset: Preset) -> Self {
        let mut scene = Self {
            preset,
            sun: Sun::default(),
            observer: Observer::default(),
            site: Site::default(),
            atmosphere: AtmosphereScene::default(),
            ground: Ground::default(),
            camera: CameraScene::default(),
            render: Render::default(),
        };
        match preset {
            Preset::Standard => standard(&mut scene),
            Preset::Earth => {}
            Preset::Paper => paper(&mut scene),
            Preset::Hazy => hazy(&mut scene),
            Preset::Mountain => mountain(&mut scene),
            Preset::Mars => mars(&mut scene),
            Preset::NoOzone => scene.atmosphere.ozone.column = 0.0,
        }
        scene
    }

    /// The preset as which the scene began.
    pub fn began_as(&self) -> Preset {
        self.preset
    }

    /// The same scene in air whose densities have a closed form and leave sunlight straight, with aerosol by its
    /// numbers, as thick as before at 550 nm.
    #[must_use]
    ///
    /// # Panics
    ///
    /// If it lists several aerosols.
    pub fn in_closed_form(mut self) -> Self {
        assert!(self.atmosphere.aerosol.modes.is_empty(), "one aerosol has a closed form");
        let aerosol = &self.atmosphere.aerosol;
        let at_550 = aerosol.optical_depth / self.optical_depth_from(1.0, 550.0);
        self.atmosphere.aerosol.kind = AerosolKind::Plain;
        self.atmosphere.aerosol.optical_depth = self.optical_depth_from(at_550, 550.0);
        (self.atmosphere.profile, self.atmosphere.refraction) = (Profile::Exponential, false);
        self
    }

    /// The same scene in light of one order over black ground, as the paper has it.
    #[must_use]
    pub fn first_order(mut self) -> Self {
        self.render.orders = Orders::UpTo(1);
        self.ground.albedo = GroundAlbedo::Grey(0.0);
        self
    }
}

/// The Earth's atmosphere as it is measured.
///
/// * Air: US Standard Atmosphere 1976; its optical depth at sea level, 0.0971 at 550 nm, its dispersion and
///   depolarisation (Bodhaine et al. 1999, DOI 10.1175/1520-0426(1999)016<1854:ORODC>2.0.CO;2). It bends sunlight.
/// * Gases: 300 Dobson units of ozone, 1.4 cm of water, pairs of oxygen and nitrogen dioxide as that atmosphere has
///   them.
/// * Aerosol: OPAC's *continental clean* at a relative humidity of 80 %, that of the country far from cities (Hess,
///   Koepke and Schult 1998, DOI 10.1175/1520-0477(1998)079<0831:OPOAAC>2.0.CO;2): optical depth 0.064 at 550 nm; a
///   scale height of 2 km, the depth of its layer.
/// * Sun: TSIS-1 HSRS (Coddington et al. 2021, DOI 10.1029/2020GL091709).
/// * Ground: grass.
///
/// Beside them stand the numbers that describe the same air in closed form, with a scale height of 8 km, and the same
/// aerosol plainly. They hold where a key says so.
fn standard(scene: &mut Scene) {
    let atmosphere = &mut scene.atmosphere;
    atmosphere.profile = Profile::UsStandard;
    atmosphere.refraction = true;
    atmosphere.air.spectrum = AirSpectrum::Bodhaine;
    // 0.00864052 at 1 µm.
    atmosphere.air.scattering = 1.080_065e-3;
    clean_country(&mut atmosphere.aerosol);
    atmosphere.aerosol.kind = AerosolKind::ContinentalClean;
    // 0.064 at 550 nm by the spectrum of this kind.
    atmosphere.aerosol.optical_depth = 0.026133;
    scene.sun.spectrum = SunSpectrum::Tsis1;
    scene.ground.albedo = GroundAlbedo::Grass;
}

/// Takahashi and Dobashi, *Full-spectrum rendering of the sky using GPU*: light of one order over black ground, no
/// ozone, a sun of 1 at every wavelength.
fn paper(scene: &mut Scene) {
    scene.render.orders = Orders::UpTo(1);
    scene.ground.albedo = GroundAlbedo::Grey(0.0);
    scene.sun.spectrum = SunSpectrum::Flat;
    scene.atmosphere.ozone.column = 0.0;
}

/// The *continental polluted* aerosol of OPAC at a relative humidity of 80 % (Hess, Koepke and Schult 1998, DOI
/// 10.1175/1520-0477(1998)079<0831:OPOAAC>2.0.CO;2): optical depth 0.327, single-scattering albedo 0.892 and asymmetry
/// 0.698 at 550 nm. The Ångström exponent 1.3 lies between those that OPAC gives below and above 500 nm.
fn hazy(scene: &mut Scene) {
    scene.ground.albedo = GroundAlbedo::Grass;
    let aerosol = &mut scene.atmosphere.aerosol;
    aerosol.angstrom_exponent = 1.3;
    // 0.327 at 550 nm.
    aerosol.optical_depth = 0.150;
    aerosol.single_scattering_albedo = 0.892;
    aerosol.asymmetry = 0.698;
}

/// From 3 km above the sea. The aerosol below and above the observer is clean: 0.064 of optical depth at 550 nm over
/// the sea, single-scattering albedo 0.972 and asymmetry 0.709 are those of OPAC's *continental clean* (Hess, Koepke
/// and Schult 1998). With a scale height of 2 km 0.014 of it lie above the observer, about what is measured at Mauna
/// Loa, at 3.4 km: a yearly mean of 0.02 at 500 nm (Holben et al. 2001, DOI 10.1029/2001JD900014).
fn mountain(scene: &mut Scene) {
    scene.observer.altitude = 3.0;
    clean_country(&mut scene.atmosphere.aerosol);
}

/// Mars on a clear day.
///
/// * Ground radius 3389.5 km, scale height 11.1 km, surface pressure near 610 Pa, mean distance 1.524 au: NASA's Mars
///   fact sheet (Williams, NSSDCA).
/// * Air: 610 Pa of carbon dioxide has 1.06 % of the molecules of the Earth's, each of which scatters 2.59 times as
///   much as one of air (Bodhaine et al. 1999, Eq. 22, DOI 10.1175/1520-0426(1999)016<1854:ORODC>2.0.CO;2): an optical
///   depth of 0.00267 at 550 nm.
/// * Dust: optical depth 0.5, of a day without a storm (Tomasko et al. 1999, DOI 10.1029/1998JE900016); grey, because
///   its particles are larger than the wavelength; well mixed, hence 11 km (Vincendon and Langevin 2010 find 6 to 12
///   km, DOI 10.1016/j.icarus.2009.12.018); asymmetry 0.69 (Chen-Chen et al. 2019, DOI 10.1016/j.icarus.2019.04.004);
///   albedo by wavelength of Wolff et al. 2009 (DOI 10.1029/2009JE003350).
/// * Ground: the planet's Bond albedo, 0.25 (NASA's fact sheet).
fn mars(scene: &mut Scene) {
    scene.sun.distance = 1.524;
    scene.ground.albedo = GroundAlbedo::Grey(0.25);
    let atmosphere = &mut scene.atmosphere;
    atmosphere.ground_radius = 3389.5;
    atmosphere.top_radius = 3499.5;
    // 0.00267 at 550 nm.
    atmosphere.air.scattering = 2.2e-5;
    atmosphere.air.scale_height = 11.1;
    atmosphere.aerosol.optical_depth = 0.5;
    atmosphere.aerosol.angstrom_exponent = 0.0;
    atmosphere.aerosol.scale_height = 11.0;
    atmosphere.aerosol.single_scattering_albedo_spectrum = AlbedoSpectrum::MarsDust;
    atmosphere.aerosol.asymmetry = 0.69;
    atmosphere.ozone.column = 0.0;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_those_of_the_design() {
        for preset in [Preset::Standard, Preset::Earth] {
            let scene = Scene::preset(preset);
            assert_eq!(scene.atmosphere.ozone.column, 300.0);
            let sun = if preset == Preset::Earth { SunSpectrum::AstmG173 } else { SunSpectrum::Tsis1 };
            assert_eq!(scene.sun.spectrum, sun);
            assert_eq!(scene.render.orders, Orders::All);
        }
        let paper = Scene::preset(Preset::Paper);
        assert_eq!(paper.atmosphere.ozone.column, 0.0);
        assert_eq!((paper.render.orders, &paper.ground.albedo), (Orders::UpTo(1), &GroundAlbedo::Grey(0.0)));
        assert_eq!(paper.sun.spectrum, SunSpectrum::Flat);
    }
}
