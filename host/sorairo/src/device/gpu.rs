//! The kernels on a Vulkan device, from the SPIR-V that travels with the program.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet, VecDeque};
use std::num::NonZero;
use std::ops::Range;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use sorairo_shared::glam::Vec4;
use sorairo_shared::kernels::{LOOKUP_WORKGROUP, WORKGROUP_SIDE};
use sorairo_shared::lookup::entries;
use sorairo_shared::uniform::Uniform;

use super::{Backend, Device, Kernel, TakeRows, Times, invocations_per_row, rounds, rows_at_once, words_per_row};
use crate::error::{Error, Result};
use crate::plan::Plan;

/// The kernels, compiled by rust-gpu; `cargo xtask shaders` rebuilds them.
pub const SPIRV: &[u8] = sorairo_shaders::SPIRV;

/// A bit pattern that no kernel stores (a NaN), so that a pixel which a kernel failed to write can be told.
pub const SENTINEL: u32 = sorairo_shared::kernels::SENTINEL;

/// Rounds after which llvmpipe ends the loops of an invocation, all of them together, and says nothing (`LP_MAX_TGSI_LOOP_ITERATIONS` of
/// Mesa's `lp_bld_limits.h`). A sum would lack its last terms.
const ROUNDS_OF_LLVMPIPE: u64 = 65_535;

/// Strips of an image that are under way at once: one is computed while the other is brought back.
const STRIPS_UNDER_WAY: usize = 2;

/// A Vulkan device with the kernels loaded.
pub struct Gpu {
    name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    passthrough: bool,
    /// One for each value of the specialisation constant.
    modules: Mutex<HashMap<u32, wgpu::ShaderModule>>,
    pipelines: Mutex<HashMap<(&'static str, u32), wgpu::ComputePipeline>>,
    lookup_layouts: Layouts,
    pixel_layouts: Layouts,
    /// What one image leaves to the next.
    buffers: Mutex<DeviceBuffers>,
    /// Kernels and sizes whose output was seen to be whole.
    verified: Mutex<HashSet<(Kernel, u32, u32, u32)>>,
    fault: Arc<Mutex<Option<String>>>,
    /// The largest buffer that a kernel can write (bytes).
    largest_buffer: u64,
    /// The most workgroups along a side of a dispatch.
    most_groups: u32,
    /// The most rounds that the loops of an invocation may make together.
    most_rounds: u64,
    has_timestamps: bool,
    /// Whether the copy of pixels is timed too.
    times_copies: bool,
}

/// A Vulkan device as `sorairo devices` lists it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct DeviceInfo {
    /// The device's name.
    pub name: String,
    /// Discrete, integrated, virtual, or software on the CPU.
    pub kind: String,
    /// The driver and its version.
    pub driver: String,
}

fn instance() -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::VULKAN;
    // Validation layers cost more than an image where they are installed.
    descriptor.flags = wgpu::InstanceFlags::empty();
    wgpu::Instance::new(descriptor)
}

/// The Vulkan devices, best first.
fn adapters(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
    adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    adapters
}

/// The Vulkan devices of this machine, best first.
pub fn devices() -> Vec<DeviceInfo> {
    adapters(&instance())
        .iter()
        .map(|adapter| {
            let info = adapter.get_info();
            DeviceInfo {
                name: info.name,
                kind: match info.device_type {
                    wgpu::DeviceType::DiscreteGpu => "discrete",
                    wgpu::DeviceType::IntegratedGpu => "integrated",
                    wgpu::DeviceType::VirtualGpu => "virtual",
                    wgpu::DeviceType::Cpu => "software",
                    wgpu::DeviceType::Other => "other",
                }
                .into(),
                driver: format!("{} {}", info.driver, info.driver_info).trim().into(),
            }
        })
        .collect()
}

/// The error for a device that is not there.
pub(super) fn no_such_device(choice: &str) -> Error {
    let mut names = vec!["auto".to_owned(), "cpu".to_owned()];
    let found = devices();
    if !found.is_empty() {
        names.push("gpu".into());
    }
    names.extend(found.into_iter().map(|device| format!("{:?}", device.name)));
    Error::NoSuchDevice { choice: choice.to_owned(), names }
}

/// Opens the best Vulkan device whose name contains `wanted`, ignoring case; `None` if there is none.
///
/// # Errors
///
/// [`Error::Device`] if the device is there and cannot be opened.
pub fn open(wanted: &str) -> Result<Option<Device>> {
    Ok(Gpu::open(wanted, u64::MAX)?.map(Gpu::into_device))
}

