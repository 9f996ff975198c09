//! What a plan integrates, in a device: light fields and what is seen of them.

use std::any::Any;
use std::num::NonZero;
use std::sync::{Arc, Mutex, PoisonError};

use bytemuck::{bytes_of, cast_slice};
use sorairo_shared::glam::Vec4;
use sorairo_shared::kernels::{LOOKUP_WORKGROUP, PARTS};
use sorairo_shared::light_field::FieldUniform;
use sorairo_shared::sky::Parts;
use wgpu::util::DeviceExt;

use super::kernels::Kernels;
use super::layouts::Layouts;
use super::module::LOOK;
use super::readback::mapped;
use crate::plan::multiple::LightFields;
use crate::plan::on_device::{Keeping, Look, Memory, PlanDevice, Reading, Step, Work};

/// Bytes of a value.
const VALUE: u64 = size_of::<Vec4>() as u64;

/// The most buffers that wait to be used again.
const MOST_FREE: usize = 16;

/// Light fields that are computed and kept in a program's device, with what else the plans that take them integrate: [`crate::SkyPlan::with_light_fields`].
///
/// A plan then waits for the device a few times; it does so on the thread that plans, never where commands are encoded. What the device cannot do, such as
/// one that is lost, the processor does.
pub fn light_fields(device: &wgpu::Device, queue: &wgpu::Queue) -> LightFields {
    LightFields::on_device(Arc::new(Planner {
        kernels: Kernels::new(device),
        fields: Layouts::new(device, &[0, 1, 2, 3, 4, 5, 6], &[4, 5, 6]),
        looks: Layouts::new(device, &[0, 1, 2, 3, 4, 5, 6], &[6]),
        free: Arc::default(),
        device: device.clone(),
        queue: queue.clone(),
    }))
}

/// Buffers that wait to be used again.
type Free = Arc<Mutex<Vec<wgpu::Buffer>>>;

struct Planner {
    device: wgpu::Device,
    queue: wgpu::Queue,
    kernels: Kernels,
    fields: Layouts,
    looks: Layouts,
    free: Free,
}

/// A buffer that goes back to those that are free.
struct Pooled {
    buffer: wgpu::Buffer,
    free: Free,
}

impl Drop for Pooled {
    fn drop(&mut self) {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        free.push(self.buffer.clone());
        if free.len() > MOST_FREE {
            free.remove(0);
        }
    }
}

fn buffer_of(memory: &Memory) -> Option<&wgpu::Buffer> {
    let memory: &dyn Any = &**memory;
    memory.downcast_ref::<Pooled>().map(|pooled| &pooled.buffer)
}

fn whole(buffer: &wgpu::Buffer) -> wgpu::BufferBinding<'_> {
    wgpu::BufferBinding { buffer, offset: 0, size: None }
}

impl PlanDevice for Planner {
    fn reserve(&self, numbers: usize) -> Option<Memory> {
        let bytes = 4 * (numbers as u64).max(4);
        let limits = self.device.limits();
        if bytes > limits.max_buffer_size.min(limits.max_storage_buffer_binding_size) {
            return None;
        }
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let fits = |buffer: &wgpu::Buffer| (bytes..=4 * bytes).contains(&buffer.size());
        let kept = free.iter().position(fits).map(|at| free.remove(at));
        let buffer = kept.unwrap_or_else(|| {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
            let label = Some("plan");
            self.device.create_buffer(&wgpu::BufferDescriptor { label, size: bytes, usage, mapped_at_creation: false })
        });
        Some(Arc::new(Pooled { buffer, free: Arc::clone(&self.free) }))
    }

