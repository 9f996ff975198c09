//! Pictures by WebGPU. Nothing waits: what takes time is a promise of the browser.

use std::sync::{Arc, Mutex};

use js_sys::Promise;
use sorairo::scene::CameraScene;
use sorairo::wgpu;
use sorairo::{Error, PixelFormat, ResidentRenderer, SkyPlan, Target};
use wasm_bindgen::JsValue;
use wasm_bindgen_futures::JsFuture;

/// A device of the browser.
pub struct Gpu {
    /// Its name.
    pub name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    renderer: ResidentRenderer,
    buffers: Option<Buffers>,
    /// The first error that the device reported.
    fault: Arc<Mutex<Option<String>>>,
}

/// Where a picture is computed, and where it comes back to.
struct Buffers {
    pixels: wgpu::Buffer,
    staging: wgpu::Buffer,
}

/// Why there is no picture.
pub enum Failure {
    /// What is asked for is wrong, on any device.
    Refused(String),
    /// The device is too small for this picture, and goes on with others.
    TooSmall(String),
    /// The device is gone.
    Lost(String),
}

impl Gpu {
    /// Opens the browser's device.
    ///
    /// # Errors
    ///
    /// Why there is none, in a sentence.
    pub async fn open() -> Result<Self, String> {
        if !wgpu::util::is_browser_webgpu_supported().await {
            return Err("This browser has no WebGPU, or keeps it from this page".into());
        }
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::BROWSER_WEBGPU;
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = wgpu::Instance::new(descriptor).request_adapter(&options).await;
        let adapter = adapter.map_err(|error| format!("WebGPU has no device here: {error}"))?;
        let device = adapter.request_device(&ResidentRenderer::device_descriptor(&adapter)).await;
        let (device, queue) = device.map_err(|error| format!("The device of WebGPU cannot be opened: {error}"))?;
        let fault = Arc::<Mutex<Option<String>>>::default();
        let record = || {
            let fault = Arc::clone(&fault);
            move |text: String| {
                fault.lock().expect("no holder of this lock panics").get_or_insert(text);
            }
        };
        let (failed, lost) = (record(), record());
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| failed(error.to_string())));
        device.set_device_lost_callback(move |reason, message| lost(format!("it was lost ({reason:?}) {message}")));
        let renderer = ResidentRenderer::with_device(&device, &queue);
        Ok(Self { name: name(&adapter.get_info()), device, queue, renderer, buffers: None, fault })
    }

    /// The pixels that a camera sees of a sky, in the layout of their format.
    ///
    /// # Errors
    ///
    /// A [`Failure`].
    pub async fn pixels(
        &mut self,
        sky: &Arc<SkyPlan>,
        camera: &CameraScene,
        pixel: PixelFormat,
    ) -> Result<Vec<u32>, Failure> {
        let bytes = 4 * u64::from(pixel.words()) * u64::from(camera.size.width) * u64::from(camera.size.height);
        if bytes > self.device.limits().max_buffer_size {
            return Err(Failure::TooSmall(format!("its limits do not allow a picture of {} pixels", camera.size)));
        }
        let buffers = match self.buffers.take() {
            Some(buffers) if buffers.staging.size() >= bytes => buffers,
            _ => Buffers::new(&self.device, bytes),
        };
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let target = Target::Buffer(&buffers.pixels, pixel);
        let encoded = self.renderer.encode(&mut encoder, sky, camera, &target);
        encoded.map_err(|error| match error {
            Error::Device(reason) => Failure::TooSmall(reason),
            other => Failure::Refused(other.to_string()),
        })?;
        encoder.copy_buffer_to_buffer(&buffers.pixels, 0, &buffers.staging, 0, bytes);
        self.queue.submit([encoder.finish()]);
        let slice = buffers.staging.slice(..bytes);
        let mapping = mapped(slice).await;
        if let Some(fault) = self.fault.lock().expect("no holder of this lock panics").take() {
            return Err(Failure::Lost(fault.replace('\n', " ")));
        }
        mapping.map_err(|_| Failure::Lost("it does not answer".into()))?;
        let range = slice.get_mapped_range().map_err(|error| Failure::Lost(error.to_string()))?;
        let words = range.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().expect("four bytes")));
        let pixels = words.collect();
        drop(range);
        buffers.staging.unmap();
        self.buffers = Some(buffers);
        Ok(pixels)
    }
}

impl Buffers {
    fn new(device: &wgpu::Device, size: u64) -> Self {
        let buffer = |label, usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let (storage, copied) = (wgpu::BufferUsages::STORAGE, wgpu::BufferUsages::COPY_DST);
        Self {
            pixels: buffer("pixels", storage | copied | wgpu::BufferUsages::COPY_SRC),
            staging: buffer("read-back", copied | wgpu::BufferUsages::MAP_READ),
        }
    }
}

/// A promise that is kept when a buffer is mapped.
async fn mapped(slice: wgpu::BufferSlice<'_>) -> Result<JsValue, JsValue> {
    let promise = Promise::new(&mut |resolve, reject| {
        slice.map_async(wgpu::MapMode::Read, move |mapped| {
            let settle = if mapped.is_ok() { &resolve } else { &reject };
            // A promise's own functions throw nothing.
            let _ = settle.call0(&JsValue::NULL);
        });
    });
    JsFuture::from(promise).await
}

fn name(info: &wgpu::AdapterInfo) -> String {
    let told = [info.name.as_str(), info.driver.as_str()].into_iter().find(|text| !text.trim().is_empty());
    told.map_or_else(|| "WebGPU".into(), |name| format!("WebGPU ({name})"))
}