impl Gpu {
    /// [`open`] of a device that is treated as if it took no buffer larger than `largest_buffer` (bytes).
    ///
    /// # Errors
    ///
    /// [`Error::Device`] if the device is there and cannot be opened.
    pub fn open(wanted: &str, largest_buffer: u64) -> Result<Option<Self>> {
        let wanted = wanted.to_lowercase();
        let instance = instance();
        let adapter =
            adapters(&instance).into_iter().find(|adapter| adapter.get_info().name.to_lowercase().contains(&wanted));
        let Some(adapter) = adapter else { return Ok(None) };
        let name = adapter.get_info().name;
        let gpu = Self::new(&adapter, largest_buffer)
            .map_err(|error| Error::Device(format!("device {name:?} cannot be opened: {error}")))?;
        Ok(Some(gpu))
    }

    /// This device, without spares.
    pub fn into_device(self) -> Device {
        Device { name: self.name.clone(), kind: "gpu", backend: Box::new(self), spares: VecDeque::new() }
    }

    fn new(adapter: &wgpu::Adapter, largest_buffer: u64) -> std::result::Result<Self, wgpu::RequestDeviceError> {
        let wanted = wgpu::Features::TIMESTAMP_QUERY
            | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS
            | wgpu::Features::PASSTHROUGH_SHADERS;
        let features = adapter.features() & wanted;
        let limits = adapter.limits();
        // SAFETY: the one experimental feature used is the shader passthrough, see `load`.
        #[expect(unsafe_code, reason = "wgpu marks the feature as experimental")]
        let experimental_features = unsafe { wgpu::ExperimentalFeatures::enabled() };
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("sorairo"),
            required_features: features,
            required_limits: limits.clone(),
            experimental_features,
            memory_hints: wgpu::MemoryHints::Performance,
            trace: wgpu::Trace::Off,
        }))?;
        let fault = Arc::new(Mutex::new(None));
        let record = |fault: &Arc<Mutex<Option<String>>>| {
            let fault = Arc::clone(fault);
            move |text: String| {
                fault.lock().expect("no holder of this lock panics").get_or_insert(text);
            }
        };
        let (failed, lost) = (record(&fault), record(&fault));
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| failed(error.to_string())));
        device.set_device_lost_callback(move |reason, message| lost(format!("it was lost ({reason:?}) {message}")));
        Ok(Self {
            name: adapter.get_info().name,
            lookup_layouts: Layouts::new(&device, &[0, 1, 2, 3, 4], 4),
            pixel_layouts: Layouts::new(&device, &[0, 1, 2, 3, 4, 5], 5),
            device,
            queue,
            passthrough: features.contains(wgpu::Features::PASSTHROUGH_SHADERS),
            modules: Mutex::default(),
            pipelines: Mutex::default(),
            buffers: Mutex::default(),
            verified: Mutex::default(),
            fault,
            largest_buffer: limits.max_buffer_size.min(limits.max_storage_buffer_binding_size).min(largest_buffer),
            most_groups: limits.max_compute_workgroups_per_dimension,
            most_rounds: if adapter.get_info().driver == "llvmpipe" { ROUNDS_OF_LLVMPIPE } else { u64::MAX },
            has_timestamps: features.contains(wgpu::Features::TIMESTAMP_QUERY),
            times_copies: features.contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS),
        })
    }

    fn pipeline(&self, entry_point: &'static str, variant: u32, layouts: &Layouts) -> wgpu::ComputePipeline {
        let mut modules = self.modules.lock().expect("no holder of this lock panics");
        let module = modules.entry(variant).or_insert_with(|| load(&self.device, self.passthrough, variant));
        let mut pipelines = self.pipelines.lock().expect("no holder of this lock panics");
        let build = || {
            self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&layouts.pipeline),
                module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        pipelines.entry((entry_point, variant)).or_insert_with(build).clone()
    }

    /// Buffers of an image with the bytes that it uses of each, as a pipeline takes them.
    fn group(&self, layouts: &Layouts, buffers: &[(&wgpu::Buffer, u64)]) -> wgpu::BindGroup {
        let entry = |&binding: &u32| {
            let (buffer, bytes) = buffers[binding as usize];
            let resource =
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size: NonZero::new(bytes) });
            wgpu::BindGroupEntry { binding, resource }
        };
        let entries: Vec<_> = layouts.used.iter().map(entry).collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("kernel"),
            layout: &layouts.bindings,
            entries: &entries,
        })
    }

    /// Whether this kernel has not yet written an image of this size here. A panic in a kernel is silent, and would recur
    /// for every image of the size: the first one shows it.
    fn is_new(&self, plan: &Plan, kernel: Kernel) -> bool {
        let key = (kernel, plan.variant, plan.width(), plan.height());
        self.verified.lock().expect("no holder of this lock panics").insert(key)
    }

    /// Rows that one dispatch computes, so that its output fits the device's largest buffer.
    fn rows_per_strip(&self, plan: &Plan, row_bytes: u64) -> Result<u32> {
        let most = u64::from(self.most_groups) * u64::from(WORKGROUP_SIDE);
        let widest = (self.largest_buffer / (row_bytes / u64::from(plan.width()))).min(most);
        if u64::from(plan.width()) > widest {
            let (width, height) = (plan.width(), plan.height());
            let complaint = format!("= {width}x{height} is wider than this device takes; at most {widest} pixels");
            return Err(Error::not_allowed("camera.size", complaint));
        }
        let rows = (self.largest_buffer / row_bytes).min(most).min(u64::from(rows_at_once(plan)));
        Ok(rows.min(plan.lit_rows.len() as u64).max(1) as u32)
    }

    /// The first error that the device reported.
    fn check(&self) -> Result<()> {
        match self.fault.lock().expect("no holder of this lock panics").take() {
            Some(fault) => Err(Error::Device(fault.replace('\n', " "))),
            None => Ok(()),
        }
    }

    /// Makes every later use of the device fail, as the loss of its driver does.
    pub fn lose(&self) {
        self.device.destroy();
    }

    /// Waits until a submission is done, and what it maps is mapped.
    fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<()> {
        let polled = self.device.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None });
        self.check()?;
        polled.map_err(|error| Error::Device(format!("it does not answer: {error}")))?;
        Ok(())
    }

    /// Brings a strip back and hands it out.
    fn collect(&self, strip: Strip, verify: bool, kernel: Kernel, take: &mut TakeRows<'_>) -> Result<Times> {
        let Strip { first_row, bytes, slot, submission, submitted } = strip;
        self.wait(submission)?;
        let waited = submitted.elapsed();
        let mut times = match &slot.clock {
            Some(clock) => clock.times(self)?,
            None => Times { kernel: waited, readback: Duration::ZERO },
        };
        let start = Instant::now();
        let mapped = mapped(&slot.staging, bytes)?;
        times.readback += start.elapsed();
        let words: &[u32] = bytemuck::cast_slice(&mapped);
        if verify && words.contains(&SENTINEL) {
            return Err(Error::Device(format!("kernel {} left pixels unwritten", kernel.entry_point())));
        }
        let taken = take(first_row, words);
        drop(mapped);
        slot.staging.unmap();
        taken.map(|()| times)
    }
}

