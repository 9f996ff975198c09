//! The kernels of a device: modules and pipelines, made when they are first needed and kept.

use std::collections::HashMap;
use std::sync::{Mutex, OnceLock};

use super::layouts::{KernelLayouts, Layouts};
use super::module::{Module, load};
use crate::plan::Kernel;

/// A module for a value of the specialisation constant, of all entry points or of one.
type Loaded = (Module, Option<&'static str>, u32);

/// The kernels of a device.
pub(super) struct Kernels {
    /// How buffers are bound to them: made when it is first asked for, since a device may lack the bindings.
    layouts: OnceLock<KernelLayouts>,
    /// Whether the driver takes SPIR-V as it is.
    passthrough: bool,
    modules: Mutex<HashMap<Loaded, wgpu::ShaderModule>>,
    pipelines: Mutex<HashMap<(&'static str, u32), wgpu::ComputePipeline>>,
}

impl Kernels {
    /// Those of a device; nothing is compiled yet.
    pub(super) fn new(device: &wgpu::Device) -> Self {
        Self {
            layouts: OnceLock::new(),
            passthrough: takes_spirv(device),
            modules: Mutex::default(),
            pipelines: Mutex::default(),
        }
    }

    /// The pipeline of a kernel for a variant.
    pub(super) fn pipeline(&self, device: &wgpu::Device, kernel: Kernel, variant: u32) -> wgpu::ComputePipeline {
        let layouts = match kernel {
            Kernel::Lookup | Kernel::Anchors => &self.layouts(device).lookup,
            _ => &self.layouts(device).pixels,
        };
        self.pipeline_of(device, Module::Images, kernel.entry_point(), layouts, variant)
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
        let mut modules = self.modules.lock().expect("no holder of this lock panics");
        let translated = (!self.passthrough).then_some(entry_point);
        let load = || load(device, module, translated, variant);
        let module = modules.entry((module, translated, variant)).or_insert_with(load);
        let mut pipelines = self.pipelines.lock().expect("no holder of this lock panics");
        let build = || {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
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

    /// How buffers are bound to the kernels.
    pub(super) fn layouts(&self, device: &wgpu::Device) -> &KernelLayouts {
        self.layouts.get_or_init(|| KernelLayouts::new(device))
    }
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
