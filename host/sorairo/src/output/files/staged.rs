//! Files that are written beside their place and take it when they are whole.
//!
//! A file that is being written has a name that nothing else has, and is locked. Whatever ends the process ends the
//! lock: a file of such a name without one was abandoned, and the next run removes it.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use super::place::{folder, resolved, unwritable};
use crate::error::{Error, Result};

/// How names of unfinished files begin. The digits are random, so that no one else's file begins like this.
const PREFIX: &str = ".sorairo-unfinished-93fd04c58be1a276-";

/// Random letters and digits that follow, so many.
const RANDOM: usize = 6;

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

/// Moves files to their places as [`Staged::commit`] does: all of them, or none. If one cannot be moved, those that
/// were moved before it give their places back to what was there.
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
    let mut begun = unfinished();
    let kept = builder().make_in(folder(place), |name| {
        // Not every file system has a second name for a file.
        std::fs::hard_link(place, name).or_else(|_| std::fs::copy(place, name).map(drop))?;
        File::open(name).inspect_err(|_| drop(std::fs::remove_file(name)))
    })?;
    // The lock of another program serves as well.
    let _ = kept.as_file().try_lock();
    let path = kept.path().to_owned();
    begun.insert(path.clone());
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
    // What an encoder refuses is its own sentence.
    attempt().map_err(|error| error.downcast::<Error>().unwrap_or_else(|error| unwritable(path, &error)))
}

/// While it lives, no thread of the process begins a file or moves one to its place.
pub struct Standstill(#[expect(dead_code, reason = "it is held")] MutexGuard<'static, BTreeSet<PathBuf>>);

/// Removes every file that this process has begun and not finished. Its renders that still run fail, with their places
/// as they were; later ones write again once the standstill is dropped. A process that ends keeps it until it has
/// ended.
pub fn remove_unfinished() -> Standstill {
    let unfinished = unfinished();
    for path in unfinished.iter() {
        // What cannot be removed is removed by the next run.
        let _ = std::fs::remove_file(path);
    }
    Standstill(unfinished)
}

/// Removes what processes that were killed have left in a folder, and touches nothing else.
pub(super) fn remove_abandoned(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !(is_file && is_unfinished(&entry.file_name())) {
            continue;
        }
        if let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Whether a file name is that of an unfinished file.
fn is_unfinished(name: &OsStr) -> bool {
    let random = name.to_str().and_then(|name| name.strip_prefix(PREFIX));
    random.is_some_and(|random| random.len() == RANDOM && random.bytes().all(|byte| byte.is_ascii_alphanumeric()))
}

fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).rand_bytes(RANDOM);
    builder
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
        #[cfg_attr(not(unix), expect(unused_mut, reason = "Unix alone has modes"))]
        let mut builder = builder();
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

    /// One process has one set of unfinished files.
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

    fn alone() -> MutexGuard<'static, ()> {
        ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner)
    }

    #[test]
    fn a_process_that_gave_up_its_files_writes_again() {
        let _alone = alone();
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        std::fs::write(place("old"), "was here before").unwrap();
        let given_up = staged(&place("given up"));
        let _ = remove_unfinished();
        assert_eq!(names(folder.path()), ["old"]);

        let (later, written) = (place("old"), std::sync::mpsc::channel());
        let writing = std::thread::spawn(move || {
            // What was given up takes its partner with it.
            let both = commit_all(vec![staged(&later), given_up]);
            let _ = written.0.send((both, staged(&later).commit()));
        });
        let limit = std::time::Duration::from_secs(20);
        let (both, again) = written.1.recv_timeout(limit).expect("a writer of a process that gave up hangs");
        writing.join().unwrap();
        assert!(matches!(&both, Err(crate::Error::Write { path, .. }) if *path == place("given up")), "{both:?}");
        again.unwrap();
        assert_eq!(names(folder.path()), ["old"]);
        assert_eq!(std::fs::read_to_string(place("old")).unwrap(), "new");
    }

    #[test]
    fn nothing_is_begun_while_a_process_stands_still() {
        let _alone = alone();
        let folder = tempfile::tempdir().unwrap();
        let still = remove_unfinished();
        let path = folder.path().join("later");
        let writing = std::thread::spawn(move || staged(&path).commit());
        std::thread::sleep(std::time::Duration::from_millis(50));
        assert!(names(folder.path()).is_empty());
        drop(still);
        writing.join().unwrap().unwrap();
        assert_eq!(names(folder.path()), ["later"]);
    }

    #[test]
    fn only_abandoned_files_of_this_program_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let abandoned = format!("{PREFIX}aZ09bY");
        let kept = [".sorairo-x", ".sorairo-abcdef", &format!("{PREFIX}aZ09b"), &format!("{PREFIX}a.09bY")];
        for name in kept.iter().copied().chain([abandoned.as_str()]) {
            std::fs::write(folder.path().join(name), "somebody's").unwrap();
        }
        let of_a_folder = format!("{PREFIX}folder");
        std::fs::create_dir(folder.path().join(&of_a_folder)).unwrap();
        remove_abandoned(folder.path());
        let mut expected: Vec<&str> = kept.into_iter().chain([of_a_folder.as_str()]).collect();
        expected.sort_unstable();
        assert_eq!(names(folder.path()), expected);
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = folder.read_dir().unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn if_one_file_cannot_take_its_place_all_places_are_as_before() {
        let _alone = alone();
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        std::fs::write(place("old"), "was here before").unwrap();
        let files = ["old", "none", "blocked", "last"].map(|name| staged(&place(name)));
        // Between the check of the names and the move.
        std::fs::create_dir(place("blocked")).unwrap();
        let error = commit_all(files.into()).unwrap_err();
        assert!(matches!(&error, crate::Error::Write { path, .. } if *path == place("blocked")), "{error}");
        assert_eq!(names(folder.path()), ["blocked", "old"]);
        assert_eq!(std::fs::read_to_string(place("old")).unwrap(), "was here before");

        std::fs::remove_dir(place("blocked")).unwrap();
        commit_all(["old", "none", "blocked"].map(|name| staged(&place(name))).into()).unwrap();
        assert_eq!(folder.path().read_dir().unwrap().count(), 3);
        assert_eq!(std::fs::read_to_string(place("old")).unwrap(), "new");
    }
}
