//! A device of the library, which computes images in strips and waits for them.

use std::collections::{HashSet, VecDeque};
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

use sorairo_shared::kernels::{SENTINEL, WORKGROUP_SIDE};
use sorairo_shared::uniform::Uniform;

use super::adapters::adapter;
use super::buffers::{DeviceBuffers, STRIPS_UNDER_WAY};
use super::kernels::{Kernels, dispatch};
use super::layouts::groups_of_lookup;
use super::planner;
use super::readback::{Slot, mapped};
use super::resident::ResidentRenderer;
use crate::device::backend::{Backend, TakeRows, Times};
use crate::device::chosen::{Device, DeviceKind};
use crate::device::quirks;
use crate::device::rows::{invocations_per_row, rows_at_once, words_per_row};
use crate::error::{Error, Result};
use crate::plan::{Kernel, LightFields, Plan};

/// A graphics device with the kernels loaded.
pub struct Gpu {
    name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    kernels: Kernels,
    /// Resources reused by the next image.
    buffers: Mutex<DeviceBuffers>,
    light_fields: OnceLock<LightFields>,
    own_light_fields: OnceLock<LightFields>,
    /// Kernels and sizes whose output was checked to be complete.
    verified: Mutex<HashSet<(Kernel, u32, u32, u32)>>,
    fault: Arc<Mutex<Option<String>>>,
    /// The largest buffer that a kernel can write (bytes).
    largest_buffer: u64,
    /// The most workgroups along a side of a dispatch.
    most_groups: u32,
    /// The maximum number of iterations of all loops of an invocation.
    most_rounds: u64,
    has_timestamps: bool,
    /// Whether it is hardware, not software on CPU cores.
    is_hardware: bool,
    /// Whether the copy of pixels is timed too.
    times_copies: bool,
}

/// Opens the best graphics device whose name contains `wanted`, ignoring case; `None` if there is none.
///
/// # Errors
///
/// [`Error::Device`] if the device is there and cannot be opened.
pub fn open(wanted: &str) -> Result<Option<Device>> {
    Ok(Gpu::open(wanted)?.map(Gpu::into_device))
}

impl Gpu {
    /// [`open`], before it is a [`Device`].
    ///
    /// # Errors
    ///
    /// [`Error::Device`] if the device is there and cannot be opened.
    pub fn open(wanted: &str) -> Result<Option<Self>> {
        let Some(adapter) = adapter(wanted) else { return Ok(None) };
        let name = adapter.get_info().name;
        let gpu =
            Self::new(&adapter).map_err(|error| Error::Device(format!("device {name:?} cannot be opened: {error}")))?;
        Ok(Some(gpu))
    }

    /// This device as if it took no buffer larger than so many bytes: how strips are tested.
    #[doc(hidden)]
    pub fn with_largest_buffer(self, bytes: u64) -> Self {
        Self { largest_buffer: self.largest_buffer.min(bytes), ..self }
    }

    /// Makes every later use of the device fail, as the loss of its driver does: how spares are tested.
    #[doc(hidden)]
    pub fn lose(&self) {
        self.device.destroy();
    }

    /// This device, without spares.
    pub fn into_device(self) -> Device {
        Device { name: self.name.clone(), kind: DeviceKind::Gpu, backend: Box::new(self), spares: VecDeque::new() }
    }

    fn new(adapter: &wgpu::Adapter) -> std::result::Result<Self, wgpu::RequestDeviceError> {
        let clocks = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let mut descriptor = ResidentRenderer::device_descriptor(adapter);
        descriptor.required_features |= adapter.features() & clocks;
        let (features, limits) = (descriptor.required_features, descriptor.required_limits.clone());
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
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
            kernels: Kernels::new(&device),
            device,
            queue,
            buffers: Mutex::default(),
            light_fields: OnceLock::new(),
            own_light_fields: OnceLock::new(),
            verified: Mutex::default(),
            fault,
            largest_buffer: limits.max_buffer_size.min(limits.max_storage_buffer_binding_size),
            most_groups: limits.max_compute_workgroups_per_dimension,
            most_rounds: quirks::most_rounds(&adapter.get_info().driver),
            has_timestamps: features.contains(wgpu::Features::TIMESTAMP_QUERY),
            is_hardware: adapter.get_info().device_type != wgpu::DeviceType::Cpu,
            times_copies: features.contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS),
        })
    }

    /// Whether this kernel has not yet written an image of this size here. A panic in a kernel is silent, and would
    /// recur for every image of the size: the first one shows it.
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

    /// Waits until a submission is done, and what it maps is mapped.
    fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<()> {
        let polled = self.device.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None });
        self.check()?;
        polled.map_err(|error| Error::Device(format!("it does not answer: {error}")))?;
        Ok(())
    }

    /// Reads a strip back and delivers it.
    fn collect(&self, strip: Strip, verify: bool, kernel: Kernel, take: &mut TakeRows<'_>) -> Result<Times> {
        let Strip { first_row, bytes, slot, submission, submitted } = strip;
        self.wait(submission)?;
        let waited = submitted.elapsed();
        let mut times = match &slot.clock {
            Some(clock) => clock.times(&self.queue, self.times_copies)?,
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

impl Backend for Gpu {
    fn light_fields(&self) -> LightFields {
        let on_processor = || self.light_fields.get_or_init(LightFields::default).clone();
        self.own_light_fields().filter(|_| self.is_hardware).unwrap_or_else(on_processor)
    }

    fn own_light_fields(&self) -> Option<LightFields> {
        let new = || planner::light_fields(&self.device, &self.queue);
        Some(self.own_light_fields.get_or_init(new).clone())
    }

    fn refusal(&self, plan: &Plan) -> Option<String> {
        let rounds = quirks::rounds(plan);
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
        let row_bytes = 4 * words_per_row(plan) as u64;
        let rows_per_strip = self.rows_per_strip(plan, row_bytes)?;
        let verify = kernel != Kernel::Fill && self.is_new(plan, kernel);

        let mut kept = self.buffers.lock().expect("no holder of this lock panics");
        // An image that fails leaves no buffer that is still in use.
        let mut buffers = std::mem::take(&mut *kept);
        let groups = buffers.fill(
            (&self.device, &self.queue),
            self.kernels.layouts(&self.device),
            plan,
            row_bytes * u64::from(rows_per_strip),
        );
        let pipeline = |kernel| self.kernels.pipeline(&self.device, kernel, plan.variant);
        let fill_lookup = (kernel == Kernel::SkyLookup).then(|| [Kernel::Anchors, Kernel::Lookup].map(pipeline));
        let pixels = pipeline(kernel);
        let sentinel = verify.then(|| pipeline(Kernel::Fill));
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
            let strip_bytes = row_bytes * u64::from(rows_per_strip);
            let slot = buffers.slot(&self.device, strip % STRIPS_UNDER_WAY, strip_bytes, self.has_timestamps);
            let clock = slot.clock.as_ref();
            let lookup_first = fill_lookup.as_ref().filter(|_| strip == 0);
            if let Some([fill_anchors, fill_entries]) = lookup_first {
                let [of_anchors, of_entries] = groups_of_lookup(&plan.uniform);
                let begins = clock.map(|clock| clock.writes(true, false));
                dispatch(&mut encoder, fill_anchors, &groups.lookup, of_anchors, begins);
                dispatch(&mut encoder, fill_entries, &groups.lookup, of_entries, None);
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
