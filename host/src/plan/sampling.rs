//! How a scene's rays are sampled: as few samples as keep the radiance within its error, measured on the scene's own rays.

use rayon::prelude::*;
use sorairo_shared::frame::Frame;
use sorairo_shared::glam::{Vec2, Vec3};
use sorairo_shared::scattering::Bands;
use sorairo_shared::sky::transfer;
use sorairo_shared::variant;

use super::optics::Optics;
use super::quadrature::gauss_legendre;
use super::{direction, path};
use crate::scene::Scene;

/// A radiance below this part of its scene's maximum is judged by its absolute error.
pub const FAINT: f64 = 1e-9;

/// The largest relative error that a radiance may have.
pub const BOUND: f64 = 1e-3;

/// A scene whose brightest transfer (sr⁻¹) is below this is black, and [`FAINT`] of this is nothing: it is where single precision ends, the
/// smallest exponential (1.6e-38) along the longest paths.
const BLACK: f64 = 1e-21;

/// The difference from twice as many samples at which more are taken: other rays are a little worse than the scene's test rays.
const TOLERANCE: f64 = 0.25 * BOUND;

/// Samples that a guess is compared with, at least: two coarse rules can miss the same.
const FEWEST_OF_REFERENCE: u32 = 96;

/// What twilight takes on the Earth's ground.
const TWILIGHT: u32 = 64;

/// Most samples on a piece that are taken unasked.
const MOST: u32 = 3072;

/// The error of a radiance relative to itself or, where it is fainter than 1e-9 of the scene's maximum, to a millionth of that: so that
/// [`BOUND`] stands for 1e-3 of the one and 1e-9 of the other. In a black scene the larger of both counts. Infinite for what is not a
/// number.
pub fn error(value: f64, reference: f64, brightest: f64) -> f64 {
    let faint = FAINT / BOUND * brightest.max(BLACK);
    let scale = if brightest < BLACK {
        reference.max(faint)
    } else if reference > FAINT * brightest {
        reference
    } else {
        faint
    };
    let error = (value - reference).abs() / scale;
    if error.is_nan() { f64::INFINITY } else { error }
}

/// Samples on each piece of a ray: the fewest that keep the radiance of the scene's test rays within [`BOUND`].
///
/// By day and from the ground of a planet like the Earth the integrand is smooth, and 12 samples do. With a low sun, rays of sunlight graze
/// the edges of the ozone tent, where its column has a singularity of the power 3/2, and 48 are needed. These are the first guess;
/// more are taken until a rule of twice as many, and of 96 at least, agrees. Between the test rays of a hard scene there are worse ones, so
/// that the next number is taken: where the guess does not do for the limb, seen from above the ground, or more than twilight takes on the
/// Earth are needed anywhere.
///
/// `bands` are the plan's own.
pub fn steps(scene: &Scene, frame: &Frame, optics: &Optics, bands: &[Bands], integral: u32) -> u32 {
    let sky = Sky { frame, bands: test_bands(scene, optics, bands, integral), integral };
    let mut views = test_views(scene);
    let guess = if scene.sun.elevation >= 5.0 { 12 } else { 48 };
    let mut steps = guess;
    let mut brightest = None;
    while steps < MOST {
        let values = sky.transfer(&views, steps);
        let references = sky.transfer(&views, (2 * steps).max(FEWEST_OF_REFERENCE));
        let brightest = brightest.get_or_insert_with(|| largest(&references));
        let errors = values.iter().zip(&references).map(|(value, reference)| worst(value, reference, brightest));
        let errors: Vec<f64> = errors.collect();
        if errors.iter().all(|&error| error <= TOLERANCE) {
            let easy = if scene.observer.altitude > 0.0 { guess } else { TWILIGHT };
            return if steps > easy { more_steps(steps) } else { steps };
        }
        // What is far within the bound will not leave it with more samples.
        let mut of_views = errors.into_iter();
        views.retain(|_| of_views.next().is_some_and(|error| error > TOLERANCE / 16.0));
        steps = more_steps(steps);
    }
    MOST
}