/// The bytes of a buffer that is mapped.
fn mapped(buffer: &wgpu::Buffer, bytes: u64) -> Result<wgpu::BufferView> {
    buffer
        .slice(..bytes)
        .get_mapped_range()
        .map_err(|error| Error::Device(format!("its output cannot be read: {error}")))
}

impl Backend for Gpu {
    fn refusal(&self, plan: &Plan) -> Option<String> {
        let rounds = rounds(plan);
        (rounds >= self.most_rounds).then(|| {
            format!(
                "its driver ends loops after {} rounds, and a pixel may take {rounds} here: fewer samples, bands or wavelengths would do",
                self.most_rounds
            )
        })
    }

    fn lit_rows(&self, plan: &Plan, kernel: Kernel, rows: Range<u32>, take: &mut TakeRows<'_>) -> Result<Times> {
        if let Some(refusal) = self.refusal(plan) {
            return Err(Error::Device(refusal));
        }
        let row_bytes = 4 * words_per_row(plan, kernel) as u64;
        let rows_per_strip = self.rows_per_strip(plan, row_bytes)?;
        let verify = kernel != Kernel::Fill && self.is_new(plan, kernel);

        let mut kept = self.buffers.lock().expect("no holder of this lock panics");
        // An image that fails leaves no buffer that is still in use.
        let mut buffers = std::mem::take(&mut *kept);
        let groups = buffers.fill(self, plan, row_bytes * u64::from(rows_per_strip));
        let fill_lookup = (kernel == Kernel::SkyLookup)
            .then(|| self.pipeline(plan.lookup_kernel().entry_point(), plan.variant, &self.lookup_layouts));
        let pixels = self.pipeline(kernel.entry_point(), plan.variant, &self.pixel_layouts);
        let sentinel = verify.then(|| self.pipeline(Kernel::Fill.entry_point(), plan.variant, &self.pixel_layouts));
        self.check()?;

        let mut times = Times::default();
        let mut under_way = VecDeque::new();
        for (strip, first_row) in rows.clone().step_by(rows_per_strip as usize).enumerate() {
            if under_way.len() == STRIPS_UNDER_WAY {
                let oldest = under_way.pop_front().expect("two strips are under way");
                times += self.collect(oldest, verify, kernel, take)?;
            }
            let uniform = Uniform { first_row, rows: rows_per_strip.min(rows.end - first_row), ..plan.uniform };
            self.queue.write_buffer(buffers.uniform.get(), 0, bytemuck::bytes_of(&uniform));
            let invocations = invocations_per_row(plan, kernel);
            let size = (invocations.div_ceil(WORKGROUP_SIDE), uniform.rows.div_ceil(WORKGROUP_SIDE));
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            if let Some(sentinel) = &sentinel {
                dispatch(&mut encoder, sentinel, &groups.pixels, size, None);
            }
            let slot = buffers.slot(self, strip % STRIPS_UNDER_WAY, row_bytes * u64::from(rows_per_strip));
            let clock = slot.clock.as_ref();
            let lookup_first = fill_lookup.as_ref().filter(|_| strip == 0);
            if let Some(fill_lookup) = lookup_first {
                let size = (entries(&plan.uniform).div_ceil(LOOKUP_WORKGROUP), 1);
                dispatch(&mut encoder, fill_lookup, &groups.lookup, size, clock.map(|clock| clock.writes(true, false)));
            }
            let writes = clock.map(|clock| clock.writes(lookup_first.is_none(), true));
            dispatch(&mut encoder, &pixels, &groups.pixels, size, writes);
            let bytes = row_bytes * u64::from(uniform.rows);
            encoder.copy_buffer_to_buffer(buffers.pixels.get(), 0, &slot.staging, 0, bytes);
            if let Some(clock) = clock {
                clock.resolve(&mut encoder, self.times_copies);
            }
            let submitted = Instant::now();
            let submission = self.queue.submit([encoder.finish()]);
            slot.staging.slice(..bytes).map_async(wgpu::MapMode::Read, |_| {});
            if let Some(clock) = clock {
                clock.staging.slice(..).map_async(wgpu::MapMode::Read, |_| {});
            }
            under_way.push_back(Strip { first_row, bytes, slot, submission, submitted });
        }
        for strip in under_way {
            times += self.collect(strip, verify, kernel, take)?;
        }
        *kept = buffers;
        Ok(times)
    }
}

