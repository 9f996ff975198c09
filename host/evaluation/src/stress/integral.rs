//! The ray integral in single precision against the oracle, over the whole domain of scenes and rays.
//!
//! A case is a ray of a random scene at four wavelengths. It goes through a [`Plan`], so that samples, variant and
//! coefficients are those that a user gets. A scene's maximum is the brightest of its own [`RAYS_PER_SCENE`] rays,
//! among which are the zenith, the horizon and the sun's direction; a brighter one elsewhere would only allow more.

use std::f64::consts::{FRAC_PI_2, PI};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;
use sorairo_oracle::{Coefficients, Medium, Ray, scattered_radiance_bands_within};
use sorairo_shared::glam::{DVec3, Vec3};

use super::outcome::{Outcome, generator};
use super::scenes::{bounds, thin_the_top};
use crate::judge;
use sorairo::low_level::plan::direction;
use sorairo::low_level::plan::rays::directions;
use sorairo::low_level::plan::samples::{BOUND, error};
use sorairo::scene::{Exposure, Fit, PathChoice, Preset, Scene};
use sorairo::{PixelFormat, Plan};

/// Rays of a scene.
pub const RAYS_PER_SCENE: u64 = 64;

/// The oracle's tolerance: far below the bound, and four times faster than its finest.
const REFERENCE_TOLERANCE: f64 = 1e-6;

/// A direction that differs by this (radians) is the same direction: three units in the last place of a component in
/// single precision, a seventeenth of a pixel's width in the largest image.
const SAME_DIRECTION: f64 = 2e-7;

/// An angle (radians) that is nothing beside [`SAME_DIRECTION`], and that double precision can tell.
const HAIR: f64 = 1e-12;

/// One ray of one scene at four wavelengths, and how far the integral is from the oracle there.
#[derive(Clone, Debug)]
pub struct Case {
    /// The scene.
    pub scene: Scene,
    /// Unit vector along the view.
    pub view: Vec3,
    /// Wavelength of the largest error (nm).
    pub wavelength: f64,
    /// The integral (sr⁻¹).
    pub value: f64,
    /// The oracle's (sr⁻¹).
    pub reference: f64,
    /// The largest of the scene (sr⁻¹).
    pub brightest: f64,
    /// The largest error of the four wavelengths, in the sense of [`error`].
    pub error: f64,
    /// Samples per piece.
    pub steps: u32,
    /// Whether the error is that large only because a direction has no more digits in single precision.
    pub excused: bool,
}

/// Compares the rays of random scenes; at least `cases` rays, in whole scenes of [`RAYS_PER_SCENE`].
pub fn integral(seed: u64, cases: u64) -> Outcome {
    let scenes = cases.div_ceil(RAYS_PER_SCENE);
    let found = (0..scenes).into_par_iter().map(|number| Found::of(scene_cases(seed, number)));
    let Found { failures, excused, worst } = found.reduce(Found::default, Found::and);
    Outcome {
        subject: "rays in single precision against the oracle",
        seed,
        cases: scenes * RAYS_PER_SCENE,
        failures,
        worst: worst.as_ref().map_or(0.0, |case| case.error),
        bound: BOUND,
        worst_case: worst.map_or("none".into(), |case| case.to_string()),
        judged_apart: excused,
        apart: "judged by directions that single precision cannot tell from their own",
        ..Outcome::default()
    }
}

/// What rays were found to be.
#[derive(Default)]
struct Found {
    failures: u64,
    excused: u64,
    worst: Option<Case>,
}

impl Found {
    fn of(cases: Vec<Case>) -> Self {
        let count = |what: fn(&Case) -> bool| cases.iter().filter(|case| what(case)).count() as u64;
        Self {
            failures: count(|case| case.error.is_nan() || case.error > BOUND),
            excused: count(|case| case.excused),
            worst: cases.into_iter().max_by(|a, b| a.error.total_cmp(&b.error)),
        }
    }

