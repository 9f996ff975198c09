//! Light of all orders in single precision against the oracle's paths, over the skies that the Earth has.
//!
//! A case is a direction in a random sky at a wavelength. What it may be off is what is stated for its sun and haze and
//! twice what the plan tells of itself, whichever is less, and the standard errors of the oracle.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use sorairo::Sky;
use sorairo_oracle::{Estimate, Paths, radiance_of_all_orders};

use super::outcome::{Outcome, Together, generator};
use crate::judge;
use sorairo::low_level::plan::direction;
use sorairo::low_level::plan::light_field::OrdersMade;
use sorairo::low_level::spectrum::DenseSpectrum;
use sorairo::scene::{Fit, GroundAlbedo, Preset, Scene, SunSpectrum};

/// Paths of a first estimate.
const FEWEST_PATHS: u64 = 8192;

/// Paths of the last: a case whose chance is larger than what it is judged by says little. Two cases of twenty, in deep
/// twilight and in thick haze, ask for 3 and 6 million.
const MOST_PATHS: u64 = 8_388_608;

/// Standard errors that a case may be off by: of a thousand normal ones three are.
const STANDARD_ERRORS: f64 = 3.0;

/// How many more paths are followed than an estimate asks for, whose standard error is itself uncertain by a tenth.
const SPARE: f64 = 1.25;

/// The oracle's standard error that decides a case, relative to what the case may be off: with three of them a case
/// fails from 1.4 times that on at the latest.
const DECIDES: f64 = 0.125;

/// The part of the cases that may stay undecided because the oracle ran out of paths.
const MOST_UNDECIDED: f64 = 0.05;

/// How much more a plan may tell than it is off, in the mean of the squares of many cases.
const MOST_TOLD: f64 = 10.0;

/// A direction is judged relative to its own light, or to this part of the brightest of its sky.
const FLOOR: f64 = 0.05;

/// A direction in a sky at a wavelength.
#[derive(Clone, Debug)]
pub struct Case {
    scene: Scene,
    wavelength: f64,
    /// Elevation and azimuth (degrees).
    view: (f64, f64),
    /// By the product (sr⁻¹).
    found: f64,
    /// By the oracle (sr⁻¹).
    reference: Estimate,
    /// How far it is off beyond the oracle's chance, over what is allowed.
    pub error: f64,
    /// How far it is off, and how far the plan tells that it may be, relative to the same light.
    off: f64,
    told: f64,
    /// Whether the oracle knows its light well enough to judge it.
    is_decided: bool,
}

/// Compares random skies.
pub fn orders(seed: u64, cases: u64) -> Outcome {
    let found: Vec<Case> = (0..cases).into_par_iter().map(|number| Case::random(seed, number)).collect();
    let undecided = found.iter().filter(|case| !case.is_decided).count() as u64;
    let square = |of: fn(&Case) -> f64| found.iter().map(|case| of(case).powi(2)).sum::<f64>();
    Outcome {
        judged_apart: undecided,
        apart: "left undecided by an oracle that ran out of paths; more than 5 % of them are failures",
        together: Together {
            told_and_off: [square(|case| case.told), square(|case| case.off)],
            most_told: MOST_TOLD,
            most_apart: MOST_UNDECIDED,
        },
        ..Outcome::of_cases("light of all orders against the oracle's paths", seed, cases, &found, |case| case.error)
    }
}

impl Case {
    /// That of a number.
    pub fn random(seed: u64, number: u64) -> Self {
        let rng = &mut generator(seed, number);
        let scene = random_scene(rng);
        let wavelength = rng.random_range(380.0..=780.0);
        let sky = Sky::new(&scene).expect("a valid scene");
        let wavelengths = [wavelength];
        let dense = DenseSpectrum::new(sky.plan(), &wavelengths);
        let radiance = |(elevation, azimuth): (f64, f64)| dense.radiance(direction(elevation, azimuth).as_vec3())[0];
        let views: Vec<(f64, f64)> = (0..16).map(|_| random_view(rng, &scene)).collect();
        let brightest = views.iter().copied().map(radiance).fold(0.0, f64::max);
        let found = radiance(views[0]);
        let scale = found.max(FLOOR * brightest);
        let told = sky.plan().integral().orders_made.iter().map(OrdersMade::told).fold(0.0, f64::max);
        let allowed = allowed(&scene).min(2.0 * told);
        let reference = reference(&scene, wavelength, views[0], DECIDES * allowed * scale, number);
        let off = (found - reference.mean).abs();
        let beyond = (off - STANDARD_ERRORS * reference.standard_error).max(0.0);
        let error = if scale > 0.0 { beyond / scale / allowed } else { beyond };
        let off = if scale > 0.0 { off / scale } else { off };
        let is_decided = reference.standard_error <= DECIDES * allowed * scale;
        Self { scene, wavelength, view: views[0], found, reference, error, off, told, is_decided }
    }
}

/// What the light of all orders may be off, relative to itself: what is stated in `docs/accuracy.md`.
fn allowed(scene: &Scene) -> f64 {
    let aerosol = &scene.atmosphere.aerosol;
    match scene.sun.elevation {
        _ if aerosol.optical_depth > 0.05 => 0.025,
        sun if sun >= 10.0 => 0.005,
        sun if sun >= 0.0 => 0.01,
        sun if sun >= -6.0 => 0.015,
        _ => 0.03,
    }
}

