//! Light between two points: what the air before a point adds, and what it lets through of the light behind it, are
//! together the light of the whole ray.
//!
//! A case is a ray through a random sky, and a point on it. With the path radiance `L` and the transmittance `T`
//!
//! ```text
//! L(observer to end) = L(observer to P) + T(observer to P) · L(P to end)
//! ```
//!
//! where the last is computed for an observer at the point, under the sun that is seen there: its light field stands
//! about other suns, and its samples elsewhere. The end is where the ray leaves the air or meets the ground.

use std::fmt;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use sorairo::low_level::medium::aerosol::AerosolKind;
use sorairo::low_level::plan::direction;
use sorairo::low_level::plan::light_field::LightFields;
use sorairo::scene::{Preset, Rgb, Scene};
use sorairo::{AirBetween, BetweenSample, Direction, Sky};
use sorairo_shared::glam::DVec3;

use super::orders::{random_scene, seen};
use super::outcome::{Outcome, generator};

/// A ray is judged relative to its own light, or to this part of the brightest of its sky.
const FLOOR: f64 = 0.05;

/// An optical depth of aerosol above which one case of 300 left more than [`Allowed::DAY`]; none below did.
const THICK: f64 = 3.0;

/// What the two sides may differ by. Both come from light fields about other suns.
struct Allowed {
    /// Relative to the brightest wavelength of the ray, or to [`FLOOR`] of the brightest of some rays.
    of_ray: f64,
    /// Relative to the brightest of some rays of the sky.
    of_brightest: f64,
}

impl Allowed {
    /// Of 100 352 pairs of 1568 skies ten exceeded what is allowed, by 2.4 times at most, in two skies that are tests
    /// now.
    const DAY: Self = Self { of_ray: 2e-3, of_brightest: 1e-3 };
    /// Of 300 cases the largest was 1.7e-3 of either.
    const IN_THICK_AIR: Self = Self { of_ray: 3e-3, of_brightest: 3e-3 };
    /// With the sun below -6°. Of 770 cases the largest was 2.4e-3 of the ray and 2.2e-3 of the brightest; of the
    /// latter, one was above 1e-3.
    const LATE: Self = Self { of_ray: 5e-3, of_brightest: 3e-3 };

    fn of(scene: &Scene) -> Self {
        if scene.sun.elevation < -6.0 {
            Self::LATE
        } else if scene.atmosphere.aerosol.optical_depth > THICK {
            Self::IN_THICK_AIR
        } else {
            Self::DAY
        }
    }
}

/// Wavelengths (nm).
const WAVELENGTHS: [f64; 4] = [400.0, 500.0, 600.0, 700.0];

/// A ray and a point on it.
pub struct Case {
    scene: Scene,
    /// Elevation and azimuth (degrees).
    view: (f64, f64),
    /// Of the point (km).
    distance: f64,
    /// How far both sides are apart, over what is allowed.
    pub error: f64,
}

/// Pairs of a sky: their light fields are made once.
const PAIRS: usize = 64;

/// Compares random rays of so many random skies.
pub fn between(seed: u64, skies: u64) -> Outcome {
    let found: Vec<Case> = (0..skies).into_par_iter().flat_map_iter(|number| Case::of_sky(seed, number)).collect();
    let pairs = found.len() as u64;
    let subject = "light before a point and through it against that of the whole ray";
    Outcome::of_cases(subject, seed, pairs, &found, |case| case.error)
}

impl Case {
    /// Those of a sky, by its number.
    fn of_sky(seed: u64, number: u64) -> Vec<Self> {
        let rng = &mut generator(seed, number);
        let scene = random_air(rng);
        let light_fields = LightFields::default();
        let here = air(&scene, &light_fields);
        let brightest = (0..8).map(|_| peak(&whole(&here, random_view(rng, &scene)))).fold(0.0, f64::max);
        let pair = |_| {
            let view = random_view(rng, &scene);
            // Where the ray is still in the air: most of it lies near one end.
            let distance = rng.random_range(0.0..1.0f64).powi(2) * length(&scene, view);
            Self::compared(&scene, (&here, brightest), &light_fields, (view, distance))
        };
        (0..PAIRS).map(pair).collect()
    }

