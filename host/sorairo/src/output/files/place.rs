//! Where files lie, and why they cannot.

use std::io;
use std::path::{Path, PathBuf};

use crate::error::Error;

/// The failure to write a file.
pub(super) fn unwritable(path: &Path, error: &io::Error) -> Error {
    Error::Write { path: path.to_owned(), reason: plain(path, error) }
}

/// Why a file cannot be begun there: a wrong request, or a file system that takes no file from anyone.
pub(super) fn refused(path: &Path, error: &io::Error) -> Error {
    use io::ErrorKind::{QuotaExceeded, ReadOnlyFilesystem, StorageFull};
    match error.kind() {
        QuotaExceeded | ReadOnlyFilesystem | StorageFull => unwritable(path, error),
        _ => Error::NotWritable { path: path.to_owned(), reason: plain(path, error) },
    }
}

/// The folder of a file.
pub(super) fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Where a file of this name is written: what it points at, where it is a link or a chain of them.
pub(super) fn resolved(path: &Path) -> io::Result<PathBuf> {
    const LONGEST_CHAIN: usize = 40;
    let mut place = path.to_owned();
    for _ in 0..LONGEST_CHAIN {
        match place.read_link() {
            Ok(target) => place = folder(&place).join(target),
            Err(_) => return Ok(place),
        }
    }
    Err(io::Error::other("it is a link that leads to itself"))
}

/// Whether a path is written as that of a folder, such as `sky.png/`.
pub(super) fn names_folder(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().as_encoded_bytes();
    name.is_empty() || !path.as_os_str().as_encoded_bytes().ends_with(name)
}

/// Why a file cannot be written, in the operating system's own words, without the temporary file's name.
pub(super) fn plain(path: &Path, error: &io::Error) -> String {
    match (error.raw_os_error(), error.kind()) {
        (Some(code), _) => io::Error::from_raw_os_error(code).to_string(),
        (None, io::ErrorKind::NotFound) if folder(path).is_dir() => "its folder takes no new files".into(),
        (None, io::ErrorKind::NotFound) => "the folder does not exist".into(),
        (None, io::ErrorKind::PermissionDenied) => "permission denied".into(),
        // A temporary file's error names it, around the system's own.
        _ => match error.get_ref().and_then(|around| around.source()?.downcast_ref()) {
            Some(within) => plain(path, within),
            None => error.to_string(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_and_a_read_only_one_are_failures_told_without_the_temporary_file() {
        #[derive(Debug, thiserror::Error)]
        #[error("{0} at path .sorairo-x")]
        struct Around(#[source] io::Error);
        let around = |code: i32| {
            let error = io::Error::from_raw_os_error(code);
            io::Error::new(error.kind(), Around(error))
        };
        // EPERM, ENOSPC and EROFS.
        for (code, is_failure) in [(1, false), (28, true), (30, true)] {
            let error = refused(Path::new("a/sky.png"), &around(code));
            assert_eq!(error.is_failure(), is_failure, "{error}");
            assert!(!error.to_string().contains(".sorairo-x"), "{error}");
        }
    }
}