/// The oracle's light, with as many paths as bring its standard error below a radiance (sr⁻¹), or with the most.
fn reference(scene: &Scene, wavelength: f64, view: (f64, f64), enough: f64, seed: u64) -> Estimate {
    let (medium, band) = (judge::medium(scene), judge::coefficients(scene, wavelength));
    let ray = judge::ray(scene, view.0, view.1);
    let mut number = FEWEST_PATHS;
    loop {
        let estimate = radiance_of_all_orders(&medium, &band, &ray, Paths { number, seed });
        if estimate.standard_error <= enough || number >= MOST_PATHS {
            return estimate;
        }
        let wanted = SPARE * number as f64 * (estimate.standard_error / enough).powi(2);
        number = (wanted as u64).max(2 * number).min(MOST_PATHS);
    }
}

/// A sky of the Earth: air of any law and pressure, haze up to an optical depth of 0.3 at 1 µm or, one in eight, of 1
/// to 8, any ground, seen from the ground to orbit.
pub(super) fn random_scene(rng: &mut ChaCha8Rng) -> Scene {
    let preset = if rng.random() { Preset::Standard } else { Preset::Earth };
    // Paths through the levels of a profile take ten times as long.
    let mut scene = Scene::preset(preset).in_closed_form();
    scene.sun.spectrum = SunSpectrum::Flat;
    scene.render.fit = Fit::Transfer;
    scene.sun.elevation = match rng.random_range(0..4) {
        0 => rng.random_range(-12.0..0.0),
        1 => rng.random_range(0.0..10.0),
        _ => rng.random_range(10.0..=90.0),
    };
    scene.observer.altitude = match rng.random_range(0..5) {
        0..3 => 0.0,
        3 => rng.random_range(0.0..20.0),
        _ => rng.random_range(20.0..=400.0),
    };
    scene.ground.albedo = GroundAlbedo::Grey(if rng.random() { 0.0 } else { rng.random_range(0.0..=1.0) });
    let atmosphere = &mut scene.atmosphere;
    atmosphere.air.pressure = rng.random_range(500.0..=1050.0);
    atmosphere.ozone.column = rng.random_range(0.0..=500.0);
    let aerosol = &mut atmosphere.aerosol;
    aerosol.optical_depth = match rng.random_range(0..8) {
        0..2 => 0.0,
        2 => rng.random_range(0.05..=0.3),
        3 => rng.random_range(1.0..=8.0),
        _ => rng.random_range(0.0..=0.05),
    };
    aerosol.angstrom_exponent = rng.random_range(0.0..=1.0);
    aerosol.scale_height = rng.random_range(1.0..=3.0);
    aerosol.single_scattering_albedo = rng.random_range(0.8..=1.0);
    aerosol.asymmetry = rng.random_range(0.5..=0.8);
    scene
}

/// A direction (degrees) from which light comes; the horizon itself is left out, where the ground begins.
pub(super) fn random_view(rng: &mut ChaCha8Rng, scene: &Scene) -> (f64, f64) {
    let lowest = if scene.observer.altitude > 0.0 { -90.0 } else { 0.2 };
    (rng.random_range(lowest..=90.0), scene.sun.azimuth + rng.random_range(0.0..=180.0))
}

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { scene, wavelength, view, found, reference, error, .. } = self;
        let Estimate { mean, standard_error, .. } = reference;
        write!(
            f,
            "{error:.2} of what is allowed: {found:.4e} instead of {mean:.4e} ± {standard_error:.1e} at {wavelength:.0} nm; {}",
            seen(scene, *view)
        )
    }
}

/// A direction (degrees) in a random scene, and what is random in that.
pub(super) fn seen(scene: &Scene, (elevation, azimuth): (f64, f64)) -> String {
    let (air, aerosol) = (&scene.atmosphere.air, &scene.atmosphere.aerosol);
    format!(
        "view {elevation:.2}°, {azimuth:.1}°; {:?}, orders {:?}, sun {:.2}°, altitude {:.2} km, ground {:?}, {:.0} hPa, ozone {:.0} DU, aerosol {:.4}, \
         Ångström {:.2}, {:.2} over {:.2} km, g {:.3}",
        scene.began_as(),
        scene.render.orders,
        scene.sun.elevation,
        scene.observer.altitude,
        scene.ground.albedo,
        air.pressure,
        scene.atmosphere.ozone.column,
        aerosol.optical_depth,
        aerosol.angstrom_exponent,
        aerosol.single_scattering_albedo,
        aerosol.scale_height,
        aerosol.asymmetry
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_without_a_ground_that_is_there_is_told() {
        // The first case over lit ground, by day.
        let is_lit = |scene: &Scene| scene.sun.elevation > 20.0 && scene.ground.albedo != GroundAlbedo::Grey(0.0);
        let scenes = (0..100).map(|number| random_scene(&mut generator(1, number)));
        let mut scene = scenes.into_iter().find(is_lit).expect("one in four");
        scene.ground.albedo = GroundAlbedo::Grey(0.8);
        let mut black = scene.clone();
        black.ground.albedo = GroundAlbedo::Grey(0.0);
        let sky = Sky::new(&black).unwrap();
        let found = DenseSpectrum::new(sky.plan(), &[450.0]).radiance(direction(60.0, 100.0).as_vec3())[0];
        let lit = reference(&scene, 450.0, (60.0, 100.0), DECIDES * allowed(&scene) * found, 1);
        assert!(
            lit.mean - found - STANDARD_ERRORS * lit.standard_error > 5.0 * allowed(&scene) * found,
            "{lit:?}, {found}"
        );
    }
}