    /// A ray and the distance of a point on it, under a sky with the light of the brightest of some rays.
    fn compared(
        scene: &Scene,
        (here, brightest): (&AirBetween, f64),
        light_fields: &LightFields,
        (view, distance): ((f64, f64), f64),
    ) -> Self {
        let all = whole(here, view);
        let near = here.until(&towards(view), distance).expect("a distance before the ground");
        let (there, onwards) = from_there(scene, view, distance);
        let far = whole(&air(&there, light_fields), onwards);
        let own = peak(&all);
        let Allowed { of_ray, of_brightest } = Allowed::of(scene);
        let allowed = (own.max(FLOOR * brightest) * of_ray).min(own.max(brightest) * of_brightest);
        let off = |((near, far), all): ((&BetweenSample, &BetweenSample), &BetweenSample)| {
            (near.radiance + near.transmittance * far.radiance - all.radiance).abs()
        };
        let off = near.iter().zip(&far).zip(&all).map(off).fold(0.0, f64::max);
        let error = if off == 0.0 { 0.0 } else { off / allowed };
        Self { scene: scene.clone(), view, distance, error }
    }
}

/// A sky of any air that a scene may name, seen from anywhere between the ground and orbit, of three one about sunset.
fn random_air(rng: &mut ChaCha8Rng) -> Scene {
    let mut scene = random_scene(rng);
    if rng.random_ratio(1, 3) {
        scene.sun.elevation = rng.random_range(-3.0..3.0);
    }
    if rng.random() {
        return scene;
    }
    let presets = [Preset::Standard, Preset::Earth, Preset::Hazy, Preset::Mars];
    let mut other = Scene::preset(presets[rng.random_range(0..presets.len())]);
    if other.atmosphere.profile.is_measured() && rng.random() {
        other.atmosphere.aerosol.kind = AerosolKind::Desert;
    }
    (other.sun.elevation, other.observer.altitude) = (scene.sun.elevation, scene.observer.altitude);
    other
}

/// A direction (degrees) in which there is air.
fn random_view(rng: &mut ChaCha8Rng, scene: &Scene) -> (f64, f64) {
    let atmosphere = &scene.atmosphere;
    let nearest = atmosphere.top_radius / (atmosphere.ground_radius + scene.observer.altitude);
    let highest = if nearest < 1.0 { -nearest.acos().to_degrees() } else { 90.0 };
    let lowest = if scene.observer.altitude > 0.0 { -90.0 } else { 0.2 };
    (rng.random_range(lowest..highest), scene.sun.azimuth + rng.random_range(0.0..=180.0))
}

/// How long the ray is (km) that ends on the ground, or where it leaves the air.
fn length(scene: &Scene, (elevation, _): (f64, f64)) -> f64 {
    let atmosphere = &scene.atmosphere;
    let from = atmosphere.ground_radius + scene.observer.altitude;
    let (sine, cosine) = elevation.to_radians().sin_cos();
    let half = |radius: f64| (radius * radius - (from * cosine).powi(2)).max(0.0).sqrt();
    let meets_ground = sine < 0.0 && from * cosine < atmosphere.ground_radius;
    if meets_ground {
        -from * sine - half(atmosphere.ground_radius)
    } else {
        -from * sine + half(atmosphere.top_radius)
    }
}

fn air(scene: &Scene, light_fields: &LightFields) -> AirBetween {
    let sky = Sky::with_light_fields(&scene.validated().expect("a valid scene"), Rgb::Srgb, light_fields);
    sky.between(&WAVELENGTHS).expect("wavelengths of light")
}

fn towards((elevation, azimuth): (f64, f64)) -> Direction {
    Direction { elevation, azimuth }
}

/// All air in a direction, up to the ground where it is seen.
fn whole(air: &AirBetween, view: (f64, f64)) -> Vec<BetweenSample> {
    let ground = air.ground(&towards(view)).expect("a direction");
    air.until(&towards(view), ground.unwrap_or(f64::INFINITY)).expect("a distance up to the ground")
}

fn peak(samples: &[BetweenSample]) -> f64 {
    samples.iter().map(|sample| sample.radiance).fold(0.0, f64::max)
}

/// The scene as one sees it from a distance (km) along a ray of an elevation and an azimuth (degrees), and the
/// direction in which the ray goes on there.
pub fn from_there(scene: &Scene, (elevation, azimuth): (f64, f64), distance: f64) -> (Scene, (f64, f64)) {
    let radius = scene.atmosphere.ground_radius;
    let view = direction(elevation, azimuth);
    let sun = direction(scene.sun.elevation, scene.sun.azimuth);
    let place = DVec3::Z * (radius + scene.observer.altitude) + view * distance;
    let up = place.normalize();
    let mut there = scene.clone();
    there.observer.altitude = (place.length() - radius).max(0.0);
    (there.sun.elevation, there.sun.azimuth) = (up.dot(sun).clamp(-1.0, 1.0).asin().to_degrees(), 0.0);
    (there, (up.dot(view).clamp(-1.0, 1.0).asin().to_degrees(), azimuth_between(view, sun, up)))
}