/// Rows that are on their way.
struct Strip {
    first_row: u32,
    bytes: u64,
    slot: Slot,
    submission: wgpu::SubmissionIndex,
    submitted: Instant,
}

/// Where a strip comes back to.
#[derive(Clone)]
struct Slot {
    staging: wgpu::Buffer,
    bytes: u64,
    clock: Option<Clock>,
}

/// A buffer that is kept from image to image, and made anew for one that needs more.
struct Kept {
    label: &'static str,
    usage: wgpu::BufferUsages,
    buffer: Option<wgpu::Buffer>,
}

impl Kept {
    fn new(label: &'static str, usage: wgpu::BufferUsages) -> Self {
        Self { label, usage, buffer: None }
    }

    fn reserve(&mut self, device: &wgpu::Device, bytes: u64) {
        if self.buffer.as_ref().is_none_or(|buffer| buffer.size() < bytes) {
            self.buffer = Some(device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(self.label),
                size: bytes,
                usage: self.usage,
                mapped_at_creation: false,
            }));
        }
    }

    /// Uploads the contents; returns how many bytes they are.
    fn upload(&mut self, gpu: &Gpu, contents: &[u8]) -> u64 {
        self.reserve(&gpu.device, contents.len() as u64);
        gpu.queue.write_buffer(self.get(), 0, contents);
        contents.len() as u64
    }

    fn get(&self) -> &wgpu::Buffer {
        self.buffer.as_ref().expect("an image reserves its buffers first")
    }
}

