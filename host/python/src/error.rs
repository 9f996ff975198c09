//! Errors of the library as Python's, with keys named by their parameters.

use pyo3::PyErr;
use pyo3::exceptions::{PyMemoryError, PyRuntimeError, PyValueError};
use sorairo::Error;

/// Keys of a scene and arguments of the library that parameters stand for.
const PARAMETERS: [(&str, &str); 8] = [
    ("sun.elevation", "sun_elevation"),
    ("sun.azimuth", "sun_azimuth"),
    ("sun.place", "place"),
    ("sun.time", "time"),
    ("ground.albedo", "albedo"),
    ("camera.size", "size"),
    ("view_elevation", "elevation"),
    ("view_azimuth", "azimuth"),
];

/// `ValueError` for a wrong request; `MemoryError` or `RuntimeError` for one that failed.
pub fn python(error: &Error) -> PyErr {
    let sentence = sentence(error);
    match error {
        Error::Memory(_) => PyMemoryError::new_err(sentence),
        error if error.is_failure() => PyRuntimeError::new_err(sentence),
        _ => PyValueError::new_err(sentence),
    }
}

/// The library's sentence, whose first word, where it is a key or an argument, is named by its parameter; what stands
/// in a file keeps its keys.
fn sentence(error: &Error) -> String {
    match error {
        Error::InFrame { number, error } => return format!("sun {number}: {}", self::sentence(error)),
        Error::NoSuchDevice { .. } => return format!("device {error}"),
        _ => {}
    }
    let sentence = error.to_string();
    let named = PARAMETERS.iter().find_map(|(key, parameter)| {
        let rest = sentence.strip_prefix(key).filter(|rest| rest.starts_with([' ', ':']))?;
        let key = if key.contains('.') { format!(" ({key})") } else { String::new() };
        Some(format!("{parameter}{key}{rest}"))
    });
    named.unwrap_or(sentence)
}
