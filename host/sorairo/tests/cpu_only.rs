//! The library without Vulkan and without files, as `--no-default-features --features cpu` makes it.
#![cfg(not(any(feature = "gpu", feature = "files", feature = "scene-files")))]

use sorairo::{Device, Error, Scene, Sky};

fn small() -> Scene {
    let mut scene = Scene::default();
    scene.camera.size = "32x16".parse().unwrap();
    scene
}

#[test]
fn the_sky_is_blue_above_green_grass() {
    let scene = small();
    let sky = Sky::new(&scene).unwrap().image(&scene.camera, &mut Device::open("cpu").unwrap()).unwrap();
    let [red, _, blue] = sky.pixel(16, 0);
    assert!(blue > red && red > 0.0, "{red} {blue}");
    let [red, green, blue] = sky.pixel(16, 15);
    assert!(green > red && red > blue && blue > 0.0, "{red} {green} {blue}");
}

#[test]
fn whatever_device_there_is_is_the_cpu() {
    assert!(Device::open("auto").unwrap().name.starts_with("CPU"));
}

#[test]
fn a_gpu_is_refused_with_the_devices_that_there_are() {
    let Err(Error::NoSuchDevice { choice, names }) = Device::open("gpu") else { panic!("a device was opened") };
    assert_eq!((choice.as_str(), names), ("gpu", vec!["auto".to_owned(), "cpu".to_owned()]));
}
