//! The ray integral over its whole domain: against the oracle, and where it must not jump.

use sorairo::low_level::plan::direction;
use sorairo::scene::keys::{Key, find};
use sorairo::scene::{Preset, Scene};
use sorairo::{PixelFormat, Plan};
use sorairo_evaluation::judge::{bands, medium, ray};
use sorairo_evaluation::stress::integral::{compare, integral};
use sorairo_oracle::scattered_radiance_bands;
use sorairo_shared::glam::Vec3;
use sorairo_tests::sky::{plan_of, scene};

/// Rays of random scenes in a run of the tests; `sorairo stress` tries more.
const RAYS: u64 = 16_000;

/// Seed of those rays.
const SEED: u64 = 20_261_121;

/// Single precision keeps 1e-5 of an optical depth of some ten; a difference has two such values.
const ROUNDING: f64 = 3e-5;

fn plan(scene: &Scene) -> Plan {
    plan_of(scene, PixelFormat::LinearRgb)
}

/// The transfer at the plan's bands towards an elevation and an azimuth (degrees).
fn seen(plan: &Plan, elevation: f64, azimuth: f64) -> [f64; 4] {
    let transfer = plan.sky.plan().integral().transfer(direction(elevation, azimuth).as_vec3());
    std::array::from_fn(|i| transfer[i])
}

/// Where a value is looked at about a place, in angles.
const PARTS: [f64; 4] = [-3.0, -1.0, 1.0, 3.0];

/// What changes over twice an angle (degrees) about a place is no more than twice what changes beside it.
fn assert_continuous(what: &str, at: f64, angle: f64, value: impl Fn(f64) -> [f64; 4]) {
    let [far_below, below, above, far_above] = PARTS.map(|part| value(at + part * angle));
    for band in 0..4 {
        let jump = (above[band] - below[band]).abs();
        let slope = (far_above[band] - above[band]).abs().max((below[band] - far_below[band]).abs());
        let allowed = 2.0 * slope + ROUNDING * above[band].max(below[band]);
        assert!(above[band] > 0.0 && below[band] > 0.0, "{what}, band {band}: nothing is lit");
        assert!(jump <= allowed, "{what}, band {band}: a jump of {jump:e} beside a slope of {slope:e}");
    }
}

/// The errors along views of a scene towards and across the sun and away from it, the largest of them no larger than
/// the bound of 1e-3.
fn assert_accurate(scene: &Scene, elevations: impl IntoIterator<Item = f64>) {
    assert_accurate_towards(scene, elevations, &[1.0, 70.0, 179.0]);
}

fn assert_accurate_towards(scene: &Scene, elevations: impl IntoIterator<Item = f64>, azimuths: &[f64]) {
    let toward = |elevation| azimuths.iter().map(move |&azimuth| direction(elevation, azimuth).as_vec3());
    let views: Vec<Vec3> = elevations.into_iter().flat_map(toward).collect();
    let cases = compare(scene, &views);
    assert!(cases.iter().any(|case| case.reference > 0.0), "nothing is lit");
    let worst = cases.into_iter().max_by(|a, b| a.error.total_cmp(&b.error)).expect("a view");
    println!("{worst}");
    assert!(worst.error <= 1e-3, "{worst}");
}

/// Random scenes over all that a scene allows.
#[test]
fn radiance_of_random_scenes_agrees_with_the_oracle() {
    let outcome = integral(SEED, RAYS);
    println!("{outcome:?}");
    assert_eq!(outcome.cases, RAYS);
    assert_eq!(outcome.failures, 0, "{outcome:?}");
}

#[test]
fn radiance_is_continuous_across_the_level_direction() {
    for altitude in [0.5, 2.0, 12.0, 35.0, 90.0] {
        for sun in [-3.0, 0.5, 2.0, 40.0] {
            let mut scene = scene(Preset::Earth, sun, "8x4");
            scene.observer.altitude = altitude;
            let plan = plan(&scene);
            // With the sun below the horizon the sky opposite to it lies in the planet's shadow.
            let farthest = if sun < 0.0 { 90.0 } else { 175.0 };
            for azimuth in [5.0, 90.0, farthest] {
                assert_continuous(&format!("{altitude} km, sun at {sun}, azimuth {azimuth}"), 0.0, 0.01, |elevation| {
                    seen(&plan, elevation, azimuth)
                });
            }
        }
    }
}

