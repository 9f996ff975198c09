//! What is known of a sequence's files without reading them.
//!
//! A task that a farm runs again when all is done would otherwise read every frame of all other tasks. Two things are
//! trusted in place of that, and nothing else:
//!
//! * **The contact sheet**, which is written when every frame was found whole, and says of what it was made, with the
//!   checksum of the manifest. A sheet of other scenes, tables, wavelengths, names or of another version proves
//!   nothing.
//! * **The times of change** that the file system keeps (`ctime`). Whatever is written to a file, moved into its place
//!   or done to its attributes sets its own to the clock. The time of modification is not trusted: copying and
//!   unpacking programs set it back.
//!
//! A frame that changed after the sheet is read, with all others. Where a system has no such times every frame is read.
//! What goes unnoticed is a medium that decays, and a change while the clock stands before the sheet's: `rm` the sheet,
//! and every byte counts again.

use std::io;
use std::path::Path;

use sha2::{Digest, Sha256};
use sorairo::Result;
use sorairo::sequence::Frame;

use crate::cases::Cases;
use crate::contact_sheet;
use crate::manifest;

/// A checksum over all that is asked of a sequence's files.
///
/// # Errors
///
/// File names of no format, wavelengths that no file can hold.
pub fn made_of(frames: &[Frame], cases: Option<&Cases>) -> Result<String> {
    let mut sum = Sha256::new();
    // Each part ends where no text can.
    let mut add = |part: &[u8]| sum.update([part, &[0xff]].concat());
    for frame in frames {
        add(frame.request.signature(&frame.scene)?.as_bytes());
        for output in frame.request.files() {
            let beside = frames.first().and_then(|first| first.request.outputs.first()?.parent());
            let name = beside.and_then(|folder| output.strip_prefix(folder).ok()).unwrap_or(&output);
            add(name.as_os_str().as_encoded_bytes());
        }
    }
    // The manifest repeats them as they stand there.
    if let Some(cases) = cases {
        cases.keys.iter().for_each(|key| add(key.name.as_bytes()));
        cases.cells().flatten().for_each(|cell| add(cell.as_bytes()));
    }
    Ok(manifest::hexadecimal(sum))
}

/// What a sheet notes: of what it was made, and the checksum of the manifest that was written with it.
pub fn note(made_of: &str, manifest: Option<&str>) -> String {
    manifest.map_or_else(|| made_of.to_owned(), |checksum| format!("{made_of} {checksum}"))
}

/// The checksum of the manifest that a sheet notes.
pub fn noted_manifest(sheet: &Path) -> Option<String> {
    contact_sheet::made_of(sheet)?.split_once(' ').map(|(_, checksum)| checksum.to_owned())
}

/// Whether all frames are known to be whole: the sheet was made of them, the manifest is the one that was written with
/// it, and no frame has changed since.
pub fn are_whole(frames: &[Frame], made_of: &str, sheet: &Path, manifest: Option<&Path>) -> bool {
    let checksum = manifest.map(manifest::checksum).transpose();
    let is_noted =
        checksum.is_ok_and(|checksum| contact_sheet::made_of(sheet) == Some(note(made_of, checksum.as_deref())));
    if !is_noted {
        return false;
    }
    let beside = [Some(sheet), manifest].into_iter().flatten().map(changed);
    let Ok(Some(oldest)) = beside.collect::<io::Result<Vec<_>>>().map(|times| times.into_iter().min()) else {
        return false;
    };
    // A file of the same instant may have changed after it.
    let mut files = frames.iter().flat_map(|frame| frame.request.files());
    files.all(|file| changed(&file).is_ok_and(|time| time < oldest))
}

/// When a file last changed in any way (s, ns).
#[cfg(unix)]
fn changed(file: &Path) -> io::Result<(i64, i64)> {
    use std::os::unix::fs::MetadataExt as _;
    file.metadata().map(|file| (file.ctime(), file.ctime_nsec()))
}

/// When a file last changed in any way, which is not known here.
#[cfg(not(unix))]
fn changed(_: &Path) -> io::Result<(i64, i64)> {
    Err(io::ErrorKind::Unsupported.into())
}