/// The next number of samples to try: 12, 16, 24, 32, 48, 64 and so on.
fn more_steps(steps: u32) -> u32 {
    if steps.is_multiple_of(3) { steps / 3 * 4 } else { steps / 2 * 3 }
}

/// The scene's sky at the test wavelengths.
struct Sky<'a> {
    frame: &'a Frame,
    bands: Vec<Bands>,
    integral: u32,
}

impl Sky<'_> {
    /// The transfer at the test wavelengths along each view.
    fn transfer(&self, views: &[Vec3], steps: u32) -> Vec<Vec<f64>> {
        let rule: Vec<Vec2> = gauss_legendre(steps);
        let four = |bands, view| transfer(self.frame, bands, &rule, view, self.integral).to_array().map(f64::from);
        views.par_iter().map(|&view| self.bands.iter().flat_map(|bands| four(bands, view)).collect()).collect()
    }
}

/// The largest value of all rays at each wavelength.
fn largest(rays: &[Vec<f64>]) -> Vec<f64> {
    let count = rays.first().map_or(0, Vec::len);
    (0..count).map(|band| rays.iter().map(|ray| ray[band]).fold(0.0, f64::max)).collect()
}

/// The largest [`error`] of a ray at any wavelength. Other rays and other wavelengths may be fainter here and not there: what counts as
/// faint is fainter still.
fn worst(value: &[f64], reference: &[f64], brightest: &[f64]) -> f64 {
    (0..value.len()).map(|band| error(value[band], reference[band], 0.01 * brightest[band])).fold(0.0, f64::max)
}

/// The ends of the range of bands, and where air and ozone weigh differently between them (nm).
const TEST_WAVELENGTHS: [f64; 4] = [360.0, 440.0, 590.0, 830.0];

/// Wavelengths between those (nm), for scenes that are black at some of them: where they just are not, the error is largest.
const BETWEEN: [f64; 4] = [480.0, 530.0, 650.0, 700.0];

/// A column of ozone (DU) that can make the sky black in the middle of its band: three times the Earth's.
const MUCH_OZONE: f64 = 1000.0;

/// The wavelengths at which a scene's error is measured. A scene that is black somewhere is tried with the plan's own bands too: samples
/// are placed for the most opaque of four, and not all of the others need be at their best.
fn test_bands(scene: &Scene, optics: &Optics, bands: &[Bands], integral: u32) -> Vec<Bands> {
    let mut tested = vec![optics.bands(TEST_WAVELENGTHS)];
    if integral & variant::OPAQUE != 0 || scene.atmosphere.ozone.column > MUCH_OZONE {
        tested.push(optics.bands(BETWEEN));
        tested.extend(bands.first());
        tested.extend(bands.get(1..).and_then(<[Bands]>::last));
    }
    tested
}

