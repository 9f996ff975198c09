//! Rendering in a program's own device. The renderer encodes into the program's commands, without a read-back, a thread
//! or a wait. It submits only the filling of a sky lookup itself, once per sky.

use std::future::Future;
use std::pin::pin;
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll, Waker};

use sorairo_shared::camera::Camera;
use sorairo_shared::glam::Vec4;
use sorairo_shared::kernels::WORKGROUP_SIDE;
use sorairo_shared::uniform::{Buffers, Uniform};
use wgpu::util::DeviceExt;

use super::environment::{self, Environment, EnvironmentTarget, Texels};
use super::kernels::{Kernels, dispatch};
use super::layouts::{STORAGE_BUFFERS, groups_of_lookup, lookup_bytes, not_empty};
use super::target::Target;
use crate::device::quirks;
use crate::device::rows::invocations_per_row;
use crate::error::{Error, Result};
use crate::plan::lookup::LookupSize;
use crate::plan::{Kernel, LightFields, Plan, Sky, day};
use crate::scene::{CameraScene, ExrDepth, Projection, Size, ValidScene};
use sorairo_shared::variant::PixelFormat;

/// Renders skies in a program's own device.
///
/// The data of a sky is uploaded when it is first drawn. A sky lookup is refilled only if the sky changes, or the rows
/// of an equirectangular image. For the first perspective camera of a sky only its view is filled, for the next one
/// everything. The renderer submits the filling of a lookup itself, into a buffer of that sky alone. Commands in the
/// program's encoders may therefore be submitted in any order, or dropped.
pub struct ResidentRenderer {
    pub(super) device: wgpu::Device,
    queue: wgpu::Queue,
    pub(super) kernels: Arc<Kernels>,
    light_fields: OnceLock<LightFields>,
    most_rounds: u64,
    sky: Option<UploadedSky>,
    lookup: Option<FilledLookup>,
    /// The table of the air that was used last.
    pub(super) air: Option<(Arc<[Vec4]>, wgpu::Buffer)>,
    pixels: Option<wgpu::Buffer>,
    environment: Option<Environment>,
    /// Black pixels, and their format.
    black: Option<(PixelFormat, wgpu::Buffer)>,
    /// The exposure of linear RGB (stops).
    pub(super) linear_exposure: f32,
    /// Whether the warning about a clipped disc was logged.
    has_told_of_cut: bool,
}

/// The buffers of a sky, for all cameras.
struct UploadedSky {
    of: Sky,
    /// Whether its multiply scattered light is that of the finer grid.
    is_refined: bool,
    /// Samples per piece: a sky lookup may take fewer than an integrated pixel.
    samples: u32,
    bands: wgpu::Buffer,
    quadrature: wgpu::Buffer,
    multiple: wgpu::Buffer,
    columns: wgpu::Buffer,
}

/// A sky lookup, and the view for which it was filled.
struct FilledLookup {
    of: Sky,
    size: Option<LookupSize>,
    /// The size of an equirectangular image, whose rows the lookup has.
    rows_of: Option<Size>,
    /// The perspective camera for which it was filled; `None` if it was filled for any.
    seen_by: Option<Camera>,
    buffer: wgpu::Buffer,
}

/// The part of a sky lookup to be filled.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Fill {
    Nothing,
    Seen,
    Whole,
}

impl ResidentRenderer {
    /// A renderer in a program's device. Nothing is compiled or allocated yet.
    ///
    /// Without [`wgpu::Features::PASSTHROUGH_SHADERS`] wgpu translates the kernels, which takes some seconds for the
    /// first image of a kind.
    pub fn with_device(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self {
            kernels: Arc::new(Kernels::new(device)),
            light_fields: OnceLock::new(),
            most_rounds: quirks::most_rounds(&device.adapter_info().driver),
            device: device.clone(),
            queue: queue.clone(),
            sky: None,
            lookup: None,
            air: None,
            pixels: None,
            environment: None,
            black: None,
            linear_exposure: 0.0,
            has_told_of_cut: false,
        }
    }

    /// The same renderer, with a pipeline cache of the program. Call this before any pipeline is compiled. Caches need
    /// the feature [`wgpu::Features::PIPELINE_CACHE`], which [`Self::device_descriptor`] requests if available.
    #[must_use]
    pub fn with_pipeline_cache(self, cache: wgpu::PipelineCache) -> Self {
        let kernels = Kernels::new(&self.device).with_cache(cache);
        Self { kernels: Arc::new(kernels), ..self }
    }