    fn and(self, other: Self) -> Self {
        let worst = [self.worst, other.worst].into_iter().flatten().max_by(|a, b| a.error.total_cmp(&b.error));
        Self { failures: self.failures + other.failures, excused: self.excused + other.excused, worst }
    }
}

/// The rays of one random scene.
pub fn scene_cases(seed: u64, index: u64) -> Vec<Case> {
    let mut rng = generator(seed, index);
    let scene = random_scene(&mut rng);
    let views: Vec<Vec3> = (0..RAYS_PER_SCENE).map(|i| random_view(&mut rng, &scene, i).as_vec3()).collect();
    compare(&scene, &views)
}

/// A cell of the [`error_map`].
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Cell {
    /// Altitude of the observer (km).
    pub altitude: f64,
    /// Elevation of the view above the observer's horizon (degrees).
    pub view: f64,
    /// Elevation of the sun (degrees).
    pub sun: f64,
    /// The largest error, in the sense of [`error`], of the plan's bands and of two azimuths; `None` where nothing is
    /// lit.
    pub error: Option<f64>,
}

/// Altitudes of the [`error_map`] (km).
pub const MAP_ALTITUDES: [f64; 6] = [0.0, 2.0, 12.0, 35.0, 120.0, 1000.0];

/// Elevations above the observer's horizon of the [`error_map`] (degrees).
pub const MAP_VIEWS: [f64; 19] =
    [-90.0, -60.0, -30.0, -15.0, -6.0, -3.0, -1.0, -0.3, -0.1, 0.0, 0.1, 0.3, 1.0, 3.0, 6.0, 15.0, 30.0, 60.0, 90.0];

/// Elevations of the sun of the [`error_map`] (degrees).
pub const MAP_SUNS: [f64; 19] =
    [-18.0, -12.0, -9.0, -6.0, -4.0, -3.0, -2.0, -1.0, -0.3, 0.0, 0.3, 1.0, 3.0, 5.0, 9.0, 15.0, 30.0, 60.0, 90.0];

/// Azimuths from the sun of the [`error_map`] (degrees).
const MAP_AZIMUTHS: [f64; 2] = [10.0, 120.0];

/// The error of the earth preset over the observer's altitude, the view's elevation and the sun's.
pub fn error_map() -> Vec<Cell> {
    let places: Vec<_> = MAP_ALTITUDES.iter().flat_map(|&altitude| MAP_SUNS.map(|sun| (altitude, sun))).collect();
    places.into_par_iter().flat_map_iter(|(altitude, sun)| cells(altitude, sun)).collect()
}

/// The cells of an altitude (km) and an elevation of the sun (degrees).
fn cells(altitude: f64, sun: f64) -> impl Iterator<Item = Cell> {
    let mut scene = Scene::preset(Preset::Earth).first_order();
    scene.sun.elevation = sun;
    scene.observer.altitude = altitude;
    let horizon = directions::horizon(scene.atmosphere.ground_radius, altitude).to_degrees();
    let elevations = MAP_VIEWS.map(|view| (horizon + view).clamp(-90.0, 90.0));
    let toward =
        |elevation: f64| MAP_AZIMUTHS.map(|azimuth| direction(elevation, scene.sun.azimuth + azimuth).as_vec3());
    let views: Vec<Vec3> = elevations.into_iter().flat_map(toward).collect();
    let cases = compare(&scene, &views);
    MAP_VIEWS.into_iter().enumerate().map(move |(i, view)| {
        let cases = &cases[i * MAP_AZIMUTHS.len()..][..MAP_AZIMUTHS.len()];
        let lit = cases.iter().any(|case| case.brightest > 0.0);
        let error = lit.then(|| cases.iter().map(|case| case.error).fold(0.0, f64::max));
        Cell { altitude, view, sun, error }
    })
}

