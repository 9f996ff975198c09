//! The kernels of a device: modules and pipelines, made when they are first needed and kept.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Mutex, OnceLock};

use super::layouts::{KernelLayouts, Layouts};
use super::module::{Module, load};
use crate::plan::Kernel;

/// The kernels of a device.
pub(super) struct Kernels {
    /// How buffers are bound to them: made when it is first asked for, since a device may lack the bindings.
    layouts: OnceLock<KernelLayouts>,
    /// Whether the driver takes SPIR-V as it is.
    passthrough: bool,
    /// Where the driver keeps what it compiles, if the program has such a place.
    cache: Option<wgpu::PipelineCache>,
    pipelines: Mutex<HashMap<(&'static str, u32), wgpu::ComputePipeline>>,
}

impl Kernels {
    /// Those of a device; nothing is compiled yet.
    pub(super) fn new(device: &wgpu::Device) -> Self {
        Self { layouts: OnceLock::new(), passthrough: takes_spirv(device), cache: None, pipelines: Mutex::default() }
    }

    /// The same, whose pipelines a cache of the driver's keeps.
    pub(super) fn with_cache(self, cache: wgpu::PipelineCache) -> Self {
        Self { cache: Some(cache), ..self }
    }

    /// The pipeline of a kernel for a variant.
    pub(super) fn pipeline(&self, device: &wgpu::Device, kernel: Kernel, variant: u32) -> wgpu::ComputePipeline {
        let layouts = match kernel {
            Kernel::Lookup | Kernel::Anchors => &self.layouts(device).lookup,
            _ => &self.layouts(device).pixels,
        };
        self.pipeline_of(device, Module::Images, kernel.entry_point(), layouts, kernel.variant(variant))
    }

    /// The pipeline of a module's entry point to which buffers are bound in this way, for a variant.
    pub(super) fn pipeline_of(
        &self,
        device: &wgpu::Device,
        module: Module,
        entry_point: &'static str,
        layouts: &Layouts,
        variant: u32,
    ) -> wgpu::ComputePipeline {
        let key = (entry_point, variant);
        found_or_made(&self.pipelines, key, || {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&layouts.pipeline),
                module: &load(device, module, entry_point, variant, self.passthrough),
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: self.cache.as_ref(),
            })
        })
    }

    /// How many pipelines are compiled.
    pub(super) fn count(&self) -> usize {
        self.pipelines.lock().expect("no holder of this lock panics").len()
    }

    /// How buffers are bound to the kernels.
    pub(super) fn layouts(&self, device: &wgpu::Device) -> &KernelLayouts {
        self.layouts.get_or_init(|| KernelLayouts::new(device))
    }
}

/// What a map holds at a key, or else what is made now. The map is not locked meanwhile: a frame does not wait for what
/// another thread compiles, but compiles the same once more if it needs that.
fn found_or_made<K: Eq + Hash, V: Clone>(map: &Mutex<HashMap<K, V>>, key: K, make: impl FnOnce() -> V) -> V {
    let lock = || map.lock().expect("no holder of this lock panics");
    let found = lock().get(&key).cloned();
    found.unwrap_or_else(|| {
        let made = make();
        lock().entry(key).or_insert(made).clone()
    })
}

/// Whether SPIR-V reaches the driver as it is. Other interfaces pass their own languages through, by the same feature.
fn takes_spirv(device: &wgpu::Device) -> bool {
    let has_feature = device.features().contains(wgpu::Features::PASSTHROUGH_SHADERS);
    has_feature && device.adapter_info().backend == wgpu::Backend::Vulkan
}

/// Encodes a kernel over so many workgroups.
pub(super) fn dispatch(
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
