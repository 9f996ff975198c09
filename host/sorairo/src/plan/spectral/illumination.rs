//! From the light at some bands to radiance: the solar irradiance and the ground that light is relative to.

use sorairo_shared::fit::spectrum::SPECTRUM_RISE;
use sorairo_shared::glam::Vec3;
use sorairo_shared::sky::ByConstituent;

use crate::plan::fit::regression::Regression;
use crate::plan::fit::training::DARKEST;
use crate::plan::integral::{Constituent, RayIntegral};
use crate::spectra::optics::Optics;

/// The regressions of each constituent, one for each wavelength.
pub type Regressions = Vec<(Constituent, Vec<Regression>)>;

/// What light at some wavelengths is relative to.
#[derive(Clone, Debug)]
pub(crate) struct Illumination {
    /// Irradiance of the sun above the atmosphere (W·m⁻²·nm⁻¹).
    pub(crate) sun: Vec<f64>,
    /// The wavelengths (nm).
    pub(crate) wavelengths: Vec<f64>,
    /// What each constituent's light is multiplied with; see [`Constituent::albedo`].
    albedo: ByConstituent<Vec<f64>>,
}

impl Illumination {
    pub(crate) fn new(optics: &Optics, wavelengths: &[f64]) -> Self {
        let albedo = |of: Constituent| wavelengths.iter().map(|&nm| of.albedo(optics, nm)).collect();
        Self {
            wavelengths: wavelengths.to_vec(),
            sun: wavelengths.iter().map(|&nm| optics.solar_irradiance(nm)).collect(),
            albedo: ByConstituent {
                air: albedo(Constituent::Air),
                aerosol: albedo(Constituent::Aerosol),
                multiple: albedo(Constituent::Multiple),
                ground: albedo(Constituent::Ground),
            },
        }
    }

    pub(crate) fn albedo(&self, of: Constituent) -> &[f64] {
        let ByConstituent { air, aerosol, multiple, ground } = &self.albedo;
        of.of(ByConstituent { air, aerosol, multiple, ground })
    }
}

/// Radiance by regressions at their wavelengths in a direction, from the light of each constituent at the bands.
pub(crate) fn radiance(
    integral: &RayIntegral,
    illumination: &Illumination,
    regressions: &[(Constituent, Vec<Regression>)],
    view: Vec3,
    light: impl Fn(Constituent) -> Vec<f64>,
) -> Vec<f64> {
    let mut transfer = vec![0.0; illumination.sun.len()];
    for (constituent, regressions) in regressions {
        let at_bands = light(*constituent);
        if at_bands.iter().all(|&value| value == 0.0) {
            continue;
        }
        let logarithms: Vec<f64> = at_bands.iter().map(|value| value.max(DARKEST).ln()).collect();
        let phases = integral.phases_at(*constituent, view, &illumination.wavelengths);
        let highest = at_bands.iter().copied().fold(DARKEST, f64::max) * f64::from(SPECTRUM_RISE).exp();
        let factors = phases.iter().zip(illumination.albedo(*constituent)).map(|(phase, albedo)| phase * albedo);
        for ((sum, regression), factor) in transfer.iter_mut().zip(regressions).zip(factors) {
            *sum += factor * regression.value(&logarithms).min(highest);
        }
    }
    transfer.iter().zip(&illumination.sun).map(|(transfer, sun)| transfer * sun).collect()
}
