//! Pictures by WebGPU. Nothing waits: what takes time is a promise of the browser.

use std::sync::{Arc, Mutex};

use js_sys::{Array, Function, Object, Promise, Reflect};
use sorairo::scene::CameraScene;
use sorairo::wgpu::webgpu::{GpuDevice, GpuTexture};
use sorairo::{AirPlan, AirVolumeTarget, Error, PixelFormat, ResidentRenderer, Sky, Target, wgpu};
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{JsCast, JsValue};
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
    /// The air of the volume that was filled last.
    air: Option<AirPlan>,
    /// Why the device was lost.
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
        let instance = instance();
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = instance.request_adapter(&options).await;
        let adapter = adapter.map_err(|error| format!("WebGPU has no device here: {error}"))?;
        let device = adapter.request_device(&ResidentRenderer::device_descriptor(&adapter)).await;
        let (device, queue) = device.map_err(|error| format!("The device of WebGPU cannot be opened: {error}"))?;
        Ok(Self { canvas: Canvas::new(&instance), ..Self::on(device, queue) })
    }

    /// Takes a device of the page; into canvases the page draws by itself.
    ///
    /// # Errors
    ///
    /// A sentence for what is no device.
    pub async fn attach(device: &GpuDevice) -> Result<Self, String> {
        let refused = || "The device cannot be attached: it is not a GPUDevice of this page".to_owned();
        if !device.is_instance_of::<GpuDevice>() {
            return Err(refused());
        }
        let adapter = offering(device).ok_or_else(refused)?.request_adapter(&Default::default()).await;
        let opened = adapter.map_err(|_| refused())?.request_device(&Default::default()).await;
        let (opened, queue) = opened.map_err(|_| refused())?;
        if opened.as_webgpu() == Some(device) { Ok(Self::on(opened, queue)) } else { Err(refused()) }
    }

    fn on(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let fault = Arc::<Mutex<Option<String>>>::default();
        let gone = Arc::clone(&fault);
        let lost = kept(|keep| {
            device.set_device_lost_callback(move |reason, message| {
                *gone.lock().expect("no holder of this lock panics") =
                    Some(format!("it was lost ({reason:?}) {message}"));
                keep();
            });
        });
        let renderer = ResidentRenderer::with_device(&device, &queue);
        let name = name(&device.adapter_info());
        Self { name, device, queue, renderer, buffers: None, canvas: None, air: None, fault, lost }
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
        let watch = Watch::new(&self.device);
        let buffers = match self.buffers.take() {
            Some(buffers) if buffers.staging.size() >= bytes => buffers,
            _ => Buffers::new(&self.device, bytes),
        };
        self.renderer.set_linear_exposure(0.0);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let target = Target::Buffer(&buffers.pixels, pixel);
        self.renderer.encode(&mut encoder, sky, camera, &target).map_err(failure)?;
        encoder.copy_buffer_to_buffer(&buffers.pixels, 0, &buffers.staging, 0, bytes);
        self.queue.submit([encoder.finish()]);
        let slice = buffers.staging.slice(..bytes);
        let errors = watch.end();
        let mapping = mapped(slice).await;
        self.check_fault()?;
        mapping.map_err(|_| Failure::Lost("it does not answer".into()))?;
        errors.await.map_err(Failure::Lost)?;
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
        let watch = Watch::new(&self.device);
        // From here to where the picture is taken nothing may wait: the texture is that of one task.
        let texture = canvas.texture(&self.device, camera.size).ok_or_else(unanswered)?;
        let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.renderer.encode(&mut encoder, sky, camera, &Target::Texture(&view)).map_err(failure)?;
        self.queue.submit([encoder.finish()]);
        let bitmap = canvas.take().ok_or_else(unanswered)?;
        let errors = watch.end();
        // Whoever asks for the next picture before this one is done would queue more than the device draws.
        self.done().await;
        let checked = match self.check_fault() {
            Ok(()) => errors.await.map_err(Failure::Lost),
            lost => lost,
        };
        checked.inspect_err(|_| bitmap.close())?;
        Ok(bitmap)
    }

    /// Draws the linear RGB that a camera sees of a sky, times 2^`stops`, into a texture of this device.
    ///
    /// # Errors
    ///
    /// A [`Failure`].
    pub async fn draw(
        &mut self,
        sky: &Sky,
        camera: &CameraScene,
        texture: GpuTexture,
        stops: f32,
    ) -> Result<(), Failure> {
        let texture = self.of_halves(texture)?;
        self.encoded(stops, |renderer, encoder| {
            renderer.encode(encoder, sky, camera, &Target::Part(texture.as_image_copy()))
        })
        .await
    }

    /// Fills two volumes of this device with the air before a camera, its light times 2^`stops`; the middle of its
    /// distances (km).
    ///
    /// # Errors
    ///
    /// A [`Failure`].
    pub async fn fill_air(
        &mut self,
        sky: &Sky,
        camera: &CameraScene,
        [in_scatter, transmittance]: [GpuTexture; 2],
        stops: f32,
    ) -> Result<f64, Failure> {
        let (in_scatter, transmittance) = (self.of_halves(in_scatter)?, self.of_halves(transmittance)?);
        let slices = in_scatter.depth_or_array_layers();
        let known = self.air.take().filter(|air| air.sky().is_same(sky) && air.slices() == slices);
        let air = known.map_or_else(|| AirPlan::new(sky, slices, AirPlan::middle_of(sky)), Ok).map_err(failure)?;
        let target = AirVolumeTarget { in_scatter: &in_scatter, transmittance: &transmittance };
        self.encoded(stops, |renderer, encoder| renderer.encode_volume(encoder, &air, camera, &target)).await?;
        let middle = air.middle();
        self.air = Some(air);
        Ok(middle)
    }

    /// Submits what a function encodes, with linear RGB times 2^`stops`.
    async fn encoded(
        &mut self,
        stops: f32,
        encode: impl FnOnce(&mut ResidentRenderer, &mut wgpu::CommandEncoder) -> sorairo::Result<()>,
    ) -> Result<(), Failure> {
        if !stops.is_finite() {
            return Err(Failure::Refused("The stops of the exposure must be a finite number".into()));
        }
        self.check_fault()?;
        self.renderer.set_linear_exposure(stops);
        let watch = Watch::new(&self.device);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encode(&mut self.renderer, &mut encoder).map_err(failure)?;
        self.queue.submit([encoder.finish()]);
        watch.end().await.map_err(Failure::Refused)?;
        self.check_fault()
    }

    /// A texture of the page, of half floats.
    fn of_halves(&self, texture: GpuTexture) -> Result<wgpu::Texture, Failure> {
        let told = |name: &str| Reflect::get(&texture, &name.into()).ok().and_then(|value| value.as_string());
        if !texture.is_instance_of::<GpuTexture>() || told("format").as_deref() != Some("rgba16float") {
            return Err(Failure::Refused("The target is not a GPUTexture of the format rgba16float".into()));
        }
        let descriptor = wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: texture.width(),
                height: texture.height(),
                depth_or_array_layers: texture.depth_or_array_layers(),
            },
            mip_level_count: texture.mip_level_count(),
            sample_count: texture.sample_count(),
            dimension: match told("dimension").as_deref() {
                Some("3d") => wgpu::TextureDimension::D3,
                _ => wgpu::TextureDimension::D2,
            },
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::from_bits_truncate(texture.usage()),
            view_formats: &[],
        };
        Ok(self.device.create_texture_from_webgpu_handle(texture, &descriptor, None))
    }

    /// Waits until the device has done what was submitted, or is lost: one that was given up does not say that it is
    /// done.
    async fn done(&self) {
        let done = kept(|keep| self.queue.on_submitted_work_done(keep));
        // Neither is ever refused.
        let _ = JsFuture::from(Promise::race(&Array::of2(&done, &self.lost))).await;
    }

    /// Whether the device is still there.
    fn check_fault(&self) -> Result<(), Failure> {
        let fault = self.fault.lock().expect("no holder of this lock panics").take();
        fault.map_or(Ok(()), |fault| Err(Failure::Lost(fault.replace('\n', " "))))
    }
}