/// There the ray's end leaps from the ground to the far side of the air, and its radiance with it: by as much as the
/// oracle's.
#[test]
fn the_step_at_the_edge_of_the_ground_is_that_of_the_oracle() {
    for altitude in [0.5, 12.0, 35.0] {
        for sun in [2.0, 40.0] {
            let mut scene = scene(Preset::Earth, sun, "8x4");
            scene.observer.altitude = altitude;
            let plan = plan(&scene);
            let bands = bands(&scene, plan.sky.plan());
            let ground = scene.atmosphere.ground_radius;
            let horizon = -(ground / (ground + altitude)).acos().to_degrees();
            for elevation in [horizon - 0.01, horizon + 0.01] {
                let values = seen(&plan, elevation, 60.0);
                let references = scattered_radiance_bands(&medium(&scene), &bands, &ray(&scene, elevation, 60.0));
                for (value, reference) in values.into_iter().zip(references) {
                    // The bound of the integral.
                    assert!((value / reference - 1.0).abs() <= 1e-3, "{altitude} km, {elevation}: {value} {reference}");
                }
            }
        }
    }
}

#[test]
fn radiance_is_continuous_as_the_sun_sets() {
    const ANGLE: f64 = 0.02;
    for altitude in [0.0, 12.0] {
        let under = |part: f64| {
            let mut scene = scene(Preset::Earth, part * ANGLE, "8x4");
            scene.observer.altitude = altitude;
            (part * ANGLE, plan(&scene))
        };
        let plans = PARTS.map(under);
        for elevation in [1.0, 20.0, 60.0, 90.0] {
            for azimuth in [5.0, 90.0, 175.0] {
                let at_sun = |sun: f64| {
                    let (_, plan) = plans.iter().find(|(planned, _)| *planned == sun).expect("a sun that is planned");
                    seen(plan, elevation, azimuth)
                };
                assert_continuous(&format!("{altitude} km, view {elevation}, {azimuth}"), 0.0, ANGLE, at_sun);
            }
        }
    }
}

#[test]
fn radiance_is_continuous_through_the_zenith_and_round_the_horizon() {
    for sun in [-3.0, 2.0, 40.0, 89.0] {
        let plan = plan(&scene(Preset::Earth, sun, "8x4"));
        for azimuth in [5.0, 90.0] {
            let over = |elevation: f64| seen(&plan, elevation, azimuth);
            assert_continuous(&format!("zenith, sun at {sun}, azimuth {azimuth}"), 90.0, 0.05, over);
        }
        for elevation in [0.5, 10.0, 60.0] {
            let around = |azimuth: f64| seen(&plan, elevation, azimuth.rem_euclid(360.0));
            assert_continuous(&format!("seam, sun at {sun}, elevation {elevation}"), 360.0, 0.05, around);
        }
    }
}

/// From 3000 radii away a planet was dark: the distance took the digits of the place where a ray enters the atmosphere.
#[test]
fn a_small_planet_is_lit_from_afar() {
    let mut scene = scene(Preset::Paper, 10.0, "8x4");
    let a = &mut scene.atmosphere;
    (a.ground_radius, a.top_radius, a.air.scale_height) = (31.75, 34.5, 0.25);
    (a.aerosol.scale_height, scene.observer.altitude) = (0.25, 95_000.0);
    let disc = (a.top_radius / (a.ground_radius + scene.observer.altitude)).asin().to_degrees();
    assert_accurate(&scene, [0.0, 0.2, 0.5, 0.8].map(|part| -90.0 + part * disc));
}

/// In air a thousand times as dense, a column of a kilometre was the difference of two numbers 10 000 times as large.
#[test]
fn opaque_air_is_as_bright_as_it_should_be() {
    for altitude in [12.0, 50.0, 150.0] {
        let mut scene = scene(Preset::Earth, 30.0, "8x4");
        scene.observer.altitude = altitude;
        scene.atmosphere.air.scattering *= 1000.0;
        assert_accurate(&scene, [-90.0, -50.0, -30.0, -13.0, -6.0, -3.0, 0.0, 3.0, 20.0, 90.0]);
    }
}

/// Air of 50 m seen from 2663 km up: as a distance from the observer the place of a sample lost the digits of its
/// altitude.
#[test]
fn thin_air_on_the_ground_keeps_its_radiance_seen_from_high_inside_the_atmosphere() {
    let mut scene = scene(Preset::Paper, 39.0, "8x4");
    let a = &mut scene.atmosphere;
    (a.ground_radius, a.top_radius, a.air.scale_height) = (39_546.4, 39_546.4 + 2_663.34, 0.05);
    (a.air.scattering, a.aerosol.optical_depth, scene.observer.altitude) = (1.5e-5, 0.0, 2_663.3);
    assert_accurate(&scene, [-90.0, -75.0, -61.9, -45.7, -30.0]);
}

