//! A sky with a setting sun in a program's own device: in a texture that a window shows, never read back; or in files:
//! `cargo run --release --package sorairo --example embed -- --frames 60 --out frames`.
use sorairo::files::png;
use sorairo::scene::{CameraScene, Preset, Projection, Rgb, Size};
use sorairo::wgpu::CurrentSurfaceTexture::Success;
use sorairo::wgpu::{self, BufferDescriptor, BufferUsages, TextureUsages, util::TextureBlitter};
use sorairo::{LightFields, ResidentRenderer, Scene, Sky, Target};
use std::{path::Path, sync::Arc};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::{Window, WindowId};
use winit::{application::ApplicationHandler, dpi::PhysicalSize, event::WindowEvent};

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;
const SIZE: Size = Size { width: 960, height: 540 };

fn main() -> Outcome {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => Ok(EventLoop::new()?.run_app(&mut Screen(None))?),
        ["--frames", frames, "--out", folder] => save(frames.parse()?, folder.as_ref()),
        _ => Err("usage: embed [--frames N --out FOLDER]".into()),
    }
}

/// A texture with a sky, on the program's own device.
struct Canvas {
    device: wgpu::Device,
    queue: wgpu::Queue,
    view: wgpu::TextureView,
    renderer: ResidentRenderer,
    light_fields: LightFields,
    frame: u32,
}

impl Canvas {
    fn new(adapter: &wgpu::Adapter) -> Outcome<Self> {
        let descriptor = ResidentRenderer::device_descriptor(adapter);
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("sky"),
            size: wgpu::Extent3d { width: SIZE.width, height: SIZE.height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: TextureUsages::COPY_DST | TextureUsages::COPY_SRC | TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let renderer = ResidentRenderer::with_device(&device, &queue);
        let view = texture.create_view(&Default::default());
        Ok(Self { light_fields: renderer.light_fields(), device, queue, view, renderer, frame: 0 })
    }

    /// Encodes the sky of the next frame.
    fn draw(&mut self) -> Outcome<wgpu::CommandEncoder> {
        let mut scene = Scene::preset(Preset::Standard);
        scene.sun.elevation = 15.0 - 0.25 * f64::from(self.frame % 120);
        self.frame += 1;
        let sky = Sky::with_light_fields(&scene.validated()?, Rgb::Srgb, &self.light_fields);
        let camera = CameraScene { projection: Projection::Perspective, size: SIZE, ..Default::default() };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        self.renderer.encode(&mut encoder, &sky, &camera, &Target::Texture(&self.view))?;
        Ok(encoder)
    }
}

/// Draws so many frames, and copies the texture of each into a file.
fn save(frames: u32, folder: &Path) -> Outcome {
    std::fs::create_dir_all(folder)?;
    let mut sky = Canvas::new(&pollster::block_on(wgpu::Instance::default().request_adapter(&Default::default()))?)?;
    let (size, usage) = (u64::from(4 * SIZE.width * SIZE.height), BufferUsages::COPY_DST | BufferUsages::MAP_READ);
    let copy = sky.device.create_buffer(&BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
    for frame in 0..frames {
        let mut encoder = sky.draw()?;
        let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(4 * SIZE.width), ..Default::default() };
        let into = wgpu::TexelCopyBufferInfo { buffer: &copy, layout };
        encoder.copy_texture_to_buffer(sky.view.texture().as_image_copy(), into, sky.view.texture().size());
        sky.queue.submit([encoder.finish()]);
        copy.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        sky.device.poll(wgpu::PollType::wait_indefinitely())?;
        let rgb: Vec<u8> = copy.slice(..).get_mapped_range()?.chunks(4).flat_map(|texel| texel[..3].to_vec()).collect();
        copy.unmap();
        png::write(&folder.join(format!("{frame:04}.png")), SIZE.width, SIZE.height, &rgb)?.commit()?;
    }
    Ok(())
}

/// A window, its surface, what draws the texture on it, and the sky.
struct Screen(Option<(Arc<Window>, wgpu::Surface<'static>, TextureBlitter, Canvas)>);

impl ApplicationHandler for Screen {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let attributes = Window::default_attributes().with_inner_size(PhysicalSize::new(SIZE.width, SIZE.height));
        let window = Arc::new(events.create_window(attributes.with_resizable(false)).expect("a window opens"));
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let surface = instance.create_surface(Arc::clone(&window)).expect("it can be drawn on");
        let options = wgpu::RequestAdapterOptions { compatible_surface: Some(&surface), ..Default::default() };
        let adapter = pollster::block_on(instance.request_adapter(&options)).expect("a device draws on it");
        let sky = Canvas::new(&adapter).expect("the device opens");
        let mut config = surface.get_default_config(&adapter, SIZE.width, SIZE.height).expect("as it said");
        config.format = config.format.remove_srgb_suffix(); // the texture holds sRGB already
        surface.configure(&sky.device, &config);
        self.0 = Some((window, surface, TextureBlitter::new(&sky.device, config.format), sky));
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some((window, surface, blitter, sky)) = &mut self.0 else { return };
        match event {
            WindowEvent::CloseRequested => return events.exit(),
            WindowEvent::RedrawRequested => window.request_redraw(),
            _ => return,
        }
        let Success(shown) = surface.get_current_texture() else { return };
        let mut encoder = sky.draw().expect("the sky is drawn");
        blitter.copy(&sky.device, &mut encoder, &sky.view, &shown.texture.create_view(&Default::default()));
        sky.queue.submit([encoder.finish()]);
        sky.queue.present(shown);
    }
}
