//! How buffers are bound to the kernels.

use std::borrow::Cow;
use std::num::NonZero;

use sorairo_shared::glam::Vec4;
use sorairo_shared::kernels::{ANCHOR_LANES, LOOKUP_WORKGROUP};
use sorairo_shared::picture::lookup::{anchors, colours_per_entry, entries};
use sorairo_shared::uniform::Uniform;

use crate::plan::Plan;

/// The bindings of the kernels that fill the sky lookup, and of those that write pixels.
pub(super) struct Groups {
    pub(super) lookup: wgpu::BindGroup,
    pub(super) pixels: wgpu::BindGroup,
}

/// Storage buffers that are bound to a kernel, at most.
pub(super) const STORAGE_BUFFERS: u32 = 7;

/// A bind group layout and the pipeline layout on it.
pub(super) struct Layouts {
    bindings: wgpu::BindGroupLayout,
    pub(super) pipeline: wgpu::PipelineLayout,
    /// The bindings that it has.
    used: &'static [u32],
}

impl Layouts {
    /// A layout of some bindings, the first ones without a gap; `written` are those that the kernels write. wgpu
    /// numbers the bindings of a layout anew where one is left out, and a shader that is passed through to the driver
    /// would not know.
    pub(super) fn new(device: &wgpu::Device, used: &'static [u32], written: &[u32]) -> Self {
        let of = |binding: &u32| wgpu::BindingType::Buffer {
            ty: if *binding == 0 {
                wgpu::BufferBindingType::Uniform
            } else {
                wgpu::BufferBindingType::Storage { read_only: !written.contains(binding) }
            },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        Self::of_types(device, used, &used.iter().map(of).collect::<Vec<_>>())
    }

    /// A layout of bindings of any types.
    pub(super) fn of_types(device: &wgpu::Device, used: &'static [u32], types: &[wgpu::BindingType]) -> Self {
        let entry = |(&binding, &ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        };
        let entries: Vec<_> = used.iter().zip(types).map(entry).collect();
        let bindings = device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("kernel"), entries: &entries });
        let pipeline = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("kernel"),
            bind_group_layouts: &[Some(&bindings)],
            immediate_size: 0,
        });
        Self { bindings, pipeline, used }
    }

    /// Buffers with the bytes that an image uses of each, as a pipeline takes them.
    pub(super) fn bind(&self, device: &wgpu::Device, buffers: &[(&wgpu::Buffer, u64)]) -> wgpu::BindGroup {
        let of = |&(buffer, bytes)| wgpu::BufferBinding { buffer, offset: 0, size: NonZero::new(bytes) };
        let bindings: Vec<_> = buffers.iter().map(of).collect();
        self.bind_parts(device, &bindings)
    }

    /// Parts of buffers, as a pipeline takes them.
    pub(super) fn bind_parts(&self, device: &wgpu::Device, parts: &[wgpu::BufferBinding<'_>]) -> wgpu::BindGroup {
        let resources: Vec<_> = parts.iter().cloned().map(wgpu::BindingResource::Buffer).collect();
        self.bind_resources(device, &resources)
    }

    /// Resources, as a pipeline takes them.
    pub(super) fn bind_resources(
        &self,
        device: &wgpu::Device,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        let entry = |&binding: &u32| wgpu::BindGroupEntry { binding, resource: resources[binding as usize].clone() };
        let entries: Vec<_> = self.used.iter().map(entry).collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("kernel"),
            layout: &self.bindings,
            entries: &entries,
        })
    }
}

/// The layouts of the kernels that fill the sky lookup, and of those that write pixels.
pub(super) struct KernelLayouts {
    pub(super) lookup: Layouts,
    pub(super) pixels: Layouts,
}

impl KernelLayouts {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        Self {
            lookup: Layouts::new(device, &[0, 1, 2, 3, 4, 5, 6], &[5]),
            pixels: Layouts::new(device, &[0, 1, 2, 3, 4, 5, 6, 7], &[6]),
        }
    }

    /// Buffers in the order of the bindings of pixels, with the bytes that an image uses of each. Where the lookup is
    /// filled, the tables of the medium take the place of the pixels.
    pub(super) fn bind(&self, device: &wgpu::Device, buffers: &[(&wgpu::Buffer, u64); 8]) -> Groups {
        let [inputs @ .., _, columns] = buffers;
        let of_lookup = [&inputs[..], &[*columns]].concat();
        Groups { lookup: self.lookup.bind(device, &of_lookup), pixels: self.pixels.bind(device, buffers) }
    }
}

/// Bytes of a plan's sky lookup, its anchors behind its entries; a binding may not be empty.
pub(super) fn lookup_bytes(plan: &Plan) -> u64 {
    let colours = u64::from(colours_per_entry(plan.variant));
    let count = u64::from(entries(&plan.uniform)) + u64::from(anchors(&plan.uniform));
    colours * size_of::<Vec4>() as u64 * count.max(1)
}

/// Workgroups that fill the anchors of a sky lookup, and its entries.
pub(super) fn groups_of_lookup(uniform: &Uniform) -> [(u32, u32); 2] {
    [anchors(uniform) * ANCHOR_LANES, entries(uniform)].map(|count| (count.div_ceil(LOOKUP_WORKGROUP), 1))
}

/// The bytes of some values for a binding, which may not be empty.
pub(super) fn not_empty(values: &[Vec4]) -> Cow<'_, [u8]> {
    if values.is_empty() {
        bytemuck::bytes_of(&Vec4::ZERO).to_vec().into()
    } else {
        bytemuck::cast_slice(values).into()
    }
}