/// Compares the integral along views of a scene with the oracle.
///
/// # Panics
///
/// If the scene is not valid.
pub fn compare(scene: &Scene, views: &[Vec3]) -> Vec<Case> {
    let plan = Plan::new(&scene.validated().expect("a valid scene"), PixelFormat::LinearRgb);
    let judge = Judge::new(scene, &plan);
    let pairs: Vec<[(f64, f64); 4]> = views.iter().map(|&view| judge.pair(view)).collect();
    let brightest: [f64; 4] = std::array::from_fn(|i| pairs.iter().map(|pair| pair[i].1).fold(0.0, f64::max));
    views.iter().zip(pairs).map(|(&view, pair)| judge.case(view, pair, brightest)).collect()
}

/// A scene, its plan, and what the oracle needs of them.
struct Judge<'a> {
    scene: &'a Scene,
    plan: &'a Plan,
    medium: Medium,
    bands: Vec<Coefficients>,
    sun: [f64; 3],
}

impl<'a> Judge<'a> {
    fn new(scene: &'a Scene, plan: &'a Plan) -> Self {
        let bands = judge::bands(scene, plan.sky.plan());
        let sun = unit(plan.uniform.sun.truncate());
        Self { scene, plan, medium: judge::medium(scene), bands, sun }
    }

    /// The integral and the oracle at the four bands.
    fn pair(&self, view: Vec3) -> [(f64, f64); 4] {
        let values = self.plan.sky.plan().integral().transfer(view);
        let references = self.reference(unit(view), self.sun);
        std::array::from_fn(|i| (values[i], references[i]))
    }

    /// Elevation of the horizon (radians).
    fn horizon(&self) -> f64 {
        directions::horizon(self.scene.atmosphere.ground_radius, f64::from(self.plan.uniform.altitude))
    }

    fn reference(&self, view: [f64; 3], sun: [f64; 3]) -> Vec<f64> {
        let ray = Ray { observer_altitude_km: f64::from(self.plan.uniform.altitude), view, sun };
        scattered_radiance_bands_within(REFERENCE_TOLERANCE, &self.medium, &self.bands, &ray)
    }

    fn case(&self, view: Vec3, pair: [(f64, f64); 4], brightest: [f64; 4]) -> Case {
        let errors: [f64; 4] = std::array::from_fn(|i| error(pair[i].0, pair[i].1, brightest[i]));
        let worst = (0..4).max_by(|&a, &b| errors[a].total_cmp(&errors[b])).expect("four bands");
        let mut case = Case {
            scene: self.scene.clone(),
            view,
            wavelength: self.plan.sky.plan().integral().wavelengths[worst],
            value: pair[worst].0,
            reference: pair[worst].1,
            brightest: brightest[worst],
            error: errors[worst],
            steps: self.plan.samples_per_piece(),
            excused: false,
        };
        if case.error > BOUND && case.error.is_finite() {
            let nearest = self.error_of_same_directions(view, pair, brightest);
            if nearest <= BOUND {
                (case.error, case.excused) = (nearest, true);
            }
        }
        case
    }

    /// The error of values against the nearest that the oracle takes among directions that single precision cannot tell
    /// from the view and from the sun's.
    fn error_of_same_directions(&self, view: Vec3, pair: [(f64, f64); 4], brightest: [f64; 4]) -> f64 {
        let (view, sun) = (unit(view), self.sun);
        // Ever closer: beside the horizon's jump the radiance changes with its distance from the jump.
        let parts = [-1.0, -0.5, -0.25, 0.25, 0.5, 1.0].map(|part| part * SAME_DIRECTION);
        // The radiance jumps at the horizon, and beside it depends on the distance from the jump: that is one of the
        // directions to try.
        let to_horizon = self.horizon() - view[2].clamp(-1.0, 1.0).asin();
        let beside_horizon =
            [to_horizon - HAIR, to_horizon + HAIR].into_iter().filter(|angle| angle.abs() < SAME_DIRECTION);
        let beside_horizon: Vec<f64> = beside_horizon.collect();
        let of_views =
            parts.into_iter().chain(beside_horizon.clone()).map(|angle| self.reference(tilted(view, angle), sun));
        // At the horizon the sun's tilt may light or darken the other side of the jump alone.
        let at_horizon = beside_horizon.iter().map(|&angle| tilted(view, angle));
        let views: Vec<[f64; 3]> = at_horizon.chain([view]).collect();
        let of_suns = views.iter().flat_map(|&view| parts.map(|angle| self.reference(view, tilted(sun, angle))));
        let near: Vec<Vec<f64>> = of_views.chain(of_suns).collect();
        (0..4)
            .map(|i| {
                let (value, reference) = pair[i];
                let all = || near.iter().map(|bands| bands[i]).chain([reference]);
                let (low, high) = (all().fold(f64::MAX, f64::min), all().fold(0.0, f64::max));
                error(value, value.clamp(low, high), brightest[i])
            })
            .fold(0.0, f64::max)
    }
}

