//! Devices, each opened once in a process.

use std::collections::HashMap;
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;
use sorairo::{Device, Result};

use crate::work::work;

static DEVICES: LazyLock<Mutex<HashMap<String, Device>>> = LazyLock::new(Mutex::default);

/// What is done with a device, one caller after the other.
pub fn with<T>(choice: &str, act: impl FnOnce(&mut Device) -> Result<T>) -> Result<T> {
    // A device after a panic is as good as before: it keeps pipelines and buffers alone.
    let mut devices: MutexGuard<'_, _> = DEVICES.lock().unwrap_or_else(PoisonError::into_inner);
    if !devices.contains_key(choice) {
        devices.insert(choice.to_owned(), Device::open(choice)?);
    }
    act(devices.get_mut(choice).expect("it was opened"))
}

/// The name of the device that `choice` stands for.
#[pyfunction]
pub fn device_name(py: Python<'_>, choice: String) -> PyResult<String> {
    work(py, move |_| with(&choice, |device| Ok(device.name.clone())))
}
