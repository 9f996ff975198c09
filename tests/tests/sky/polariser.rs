//! A polariser before the lens, against Malus' law on the Stokes vector of every wavelength.

use sorairo::low_level::device::Backend;
use sorairo::low_level::device::cpu::Cpu;
use sorairo::low_level::plan::upload;
use sorairo::low_level::spectra::observer;
use sorairo::scene::{Polarisation, Preset, Projection, Scene};
use sorairo::{Direction, PixelFormat, StokesFrame};
use sorairo_shared::camera::pixel_view;
use sorairo_shared::glam::DVec3;
use sorairo_tests::sky::{plan_of, sky_of};

const SIZE: (u32, u32) = (12, 10);

/// What a camera sees that looks up to the side, through a polariser at an angle.
fn scene(preset: Preset, sun: f64, altitude: f64, projection: Projection, polariser: Option<f64>) -> Scene {
    let mut scene = Scene::preset(preset);
    (scene.sun.elevation, scene.sun.azimuth, scene.observer.altitude) = (sun, 30.0, altitude);
    scene.camera.projection = projection;
    scene.camera.size = format!("{}x{}", SIZE.0, SIZE.1).parse().unwrap();
    if projection == Projection::Perspective {
        (scene.camera.look_azimuth, scene.camera.look_elevation, scene.camera.fov) =
            (Some(100.0), Some(35.0), Some(90.0));
    }
    scene.camera.polariser = polariser;
    scene.render.polarisation = Polarisation::On;
    scene
}

fn pixels(scene: &Scene) -> Vec<DVec3> {
    let plan = plan_of(scene, PixelFormat::LinearRgb);
    let words = Cpu.run(&plan, plan.kernel()).unwrap().words;
    words.chunks_exact(3).map(|rgb| DVec3::from_array([0, 1, 2].map(|i| f64::from(f32::from_bits(rgb[i]))))).collect()
}

/// Linear RGB of `I`, `Q` and `U` relative to the top of the image in some directions.
fn stokes_in_rgb(scene: &Scene, directions: &[Direction]) -> Vec<[DVec3; 3]> {
    let sky = sky_of(scene);
    let wavelengths = observer::wavelengths();
    let spectra = sky.stokes(&wavelengths, StokesFrame::Camera).unwrap();
    let in_rgb = |spectrum: &Vec<sorairo::Stokes>| {
        spectrum.iter().fold([DVec3::ZERO; 3], |sums, at| {
            let weight = sky.plan().space.from_xyz * observer::weights(sky.plan().observer, at.wavelength_nm);
            let values = [at.stokes_i, at.stokes_q, at.stokes_u];
            std::array::from_fn(|k| sums[k] + weight * values[k])
        })
    };
    spectra.in_directions(directions).unwrap().iter().map(in_rgb).collect()
}

/// Pixels of an image that show the sky, each with its direction.
fn places(scene: &Scene) -> Vec<(usize, Direction)> {
    let camera = upload::camera(scene);
    let place = |index: u32| {
        let view = pixel_view(&camera, upload::projection(scene.camera.projection), index % SIZE.0, index / SIZE.0);
        let direction = view.direction.as_dvec3();
        let elevation = direction.z.asin().to_degrees();
        let azimuth = (-direction.y).atan2(direction.x).to_degrees();
        (view.covered && elevation > 1.0).then_some((index as usize, Direction { elevation, azimuth }))
    };
    (0..SIZE.0 * SIZE.1).step_by(7).filter_map(place).collect()
}

#[test]
fn a_polariser_passes_what_the_stokes_vector_says() {
    let mut compared = 0;
    for (preset, kind, sun, altitude, projection, angle) in [
        (Preset::Standard, None, 20.0, 0.0, Projection::Perspective, 0.0),
        (Preset::Standard, None, 20.0, 0.0, Projection::Fisheye, 35.0),
        (Preset::Standard, None, 50.0, 0.0, Projection::Equirectangular, 90.0),
        (Preset::Standard, None, -3.0, 0.0, Projection::Perspective, 60.0),
        (Preset::Standard, None, 10.0, 10.0, Projection::Fisheye, -45.0),
        (Preset::Hazy, None, 30.0, 0.0, Projection::Perspective, 120.0),
        (Preset::Standard, Some("desert"), 30.0, 0.0, Projection::Fisheye, 10.0),
    ] {
        let mut scene = scene(preset, sun, altitude, projection, Some(angle));
        if let Some(kind) = kind {
            scene.atmosphere.aerosol.kind = kind.parse().unwrap();
            scene.atmosphere.aerosol.optical_depth = 0.3;
        }
        let places = places(&scene);
        let truth = stokes_in_rgb(&scene, &places.iter().map(|place| place.1).collect::<Vec<_>>());
        let passed = pixels(&scene);
        let mut across = scene.clone();
        across.camera.polariser = Some(angle + 90.0);
        let across = pixels(&across);
        let (sine, cosine) = (2.0 * angle).to_radians().sin_cos();
        let mut worst: f64 = 0.0;
        for (&(index, direction), [i, q, u]) in places.iter().zip(truth) {
            let expected = 0.5 * (i + q * cosine + u * sine) / i;
            let found = passed[index] / (passed[index] + across[index]);
            let error = (found - expected).abs().max_element();
            assert!(error.is_finite(), "{direction:?}: {found}");
            worst = worst.max(error);
            compared += 1;
        }
        println!("{preset:?} {kind:?} {sun}° {altitude} km {projection:?}: {worst:.4}");
        // What the page of polarisation tells: less than a third of what four bands may leave of a degree, .01.
        assert!(worst < 3e-3, "{preset:?} {kind:?}, sun at {sun}°, {altitude} km, {projection:?}: {worst}");
    }
    assert!(compared > 60, "{compared} pixels");
}

#[test]
fn two_crossed_polarisers_pass_the_sky_between_them() {
    for extinction in [None, Some(50.0)] {
        let of = |angle: Option<f64>| {
            let mut scene = scene(Preset::Standard, 15.0, 0.0, Projection::Perspective, angle);
            scene.camera.polariser_extinction = extinction.filter(|_| angle.is_some());
            scene.render.path = sorairo::scene::PathChoice::Lookup;
            pixels(&scene)
        };
        let (along, across, without) = (of(Some(25.0)), of(Some(115.0)), of(None));
        let all = 1.0 + extinction.map_or(0.0, f64::recip);
        for ((along, across), without) in along.iter().zip(&across).zip(&without) {
            // Both look the same colours up; the sum is rounded a few times.
            assert!((*along + *across - *without * all).abs().max_element() < 2e-6 * without.max_element());
        }
        let ratio = along.iter().zip(&across).map(|(along, across)| along.y / across.y).fold(0.0, f64::max);
        assert!(ratio > 3.0 || extinction.is_some(), "they differ by {ratio} at most");
    }
}

#[test]
fn a_polariser_that_passes_all_changes_no_light() {
    let mut none = scene(Preset::Standard, 15.0, 0.0, Projection::Fisheye, Some(70.0));
    none.camera.polariser_extinction = Some(1.0);
    let mut without = none.clone();
    (without.camera.polariser, without.camera.polariser_extinction) = (None, None);
    without.render.path = sorairo::scene::PathChoice::Lookup;
    for (with, without) in pixels(&none).into_iter().zip(pixels(&without)) {
        assert!((with - without).abs().max_element() <= 1e-6 * without.max_element());
    }
}
