//! Steps: a plan chooses among counts, and where one choice follows the next no sky may jump.
//!
//! A case walks one number of a random sky in fine steps, at the colours' bands and in many directions. A smooth sky
//! changes from step to step as it does beside them; what it changes by more, relative to the brightest direction at a
//! band, is a jump.

use std::fmt;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::orders::{random_scene, seen};
use super::outcome::{Outcome, generator};
use sorairo::low_level::plan::light_field::LightFields;
use sorairo::low_level::plan::{SkyPlan, direction};
use sorairo::scene::{GroundAlbedo, Rgb, Scene};

/// What a jump may be, relative to the brightest direction: nobody sees a tenth of a per cent.
const BOUND: f64 = 1e-3;

/// Steps of a walk.
const STEPS: u32 = 16;

/// The largest optical depth of aerosol at [`BLUE`] that a walk meets.
const THICKEST: f64 = 4.0;

/// The shortest wavelength (nm) at which it is as large.
const BLUE: f64 = 400.0;

/// A number of a scene that is walked along.
struct Walk {
    name: &'static str,
    /// Its range, and the steps that all of it takes.
    range: (f64, f64),
    steps: u32,
    /// Whether its logarithm is what varies.
    is_wide: bool,
    set: fn(&mut Scene, f64),
}

/// All that light fields depend on. Steps are those of a slow sequence: a twentieth of a degree, 2 % of an optical
/// depth.
const WALKS: [Walk; 10] = [
    Walk {
        name: "the sun's elevation",
        range: (-12.0, 90.0),
        steps: 2040,
        is_wide: false,
        set: |scene, value| scene.sun.elevation = value,
    },
    Walk {
        name: "the sun's elevation, low",
        range: (-12.0, 12.0),
        steps: 480,
        is_wide: false,
        set: |scene, value| scene.sun.elevation = value,
    },
    Walk {
        name: "optical depth of aerosol",
        range: (1e-3, THICKEST),
        steps: 400,
        is_wide: true,
        set: |scene, value| {
            let aerosol = &mut scene.atmosphere.aerosol;
            aerosol.optical_depth = value * (BLUE / 1000.0).powf(aerosol.angstrom_exponent);
        },
    },
    Walk {
        name: "Ångström's exponent",
        range: (-0.5, 2.5),
        steps: 200,
        is_wide: false,
        set: |scene, value| {
            let aerosol = &mut scene.atmosphere.aerosol;
            // The optical depth at 550 nm is kept.
            aerosol.optical_depth *= 0.55f64.powf(value - aerosol.angstrom_exponent);
            aerosol.angstrom_exponent = value;
        },
    },
    Walk {
        name: "asymmetry of aerosol",
        range: (0.3, 0.85),
        steps: 200,
        is_wide: false,
        set: |scene, value| scene.atmosphere.aerosol.asymmetry = value,
    },
    Walk {
        name: "single-scattering albedo",
        range: (0.7, 1.0),
        steps: 120,
        is_wide: false,
        set: |scene, value| scene.atmosphere.aerosol.single_scattering_albedo = value,
    },
    Walk {
        name: "pressure",
        range: (300.0, 1050.0),
        steps: 200,
        is_wide: false,
        set: |scene, value| scene.atmosphere.air.pressure = value,
    },
    Walk {
        name: "ozone",
        range: (0.0, 600.0),
        steps: 120,
        is_wide: false,
        set: |scene, value| scene.atmosphere.ozone.column = value,
    },
    Walk {
        name: "the ground's albedo",
        range: (0.0, 1.0),
        steps: 120,
        is_wide: false,
        set: |scene, value| scene.ground.albedo = GroundAlbedo::Grey(value),
    },
    Walk {
        name: "the observer's altitude",
        range: (1e-3, 100.0),
        // Half a per cent each: where an observer rises through the edge of the ozone, light itself has a kink.
        steps: 2400,
        is_wide: true,
        set: |scene, value| scene.observer.altitude = value,
    },
];

