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

use super::place::{folder, resolved, unwritable};
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
    /// Its name, as it was asked for.
    path: PathBuf,
    /// Where it goes: what the name points at, where it is a link.
    place: PathBuf,
}

impl Staged {
    /// Moves the file to its place, where an existing one stays until this moment, and takes over that one's mode.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Write`] if it cannot be moved; nothing is left behind.
    pub fn commit(self) -> Result<()> {
        commit_all(vec![self])
    }

    fn take_place(&mut self) -> io::Result<()> {
        let file = self.file.take();
        #[cfg(unix)]
        if let Ok(existing) = self.place.metadata() {
            file.as_file().set_permissions(existing.permissions())?;
        }
        file.persist(&self.place).map(drop).map_err(|error| error.error)
    }
}

/// Moves files to their places as [`Staged::commit`] does: all of them, or none. If one cannot be moved, those that were moved before it
/// give their places back to what was there.
///
/// # Errors
///
/// [`crate::Error::Write`] for the first that cannot be moved; nothing is left behind.
pub fn commit_all(mut files: Vec<Staged>) -> Result<()> {
    let mut former: Vec<Option<Unfinished>> = Vec::new();
    // A move that fails has changed nothing itself.
    for before_another in &files[..files.len().saturating_sub(1)] {
        let kept = keep(&before_another.place).map_err(|error| unwritable(&before_another.path, &error))?;
        former.push(kept);
    }
    // A process that is told to end does so before the first of them moves, or after the last.
    let moving = unfinished();
    let moved = (0..files.len()).try_for_each(|i| files[i].take_place().map_err(|error| (i, error)));
    if let Err((failed, _)) = moved {
        for (file, former) in files[..failed].iter().zip(&mut former) {
            // What cannot be put back has no better place.
            let _ = match former {
                Some(former) => former.take().persist(&file.place).map(drop).map_err(|error| error.error),
                None => std::fs::remove_file(&file.place),
            };
        }
    }
    drop(moving);
    moved.map_err(|(failed, error)| unwritable(&files[failed].path, &error))
}

/// Another name for a file, by which it can be put back; none where there is no file.
fn keep(place: &Path) -> io::Result<Option<Unfinished>> {
    if !place.try_exists()? {
        return Ok(None);
    }
    let kept = tempfile::Builder::new().prefix(PREFIX).make_in(folder(place), |name| {
        // Not every file system has a second name for a file.
        std::fs::hard_link(place, name).or_else(|_| std::fs::copy(place, name).map(drop))?;
        File::open(name).inspect_err(|_| drop(std::fs::remove_file(name)))
    })?;
    // The lock of another program serves as well.
    let _ = kept.as_file().try_lock();
    let path = kept.path().to_owned();
    unfinished().insert(path.clone());
    Ok(Some(Unfinished { file: Some(kept), path }))
}

/// Writes a file by `write`, beside the place that `path` names.
///
/// # Errors
///
/// [`crate::Error::Write`] if anything fails; nothing is left behind.
pub fn stage(path: &Path, write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>) -> Result<Staged> {
    let attempt = || -> io::Result<Staged> {
        let place = resolved(path)?;
        let file = create(&folder(&place))?;
        let mut writer = BufWriter::with_capacity(1 << 18, file.as_file());
        write(&mut writer)?;
        writer.flush()?;
        drop(writer);
        Ok(Staged { file, path: path.to_owned(), place })
    };
    attempt().map_err(|error| unwritable(path, &error))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn staged(path: &Path) -> Staged {
        stage(path, |file| file.write_all(b"new")).unwrap()
    }

    #[test]
    fn if_one_file_cannot_take_its_place_all_places_are_as_before() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        std::fs::write(place("old"), "was here before").unwrap();
        let files = ["old", "none", "blocked", "last"].map(|name| staged(&place(name)));
        // Between the check of the names and the move.
        std::fs::create_dir(place("blocked")).unwrap();
        let error = commit_all(files.into()).unwrap_err();
        assert!(matches!(&error, crate::Error::Write { path, .. } if *path == place("blocked")), "{error}");
        let mut names: Vec<_> = folder.path().read_dir().unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names, ["blocked", "old"]);
        assert_eq!(std::fs::read_to_string(place("old")).unwrap(), "was here before");

        std::fs::remove_dir(place("blocked")).unwrap();
        commit_all(["old", "none", "blocked"].map(|name| staged(&place(name))).into()).unwrap();
        assert_eq!(folder.path().read_dir().unwrap().count(), 3);
        assert_eq!(std::fs::read_to_string(place("old")).unwrap(), "new");
    }
}