/// The buffers of an image, kept for the next.
struct DeviceBuffers {
    uniform: Kept,
    bands: Kept,
    quadrature: Kept,
    colour: Kept,
    lookup: Kept,
    pixels: Kept,
    slots: [Option<Slot>; STRIPS_UNDER_WAY],
}

impl Default for DeviceBuffers {
    fn default() -> Self {
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        Self {
            uniform: Kept::new("uniform", wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST),
            bands: Kept::new("bands", storage),
            quadrature: Kept::new("quadrature", storage),
            colour: Kept::new("colour", storage),
            lookup: Kept::new("sky lookup", wgpu::BufferUsages::STORAGE),
            pixels: Kept::new("pixels", wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC),
            slots: Default::default(),
        }
    }
}

impl DeviceBuffers {
    /// Uploads a plan, and binds its buffers and `pixel_bytes` of output.
    fn fill(&mut self, gpu: &Gpu, plan: &Plan, pixel_bytes: u64) -> Groups {
        let lookup_bytes = 2 * size_of::<Vec4>() as u64 * u64::from(entries(&plan.uniform)).max(1);
        self.lookup.reserve(&gpu.device, lookup_bytes);
        self.pixels.reserve(&gpu.device, pixel_bytes);
        let uniform_bytes = self.uniform.upload(gpu, bytemuck::bytes_of(&plan.uniform));
        let bands_bytes = self.bands.upload(gpu, bytemuck::cast_slice(&plan.bands));
        let quadrature_bytes = self.quadrature.upload(gpu, bytemuck::cast_slice(&plan.quadrature));
        let colour_bytes = self.colour.upload(gpu, bytemuck::cast_slice(&plan.colour));
        let bound = [
            (self.uniform.get(), uniform_bytes),
            (self.bands.get(), bands_bytes),
            (self.quadrature.get(), quadrature_bytes),
            (self.colour.get(), colour_bytes),
            (self.lookup.get(), lookup_bytes),
            (self.pixels.get(), pixel_bytes),
        ];
        Groups { lookup: gpu.group(&gpu.lookup_layouts, &bound), pixels: gpu.group(&gpu.pixel_layouts, &bound) }
    }

    /// A place of at least `bytes` for a strip to come back to.
    fn slot(&mut self, gpu: &Gpu, index: usize, bytes: u64) -> Slot {
        let slot = &mut self.slots[index];
        if slot.as_ref().is_none_or(|slot| slot.bytes < bytes) {
            let staging = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("read-back"),
                size: bytes,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            let clock = slot.take().and_then(|slot| slot.clock);
            let clock = clock.or_else(|| gpu.has_timestamps.then(|| Clock::new(&gpu.device)));
            *slot = Some(Slot { staging, bytes, clock });
        }
        slot.clone().expect("the slot was filled")
    }
}

/// The bindings of the kernels that fill the sky lookup, and of those that write pixels.
struct Groups {
    lookup: wgpu::BindGroup,
    pixels: wgpu::BindGroup,
}

/// A bind group layout and the pipeline layout on it.
struct Layouts {
    bindings: wgpu::BindGroupLayout,
    pipeline: wgpu::PipelineLayout,
    /// The bindings that it has.
    used: &'static [u32],
}

impl Layouts {
    /// A layout of some bindings; `written` is the one that the kernels write.
    fn new(device: &wgpu::Device, used: &'static [u32], written: u32) -> Self {
        let entry = |&binding: &u32| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: if binding == 0 {
                    wgpu::BufferBindingType::Uniform
                } else {
                    wgpu::BufferBindingType::Storage { read_only: binding != written }
                },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let entries: Vec<_> = used.iter().map(entry).collect();
        let bindings = device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("kernel"), entries: &entries });
        let pipeline = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("kernel"),
            bind_group_layouts: &[Some(&bindings)],
            immediate_size: 0,
        });
        Self { bindings, pipeline, used }
    }
}

