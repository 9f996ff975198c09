//! The committed shaders, without a compiler and without a GPU.

use std::path::{Path, PathBuf};

use naga::valid::{Capabilities, ValidationFlags, Validator};
use sorairo::low_level::device::gpu::{Module, specialised};
use sorairo_shared::kernels::{LOOKUP_WORKGROUP, WORKGROUP_SIDE};
use sorairo_shared::picture::air::VOLUME_SIDE;
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

/// Everything that a kernel may need but what contradicts it, and parts of it.
fn variants() -> impl Iterator<Item = u32> {
    let sky = variant::INTEGRAL | variant::REST | variant::SUN_DISC;
    let fits = [0, variant::SOLVED, variant::REGRESSION, variant::REGRESSION | variant::BANDS];
    let views = [0, variant::AGX, variant::ACES | variant::NIGHT, variant::AGX | variant::REC2020];
    let skies = [0, variant::AEROSOL, variant::WHOLE_INTEGRAL | variant::REST, sky];
    let all = skies.into_iter().zip(fits).zip(views).zip(0..);
    all.flat_map(|(((sky, fit), view), below)| {
        (0..6).map(move |projection| sky | fit | view | below << 28 | variant::of(0, projection, projection % 4))
    })
}

fn words(module: Module) -> Vec<u32> {
    module.spirv().chunks(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect()
}

#[test]
fn a_specialised_kernel_is_valid_alone_and_holds_its_constant() {
    for module in Module::ALL {
        let words = words(module);
        for (name, variant) in module.entry_points().into_iter().flat_map(|name| variants().map(move |it| (name, it))) {
            let specialised = specialised(&words, name, variant);
            let options = naga::front::spv::Options::default();
            let module = naga::front::spv::Frontend::new(specialised.into_iter(), &options).parse().unwrap();
            assert!(module.overrides.is_empty(), "{name}: the specialisation constant is left");
            assert_eq!(module.entry_points.iter().map(|entry| entry.name.as_str()).collect::<Vec<_>>(), [name]);
            Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).unwrap();
        }
    }
}

#[test]
fn what_a_variant_leaves_out_no_driver_reads() {
    let words = words(Module::Images);
    let of = |name, variant| specialised(&words, name, variant).len();
    let default = variant::of(variant::WHOLE_INTEGRAL | variant::REST | variant::AGX, 0, 1);
    // 4 to 15 times when this was written.
    for name in ["sky", "anchors", "sky_lookup"] {
        assert!(3 * of(name, default) < words.len(), "{name}: {} of {} words", of(name, default), words.len());
    }
    // Each of these says something.
    for bit in [variant::AEROSOL, variant::OZONE, variant::TABLES, variant::MULTIPLE, variant::AGX, variant::SUN_DISC] {
        assert_ne!(of("sky", default), of("sky", default ^ bit), "{bit:x}");
    }
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
                (_, "air_volume") => [VOLUME_SIDE, VOLUME_SIDE, 1],
                (Module::Plans, _) | (_, "lookup" | "anchors") => [LOOKUP_WORKGROUP, 1, 1],
                _ => [WORKGROUP_SIDE, WORKGROUP_SIDE, 1],
            };
            assert_eq!(entry.workgroup_size, expected, "{}", entry.name);
        }
    }
}
