//! The committed shaders, without a compiler and without a GPU.

use std::path::{Path, PathBuf};

use naga::valid::{Capabilities, ValidationFlags, Validator};
use sorairo::low_level::device::gpu::{Module, specialised};
use sorairo_shared::kernels::{LOOKUP_WORKGROUP, WORKGROUP_SIDE};
use sorairo_shared::picture::environment::LANES;
use sorairo_shared::variant;

#[path = "../../../xtask/src/manifest.rs"]
mod manifest;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

fn kept_manifest() -> serde_json::Value {
    let text = std::fs::read_to_string(root().join(manifest::COMPILED).join("manifest.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

#[test]
fn the_committed_shaders_were_compiled_from_these_sources() {
    let expected = manifest::source_hash(&root()).unwrap();
    assert_eq!(kept_manifest()["source_sha256"], expected, "run `cargo xtask shaders` and commit the result");
}

#[test]
fn the_source_hash_notices_a_changed_source() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["shared/Cargo.toml", "shared/src/a.rs", "shader-crate/Cargo.toml", "shader-crate/src/lib.rs"] {
        let path = folder.path().join(file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, file).unwrap();
    }
    let before = manifest::source_hash(folder.path()).unwrap();
    std::fs::write(folder.path().join("shared/src/a.rs"), "x").unwrap();
    assert_ne!(manifest::source_hash(folder.path()).unwrap(), before);
}

#[test]
fn a_specialised_module_is_valid_and_holds_its_constant() {
    for module in Module::ALL {
        holds_its_constant(module);
    }
}

fn holds_its_constant(module: Module) {
    let words: Vec<u32> = module.spirv().chunks(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect();
    for value in [0, variant::WHOLE_INTEGRAL, variant::of(variant::AEROSOL, 2, 1)] {
        let patched = specialised(&words, value);
        assert!(patched.len() < words.len(), "no decoration was left out");
        let bytes: Vec<u8> = patched.iter().flat_map(|word| word.to_le_bytes()).collect();
        let module = naga::front::spv::parse_u8_slice(&bytes, &naga::front::spv::Options::default()).unwrap();
        assert!(module.overrides.is_empty(), "the specialisation constant is left");
        Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).unwrap();
    }
    assert_ne!(specialised(&words, 0), specialised(&words, 1));
}

#[test]
fn naga_validates_the_committed_modules_and_finds_every_kernel() {
    for (compiled, file) in Module::ALL.into_iter().zip(["images.spv", "plans.spv"]) {
        let module = naga::front::spv::parse_u8_slice(compiled.spirv(), &naga::front::spv::Options::default()).unwrap();
        Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).unwrap();
        let mut found: Vec<&str> = module.entry_points.iter().map(|entry| entry.name.as_str()).collect();
        found.sort_unstable();
        let mut expected = compiled.entry_points();
        expected.sort_unstable();
        assert_eq!(found, expected);
        assert_eq!(kept_manifest()["modules"][file]["entry_points"], serde_json::json!(expected));
        for entry in &module.entry_points {
            let expected = match (compiled, entry.name.as_str()) {
                (_, "environment_rows" | "environment_harmonics") => [LANES, 1, 1],
                (Module::Plans, _) | (_, "lookup" | "anchors") => [LOOKUP_WORKGROUP, 1, 1],
                _ => [WORKGROUP_SIDE, WORKGROUP_SIDE, 1],
            };
            assert_eq!(entry.workgroup_size, expected, "{}", entry.name);
        }
    }
}