/// The column of ozone was a small difference of columns through three ramps, which began at the observer.
#[test]
fn ozone_far_above_keeps_its_column_on_level_rays() {
    let mut scene = scene(Preset::Earth, 88.0, "8x4");
    let a = &mut scene.atmosphere;
    (a.ground_radius, a.top_radius, a.air.scale_height) = (39_574.5, 39_574.5 + 139.4, 0.7);
    (a.air.scattering, a.aerosol.optical_depth, scene.observer.altitude) = (1.2e-5, 0.0, 0.134);
    (a.ozone.column, a.ozone.bottom, a.ozone.peak, a.ozone.top) = (2e3, 114.4, 115.6, 116.8);
    scene.render.bands = Some(vec![565.0, 580.0, 597.0, 606.0]);
    assert_accurate(&scene, (-32..8).map(|i| 0.004 * f64::from(i)));
}

/// The closed form of a column took its curvature from the ground: at some scale heights 2e-4 of an optical depth of
/// tens was missing.
#[test]
fn opaque_air_on_a_small_planet_is_as_bright_as_it_should_be() {
    let mut scene = scene(Preset::Earth, 1.2, "8x4");
    let a = &mut scene.atmosphere;
    (a.ground_radius, a.top_radius) = (629.0, 690.0);
    (a.air.scattering, a.air.scale_height, scene.observer.altitude) = (0.466, 4.876, 17.4);
    assert_accurate(&scene, [-1.2, 0.0, 2.0, 6.0, 12.7, 40.0]);
}

/// The oracle stepped over the few kilometres of a ray whose sunlight grazes a layer of 55 m, and was 5e-3 too bright.
#[test]
fn sunlight_that_grazes_a_thin_layer_is_dimmed_in_the_oracle_too() {
    let mut scene = scene(Preset::Earth, -9.26, "8x4");
    let a = &mut scene.atmosphere;
    (a.top_radius, a.ozone.column, scene.observer.altitude) = (a.ground_radius + 532.95, 0.0, 532.96);
    (a.air.scattering, a.air.scale_height, a.aerosol.scale_height) = (3.65e-6, 42.6, 0.055);
    assert_accurate(&scene, [-60.0, -45.3, -30.0, -22.7, -18.4, -15.2]);
}

/// From orbit the ground is seen where the sun sets; the samples were chosen for a sun that is high where the observer
/// is.
#[test]
fn the_terminator_seen_from_orbit_is_as_bright_as_it_should_be() {
    for (altitude, sun) in [(646.0, 8.5), (36_144.0, 9.3)] {
        let mut scene = scene(Preset::Earth, sun, "8x4");
        scene.observer.altitude = altitude;
        let horizon = -(6360.0_f64 / (6360.0 + altitude)).acos().to_degrees();
        assert_accurate(&scene, (0..46).map(|i| horizon + 0.02 * f64::from(i) * (-90.0 - horizon)));
    }
}

/// Haze of 100 m under 770 km of air shines where the sun is, and no test ray of the plan looked there.
#[test]
fn low_haze_is_as_bright_as_it_should_be_around_the_sun() {
    let mut scene = scene(Preset::Earth, 74.9, "8x4");
    let a = &mut scene.atmosphere;
    (a.ground_radius, a.top_radius, a.ozone.column) = (27_524.6, 28_296.06, 0.0);
    (a.air.scattering, a.air.scale_height) = (1.3167e-2, 61.7165);
    (a.aerosol.optical_depth, a.aerosol.scale_height, a.aerosol.asymmetry) = (5.328e-3, 0.111713, 0.98738);
    (a.aerosol.angstrom_exponent, a.aerosol.single_scattering_albedo) = (2.939, 0.628);
    scene.render.bands = Some(vec![432.0, 564.0, 704.0, 781.0]);
    assert_accurate(&scene, [70.0, 73.4, 74.6, 74.9, 75.2]);
}

