//! Developer commands of sorairo.
//!
//! `cargo xtask shaders` compiles the shaders into `shader-crate/compiled`; `cargo xtask shaders --check` compiles them
//! and compares the bytes with those that are there. `cargo xtask docs` writes the pages of figures from docs/figures;
//! `cargo xtask docs DIR` first takes the figures of a folder of reports. `cargo xtask gallery` makes the pictures of
//! docs/gallery.md. `cargo xtask circles` fails if files need each other in a circle. `cargo xtask features` compiles
//! packages with each feature alone. `cargo xtask package` installs the command from packages alone.
//! `cargo xtask platforms` compiles it for Windows and Apple. `cargo xtask web` builds the page for browsers into
//! target/web, and its package for npm into target/npm. `cargo xtask pixels --program PATH --out FILE` keeps the hashes
//! of a program's pixels, and `--against FILE` compares another program's with them.

mod circles;
mod docs;
mod features;
mod gallery;
mod manifest;
mod other_target;
mod package;
mod pages;
mod pixels;
mod platforms;
mod web;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use sha2::{Digest, Sha256};
use spirv_builder::{ModuleResult, SpirvBuilder};

/// SPIR-V 1.3: later versions have instructions that naga does not read.
const TARGET: &str = "spirv-unknown-vulkan1.1";
const COMPILER: &str = "rust-gpu 0.10.0";
/// The modules, by the features of the shader crate of which they are made.
const MODULES: [&str; 2] = ["images", "plans"];
const MANIFEST: &str = "manifest.json";

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let arguments: Vec<_> = arguments.iter().map(String::as_str).collect();
    let result = match arguments.as_slice() {
        ["shaders"] => shaders(false),
        ["shaders", "--check"] => shaders(true),
        ["circles"] => root().and_then(circles::check),
        ["package"] => root().and_then(package::check),
        ["platforms"] => root().and_then(platforms::check),
        ["features"] => root().and_then(features::check),
        ["gallery"] => root().and_then(gallery::make),
        ["docs"] => root().and_then(docs::write),
        ["docs", reports] => root().and_then(|root| docs::take(root, Path::new(reports))),
        ["pixels", "--program", program, "--out", file] => {
            root().and_then(|root| pixels::keep(root, Path::new(program), Path::new(file)))
        }
        ["pixels", "--program", program, "--against", file] => {
            root().and_then(|root| pixels::check(root, Path::new(program), Path::new(file)))
        }
        ["web"] => root().and_then(web::build),
        _ => {
            eprintln!(
                "usage: cargo xtask shaders [--check] | docs [DIR] | gallery | circles | features | package | platforms | web | pixels --program PATH (--out | --against) FILE"
            );
            return ExitCode::from(2);
        }
    };
    match result {
        Ok(message) => {
            println!("{message}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("xtask: {error}");
            ExitCode::FAILURE
        }
    }
}

fn root() -> Result<&'static Path, Box<dyn Error>> {
    Ok(Path::new(env!("CARGO_MANIFEST_DIR")).parent().ok_or("xtask has no parent folder")?)
}

fn shaders(check: bool) -> Result<String, Box<dyn Error>> {
    let root = root()?;
    let (mut files, mut modules) = (Vec::new(), serde_json::Map::new());
    for feature in MODULES {
        let (module, mut entry_points) = compile(&root.join("shader-crate"), feature)?;
        entry_points.sort();
        let sha256: String = Sha256::digest(&module).iter().map(|byte| format!("{byte:02x}")).collect();
        let name = format!("{feature}.spv");
        modules.insert(name.clone(), serde_json::json!({ "entry_points": entry_points, "sha256": sha256 }));
        files.push((name, module));
    }
    let manifest = serde_json::json!({
        "generator": "cargo xtask shaders",
        "compiler": COMPILER,
        "target": TARGET,
        "modules": modules,
        "source_sha256": manifest::source_hash(root)?,
    });
    files.push((MANIFEST.into(), format!("{manifest:#}\n").into_bytes()));
    let folder = root.join(manifest::COMPILED);
    if check {
        let same =
            |(name, built): &(String, Vec<u8>)| std::fs::read(folder.join(name)).is_ok_and(|kept| kept == *built);
        if !files.iter().all(same) {
            return Err("the compiled shaders differ from their sources; run `cargo xtask shaders`".into());
        }
        return Ok("the compiled shaders are what their sources give".into());
    }
    std::fs::create_dir_all(&folder)?;
    for (name, contents) in &files {
        std::fs::write(folder.join(name), contents)?;
    }
    let sizes = files.iter().map(|(name, contents)| format!("{name}: {} bytes", contents.len()));
    Ok(sizes.collect::<Vec<_>>().join(", "))
}

/// Compiles the shader crate with a feature to one module; returns its bytes and the names of its entry points.
fn compile(shader_crate: &Path, feature: &str) -> Result<(Vec<u8>, Vec<String>), Box<dyn Error>> {
    let mut builder = match std::env::var_os("RUSTC_CODEGEN_SPIRV") {
        Some(backend) => {
            let mut builder = SpirvBuilder::new(shader_crate, TARGET);
            builder.rustc_codegen_spirv_location = Some(PathBuf::from(backend));
            builder.toolchain_overwrite = std::env::var("RUST_GPU_TOOLCHAIN").ok();
            builder
        }
        None => {
            let install = cargo_gpu_install::install::Install::from_shader_crate(shader_crate.to_owned());
            install.run()?.to_spirv_builder(shader_crate, TARGET)
        }
    };
    builder.build_script.defaults = false;
    builder.shader_crate_features.default_features = false;
    builder.shader_crate_features.features = vec![feature.into()];
    let result = builder.build()?;
    let ModuleResult::SingleModule(path) = &result.module else {
        return Err("the shaders did not compile to one module".into());
    };
    Ok((std::fs::read(path)?, result.entry_points))
}