/// The angle between two directions about the vertical (degrees).
fn azimuth_between(a: DVec3, b: DVec3, up: DVec3) -> f64 {
    let level = |v: DVec3| (v - up * v.dot(up)).normalize_or_zero();
    level(a).dot(level(b)).clamp(-1.0, 1.0).acos().to_degrees()
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, view, distance, error } = self;
        write!(f, "{error:.2} of what is allowed, {distance:.3} km away; {}", seen(scene, *view))
    }
}

#[cfg(test)]
mod tests {
    use sorairo::scene::{GroundAlbedo, Profile};

    use super::*;

    /// Part by part, so that what was found is told while the rest runs.
    #[test]
    #[ignore = "40 minutes of two cores"]
    fn air_before_a_point_and_light_behind_it_are_the_whole_ray_a_hundred_thousand_times() {
        let (mut pairs, mut failed) = (0, vec![]);
        for seed in 20261129..20261129 + 32 {
            let outcome = between(seed, 49);
            println!("{outcome:?}");
            pairs += outcome.cases;
            failed.extend((outcome.failures > 0).then_some(outcome));
        }
        assert!(pairs >= 100_000 && failed.is_empty(), "{pairs} pairs, {failed:?}");
    }

    /// The light fields of the two ends have other numbers of directions.
    #[test]
    fn a_ray_above_the_limb_is_as_bright_from_nearer() {
        let mut scene = Scene::preset(Preset::Earth);
        (scene.observer.altitude, scene.sun.elevation) = (236.88, 21.43);
        scene.atmosphere.aerosol.scale_height = 2.0;
        scene.atmosphere.aerosol.asymmetry = 0.735;
        // Two directions below the level leave 3, four less than a tenth of that.
        judged(scene, (-13.85, 106.2), 359.637);
    }

    #[test]
    fn light_from_behind_under_another_sun_is_told() {
        let mut scene = Scene::preset(Preset::Standard);
        scene.sun.elevation = 20.0;
        let (view, distance) = ((2.0, 60.0), 30.0);
        let light_fields = LightFields::default();
        let here = air(&scene, &light_fields);
        let near = here.until(&towards(view), distance).unwrap();
        let (mut there, onwards) = from_there(&scene, view, distance);
        let off = |there: &Scene| {
            let far = whole(&air(there, &light_fields), onwards);
            let all = whole(&here, view);
            let sum = |i: usize| near[i].radiance + near[i].transmittance * far[i].radiance;
            (0..4).map(|i| (sum(i) - all[i].radiance).abs() / peak(&all)).fold(0.0, f64::max)
        };
        let right = off(&there);
        there.sun.elevation += 3.0;
        assert!(right < 1e-3 && off(&there) > 2.0 * Allowed::DAY.of_ray, "{right}, {}", off(&there));
    }

    /// The panels of a ray from thin air are short where haze begins below: with those that suit the thin air, this was
    /// 2.3 times what is allowed.
    #[test]
    fn haze_far_below_is_as_bright_from_nearer() {
        let mut scene = Scene::preset(Preset::Standard);
        (scene.observer.altitude, scene.sun.elevation) = (18.717, -5.227);
        scene.atmosphere.profile = Profile::Exponential;
        scene.atmosphere.refraction = false;
        let aerosol = &mut scene.atmosphere.aerosol;
        aerosol.kind = AerosolKind::Plain;
        (aerosol.optical_depth, aerosol.angstrom_exponent, aerosol.scale_height) = (1.985, 0.623, 1.095);
        (aerosol.single_scattering_albedo, aerosol.asymmetry) = (0.877, 0.747);
        scene.atmosphere.water.column = None;
        scene.ground.albedo = GroundAlbedo::Grey(0.0);
        judged(scene, (-60.49, 60.0), 18.794);
    }

    /// Light from dust that lies high comes from where the sun stands twelve degrees lower: with five, this was 2.4
    /// times what is allowed.
    #[test]
    fn the_dust_of_mars_is_as_bright_from_nearer() {
        let mut scene = Scene::preset(Preset::Mars);
        (scene.observer.altitude, scene.sun.elevation) = (0.739, 14.414);
        judged(scene, (10.74, 177.1), 0.891);
    }

    /// Judges the two sides of a ray by its own light.
    fn judged(scene: Scene, (elevation, from_sun): (f64, f64), distance: f64) {
        let light_fields = LightFields::default();
        let here = air(&scene, &light_fields);
        let view = (elevation, scene.sun.azimuth + from_sun);
        let case = Case::compared(&scene, (&here, 0.0), &light_fields, (view, distance));
        assert!(case.error > 0.0 && case.error < 0.5, "{case}");
    }
}