/// A unit vector whose elevation is larger by an angle (radians).
fn tilted([x, y, z]: [f64; 3], angle: f64) -> [f64; 3] {
    let (elevation, azimuth) = (z.clamp(-1.0, 1.0).asin() + angle, y.atan2(x));
    let (sine, cosine) = elevation.sin_cos();
    [cosine * azimuth.cos(), cosine * azimuth.sin(), sine]
}

/// A vector in single precision as a unit vector in double.
fn unit(v: Vec3) -> [f64; 3] {
    v.as_dvec3().normalize().to_array()
}

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let s = &self.scene;
        let a = &s.atmosphere;
        let view = self.view.as_dvec3();
        write!(
            f,
            "error {:.2e}: {:e} instead of {:e} (scene's maximum {:.1e}) at {:.0} nm; view elevation {:.5}°, azimuth {:.3}°; sun {:.5}°; altitude {:.6} km; \
             planet {:.1} km, top {:.2} km, air {:.2e}/km over {:.3} km, aerosol {:.1e} over {:.3} km, ozone {:.1e} DU over {:.1}-{:.1}-{:.1} km",
            self.error,
            self.value,
            self.reference,
            self.brightest,
            self.wavelength,
            view.z.clamp(-1.0, 1.0).asin().to_degrees(),
            (-view.y).atan2(view.x).to_degrees(),
            s.sun.elevation,
            s.observer.altitude,
            a.ground_radius,
            a.top_radius - a.ground_radius,
            a.air.scattering,
            a.air.scale_height,
            a.aerosol.optical_depth,
            a.aerosol.scale_height,
            a.ozone.column,
            a.ozone.bottom,
            a.ozone.peak,
            a.ozone.top,
        )
    }
}

/// A number between two, its logarithm equally likely everywhere.
fn log_uniform(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    rng.random_range(low.ln()..=high.ln()).exp()
}

/// The number that single precision has for it, so that the oracle and the kernels see the same scene.
fn rounded(value: f64) -> f64 {
    f64::from(value as f32)
}

/// A valid scene, somewhere in the whole domain that a scene's keys allow: planets, scale heights, a ten-thousandth to
/// a thousand times the Earth's air, aerosol and ozone, observers on the ground, in the air and beyond, the sun at -90°
/// to 90°.
fn random_scene(rng: &mut ChaCha8Rng) -> Scene {
    let mut scene = Scene::preset(Preset::Earth).first_order();
    scene.render.fit = Fit::Transfer;
    scene.render.path = PathChoice::Direct;
    scene.render.exposure = Exposure::Stops(0.0);
    scene.render.bands = Some(random_bands(rng));
    scene.camera.size = "1x1".parse().expect("a size");
    if rng.random_bool(0.7) {
        randomise_planet(rng, &mut scene);
    }
    let strength = |rng: &mut ChaCha8Rng| if rng.random_bool(0.3) { 1.0 } else { log_uniform(rng, 1e-4, 1e3) };
    scene.atmosphere.air.scattering *= strength(rng);
    scene.atmosphere.aerosol.optical_depth *= if rng.random_bool(0.2) { 0.0 } else { strength(rng) };
    scene.atmosphere.ozone.column *= if rng.random_bool(0.3) { 0.0 } else { strength(rng) };
    clamp(&mut scene, "atmosphere.air.scattering", |s| &mut s.atmosphere.air.scattering);
    clamp(&mut scene, "atmosphere.aerosol.optical_depth", |s| &mut s.atmosphere.aerosol.optical_depth);
    clamp(&mut scene, "atmosphere.ozone.column", |s| &mut s.atmosphere.ozone.column);
    thin_the_top(&mut scene);
    scene.sun.elevation = random_sun(rng, &scene);
    scene.sun.azimuth = rng.random_range(-360.0..=360.0);
    scene.observer.altitude = random_altitude(rng, &scene);
    scene
}

