//! Spectra by the fit, over the skies that the Earth has: light of the first order against the oracle at every
//! wavelength, light of all orders against each wavelength integrated itself, which [`super::orders`] holds against the
//! oracle's paths.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use sorairo::Sky;
use sorairo_oracle::scattered_radiance_bands;

use super::orders::{random_scene, random_view, seen};
use super::outcome::{Outcome, generator};
use crate::judge;
use sorairo::low_level::plan::spectral::{BOUND_BY_DAY, BOUND_IN_TWILIGHT, FLOOR, SpectrumFit};
use sorairo::low_level::plan::{SkyPlan, SpectralPlan, direction};
use sorairo::low_level::spectrum::DenseSpectrum;
use sorairo::scene::{Fit, GroundAlbedo, Orders, Scene};

/// Spectra of a sky, in as many directions.
const OF_A_SKY: u64 = 20;

/// A spectrum fainter than this part of the brightest of its sky is judged relative to that: the integral keeps to its
/// own bound only down to there (see [`super::integral`]).
const FAINT: f64 = 1e-6;

/// A direction in a sky.
#[derive(Clone, Debug)]
struct Case {
    scene: Scene,
    /// Elevation and azimuth (degrees).
    view: (f64, f64),
    /// The wavelength (nm) at which the spectrum is worst.
    wavelength: f64,
    /// How far it is off there, over what is allowed.
    error: f64,
    /// Whether each wavelength was integrated, because rays said that a fit would not do.
    is_integrated: bool,
}

/// Compares spectra in random skies.
pub fn spectra(seed: u64, cases: u64) -> Outcome {
    let skies = 0..cases.div_ceil(OF_A_SKY);
    let found: Vec<Case> = skies
        .into_par_iter()
        .flat_map_iter(|number| of_a_sky(seed, number, OF_A_SKY.min(cases - number * OF_A_SKY)))
        .collect();
    Outcome {
        judged_apart: found.iter().filter(|case| case.is_integrated).count() as u64,
        apart: "of skies in which each wavelength is integrated, because rays that were held out said that a fit would not do",
        ..Outcome::of_cases(
            "spectra by the fit against the oracle and each wavelength itself",
            seed,
            cases,
            &found,
            |case| case.error,
        )
    }
}

/// The spectra of the sky of a number.
fn of_a_sky(seed: u64, number: u64, count: u64) -> Vec<Case> {
    let rng = &mut generator(seed, number);
    let mut scene = random_scene(rng);
    scene.render.fit = Fit::Regression;
    if rng.random() {
        (scene.render.orders, scene.ground.albedo) = (Orders::UpTo(1), GroundAlbedo::Grey(0.0));
    }
    let wavelengths = random_wavelengths(rng);
    let sky = Sky::new(&scene).expect("a valid scene");
    let planned = SpectralPlan::new(sky.plan(), &wavelengths);
    let views: Vec<(f64, f64)> = (0..count).map(|_| random_view(rng, &scene)).collect();
    let found = views.iter().map(|&(elevation, azimuth)| planned.radiance(direction(elevation, azimuth).as_vec3()));
    let found: Vec<Vec<f64>> = found.collect();
    let expected = references(&scene, sky.plan(), &wavelengths, &views);
    let peak = |spectrum: &Vec<f64>| spectrum.iter().copied().fold(0.0, f64::max);
    let brightest = expected.iter().map(peak).fold(0.0, f64::max);
    let bound = if scene.sun.elevation < 0.0 { BOUND_IN_TWILIGHT } else { BOUND_BY_DAY };
    let is_integrated = matches!(planned.fit, SpectrumFit::Linear(_));
    let case = |i: usize| {
        let (view, found, expected) = (views[i], &found[i], &expected[i]);
        let floor = (FLOOR * peak(expected)).max(FAINT * brightest);
        let error = |i: usize| {
            let error = (found[i] - expected[i]).abs();
            if error == 0.0 { 0.0 } else { error / expected[i].max(floor) / bound }
        };
        let worst = (0..wavelengths.len()).max_by(|&a, &b| error(a).total_cmp(&error(b))).expect("wavelengths");
        Case { scene: scene.clone(), view, wavelength: wavelengths[worst], error: error(worst), is_integrated }
    };
    (0..views.len()).map(case).collect()
}

/// What the spectra towards views are held against (W·m⁻²·sr⁻¹·nm⁻¹).
fn references(scene: &Scene, sky: &SkyPlan, wavelengths: &[f64], views: &[(f64, f64)]) -> Vec<Vec<f64>> {
    if scene.render.orders != Orders::UpTo(1) {
        let dense = DenseSpectrum::new(sky, wavelengths);
        return views
            .iter()
            .map(|&(elevation, azimuth)| dense.radiance(direction(elevation, azimuth).as_vec3()))
            .collect();
    }
    let medium = judge::medium(scene);
    let coefficients: Vec<_> = wavelengths.iter().map(|&wavelength| judge::coefficients(scene, wavelength)).collect();
    let optics = scene.optics();
    let irradiance: Vec<f64> = wavelengths.iter().map(|&wavelength| optics.solar_irradiance(wavelength)).collect();
    let along = |&(elevation, azimuth): &(f64, f64)| {
        let transfer = scattered_radiance_bands(&medium, &coefficients, &judge::ray(scene, elevation, azimuth));
        transfer.iter().zip(&irradiance).map(|(transfer, irradiance)| transfer * irradiance).collect()
    };
    views.iter().map(along).collect()
}

/// Wavelengths (nm) between 360 and 830, evenly spread, at least as many as are no bands themselves.
fn random_wavelengths(rng: &mut ChaCha8Rng) -> Vec<f64> {
    let (first, last) = (rng.random_range(360.0..=420.0), rng.random_range(680.0..=830.0));
    let count = rng.random_range(16..=96);
    (0..count).map(|i| first + (last - first) * f64::from(i) / f64::from(count - 1)).collect()
}

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { scene, view, wavelength, error, .. } = self;
        write!(f, "{error:.2} of what is allowed at {wavelength:.1} nm; {}", seen(scene, *view))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spectra_through_the_bands_of_colour_alone_are_told() {
        let mut scene = Scene::default().in_closed_form();
        scene.sun.elevation = -2.0;
        let sky = Sky::new(&scene).unwrap();
        let wavelengths: Vec<f64> = (0..=47).map(|i| 360.0 + 10.0 * f64::from(i)).collect();
        // Close to the horizon, where the ends of a spectrum lose most.
        let view = (1.0, 120.0);
        let expected = &references(&scene, sky.plan(), &wavelengths, &[view])[0];
        let peak = expected.iter().copied().fold(0.0, f64::max);
        let error = |(found, expected): (&f64, &f64)| (found - expected).abs() / expected.max(FLOOR * peak);
        let worst = |spectra: SpectralPlan| {
            let found = spectra.radiance(direction(view.0, view.1).as_vec3());
            found.iter().zip(expected).map(error).fold(0.0, f64::max)
        };
        let (own, all) =
            (SpectralPlan::of_own_bands(sky.plan(), &wavelengths), SpectralPlan::new(sky.plan(), &wavelengths));
        let (own, all) = (worst(own), worst(all));
        assert!(own > BOUND_IN_TWILIGHT && all < 0.5 * BOUND_IN_TWILIGHT, "{own}, {all}");
    }
}