/// The shader module with its specialisation constant set, handed to the driver as it is where wgpu allows that, through
/// naga elsewhere.
fn load(device: &wgpu::Device, passthrough: bool, variant: u32) -> wgpu::ShaderModule {
    let words = specialised(&wgpu::util::make_spirv_raw(SPIRV), variant);
    if passthrough {
        let names = Kernel::ALL.into_iter().map(Kernel::entry_point);
        let entry_points: Vec<_> = names
            .map(|name| wgpu::PassthroughShaderEntryPoint { name: name.into(), workgroup_size: (0, 0, 0) })
            .collect();
        // SAFETY: the module is the one that the tests validate, compiled from this repository's own kernels, whose
        // indices stay inside their buffers; wgpu's devices bound buffer accesses besides.
        #[expect(unsafe_code, reason = "wgpu cannot check what it does not translate")]
        unsafe {
            device.create_shader_module_passthrough(wgpu::ShaderModuleDescriptorPassthrough {
                label: Some("sorairo"),
                spirv: Some(words.into()),
                entry_points: Cow::Owned(entry_points),
                ..Default::default()
            })
        }
    } else {
        let descriptor =
            wgpu::ShaderModuleDescriptor { label: Some("sorairo"), source: wgpu::ShaderSource::SpirV(words.into()) };
        // SAFETY: the kernels' indices stay inside their buffers, and their loops are bounded.
        #[expect(unsafe_code, reason = "wgpu would add checks that the kernels do not need")]
        unsafe {
            device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked())
        }
    }
}

/// The module with its one specialisation constant turned into the constant `value`.
///
/// Done on the words themselves because that works alike for both ways into a driver: `OpSpecConstant` becomes
/// `OpConstant`, which has the same layout (SPIR-V 1.3, 3.32.7), and its `SpecId` decoration is left out.
pub fn specialised(words: &[u32], value: u32) -> Vec<u32> {
    const HEADER: usize = 5;
    const OP_CONSTANT: u32 = 43;
    const OP_SPEC_CONSTANT: u32 = 50;
    const OP_DECORATE: u32 = 71;
    const SPEC_ID: u32 = 1;
    let mut specialised = words[..HEADER].to_vec();
    let mut at = HEADER;
    while at < words.len() {
        let (length, opcode) = ((words[at] >> 16) as usize, words[at] & 0xffff);
        let instruction = &words[at..at + length.max(1)];
        match opcode {
            OP_SPEC_CONSTANT => {
                let head = (words[at] & 0xffff_0000) | OP_CONSTANT;
                specialised.extend([head, instruction[1], instruction[2], value]);
            }
            OP_DECORATE if instruction[2] == SPEC_ID => {}
            _ => specialised.extend_from_slice(instruction),
        }
        at += instruction.len();
    }
    specialised
}

fn dispatch(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::ComputePipeline,
    group: &wgpu::BindGroup,
    (columns, rows): (u32, u32),
    timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
) {
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, group, &[]);
    pass.dispatch_workgroups(columns, rows, 1);
}

/// The device's own clock around the passes of a strip.
#[derive(Clone)]
struct Clock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
}

impl Clock {
    /// Before the first pass, after the last, after the copy.
    const QUERIES: u32 = 3;
    const BYTES: u64 = 8 * Self::QUERIES as u64;

    fn new(device: &wgpu::Device) -> Self {
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("clock"),
                size: Self::BYTES,
                usage,
                mapped_at_creation: false,
            })
        };
        Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count: Self::QUERIES,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            staging: buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
        }
    }

    /// What a pass writes: the time at the strip's beginning, at its end.
    fn writes(&self, beginning: bool, end: bool) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: beginning.then_some(0),
            end_of_pass_write_index: end.then_some(1),
        }
    }

    fn resolve(&self, encoder: &mut wgpu::CommandEncoder, times_copies: bool) {
        let mut queries = Self::QUERIES - 1;
        if times_copies {
            encoder.write_timestamp(&self.queries, queries);
            queries += 1;
        }
        encoder.resolve_query_set(&self.queries, 0..queries, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, Self::BYTES);
    }

    /// The times of a strip that is done.
    fn times(&self, gpu: &Gpu) -> Result<Times> {
        let mapped = mapped(&self.staging, Self::BYTES)?;
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&mapped[..]);
        drop(mapped);
        self.staging.unmap();
        let period = f64::from(gpu.queue.get_timestamp_period());
        let elapsed = |from: u64, to: u64| Duration::from_nanos((to.saturating_sub(from) as f64 * period) as u64);
        let readback = if gpu.times_copies { elapsed(ticks[1], ticks[2]) } else { Duration::ZERO };
        Ok(Times { kernel: elapsed(ticks[0], ticks[1]), readback })
    }
}
