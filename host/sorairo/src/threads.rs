//! The threads for all computation.

use std::error::Error as _;
use std::io;

use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};

use crate::error::{Error, Result};

/// Starts one thread per core, unless they are running. Without this call the first computation starts them, and panics
/// if the system refuses.
///
/// # Errors
///
/// [`Error::Thread`] if they cannot be started.
pub fn start() -> Result<()> {
    let failure = |error: ThreadPoolBuildError| {
        let reason = error.source()?.downcast_ref::<io::Error>()?;
        Some(reason.raw_os_error().map_or_else(|| reason.kind().into(), io::Error::from_raw_os_error))
    };
    match ThreadPoolBuilder::new().build_global().err().and_then(failure) {
        Some(error) => Err(Error::Thread(error)),
        // What failed for no reason of the system was there already.
        None => Ok(()),
    }
}
