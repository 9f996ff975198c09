//! Text files that a person goes on to edit: never over an existing file.

use std::io::{ErrorKind, Write};
use std::path::Path;

use super::place::{folder, plain};
use super::staged;
use crate::error::{Error, Result};

/// Writes a new file.
///
/// # Errors
///
/// [`Error::Request`] if there is a file or a folder of this name, or its folder does not take files; [`Error::Failure`] if it
/// cannot be written. Nothing is left behind.
pub fn create(path: &Path, text: &str) -> Result<()> {
    let name = path.display();
    let exists = || Error::request(format!("{name} exists; choose another name, or move it away"));
    if path.symlink_metadata().is_ok() {
        return Err(exists());
    }
    let unwritable = |error: &std::io::Error| format!("{name} cannot be written: {}", plain(error));
    let file = staged::create(&folder(path)).map_err(|error| Error::request(unwritable(&error)))?;
    file.as_file().write_all(text.as_bytes()).map_err(|error| Error::failure(unwritable(&error)))?;
    match file.persist_new(path) {
        Ok(()) => Ok(()),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Err(exists()),
        Err(error) => Err(Error::failure(unwritable(&error))),
    }
}
