//! Broadband irradiance, from 280 to 2500 nm.

use serde::Serialize;
use sorairo_shared::glam::DVec3;

use crate::measure::spectrum::Spectra;
use crate::measure::surface::irradiances_on;
use crate::plan::picture::sun_disc::Sun;
use crate::plan::{Sky, SkyPlan};
use crate::spectra::range::RANGE_OF_BEAMS;

/// Irradiance through measured air between 280 and 2500 nm (W·m⁻²), by the names of solar energy. The range contains
/// 96 % of the solar irradiance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Broadband {
    /// Direct normal irradiance: from the sun's disc on a surface that faces it.
    pub dni_w_m2: f64,
    /// Diffuse horizontal irradiance: from the sky without the disc on a level surface.
    pub dhi_w_m2: f64,
    /// Global horizontal irradiance: the sum of both on a level surface.
    pub ghi_w_m2: f64,
    /// UV index: 40 m²/W times the global irradiance, weighted by the action spectrum of erythema (ISO/CIE 17166:2019).
    pub uv_index: f64,
    /// Photosynthetic photon flux density: photons of 400 to 700 nm on a level surface (µmol·m⁻²·s⁻¹).
    pub ppfd_umol_m2_s: f64,
}

/// The action spectrum of erythema at a wavelength (nm).
fn erythema(nm: f64) -> f64 {
    match nm {
        ..=298.0 => 1.0,
        ..=328.0 => 10f64.powf(0.094 * (298.0 - nm)),
        ..=400.0 => 10f64.powf(0.015 * (140.0 - nm)),
        _ => 0.0,
    }
}

/// Photons per joule of light at a wavelength (µmol·J⁻¹·nm⁻¹): `1 / (N_A h c)`.
const PHOTONS: f64 = 8.359_347e-3;

impl Sky {
    /// Irradiance from 280 to 2500 nm, the sum over every nanometre. `None` if the sky has no data in part of the
    /// range: see [`Scene::known_wavelengths_of_skies`](crate::Scene::known_wavelengths_of_skies).
    pub fn broadband(&self) -> Option<Broadband> {
        Broadband::new(self.plan())
    }
}

impl Broadband {
    pub(crate) fn new(sky: &SkyPlan) -> Option<Self> {
        let (first, last) = RANGE_OF_BEAMS;
        let wavelengths: Vec<f64> = (0..(last - first) as u32).map(|i| first + f64::from(i) + 0.5).collect();
        if sky.scene.known_wavelengths_of_skies() != (first, last) {
            return None;
        }
        let (spectra, sun) = (Spectra::for_sums(sky, &wavelengths)?, Sun::at(sky, &wavelengths));
        let level = irradiances_on(&[DVec3::Z], sky, &spectra, &sun).remove(0);
        let sum = |spectrum: &[f64]| spectrum.iter().sum::<f64>();
        let weighted = |weight: &dyn Fn(f64) -> f64| -> f64 {
            wavelengths.iter().zip(&level.global).map(|(&nm, global)| weight(nm) * global).sum()
        };
        let photosynthetic = |nm: f64| if (400.0..=700.0).contains(&nm) { nm * PHOTONS } else { 0.0 };
        Some(Self {
            dni_w_m2: sum(&sun.spectral_irradiance(|_| 1.0)),
            dhi_w_m2: sum(&level.diffuse),
            ghi_w_m2: sum(&level.global),
            uv_index: 40.0 * weighted(&erythema),
            ppfd_umol_m2_s: weighted(&photosynthetic),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{GroundAlbedo, Scene};

    fn sky(sun: f64, change: impl FnOnce(&mut Scene)) -> Sky {
        let mut scene = Scene::default();
        scene.sun.elevation = sun;
        change(&mut scene);
        Sky::new(&scene).unwrap()
    }

    #[test]
    fn ultraviolet_light_is_as_strong_as_its_published_formula() {
        // Madronich 2007, https://doi.org/10.1111/j.1751-1097.2007.00200.x: 12.5 cos(z)^2.42 (ozone / 300 DU)^-1.23 of
        // clear air over dark ground, within 10 % up to a zenith angle of 60°.
        for (sun, ozone) in [(90.0, 300.0), (60.0, 300.0), (40.0, 300.0), (60.0, 400.0), (60.0, 250.0)] {
            let sky = sky(sun, |scene| scene.atmosphere.ozone.column = ozone);
            let found = sky.broadband().unwrap().uv_index;
            let published = 12.5 * f64::to_radians(sun).sin().powf(2.42) * f64::powf(ozone / 300.0, -1.23);
            println!("sun at {sun}, {ozone} DU: {found:.2}, published {published:.2}");
            assert!((found / published - 1.0).abs() < 0.15, "sun at {sun}, {ozone} DU: {found}, {published}");
        }
    }

    #[test]
    fn parts_of_the_broadband_are_as_measured() {
        let found = sky(50.0, |_| {}).broadband().unwrap();
        // McCree 1972, https://doi.org/10.1016/0002-1571(72)90045-3: half of the sun's energy lies from 400 to 700 nm,
        // of 4.57 µmol/J.
        let photons = found.ppfd_umol_m2_s / found.ghi_w_m2;
        assert!((1.9..2.3).contains(&photons), "{found:?}");
        // The sun stands 0.013° higher than without air.
        let level = found.dhi_w_m2 + found.dni_w_m2 * 50.013f64.to_radians().sin();
        assert!((found.ghi_w_m2 - level).abs() < 0.2, "{found:?}");
        // Of 1309 W/m² above the air gases, air and aerosol leave two thirds to three quarters.
        assert!((870.0..980.0).contains(&found.dni_w_m2), "{found:?}");
    }

    #[test]
    fn a_night_has_no_broadband_light_and_snow_none_that_is_known() {
        assert_eq!(sky(-30.0, |_| {}).broadband(), Some(Broadband::default()));
        assert_eq!(sky(30.0, |scene| scene.ground.albedo = GroundAlbedo::Snow).broadband(), None);
        assert_eq!(sky(30.0, |scene| *scene = scene.clone().in_closed_form()).broadband(), None);
    }
}
