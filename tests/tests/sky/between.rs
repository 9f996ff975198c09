//! Light between two points, against the light of whole rays from both, and against Koschmieder's law.

use rayon::prelude::*;
use sorairo::low_level::plan::direction;
use sorairo::low_level::spectrum::{DenseSpectrum, Direction};
use sorairo::scene::{GroundAlbedo, Orders, Preset, Rgb, Scene};
use sorairo::{AirBetween, BetweenSample, SkyPlan};
use sorairo_shared::glam::DVec3;

const WAVELENGTHS: [f64; 4] = [400.0, 500.0, 600.0, 700.0];

fn sky(scene: &Scene) -> SkyPlan {
    SkyPlan::new(&scene.validated().unwrap(), Rgb::Srgb)
}

fn between(sky: &SkyPlan, elevation: f64, azimuth: f64, distance: f64) -> Vec<BetweenSample> {
    AirBetween::new(sky, &WAVELENGTHS).unwrap().until(&Direction { elevation, azimuth }, distance).unwrap()
}

/// The angle between two directions about the vertical (degrees).
fn azimuth_between(a: DVec3, b: DVec3, up: DVec3) -> f64 {
    let level = |v: DVec3| (v - up * v.dot(up)).normalize();
    level(a).dot(level(b)).clamp(-1.0, 1.0).acos().to_degrees()
}

/// The scene as one sees it from a distance (km) along a ray, and the direction in which the ray goes on there.
fn from_there(scene: &Scene, (elevation, azimuth): (f64, f64), distance: f64) -> (Scene, Direction) {
    let radius = scene.atmosphere.ground_radius;
    let view = direction(elevation, azimuth);
    let sun = direction(scene.sun.elevation, scene.sun.azimuth);
    let place = DVec3::Z * (radius + scene.observer.altitude) + view * distance;
    let up = place.normalize();
    let mut there = scene.clone();
    there.observer.altitude = (place.length() - radius).max(0.0);
    (there.sun.elevation, there.sun.azimuth) = (up.dot(sun).asin().to_degrees(), 0.0);
    (there, Direction { elevation: up.dot(view).asin().to_degrees(), azimuth: azimuth_between(view, sun, up) })
}

/// `L(from) = L(from to P) + T L(P)`: from the ground, a hill, an aeroplane, a balloon and orbit; up, level, down and through the limb.
#[test]
fn light_of_a_ray_is_that_of_its_near_part_and_what_comes_through_it() {
    let measured = Scene::preset(Preset::Standard);
    let cases = [
        (0.0, 40.0, (3.0, 60.0), 30.0),
        (0.0, 5.0, (0.5, 20.0), 80.0),
        (0.0, -4.0, (8.0, 10.0), 60.0),
        (1.0, 20.0, (-3.0, 100.0), 10.0),
        (12.0, 30.0, (-10.0, 45.0), 40.0),
        (12.0, 2.0, (-2.0, 30.0), 150.0),
        (12.0, -6.0, (1.0, 90.0), 100.0),
        (40.0, 10.0, (-5.0, 150.0), 500.0),
        (400.0, 30.0, (-30.0, 20.0), 750.0),
        (400.0, 0.0, (-19.2, 0.0), 2000.0),
    ];
    for preset in [measured.clone(), Scene::preset(Preset::Hazy)] {
        for (altitude, sun, (elevation, azimuth), distance) in cases {
            let mut scene = preset.clone();
            (scene.observer.altitude, scene.sun.elevation) = (altitude, sun);
            let here = sky(&scene);
            let whole = DenseSpectrum::new(&here, &WAVELENGTHS).radiance(direction(elevation, azimuth).as_vec3());
            let (there, onwards) = from_there(&scene, (elevation, azimuth), distance);
            let far = DenseSpectrum::new(&sky(&there), &WAVELENGTHS).radiance(onwards.vector().unwrap());
            let near = between(&here, elevation, azimuth, distance);
            let brightest = whole.iter().copied().fold(0.0, f64::max);
            let what = format!("{:?}, {altitude} km, sun at {sun}°, {elevation}° up, {distance} km", scene.began_as());
            assert!(brightest > 0.0);
            for ((sample, whole), far) in near.iter().zip(&whole).zip(&far) {
                let found = sample.radiance + sample.transmittance * far;
                let off = (found - whole).abs() / brightest;
                println!("{what}, {} nm: {found:e}, {whole:e}, {off:.1e}", sample.wavelength_nm);
                // What lookups of light scattered more than once leave of whole rays, from both places.
                assert!(off < 3e-3, "{what}, {} nm: {found:e}, not {whole:e}", sample.wavelength_nm);
                assert!(sample.radiance > 0.0 && sample.radiance < whole * 1.003, "{what}");
            }
        }
    }
}

