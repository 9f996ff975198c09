//! A sky in a program's own device: a sun that moves, drawn frame by frame into a texture that a window shows, and never read back.
//!
//! ```sh
//! cargo run --release --package sorairo-view --example embed                               # N frames if --frames N is given
//! cargo run --release --package sorairo-view --example embed -- --frames 60 --out frames   # into files, without a window
//! ```

mod save;

use std::sync::Arc;

use sorairo::scene::{CameraScene, Preset, Projection, Rgb};
use sorairo::wgpu::{self, CurrentSurfaceTexture::Success, TextureUsages, util::TextureBlitter};
use sorairo::{LightFields, Renderer, ResidentRenderer, Scene, SkyPlan, Target};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::{Window, WindowId};
use winit::{application::ApplicationHandler, dpi::PhysicalSize, event::WindowEvent};

const SIZE: wgpu::Extent3d = wgpu::Extent3d { width: 960, height: 540, depth_or_array_layers: 1 };

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Outcome {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let show =
        |frames: u32| Ok(EventLoop::new()?.run_app(&mut Screen { frames: frames.max(1), frame: 0, shown: None })?);
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => show(u32::MAX),
        ["--frames", frames] => show(frames.parse()?),
        ["--frames", frames, "--out", folder] => save::save(frames.parse()?, folder.as_ref()),
        _ => Err("usage: embed [--frames N [--out FOLDER]]".into()),
    }
}

/// A texture with a sky, on the program's own device.
struct Sky {
    device: wgpu::Device,
    queue: wgpu::Queue,
    texture: wgpu::Texture,
    renderer: ResidentRenderer,
    light_fields: LightFields,
}

impl Sky {
    fn new(adapter: &wgpu::Adapter) -> Outcome<Self> {
        let descriptor = ResidentRenderer::device_descriptor(adapter);
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("sky"),
            size: SIZE,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: TextureUsages::COPY_DST | TextureUsages::COPY_SRC | TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let renderer = Renderer::with_device(&device, &queue);
        Ok(Self { light_fields: renderer.light_fields(), device, queue, texture, renderer })
    }

    /// Encodes the sky of a frame.
    fn draw(&mut self, frame: u32) -> Outcome<wgpu::CommandEncoder> {
        let mut scene = Scene::preset(Preset::Standard);
        scene.sun.elevation = 15.0 - 0.25 * f64::from(frame % 120);
        let sky = Arc::new(SkyPlan::with_light_fields(&scene.validated()?, Rgb::Srgb, &self.light_fields));
        let size = format!("{}x{}", SIZE.width, SIZE.height).parse()?;
        let camera = CameraScene { projection: Projection::Perspective, size, ..Default::default() };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let view = self.texture.create_view(&Default::default());
        self.renderer.encode(&mut encoder, &sky, &camera, &Target::Texture(&view))?;
        Ok(encoder)
    }
}

/// A window, its surface, what draws the texture on it, and the sky.
type Shown = (Arc<Window>, wgpu::Surface<'static>, TextureBlitter, Sky);

/// Shows so many frames, and the last one on.
struct Screen {
    frames: u32,
    frame: u32,
    shown: Option<Shown>,
}

impl ApplicationHandler for Screen {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let attributes = Window::default_attributes().with_inner_size(PhysicalSize::new(SIZE.width, SIZE.height));
        let window = Arc::new(events.create_window(attributes.with_resizable(false)).expect("a window opens"));
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let surface = instance.create_surface(Arc::clone(&window)).expect("it can be drawn on");
        let options = wgpu::RequestAdapterOptions { compatible_surface: Some(&surface), ..Default::default() };
        let adapter = pollster::block_on(instance.request_adapter(&options)).expect("a device draws on it");
        let sky = Sky::new(&adapter).expect("the device opens");
        let mut config = surface.get_default_config(&adapter, SIZE.width, SIZE.height).expect("as it said");
        config.format = config.format.remove_srgb_suffix(); // the texture holds sRGB already
        surface.configure(&sky.device, &config);
        self.shown = Some((window, surface, TextureBlitter::new(&sky.device, config.format), sky));
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match (event, &mut self.shown) {
            (WindowEvent::CloseRequested, _) => events.exit(),
            (WindowEvent::RedrawRequested, Some((window, surface, blitter, sky))) => {
                if let Success(shown) = surface.get_current_texture() {
                    let mut encoder = sky.draw(self.frame.min(self.frames - 1)).expect("the sky is drawn");
                    let [from, to] = [&sky.texture, &shown.texture].map(|of| of.create_view(&Default::default()));
                    blitter.copy(&sky.device, &mut encoder, &from, &to);
                    sky.queue.submit([encoder.finish()]);
                    sky.queue.present(shown);
                    self.frame += 1;
                }
                if self.frame < self.frames {
                    window.request_redraw();
                }
            }
            _ => {}
        }
    }
}