    fn run(
        &self,
        work: &Work<'_>,
        steps: &[Step],
        keep: Option<Keeping<'_>>,
        read: Option<Reading>,
    ) -> Option<Vec<Vec4>> {
        let limits = self.device.limits();
        let groups = |step: &Step| step.uniform.invocations.div_ceil(LOOKUP_WORKGROUP);
        if steps.iter().any(|step| groups(step) > limits.max_compute_workgroups_per_dimension) {
            return None;
        }
        let [functions, values, orders] = work.memory.map(buffer_of);
        let (functions, values, orders) = (functions?, values?, orders?);
        let storage = wgpu::BufferUsages::STORAGE;
        let bands = self.filled(cast_slice(work.bands), storage);
        let quadratures = work.quadratures.map(|rule| self.filled(cast_slice(rule), storage));
        let tables = self.filled(cast_slice(work.tables), storage);
        let stride = size_of::<FieldUniform>().next_multiple_of(limits.min_uniform_buffer_offset_alignment as usize);
        let mut bytes = vec![0; stride * steps.len()];
        for (bytes, step) in bytes.chunks_exact_mut(stride).zip(steps) {
            bytes[..size_of::<FieldUniform>()].copy_from_slice(bytes_of(&step.uniform));
        }
        let uniforms = self.filled(&bytes, wgpu::BufferUsages::UNIFORM);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        for (number, step) in steps.iter().enumerate() {
            let uniform = wgpu::BufferBinding {
                buffer: &uniforms,
                offset: (number * stride) as u64,
                size: NonZero::new(size_of::<FieldUniform>() as u64),
            };
            let quadrature = &quadratures[step.kernel.quadrature()];
            let parts = [&bands, quadrature, &tables, functions, values, orders].map(whole);
            let parts = [&[uniform][..], &parts].concat();
            let entry_point = step.kernel.entry_point();
            let variant = if step.kernel.is_specialised() { work.variant } else { 0 };
            let pipeline = self.kernels.pipeline_of(&self.device, entry_point, &self.fields, variant);
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &self.fields.bind_parts(&self.device, &parts), &[]);
            pass.dispatch_workgroups(groups(step), 1, 1);
        }
        drop(pass);
        if let Some(Keeping { values, to }) = keep {
            let bytes = VALUE * values.len() as u64;
            encoder.copy_buffer_to_buffer(orders, VALUE * values.start as u64, buffer_of(to)?, 0, bytes);
        }
        let (from, range) = match read {
            Some(Reading::Values(range)) => (values, range),
            Some(Reading::Orders(range)) => (orders, range),
            None => {
                self.queue.submit([encoder.finish()]);
                return Some(Vec::new());
            }
        };
        let bytes = VALUE * range.len() as u64;
        self.read(encoder, &[(from, VALUE * range.start as u64, bytes)])?.pop()
    }

    fn look(&self, at: &[Look<'_>]) -> Option<Vec<Vec<Parts<Vec4>>>> {
        let storage = wgpu::BufferUsages::STORAGE;
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        let mut found = Vec::new();
        for Look { uniform, buffers, variant, views } in at {
            let views: Vec<Vec4> = views.iter().map(|view| view.extend(0.0)).collect();
            let uniform = self.filled(bytes_of(*uniform), wgpu::BufferUsages::UNIFORM);
            let lists = [
                cast_slice(buffers.bands),
                cast_slice(buffers.quadrature),
                cast_slice(buffers.colour),
                cast_slice(buffers.multiple),
                cast_slice(&views),
            ];
            let lists = lists.map(|list| self.filled(list, storage));
            let invocations = views.len() * buffers.bands.len();
            let bytes = VALUE * (PARTS * invocations) as u64;
            let memory = self.reserve(bytes as usize / 4)?;
            let parts: Vec<_> = [&uniform].into_iter().chain(&lists).chain([buffer_of(&memory)?]).map(whole).collect();
            pass.set_pipeline(&self.kernels.pipeline_of(&self.device, LOOK, &self.looks, *variant));
            pass.set_bind_group(0, &self.looks.bind_parts(&self.device, &parts), &[]);
            pass.dispatch_workgroups((invocations as u32).div_ceil(LOOKUP_WORKGROUP), 1, 1);
            found.push((memory, bytes));
        }
        drop(pass);
        let parts = found.iter().map(|(memory, bytes)| Some((buffer_of(memory)?, 0, *bytes)));
        let found = self.read(encoder, &parts.collect::<Option<Vec<_>>>()?)?;
        let parts = |of: &[Vec4]| Parts { air: of[0], aerosol: of[1], multiple: of[2], ground: of[3] };
        Some(found.iter().map(|values| values.chunks_exact(PARTS).map(parts).collect()).collect())
    }
}

impl Planner {
    fn filled(&self, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        // A binding may not be empty.
        let contents = if contents.is_empty() { &[0; 16] } else { contents };
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some("plan"), contents, usage })
    }

    /// Submits commands, and waits for parts of buffers: each where it begins, and its bytes.
    fn read(&self, mut encoder: wgpu::CommandEncoder, parts: &[(&wgpu::Buffer, u64, u64)]) -> Option<Vec<Vec<Vec4>>> {
        let all = parts.iter().map(|(.., bytes)| bytes).sum();
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("plan, read back"),
            size: all,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut to = 0;
        for (buffer, from, bytes) in parts {
            encoder.copy_buffer_to_buffer(buffer, *from, &staging, to, *bytes);
            to += bytes;
        }
        let submission = self.queue.submit([encoder.finish()]);
        staging.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        self.device.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None }).ok()?;
        let mapped = mapped(&staging, all).ok()?;
        let mut rest = &mapped[..];
        let part = |(.., bytes): &(&wgpu::Buffer, u64, u64)| {
            let (part, others) = rest.split_at(*bytes as usize);
            rest = others;
            bytemuck::pod_collect_to_vec(part)
        };
        Some(parts.iter().map(part).collect())
    }
}
