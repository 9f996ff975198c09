//! The sky in the window's own device: drawn into a texture that the window shows, and never read back.

use std::sync::Arc;
use std::thread::{self, JoinHandle};

use eframe::egui::{PaintCallbackInfo, Rect, Shape};
use eframe::egui_wgpu::{
    Callback, CallbackResources, CallbackTrait, RenderState, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew,
};
use sorairo::scene::{CameraScene, Size, Sun};
use sorairo::{LightFields, PixelFormat, ResidentRenderer, Result, Scene, Sky, Target, wgpu};

/// A texture of the window on which skies are drawn.
pub struct Canvas {
    state: RenderState,
    renderer: ResidentRenderer,
    screen: Screen,
    texture: Option<Texture>,
    drawn: Option<(Sky, CameraScene)>,
    count: u32,
    /// The scene of whose day the pipelines were compiled last, without its sun, and who compiles them.
    ahead: Option<(Scene, JoinHandle<()>)>,
}

struct Texture {
    size: Size,
    view: wgpu::TextureView,
    shown: Shown,
}

impl Canvas {
    /// On the device that draws the window.
    pub fn new(state: &RenderState) -> Self {
        let renderer = ResidentRenderer::with_device(&state.device, &state.queue);
        let screen = Screen::new(&state.device, state.target_format);
        Self { state: state.clone(), renderer, screen, texture: None, drawn: None, count: 0, ahead: None }
    }

    /// Light fields for the skies that it shows.
    pub fn light_fields(&self) -> LightFields {
        self.renderer.light_fields()
    }

    /// What a camera sees of a sky, as the window shows it in a part of its own.
    ///
    /// # Errors
    ///
    /// Those of [`ResidentRenderer::encode`].
    pub fn show(&mut self, rect: Rect, sky: &Sky, camera: &CameraScene) -> Result<Shape> {
        let is_drawn = self.drawn.as_ref().is_some_and(|(of, from)| of.is_same(sky) && from == camera);
        let texture = match self.texture.take() {
            Some(texture) if texture.size == camera.size => texture,
            _ => Texture::new(&self.state.device, &self.screen, camera.size),
        };
        let texture = self.texture.insert(texture);
        let shown = texture.shown.clone();
        if !is_drawn {
            let mut encoder = self.state.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            self.renderer.encode(&mut encoder, sky, camera, &Target::Texture(&texture.view))?;
            self.state.queue.submit([encoder.finish()]);
            self.drawn = Some((sky.clone(), camera.clone()));
            self.count += 1;
            self.compile_ahead(sky, camera);
        }
        Ok(Shape::Callback(Callback::new_paint_callback(rect, shown)))
    }

    /// Compiles what the sky takes under other suns, beside the frames: the one before which the sun crosses into
    /// another kernel would wait for it.
    fn compile_ahead(&mut self, sky: &Sky, camera: &CameraScene) {
        let mut scene = sky.scene().clone().into_scene();
        scene.camera = camera.clone();
        scene.sun = Sun { disc: scene.sun.disc, ..Sun::default() };
        (scene.camera.look_azimuth, scene.camera.look_elevation, scene.camera.fov) = (None, None, None);
        if self.ahead.as_ref().is_some_and(|(of, thread)| *of == scene || !thread.is_finished()) {
            return;
        }
        let warm_up = self.renderer.warm_up(sky.scene(), camera, PixelFormat::Picture);
        self.ahead = Some((scene, thread::spawn(warm_up)));
    }

    /// Waits for what is compiled, so that no device is in use when the process ends, and counts the pipelines.
    pub fn stop(self) -> usize {
        if let Some((_, thread)) = self.ahead {
            thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        }
        self.renderer.pipelines()
    }

    /// How often a sky was drawn.
    pub fn count(&self) -> u32 {
        self.count
    }
}

impl Texture {
    /// Of a size.
    fn new(device: &wgpu::Device, screen: &Screen, size: Size) -> Self {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("sky"),
            size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("sky"),
            layout: &screen.pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) }],
        });
        Self { size, view, shown: Shown { pipeline: screen.pipeline.clone(), group } }
    }
}

/// Takes texels to the screen as they are. egui's own way filters each of them, which takes a driver in software longer
/// than to compute the sky.
struct Screen {
    pipeline: wgpu::RenderPipeline,
}

impl Screen {
    /// For the window's format.
    fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let module = device.create_shader_module(wgpu::include_wgsl!("texels.wgsl"));
        // The texture holds sRGB already.
        let entry_point = if format.is_srgb() { "linear_texel" } else { "texel" };
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("sky"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("corner"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { pipeline }
    }
}

/// A texture on its way to the screen.
#[derive(Clone)]
struct Shown {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
}

impl CallbackTrait for Shown {
    fn paint(&self, _: PaintCallbackInfo, pass: &mut wgpu::RenderPass<'static>, _: &CallbackResources) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// How the window opens its device: on the adapter of this name, with what the kernels take.
pub fn configuration(name: String) -> WgpuConfiguration {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.native_adapter_selector = Some(Arc::new(move |adapters, surface| {
        let shows = |adapter: &&wgpu::Adapter| surface.is_none_or(|surface| adapter.is_surface_supported(surface));
        let named = adapters.iter().filter(|adapter| adapter.get_info().name == name).find(shows);
        named.cloned().ok_or_else(|| format!("{name} does not draw on it"))
    }));
    setup.device_descriptor = Arc::new(ResidentRenderer::device_descriptor);
    WgpuConfiguration { wgpu_setup: WgpuSetup::CreateNew(setup), ..WgpuConfiguration::default() }
}
