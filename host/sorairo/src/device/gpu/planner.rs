//! Integrals of plans on a device: light fields and their views.

use std::any::Any;
use std::future::Future;
use std::num::NonZero;
use std::ops::Range;
use std::pin::pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

use bytemuck::{bytes_of, cast_slice};
use sorairo_shared::glam::Vec4;
use sorairo_shared::kernels::{LOOKUP_WORKGROUP, PARTS};
use sorairo_shared::sky::ByConstituent;
use sorairo_shared::uniform::Buffers;

use super::kernels::Kernels;
use super::layouts::{Layouts, STORAGE_BUFFERS};
use super::module::{LOOK, Module};
use super::readback::mapped;
use crate::error::{Error, Result};
use crate::plan::light_field::LightFields;
use crate::plan::on_device::{Dispatch, Memory, PlanDevice, PlanPass, ReadBack, Retained, Views};

/// Bytes of a value.
const VALUE: u64 = size_of::<Vec4>() as u64;

/// Bytes of the buffers that wait to be used again, at most.
const MOST_FREE: u64 = 256 << 20;

/// Light fields that a program's device computes and stores, with the other integrals of their plans:
/// [`crate::Sky::with_light_fields`].
///
/// A plan then waits for the device a few times, on the planning thread, never where commands are encoded. If the
/// device fails or is lost, the CPU computes instead, with one warning in the log: see [`LightFields::on_device`].
pub fn light_fields(device: &wgpu::Device, queue: &wgpu::Queue) -> LightFields {
    light_fields_by(Arc::new(Kernels::new(device)), device, queue)
}

