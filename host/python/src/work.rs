//! Work without Python's lock, that Python may interrupt.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use sorairo::{Error, Result};

use crate::error::python;

/// How often Python is asked whether to stop.
const PATIENCE: Duration = Duration::from_millis(50);

/// How long work may take to stop before it is left to itself: a device does within it, which must not be at work when
/// the process ends.
const GRACE: Duration = Duration::from_millis(300);

/// Whether work is to stop.
#[derive(Default)]
pub struct Stop(AtomicBool);

impl Stop {
    /// An error if it is.
    pub fn check(&self) -> Result<()> {
        if self.0.load(Ordering::Relaxed) { Err(Error::Stopped) } else { Ok(()) }
    }
}

/// Does work on a thread of its own without Python's lock, while this one listens for signals. A signal's exception is
/// raised when the work has stopped, and after [`GRACE`] all the same; the work then ends by itself where it next asks
/// whether to stop, and what it found is dropped.
pub fn work<T: Send + 'static>(py: Python<'_>, work: impl FnOnce(&Stop) -> Result<T> + Send + 'static) -> PyResult<T> {
    refuse_forked()?;
    let stop = Arc::new(Stop::default());
    let (done, outcome) = channel();
    let worker = thread::Builder::new().spawn({
        let stop = stop.clone();
        // Nobody may listen any more.
        move || drop(done.send(work(&stop)))
    });
    let worker = worker.map_err(|error| python(&Error::Thread(error)))?;
    py.detach(move || {
        loop {
            match outcome.recv_timeout(PATIENCE) {
                Ok(outcome) => return outcome.map_err(|error| python(&error)),
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(raised) = Python::attach(|py| py.check_signals()) {
                        stop.0.store(true, Ordering::Relaxed);
                        let _ = outcome.recv_timeout(GRACE);
                        return Err(raised);
                    }
                }
                Err(RecvTimeoutError::Disconnected) => {
                    let panic = worker.join().expect_err("it ended without an outcome");
                    resume_unwind(panic)
                }
            }
        }
    })
}

/// Refuses a process that was forked from one that has computed: threads and devices stay behind in the other, and work
/// would wait for them for ever.
fn refuse_forked() -> PyResult<()> {
    static COMPUTES: OnceLock<u32> = OnceLock::new();
    let process = std::process::id();
    if *COMPUTES.get_or_init(|| process) == process {
        return Ok(());
    }
    Err(PyRuntimeError::new_err(
        "sorairo computed before this process was forked, and its threads stayed behind; start processes with the method \"spawn\" or \"forkserver\"",
    ))
}
