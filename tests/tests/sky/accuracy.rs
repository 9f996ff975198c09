//! The kernels in single precision against the oracle.

use rayon::prelude::*;
use sorairo::PixelFormat;
use sorairo::low_level::plan::direction;
use sorairo::scene::{Preset, Scene};
use sorairo_evaluation::judge::{bands, medium, ray};
use sorairo_oracle::scattered_radiance_bands_within;
use sorairo_tests::compare::{Worst, worst_relative};
use sorairo_tests::sky::{SUNS, plan_of, scene};

/// Elevations (degrees) that resolve the horizon.
const ELEVATIONS: [f64; 16] = [0.0, 0.1, 0.3, 0.7, 1.5, 3.0, 5.0, 8.0, 12.0, 18.0, 26.0, 36.0, 48.0, 62.0, 77.0, 90.0];

/// The oracle's tolerance: a thousandth of what is allowed.
const REFERENCE_TOLERANCE: f64 = 1e-6;

/// The transfer at the plan's bands against the oracle, over the sky; brighter than a part of the sky's maximum.
fn compare_sky(scene: &Scene, above: f64) -> Worst {
    let plan = plan_of(scene, PixelFormat::LinearRgb);
    let bands = bands(scene, plan.sky.plan());
    let medium = medium(scene);
    let azimuths = (0..=12).map(|i| 15.0 * f64::from(i));
    let views: Vec<(f64, f64)> =
        azimuths.flat_map(|azimuth| ELEVATIONS.map(|elevation| (elevation, azimuth))).collect();
    let pairs: Vec<(f64, f64, String)> = views
        .into_par_iter()
        .flat_map_iter(|(elevation, azimuth)| {
            let view = direction(elevation, azimuth).as_vec3();
            let values = plan.sky.plan().integral().transfer(view);
            let references =
                scattered_radiance_bands_within(REFERENCE_TOLERANCE, &medium, &bands, &ray(scene, elevation, azimuth));
            let triples = values.into_iter().zip(references).zip(&plan.sky.plan().integral().wavelengths);
            triples.map(move |((value, reference), nm)| {
                (value, reference, format!("elevation {elevation}, azimuth {azimuth}, {nm} nm"))
            })
        })
        .collect();
    let brightest = pairs.iter().map(|pair| pair.1).fold(0.0, f64::max);
    worst_relative(pairs, above * brightest)
}

#[test]
fn radiance_agrees_with_the_oracle_over_the_whole_sky() {
    for preset in [Preset::Earth, Preset::Paper] {
        for sun in SUNS {
            let worst = compare_sky(&scene(preset, sun, "8x4"), 0.0);
            println!("{preset:?}, sun at {sun}: {:.1e} at {}", worst.relative, worst.place);
            // The goal of the default step count.
            assert!(worst.relative <= 1e-3, "{preset:?}, sun at {sun}: {worst:?}");
        }
    }
}
