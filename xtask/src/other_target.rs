//! Compiling for other targets than this machine.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Cargo for a target, still without a command: of the toolchain of this workspace where that has the target or rustup
/// can add it; otherwise of the nightly toolchain that `RUST_GPU_TOOLCHAIN` names, which builds std from its sources.
/// `folder` is where Cargo builds.
///
/// # Errors
///
/// What to install.
pub fn cargo(root: &Path, folder: &Path, target: &str) -> Result<Cargo, Box<dyn Error>> {
    let mut command = Command::new("cargo");
    let mut options = vec!["--target".to_owned(), target.to_owned()];
    if !has_std(root, target) && !adds_target(root, target) {
        let Ok(toolchain) = std::env::var("RUST_GPU_TOOLCHAIN") else {
            return Err(format!("the target {target} is missing: `rustup target add {target}` installs it").into());
        };
        command.arg(format!("+{toolchain}")).env("RUSTC_BOOTSTRAP", "1");
        command.env("RUSTC_WRAPPER", wrapper(&toolchain, folder)?);
        let linker_of_target = format!("CARGO_TARGET_{}_LINKER", target.to_uppercase().replace('-', "_"));
        command.env(linker_of_target, linker(root)?);
        options.push("-Zbuild-std=std,panic_abort".into());
    }
    // Cargo told this program its own toolchain.
    command.env_remove("RUSTUP_TOOLCHAIN").env_remove("CARGO").current_dir(root);
    Ok(Cargo { command, options })
}

/// Cargo for a target.
pub struct Cargo {
    command: Command,
    options: Vec<String>,
}

impl Cargo {
    /// Runs a command with its options; whether it succeeded.
    ///
    /// # Errors
    ///
    /// Where Cargo does not start.
    pub fn run(mut self, arguments: &[&str]) -> Result<bool, Box<dyn Error>> {
        Ok(self.command.args(arguments).args(self.options).status()?.success())
    }
}

/// Whether the toolchain of this workspace has std for a target.
fn has_std(root: &Path, target: &str) -> bool {
    library(root, target).is_some_and(|folder| folder.is_dir())
}

/// Lets rustup install it; whether it is there then.
fn adds_target(root: &Path, target: &str) -> bool {
    let add = Command::new("rustup").args(["target", "add", target]).current_dir(root).stderr(Stdio::null()).status();
    add.is_ok_and(|status| status.success()) && has_std(root, target)
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

/// A script that calls a compiler, and tells the crate `rustversion` its version in words that it reads: those of a
/// distribution's compiler it does not.
fn wrapper(toolchain: &str, folder: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let version = output(Command::new("rustc").args([&format!("+{toolchain}"), "--version"]))?;
    let version: Vec<_> = version.split(' ').take(2).collect();
    let script =
        format!("#!/bin/sh\nif [ -n \"$RUSTVERSION\" ]; then echo '{}'; else exec \"$@\"; fi\n", version.join(" "));
    let path = folder.join("rustc-for-other-targets.sh");
    if fs::read_to_string(&path).ok().as_deref() != Some(&script) {
        fs::create_dir_all(folder)?;
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
