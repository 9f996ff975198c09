//! The spectrum of the sky in one direction.

use serde::Serialize;
use sorairo_shared::fit::SPECTRUM_RISE;
use sorairo_shared::glam::Vec3;
use sorairo_shared::variant::ABOVE_TOP;

use crate::error::{Error, Result, check_range};
use crate::plan::fit::SpectralFit;
use crate::plan::fit::regression::Regression;
use crate::plan::fit::training::DARKEST;
use crate::plan::integral::{Constituent, RayIntegral};
use crate::plan::quadrature::gauss_legendre;
use crate::plan::upload::bands;
use crate::plan::{SkyPlan, direction};

/// Samples per piece for the dense spectrum: enough for 1e-5 in twilight, where the ozone tent's edges slow
/// the convergence.
pub const DENSE_STEPS: u32 = 512;

/// Radiance at one wavelength.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sample {
    /// Wavelength (nm).
    pub wavelength_nm: f64,
    /// What the bands and the fit give, and at least 0 (W·m⁻²·sr⁻¹·nm⁻¹).
    pub radiance: f64,
    /// The integral at this very wavelength, at high accuracy (W·m⁻²·sr⁻¹·nm⁻¹).
    pub dense: f64,
}

/// The spectrum towards an elevation and an azimuth (degrees, clockwise from north) at wavelengths in nm.
///
/// # Errors
///
/// [`Error::OutOfRange`] for a direction, [`Error::NotAllowed`] for a wavelength out of range.
pub fn spectrum(sky: &SkyPlan, elevation: f64, azimuth: f64, wavelengths: &[f64]) -> Result<Vec<Sample>> {
    check_range("view_elevation", elevation, (-90.0, 90.0), "degrees")?;
    check_range("view_azimuth", azimuth, (-360.0, 360.0), "degrees")?;
    let (shortest, longest) = sky.integral.optics.known_wavelengths();
    if let Some(outside) = wavelengths.iter().find(|&&wavelength| !(shortest..=longest).contains(&wavelength)) {
        let complaint = format!("holds {outside}; wavelengths must lie between {shortest} and {longest} nm");
        return Err(Error::not_allowed("wavelengths", complaint));
    }
    let view = direction(elevation, azimuth).as_vec3();
    let fitted = FittedSpectrum::new(sky, wavelengths).radiance(view);
    let dense = DenseSpectrum::new(sky, wavelengths).radiance(view);
    let samples = wavelengths.iter().zip(fitted).zip(dense);
    let sample = |((&wavelength_nm, radiance), dense): ((&f64, f64), f64)| {
        // A polynomial can pass below zero between its bands; light cannot.
        Sample { wavelength_nm, radiance: radiance.max(0.0), dense }
    };
    Ok(samples.map(sample).collect())
}

/// The spectrum that a sky's bands and fit give, at fixed wavelengths.
pub struct FittedSpectrum<'a> {
    sky: &'a SkyPlan,
    wavelengths: &'a [f64],
    /// Those of each constituent, made for these very wavelengths; empty for a linear fit.
    regressions: Vec<(Constituent, Vec<Regression>)>,
}

impl<'a> FittedSpectrum<'a> {
    /// Prepares the spectrum at wavelengths in nm.
    pub fn new(sky: &'a SkyPlan, wavelengths: &'a [f64]) -> Self {
        let training = sky.training();
        let regressions = match sky.fit {
            SpectralFit::Linear(_) => Vec::new(),
            SpectralFit::Regression => training.regressions(wavelengths),
        };
        Self { sky, wavelengths, regressions }
    }

    /// Radiance at each wavelength in a direction (W·m⁻²·sr⁻¹·nm⁻¹).
    pub fn radiance(&self, view: Vec3) -> Vec<f64> {
        let SpectralFit::Linear(fit) = &self.sky.fit else { return self.by_regression(view) };
        let integral = &self.sky.integral;
        let at_bands = integral.transfer(view);
        self.wavelengths.iter().map(|&wavelength| fit.radiance(&integral.optics, &at_bands, wavelength)).collect()
    }

    fn by_regression(&self, view: Vec3) -> Vec<f64> {
        let integral = &self.sky.integral;
        let (light, phases) = (integral.light(view), integral.phases(view));
        let mut transfer = vec![0.0; self.wavelengths.len()];
        for (constituent, regressions) in &self.regressions {
            let at_bands = integral.at_bands(light.iter().map(|&group| constituent.of(group)));
            if at_bands.iter().all(|&value| value == 0.0) {
                continue;
            }
            let logarithms: Vec<f64> = at_bands.iter().map(|value| value.max(DARKEST).ln()).collect();
            let phase = f64::from(constituent.of(phases));
            let highest = at_bands.iter().copied().fold(DARKEST, f64::max) * f64::from(SPECTRUM_RISE).exp();
            for ((sum, regression), &wavelength) in transfer.iter_mut().zip(regressions).zip(self.wavelengths) {
                let albedo = constituent.albedo(&integral.optics, wavelength);
                *sum += phase * albedo * regression.value(&logarithms).min(highest);
            }
        }
        let lit = transfer.iter().zip(self.wavelengths);
        lit.map(|(transfer, &wavelength)| transfer * integral.optics.solar_irradiance(wavelength)).collect()
    }
}

/// The spectrum integrated at every one of its wavelengths with [`DENSE_STEPS`] samples: the reference of every fit.
pub struct DenseSpectrum {
    integral: RayIntegral,
    irradiance: Vec<f64>,
}

impl DenseSpectrum {
    /// Prepares the spectrum at wavelengths in nm.
    pub fn new(sky: &SkyPlan, wavelengths: &[f64]) -> Self {
        let optics = &sky.integral.optics;
        let integral = RayIntegral {
            wavelengths: wavelengths.to_vec(),
            bands: bands(optics, wavelengths),
            quadrature: gauss_legendre(DENSE_STEPS),
            variant: sky.integral.variant | ABOVE_TOP,
            ..sky.integral.clone()
        };
        Self {
            integral: integral.with_multiple_light(),
            irradiance: wavelengths.iter().map(|&wavelength| optics.solar_irradiance(wavelength)).collect(),
        }
    }

    /// Radiance at each wavelength in a direction (W·m⁻²·sr⁻¹·nm⁻¹).
    pub fn radiance(&self, view: Vec3) -> Vec<f64> {
        self.integral.transfer(view).iter().zip(&self.irradiance).map(|(t, irradiance)| t * irradiance).collect()
    }
}
