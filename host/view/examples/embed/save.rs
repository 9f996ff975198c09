//! Without a window: the texture, copied to files to show what is in it.

use std::path::Path;

use sorairo::low_level::files::png;
use sorairo::wgpu::{self, BufferUsages};

use crate::{Outcome, SIZE, Sky};

/// Draws so many frames, each into a file of a folder.
pub fn save(frames: u32, folder: &Path) -> Outcome {
    std::fs::create_dir_all(folder)?;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let mut sky = Sky::new(&adapter)?;
    for frame in 0..frames {
        let encoder = sky.draw(frame)?;
        let rgb = copy(&sky, encoder)?;
        png::write(&folder.join(format!("{frame:04}.png")), SIZE.width, SIZE.height, &rgb)?.commit()?;
    }
    Ok(())
}

/// Submits what draws the texture, and brings its red, green and blue back.
fn copy(sky: &Sky, mut encoder: wgpu::CommandEncoder) -> Outcome<Vec<u8>> {
    let buffer = sky.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 4 * u64::from(SIZE.width * SIZE.height),
        usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(4 * SIZE.width), ..Default::default() };
    let into = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(sky.texture.as_image_copy(), into, SIZE);
    sky.queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    sky.device.poll(wgpu::PollType::wait_indefinitely())?;
    let texels = buffer.slice(..).get_mapped_range()?;
    Ok(texels.chunks(4).flat_map(|texel| texel[..3].to_vec()).collect())
}
