//! sorairo as a Python package: the part in Rust, under the functions of `python/sorairo`.
//!
//! It turns Python's values into those of the library and arrays back, computes without Python's lock, and asks Python
//! from time to time whether to stop. It owns no physics.

mod device;
mod draft;
mod error;
mod memory;
mod sequence;
mod sky;
mod work;

use std::ffi::OsString;

use pyo3::prelude::*;

/// The part of sorairo that is written in Rust; see `_sorairo.pyi`.
#[pymodule]
mod _sorairo {
    #[pymodule_export]
    use super::device::device_name;
    #[pymodule_export]
    use super::run;
    #[pymodule_export]
    use super::sequence::sequence;
    #[pymodule_export]
    use super::sky::NativeSky;
    #[pymodule_export]
    use super::sky::sky_again;
}

/// Runs the command `sorairo` with arguments, the first of which is its own name; returns the exit code.
#[pyfunction]
fn run(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| sorairo_cli::run(arguments))
}
