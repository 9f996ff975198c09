//! From Python's values to a scene.

use std::collections::BTreeMap;
use std::path::Path;

use pyo3::prelude::*;
use serde::Serialize;
use serde::de::value::{BoolDeserializer, F64Deserializer, I64Deserializer, SeqDeserializer, StrDeserializer};
use sorairo::scene::file::{Draft, key};
use sorairo::scene::{Preset, ValidScene};
use sorairo::{Error, Result};

/// A value of a key.
#[derive(Clone, Debug, FromPyObject, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// True or false, which Python takes for a number too.
    Truth(bool),
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f64),
    /// A word, a file, a place or a time.
    Text(String),
    /// Wavelengths.
    Numbers(Vec<f64>),
    /// Modes of aerosol.
    Tables(Vec<BTreeMap<String, Value>>),
}

/// Keys by their dotted names.
pub type Keys = Vec<(String, Value)>;

/// A preset, under a scene file.
pub fn draft(preset: Option<&str>, file: Option<&Path>) -> Result<Draft> {
    let preset = preset.map(named_preset).transpose()?;
    match file {
        Some(path) => Draft::read(path, preset),
        None => Ok(Draft::of(preset.unwrap_or_default())),
    }
}

fn named_preset(name: &str) -> Result<Preset> {
    name.parse().map_err(|_| {
        let words: Vec<_> = sorairo::words::words::<Preset>().iter().map(|word| word.name).collect();
        Error::not_allowed("preset", format!("is {name:?}; allowed: {}", words.join(", ")))
    })
}

/// The scene of a draft under values of keys.
pub fn scene(mut draft: Draft, keys: &Keys) -> Result<ValidScene> {
    keys.iter().try_for_each(|(name, value)| lay_over(&mut draft, name, value))?;
    draft.refuse_two_suns(|key| keys.iter().any(|(name, _)| name == key))?;
    draft.validated()
}

/// A number that was meant to be an end of a range, and missed it by what rounding leaves in a long row of even steps:
/// that end.
pub fn meant(value: f64, (low, high): (f64, f64)) -> f64 {
    let slack = |end: f64| 1e-9 * end.abs().max(1.0);
    if (low - slack(low)..=high + slack(high)).contains(&value) { value.clamp(low, high) } else { value }
}

fn lay_over(draft: &mut Draft, name: &str, value: &Value) -> Result<()> {
    type Wrong = serde::de::value::Error;
    let key = key(name)?;
    let value = match (value, key.bounds(draft.scene())) {
        (Value::Number(number), Some(bounds)) => &Value::Number(meant(*number, bounds)),
        _ => value,
    };
    let set = match value {
        Value::Truth(truth) => draft.set(key, BoolDeserializer::<Wrong>::new(*truth)),
        Value::Whole(whole) => draft.set(key, I64Deserializer::<Wrong>::new(*whole)),
        Value::Number(number) => draft.set(key, F64Deserializer::<Wrong>::new(*number)),
        Value::Text(text) => draft.set(key, StrDeserializer::<Wrong>::new(text)),
        Value::Numbers(numbers) => draft.set(key, SeqDeserializer::<_, Wrong>::new(numbers.iter().copied())),
        Value::Tables(_) => {
            let tables = toml::Value::try_from(value).map_err(|error| Error::Text(error.to_string()))?;
            draft.set(key, tables)
        }
    };
    set.map_err(|error| match error {
        Error::Text(complaint) => Error::Text(format!("{name}: {complaint}")),
        other => other,
    })
}