/// The same with kernels shared with others.
pub(super) fn light_fields_by(kernels: Arc<Kernels>, device: &wgpu::Device, queue: &wgpu::Queue) -> LightFields {
    let buffers = device.limits().max_storage_buffers_per_shader_stage;
    if buffers < STORAGE_BUFFERS {
        let name = device.adapter_info().name;
        log::warn!(
            "device {name:?} binds {buffers} storage buffers, and plans take {STORAGE_BUFFERS}; planning on the CPU"
        );
        return LightFields::default();
    }
    LightFields::on_device(Arc::new(Planner {
        kernels,
        fields: Layouts::new(device, &[0, 1, 2, 3, 4, 5, 6, 7], &[4, 5, 6]),
        looks: Layouts::new(device, &[0, 1, 2, 3, 4, 5, 6, 7], &[6]),
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
    kernels: Arc<Kernels>,
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
        while free.iter().map(wgpu::Buffer::size).sum::<u64>() > MOST_FREE {
            free.remove(0);
        }
    }
}

fn buffer_of(memory: &Memory) -> &wgpu::Buffer {
    let memory: &dyn Any = &**memory;
    &memory.downcast_ref::<Pooled>().expect("memory that a planner gave").buffer
}

fn whole(buffer: &wgpu::Buffer) -> wgpu::BufferBinding<'_> {
    wgpu::BufferBinding { buffer, offset: 0, size: None }
}

impl PlanDevice for Planner {
    fn name(&self) -> String {
        self.device.adapter_info().name
    }

    fn reserve(&self, numbers: usize) -> Result<Memory> {
        let bytes = 4 * (numbers as u64).max(4);
        let limits = self.device.limits();
        if bytes > limits.max_buffer_size.min(limits.max_storage_buffer_binding_size) {
            return Err(Error::Device(format!("its limits do not allow a buffer of {bytes} bytes")));
        }
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        self.guarded(|| Ok(self.pooled(bytes, usage)))
    }

    fn run(&self, work: &PlanPass<'_>) -> Result<Vec<Vec4>> {
        self.guarded(|| self.run_steps(work))
    }

    fn light_of_views(&self, at: &[Views<'_>]) -> Result<Vec<Vec<ByConstituent<Vec4>>>> {
        self.guarded(|| self.look_at(at))
    }
}

impl Planner {
    fn run_steps(&self, work: &PlanPass<'_>) -> Result<Vec<Vec4>> {
        let groups = |step: &Dispatch| step.uniform.invocations.div_ceil(LOOKUP_WORKGROUP);
        if work.steps.iter().any(|step| groups(step) > self.device.limits().max_compute_workgroups_per_dimension) {
            return Err(Error::Device("its limits do not allow the workgroups of a light field".into()));
        }
        let [functions, values, orders] = work.memory.map(buffer_of);
        let mut upload = Upload::new(&self.device);
        let lists =
            [cast_slice(work.bands), cast_slice(work.tables), cast_slice(work.columns)].map(|list| upload.add(list));
        let quadratures = work.quadratures.map(|rule| upload.add(cast_slice(rule)));
        let uniforms: Vec<_> = work.steps.iter().map(|step| upload.add(bytes_of(&step.uniform))).collect();
        let memory = self.uploaded(&upload);
        let uploaded = buffer_of(&memory);
        let part = |at: &Part| at.of(uploaded);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        for (step, uniform) in work.steps.iter().zip(&uniforms) {
            let [bands, tables, columns] = lists.each_ref().map(part);
            let quadrature = part(&quadratures[step.kernel.quadrature()]);
            let [functions, values, orders] = [functions, values, orders].map(whole);
            let parts = [part(uniform), bands, quadrature, tables, functions, values, orders, columns];
            let variant = if step.kernel.is_specialised() { work.variant } else { 0 };
            pass.set_pipeline(&self.pipeline(step.kernel.entry_point(), &self.fields, variant));
            pass.set_bind_group(0, &self.fields.bind_parts(&self.device, &parts), &[]);
            pass.dispatch_workgroups(groups(step), 1, 1);
        }
        drop(pass);
        if let Some(Retained { values, to }) = &work.keep {
            let bytes = VALUE * values.len() as u64;
            encoder.copy_buffer_to_buffer(orders, VALUE * values.start as u64, buffer_of(to), 0, bytes);
        }
        let part = |range: Range<usize>| Part { first: VALUE * range.start as u64, bytes: VALUE * range.len() as u64 };
        match work.read.clone() {
            Some(ReadBack::Values(range)) => Ok(self.read(encoder, &[(values, part(range))])?.concat()),
            Some(ReadBack::Orders(range)) => Ok(self.read(encoder, &[(orders, part(range))])?.concat()),
            None => {
                self.queue.submit([encoder.finish()]);
                Ok(Vec::new())
            }
        }
    }

    fn look_at(&self, at: &[Views<'_>]) -> Result<Vec<Vec<ByConstituent<Vec4>>>> {
        let mut upload = Upload::new(&self.device);
        let add = |Views { uniform, buffers, views, .. }: &Views<'_>| {
            let views: Vec<Vec4> = views.iter().map(|view| view.extend(0.0)).collect();
            let Buffers { bands, quadrature, colour, multiple, columns } = buffers;
            let lists = [
                cast_slice(bands),
                cast_slice(quadrature),
                cast_slice(colour),
                cast_slice(multiple),
                cast_slice(columns),
            ];
            let lists = lists.map(|list| upload.add(list));
            (upload.add(bytes_of(*uniform)), lists, upload.add(cast_slice(&views)))
        };
        let parts: Vec<_> = at.iter().map(add).collect();
        let memory = self.uploaded(&upload);
        let uploaded = buffer_of(&memory);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        let mut found = Vec::new();
        for (Views { buffers, views, variant, .. }, (uniform, lists, views_at)) in at.iter().zip(&parts) {
            let invocations = views.len() * buffers.bands.len();
            let memory = self.reserve(4 * PARTS * invocations)?;
            let [bands, quadrature, colour, multiple, columns] = lists.each_ref().map(|list| list.of(uploaded));
            let (uniform, views) = (uniform.of(uploaded), views_at.of(uploaded));
            let parts = [uniform, bands, quadrature, colour, multiple, views, whole(buffer_of(&memory)), columns];
            pass.set_pipeline(&self.pipeline(LOOK, &self.looks, *variant));
            pass.set_bind_group(0, &self.looks.bind_parts(&self.device, &parts), &[]);
            pass.dispatch_workgroups((invocations as u32).div_ceil(LOOKUP_WORKGROUP), 1, 1);
            found.push((memory, Part { first: 0, bytes: VALUE * (PARTS * invocations) as u64 }));
        }
        drop(pass);
        let parts: Vec<_> = found.iter().map(|(memory, part)| (buffer_of(memory), *part)).collect();
        let found = self.read(encoder, &parts)?;
        let parts = |of: &[Vec4]| ByConstituent { air: of[0], aerosol: of[1], multiple: of[2], ground: of[3] };
        Ok(found.iter().map(|values| values.chunks_exact(PARTS).map(parts).collect()).collect())
    }

    fn pipeline(&self, entry_point: &'static str, layouts: &Layouts, variant: u32) -> wgpu::ComputePipeline {
        self.kernels.pipeline_of(&self.device, Module::Plans, entry_point, layouts, variant)
    }

    /// A buffer of these bytes at least.
    fn pooled(&self, bytes: u64, usage: wgpu::BufferUsages) -> Memory {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let fits = |buffer: &wgpu::Buffer| buffer.usage() == usage && (bytes..=4 * bytes).contains(&buffer.size());
        let kept = free.iter().position(fits).map(|at| free.remove(at));
        let size = bytes.next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
        let descriptor = wgpu::BufferDescriptor { label: Some("plan"), size, usage, mapped_at_creation: false };
        let buffer = kept.unwrap_or_else(|| self.device.create_buffer(&descriptor));
        Arc::new(Pooled { buffer, free: Arc::clone(&self.free) })
    }

    /// A buffer of what kernels read.
    fn uploaded(&self, upload: &Upload) -> Memory {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let memory = self.pooled(upload.bytes.len() as u64, usage);
        self.queue.write_buffer(buffer_of(&memory), 0, &upload.bytes);
        memory
    }

    /// Submits commands, and waits for parts of buffers.
    fn read(&self, mut encoder: wgpu::CommandEncoder, parts: &[(&wgpu::Buffer, Part)]) -> Result<Vec<Vec<Vec4>>> {
        let all = parts.iter().map(|(_, part)| part.bytes).sum();
        let memory = self.pooled(all, wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);
        let staging = buffer_of(&memory);
        let mut to = 0;
        for (buffer, part) in parts {
            encoder.copy_buffer_to_buffer(buffer, part.first, staging, to, part.bytes);
            to += part.bytes;
        }
        let submission = self.queue.submit([encoder.finish()]);
        staging.slice(..all).map_async(wgpu::MapMode::Read, |_| {});
        let polled = self.device.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None });
        let not_answered = |error: wgpu::PollError| Error::Device(format!("it does not answer: {error}"));
        let read = polled.map_err(not_answered).and_then(|_| {
            let mapped = mapped(staging, all)?;
            let mut rest = &mapped[..];
            let part = |(_, part): &(&wgpu::Buffer, Part)| {
                let (values, others) = rest.split_at(part.bytes as usize);
                rest = others;
                bytemuck::pod_collect_to_vec(values)
            };
            Ok(parts.iter().map(part).collect())
        });
        staging.unmap();
        read
    }

    /// What some work finds, or what the device complained of. The error handlers of the program whose device it is
    /// hear of none of that.
    fn guarded<T>(&self, work: impl FnOnce() -> Result<T>) -> Result<T> {
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let found = work();
        let complaint =
            |scope: wgpu::ErrorScopeGuard| match pin!(scope.pop()).poll(&mut Context::from_waker(Waker::noop())) {
                Poll::Ready(error) => error.map(|error| error.to_string()),
                Poll::Pending => Some("it does not say whether it complained".into()),
            };
        // The last that was pushed is the first to be asked.
        let [of_memory, of_validation] = [memory, validation].map(complaint);
        match of_memory.or(of_validation) {
            Some(complaint) => Err(Error::Device(complaint.split_whitespace().collect::<Vec<_>>().join(" "))),
            None => found,
        }
    }
}

/// A part of a buffer.
#[derive(Clone, Copy)]
struct Part {
    first: u64,
    bytes: u64,
}

impl Part {
    fn of(self, buffer: &wgpu::Buffer) -> wgpu::BufferBinding<'_> {
        wgpu::BufferBinding { buffer, offset: self.first, size: NonZero::new(self.bytes) }
    }
}

/// What kernels read, one after the other in one buffer.
struct Upload {
    bytes: Vec<u8>,
    alignment: usize,
}

impl Upload {
    fn new(device: &wgpu::Device) -> Self {
        let limits = device.limits();
        let alignment = limits.min_uniform_buffer_offset_alignment.max(limits.min_storage_buffer_offset_alignment);
        Self { bytes: Vec::new(), alignment: alignment as usize }
    }

    /// Adds some bytes; where they are. A binding may not be empty.
    fn add(&mut self, bytes: &[u8]) -> Part {
        let first = self.bytes.len();
        self.bytes.extend_from_slice(if bytes.is_empty() { &[0; 16] } else { bytes });
        let part = Part { first: first as u64, bytes: (self.bytes.len() - first) as u64 };
        self.bytes.resize(self.bytes.len().next_multiple_of(self.alignment), 0);
        part
    }
}
