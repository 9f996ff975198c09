//! The same scene gives the same bytes, whatever came before it and however many threads work at it.

use sorairo::low_level::device::Backend;
use sorairo::low_level::device::cpu::Cpu;
use sorairo::scene::{ColourPath, ExrDepth, Fit, PathChoice, Preset, Projection, Scene};
use sorairo::{PixelFormat, Plan, Request, render};
use sorairo_tests::gpu;
use sorairo_tests::sky::scene;
use tempfile::tempdir;

/// Scenes that take every way to a pixel.
fn scenes() -> Vec<Scene> {
    let mut looked_up = scene(Preset::Earth, 20.0, "160x80");
    looked_up.render.path = PathChoice::Lookup;
    let mut twilight = scene(Preset::Earth, -4.0, "65x33");
    twilight.observer.altitude = 11.0;
    twilight.camera.projection = Projection::Fisheye;
    let mut solve = scene(Preset::Paper, 10.0, "64x48");
    (solve.render.fit, solve.render.color) = (Fit::Transfer, ColourPath::Solve);
    let mut dense = scene(Preset::Earth, 60.0, "31x17");
    dense.render.fit = Fit::Dense;
    vec![looked_up, twilight, solve, dense]
}

/// The words of a scene's pixels, from a plan of its own.
fn words(scene: &Scene, pixel: PixelFormat, backend: &dyn Backend) -> Vec<u32> {
    let plan = Plan::new(&scene.validated().unwrap(), pixel);
    backend.run(&plan, plan.kernel()).unwrap().words
}

#[test]
fn a_frame_does_not_depend_on_the_frames_before_it() {
    for backend in [gpu::backend(), &Cpu] {
        let frame = |scene: &Scene| words(scene, PixelFormat::LinearRgb, backend);
        let scenes = scenes();
        let forwards: Vec<_> = scenes.iter().map(frame).collect();
        let backwards: Vec<_> = scenes.iter().rev().map(frame).collect();
        let again: Vec<_> = scenes.iter().map(frame).collect();
        assert!(forwards.iter().flatten().any(|&word| word != 0));
        assert!(forwards.iter().eq(backwards.iter().rev()), "backwards");
        assert_eq!(forwards, again);
    }
}

#[test]
fn a_frame_does_not_depend_on_the_number_of_threads() {
    for scene in scenes() {
        for pixel in [PixelFormat::LinearRgb, PixelFormat::Picture] {
            // The plan is made by those threads too.
            let with = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| words(&scene, pixel, &Cpu))
            };
            let one = with(1);
            assert!(one.iter().any(|&word| word != one[0]));
            assert_eq!(one, with(2));
            assert_eq!(one, with(5));
        }
    }
}

/// The bytes of the files that a scene is rendered into.
fn files(scene: &Scene, device: &str, threads: usize) -> Vec<Vec<u8>> {
    let folder = tempdir().unwrap();
    let outputs = ["sky.png", "sky.exr"].map(|name| folder.path().join(name)).to_vec();
    let request = Request { outputs, ..Request::default() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| render(&scene.validated().unwrap(), &request, || sorairo::Device::open(device), |_| {})).unwrap();
    request.outputs.iter().map(|path| std::fs::read(path).unwrap()).collect()
}

#[test]
fn files_are_the_same_byte_for_byte() {
    for depth in [ExrDepth::Half, ExrDepth::Full] {
        // Large enough for many blocks of an EXR, which several threads compress.
        let mut scene = scene(Preset::Earth, 15.0, "700x500");
        scene.render.exr = depth;
        scene.camera.projection = Projection::Perspective;
        for device in ["cpu", "gpu"] {
            let first = files(&scene, device, 1);
            assert!(first.iter().all(|bytes| bytes.len() > 10_000));
            for threads in [1, 2, 5, 5, 5] {
                assert!(files(&scene, device, threads) == first, "{device}, {threads} threads");
            }
        }
    }
}
