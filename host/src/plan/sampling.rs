//! How a scene's rays are sampled: as few samples as keep the radiance within its error, measured on the scene's own rays.

use rayon::prelude::*;
use sorairo_shared::frame::Frame;
use sorairo_shared::glam::{Vec2, Vec3};
use sorairo_shared::scattering::Bands;
use sorairo_shared::sky::transfer;

use super::optics::Optics;
use super::quadrature::gauss_legendre;
use super::{direction, path};
use crate::scene::Scene;

/// A radiance below this part of its scene's maximum is judged by its absolute error.
pub const FAINT: f64 = 1e-9;

/// The largest relative error that a radiance may have.
pub const BOUND: f64 = 1e-3;

/// A scene whose brightest transfer (sr⁻¹) is below this is black: [`FAINT`] of it is where single precision ends.
pub const BLACK: f64 = 1e-23;

/// The difference from twice as many samples at which more are taken: other rays are a little worse than the scene's test rays.
const TOLERANCE: f64 = 0.5 * BOUND;

/// Samples that a guess is compared with, at least: two coarse rules can miss the same.
const FEWEST_OF_REFERENCE: u32 = 96;

/// Most samples on a piece that are taken unasked.
const MOST: u32 = 768;

/// The error of a radiance relative to itself or, where it is fainter than 1e-9 of the scene's maximum, to a millionth of that: so that
/// [`BOUND`] stands for 1e-3 of the one and 1e-9 of the other. Infinite for what is not a number.
pub fn error(value: f64, reference: f64, brightest: f64) -> f64 {
    let brightest = brightest.max(BLACK);
    let scale = if reference > FAINT * brightest { reference } else { FAINT / BOUND * brightest };
    let error = (value - reference).abs() / scale;
    if error.is_nan() { f64::INFINITY } else { error }
}

/// Samples on each piece of a ray: the fewest that keep the radiance of the scene's test rays within [`BOUND`].
///
/// By day and from the ground of a planet like the Earth the integrand is smooth, and 12 samples do. With a low sun, rays of sunlight graze
/// the edges of the ozone tent, where its column has a singularity of the power 3/2, and 48 are needed. These are the first guess;
/// it is doubled until a rule of twice as many samples, and of 96 at least, agrees.
pub fn steps(scene: &Scene, frame: &Frame, optics: &Optics, integral: u32) -> u32 {
    let sky = Sky { frame, bands: optics.bands(TEST_WAVELENGTHS), views: test_views(scene), integral };
    let mut steps = if scene.sun.elevation >= 5.0 { 12 } else { 48 };
    let mut finer = (0, Vec::new());
    while steps < MOST {
        let more = (2 * steps).max(FEWEST_OF_REFERENCE);
        let values = if finer.0 == steps { finer.1 } else { sky.transfer(steps) };
        finer = (more, sky.transfer(more));
        if worst(&values, &finer.1) <= TOLERANCE {
            return steps;
        }
        steps *= 2;
    }
    MOST
}

/// The scene's sky on its test rays.
struct Sky<'a> {
    frame: &'a Frame,
    bands: Bands,
    views: Vec<Vec3>,
    integral: u32,
}

impl Sky<'_> {
    /// The transfer at four wavelengths along each ray.
    fn transfer(&self, steps: u32) -> Vec<[f64; 4]> {
        let rule: Vec<Vec2> = gauss_legendre(steps);
        let along =
            |&view: &Vec3| transfer(self.frame, &self.bands, &rule, view, self.integral).to_array().map(f64::from);
        self.views.par_iter().map(along).collect()
    }
}

/// The largest [`error`] of any ray at any wavelength.
fn worst(values: &[[f64; 4]], references: &[[f64; 4]]) -> f64 {
    let brightest: [f64; 4] = std::array::from_fn(|band| references.iter().map(|ray| ray[band]).fold(0.0, f64::max));
    let of_ray = |(value, reference): (&[f64; 4], &[f64; 4])| {
        (0..4).map(|band| error(value[band], reference[band], brightest[band])).fold(0.0, f64::max)
    };
    values.iter().zip(references).map(of_ray).fold(0.0, f64::max)
}

/// The ends of the range of bands, and where air and ozone weigh differently between them (nm).
const TEST_WAVELENGTHS: [f64; 4] = [360.0, 440.0, 590.0, 830.0];

/// Directions that meet every kind of ray: towards the sun, across and away from it; the zenith, the horizon and close above it; from
/// above the ground also level, down, and through the air behind the limb at several heights.
fn test_views(scene: &Scene) -> Vec<Vec3> {
    let a = &scene.atmosphere;
    let (ground, altitude) = (a.ground_radius, scene.observer.altitude);
    let horizon = path::horizon(ground, altitude).to_degrees();
    let mut elevations: Vec<f64> = [0.0, 0.3, 2.0, 8.0, 30.0].map(|above| horizon + above).into();
    elevations.push(90.0);
    if altitude > 0.0 {
        elevations.extend([0.1, 1.0, 5.0, 30.0].map(|below| horizon - below));
        elevations.extend([0.0, -90.0]);
        let highest = altitude.min(a.top_radius - ground);
        let limb = |lowest: f64| path::horizon(ground + lowest, altitude - lowest).to_degrees();
        let thinner = a.air.scale_height.min(a.aerosol.scale_height);
        elevations.extend([0.5 * thinner, 1.5 * thinner, 4.0 * a.air.scale_height].map(|h| limb(h.min(highest))));
        elevations.extend([0.1, 0.3, 0.7].map(|part| limb(part * highest)));
    }
    let azimuths = [2.0, 70.0, 178.0].map(|from_sun| scene.sun.azimuth + from_sun);
    elevations
        .into_iter()
        .flat_map(|elevation| azimuths.map(|azimuth| direction(elevation.clamp(-90.0, 90.0), azimuth).as_vec3()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PixelFormat;
    use crate::plan::Plan;

    fn steps(change: impl FnOnce(&mut Scene)) -> u32 {
        let mut scene = Scene::default();
        change(&mut scene);
        Plan::new(&scene, PixelFormat::LinearRgb).unwrap().steps()
    }

    #[test]
    fn the_earth_from_its_ground_takes_few_samples() {
        for (sun, expected) in [(90.0, 12), (30.0, 12), (5.0, 12), (4.0, 48), (0.0, 48), (-4.0, 48)] {
            assert_eq!(steps(|scene| scene.sun.elevation = sun), expected, "sun at {sun}");
        }
    }

    #[test]
    fn thick_air_takes_more_samples() {
        assert!(steps(|scene| scene.atmosphere.air.scattering *= 100.0) > 12);
    }

    #[test]
    fn what_is_not_a_number_is_an_infinite_error() {
        assert_eq!(error(f64::NAN, 1.0, 1.0), f64::INFINITY);
        assert_eq!(error(1.001, 1.0, 1.0).to_bits(), (1.001_f64 - 1.0).to_bits());
        // 1e-9 of the maximum counts as much as 1e-3 of what is brighter.
        assert!((error(1e-9, 0.0, 1.0) - BOUND).abs() < 1e-12);
    }
}
