//! Text files for editing: they replace an existing file only on request.

use std::io::{ErrorKind, Write};
use std::path::Path;

use super::check::check_writable;
use super::place::{folder, refused, unwritable};
use super::staged::{self, stage};
use crate::error::{Error, Result};

/// Writes a file, in the place of one that is there.
///
/// # Errors
///
/// [`Error::NotWritable`] if no file can be written there, [`Error::Write`] if it cannot be written. Then what was
/// there stays.
pub fn replace(path: &Path, text: &str) -> Result<()> {
    check_writable(path)?;
    stage(path, |file| file.write_all(text.as_bytes()))?.commit()
}

/// Writes a new file.
///
/// # Errors
///
/// [`Error::FileExists`] if there is a file or a folder of this name, [`Error::NotWritable`] if its folder does not
/// take files, [`Error::Write`] if it cannot be written. Nothing is left behind.
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
