//! Pictures by WebGPU. Nothing waits: what takes time is a promise of the browser.

use std::sync::{Arc, Mutex};

use js_sys::{Array, Function, Promise};
use sorairo::scene::CameraScene;
use sorairo::{Error, PixelFormat, ResidentRenderer, Sky, Target, wgpu};
use wasm_bindgen::JsValue;
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen_futures::JsFuture;
use web_sys::ImageBitmap;

use crate::canvas::Canvas;

/// How often a lost device is asked for again.
const TRIES: u32 = 5;
/// From one time to the next (ms).
const PAUSE: f64 = 200.0;

#[wasm_bindgen]
extern "C" {
    /// The browser's own function, of a page and of a worker.
    #[wasm_bindgen(js_name = setTimeout)]
    fn set_timeout(then: &Function, milliseconds: f64);
}

/// A device of the browser.
pub struct Gpu {
    /// Its name.
    pub name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// It compiles nothing ahead (`warm_up`): a pipeline is one step, of as long as the frame that needs it would wait,
    /// on the thread that answers the page; the browser has a way to compile one beside that, and wgpu none to take it
    /// from there.
    renderer: ResidentRenderer,
    buffers: Option<Buffers>,
    canvas: Option<Canvas>,
    /// The first error that the device reported.
    fault: Arc<Mutex<Option<String>>>,
    /// Kept when the device is lost.
    lost: Promise,
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
        let instance = wgpu::Instance::new(descriptor);
        let adapter = instance.request_adapter(&options).await;
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
        let (failed, gone) = (record(), record());
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| failed(error.to_string())));
        let lost = kept(|keep| {
            device.set_device_lost_callback(move |reason, message| {
                gone(format!("it was lost ({reason:?}) {message}"));
                keep();
            });
        });
        let renderer = ResidentRenderer::with_device(&device, &queue);
        let (name, canvas) = (name(&adapter.get_info()), Canvas::new(&instance));
        Ok(Self { name, device, queue, renderer, buffers: None, canvas, fault, lost })
    }

    /// Opens the browser's device again after it was lost: the browser may need a moment for it.
    ///
    /// # Errors
    ///
    /// Those of [`Gpu::open`].
    pub async fn reopen() -> Result<Self, String> {
        for _ in 1..TRIES {
            if let Ok(gpu) = Self::open().await {
                return Ok(gpu);
            }
            pause().await;
        }
        Self::open().await
    }

    /// The pixels that a camera sees of a sky, in the layout of their format.
    ///
    /// # Errors
    ///
    /// A [`Failure`].
    pub async fn pixels(&mut self, sky: &Sky, camera: &CameraScene, pixel: PixelFormat) -> Result<Vec<u32>, Failure> {
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
        self.renderer.encode(&mut encoder, sky, camera, &target).map_err(failure)?;
        encoder.copy_buffer_to_buffer(&buffers.pixels, 0, &buffers.staging, 0, bytes);
        self.queue.submit([encoder.finish()]);
        let slice = buffers.staging.slice(..bytes);
        let mapping = mapped(slice).await;
        self.check_fault()?;
        mapping.map_err(|_| Failure::Lost("it does not answer".into()))?;
        let range = slice.get_mapped_range().map_err(|error| Failure::Lost(error.to_string()))?;
        let words = range.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().expect("four bytes")));
        let pixels = words.collect();
        drop(range);
        buffers.staging.unmap();
        self.buffers = Some(buffers);
        Ok(pixels)
    }

    /// The picture that a camera sees of a sky, for a canvas of the page: its pixels stay on the device.
    ///
    /// # Errors
    ///
    /// A [`Failure`]; [`Failure::TooSmall`] also where the device draws for no canvas, or for none of this size.
    pub async fn bitmap(&mut self, sky: &Sky, camera: &CameraScene) -> Result<ImageBitmap, Failure> {
        // Of a device that is known to be lost a browser's canvas may wait for ever.
        self.check_fault()?;
        let most = self.device.limits().max_texture_dimension_2d;
        let canvas = self.canvas.as_mut().filter(|_| camera.size.width.max(camera.size.height) <= most);
        let canvas = canvas.ok_or_else(|| Failure::TooSmall("it draws for no canvas of this size".into()))?;
        let unanswered = || Failure::Lost("it draws for no canvas".into());
        // From here to where the picture is taken nothing may wait: the texture is that of one task.
        let texture = canvas.texture(&self.device, camera.size).ok_or_else(unanswered)?;
        let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.renderer.encode(&mut encoder, sky, camera, &Target::Texture(&view)).map_err(failure)?;
        self.queue.submit([encoder.finish()]);
        let bitmap = canvas.take().ok_or_else(unanswered)?;
        // Whoever asks for the next picture before this one is done would queue more than the device draws.
        self.done().await;
        self.check_fault().inspect_err(|_| bitmap.close())?;
        Ok(bitmap)
    }

    /// Waits until the device has done what was submitted, or is lost: one that was given up does not say that it is
    /// done.
    async fn done(&self) {
        let done = kept(|keep| self.queue.on_submitted_work_done(keep));
        // Neither is ever refused.
        let _ = JsFuture::from(Promise::race(&Array::of2(&done, &self.lost))).await;
    }

    /// Whether the device has reported an error since it was last asked.
    fn check_fault(&self) -> Result<(), Failure> {
        let fault = self.fault.lock().expect("no holder of this lock panics").take();
        fault.map_or(Ok(()), |fault| Err(Failure::Lost(fault.replace('\n', " "))))
    }
}

/// Why a picture was not encoded.
fn failure(error: Error) -> Failure {
    match error {
        Error::Device(reason) => Failure::TooSmall(reason),
        other => Failure::Refused(other.to_string()),
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

/// A promise that is kept by the function which `promised` gets.
fn kept(promised: impl FnOnce(Box<dyn Fn() + Send>)) -> Promise {
    let mut promised = Some(promised);
    Promise::new(&mut |resolve, _| {
        let keep = move || {
            // A promise's own functions throw nothing.
            let _ = resolve.call0(&JsValue::NULL);
        };
        promised.take().expect("a promise is made once")(Box::new(keep));
    })
}

async fn pause() {
    let promise = Promise::new(&mut |resolve, _| set_timeout(&resolve, PAUSE));
    // It is never refused.
    let _ = JsFuture::from(promise).await;
}

fn name(info: &wgpu::AdapterInfo) -> String {
    let told = [info.name.as_str(), info.driver.as_str()].into_iter().find(|text| !text.trim().is_empty());
    told.map_or_else(|| "WebGPU".into(), |name| format!("WebGPU ({name})"))
}
