//! The committed kernels in the languages of every graphics interface: Metal's, Direct3D's and WebGPU's. None of these
//! devices is here; what can be shown is that naga, through which wgpu goes, translates every kernel, and that each
//! keeps to the limits that all of them have.

use naga::back::{hlsl, msl, wgsl};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, Module};
use sorairo_shared::light_field::device::uniform::FieldUniform;
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant::{self, PixelFormat};

#[path = "../../host/sorairo/src/device/gpu/specialised.rs"]
mod specialised;

use specialised::specialised;

const SPIRV: [&[u8]; 2] =
    [include_bytes!("../../shader-crate/compiled/images.spv"), include_bytes!("../../shader-crate/compiled/plans.spv")];

/// WebGPU's default limits (W3C, *WebGPU*, 3.6.2), which no device may undercut: those of Metal (31 buffers, 32 KiB for
/// a threadgroup) and Direct3D 12 (1024 threads, 32 KiB for a group) are wider.
const STORAGE_BUFFERS: usize = 8;
/// Of storage textures, the fewest of those that a stage has.
const TEXTURES: usize = 6;
/// Uniforms that a kernel reads at most.
const UNIFORMS: usize = 3;
/// All of these: nothing demands gaps.
const BINDINGS: u32 = (UNIFORMS + TEXTURES + STORAGE_BUFFERS) as u32;
const UNIFORM_BYTES: usize = 65_536;
const INVOCATIONS: u32 = 256;
const WORKGROUP_SIZES: [u32; 3] = [256, 256, 64];
const WORKGROUP_BYTES: u32 = 16_384;

/// The least and the most that a kernel is compiled with, in every format of pixels.
fn variants() -> [u32; 5] {
    let whole = variant::INTEGRAL | variant::REST | variant::SUN_DISC;
    [
        variant::of(0, 0, PixelFormat::LinearRgb as u32),
        variant::of(variant::AEROSOL | variant::RUNS, 0, PixelFormat::Picture as u32),
        variant::of(variant::AEROSOL | variant::REST | variant::RUNS, 2, PixelFormat::Picture as u32),
        variant::of(whole, 1, PixelFormat::HalfRgb as u32),
        variant::of(whole, 2, PixelFormat::LinearRgba as u32),
    ]
}

fn modules() -> [Module; 2] {
    SPIRV.map(|spirv| naga::front::spv::parse_u8_slice(spirv, &naga::front::spv::Options::default()).unwrap())
}

fn validated(module: &Module) -> ModuleInfo {
    Validator::new(ValidationFlags::all(), Capabilities::all()).validate(module).unwrap()
}

/// Calls a translator with every kernel alone, for each variant.
fn each_kernel(mut translate: impl FnMut(&str, &Module, &ModuleInfo)) {
    let mut kernels = 0;
    for (spirv, module) in SPIRV.into_iter().zip(modules()) {
        let words: Vec<u32> = spirv.chunks(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect();
        for entry in &module.entry_points {
            for variant in variants() {
                let alone = specialised(&words, &entry.name, variant);
                let options = naga::front::spv::Options::default();
                let alone = naga::front::spv::Frontend::new(alone.into_iter(), &options).parse().unwrap();
                assert_eq!(alone.entry_points.len(), 1);
                translate(&entry.name, &alone, &validated(&alone));
                kernels += 1;
            }
        }
    }
    assert_eq!(kernels, 22 * variants().len());
}

#[test]
fn every_kernel_has_a_translation_for_metal() {
    let options = msl::Options { lang_version: (2, 4), fake_missing_bindings: true, ..msl::Options::default() };
    each_kernel(|name, module, info| {
        let (text, names) = msl::write_string(module, info, &options, &msl::PipelineOptions::default()).unwrap();
        let translated = names.entry_point_names.into_iter().collect::<Result<Vec<_>, _>>();
        assert_eq!(translated.unwrap(), [name]);
        assert!(text.contains("kernel void"), "{name}");
    });
}

#[test]
fn every_kernel_has_a_translation_for_direct3d() {
    let options = hlsl::Options { fake_missing_bindings: true, ..hlsl::Options::default() };
    let of_pipeline = hlsl::PipelineOptions::default();
    each_kernel(|name, module, info| {
        let mut text = String::new();
        let mut writer = hlsl::Writer::new(&mut text, &options, &of_pipeline);
        let names = writer.write(module, info, None).unwrap().entry_point_names;
        assert_eq!(names.into_iter().collect::<Result<Vec<_>, _>>().unwrap(), [name]);
        assert!(text.contains("numthreads"), "{name}");
    });
}

#[test]
fn every_kernel_has_a_translation_for_webgpu_that_can_be_read_again() {
    each_kernel(|name, module, info| {
        let text = wgsl::write_string(module, info, wgsl::WriterFlags::empty()).unwrap();
        let again =
            naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
        validated(&again);
        assert_eq!(again.entry_points.iter().map(|entry| entry.name.as_str()).collect::<Vec<_>>(), [name]);
    });
}

#[test]
fn kernels_keep_to_the_limits_that_every_interface_has() {
    assert!(size_of::<Uniform>() <= UNIFORM_BYTES && size_of::<FieldUniform>() <= UNIFORM_BYTES);
    // Those of environment maps share memory, those of plans do not.
    assert_eq!(modules().each_ref().map(keeps_to_limits), [true, false]);
}

/// Checks every entry point of a module; whether any of them shares memory in its workgroups.
fn keeps_to_limits(module: &Module) -> bool {
    let info = validated(module);
    let mut shares = false;
    for (i, entry) in module.entry_points.iter().enumerate() {
        let used = |space: fn(AddressSpace) -> bool| {
            let of_entry = info.get_entry_point(i);
            let globals = module.global_variables.iter();
            globals.filter(|(handle, global)| space(global.space) && !of_entry[*handle].is_empty()).count()
        };
        let storage = used(|space| matches!(space, AddressSpace::Storage { .. }));
        let textures = used(|space| space == AddressSpace::Handle);
        let uniforms = used(|space| space == AddressSpace::Uniform);
        assert!(uniforms <= UNIFORMS, "{}: {uniforms} uniforms", entry.name);
        assert!(storage <= STORAGE_BUFFERS, "{}: {storage} storage buffers", entry.name);
        assert!(textures <= TEXTURES, "{}: {textures} textures and samplers", entry.name);
        assert!(storage + textures > 0, "{} writes nothing", entry.name);
        assert!(entry.workgroup_size.iter().product::<u32>() <= INVOCATIONS, "{}", entry.name);
        assert!(entry.workgroup_size.iter().zip(WORKGROUP_SIZES).all(|(&size, most)| size <= most), "{}", entry.name);
        let of_entry = info.get_entry_point(i);
        let shared = module
            .global_variables
            .iter()
            .filter(|(handle, global)| global.space == AddressSpace::WorkGroup && !of_entry[*handle].is_empty());
        let bytes: u32 = shared.map(|(_, global)| module.types[global.ty].inner.size(module.to_ctx())).sum();
        assert!(bytes <= WORKGROUP_BYTES, "{}: {bytes} bytes of a workgroup", entry.name);
        shares |= bytes > 0;
    }
    for (_, global) in module.global_variables.iter().filter(|(_, global)| global.binding.is_some()) {
        let binding = global.binding.as_ref().unwrap();
        assert!(binding.group == 0 && binding.binding < BINDINGS, "{binding:?}");
    }
    shares
}

#[test]
fn a_kernel_that_is_none_is_told() {
    let [mut module, _] = modules();
    module.entry_points[0].workgroup_size = [0, 1, 1];
    assert!(Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module).is_err());
}
