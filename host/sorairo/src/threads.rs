//! The threads on which all computing is done.

use std::error::Error as _;
use std::io;

use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};

use crate::error::{Error, Result};

/// Starts them, one for each core, if they are not there yet. Otherwise they are started by the first computation,
/// which panics where the system lets the process have none.
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
