//! Where files lie, and why they cannot.

use std::path::{Path, PathBuf};

use crate::error::Error;

/// The failure to write a file.
pub(super) fn unwritable(path: &Path, error: &std::io::Error) -> Error {
    Error::Write { path: path.to_owned(), reason: plain(path, error) }
}

/// The folder of a file.
pub(super) fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Why a file cannot be written, in the operating system's own words, without the temporary file's name.
pub(super) fn plain(path: &Path, error: &std::io::Error) -> String {
    match (error.raw_os_error(), error.kind()) {
        (Some(code), _) => std::io::Error::from_raw_os_error(code).to_string(),
        (None, std::io::ErrorKind::NotFound) if folder(path).is_dir() => "its folder takes no new files".into(),
        (None, std::io::ErrorKind::NotFound) => "the folder does not exist".into(),
        (None, std::io::ErrorKind::PermissionDenied) => "permission denied".into(),
        _ => error.to_string(),
    }
}
