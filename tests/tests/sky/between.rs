//! Light between two points, against the light of whole rays from both, and against Koschmieder's law.

use rayon::prelude::*;
use sorairo::low_level::plan::direction;
use sorairo::low_level::spectra::observer;
use sorairo::low_level::spectrum::DenseSpectrum;
use sorairo::scene::{GroundAlbedo, Orders, Preset, Scene};
use sorairo::{BetweenSample, Direction, Sky};
use sorairo_evaluation::stress::between::from_there;
use sorairo_shared::glam::{DVec3, Vec3};
use sorairo_tests::sky::sky_of;

const WAVELENGTHS: [f64; 4] = [400.0, 500.0, 600.0, 700.0];

fn sky(scene: &Scene) -> Sky {
    sky_of(scene)
}

fn between(sky: &Sky, elevation: f64, azimuth: f64, distance: f64) -> Vec<BetweenSample> {
    sky.between(&WAVELENGTHS).unwrap().until(&Direction { elevation, azimuth }, distance).unwrap()
}

/// `L(from) = L(from to P) + T L(P)`: from the ground, a hill, an aeroplane, a balloon and orbit; up, level, down and
/// through the limb.
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
        // It ends in lit air over ground that lies in the planet's shadow.
        (6.0, -0.6, (-86.0, 67.0), 2.7),
        (40.0, 10.0, (-5.0, 150.0), 500.0),
        (400.0, 30.0, (-30.0, 20.0), 750.0),
        (400.0, 0.0, (-19.2, 0.0), 2000.0),
    ];
    for preset in [measured.clone(), Scene::preset(Preset::Hazy)] {
        for (altitude, sun, (elevation, azimuth), distance) in cases {
            let mut scene = preset.clone();
            (scene.observer.altitude, scene.sun.elevation) = (altitude, sun);
            let here = sky(&scene);
            let whole = DenseSpectrum::new(here.plan(), &WAVELENGTHS).radiance(direction(elevation, azimuth).as_vec3());
            let (there, onwards) = from_there(&scene, (elevation, azimuth), distance);
            let onwards = direction(onwards.0, onwards.1).as_vec3();
            let far = DenseSpectrum::new(sky(&there).plan(), &WAVELENGTHS).radiance(onwards);
            let near = between(&here, elevation, azimuth, distance);
            let brightest = whole.iter().copied().fold(0.0, f64::max);
            let what = format!("{:?}, {altitude} km, sun at {sun}°, {elevation}° up, {distance} km", scene.began_as());
            assert!(brightest > 0.0);
            for ((sample, whole), far) in near.iter().zip(&whole).zip(&far) {
                let found = sample.radiance + sample.transmittance * far;
                let off = (found - whole).abs() / brightest;
                println!("{what}, {} nm: {found:e}, {whole:e}, {off:.1e}", sample.wavelength_nm);
                // What lookups of light scattered more than once leave of whole rays, from both places: 3.1e-3 past
                // the limb from a balloon at 40 km, half as much elsewhere.
                assert!(off < 3.5e-3, "{what}, {} nm: {found:e}, not {whole:e}", sample.wavelength_nm);
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
    // The way rises by 8 m over 10 km, a thousandth of the scale height; light of all orders is brighter where it ends,
    // by as much again.
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
    let whole = DenseSpectrum::new(sky.plan(), &WAVELENGTHS).radiance(direction(10.0, 40.0).as_vec3());
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
    let air = sky(&scene).between(&[550.0]).unwrap();
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

/// Far away nothing is left but the sky, whose colour a fit makes of four bands.
#[test]
fn all_the_air_has_the_colour_of_the_sky() {
    for (preset, sun) in [(Preset::Standard, 40.0), (Preset::Standard, 2.0), (Preset::Hazy, 20.0), (Preset::Mars, 10.0)]
    {
        let mut scene = Scene::preset(preset);
        scene.sun.elevation = sun;
        let sky = sky(&scene);
        let air = sky.between_rgb();
        for (elevation, azimuth) in [(0.5, 20.0), (5.0, 160.0), (60.0, 90.0)] {
            let found = air.until(&Direction { elevation, azimuth }, f64::INFINITY).unwrap();
            let found = Vec3::from_array(found.radiance.map(|value| value as f32));
            let colour = sky.plan().rgb_towards(direction(elevation, azimuth).as_vec3());
            let off = (found - colour).abs().max_element() / colour.max_element();
            // What the fit of colours leaves of the sky: see docs/accuracy.md.
            assert!(off < 0.01, "{preset:?}, sun at {sun}°, {elevation}° up: {found}, not {colour}");
        }
    }
}

/// Transmittance in three colours is that of sunlight; what a spectrum lets through of a grey wall in the sun is the
/// same.
#[test]
fn a_wall_in_the_sun_is_reddened_as_its_spectrum_is() {
    let mut scene = Scene::preset(Preset::Standard);
    (scene.sun.elevation, scene.observer.altitude) = (30.0, 1.0);
    let sky = sky(&scene);
    let at = Direction { elevation: -0.5, azimuth: 60.0 };
    let (optics, nodes) = (scene.optics(), observer::wavelengths());
    let seen = sky.between(&nodes).unwrap().until(&at, 50.0).unwrap();
    let xyz = |of: &dyn Fn(usize) -> f64| {
        let spectrum: Vec<f64> = (0..nodes.len()).map(|i| of(i) * optics.solar_irradiance(nodes[i])).collect();
        sky.plan().space.from_xyz * observer::xyz_of_samples(sky.plan().observer, &spectrum)
    };
    let expected: DVec3 = xyz(&|i| seen[i].transmittance) / xyz(&|_| 1.0);
    let found = DVec3::from_array(sky.between_rgb().until(&at, 50.0).unwrap().transmittance);
    // Between the sun's spectrum at the nodes and its means about them lie its lines.
    assert!((found - expected).abs().max_element() < 5e-3, "{found}, not {expected}");
    assert!(found.x > found.y && found.y > found.z && found.z > 0.0 && found.x < 1.0, "{found}");
    let near = sky.between_rgb().until(&at, 0.0).unwrap();
    assert_eq!((near.transmittance, near.radiance), ([1.0; 3], [0.0; 3]));
}
