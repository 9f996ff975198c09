//! The kernels on a Vulkan device, from the SPIR-V that travels with the program.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use sorairo_shared::frame::{Frame, TABLE_WORKGROUP, WORKGROUP_SIDE};
use sorairo_shared::glam::Vec4;
use sorairo_shared::sky_table::entries;
use wgpu::util::DeviceExt;

use super::cpu::{black_image, words_per_pixel};
use super::{Backend, Device, Kernel, Run};
use crate::error::{Error, Result};
use crate::plan::Plan;

/// The kernels, compiled by rust-gpu; `cargo xtask shaders` rebuilds them.
pub const SPIRV: &[u8] = include_bytes!("../../../shader-crate/compiled/sorairo.spv");

/// A bit pattern that no kernel stores (a NaN), so that a pixel which a kernel failed to write can be told.
pub const SENTINEL: u32 = sorairo_shared::frame::SENTINEL;

/// Pixels in one dispatch: enough to fill any device, short enough for a driver's watchdog.
const PIXELS_PER_DISPATCH: u64 = 1 << 22;

/// A Vulkan device with the kernels loaded.
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    passthrough: bool,
    /// One for each value of the specialisation constant.
    modules: Mutex<HashMap<u32, wgpu::ShaderModule>>,
    pipelines: Mutex<HashMap<(&'static str, u32), wgpu::ComputePipeline>>,
    table_layouts: Layouts,
    pixel_layouts: Layouts,
    /// Those of the last frame, for the next of its size.
    targets: Mutex<Option<Targets>>,
    /// Kernels and sizes whose output was seen to be whole.
    verified: Mutex<HashSet<(Kernel, u32, u32, u32)>>,
    fault: Arc<Mutex<Option<String>>>,
    limits: wgpu::Limits,
    has_timestamps: bool,
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
    // Validation layers cost more than a frame where they are installed.
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
    Error::request(format!("--device {choice:?} is not a device of this machine; allowed: {}", names.join(", ")))
}

/// Opens the best Vulkan device whose name contains `wanted`, ignoring case; `None` if there is none.
///
/// # Errors
///
/// [`Error::Failure`] if the device is there and cannot be opened.
pub fn open(wanted: &str) -> Result<Option<Device>> {
    let wanted = wanted.to_lowercase();
    let instance = instance();
    let adapter =
        adapters(&instance).into_iter().find(|adapter| adapter.get_info().name.to_lowercase().contains(&wanted));
    let Some(adapter) = adapter else { return Ok(None) };
    let name = adapter.get_info().name;
    let gpu =
        Gpu::new(&adapter).map_err(|error| Error::failure(format!("device {name:?} cannot be opened: {error}")))?;
    Ok(Some(Device { name, kind: "gpu", backend: Box::new(gpu) }))
}