/// The errors of what is asked of a device meanwhile, of which its own handler hears nothing.
struct Watch([wgpu::ErrorScopeGuard; 3]);

impl Watch {
    fn new(device: &wgpu::Device) -> Self {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let mut scopes = [Internal, OutOfMemory, Validation].map(|errors| device.push_error_scope(errors));
        // The last one is ended first.
        scopes.reverse();
        Self(scopes)
    }

    /// Ends at once; the first error comes later.
    fn end(self) -> impl Future<Output = Result<(), String>> {
        let ends = self.0.map(wgpu::ErrorScopeGuard::pop);
        async {
            for end in ends {
                if let Some(error) = end.await {
                    return Err(error.to_string().replace('\n', " "));
                }
            }
            Ok(())
        }
    }
}

/// An instance of WebGPU.
fn instance() -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::BROWSER_WEBGPU;
    wgpu::Instance::new(descriptor)
}

/// An instance whose adapter offers a device of the page, because wgpu takes only devices that it opens: while the
/// instance is made, and no other script runs, `navigator.gpu` leads to that device. None where that is forbidden.
fn offering(device: &GpuDevice) -> Option<wgpu::Instance> {
    let promise = Reflect::get(&js_sys::global(), &"Promise".into()).ok()?;
    let resolve: Function = Reflect::get(&promise, &"resolve".into()).ok()?.unchecked_into();
    let with = |name: &str, value: &JsValue| {
        let object = Object::new();
        Reflect::set(&object, &name.into(), value).ok().map(|_| object)
    };
    let adapter = with("requestDevice", &resolve.bind1(&promise, device))?;
    let gpu = with("requestAdapter", &resolve.bind1(&promise, &adapter))?;
    let stand_in = with("value", &gpu)?;
    Reflect::set(&stand_in, &"configurable".into(), &true.into()).ok()?;
    let navigator: Object = Reflect::get(&js_sys::global(), &"navigator".into()).ok()?.unchecked_into();
    let name = "gpu".into();
    let before = Object::get_own_property_descriptor(&navigator, &name);
    if !Reflect::define_property(&navigator, &name, &stand_in).ok()? {
        return None;
    }
    let instance = instance();
    if before.is_undefined() {
        Reflect::delete_property(&navigator, &name).ok()?;
    } else {
        Reflect::define_property(&navigator, &name, before.unchecked_ref()).ok()?;
    }
    Some(instance)
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