/// Brings a number of a scene into its range.
fn clamp(scene: &mut Scene, name: &str, field: fn(&mut Scene) -> &mut f64) {
    let (low, high) = bounds(name, scene);
    let value = field(scene);
    *value = value.clamp(low, high);
}

fn random_bands(rng: &mut ChaCha8Rng) -> Vec<f64> {
    // One in each quarter, so that they lie apart.
    (0..4).map(|i| 360.0 + 117.5 * f64::from(i) + rng.random_range(0.0..=117.0)).collect()
}

fn randomise_planet(rng: &mut ChaCha8Rng, scene: &mut Scene) {
    let (smallest, largest) = bounds("atmosphere.ground_radius", scene);
    let earth = rng.random_bool(0.3);
    scene.atmosphere.ground_radius = if earth { 6360.0 } else { rounded(log_uniform(rng, smallest, largest)) };
    let (lowest_top, highest_top) = bounds("atmosphere.top_radius", scene);
    scene.atmosphere.top_radius = highest_top;
    scene.atmosphere.air.scale_height = random_scale_height(rng, scene, "atmosphere.air.scale_height");
    let a = &mut scene.atmosphere;
    let (least, most) = (lowest_top - a.ground_radius, highest_top - a.ground_radius);
    let depth = if rng.random_bool(0.6) { 12.5 * a.air.scale_height } else { log_uniform(rng, least, most) };
    let depth = rounded(depth.max(a.air.scale_height).clamp(least, most));
    a.top_radius = (a.ground_radius + depth).min(highest_top);
    clamp(scene, "atmosphere.air.scale_height", |s| &mut s.atmosphere.air.scale_height);
    scene.atmosphere.aerosol.scale_height = random_scale_height(rng, scene, "atmosphere.aerosol.scale_height");
    let a = &mut scene.atmosphere;
    let depth = a.top_radius - a.ground_radius;
    a.aerosol.single_scattering_albedo = rng.random_range(0.0..=1.0);
    a.aerosol.asymmetry = rng.random_range(-0.9..=0.99);
    a.aerosol.angstrom_exponent = rng.random_range(-1.0..=3.0);
    if depth < 40.0 || rng.random_bool(0.5) {
        let part = rng.random_range(0.0..0.8);
        let width = (0.95 - part) * rng.random_range(0.3..1.0);
        let peak = rng.random_range(0.2..0.8);
        a.ozone.bottom = rounded(depth * part);
        a.ozone.peak = rounded(a.ozone.bottom + (depth * width * peak).max(0.11));
        a.ozone.top = rounded(a.ozone.peak + (depth * width * (1.0 - peak)).max(0.11)).min(depth);
        if a.ozone.top - a.ozone.peak < 0.1 {
            a.ozone.column = 0.0;
        }
    }
}

/// A scale height (km) up to 100.
fn random_scale_height(rng: &mut ChaCha8Rng, scene: &Scene, name: &str) -> f64 {
    let (low, high) = bounds(name, scene);
    rounded(log_uniform(rng, low, high.min(100.0))).clamp(low, high)
}