impl Gpu {
    fn new(adapter: &wgpu::Adapter) -> std::result::Result<Self, wgpu::RequestDeviceError> {
        let wanted = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::PASSTHROUGH_SHADERS;
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
        let record = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            record.lock().expect("no holder of this lock panics").get_or_insert_with(|| error.to_string());
        }));
        Ok(Self {
            table_layouts: Layouts::new(&device, &[0, 1, 2, 3, 4], 4),
            pixel_layouts: Layouts::new(&device, &[0, 1, 2, 3, 4, 5], 5),
            device,
            queue,
            passthrough: features.contains(wgpu::Features::PASSTHROUGH_SHADERS),
            modules: Mutex::default(),
            pipelines: Mutex::default(),
            targets: Mutex::default(),
            verified: Mutex::default(),
            fault,
            limits,
            has_timestamps: features.contains(wgpu::Features::TIMESTAMP_QUERY),
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

    fn group(&self, layouts: &Layouts, buffers: &[&wgpu::Buffer]) -> wgpu::BindGroup {
        let entry =
            |&binding: &u32| wgpu::BindGroupEntry { binding, resource: buffers[binding as usize].as_entire_binding() };
        let entries: Vec<_> = layouts.used.iter().map(entry).collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("kernel"),
            layout: &layouts.bindings,
            entries: &entries,
        })
    }

    /// Buffers for a tile of this size: those of the last frame if they fit.
    fn targets(&self, bytes: u64) -> Targets {
        let last = self.targets.lock().expect("no holder of this lock panics").take();
        last.filter(|targets| targets.bytes == bytes).unwrap_or_else(|| Targets {
            output: self.buffer("pixels", bytes, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC),
            staging: self.buffer("read-back", bytes, wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
            clock: self.has_timestamps.then(|| Clock::new(self)),
            bytes,
        })
    }

    /// Whether this kernel has not yet written an image of this size here. A panic in a kernel is silent, and would recur
    /// for every image of the size: the first one shows it.
    fn is_new(&self, plan: &Plan, kernel: Kernel) -> bool {
        let key = (kernel, plan.variant, plan.width(), plan.height());
        self.verified.lock().expect("no holder of this lock panics").insert(key)
    }

    /// Rows that one dispatch computes, so that its output fits the device's largest buffer.
    fn rows_per_tile(&self, plan: &Plan, row_bytes: u64) -> Result<u32> {
        let largest = self.limits.max_buffer_size.min(self.limits.max_storage_buffer_binding_size);
        let most_groups = u64::from(self.limits.max_compute_workgroups_per_dimension);
        let side = u64::from(WORKGROUP_SIDE);
        let rows =
            (largest / row_bytes).min(PIXELS_PER_DISPATCH / u64::from(plan.width())).max(1).min(most_groups * side);
        if row_bytes > largest || u64::from(plan.width()).div_ceil(side) > most_groups {
            let widest = (largest / (row_bytes / u64::from(plan.width()))).min(most_groups * side);
            return Err(Error::request(format!(
                "--size {}x{} is wider than this device takes; at most {widest} pixels",
                plan.width(),
                plan.height()
            )));
        }
        Ok(rows.min(u64::from(plan.lit_rows.end - plan.lit_rows.start)).max(1) as u32)
    }

    /// The first error that the device reported, as a failure.
    fn check(&self) -> Result<()> {
        match self.fault.lock().expect("no holder of this lock panics").take() {
            Some(fault) => Err(Error::failure(format!("the device failed: {}", fault.replace('\n', " ")))),
            None => Ok(()),
        }
    }

    fn storage(&self, label: &str, contents: &[u8]) -> wgpu::Buffer {
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(label),
            contents,
            usage: wgpu::BufferUsages::STORAGE,
        })
    }

    fn uniform(&self, label: &str, contents: &[u8]) -> wgpu::Buffer {
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(label),
            contents,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        })
    }

    fn buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// Waits for the device and copies the first `size` bytes of a mappable buffer out.
    fn read(&self, buffer: &wgpu::Buffer, size: u64, into: &mut [u32]) -> Result<()> {
        let slice = buffer.slice(..size);
        slice.map_async(wgpu::MapMode::Read, |_| {});
        self.wait()?;
        let mapped = slice
            .get_mapped_range()
            .map_err(|error| Error::failure(format!("the device's output cannot be read: {error}")))?;
        bytemuck::cast_slice_mut::<u32, u8>(into).copy_from_slice(&mapped);
        drop(mapped);
        buffer.unmap();
        Ok(())
    }

    fn wait(&self) -> Result<()> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|error| Error::failure(format!("the device was lost: {error}")))?;
        self.check()
    }
}

