//! Work without Python's lock, that Python may interrupt.

use std::panic::resume_unwind;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use sorairo::{Error, Result};

use crate::error::python;

/// How often Python is asked whether to stop.
const PATIENCE: Duration = Duration::from_millis(50);

/// Whether work is to stop.
#[derive(Default)]
pub struct Stop(AtomicBool);

impl Stop {
    /// An error if it is.
    pub fn check(&self) -> Result<()> {
        if self.0.load(Ordering::Relaxed) { Err(Error::Stopped) } else { Ok(()) }
    }
}

/// Does work on a thread of its own without Python's lock, while this one listens for signals. A signal's exception is raised once the work
/// has stopped.
pub fn work<T: Send>(py: Python<'_>, work: impl FnOnce(&Stop) -> Result<T> + Send) -> PyResult<T> {
    refuse_forked()?;
    let stop = Stop::default();
    let (outcome, signal) = py.detach(|| {
        thread::scope(|scope| {
            let (ended, listening) = channel::<()>();
            let stop = &stop;
            let worker = scope.spawn(move || {
                let outcome = work(stop);
                drop(ended);
                outcome
            });
            let mut signal = None;
            while listening.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                if signal.is_none()
                    && let Err(raised) = Python::attach(|py| py.check_signals())
                {
                    stop.0.store(true, Ordering::Relaxed);
                    signal = Some(raised);
                }
            }
            (worker.join().unwrap_or_else(|panic| resume_unwind(panic)), signal)
        })
    });
    match signal {
        Some(raised) => Err(raised),
        None => outcome.map_err(|error| python(&error)),
    }
}

/// Refuses a process that was forked from one that has computed: threads and devices stay behind in the other, and work would wait for
/// them for ever.
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
