//! The downwelling irradiance of the sky and of its sun, wavelength by wavelength.

use serde::Serialize;
use sorairo_shared::glam::DVec3;

use crate::error::Result;
use crate::measure::spectrum::{Method, Spectra};
use crate::measure::surface::irradiances_on;
use crate::plan::picture::sun_disc::Sun;
use crate::plan::{Sky, SkyPlan};

/// Irradiance at the observer by the sky, the sun and the ground, by wavelength (W·m⁻²·nm⁻¹; relative with the flat
/// sun).
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SpectralIrradiance {
    /// The wavelengths (nm).
    pub wavelength_nm: Vec<f64>,
    /// Diffuse irradiance, by the sky without the sun, on a level surface.
    pub irradiance_w_m2_nm: Vec<f64>,
    /// Direct irradiance, by the sun, on the same surface.
    pub direct_irradiance_w_m2_nm: Vec<f64>,
    /// Irradiance of a level surface that faces down, by the ground and the air in front of it.
    pub ground_irradiance_w_m2_nm: Vec<f64>,
    /// Irradiance of a surface that faces the sun, by the sun.
    pub sun_irradiance_w_m2_nm: Vec<f64>,
}

impl Sky {
    /// Irradiance of a level [`Surface`](crate::Surface) that faces up, and of one that faces down, at wavelengths
    /// (nm).
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`](crate::Error::NotAllowed) for a wavelength at which the scene has no data.
    pub fn spectral_light(&self, wavelengths: &[f64]) -> Result<SpectralIrradiance> {
        let spectra = Spectra::new(self.plan(), wavelengths, Method::Fit)?;
        Ok(SpectralIrradiance::by(&spectra, self.plan(), &Sun::at(self.plan(), wavelengths), wavelengths))
    }
}

impl SpectralIrradiance {
    /// That of a sky by spectra and a sun at these wavelengths.
    pub(crate) fn by(spectra: &Spectra, sky: &SkyPlan, sun: &Sun<'_>, wavelengths: &[f64]) -> Self {
        let mut sides = irradiances_on(&[DVec3::Z, -DVec3::Z], sky, spectra, sun);
        let (down, up) = (sides.remove(1), sides.remove(0));
        Self {
            wavelength_nm: wavelengths.to_vec(),
            irradiance_w_m2_nm: up.diffuse,
            direct_irradiance_w_m2_nm: up.direct,
            ground_irradiance_w_m2_nm: down.ground,
            sun_irradiance_w_m2_nm: sun.spectral_irradiance(|_| 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, SunSpectrum};
    use crate::spectra::observer;

    #[test]
    fn its_sum_over_the_observers_wavelengths_is_the_irradiance() {
        for sun in [40.0, 3.0, -3.0] {
            let mut scene = Scene::default().in_closed_form();
            scene.sun.elevation = sun;
            // Of its own spectrum sums take means, and of gases.
            scene.sun.spectrum = SunSpectrum::Flat;
            let sky = Sky::new(&scene).unwrap();
            let (light, spectral) = (sky.light(), sky.spectral_light(&observer::wavelengths()).unwrap());
            let sum = |values: &[f64]| -> f64 {
                values.iter().zip(&spectral.wavelength_nm).map(|(value, &nm)| value * observer::width(nm)).sum()
            };
            for (found, expected) in [
                (sum(&spectral.irradiance_w_m2_nm), light.irradiance_w_m2),
                (sum(&spectral.direct_irradiance_w_m2_nm), light.direct_irradiance_w_m2),
                (sum(&spectral.ground_irradiance_w_m2_nm), light.ground_irradiance_w_m2),
                (sum(&spectral.sun_irradiance_w_m2_nm), light.sun_irradiance_w_m2),
            ] {
                // The same terms in another order.
                assert!((found - expected).abs() <= 1e-9 * expected, "sun at {sun}: {found}, not {expected}");
            }
            assert!(light.irradiance_w_m2 > 0.0 && (light.sun_irradiance_w_m2 > 0.0) == (sun > 0.0), "{light:?}");
        }
    }

    #[test]
    fn a_night_throws_no_light_at_any_wavelength() {
        let mut scene = Scene::default();
        scene.sun.elevation = -30.0;
        let sky = Sky::new(&scene).unwrap();
        let light = sky.spectral_light(&[450.0, 550.0]).unwrap();
        assert_eq!((light.irradiance_w_m2_nm, light.sun_irradiance_w_m2_nm), (vec![0.0; 2], vec![0.0; 2]));
    }
}
