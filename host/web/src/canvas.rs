//! Pictures as a canvas takes them.

use sorairo::scene::Size;
use sorairo::wgpu;
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{Clamped, JsCast, JsValue};
use web_sys::{ImageBitmap, ImageData, OffscreenCanvas};

#[wasm_bindgen]
extern "C" {
    /// The browser's own function, of a page and of a worker.
    #[wasm_bindgen(js_name = createImageBitmap, catch)]
    async fn create_image_bitmap(pixels: &ImageData) -> Result<JsValue, JsValue>;
}

/// A canvas out of sight, into which WebGPU draws.
pub struct Canvas {
    canvas: OffscreenCanvas,
    surface: wgpu::Surface<'static>,
    size: Option<Size>,
}

impl Canvas {
    /// A canvas; none where the browser has none out of sight, or none for WebGPU.
    pub fn new(instance: &wgpu::Instance) -> Option<Self> {
        let canvas = OffscreenCanvas::new(1, 1).ok()?;
        let surface = instance.create_surface(wgpu::SurfaceTarget::OffscreenCanvas(canvas.clone())).ok()?;
        Some(Self { canvas, surface, size: None })
    }

    /// The texture of its next picture, for copies of `rgba8unorm`; none where the browser gives none.
    pub fn texture(&mut self, device: &wgpu::Device, size: Size) -> Option<wgpu::SurfaceTexture> {
        if self.size != Some(size) {
            self.surface.configure(device, &configuration(size));
            self.size = Some(size);
        }
        match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(texture) | wgpu::CurrentSurfaceTexture::Suboptimal(texture) => {
                Some(texture)
            }
            _ => None,
        }
    }

    /// Takes away the picture that was drawn, which the canvas forgets with the task of the browser that drew it.
    pub fn take(&self) -> Option<ImageBitmap> {
        self.canvas.transfer_to_image_bitmap().ok()
    }
}

fn configuration(Size { width, height }: Size) -> wgpu::SurfaceConfiguration {
    wgpu::SurfaceConfiguration {
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_DST,
        format: wgpu::TextureFormat::Rgba8Unorm,
        color_space: wgpu::SurfaceColorSpace::Srgb,
        width,
        height,
        present_mode: wgpu::PresentMode::Fifo,
        desired_maximum_frame_latency: 2,
        alpha_mode: wgpu::CompositeAlphaMode::Opaque,
        view_formats: Vec::new(),
    }
}

/// A picture from its pixels, each of red, green, blue and opacity.
///
/// # Errors
///
/// A sentence where the browser has no room for it.
pub async fn bitmap_of(pixels: &[u8], size: Size) -> Result<ImageBitmap, String> {
    let too_large = |_| format!("The browser has no room for a picture of {size} pixels");
    let image = ImageData::new_with_u8_clamped_array_and_sh(Clamped(pixels), size.width, size.height);
    let bitmap = create_image_bitmap(&image.map_err(too_large)?).await;
    Ok(bitmap.map_err(too_large)?.unchecked_into())
}
