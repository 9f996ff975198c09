//! The spectrum of the sky in one direction.

use serde::Serialize;
use sorairo_shared::atmosphere::{cornette_shanks_phase, rayleigh_phase};
use sorairo_shared::glam::Vec3;
use sorairo_shared::scattering::{SingleScattering, single_scattering};
use sorairo_shared::sky::{transfer, view_ray};
use sorairo_shared::variant;

use crate::error::{Error, Result};
use crate::plan::learnt::{Constituent, DARKEST};
use crate::plan::quadrature::gauss_legendre;
use crate::plan::{Plan, SpectralFit, bands, direction};
use crate::tables::MEASURED_RANGE;

/// Samples on each piece of a ray for the dense spectrum: enough for 1e-5 in twilight, where the ozone tent's edges slow
/// the convergence.
const DENSE_STEPS: u32 = 512;

/// Radiance at one wavelength.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sample {
    /// Wavelength (nm).
    pub wavelength_nm: f64,
    /// What the four bands and the fit give (W·m⁻²·sr⁻¹·nm⁻¹).
    pub radiance: f64,
    /// The integral at this very wavelength, at high accuracy (W·m⁻²·sr⁻¹·nm⁻¹).
    pub dense: f64,
}

/// The spectrum towards an elevation and an azimuth (degrees, clockwise from north) at wavelengths in nm.
///
/// # Errors
///
/// [`Error::Request`] for a direction or a wavelength out of range.
pub fn spectrum(plan: &Plan, elevation: f64, azimuth: f64, wavelengths: &[f64]) -> Result<Vec<Sample>> {
    for (flag, value, limit) in [("--view-elevation", elevation, 90.0), ("--view-azimuth", azimuth, 360.0)] {
        if !(-limit..=limit).contains(&value) {
            return Err(Error::request(format!("{flag} is {value}; it must lie between -{limit} and {limit} degrees")));
        }
    }
    let (shortest, longest) = MEASURED_RANGE;
    if let Some(outside) = wavelengths.iter().find(|&&wavelength| !(shortest..=longest).contains(&wavelength)) {
        return Err(Error::request(format!(
            "--wavelengths holds {outside}; wavelengths must lie between {shortest} and {longest} nm"
        )));
    }
    let view = direction(elevation, azimuth).as_vec3();
    let fitted = fitted_spectrum(plan, view, wavelengths);
    let quadrature = gauss_legendre(DENSE_STEPS);
    let dense = bands(&plan.optics, wavelengths).into_iter().flat_map(|group| {
        transfer(&plan.frame, &group, &quadrature, view, plan.variant | variant::ABOVE_TOP).to_array().map(f64::from)
    });
    let samples = wavelengths.iter().zip(fitted).zip(dense).map(|((&wavelength, radiance), dense)| Sample {
        wavelength_nm: wavelength,
        radiance,
        dense: dense * plan.optics.solar_irradiance(wavelength),
    });
    Ok(samples.collect())
}

/// Radiance at wavelengths (nm) in a direction, by the plan's bands and fit.
fn fitted_spectrum(plan: &Plan, view: Vec3, wavelengths: &[f64]) -> Vec<f64> {
    let SpectralFit::Linear(fit) = &plan.fit else { return learnt_spectrum(plan, view, wavelengths) };
    let at_bands: Vec<f64> = plan
        .bands
        .iter()
        .flat_map(|group| transfer(&plan.frame, group, &plan.quadrature, view, plan.variant).to_array().map(f64::from))
        .take(plan.wavelengths.len())
        .collect();
    wavelengths.iter().map(|&wavelength| fit.radiance(&plan.optics, &at_bands, wavelength)).collect()
}

/// [`fitted_spectrum`] by the learnt fit, whose regression is made for these very wavelengths.
fn learnt_spectrum(plan: &Plan, view: Vec3, wavelengths: &[f64]) -> Vec<f64> {
    let ray = view_ray(&plan.frame, view);
    let scattered: Vec<SingleScattering> = plan
        .bands
        .iter()
        .map(|group| single_scattering(&plan.frame.atmosphere, group, &plan.quadrature, ray, plan.variant))
        .collect();
    let phases = [
        (Constituent::Air, rayleigh_phase(ray.nu)),
        (Constituent::Aerosol, cornette_shanks_phase(ray.nu, plan.frame.atmosphere.aerosol_asymmetry)),
    ];
    let mut transfer = vec![0.0; wavelengths.len()];
    for (constituent, phase) in phases {
        let at_bands: Vec<f64> = scattered
            .iter()
            .flat_map(|group| constituent.of(group).to_array().map(f64::from))
            .take(plan.wavelengths.len())
            .collect();
        if at_bands.iter().all(|&value| value == 0.0) {
            continue;
        }
        let logarithms: Vec<f64> = at_bands.iter().map(|value| value.max(DARKEST).ln()).collect();
        let regressions = plan.training().regressions(constituent, wavelengths);
        for (sum, regression) in transfer.iter_mut().zip(regressions) {
            *sum += f64::from(phase) * regression.value(&logarithms);
        }
    }
    transfer.iter().zip(wavelengths).map(|(t, &wavelength)| t * plan.optics.solar_irradiance(wavelength)).collect()
}

/// Wavelengths (nm) written as `START:END:STEP` or as a list with commas.
///
/// # Errors
///
/// A sentence that says what is allowed.
pub fn parse_wavelengths(text: &str) -> std::result::Result<Vec<f64>, String> {
    const MOST: f64 = 100_000.0;
    let allowed = || {
        format!(
            "wavelengths are START:END:STEP (START <= END, STEP > 0, at most {MOST} steps) or a list such as 450,550,650 \
             in nm, not {text:?}"
        )
    };
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite()).ok_or_else(allowed);
    if text.contains(':') {
        let parts: Vec<f64> = text.split(':').map(number).collect::<std::result::Result<_, _>>()?;
        let [start, end, step] = parts[..] else { return Err(allowed()) };
        if step <= 0.0 || end < start || (end - start) / step > MOST {
            return Err(allowed());
        }
        // Half a thousandth of a step lets the end be reached in spite of rounding.
        let count = ((end - start) / step + 5e-4).floor() as u32;
        return Ok((0..=count).map(|i| (start + step * f64::from(i)).min(end)).collect());
    }
    text.split(',').map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wavelengths_are_a_range_or_a_list() {
        assert_eq!(parse_wavelengths("380:780:5").unwrap().len(), 81);
        assert_eq!(parse_wavelengths("380:780:0.1").unwrap().len(), 4001);
        assert_eq!(parse_wavelengths("450, 550").unwrap(), [450.0, 550.0]);
        // The last sum rounds to more than the end.
        let range = parse_wavelengths("360.1:830:0.1").unwrap();
        assert_eq!((range.len(), range[range.len() - 1]), (4700, 830.0));
        for bad in ["", "a", "1:2", "400:300:5", "400:500:0", "400:500:-1", "0:1e9:1e-9", "NaN"] {
            assert!(parse_wavelengths(bad).is_err(), "{bad}");
        }
    }
}
