//! `cargo xtask web`: the page, as a folder that any server of files serves.

use std::error::Error;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use wasm_bindgen_cli_support::Bindgen;

use crate::other_target;

const TARGET: &str = "wasm32-unknown-unknown";
const PROFILE: &str = "browser";

/// Builds the module and its JavaScript, and lays them beside the files of the page.
///
/// # Errors
///
/// What is missing, or the step that failed.
pub fn build(root: &Path) -> Result<String, Box<dyn Error>> {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    compile(root, &target)?;
    let folder = target.join("web");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder)?;
    let module = target.join(TARGET).join(PROFILE).join("sorairo_web.wasm");
    let mut bindgen = Bindgen::new();
    bindgen.input_path(module).out_name("sorairo").web(true)?.typescript(false).omit_default_module_path(false);
    bindgen.remove_name_section(true).remove_producers_section(true);
    bindgen.generate(&folder)?;
    for file in fs::read_dir(root.join("host/web/page"))? {
        let file = file?;
        fs::copy(file.path(), folder.join(file.file_name()))?;
    }
    let (raw, packed) = sizes(&folder)?;
    let [raw, packed] = [raw, packed].map(|bytes| bytes as f64 / 1e6);
    Ok(format!("{}: {raw:.2} MB, {packed:.2} MB compressed with gzip", folder.display()))
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
