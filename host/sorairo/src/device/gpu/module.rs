//! The kernels' SPIR-V, specialised and handed to the driver.

use std::borrow::Cow;

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
            Self::Images => Kernel::ALL.iter().map(|kernel| kernel.entry_point()).chain(OF_ENVIRONMENTS).collect(),
            #[cfg(not(target_arch = "wasm32"))]
            Self::Plans => FieldKernel::ALL.iter().map(|kernel| kernel.entry_point()).chain([LOOK]).collect(),
        }
    }
}

/// The entry points that serve environment maps, which no plan asks for.
pub(super) const OF_ENVIRONMENTS: [&str; 4] =
    ["environment_level", "environment_half", "environment_rows", "environment_harmonics"];

/// The entry point that looks in directions.
#[cfg(not(target_arch = "wasm32"))]
pub(super) const LOOK: &str = "look";

/// The shader module with its specialisation constant set: handed to the driver as it is, where wgpu allows that; or `translated` by naga, one
/// entry point without what the others need, since a browser's compiler takes seconds for all of them.
pub(super) fn load(
    device: &wgpu::Device,
    module: Module,
    translated: Option<&str>,
    variant: u32,
) -> wgpu::ShaderModule {
    let words = specialised(&bytemuck::pod_collect_to_vec::<u8, u32>(module.spirv()), variant);
    match translated {
        None => {
            let entry_points: Vec<_> = module
                .entry_points()
                .into_iter()
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
        }
        Some(entry_point) => {
            let source = wgpu::ShaderSource::Naga(Cow::Owned(alone(words, entry_point)));
            let descriptor = wgpu::ShaderModuleDescriptor { label: Some("sorairo"), source };
            // SAFETY: the kernels' indices stay inside their buffers, and their loops are bounded.
            #[expect(unsafe_code, reason = "wgpu would add checks that the kernels do not need")]
            unsafe {
                device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked())
            }
        }
    }
}

/// One entry point of a module, and what it needs.
fn alone(words: Vec<u32>, entry_point: &str) -> naga::Module {
    let options = naga::front::spv::Options::default();
    let parsed = naga::front::spv::Frontend::new(words.into_iter(), &options).parse();
    let mut module = parsed.expect("the tests read the module with naga");
    module.entry_points.retain(|entry| entry.name == entry_point);
    naga::compact::compact(&mut module, naga::compact::KeepUnused::No);
    module
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
