//! Light that nothing absorbs, over white ground: as much goes up as comes down, at any altitude.
//!
//! It needs no oracle, and so it tries the thickest air. What is lost or made on the way shows as a net irradiance.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use sorairo::Sky;
use sorairo::scene::{AirSpectrum, Fit, GroundAlbedo, Preset, Scene, SunSpectrum};

use super::outcome::{Outcome, generator};

/// The wavelength (nm).
const WAVELENGTH: f64 = 550.0;

/// The net irradiance that may be, relative to what meets the top of the atmosphere: 0.3 % for sums over the directions
/// of a hemisphere, which leave as much in haze with a low sun, and what the planet's curvature takes, twice the
/// altitude over its radius.
const BOUND: f64 = 3e-3;

/// Tries random skies.
pub fn energy(seed: u64, cases: u64) -> Outcome {
    let net = |number: u64| {
        let scene = random_scene(&mut generator(seed, number));
        (net(&scene) / allowed(&scene), scene)
    };
    let found: Vec<(f64, Scene)> = (0..cases).into_par_iter().map(net).collect();
    let worst = found.iter().max_by(|a, b| a.0.total_cmp(&b.0));
    Outcome {
        subject: "energy of light that nothing absorbs, over white ground",
        seed,
        cases,
        failures: found.iter().filter(|(error, _)| error.is_nan() || *error > 1.0).count() as u64,
        worst: worst.map_or(0.0, |(error, _)| *error),
        bound: 1.0,
        worst_case: worst.map_or("none".into(), |(error, scene)| {
            let (air, aerosol) = (scene.atmosphere.air.scattering, &scene.atmosphere.aerosol);
            format!(
                "{error:.2} of what is allowed: sun {:.1}°, altitude {:.2} km, air {air:.2e}, aerosol {:.3}, g {:.2}",
                scene.sun.elevation, scene.observer.altitude, aerosol.optical_depth, aerosol.asymmetry
            )
        }),
        ..Outcome::default()
    }
}

fn allowed(scene: &Scene) -> f64 {
    BOUND + 2.0 * scene.observer.altitude / scene.atmosphere.ground_radius
}

/// The net irradiance at the observer, relative to what meets the top of the atmosphere.
fn net(scene: &Scene) -> f64 {
    let sky = Sky::new(scene).expect("a valid scene");
    let light = sky.spectral_light(&[WAVELENGTH]).expect("a known wavelength");
    let down = light.irradiance_w_m2_nm[0] + light.direct_irradiance_w_m2_nm[0];
    (down - light.ground_irradiance_w_m2_nm[0]).abs() / scene.sun.elevation.to_radians().sin()
}

/// Air and haze up to an optical depth of 100 together, seen from up to 3 km.
fn random_scene(rng: &mut ChaCha8Rng) -> Scene {
    // Gases of a measured profile absorb.
    let mut scene = Scene::preset(Preset::Standard).in_closed_form();
    (scene.sun.spectrum, scene.render.fit) = (SunSpectrum::Flat, Fit::Transfer);
    scene.sun.elevation = rng.random_range(15.0..=90.0);
    scene.observer.altitude = rng.random_range(0.0..=3.0);
    scene.ground.albedo = GroundAlbedo::Grey(1.0);
    let depth = 10f64.powf(rng.random_range(-1.0..=2.0));
    let of_air = if rng.random() { 1.0 } else { rng.random_range(0.0..=1.0) };
    let atmosphere = &mut scene.atmosphere;
    atmosphere.ozone.column = 0.0;
    atmosphere.air.spectrum = AirSpectrum::FourthPower;
    atmosphere.air.scattering =
        (depth * of_air).max(1e-3) / atmosphere.air.scale_height * (WAVELENGTH / 1000.0).powi(4);
    let aerosol = &mut atmosphere.aerosol;
    (aerosol.optical_depth, aerosol.angstrom_exponent) = (depth * (1.0 - of_air), 0.0);
    (aerosol.single_scattering_albedo, aerosol.asymmetry) = (1.0, rng.random_range(0.3..=0.85));
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ground_that_keeps_a_hundredth_is_told() {
        let mut scene = random_scene(&mut generator(1, 0));
        scene.observer.altitude = 0.0;
        assert!(net(&scene) < allowed(&scene));
        scene.ground.albedo = GroundAlbedo::Grey(0.98);
        assert!(net(&scene) > allowed(&scene), "{}", net(&scene));
    }
}