/// Rounding chose on which side of the horizon the plan's test ray was, and the samples did for that side only.
#[test]
fn opaque_air_is_as_bright_as_it_should_be_on_either_side_of_the_horizon() {
    let mut scene = scene(Preset::Earth, 78.6, "8x4");
    let a = &mut scene.atmosphere;
    (a.air.scattering, a.aerosol.optical_depth, a.ozone.column) = (1.2134, 4.45e-3, 0.0);
    scene.observer.altitude = 8.594_831_5;
    scene.render.bands = Some(vec![429.0, 495.0, 698.0, 797.0]);
    assert_accurate(&scene, [-3.2, -2.978, -2.97703, -2.97, -2.7]);
}

/// At the wavelengths tried the sky was black or bright; between them, and with samples placed for a blacker band, it
/// was 1.2e-3 off.
#[test]
fn opaque_air_is_as_bright_as_it_should_be_at_the_plans_own_bands() {
    let mut scene = scene(Preset::Earth, 90.0, "8x4");
    scene.atmosphere.air.scattering = 0.877_074_3;
    scene.atmosphere.aerosol.optical_depth = 0.0904;
    scene.render.bands = Some(vec![400.87, 493.88, 647.5, 784.24]);
    assert_accurate(&scene, [20.0, 45.0, 90.0]);
}

/// Between the heights at which the plan's test rays passed through the limb lay the edge of the ozone.
#[test]
fn ozone_on_the_limb_is_as_dark_as_it_should_be_at_the_terminator() {
    let mut scene = scene(Preset::Earth, -0.0014, "8x4");
    let a = &mut scene.atmosphere;
    (a.ground_radius, a.top_radius) = (13_541.438, 13_549.265);
    (a.air.scattering, a.air.scale_height, a.aerosol.optical_depth) = (2.234_52e-5, 0.626_136_5, 0.0);
    (a.ozone.column, a.ozone.bottom, a.ozone.peak, a.ozone.top) = (300.0, 3.127_853, 3.936_414, 4.584_877);
    scene.observer.altitude = 851.457_5;
    scene.render.bands = Some(vec![374.0, 563.0, 627.0, 812.0]);
    let horizon = -(13_541.438_f64 / (13_541.438 + 851.457_5)).acos().to_degrees();
    assert_accurate_towards(&scene, (1..40).map(|i| horizon + 0.002 * f64::from(i)), &[85.0, 90.0, 95.0]);
}

/// The largest number of samples left 1.3e-3 where sunlight grazes ozone denser than the Earth's on a planet five times
/// as large.
#[test]
fn sunlight_that_grazes_dense_ozone_is_as_bright_as_it_should_be() {
    let mut scene = scene(Preset::Earth, -6e-5, "8x4");
    let a = &mut scene.atmosphere;
    (a.ground_radius, a.top_radius) = (34_542.242, 34_567.682);
    (a.air.scattering, a.air.scale_height) = (1.206_348e-6, 0.065_442);
    (a.aerosol.optical_depth, a.aerosol.scale_height, a.aerosol.asymmetry) = (5.328e-3, 9.218_186, -0.451_63);
    (a.ozone.column, a.ozone.bottom, a.ozone.peak, a.ozone.top) = (1058.06, 19.545_29, 21.395_42, 22.940_65);
    scene.render.bands = Some(vec![377.0, 574.0, 671.0, 740.0]);
    assert_accurate(&scene, (0..30).map(|i| 5.0 + 2.5 * f64::from(i)));
}

/// Away from a low sun the last light on a ray comes from where the sun sets at the top of the air, and no test ray of
/// the plan ended there.
#[test]
fn opaque_air_is_as_bright_as_it_should_be_away_from_a_low_sun() {
    let mut scene = scene(Preset::Earth, 0.544_17, "8x4");
    let a = &mut scene.atmosphere;
    (a.ground_radius, a.top_radius) = (10_278.384, 10_289.348);
    (a.air.scattering, a.air.scale_height) = (2.690_221e-3, 10.963_892);
    (a.aerosol.optical_depth, a.ozone.column) = (0.0, 0.0);
    scene.render.bands = Some(vec![361.578, 516.0, 620.0, 750.0]);
    assert_accurate_towards(&scene, (0..20).map(|i| 1.0 + 0.4 * f64::from(i)), &[125.0, 150.0, 160.0, 178.0]);
}