/// Directions that meet every kind of ray: towards the sun, across and away from it; the zenith, the horizon and close above it; to where
/// the sun sets at the top of the atmosphere; from above the ground also level, down, through the air behind the limb at several heights,
/// and to the ground where the sun is low.
fn test_views(scene: &Scene) -> Vec<Vec3> {
    let a = &scene.atmosphere;
    let (ground, altitude) = (a.ground_radius, scene.observer.altitude);
    let horizon = path::horizon(ground, altitude).to_degrees();
    let mut elevations: Vec<f64> = [BESIDE, 0.1, 0.5, 2.0, 8.0, 20.0, 45.0].map(|above| horizon + above).into();
    elevations.push(90.0);
    if altitude > 0.0 {
        elevations.extend([BESIDE, 0.1, 1.0, 5.0, 30.0].map(|below| horizon - below));
        elevations.extend([0.0, -90.0]);
        let highest = altitude.min(a.top_radius - ground);
        let limb = |lowest: f64| path::horizon(ground + lowest, altitude - lowest).to_degrees();
        let thinner = a.air.scale_height.min(a.aerosol.scale_height);
        elevations.extend([0.5 * thinner, 1.5 * thinner, 4.0 * a.air.scale_height].map(|h| limb(h.min(highest))));
        elevations.extend([0.1, 0.3, 0.5, 0.7, 0.9].map(|part| limb(part * highest)));
        let ozone = [a.ozone.bottom, 0.5 * (a.ozone.bottom + a.ozone.peak), a.ozone.peak, a.ozone.top];
        elevations.extend(ozone.map(|h| limb((0.97 * h).min(highest))));
    }
    let top = a.top_radius - ground;
    let views = |from_sun: f64| {
        let on_ground = LOW_SUNS.into_iter().flat_map(move |low| views_of_low_sun(scene, from_sun, low, 0.0));
        let low_sun = on_ground.chain(views_of_low_sun(scene, from_sun, 0.0, top));
        elevations
            .clone()
            .into_iter()
            .chain(low_sun)
            .map(move |elevation| direction(elevation.clamp(-90.0, 90.0), scene.sun.azimuth + from_sun).as_vec3())
    };
    let to_sun = direction(scene.sun.elevation, scene.sun.azimuth).as_vec3();
    let all = [2.0, 25.0, 50.0, 75.0, 100.0, 125.0, 150.0, 178.0].into_iter().flat_map(views);
    all.chain([to_sun, -to_sun]).collect()
}

/// An angle (degrees) that parts a ray from the horizon, where rounding would choose whether it meets the ground.
const BESIDE: f64 = 1e-4;

/// Elevations of the sun (degrees) about the terminator, on the ground.
const LOW_SUNS: [f64; 9] = [-4.0, -2.0, -1.0, -0.3, 0.0, 1.0, 3.0, 5.0, 8.0];

/// The elevations (degrees) at which an observer sees places of a height (km) where the sun stands at an elevation (degrees), in the
/// direction of an azimuth (degrees) from the sun: none, one or two.
///
/// At the angle `θ` from the observer, at the planet's centre, the sun's elevation `e` has
/// `sin e = sin ε cos θ + cos ε cos φ sin θ`, with `ε` the sun's elevation at the observer.
fn views_of_low_sun(scene: &Scene, from_sun: f64, low: f64, height: f64) -> impl Iterator<Item = f64> {
    let (ground, altitude) = (scene.atmosphere.ground_radius, scene.observer.altitude);
    let (up, across) = scene.sun.elevation.to_radians().sin_cos();
    let across = across * from_sun.to_radians().cos();
    let middle = across.atan2(up);
    let half = (low.to_radians().sin() / up.hypot(across)).acos();
    let farthest = -path::horizon(ground, altitude) - path::horizon(ground, height);
    [middle - half, middle + half].into_iter().filter(move |&angle| angle > 0.0 && angle < farthest).map(move |angle| {
        let (sine, cosine) = angle.sin_cos();
        ((ground + height) * cosine - ground - altitude).atan2((ground + height) * sine).to_degrees()
    })
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
        for (sun, expected) in [(90.0, 12), (30.0, 12), (5.0, 12), (4.0, 48), (0.0, 48), (-4.0, 64)] {
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

    #[test]
    fn a_sky_below_what_single_precision_holds_is_black() {
        assert!(error(0.0, 1e-3 * FAINT * BLACK, 1e-3 * BLACK) < BOUND);
        assert!(error(2.99 * FAINT * BLACK, 3.0 * FAINT * BLACK, 1e-6 * BLACK) < BOUND);
        assert!(error(1.002 * BLACK, BLACK, BLACK) > BOUND && error(0.0, 1e-6 * BLACK, 1e-6 * BLACK) > BOUND);
        assert!(error(0.0, 10.0 * FAINT * BLACK, BLACK) > BOUND);
    }
}
