//! A sky in a program's own device: a sun that moves, drawn into a texture of the program, frame by frame.
//!
//! ```sh
//! cargo run --release --package sorairo --example embed -- --frames 60 --out frames
//! ```
//!
//! An engine draws with the texture and reads nothing back. This one has no window: it copies the texture to files, to show what is in it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use sorairo::low_level::files::png;
use sorairo::scene::{CameraScene, Preset, Projection, Rgb};
use sorairo::wgpu::{self, BufferUsages, TextureUsages};
use sorairo::{Renderer, ResidentRenderer, Scene, SkyPlan, Target};

const WIDTH: u32 = 960;
const HEIGHT: u32 = 540;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (frames, out) = arguments().ok_or("usage: embed --frames N --out FOLDER")?;
    std::fs::create_dir_all(&out)?;
    let (device, queue) = device()?;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("sky"),
        size: wgpu::Extent3d { width: WIDTH, height: HEIGHT, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: TextureUsages::COPY_DST | TextureUsages::COPY_SRC | TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    let mut renderer = Renderer::with_device(&device, &queue);
    let size = format!("{WIDTH}x{HEIGHT}").parse()?;
    let camera = CameraScene { projection: Projection::Perspective, size, ..CameraScene::default() };

    for frame in 0..frames {
        let mut scene = Scene::preset(Preset::Standard);
        scene.sun.elevation = 15.0 - 0.25 * f64::from(frame);
        let sky = Arc::new(SkyPlan::new(&scene.validated()?, Rgb::Srgb));
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.encode(&mut encoder, &sky, &camera, &Target::Texture(&view))?;
        queue.submit([encoder.finish()]);
        save(&device, &queue, &texture, &out.join(format!("{frame:04}.png")))?;
    }
    Ok(())
}

/// The program's own device. Kernels that are passed through to the driver are ready at once; elsewhere wgpu translates them first.
fn device() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn std::error::Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    Ok(pollster::block_on(adapter.request_device(&ResidentRenderer::device_descriptor(&adapter)))?)
}

fn arguments() -> Option<(u32, PathBuf)> {
    let all: Vec<String> = std::env::args().skip(1).collect();
    match all.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["--frames", frames, "--out", out] => Some((frames.parse().ok()?, out.into())),
        _ => None,
    }
}

/// Copies a texture to a file.
fn save(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    path: &Path,
) -> Result<(), Box<dyn std::error::Error>> {
    let row = 4 * WIDTH;
    let usage = BufferUsages::COPY_DST | BufferUsages::MAP_READ;
    let size = u64::from(row * HEIGHT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let target = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), target, texture.size());
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let texels = buffer.slice(..).get_mapped_range()?;
    let rgb: Vec<u8> = texels.chunks(4).flat_map(|texel| texel[..3].to_vec()).collect();
    Ok(png::write(path, WIDTH, HEIGHT, &rgb)?.commit()?)
}
