//! What comes back from a graphics device: strips of pixels, and the device's own clock.

use std::time::Duration;

use crate::device::backend::Times;
use crate::error::{Error, Result};

/// Where a strip comes back to.
#[derive(Clone)]
pub(super) struct Slot {
    pub(super) staging: wgpu::Buffer,
    pub(super) bytes: u64,
    pub(super) clock: Option<Clock>,
}

impl Slot {
    pub(super) fn new(device: &wgpu::Device, bytes: u64, clock: Option<Clock>) -> Self {
        let staging = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read-back"),
            size: bytes,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Self { staging, bytes, clock }
    }
}

/// The bytes of a buffer that is mapped.
pub(super) fn mapped(buffer: &wgpu::Buffer, bytes: u64) -> Result<wgpu::BufferView> {
    buffer
        .slice(..bytes)
        .get_mapped_range()
        .map_err(|error| Error::Device(format!("its output cannot be read: {error}")))
}

/// The device's own clock around the passes of a strip.
#[derive(Clone)]
pub(super) struct Clock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    pub(super) staging: wgpu::Buffer,
}

impl Clock {
    /// Before the first pass, after the last, after the copy.
    const QUERIES: u32 = 3;
    const BYTES: u64 = 8 * Self::QUERIES as u64;

    pub(super) fn new(device: &wgpu::Device) -> Self {
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
    pub(super) fn writes(&self, beginning: bool, end: bool) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: beginning.then_some(0),
            end_of_pass_write_index: end.then_some(1),
        }
    }

    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder, times_copies: bool) {
        let mut queries = Self::QUERIES - 1;
        if times_copies {
            encoder.write_timestamp(&self.queries, queries);
            queries += 1;
        }
        encoder.resolve_query_set(&self.queries, 0..queries, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, Self::BYTES);
    }

    /// The times of a strip that is done; with `times_copies` that of its copy is known too.
    pub(super) fn times(&self, queue: &wgpu::Queue, times_copies: bool) -> Result<Times> {
        let mapped = mapped(&self.staging, Self::BYTES)?;
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&mapped[..]);
        drop(mapped);
        self.staging.unmap();
        let period = f64::from(queue.get_timestamp_period());
        let elapsed = |from: u64, to: u64| Duration::from_nanos((to.saturating_sub(from) as f64 * period) as u64);
        let readback = if times_copies { elapsed(ticks[1], ticks[2]) } else { Duration::ZERO };
        Ok(Times { kernel: elapsed(ticks[0], ticks[1]), readback })
    }
}
