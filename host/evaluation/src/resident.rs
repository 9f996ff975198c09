//! Skies that stay in a device of a program's own: what a frame costs that nobody reads back.

use std::time::{Duration, Instant};

use sorairo::low_level::device::{DeviceKind, gpu};
use sorairo::low_level::plan::LightFields;
use sorairo::scene::{Rgb, Scene, Size};
use sorairo::{Device, PixelFormat, ResidentRenderer, Sky, Target, wgpu};

use crate::problem::Result;

/// A program's own device, with room for an image of linear pixels.
pub struct Resident {
    device: wgpu::Device,
    queue: wgpu::Queue,
    renderer: ResidentRenderer,
    pixels: wgpu::Buffer,
}

impl Resident {
    /// Opens the device of this name once more, as a program does; none where the processor is the device.
    ///
    /// # Errors
    ///
    /// [`sorairo::Error::Device`] for a device that cannot be opened.
    pub fn beside(device: &Device, size: Size) -> Result<Option<Self>> {
        if device.kind == DeviceKind::Cpu {
            return Ok(None);
        }
        let failed = |why: String| sorairo::Error::Device(format!("{} cannot be opened again: {why}", device.name));
        let adapter = gpu::adapter(&device.name).ok_or_else(|| failed("it is gone".into()))?;
        let descriptor = ResidentRenderer::device_descriptor(&adapter);
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| failed(error.to_string()))?;
        let pixels = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("linear RGB"),
            size: 12 * u64::from(size.width) * u64::from(size.height),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Ok(Some(Self { renderer: ResidentRenderer::with_device(&device, &queue), device, queue, pixels }))
    }

    /// Light fields where its plans integrate.
    pub fn light_fields(&self) -> LightFields {
        self.renderer.light_fields()
    }

    /// The time of a frame, from its scene until its last pixel lies in the device.
    ///
    /// # Errors
    ///
    /// A wrong scene, an image of another size, or a device that fails.
    pub fn frame(&mut self, scene: &Scene, light_fields: &LightFields) -> Result<Duration> {
        let start = Instant::now();
        let sky = Sky::with_light_fields(&scene.validated()?, Rgb::default(), light_fields);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let target = Target::Buffer(&self.pixels, PixelFormat::LinearRgb);
        self.renderer.encode(&mut encoder, &sky, &scene.camera, &target)?;
        self.queue.submit([encoder.finish()]);
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        waited.map_err(|error| sorairo::Error::Device(format!("it does not answer: {error}")))?;
        Ok(start.elapsed())
    }
}
