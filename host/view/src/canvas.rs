//! The sky in the window's own device: drawn into a texture that the window shows, and never read back.

use std::sync::Arc;

use eframe::egui::TextureId;
use eframe::egui_wgpu::{RenderState, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use sorairo::scene::{CameraScene, Size};
use sorairo::wgpu;
use sorairo::{ResidentRenderer, Result, SkyPlan, Target};

/// A texture of the window on which skies are drawn.
pub struct Canvas {
    state: RenderState,
    renderer: ResidentRenderer,
    texture: Option<Texture>,
    drawn: Option<(Arc<SkyPlan>, CameraScene)>,
    count: u32,
}

struct Texture {
    size: Size,
    view: wgpu::TextureView,
    id: TextureId,
}

impl Canvas {
    /// On the device that draws the window.
    pub fn new(state: &RenderState) -> Self {
        let renderer = ResidentRenderer::with_device(&state.device, &state.queue);
        Self { state: state.clone(), renderer, texture: None, drawn: None, count: 0 }
    }

    /// What a camera sees of a sky, as the window shows it.
    ///
    /// # Errors
    ///
    /// Those of [`ResidentRenderer::encode`].
    pub fn show(&mut self, sky: &Arc<SkyPlan>, camera: &CameraScene) -> Result<TextureId> {
        let is_drawn = self.drawn.as_ref().is_some_and(|(of, from)| Arc::ptr_eq(of, sky) && from == camera);
        let texture = match self.texture.take() {
            Some(texture) if texture.size == camera.size => texture,
            other => Texture::new(&self.state, camera.size, other),
        };
        let texture = self.texture.insert(texture);
        if !is_drawn {
            let mut encoder = self.state.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            self.renderer.encode(&mut encoder, sky, camera, &Target::Texture(&texture.view))?;
            self.state.queue.submit([encoder.finish()]);
            self.drawn = Some((Arc::clone(sky), camera.clone()));
            self.count += 1;
        }
        Ok(texture.id)
    }

    /// How often a sky was drawn.
    pub fn count(&self) -> u32 {
        self.count
    }
}

impl Texture {
    /// Of a size, in the place of another one.
    fn new(state: &RenderState, size: Size, other: Option<Self>) -> Self {
        let texture = state.device.create_texture(&wgpu::TextureDescriptor {
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
        let (device, filter) = (&state.device, wgpu::FilterMode::Nearest);
        let mut renderer = state.renderer.write();
        let id = match other {
            Some(Self { id, .. }) => {
                renderer.update_egui_texture_from_wgpu_texture(device, &view, filter, id);
                id
            }
            None => renderer.register_native_texture(device, &view, filter),
        };
        Self { size, view, id }
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
