//! Random scenes over everything that may be asked for: every pixel is a finite light, and no picture is lost.

use sorairo::PixelFormat;
use sorairo::low_level::device::Backend;
use sorairo::low_level::device::cpu::Cpu;
use sorairo::low_level::plan::direction;
use sorairo::scene::{Fit, Preset, Projection};
use sorairo_evaluation::stress::scenes::{refusals, scenes};
use sorairo_tests::gpu;
use sorairo_tests::sky::{plan_of, scene};

/// The seed of the random cases; a failure names its case.
const SEED: u64 = 20_261_121;

/// As many scenes as take a minute of two cores; `sorairo stress` tries more.
const SCENES: u64 = 30;

#[test]
fn no_pixel_of_random_scenes_is_wrong_on_either_device() {
    let outcome = scenes(SEED, SCENES, gpu::device());
    println!("{outcome:?}");
    assert_eq!((outcome.cases, outcome.failures), (SCENES, 0), "{outcome:?}");
}

#[test]
fn a_value_out_of_range_is_refused_in_one_sentence() {
    let outcome = refusals(SEED, 20_000);
    println!("{outcome:?}");
    assert_eq!((outcome.cases, outcome.failures), (20_000, 0), "{outcome:?}");
}

/// Light that has crossed everything leaves 1e-40, and the exposure for that was infinite.
#[test]
fn a_nearly_black_sky_has_an_exposure() {
    let mut scene = scene(Preset::Earth, 90.0, "16x8");
    (scene.sun.distance, scene.atmosphere.aerosol.optical_depth) = (1000.0, 84.0);
    scene.render.fit = Fit::Transfer;
    let plan = plan_of(&scene, PixelFormat::Picture);
    let sky = plan.radiance(direction(60.0, 0.0).as_vec3()).y;
    // A quarter of a picture's white divided by less than this is beyond single precision.
    assert!(sky > 0.0 && sky < 0.25 / f32::MAX, "{sky:e}");
    assert_eq!(plan.uniform.exposure, (1u64 << 50) as f32);
}

/// From 36 000 km no direction that the exposure was measured in met the planet, and its picture was as dark as a
/// night's.
#[test]
fn a_planet_far_away_is_exposed_as_one_close_by() {
    let exposure = |altitude: f64| {
        let mut scene = scene(Preset::Earth, 60.0, "64x64");
        scene.observer.altitude = altitude;
        plan_of(&scene, PixelFormat::Picture).uniform.exposure
    };
    let (near, far, farthest) = (exposure(1000.0), exposure(36_000.0), exposure(1e5));
    // The whole disc has a darker rim than its middle, and from farthest it takes one pixel and a half of this picture.
    assert!((0.3..3.0).contains(&(far / near)) && (0.7..1.4).contains(&(farthest / far)), "{near} {far} {farthest}");
}

/// A layer without ozone may be of no thickness: its density was 0/0, and every pixel NaN.
#[test]
fn ozone_that_is_not_there_may_be_anywhere() {
    let words = |peak: f64| {
        let mut scene = scene(Preset::Paper, 20.0, "16x8");
        scene.camera.projection = Projection::Fisheye;
        let ozone = &mut scene.atmosphere.ozone;
        (ozone.bottom, ozone.peak, ozone.top) = (peak, peak, peak);
        let plan = plan_of(&scene, PixelFormat::LinearRgb);
        Cpu.run(&plan, plan.kernel()).unwrap().words
    };
    let usual = words(25.0);
    assert!(usual.iter().all(|&word| f32::from_bits(word).is_finite()) && usual.iter().any(|&word| word != 0));
    assert_eq!(words(0.0), usual);
    assert_eq!(words(f64::NAN), usual);
}