fn random_sun(rng: &mut ChaCha8Rng, scene: &Scene) -> f64 {
    let a = &scene.atmosphere;
    let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let elevation = match rng.random_range(0..10) {
        0 => [-90.0, 0.0, 90.0, 5.0, -4.0][rng.random_range(0..5)],
        1 => side * log_uniform(rng, 1e-6, 1.0),
        // Where the last sunlit air at the zenith, or at the end of the farthest view, goes dark.
        2 => {
            let twilight = -directions::horizon(a.ground_radius, a.top_radius - a.ground_radius).to_degrees();
            let times = if rng.random_bool(0.5) { -1.0 } else { -2.0 };
            times * twilight * (1.0 + side * log_uniform(rng, 1e-6, 0.1))
        }
        3..7 => rng.random_range(-12.0..=12.0),
        _ => rng.random_range(-90.0..=90.0),
    };
    elevation.clamp(-90.0, 90.0)
}

fn random_altitude(rng: &mut ChaCha8Rng, scene: &Scene) -> f64 {
    let a = &scene.atmosphere;
    let depth = a.top_radius - a.ground_radius;
    let altitude = match rng.random_range(0..10) {
        0..3 => 0.0,
        3 => log_uniform(rng, 1e-4, bounds("observer.altitude", scene).1),
        4 => depth * [0.999_99, 1.0, 1.000_01][rng.random_range(0..3)],
        5 => depth * rng.random_range(0.0..=1.0),
        6 => depth + log_uniform(rng, 1e-3, 1000.0),
        7 => a.air.scale_height * rng.random_range(0.0..=10.0),
        _ => log_uniform(rng, 1e-3, 1000.0),
    };
    rounded(altitude)
}

/// A direction of a scene: the first rays are the special ones, the others lie anywhere, more of them near the horizon,
/// on the limb and near the sun.
fn random_view(rng: &mut ChaCha8Rng, scene: &Scene, index: u64) -> DVec3 {
    let a = &scene.atmosphere;
    let horizon = directions::horizon(a.ground_radius, scene.observer.altitude).to_degrees();
    let azimuth = scene.sun.azimuth
        + match rng.random_range(0..4) {
            0 => [0.0, 90.0, 180.0, -180.0][rng.random_range(0..4)],
            _ => rng.random_range(-180.0..=180.0),
        };
    let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let elevation = match index {
        0 => 90.0,
        1 => -90.0,
        2 => 0.0,
        3 => horizon,
        4 => return direction(scene.sun.elevation, scene.sun.azimuth),
        5 => return -direction(scene.sun.elevation, scene.sun.azimuth),
        6..12 => horizon + side * log_uniform(rng, 1e-6, 1.0),
        12..24 => limb(rng, scene).to_degrees(),
        24..30 => {
            let near = scene.sun.elevation + side * log_uniform(rng, 1e-6, 3.0);
            let toward = direction(near.clamp(-90.0, 90.0), scene.sun.azimuth + side * log_uniform(rng, 1e-6, 3.0));
            return if rng.random_bool(0.7) { toward } else { -toward };
        }
        30..40 => rng.random_range(-15.0..=15.0),
        _ => rng.random_range(-1.0..=1.0_f64).asin().to_degrees(),
    };
    direction(elevation.clamp(-90.0, 90.0), azimuth)
}

/// The elevation (radians) of a ray whose lowest point lies somewhere between the ground and the observer, or the top
/// of the atmosphere.
fn limb(rng: &mut ChaCha8Rng, scene: &Scene) -> f64 {
    let a = &scene.atmosphere;
    let highest = scene.observer.altitude.min(a.top_radius - a.ground_radius);
    let lowest_point = if rng.random_bool(0.5) {
        highest * rng.random_range(0.0..=1.0)
    } else {
        (a.air.scale_height * rng.random_range(0.0..=8.0)).min(highest)
    };
    directions::horizon(a.ground_radius + lowest_point, scene.observer.altitude - lowest_point).clamp(-FRAC_PI_2, PI)
}
