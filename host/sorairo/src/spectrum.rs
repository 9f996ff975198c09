//! The spectrum of the sky in one direction.

use serde::Serialize;
use sorairo_shared::fit::SPECTRUM_RISE;
use sorairo_shared::glam::{Vec2, Vec3};
use sorairo_shared::phase::{ScatteringAngle, cornette_shanks_phase, rayleigh_phase};
use sorairo_shared::single::{Bands, SingleScattering, single_scattering};
use sorairo_shared::sky::{transfer, view_ray};
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant::ABOVE_TOP;

use crate::error::{Error, Result, check_range};
use crate::plan::quadrature::gauss_legendre;
use crate::plan::regression::{Constituent, DARKEST, Regression};
use crate::plan::{Plan, SpectralFit, bands, direction};

/// Samples on each piece of a ray for the dense spectrum: enough for 1e-5 in twilight, where the ozone tent's edges slow
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
pub fn spectrum(plan: &Plan, elevation: f64, azimuth: f64, wavelengths: &[f64]) -> Result<Vec<Sample>> {
    check_range("view_elevation", elevation, (-90.0, 90.0), "degrees")?;
    check_range("view_azimuth", azimuth, (-360.0, 360.0), "degrees")?;
    let (shortest, longest) = plan.optics.known_wavelengths();
    if let Some(outside) = wavelengths.iter().find(|&&wavelength| !(shortest..=longest).contains(&wavelength)) {
        let complaint = format!("holds {outside}; wavelengths must lie between {shortest} and {longest} nm");
        return Err(Error::not_allowed("wavelengths", complaint));
    }
    let view = direction(elevation, azimuth).as_vec3();
    let fitted = FittedSpectrum::new(plan, wavelengths).radiance(view);
    let dense = DenseSpectrum::new(plan, wavelengths).radiance(view);
    let samples = wavelengths.iter().zip(fitted).zip(dense);
    let sample = |((&wavelength_nm, radiance), dense): ((&f64, f64), f64)| {
        // A polynomial can pass below zero between its bands; light cannot.
        Sample { wavelength_nm, radiance: radiance.max(0.0), dense }
    };
    Ok(samples.map(sample).collect())
}

/// The spectrum that a plan's bands and fit give, at fixed wavelengths.
pub struct FittedSpectrum<'a> {
    plan: &'a Plan,
    wavelengths: &'a [f64],
    /// Those of air and of aerosol, made for these very wavelengths; empty for a linear fit.
    regressions: Vec<(Constituent, Vec<Regression>)>,
}

impl<'a> FittedSpectrum<'a> {
    /// Prepares the spectrum at wavelengths in nm.
    pub fn new(plan: &'a Plan, wavelengths: &'a [f64]) -> Self {
        let regressions = match plan.fit {
            SpectralFit::Linear(_) => Vec::new(),
            SpectralFit::Regression => [Constituent::Air, Constituent::Aerosol]
                .map(|constituent| (constituent, plan.training().regressions(constituent, wavelengths)))
                .into(),
        };
        Self { plan, wavelengths, regressions }
    }

    /// Radiance at each wavelength in a direction (W·m⁻²·sr⁻¹·nm⁻¹).
    pub fn radiance(&self, view: Vec3) -> Vec<f64> {
        let SpectralFit::Linear(fit) = &self.plan.fit else { return self.by_regression(view) };
        let Plan { uniform, bands, quadrature, optics, variant, .. } = self.plan;
        let at_bands: Vec<f64> = bands
            .iter()
            .flat_map(|group| transfer(uniform, group, quadrature, view, *variant).to_array().map(f64::from))
            .take(self.plan.wavelengths.len())
            .collect();
        self.wavelengths.iter().map(|&wavelength| fit.radiance(optics, &at_bands, wavelength)).collect()
    }

    fn by_regression(&self, view: Vec3) -> Vec<f64> {
        let Plan { uniform, bands, quadrature, optics, variant, .. } = self.plan;
        let ray = view_ray(uniform, view);
        let scattered: Vec<SingleScattering> = bands
            .iter()
            .map(|group| single_scattering(&uniform.atmosphere, group, quadrature, ray, *variant))
            .collect();
        let mut transfer = vec![0.0; self.wavelengths.len()];
        for (constituent, regressions) in &self.regressions {
            let at_bands: Vec<f64> = scattered
                .iter()
                .flat_map(|group| constituent.of(group).to_array().map(f64::from))
                .take(self.plan.wavelengths.len())
                .collect();
            if at_bands.iter().all(|&value| value == 0.0) {
                continue;
            }
            let logarithms: Vec<f64> = at_bands.iter().map(|value| value.max(DARKEST).ln()).collect();
            let phase = f64::from(match constituent {
                Constituent::Air => rayleigh_phase(ray.nu),
                Constituent::Aerosol => {
                    cornette_shanks_phase(ScatteringAngle::of_ray(ray), uniform.atmosphere.aerosol_asymmetry)
                }
            });
            let highest = at_bands.iter().copied().fold(DARKEST, f64::max) * f64::from(SPECTRUM_RISE).exp();
            for (sum, regression) in transfer.iter_mut().zip(regressions) {
                *sum += phase * regression.value(&logarithms).min(highest);
            }
        }
        let lit = transfer.iter().zip(self.wavelengths);
        lit.map(|(transfer, &wavelength)| transfer * optics.solar_irradiance(wavelength)).collect()
    }
}

/// The spectrum integrated at every one of its wavelengths with [`DENSE_STEPS`] samples: the reference of every fit.
pub struct DenseSpectrum {
    uniform: Uniform,
    variant: u32,
    groups: Vec<Bands>,
    quadrature: Vec<Vec2>,
    irradiance: Vec<f64>,
}

impl DenseSpectrum {
    /// Prepares the spectrum at wavelengths in nm.
    pub fn new(plan: &Plan, wavelengths: &[f64]) -> Self {
        Self {
            uniform: plan.uniform,
            variant: plan.variant | ABOVE_TOP,
            groups: bands(&plan.optics, wavelengths),
            quadrature: gauss_legendre(DENSE_STEPS),
            irradiance: wavelengths.iter().map(|&wavelength| plan.optics.solar_irradiance(wavelength)).collect(),
        }
    }

    /// Radiance at each wavelength in a direction (W·m⁻²·sr⁻¹·nm⁻¹).
    pub fn radiance(&self, view: Vec3) -> Vec<f64> {
        let Self { uniform, quadrature, variant, .. } = self;
        let transfer = |group: &Bands| transfer(uniform, group, quadrature, view, *variant).to_array().map(f64::from);
        self.groups.iter().flat_map(transfer).zip(&self.irradiance).map(|(t, irradiance)| t * irradiance).collect()
    }
}
