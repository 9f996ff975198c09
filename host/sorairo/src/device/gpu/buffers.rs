//! The buffers of an image on a graphics device, kept for the next.

use super::layouts::{Groups, KernelLayouts, lookup_bytes, not_empty};
use super::readback::{Clock, Slot};
use crate::plan::Plan;

/// Strips of an image that are under way at once: one is computed while the other is brought back.
pub(super) const STRIPS_UNDER_WAY: usize = 2;

/// A buffer that is kept from image to image, and made anew for one that needs more.
pub(super) struct Kept {
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
    fn upload(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, contents: &[u8]) -> u64 {
        self.reserve(device, contents.len() as u64);
        queue.write_buffer(self.get(), 0, contents);
        contents.len() as u64
    }

    pub(super) fn get(&self) -> &wgpu::Buffer {
        self.buffer.as_ref().expect("an image reserves its buffers first")
    }
}

/// The buffers of an image, kept for the next.
pub(super) struct DeviceBuffers {
    pub(super) uniform: Kept,
    bands: Kept,
    quadrature: Kept,
    colour: Kept,
    multiple: Kept,
    columns: Kept,
    lookup: Kept,
    pub(super) pixels: Kept,
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
            multiple: Kept::new("lookup of multiply scattered light", storage),
            columns: Kept::new("tables of the medium", storage),
            lookup: Kept::new("sky lookup", wgpu::BufferUsages::STORAGE),
            pixels: Kept::new("pixels", wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC),
            slots: Default::default(),
        }
    }
}

impl DeviceBuffers {
    /// Uploads a plan, and binds its buffers and `pixel_bytes` of output.
    pub(super) fn fill(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        layouts: &KernelLayouts,
        plan: &Plan,
        pixel_bytes: u64,
    ) -> Groups {
        let lookup_bytes = lookup_bytes(plan);
        self.lookup.reserve(device, lookup_bytes);
        self.pixels.reserve(device, pixel_bytes);
        let buffers = plan.buffers();
        let uniform_bytes = self.uniform.upload(device, queue, bytemuck::bytes_of(&plan.uniform));
        let bands_bytes = self.bands.upload(device, queue, bytemuck::cast_slice(buffers.bands));
        let quadrature_bytes = self.quadrature.upload(device, queue, bytemuck::cast_slice(buffers.quadrature));
        let colour_bytes = self.colour.upload(device, queue, &not_empty(buffers.colour));
        let multiple_bytes = self.multiple.upload(device, queue, &not_empty(buffers.multiple));
        let columns_bytes = self.columns.upload(device, queue, &not_empty(buffers.columns));
        let bound = [
            (self.uniform.get(), uniform_bytes),
            (self.bands.get(), bands_bytes),
            (self.quadrature.get(), quadrature_bytes),
            (self.colour.get(), colour_bytes),
            (self.multiple.get(), multiple_bytes),
            (self.lookup.get(), lookup_bytes),
            (self.pixels.get(), pixel_bytes),
            (self.columns.get(), columns_bytes),
        ];
        layouts.bind(device, &bound)
    }

    /// A place of at least `bytes` for a strip to come back to.
    pub(super) fn slot(&mut self, device: &wgpu::Device, index: usize, bytes: u64, has_clock: bool) -> Slot {
        let kept = self.slots[index].take();
        let slot = match kept {
            Some(slot) if slot.bytes >= bytes => slot,
            smaller => Slot::new(device, bytes, has_clock.then(|| clock_of(smaller, device))),
        };
        self.slots[index] = Some(slot.clone());
        slot
    }
}

/// The clock of a slot that is given up, or a new one.
fn clock_of(slot: Option<Slot>, device: &wgpu::Device) -> Clock {
    slot.and_then(|slot| slot.clock).unwrap_or_else(|| Clock::new(device))
}
