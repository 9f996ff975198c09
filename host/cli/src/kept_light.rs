//! What the frames of a sequence show of their light, kept beside them: no frame's own file holds it, and to compute it takes its time.
//!
//! It depends on the scene, the files that are asked for and the version of the program, and on nothing else. So what is kept is trusted for
//! those that it names, if no byte of it has changed. Where it is missing or not to be trusted, the light is computed as before.

use std::collections::{BTreeMap, HashSet};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use sorairo::Result;
use sorairo::low_level::files;
use sorairo::low_level::render::Shown;
use sorairo::low_level::sequence::Frame;

/// The name of the file, beside the first frame.
const NAME: &str = "light.json";

/// What is shown, by [`key`].
pub type KeptLight = BTreeMap<String, Shown>;

/// The file.
#[derive(Serialize, Deserialize)]
struct Kept {
    /// That of the light, as it stands in the file.
    checksum: String,
    light: KeptLight,
}

/// What all that a frame is asked for is known by.
///
/// # Errors
///
/// File names of no format, wavelengths that no file can hold.
pub fn key(frame: &Frame) -> Result<String> {
    Ok(checksum(&frame.request.signature(&frame.scene)?))
}

/// What is kept beside frames; nothing where there is no such file, or where it has changed.
pub fn read(path: &Path) -> KeptLight {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let kept = serde_json::from_str(&text).ok().filter(|Kept { checksum: sum, light }| *sum == checksum(&json(light)));
    kept.map(|kept| kept.light).unwrap_or_default()
}

/// Keeps more for frames, beside what other runs have kept for them meanwhile.
///
/// # Errors
///
/// Those of [`key`]; [`sorairo::Error::Write`] if the file cannot be written.
pub fn add(path: &Path, frames: &[Frame], more: KeptLight) -> Result<()> {
    let keys: HashSet<String> = frames.iter().map(key).collect::<Result<_>>()?;
    let mut light = read(path);
    light.extend(more);
    light.retain(|key, _| keys.contains(key));
    let kept = Kept { checksum: checksum(&json(&light)), light };
    files::stage(path, |file| writeln!(file, "{}", json(&kept)))?.commit()
}

/// Where it lies.
pub fn path(frames: &[Frame]) -> PathBuf {
    let first = frames.first().and_then(|frame| frame.request.outputs.first());
    first.map(|path| path.with_file_name(NAME)).unwrap_or_default()
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("light is plain data")
}

fn checksum(text: &str) -> String {
    Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
}