    /// Returns a closure that compiles the pipelines for a camera's images of a scene's sky, for any sun from the
    /// zenith to the night. Any thread may run it: `std::thread::spawn(renderer.warm_up(&scene, &camera, pixel))`.
    /// [`Self::encode`] compiles missing pipelines, which takes tens of milliseconds each, and hundreds if wgpu
    /// translates the kernels.
    ///
    /// All of the scene matters except the sun's position and the camera; of the camera, its projection and size.
    pub fn warm_up(
        &self,
        scene: &ValidScene,
        camera: &CameraScene,
        pixel: PixelFormat,
    ) -> impl FnOnce() + 'static + use<> {
        let (device, kernels) = (self.device.clone(), Arc::clone(&self.kernels));
        let (scene, camera) = (scene.clone(), camera.clone());
        move || {
            for (kernel, variant) in day::kernels(&scene, &camera, pixel) {
                kernels.pipeline(&device, kernel, variant);
            }
        }
    }

    /// The same for environment maps of one size; see [`Self::encode_environment`].
    pub fn warm_up_environment(&self, scene: &ValidScene, size: Size) -> impl FnOnce() + 'static + use<> {
        let (device, kernels) = (self.device.clone(), Arc::clone(&self.kernels));
        let of_images = self.warm_up(scene, &environment::camera(size), PixelFormat::LinearRgba);
        move || {
            of_images();
            environment::compile(&device, &kernels);
        }
    }

    /// The number of compiled pipelines.
    pub fn pipelines(&self) -> usize {
        self.kernels.count()
    }

    /// Sets the exposure (stops) of linear RGB from now on, including levels and harmonics of environment maps. Half
    /// floats end at 65504, and the sun's disc is forty times as bright. Pictures are unaffected.
    /// [`ResidentRenderer::exposure_of_halves`] suggests a value for a view.
    pub fn set_linear_exposure(&mut self, stops: f32) {
        if self.linear_exposure != stops {
            self.linear_exposure = stops;
            self.has_told_of_cut = false;
            // Its entries are colours.
            self.lookup = None;
        }
    }

    /// The exposure (stops) at which half floats hold the brightest value in a camera's view of a sky, the sun's disc
    /// included, and digits of the darkest; 0 if they hold them without exposure.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::NotAllowed`] for an invalid camera.
    pub fn exposure_of_halves(sky: &Sky, camera: &CameraScene) -> Result<f32> {
        Ok(Plan::seen(sky, camera, PixelFormat::HalfRgb)?.linear_exposure(ExrDepth::Half))
    }

    /// The light fields for plans of the skies of this renderer, the same at each call; see [`Sky::with_light_fields`].
    /// On a hardware device, it computes light fields and other integrals of a plan. For a software device, and in a
    /// browser, where blocking is impossible, the CPU computes them.
    pub fn light_fields(&self) -> LightFields {
        self.light_fields.get_or_init(|| self.new_light_fields()).clone()
    }

    fn new_light_fields(&self) -> LightFields {
        #[cfg(not(target_arch = "wasm32"))]
        if self.device.adapter_info().device_type != wgpu::DeviceType::Cpu {
            return super::planner::light_fields_by(Arc::clone(&self.kernels), &self.device, &self.queue);
        }
        LightFields::default()
    }

    /// The descriptor of a device for this renderer: all limits of the adapter and, if available, the feature without
    /// which wgpu translates the kernels and that of pipeline caches.
    pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
        // SAFETY: the one experimental feature used is that the library's own kernels are passed through, see `module`.
        #[expect(unsafe_code, reason = "wgpu marks the feature as experimental")]
        let experimental_features = unsafe { wgpu::ExperimentalFeatures::enabled() };
        wgpu::DeviceDescriptor {
            label: Some("sorairo"),
            required_features: adapter.features()
                & (wgpu::Features::PASSTHROUGH_SHADERS | wgpu::Features::PIPELINE_CACHE),
            required_limits: adapter.limits(),
            experimental_features,
            memory_hints: wgpu::MemoryHints::Performance,
            trace: wgpu::Trace::Off,
        }
    }

    /// Encodes a camera's image of a sky into a target.
    ///
    /// Computes lazily whatever the plan of the sky lacks. Call [`Sky::prepare_images`] first, off the render thread,
    /// to keep the frame short; with light fields on a device, the frame then waits for none of them.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::NotAllowed`] for an invalid camera; [`Error::Target`] for a target of the
    /// wrong size, usage or format; [`Error::Device`] for an image that exceeds a limit of the device, or a lost device
    /// (not detected in a browser). In these cases nothing was encoded.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        sky: &Sky,
        camera: &CameraScene,
        target: &Target<'_>,
    ) -> Result<()> {
        let plan = self.plan(sky, camera, target.pixel()?, target.pixel()? == PixelFormat::HalfRgb)?;
        target.check(&plan)?;
        self.check_present()?;
        let row_pixels = target.row_pixels(&plan);
        self.check_limits(&plan, row_pixels)?;
        let output = self.output(&plan, row_pixels, target);
        self.draw(encoder, &plan, camera, row_pixels, &output);
        if let Some(part) = target.part() {
            let bytes_per_row = Some(4 * row_pixels * plan.pixel_words());
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
            let source = wgpu::TexelCopyBufferInfo { buffer: &output, layout };
            let size = wgpu::Extent3d { width: plan.width(), height: plan.height(), depth_or_array_layers: 1 };
            encoder.copy_buffer_to_texture(source, part, size);
        }
        Ok(())
    }

    /// Encodes a sky as an environment map with all levels, and its irradiance, for image-based lighting.
    ///
    /// The map is equirectangular with north in its centre, and has the size of the texture. A pixel of a level is the
    /// mean over its part of the sphere; the last level, a single pixel, is the mean radiance; see
    /// [`sorairo_shared::picture::environment`]. The irradiance has the order and the axes of
    /// [`Harmonics`](crate::Harmonics). With `sun.disc` both include the sun; without it, add a sun of your own.
    ///
    /// # Errors
    ///
    /// [`Error::Target`] for a texture or a buffer of the wrong size, usage, format or number of levels;
    /// [`Error::OutOfRange`] for a texture larger than any camera; [`Error::Device`] for one that exceeds a limit of
    /// the device. In these cases nothing was encoded.
    pub fn encode_environment(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        sky: &Sky,
        target: &EnvironmentTarget<'_>,
    ) -> Result<()> {
        let format = target.check()?;
        self.check_present()?;
        let size = Size { width: target.map.width(), height: target.map.height() };
        let camera = environment::camera(size);
        let plan = self.plan(sky, &camera, PixelFormat::LinearRgba, format == Texels::Half)?;
        let row_pixels = environment::row_pixels(size);
        self.check_limits(&plan, row_pixels)?;
        environment::check_limits(&self.device.limits(), size)?;
        let kept = self.environment.take().filter(|environment| environment.serves(size, format));
        let environment = kept.unwrap_or_else(|| Environment::new(&self.device, size, format));
        self.draw(encoder, &plan, &camera, row_pixels, environment.levels());
        environment.encode(encoder, (&self.device, &self.kernels), target);
        self.environment = Some(environment);
        Ok(())
    }

    /// The plan of a camera's image of a sky, exposed, with a warning if half floats clip it.
    pub(super) fn plan(
        &mut self,
        sky: &Sky,
        camera: &CameraScene,
        pixel: PixelFormat,
        becomes_halves: bool,
    ) -> Result<Plan> {
        let plan = Plan::seen(sky, camera, pixel)?.exposed(self.linear_exposure);
        if becomes_halves
            && !self.has_told_of_cut
            && let Some((lost, stops)) = plan.cut_of_disc()
        {
            self.has_told_of_cut = true;
            log::warn!(
                "half floats end at 65504, and the sun's disc is brighter: about {:.0} % of its light is lost in this target; set_linear_exposure({}) keeps it",
                100.0 * lost,
                self.linear_exposure + stops
            );
        }
        Ok(plan)
    }

    /// Encodes the kernels of a plan, which write pixels into a buffer.
    fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        plan: &Plan,
        camera: &CameraScene,
        row_pixels: u32,
        output: &wgpu::Buffer,
    ) {
        let kernel = plan.kernel();
        let lit = plan.lit_rows.clone();
        if !lit.is_empty() {
            let fill = self.reserve_lookup(plan, camera);
            let uniform = Uniform {
                first_row: lit.start,
                rows: lit.len() as u32,
                row_pixels,
                fills_whole_lookup: u32::from(fill == Fill::Whole) | plan.uniform.fills_whole_lookup,
                ..plan.uniform
            };
            let groups = self.bind(plan, &uniform, output);
            if fill != Fill::Nothing {
                self.fill_lookup(plan, &groups.lookup);
            }
            let pipeline = self.kernels.pipeline(&self.device, kernel, plan.variant);
            let columns = invocations_per_row(plan, kernel).div_ceil(WORKGROUP_SIDE);
            dispatch(encoder, &pipeline, &groups.pixels, (columns, uniform.rows.div_ceil(WORKGROUP_SIDE)), None);
        }
        self.copy_black(encoder, plan, row_pixels, output);
    }

    /// Fills a plan's sky lookup by a submission of its own, because the renderer does not know whether the program
    /// submits its encoder.
    pub(super) fn fill_lookup(&self, plan: &Plan, group: &wgpu::BindGroup) {
        let label = Some("sky lookup");
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
        for (kernel, size) in [Kernel::Anchors, Kernel::Lookup].into_iter().zip(groups_of_lookup(&plan.uniform)) {
            let pipeline = self.kernels.pipeline(&self.device, kernel, plan.variant);
            dispatch(&mut encoder, &pipeline, group, size, None);
        }
        self.queue.submit([encoder.finish()]);
    }

    /// Whether the device is still available. wgpu reports a lost device only to the program, which may have set a
    /// callback. But no resource can be created in it any more, and the use of such a resource is an error in a scope.
    /// In a browser this error arrives only after the frame.
    pub(super) fn check_present(&self) -> Result<()> {
        if cfg!(target_arch = "wasm32") {
            return Ok(());
        }
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let buffer = self.empty("made in a device that is there", 4, wgpu::BufferUsages::COPY_DST);
        self.queue.write_buffer(&buffer, 0, &[]);
        match pin!(scope.pop()).poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(Some(_)) => Err(Error::Device("it is lost".into())),
            _ => Ok(()),
        }
    }

    pub(super) fn check_limits(&self, plan: &Plan, row_pixels: u32) -> Result<()> {
        let limits = self.device.limits();
        let too_large = |what: &str| Err(Error::Device(format!("its limits do not allow {what} of this image")));
        let bytes = 4 * u64::from(row_pixels) * u64::from(plan.height()) * u64::from(plan.pixel_words());
        let largest = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        if bytes > largest {
            return too_large("the pixels");
        }
        if lookup_bytes(plan) > largest {
            return too_large("the sky lookup");
        }
        let Buffers { bands, quadrature, colour, multiple, columns } = plan.buffers();
        let sky = [size_of_val(bands), size_of_val(quadrature), size_of_val(multiple), size_of_val(columns)];
        let read = sky.into_iter().chain([size_of_val(colour)]);
        let mut read = read;
        if read.any(|bytes| bytes as u64 > largest) {
            return too_large("what the kernels read");
        }
        let groups = plan.width().max(plan.height()).div_ceil(WORKGROUP_SIDE);
        let [(of_anchors, _), (of_entries, _)] = groups_of_lookup(&plan.uniform);
        if groups.max(of_anchors).max(of_entries) > limits.max_compute_workgroups_per_dimension {
            return too_large("the workgroups");
        }
        let has_uniform = limits.max_uniform_buffer_binding_size >= size_of::<Uniform>() as u64;
        if !has_uniform
            || limits.max_storage_buffers_per_shader_stage < STORAGE_BUFFERS
            || limits.max_compute_invocations_per_workgroup < WORKGROUP_SIDE * WORKGROUP_SIDE
        {
            return too_large("the kernels");
        }
        if quirks::rounds(plan) >= self.most_rounds {
            return too_large("the samples of a pixel");
        }
        Ok(())
    }

    /// The buffer that the kernels write: the caller's, or one of ours.
    fn output(&mut self, plan: &Plan, row_pixels: u32, target: &Target<'_>) -> wgpu::Buffer {
        if let Target::Buffer(buffer, _) = target {
            return (*buffer).clone();
        }
        let bytes = 4 * u64::from(row_pixels) * u64::from(plan.height()) * u64::from(plan.pixel_words());
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let kept = self.pixels.take().filter(|buffer| buffer.size() >= bytes);
        let buffer = kept.unwrap_or_else(|| self.empty("sky pixels", bytes, usage));
        self.pixels = Some(buffer.clone());
        buffer
    }

    pub(super) fn empty(&self, label: &'static str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let label = Some(label);
        self.device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
    }

    /// Allocates the plan's sky lookup, and returns the part to be filled.
    pub(super) fn reserve_lookup(&mut self, plan: &Plan, camera: &CameraScene) -> Fill {
        let sky = &plan.sky;
        let size = plan.lookup.size;
        let rows_of = (camera.projection == Projection::Equirectangular).then_some(camera.size);
        let looks = (camera.projection == Projection::Perspective).then_some(plan.uniform.camera);
        let known = self.lookup.as_ref().filter(|lookup| {
            lookup.of.is_same(sky) && lookup.size == size && (size.is_none() || lookup.rows_of == rows_of)
        });
        let fill = match known {
            Some(FilledLookup { seen_by: None, .. }) => Fill::Nothing,
            Some(FilledLookup { seen_by, .. }) if *seen_by == looks => Fill::Nothing,
            Some(_) => Fill::Whole,
            None if looks.is_some() => Fill::Seen,
            None => Fill::Whole,
        };
        if fill != Fill::Nothing {
            // The lookup of another sky may be read by commands that are submitted later.
            let kept = known.map(|lookup| lookup.buffer.clone());
            let empty = || self.empty("sky lookup", lookup_bytes(plan), wgpu::BufferUsages::STORAGE);
            let buffer = kept.unwrap_or_else(empty);
            let seen_by = looks.filter(|_| fill == Fill::Seen);
            self.lookup = Some(FilledLookup { of: sky.clone(), size, rows_of, seen_by, buffer });
        }
        if plan.kernel() == Kernel::SkyLookup { fill } else { Fill::Nothing }
    }

    /// The sky lookup, which was reserved.
    pub(super) fn lookup_buffer(&self) -> wgpu::Buffer {
        self.lookup.as_ref().expect("it was reserved").buffer.clone()
    }

    /// Binds a plan's buffers. Uniform and colour rows belong to this image alone, because several images may be
    /// encoded before any is submitted.
    pub(super) fn bind(&mut self, plan: &Plan, uniform: &Uniform, output: &wgpu::Buffer) -> super::layouts::Groups {
        let buffers = plan.buffers();
        let storage = wgpu::BufferUsages::STORAGE;
        let is_refined = plan.is_refined();
        let samples = plan.samples_per_piece();
        let is_known =
            |sky: &UploadedSky| sky.of.is_same(&plan.sky) && sky.is_refined == is_refined && sky.samples == samples;
        let sky = match self.sky.take().filter(is_known) {
            Some(uploaded) => uploaded,
            None => UploadedSky {
                of: plan.sky.clone(),
                is_refined,
                samples,
                bands: filled(&self.device, "bands", bytemuck::cast_slice(buffers.bands), storage),
                quadrature: filled(&self.device, "quadrature", bytemuck::cast_slice(buffers.quadrature), storage),
                // A binding may not be empty.
                multiple: filled(&self.device, "multiply scattered light", &not_empty(buffers.multiple), storage),
                columns: filled(&self.device, "tables of the medium", &not_empty(buffers.columns), storage),
            },
        };
        let colour = filled(&self.device, "colour", &not_empty(buffers.colour), storage);
        let uniform = filled(&self.device, "uniform", bytemuck::bytes_of(uniform), wgpu::BufferUsages::UNIFORM);
        let lookup = self.lookup_buffer();
        let bound = [&uniform, &sky.bands, &sky.quadrature, &colour, &sky.multiple, &lookup, output, &sky.columns];
        let groups =
            self.kernels.layouts(&self.device).bind(&self.device, &bound.map(|buffer| (buffer, buffer.size())));
        self.sky = Some(sky);
        groups
    }

    /// Copies black rows to where the kernels write none.
    fn copy_black(&mut self, encoder: &mut wgpu::CommandEncoder, plan: &Plan, row_pixels: u32, output: &wgpu::Buffer) {
        let rows = plan.height() - plan.lit_rows.len() as u32;
        if rows == 0 {
            return;
        }
        let bytes = 4 * u64::from(row_pixels) * u64::from(rows) * u64::from(plan.pixel_words());
        let kept = self.black.take().filter(|(pixel, buffer)| *pixel == plan.pixel && buffer.size() >= bytes);
        let (_, black) = self.black.insert(kept.unwrap_or_else(|| {
            let words = plan.pixel.black().repeat((row_pixels * rows) as usize);
            (plan.pixel, filled(&self.device, "black", bytemuck::cast_slice(&words), wgpu::BufferUsages::COPY_SRC))
        }));
        // Rows are lit from the top.
        let offset = 4 * u64::from(row_pixels) * u64::from(plan.lit_rows.len() as u32) * u64::from(plan.pixel_words());
        encoder.copy_buffer_to_buffer(black, 0, output, offset, bytes);
    }

    /// The queue for the commands, which also fills sky lookups.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }
}

pub(super) fn filled(
    device: &wgpu::Device,
    label: &'static str,
    contents: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
}
