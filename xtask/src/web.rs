//! `cargo xtask web`: the page, as a folder that any server of files serves, and its module as a package for npm.

use std::error::Error;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::json;
use wasm_bindgen_cli_support::Bindgen;

use crate::other_target;

const TARGET: &str = "wasm32-unknown-unknown";
const PROFILE: &str = "browser";

/// Builds the module and its JavaScript, packs them, and lays them beside the files of the page.
///
/// # Errors
///
/// What is missing, or the step that failed.
pub fn build(root: &Path) -> Result<String, Box<dyn Error>> {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    compile(root, &target)?;
    let [folder, npm] = ["web", "npm"].map(|name| target.join(name));
    for folder in [&folder, &npm] {
        let _ = fs::remove_dir_all(folder);
        fs::create_dir_all(folder)?;
    }
    let module = target.join(TARGET).join(PROFILE).join("sorairo_web.wasm");
    let mut bindgen = Bindgen::new();
    bindgen.input_path(module).out_name("sorairo").web(true)?.typescript(true).omit_default_module_path(false);
    bindgen.remove_name_section(true).remove_producers_section(true);
    bindgen.generate(&npm)?;
    package(root, &npm)?;
    for file in ["sorairo.js", "sorairo_bg.wasm"] {
        fs::copy(npm.join(file), folder.join(file))?;
    }
    for file in fs::read_dir(root.join("host/web/page"))? {
        let file = file?;
        fs::copy(file.path(), folder.join(file.file_name()))?;
    }
    let (raw, packed) = sizes(&folder)?;
    let [raw, packed] = [raw, packed].map(|bytes| bytes as f64 / 1e6);
    Ok(format!("{}: {raw:.2} MB, {packed:.2} MB compressed with gzip", folder.display()))
}

/// Writes what a package for npm has beside the module.
fn package(root: &Path, folder: &Path) -> Result<(), Box<dyn Error>> {
    for file in ["LICENSE-APACHE", "LICENSE-MIT", "host/web/README.md"] {
        let file = root.join(file);
        fs::copy(&file, folder.join(file.file_name().ok_or("a file has a name")?))?;
    }
    let package = json!({
        "name": "sorairo",
        "version": env!("CARGO_PKG_VERSION"),
        "description": "Full-spectrum rendering of the clear sky with WebGPU",
        "license": env!("CARGO_PKG_LICENSE"),
        "type": "module",
        "exports": { ".": "./sorairo.js", "./sorairo_bg.wasm": "./sorairo_bg.wasm" },
        "types": "./sorairo.d.ts",
        "files": ["LICENSE-*", "sorairo.js", "sorairo.d.ts", "sorairo_bg.wasm"],
    });
    fs::write(folder.join("package.json"), format!("{package:#}\n"))?;
    Ok(())
}

/// Compiles the module.
fn compile(root: &Path, target: &Path) -> Result<(), Box<dyn Error>> {
    let build = ["build", "--quiet", "--package", "sorairo-web", "--lib", "--profile", PROFILE];
    let compiled = other_target::cargo(root, target, TARGET)?.run(&build)?;
    if compiled { Ok(()) } else { Err("sorairo-web does not compile".into()) }
}

/// Bytes of all files of a folder, and what they are compressed.
fn sizes(folder: &Path) -> Result<(u64, u64), Box<dyn Error>> {
    let (mut raw, mut packed) = (0, 0);
    for file in fs::read_dir(folder)? {
        let bytes = fs::read(file?.path())?;
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&bytes)?;
        raw += bytes.len() as u64;
        packed += encoder.finish()?.len() as u64;
    }
    Ok((raw, packed))
}
