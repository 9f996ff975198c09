//! `cargo xtask package`: proves that the packages of the crates, and nothing else of the repository, give a working
//! command.
//!
//! They are packed, unpacked into a folder of their own, and the command is installed from there; then it renders a
//! picture in an empty folder. Where a crate of ours is asked of crates.io, the unpacked one answers.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Packs, installs and runs.
///
/// # Errors
///
/// A step that fails, by its command line.
pub fn check(root: &Path) -> Result<String, Box<dyn Error>> {
    let target = root.join("target");
    let packed = target.join("package");
    let _ = fs::remove_dir_all(&packed);
    let left_out = ["sorairo-python", "sorairo-tests", "xtask"].into_iter().flat_map(|name| ["--exclude", name]);
    let pack = ["package", "--quiet", "--workspace", "--no-verify", "--allow-dirty"];
    run(Command::new("cargo").args(pack).args(left_out).current_dir(root))?;
    // Elsewhere, so that the packages are no part of this workspace.
    let folder = std::env::temp_dir().join(format!("sorairo-packages-{}", std::process::id()));
    let installed = install(&unpack(&packed, &folder)?, &folder, &target);
    let _ = fs::remove_dir_all(&folder);
    installed
}

/// Installs the command from unpacked packages in a folder, and renders with it in an empty one.
fn install(crates: &[String], folder: &Path, target: &Path) -> Result<String, Box<dyn Error>> {
    let command = crates.iter().find(|name| name.starts_with("sorairo-cli-")).ok_or("no package of the command")?;
    let install = ["install", "--quiet", "--path", command, "--root", "installed"];
    run(Command::new("cargo").args(install).env("CARGO_TARGET_DIR", target.join("packaged")).current_dir(folder))?;
    let empty = folder.join("empty");
    fs::create_dir(&empty)?;
    let render = ["render", "--device", "cpu", "--size", "64x32", "-o", "sky.png"];
    run(Command::new(folder.join("installed/bin/sorairo")).args(render).current_dir(&empty))?;
    Ok(format!("{} packages give a command that renders", crates.len()))
}

/// Unpacks every package into a folder, and writes there that they stand for those of crates.io; returns their names
/// and versions.
fn unpack(packed: &Path, folder: &Path) -> Result<Vec<String>, Box<dyn Error>> {
    fs::create_dir_all(folder.join(".cargo"))?;
    let mut crates = Vec::new();
    let mut patch = "[patch.crates-io]\n".to_owned();
    for entry in fs::read_dir(packed)? {
        let package = entry?.path();
        if package.extension().is_some_and(|extension| extension == "crate") {
            run(Command::new("tar").arg("-xf").arg(&package).current_dir(folder))?;
            let folder = package.file_stem().map(PathBuf::from).ok_or("a package has a name")?.display().to_string();
            let (name, _) = folder.rsplit_once('-').ok_or("a package has a version")?;
            writeln!(patch, "{name} = {{ path = \"{folder}\" }}")?;
            crates.push(folder);
        }
    }
    fs::write(folder.join(".cargo/config.toml"), patch)?;
    Ok(crates)
}

fn run(command: &mut Command) -> Result<(), Box<dyn Error>> {
    if command.status()?.success() { Ok(()) } else { Err(format!("{command:?} failed").into()) }
}