impl Walk {
    /// The value after so many steps from the beginning of the range.
    fn value(&self, step: u32) -> f64 {
        let part = f64::from(step) / f64::from(self.steps);
        let (low, high) = self.range;
        if self.is_wide { low * (high / low).powf(part) } else { low + (high - low) * part }
    }
}

/// A walk through a sky.
struct Case {
    walk: &'static Walk,
    scene: Scene,
    /// The largest jump over what is allowed, to this scene and in which direction.
    error: f64,
    view: (f64, f64),
}

/// Walks through random skies.
pub fn steps(seed: u64, cases: u64) -> Outcome {
    let found: Vec<Case> = (0..cases).into_par_iter().map(|number| Case::random(seed, number)).collect();
    Outcome::of_cases("steps of the plan along a number of a scene", seed, cases, &found, |case| case.error)
}

impl Case {
    fn random(seed: u64, number: u64) -> Self {
        let rng = &mut generator(seed, number);
        let mut scene = random_scene(rng);
        if rng.random() {
            thicken(&mut scene, rng);
        }
        let walk = &WALKS[number as usize % WALKS.len()];
        let first = rng.random_range(0..=walk.steps - STEPS);
        let light_fields = LightFields::default();
        let walked = |step: u32| {
            let mut scene = scene.clone();
            (walk.set)(&mut scene, walk.value(first + step));
            light(&scene, &light_fields)
        };
        let skies: Vec<Vec<Vec<f64>>> = (0..=STEPS).map(walked).collect();
        let (jump, step, view) = largest_jump(&skies);
        (walk.set)(&mut scene, walk.value(first + step));
        Self { walk, error: jump / BOUND, view: views(&scene)[view], scene }
    }
}

/// Haze up to [`THICKEST`].
fn thicken(scene: &mut Scene, rng: &mut ChaCha8Rng) {
    let aerosol = &mut scene.atmosphere.aerosol;
    let thickest = THICKEST * (BLUE / 1000.0).powf(aerosol.angstrom_exponent.max(0.0));
    aerosol.optical_depth = thickest * 10f64.powf(rng.random_range(-2.0..=0.0));
}

/// Directions (degrees) over the sky and, from above it, the ground: none where the horizon passes as an observer
/// climbs.
fn views(scene: &Scene) -> Vec<(f64, f64)> {
    const ABOVE: [f64; 5] = [1.0, 5.0, 15.0, 40.0, 85.0];
    const BELOW: [f64; 3] = [-85.0, -60.0, -35.0];
    let below = if scene.observer.altitude > 0.0 { &BELOW[..] } else { &[] };
    let elevations = ABOVE.iter().chain(below);
    elevations
        .flat_map(|&elevation| [10.0, 60.0, 120.0, 170.0].map(|azimuth| (elevation, scene.sun.azimuth + azimuth)))
        .collect()
}

/// Transfer in those directions at the colours' bands.
fn light(scene: &Scene, light_fields: &LightFields) -> Vec<Vec<f64>> {
    let sky = SkyPlan::with_light_fields(&scene.validated().expect("a valid scene"), Rgb::Srgb, light_fields);
    let integral = sky.integral();
    views(scene)
        .iter()
        .map(|&(elevation, azimuth)| integral.transfer(direction(elevation, azimuth).as_vec3()))
        .collect()
}