/// Behind the limb, where the sun sets across the view, light grazes the ozone along the whole of a ray, and no test
/// ray of the plan went there: 3e-3 with the samples that were enough elsewhere.
#[test]
fn the_limb_is_as_bright_as_it_should_be_where_the_sun_sets_across_it() {
    let mut scene = scene(Preset::Earth, -1.034_473, "8x4");
    let a = &mut scene.atmosphere;
    (a.top_radius, scene.observer.altitude) = (6361.0, 627.447_6);
    (a.air.scattering, a.air.scale_height) = (0.133_843, 0.054_982);
    (a.aerosol.optical_depth, a.aerosol.scale_height) = (0.0, 0.087_958);
    (a.ozone.bottom, a.ozone.peak, a.ozone.top) = (0.553_597, 0.663_597, 0.875_661);
    scene.render.bands = Some(vec![420.0, 540.0, 600.0, 760.0]);
    let limb = |i: i32| -((6360.4 + 0.01 * f64::from(i)) / (6360.0 + 627.447_6)).acos().to_degrees();
    assert_accurate_towards(&scene, (0..20).map(limb), &[87.7, 87.8, 87.9, 88.0, 88.2]);
}

/// The same on a planet twelve times as large, of a ray that an independent seed found: 1.7e-3.
#[test]
fn the_limb_of_a_large_planet_is_as_bright_as_it_should_be_where_the_sun_sets_across_it() {
    let mut scene = scene(Preset::Earth, -0.312_37, "8x4");
    let a = &mut scene.atmosphere;
    (a.ground_radius, a.top_radius) = (73_521.516, 73_528.268);
    (a.air.scattering, a.air.scale_height, a.aerosol.optical_depth) = (1.240_62e-3, 0.540_161, 0.0);
    (a.ozone.bottom, a.ozone.peak, a.ozone.top) = (5.096_882, 5.427_984, 5.584_813);
    scene.observer.altitude = 3_917.76;
    scene.render.bands = Some(vec![448.87, 563.61, 710.55, 712.76]);
    assert_accurate_towards(&scene, (0..20).map(|i| -18.293_9 + 5e-5 * f64::from(i)), &[88.0, 89.0, 90.0]);
}

/// Shallow air far below an observer inside the atmosphere: the planet's shadow ends metres above the ground, which the
/// distance to it has lost. With the sun on the horizon and away from the view 2.1e-3 of the light was missing,
/// whatever the samples.
#[test]
fn the_ground_at_the_terminator_is_as_bright_as_it_should_be_from_high_inside_the_atmosphere() {
    for sun in [0.0, -0.003, -0.01, -0.03, -0.1, -0.3, -1.0] {
        let mut scene = scene(Preset::Earth, sun, "8x4");
        let a = &mut scene.atmosphere;
        (a.ground_radius, a.top_radius) = (56_441.63, 62_886.86);
        (a.air.scattering, a.air.scale_height) = (2.065e-7, 0.543_8);
        (a.aerosol.optical_depth, a.ozone.column) = (0.0, 0.0);
        scene.observer.altitude = 6445.0;
        scene.render.bands = Some(vec![444.107, 526.756, 652.771, 786.521]);
        assert_accurate_towards(&scene, [-90.0, -89.9, -85.0, -70.0], &[91.0, 150.0, 179.0]);
    }
}

/// The horizon of a planet of a million kilometres lies within single precision's rounding of its scale heights.
#[test]
fn a_planet_too_large_for_single_precision_is_refused() {
    let mut scene = Scene::preset(Preset::Earth).first_order();
    (scene.atmosphere.ground_radius, scene.atmosphere.top_radius) = (1e6, 1e6 + 100.0);
    let refusal = scene.validated().expect_err("refused").to_string();
    assert!(refusal.contains("atmosphere.ground_radius") && refusal.contains("100000"), "{refusal}");
}

#[test]
fn the_rays_from_the_ground_need_as_many_samples_as_the_key_says() {
    let says = find("render.steps").and_then(Key::stand_in).unwrap();
    let steps = |sun| plan(&scene(Preset::Earth, sun, "64x32")).samples_per_piece();
    let high: Vec<u32> = [5.0, 30.0, 90.0].map(steps).into();
    let low: Vec<u32> = [-6.0, -3.0, 0.0, 2.0, 4.9].map(steps).into();
    assert!(high.iter().all(|&steps| steps == 12) && says.contains("12 from the Earth's ground"), "{high:?}: {says}");
    let (fewest, most) = (low.iter().min().unwrap(), low.iter().max().unwrap());
    assert!(*fewest >= 48 && *most <= 64 && says.contains("48 to 64"), "{low:?}: {says}");
}
