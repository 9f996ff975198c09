//! A device as a program of other people has one, its textures and its buffers.

use sorairo::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};

/// A device as a program opens it, with some features of those that it has.
///
/// # Panics
///
/// If there is no device; the words say what to install.
pub fn opened(features: wgpu::Features) -> (wgpu::Device, wgpu::Queue) {
    opened_within(features, |limits| limits)
}

/// The same within some limits, made of those that the device has.
///
/// # Panics
///
/// As [`opened`].
pub fn opened_within(
    features: wgpu::Features,
    limits: impl FnOnce(wgpu::Limits) -> wgpu::Limits,
) -> (wgpu::Device, wgpu::Queue) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
        .expect("a Vulkan device; on Debian: apt-get install mesa-vulkan-drivers libvulkan1");
    // SAFETY: the one experimental feature is that the library's own kernels are passed through.
    #[expect(unsafe_code, reason = "wgpu marks the feature as experimental")]
    let experimental_features = unsafe { wgpu::ExperimentalFeatures::enabled() };
    let descriptor = wgpu::DeviceDescriptor {
        required_features: adapter.features() & features,
        required_limits: limits(adapter.limits()),
        experimental_features,
        ..Default::default()
    };
    pollster::block_on(adapter.request_device(&descriptor)).unwrap()
}

/// A device that takes SPIR-V as it is, where there is one.
///
/// # Panics
///
/// As [`opened`].
pub fn with_passthrough() -> (wgpu::Device, wgpu::Queue) {
    opened(wgpu::Features::PASSTHROUGH_SHADERS)
}

/// A texture of some levels.
pub fn texture(
    device: &wgpu::Device,
    (width, height): (u32, u32),
    mip_level_count: u32,
    format: TextureFormat,
    usage: TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// A buffer of so many bytes.
pub fn buffer(device: &wgpu::Device, size: u64, usage: BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
}

/// The words of a buffer that can be copied from.
///
/// # Panics
///
/// If the device fails.
pub fn read(device: &wgpu::Device, queue: &wgpu::Queue, buffer: &wgpu::Buffer) -> Vec<u32> {
    let staging = self::buffer(device, buffer.size(), BufferUsages::MAP_READ | BufferUsages::COPY_DST);
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
    queue.submit([encoder.finish()]);
    staging.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    bytemuck::cast_slice(&staging.slice(..).get_mapped_range().unwrap()).to_vec()
}

/// The words of a texture's level, of so many words a texel.
///
/// # Panics
///
/// If the device fails.
pub fn texels(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    mip_level: u32,
    words: u32,
) -> Vec<u32> {
    texels_of_layer(device, queue, texture, (mip_level, 0), words)
}

/// The same of a level and a layer.
///
/// # Panics
///
/// As [`texels`].
pub fn texels_of_layer(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    (mip_level, layer): (u32, u32),
    words: u32,
) -> Vec<u32> {
    let side = |length: u32| (length >> mip_level).max(1);
    let (width, height) = (side(texture.width()), side(texture.height()));
    let row = (4 * words * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let copied = buffer(device, u64::from(row * height), BufferUsages::COPY_DST | BufferUsages::COPY_SRC);
    let mut encoder = device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let target = wgpu::TexelCopyBufferInfo { buffer: &copied, layout };
    let origin = wgpu::Origin3d { z: layer, ..wgpu::Origin3d::ZERO };
    let source = wgpu::TexelCopyTextureInfo { mip_level, origin, ..texture.as_image_copy() };
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    encoder.copy_texture_to_buffer(source, target, size);
    queue.submit([encoder.finish()]);
    let rows = read(device, queue, &copied);
    rows.chunks(row as usize / 4).flat_map(|row| row[..(words * width) as usize].to_vec()).collect()
}
