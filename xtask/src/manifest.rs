//! The manifest of the compiled shaders: what they were compiled from, and by what. Shared with the tests.

use std::io;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

/// Where the compiled shaders lie, from the root of the repository.
pub const COMPILED: &str = "shader-crate/compiled";

/// The SHA-256 of every source that the shaders are compiled from, in hexadecimal: names and contents of the manifests
/// and source files of `shared` and `shader-crate`. The compiler and its libraries are pinned to one version.
///
/// # Errors
///
/// Any error of reading the files.
pub fn source_hash(root: &Path) -> io::Result<String> {
    let mut files = vec![PathBuf::from("shared/Cargo.toml"), PathBuf::from("shader-crate/Cargo.toml")];
    let mut folders = vec![PathBuf::from("shared/src"), PathBuf::from("shader-crate/src")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(root.join(&folder))? {
            let entry = entry?;
            let found = if entry.file_type()?.is_dir() { &mut folders } else { &mut files };
            found.push(folder.join(entry.file_name()));
        }
    }
    files.sort();
    let mut hash = Sha256::new();
    for file in files {
        let contents = std::fs::read(root.join(&file))?;
        hash.update(file.to_string_lossy().replace('\\', "/").as_bytes());
        hash.update((contents.len() as u64).to_le_bytes());
        hash.update(contents);
    }
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}
