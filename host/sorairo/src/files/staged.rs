//! Files that are written beside their place and take it when they are whole.
//!
//! A file that is being written is called `.sorairo-` and some letters, and is locked. Whatever ends the process ends the
//! lock: a file of that name without one was abandoned, and the next run removes it.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use super::place::{folder, unwritable};
use crate::error::Result;

const PREFIX: &str = ".sorairo-";

/// Files of this process that have not taken their places.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    // The set is whole after each of its own operations, whatever else panicked.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A whole file beside its place. It disappears if it is dropped before [`Staged::commit`].
#[must_use = "a file that is not committed is removed"]
pub struct Staged {
    file: Unfinished,
    path: PathBuf,
}

impl Staged {
    /// Moves the file to its place, where an existing one stays until this moment.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Write`] if it cannot be moved; nothing is left behind.
    pub fn commit(mut self) -> Result<()> {
        let file = self.file.take();
        file.persist(&self.path).map_err(|error| unwritable(&self.path, &error.error))?;
        Ok(())
    }
}

/// Writes a file by `write`, beside the place that `path` names.
///
/// # Errors
///
/// [`crate::Error::Write`] if anything fails; nothing is left behind.
pub fn stage(path: &Path, write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>) -> Result<Staged> {
    let attempt = || -> io::Result<Unfinished> {
        let file = create(&folder(path))?;
        let mut writer = BufWriter::with_capacity(1 << 18, file.as_file());
        write(&mut writer)?;
        writer.flush()?;
        drop(writer);
        Ok(file)
    };
    match attempt() {
        Ok(file) => Ok(Staged { file, path: path.to_owned() }),
        Err(error) => Err(unwritable(path, &error)),
    }
}

/// Removes every file that this process has begun and not finished, and lets it begin none after: what a process does that is told to end.
///
/// A thread that would begin a file waits from now on.
pub fn remove_unfinished() {
    let unfinished = unfinished();
    for path in unfinished.iter() {
        // What cannot be removed is removed by the next run.
        let _ = std::fs::remove_file(path);
    }
    std::mem::forget(unfinished);
}

/// Removes what processes that were killed have left in a folder.
pub(super) fn remove_abandoned(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        if !entry.file_name().to_string_lossy().starts_with(PREFIX) {
            continue;
        }
        if let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// A locked file that is removed when it is dropped.
pub(super) struct Unfinished {
    file: Option<NamedTempFile>,
    path: PathBuf,
}

impl Unfinished {
    pub(super) fn as_file(&self) -> &File {
        self.file.as_ref().expect("an unfinished file has its file").as_file()
    }

    /// Moves the file to a place where there is none.
    pub(super) fn persist_new(mut self, path: &Path) -> io::Result<()> {
        self.take().persist_noclobber(path).map(drop).map_err(|error| error.error)
    }

    fn take(&mut self) -> NamedTempFile {
        self.file.take().expect("an unfinished file has its file")
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        unfinished().remove(&self.path);
    }
}

/// A new locked file in a folder.
pub(super) fn create(folder: &Path) -> io::Result<Unfinished> {
    loop {
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // A temporary file is private by default; this one becomes an ordinary file, subject to the umask.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let mut begun = unfinished();
        let file = builder.tempfile_in(folder)?;
        let path = file.path().to_owned();
        begun.insert(path.clone());
        drop(begun);
        let unfinished = Unfinished { file: Some(file), path };
        match unfinished.as_file().lock() {
            // Without locks on this file system, nothing can be told to be abandoned.
            Err(error) if error.kind() == io::ErrorKind::Unsupported => return Ok(unfinished),
            locked => locked?,
        }
        // Between its creation and its lock another run may have taken it for abandoned.
        if unfinished.path.exists() {
            return Ok(unfinished);
        }
    }
}