/// Air of one density scatters as much towards the observer from every distance, and weakens it: Koschmieder 1924.
#[test]
fn a_level_way_through_haze_brightens_as_koschmieder_says() {
    let mut scene = Scene::preset(Preset::Earth);
    let atmosphere = &mut scene.atmosphere;
    (atmosphere.air.scattering, atmosphere.ozone.column) = (0.0, 0.0);
    (atmosphere.aerosol.optical_depth, atmosphere.aerosol.scale_height) = (0.5, 8.0);
    scene.ground.albedo = GroundAlbedo::Grey(0.0);
    let extinction: f64 = 0.5 / 8.0;
    // The way rises by 8 m over 10 km, a thousandth of the scale height; light of all orders is brighter where it ends, by as much again.
    for (orders, tolerance) in [(Orders::UpTo(1), 1.5e-3), (Orders::All, 4e-3)] {
        scene.render.orders = orders;
        let sky = sky(&scene);
        for (short, long) in between(&sky, 0.0, 90.0, 5.0).iter().zip(between(&sky, 0.0, 90.0, 10.0)) {
            for (found, expected) in [
                (short.transmittance, (-5.0 * extinction).exp()),
                (long.transmittance, (-10.0 * extinction).exp()),
                (
                    long.radiance / short.radiance,
                    (1.0 - (-10.0 * extinction).exp()) / (1.0 - (-5.0 * extinction).exp()),
                ),
            ] {
                assert!((found / expected - 1.0).abs() < tolerance, "{orders:?}: {found}, not {expected}");
            }
        }
    }
}

#[test]
fn no_distance_changes_nothing_and_all_of_it_is_the_sky() {
    let mut scene = Scene::preset(Preset::Standard);
    scene.sun.elevation = 20.0;
    let sky = sky(&scene);
    for sample in between(&sky, 10.0, 40.0, 0.0) {
        assert_eq!((sample.transmittance, sample.radiance), (1.0, 0.0));
    }
    let whole = DenseSpectrum::new(&sky, &WAVELENGTHS).radiance(direction(10.0, 40.0).as_vec3());
    for (sample, whole) in between(&sky, 10.0, 40.0, f64::INFINITY).iter().zip(whole) {
        // The light scattered more than once is seen through the rows of a lookup there.
        assert!((sample.radiance / whole - 1.0).abs() < 2e-3, "{sample:?}, {whole:e}");
        assert!(sample.transmittance > 0.0 && sample.transmittance < 0.99, "{sample:?}");
    }
    // Near the observer light grows with the distance, without steps.
    let ways = [0.001, 0.01, 0.1, 1.0];
    let light: Vec<f64> = ways.par_iter().map(|&way| between(&sky, 0.0, 40.0, way)[0].radiance / way).collect();
    assert!(light.windows(2).all(|pair| (pair[1] / pair[0] - 1.0).abs() < 0.1), "{light:?}");
}

#[test]
fn what_lies_below_the_ground_is_no_distance() {
    let mut scene = Scene::preset(Preset::Standard);
    scene.observer.altitude = 1.0;
    let air = AirBetween::new(&sky(&scene), &[550.0]).unwrap();
    let refused = |elevation: f64, distance: f64| {
        air.until(&Direction { elevation, azimuth: 0.0 }, distance).unwrap_err().to_string()
    };
    // 1 km straight down, or over a hypotenuse.
    assert!(refused(-90.0, 1.1).starts_with("distance is 1.1 km, and the ground is 1.000 km away there"));
    assert!(refused(-30.0, f64::INFINITY).contains("the ground is 2.00"), "{}", refused(-30.0, f64::INFINITY));
    assert!(refused(10.0, -1.0).contains("it must be 0 km or more") && refused(10.0, f64::NAN).contains("is NaN"));
    assert!(refused(91.0, 1.0).starts_with("view_elevation is 91"));
    assert!(air.until(&Direction { elevation: -90.0, azimuth: 0.0 }, 1.0).unwrap()[0].transmittance < 1.0);
}
