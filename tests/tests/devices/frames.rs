//! What a frame of a still sky costs the thread that encodes it.

use allocation_counter::measure;
use sorairo::scene::{CameraScene, Preset, Projection, Scene};
use sorairo::wgpu::{self, BufferUsages};
use sorairo::{PixelFormat, ResidentRenderer, Sky, Target};
use sorairo_tests::own_device::{buffer, with_passthrough};
use sorairo_tests::sky::sky_of;

/// Most allocations of a frame, on the thread that encodes it: 82 were counted, most of them wgpu's, for two bind
/// groups, two buffers and a pass.
const OF_A_FRAME: u64 = 100;

/// The same that a disc may add: the places of its rim, and those of them that the camera sees.
const OF_A_DISC: u64 = 4;

fn sky(disc: bool) -> Sky {
    let mut scene = Scene::preset(Preset::Standard);
    (scene.sun.elevation, scene.sun.azimuth, scene.sun.disc) = (20.0, 10.0, disc);
    let sky = sky_of(&scene);
    sky.prepare_images();
    sky
}

/// Allocations of the third frame of a sky, when all is made that frames share.
fn allocations((device, queue): &(wgpu::Device, wgpu::Queue), sky: &Sky, camera: &CameraScene) -> u64 {
    let mut renderer = ResidentRenderer::with_device(device, queue);
    let bytes = 4 * u64::from(camera.size.width * camera.size.height);
    let output = buffer(device, bytes, BufferUsages::STORAGE | BufferUsages::COPY_DST);
    let mut frame = || {
        let mut encoder = device.create_command_encoder(&Default::default());
        let target = Target::Buffer(&output, PixelFormat::Picture);
        let counted = measure(|| renderer.encode(&mut encoder, sky, camera, &target).unwrap());
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        counted.count_total
    };
    (frame(), frame(), frame()).2
}

#[test]
fn a_still_sky_with_a_disc_encodes_with_as_few_allocations_as_one_without() {
    let device = with_passthrough();
    let skies = [sky(false), sky(true)];
    for projection in [Projection::Perspective, Projection::Equirectangular, Projection::Fisheye] {
        let camera = CameraScene { projection, size: "128x64".parse().unwrap(), ..CameraScene::default() };
        let [without, with] = skies.each_ref().map(|sky| allocations(&device, sky, &camera));
        println!("{projection:?}: {without} without, {with} with a disc");
        assert!(without > 0 && with <= without + OF_A_DISC, "{projection:?}: {with} against {without}");
        assert!(without <= OF_A_FRAME, "{projection:?}: {without}");
    }
}
