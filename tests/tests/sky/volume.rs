//! A volume of air before a camera, against each of its rays integrated at every wavelength.

use rayon::prelude::*;
use sorairo::scene::{CameraScene, ColourPath, Scene};
use sorairo::{Sky, VolumeSize};
use sorairo_shared::glam::DVec3;
use sorairo_tests::air::{self, scenes, scenes_towards_the_sun, towards};
use sorairo_tests::sky::sky_of;

fn camera(elevation: f64) -> CameraScene {
    air::camera((160, 90), elevation)
}

/// Places of a volume that are compared.
const PLACES: usize = 1250;

/// Places that are spread over the image and the distances as evenly as can be: steps of the generalised golden ratio
/// in three dimensions.
fn places(far: f64) -> Vec<([f64; 2], f64)> {
    let part = |i: usize, power: i32| (0.5 + i as f64 * 1.220_744_084_605_76_f64.powi(-power)).fract();
    (0..PLACES).map(|i| ([part(i, 1), part(i, 2)], far * part(i, 3).powi(2))).collect()
}

/// How far a volume is from each ray integrated at places all over it: light relative to the brightest, then
/// transmittance; in the mean of the squares and at most.
fn errors(scene: &Scene, elevation: f64, size: VolumeSize) -> [[f64; 2]; 2] {
    let sky = sky_of(scene);
    let camera = camera(elevation);
    let volume = sky.air_volume(&camera, size).unwrap();
    let each = sky.between_rgb();
    let compared: Vec<_> = places(size.far)
        .into_par_iter()
        .filter_map(|(place, distance)| {
            let expected = each.until(&towards(&camera, place), distance).ok()?;
            let found = volume.at(place, distance);
            Some(([found.radiance, found.transmittance].map(DVec3::from_array), expected))
        })
        .collect();
    assert!(compared.len() > PLACES / 3, "places before the ground: {}", compared.len());
    air::errors(&compared)
}

#[test]
fn air_between_froxels_is_that_of_each_ray() {
    for (name, scene, elevation) in scenes(30.0).into_iter().chain(scenes_towards_the_sun()) {
        let errors = errors(&scene, elevation, VolumeSize::default());
        println!("{name}: light and transmittance, rms and at most: {errors:.5?}");
        for [rms, largest] in errors {
            // Half of what a volume of 32 × 32 × 32 is to be good for.
            assert!(rms < 0.005 && largest < 0.015, "{name}: {rms}, {largest}");
        }
    }
}

#[test]
fn before_no_distance_there_is_nothing_and_all_comes_through() {
    let mut scene = Scene::default();
    scene.sun.elevation = 20.0;
    let sky = sky_of(&scene);
    let volume = sky.air_volume(&camera(5.0), VolumeSize { columns: 4, rows: 4, slices: 32, far: 40.0 }).unwrap();
    for place in [[0.0, 0.0], [0.3, 0.8], [1.0, 1.0]] {
        let nothing = volume.at(place, 0.0);
        assert_eq!((nothing.transmittance, nothing.radiance), ([1.0; 3], [0.0; 3]));
        let near = volume.at(place, 1e-6);
        assert!(near.transmittance.iter().all(|part| (part - 1.0).abs() < 1e-4), "{near:?}");
        assert!(near.radiance.iter().all(|light| *light < 1e-4), "{near:?}");
    }
    assert_eq!(volume.at([0.5, 0.5], 50.0), volume.at([0.5, 0.5], 40.0));
}

#[test]
fn a_volume_that_cannot_be_filled_is_refused() {
    let mut scene = Scene::default();
    let sky = sky_of(&scene);
    let refused = |sky: &Sky, camera: &CameraScene, size| {
        sky.air_volume(camera, size).err().map(|error| error.to_string()).unwrap_or_default()
    };
    let size = VolumeSize::default();
    for far in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refused(&sky, &camera(0.0), VolumeSize { far, ..size }).starts_with("far is "), "{far}");
    }
    assert!(refused(&sky, &camera(0.0), VolumeSize { rows: 3, ..size }).starts_with("rows is 3; it must lie between"));
    assert!(refused(&sky, &CameraScene::default(), size).starts_with("camera.projection"));
    scene.render.color = ColourPath::Solve;
    let solved = sky_of(&scene);
    assert!(refused(&solved, &camera(0.0), size).starts_with("render.color"));
}
