//! `cargo xtask platforms`: the program compiles where other graphics interfaces are, which no test here can run. Its
//! window, a fifth of the crates, is compiled there by `.github/workflows`.

use std::error::Error;
use std::path::{Path, PathBuf};

use crate::other_target;

/// Targets, and the interface that is compiled there beside Vulkan or in its place.
const PLATFORMS: [(&str, &str); 2] = [("x86_64-pc-windows-msvc", "Direct3D 12"), ("aarch64-apple-darwin", "Metal")];

/// Checks the program for every platform, as far as a compiler does without a linker.
///
/// # Errors
///
/// What is missing, or the platform for which it does not compile.
pub fn check(root: &Path) -> Result<String, Box<dyn Error>> {
    let folder = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    for (target, interface) in PLATFORMS {
        let check = ["check", "--quiet", "--package", "sorairo-cli", "--features", "evaluation"];
        if !other_target::cargo(root, &folder, target)?.run(&check)? {
            return Err(format!("the program does not compile for {target} ({interface})").into());
        }
    }
    let names = PLATFORMS.map(|(target, interface)| format!("{target} ({interface})"));
    Ok(format!("the program compiles for {}", names.join(" and ")))
}
