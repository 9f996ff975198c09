//! `cargo xtask web`: the page, as a folder that any server of files serves.

use std::error::Error;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use flate2::Compression;
use flate2::write::GzEncoder;
use wasm_bindgen_cli_support::Bindgen;

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

/// Compiles the module: by the toolchain of this workspace where its target is installed or can be; otherwise by the nightly toolchain that
/// `RUST_GPU_TOOLCHAIN` names, which builds std from its sources.
fn compile(root: &Path, target: &Path) -> Result<(), Box<dyn Error>> {
    let mut cargo = Command::new("cargo");
    let build = ["build", "--quiet", "--package", "sorairo-web", "--lib", "--profile", PROFILE, "--target", TARGET];
    if has_std(root) || adds_target(root) {
        cargo.args(build);
    } else if let Ok(toolchain) = std::env::var("RUST_GPU_TOOLCHAIN") {
        cargo.arg(format!("+{toolchain}")).args(build).arg("-Zbuild-std=std,panic_abort");
        cargo.env("RUSTC_BOOTSTRAP", "1").env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", linker(root)?);
        cargo.env("RUSTC_WRAPPER", wrapper(&toolchain, target)?);
    } else {
        return Err(format!("the target {TARGET} is missing: `rustup target add {TARGET}` installs it").into());
    }
    // Cargo told this program its own toolchain.
    cargo.env_remove("RUSTUP_TOOLCHAIN").env_remove("CARGO").current_dir(root);
    if cargo.status()?.success() { Ok(()) } else { Err("sorairo-web does not compile".into()) }
}

/// Whether the toolchain of this workspace has std for the browser.
fn has_std(root: &Path) -> bool {
    library(root, TARGET).is_some_and(|folder| folder.is_dir())
}

/// Lets rustup install it; whether it is there then.
fn adds_target(root: &Path) -> bool {
    let add = Command::new("rustup").args(["target", "add", TARGET]).current_dir(root).stderr(Stdio::null()).status();
    add.is_ok_and(|status| status.success()) && has_std(root)
}

/// The folder of a target in the toolchain of this workspace.
fn library(root: &Path, target: &str) -> Option<PathBuf> {
    let found = output(Command::new("rustc").args(["--print", "sysroot"]).current_dir(root)).ok()?;
    Some(Path::new(&found).join("lib/rustlib").join(target).join("lib"))
}

/// The linker that comes with the toolchain of this workspace, for one that has none.
fn linker(root: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let host = output(Command::new("rustc").args(["--print", "host-tuple"]).current_dir(root))?;
    let linker = library(root, &host).ok_or("rustc names no folder")?.with_file_name("bin/rust-lld");
    if linker.is_file() { Ok(linker) } else { Err(format!("{} is missing", linker.display()).into()) }
}

/// A script that calls a compiler, and tells the crate `rustversion` its version in words that it reads: those of a distribution's compiler it
/// does not.
fn wrapper(toolchain: &str, target: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let version = output(Command::new("rustc").args([&format!("+{toolchain}"), "--version"]))?;
    let version: Vec<_> = version.split(' ').take(2).collect();
    let script =
        format!("#!/bin/sh\nif [ -n \"$RUSTVERSION\" ]; then echo '{}'; else exec \"$@\"; fi\n", version.join(" "));
    let path = target.join("rustc-for-web.sh");
    if fs::read_to_string(&path).ok().as_deref() != Some(&script) {
        fs::create_dir_all(target)?;
        fs::write(&path, script)?;
        #[cfg(unix)]
        fs::set_permissions(&path, std::os::unix::fs::PermissionsExt::from_mode(0o755))?;
    }
    Ok(path)
}

/// What a command prints, in a line.
fn output(command: &mut Command) -> Result<String, Box<dyn Error>> {
    // Cargo told this program its own toolchain.
    let output = command.env_remove("RUSTUP_TOOLCHAIN").output()?;
    if !output.status.success() {
        return Err(format!("{command:?} failed").into());
    }
    Ok(String::from_utf8(output.stdout)?.trim().to_owned())
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
