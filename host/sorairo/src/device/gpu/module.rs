//! The kernels' SPIR-V, specialised and handed to the driver.

use std::borrow::Cow;

use super::specialised::specialised;
use crate::plan::Kernel;
#[cfg(not(target_arch = "wasm32"))]
use crate::plan::on_device::FieldKernel;

/// A module of kernels, compiled by rust-gpu; `cargo xtask shaders` rebuilds them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Module {
    /// What draws the sky, lights with it and measures a device.
    Images,
    /// What plans ask of a device. Nobody does in a browser, which has no need to load it.
    #[cfg(not(target_arch = "wasm32"))]
    Plans,
}

impl Module {
    /// Every module.
    #[cfg(not(target_arch = "wasm32"))]
    pub const ALL: [Self; 2] = [Self::Images, Self::Plans];

    /// Its SPIR-V.
    pub fn spirv(self) -> &'static [u8] {
        match self {
            Self::Images => sorairo_shaders::IMAGES,
            #[cfg(not(target_arch = "wasm32"))]
            Self::Plans => sorairo_shaders::PLANS,
        }
    }

    /// Its entry points.
    pub fn entry_points(self) -> Vec<&'static str> {
        match self {
            Self::Images => {
                let of_plans = Kernel::ALL.iter().map(|kernel| kernel.entry_point());
                of_plans.chain(OF_ENVIRONMENTS).chain(OF_AIR).collect()
            }
            #[cfg(not(target_arch = "wasm32"))]
            Self::Plans => FieldKernel::ALL.iter().map(|kernel| kernel.entry_point()).chain([LOOK]).collect(),
        }
    }
}

/// The entry points that serve environment maps, which no plan asks for.
pub(super) const OF_ENVIRONMENTS: [&str; 4] =
    ["environment_level", "environment_half", "environment_rows", "environment_harmonics"];

/// The entry points that fill a volume of air, and apply it; likewise.
pub(super) const OF_AIR: [&str; 2] = ["air_volume", "air_applied"];

/// The entry point that looks in directions.
#[cfg(not(target_arch = "wasm32"))]
pub(super) const LOOK: &str = "look";

/// A kernel, specialised: handed to the driver as it is where `passthrough` says that wgpu allows it, or else
/// translated by naga.
pub(super) fn load(
    device: &wgpu::Device,
    module: Module,
    entry_point: &'static str,
    variant: u32,
    passthrough: bool,
) -> wgpu::ShaderModule {
    let words = specialised(&bytemuck::pod_collect_to_vec::<u8, u32>(module.spirv()), entry_point, variant);
    match passthrough {
        true => {
            let entry_points =
                [wgpu::PassthroughShaderEntryPoint { name: entry_point.into(), workgroup_size: (0, 0, 0) }];
            // SAFETY: the module is the one that the tests validate, compiled from this repository's own kernels, whose
            // indices stay inside their buffers; wgpu's devices bound buffer accesses besides.
            #[expect(unsafe_code, reason = "wgpu cannot check what it does not translate")]
            unsafe {
                device.create_shader_module_passthrough(wgpu::ShaderModuleDescriptorPassthrough {
                    label: Some("sorairo"),
                    spirv: Some(words.into()),
                    entry_points: entry_points.as_slice().into(),
                    ..Default::default()
                })
            }
        }
        false => {
            let source = wgpu::ShaderSource::Naga(Cow::Owned(parsed(words)));
            let descriptor = wgpu::ShaderModuleDescriptor { label: Some("sorairo"), source };
            // SAFETY: the kernels' indices stay inside their buffers, and their loops are bounded.
            #[expect(unsafe_code, reason = "wgpu would add checks that the kernels do not need")]
            unsafe {
                device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked())
            }
        }
    }
}

/// A module as naga reads it, without what its entry point does not need.
fn parsed(words: Vec<u32>) -> naga::Module {
    let options = naga::front::spv::Options::default();
    let parsed = naga::front::spv::Frontend::new(words.into_iter(), &options).parse();
    let mut module = parsed.expect("the tests read the module with naga");
    naga::compact::compact(&mut module, naga::compact::KeepUnused::No);
    written_only(&mut module.types);
    module
}

/// Declares that storage textures are only written. The SPIR-V does not say so, and naga then declares that they are
/// read too, which no layout here allows, nor WebGPU for this format.
fn written_only(types: &mut naga::UniqueArena<naga::Type>) {
    let all: Vec<_> = types.iter().map(|(handle, of)| (handle, of.clone())).collect();
    for (handle, mut of) in all {
        if let naga::TypeInner::Image { class: naga::ImageClass::Storage { access, .. }, .. } = &mut of.inner {
            *access = naga::StorageAccess::STORE;
            types.replace(handle, of);
        }
    }
}
