//! Text files that a person goes on to edit: never over an existing file.

use std::io::{ErrorKind, Write};
use std::path::Path;

use super::place::{folder, refused, unwritable};
use super::staged;
use crate::error::{Error, Result};

/// Writes a new file.
///
/// # Errors
///
/// [`Error::FileExists`] if there is a file or a folder of this name, [`Error::NotWritable`] if its folder does not take files,
/// [`Error::Write`] if it cannot be written. Nothing is left behind.
pub fn create(path: &Path, text: &str) -> Result<()> {
    let exists = || Error::FileExists { path: path.to_owned() };
    if path.symlink_metadata().is_ok() {
        return Err(exists());
    }
    let file = staged::create(&folder(path)).map_err(|error| refused(path, &error))?;
    file.as_file().write_all(text.as_bytes()).map_err(|error| unwritable(path, &error))?;
    match file.persist_new(path) {
        Ok(()) => Ok(()),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Err(exists()),
        Err(error) => Err(unwritable(path, &error)),
    }
}