impl Backend for Gpu {
    fn run(&self, plan: &Plan, kernel: Kernel) -> Result<Run> {
        let words_per_row = plan.width() as usize * words_per_pixel(plan, kernel);
        let row_bytes = words_per_row as u64 * 4;
        let rows_per_tile = self.rows_per_tile(plan, row_bytes)?;
        let mut words = black_image(plan, kernel)?;
        if plan.lit_rows.is_empty() {
            return Ok(Run { words, kernel: Duration::ZERO, readback: Duration::ZERO });
        }
        let lit = plan.lit_rows.start as usize * words_per_row..plan.lit_rows.end as usize * words_per_row;
        let verify = kernel != Kernel::Fill && self.is_new(plan, kernel);

        let table_bytes = 2 * size_of::<Vec4>() as u64 * u64::from(entries(&plan.frame)).max(1);
        let table = self.buffer("sky table", table_bytes, wgpu::BufferUsages::STORAGE);
        let frame = self.uniform("frame", bytemuck::bytes_of(&plan.frame));
        let targets = self.targets(row_bytes * u64::from(rows_per_tile));
        let shared = [
            self.storage("bands", bytemuck::cast_slice(&plan.bands)),
            self.storage("quadrature", bytemuck::cast_slice(&plan.quadrature)),
            self.storage("colour", bytemuck::cast_slice(&plan.colour)),
        ];
        let buffers = [&frame, &shared[0], &shared[1], &shared[2], &table, &targets.output];
        let groups = Groups {
            table: self.group(&self.table_layouts, &buffers),
            pixels: self.group(&self.pixel_layouts, &buffers),
        };
        let fill_table = (kernel == Kernel::SkyTable)
            .then(|| self.pipeline(plan.table_kernel().entry_point(), plan.variant, &self.table_layouts));
        let pixels = self.pipeline(kernel.entry_point(), plan.variant, &self.pixel_layouts);
        let sentinel = verify.then(|| self.pipeline(Kernel::Fill.entry_point(), plan.variant, &self.pixel_layouts));
        self.check()?;

        let mut run = Run { words: Vec::new(), kernel: Duration::ZERO, readback: Duration::ZERO };
        for (tile, words) in words[lit].chunks_mut(words_per_row * rows_per_tile as usize).enumerate() {
            let tile_frame = Frame {
                first_row: plan.lit_rows.start + tile as u32 * rows_per_tile,
                rows: (words.len() / words_per_row) as u32,
                ..plan.frame
            };
            self.queue.write_buffer(&frame, 0, bytemuck::bytes_of(&tile_frame));
            let size = (plan.width().div_ceil(WORKGROUP_SIDE), tile_frame.rows.div_ceil(WORKGROUP_SIDE));
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            if let Some(sentinel) = &sentinel {
                dispatch(&mut encoder, sentinel, &groups.pixels, size, None);
            }
            let clock = targets.clock.as_ref();
            let table_first = fill_table.as_ref().filter(|_| tile == 0);
            if let Some(fill_table) = table_first {
                let size = (entries(&plan.frame).div_ceil(TABLE_WORKGROUP), 1);
                dispatch(&mut encoder, fill_table, &groups.table, size, clock.map(|clock| clock.writes(true, false)));
            }
            let writes = clock.map(|clock| clock.writes(table_first.is_none(), true));
            dispatch(&mut encoder, &pixels, &groups.pixels, size, writes);
            if let Some(clock) = clock {
                clock.resolve(&mut encoder);
            }
            let start = Instant::now();
            self.queue.submit([encoder.finish()]);
            self.wait()?;
            let computed = Instant::now();
            let bytes = words.len() as u64 * 4;
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(&targets.output, 0, &targets.staging, 0, bytes);
            self.queue.submit([encoder.finish()]);
            self.read(&targets.staging, bytes, words)?;
            run.readback += computed.elapsed();
            run.kernel += match clock {
                Some(clock) => clock.elapsed(self)?,
                None => computed - start,
            };
            if verify && words.contains(&SENTINEL) {
                return Err(Error::failure(format!("kernel {} left pixels unwritten", kernel.entry_point())));
            }
        }
        *self.targets.lock().expect("no holder of this lock panics") = Some(targets);
        run.words = words;
        Ok(run)
    }
}

/// The bindings of the kernels that fill the table, and of those that write pixels.
struct Groups {
    table: wgpu::BindGroup,
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

/// Buffers that frames of one size share.
struct Targets {
    output: wgpu::Buffer,
    staging: wgpu::Buffer,
    clock: Option<Clock>,
    bytes: u64,
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

/// The device's own clock around the passes of a frame.
struct Clock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
}

impl Clock {
    fn new(gpu: &Gpu) -> Self {
        Self {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: gpu.buffer("clock", 16, wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            staging: gpu.buffer("clock", 16, wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
        }
    }

    /// What a pass writes: the time at the frame's beginning, at its end.
    fn writes(&self, beginning: bool, end: bool) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: beginning.then_some(0),
            end_of_pass_write_index: end.then_some(1),
        }
    }

    fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, 16);
    }

    fn elapsed(&self, gpu: &Gpu) -> Result<Duration> {
        let mut words = [0u32; 4];
        gpu.read(&self.staging, 16, &mut words)?;
        let [start, end] =
            [[words[0], words[1]], [words[2], words[3]]].map(|[low, high]| u64::from(low) | (u64::from(high) << 32));
        let nanoseconds = end.saturating_sub(start) as f64 * f64::from(gpu.queue.get_timestamp_period());
        Ok(Duration::from_nanos(nanoseconds as u64))
    }
}