/// The largest jump between two skies of a walk, relative to the brightest direction at a band, the step before which
/// it is and the number of its direction.
fn largest_jump(skies: &[Vec<Vec<f64>>]) -> (f64, u32, usize) {
    let mut largest = (0.0f64, 0, 0);
    for (step, four) in skies.windows(4).enumerate() {
        let bands = four[1][0].len();
        for band in 0..bands {
            let brightest = four[1].iter().map(|ray| ray[band]).fold(0.0, f64::max);
            let rays = four[0].iter().zip(&four[1]).zip(four[2].iter().zip(&four[3])).enumerate();
            for (view, ((a, b), (c, d))) in rays {
                let light = [a[band], b[band], c[band], d[band]];
                let change = |i: usize| light[i + 1] - light[i];
                let jump = (change(1) - 0.5 * (change(0) + change(2))).abs() / brightest;
                // A jump that is no number is the largest.
                if jump.is_nan() || jump > largest.0 {
                    largest = (jump, step as u32 + 2, view);
                }
            }
        }
    }
    largest
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { walk, scene, error, view } = self;
        write!(f, "{error:.2} of what is allowed along {}; {}", walk.name, seen(scene, *view))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sorairo::scene::{Orders, Preset};

    fn walk(orders: fn(u32) -> Orders) -> f64 {
        let mut scene = Scene::preset(Preset::Hazy);
        let light_fields = LightFields::default();
        let skies = (0..8).map(|step| {
            scene.sun.elevation = 30.0 + 0.05 * f64::from(step);
            scene.render.orders = orders(step);
            light(&scene, &light_fields)
        });
        largest_jump(&skies.collect::<Vec<_>>()).0
    }

    #[test]
    fn a_sky_that_loses_an_order_on_its_way_is_found() {
        let (still, lost) = (walk(|_| Orders::All), walk(|step| if step < 4 { Orders::All } else { Orders::UpTo(6) }));
        assert!(still < 0.1 * BOUND && lost > BOUND, "{still:e}, {lost:e}");
    }

    /// Walks the asymmetry of a scene's aerosol from a value on.
    fn assert_no_jump_of_asymmetry(mut scene: Scene, first: f64) {
        let light_fields = LightFields::default();
        let skies = (0..10).map(|step| {
            scene.atmosphere.aerosol.asymmetry = first + 0.00275 * f64::from(step);
            light(&scene, &light_fields)
        });
        let (jump, step, _) = largest_jump(&skies.collect::<Vec<_>>());
        assert!(jump < BOUND, "{jump:e} at step {step}");
    }

    #[test]
    fn no_sky_jumps_where_aerosol_begins_to_have_a_forward_peak() {
        let mut scene = Scene::preset(Preset::Earth);
        scene.sun.elevation = 1.86;
        scene.atmosphere.aerosol.optical_depth = 0.66;
        assert_no_jump_of_asymmetry(scene, 0.8);
    }

    /// Where the number of directions between the level and the horizon followed that of moments, light at 700 nm jumped
    /// by up to a hundredth of a ray.
    #[test]
    fn no_twilight_in_haze_jumps_where_it_needs_more_moments() {
        let mut scene = Scene::preset(Preset::Standard).in_closed_form();
        (scene.sun.elevation, scene.atmosphere.air.pressure) = (-9.72, 596.0);
        scene.atmosphere.ozone.column = 471.0;
        let aerosol = &mut scene.atmosphere.aerosol;
        (aerosol.optical_depth, aerosol.angstrom_exponent, aerosol.scale_height) = (1.396, 0.19, 2.68);
        aerosol.single_scattering_albedo = 0.81;
        scene.ground.albedo = GroundAlbedo::Grey(0.0);
        for first in [0.64, 0.715, 0.76, 0.795] {
            assert_no_jump_of_asymmetry(scene.clone(), first);
        }
    }

    #[test]
    fn a_jump_is_found_between_the_skies_where_it_is_and_what_is_no_number_fails() {
        let sky = |step: u32, jump: f64| vec![vec![1.0 + 0.1 * f64::from(step) + jump], vec![0.5]];
        let skies: Vec<_> = (0..10).map(|step| sky(step, if step < 6 { 0.0 } else { 0.02 })).collect();
        let (jump, step, view) = largest_jump(&skies);
        // 0.02 of the 1.5 before it.
        assert!((jump - 0.02 / 1.5).abs() < 1e-12 && (step, view) == (6, 0), "{jump}, {step}, {view}");
        let dark: Vec<_> = (0..10).map(|step| sky(step, if step < 6 { 0.0 } else { f64::NAN })).collect();
        assert!(largest_jump(&dark).0.is_nan());
    }
}
