//! Values of keys, as flags and tables say them: how they are read, and laid over a scene.

use std::path::Path;

use serde::de::value::{BoolDeserializer, F64Deserializer, SeqDeserializer, StrDeserializer, U32Deserializer};
use sorairo::scene::file::Draft;
use sorairo::scene::keys::{self, Key};
use sorairo::scene::place::Time;
use sorairo::scene::{Exposure, Preset, Shutter, ValidScene};

use crate::ranges::{self, Numbers};

/// Reads the text of a flag, or says what is allowed.
pub type Read = fn(&str) -> Result<Given, String>;

/// What a flag gives to its key.
#[derive(Clone, Debug)]
pub enum Given {
    Truth(bool),
    Number(f64),
    Count(u32),
    Numbers(Numbers),
    Text(String),
    /// An optical depth of aerosol and its wavelength (nm).
    DepthAt(f64, f64),
    /// A file of AERONET, and which of its rows.
    Aeronet(String),
    /// How far one sees (km).
    Visibility(f64),
    /// A value of a table, which has no kind of its own.
    Cell(String),
}

/// The value of a key.
#[derive(Clone, Debug)]
pub struct Value {
    /// The key.
    pub key: &'static str,
    /// How it was said: a flag, with its dashes, or a column of a table.
    pub said: &'static str,
    /// What was said.
    pub given: Given,
}

/// Values of keys that flags give.
#[derive(Clone, Debug, Default)]
pub struct Values(Vec<Value>);

impl FromIterator<Value> for Values {
    fn from_iter<I: IntoIterator<Item = Value>>(values: I) -> Self {
        Self(values.into_iter().collect())
    }
}

impl Values {
    /// The preset, under a scene file.
    pub fn draft(&self, file: Option<&Path>) -> sorairo::Result<Draft> {
        match file {
            Some(path) => Draft::read(path, self.preset()),
            None => Ok(Draft::of(self.preset().unwrap_or_default())),
        }
    }

    /// A draft under these values.
    pub fn over(&self, mut draft: Draft) -> sorairo::Result<ValidScene> {
        self.lay_over(&mut draft)?;
        draft.validated()
    }

    /// The preset, if it is given.
    fn preset(&self) -> Option<Preset> {
        self.0.iter().find_map(|value| match &value.given {
            Given::Text(name) if value.key == "preset" => name.parse().ok(),
            _ => None,
        })
    }

    /// Whether a key is given.
    pub fn has(&self, key: &str) -> bool {
        self.0.iter().any(|value| value.key == key)
    }

    /// These values and an elevation of the sun.
    pub fn with_elevation(&self, elevation: f64) -> Self {
        self.with("sun.elevation", "--sun-elevation", Given::Number(elevation))
    }

    /// These values and a time.
    pub fn with_time(&self, time: Time) -> Self {
        self.with("sun.time", "--time", Given::Text(time.to_string()))
    }

    /// These values and an exposure.
    pub fn with_exposure(&self, exposure: Exposure) -> Self {
        let given = match exposure {
            Exposure::Stops(stops) => Given::Number(stops),
            Exposure::Adapt => Given::Text("adapt".into()),
            _ => Given::Text("auto".into()),
        };
        self.with("render.exposure", "--exposure", given)
    }

    /// Those of a table's row, by their keys, and these values of all other keys.
    pub fn with_cells<'a>(&self, cells: impl Iterator<Item = (&'static str, &'a str)>) -> Self {
        let cells = cells.map(|(key, text)| Value { key, said: key, given: Given::Cell(text.to_owned()) });
        let cells: Vec<_> = cells.collect();
        let is_other = |value: &&Value| cells.iter().all(|cell| cell.key != value.key);
        self.0.iter().filter(is_other).cloned().chain(cells.iter().cloned()).collect()
    }

    fn with(&self, key: &'static str, said: &'static str, given: Given) -> Self {
        let mut values = self.clone();
        values.0.push(Value { key, said, given });
        values
    }

    /// Lays the values over a scene: first what takes the place of several keys, last what follows from others.
    fn lay_over(&self, draft: &mut Draft) -> sorairo::Result<()> {
        let given = || self.0.iter().filter(|value| value.key != "preset");
        let follows = |value: &&Value| matches!(value.given, Given::DepthAt(..) | Given::Visibility(_));
        let leads = |value: &&Value| matches!(value.given, Given::Aeronet(_));
        given().filter(leads).try_for_each(|value| value.lay_over(draft))?;
        given().filter(|value| !leads(value) && !follows(value)).try_for_each(|value| value.lay_over(draft))?;
        given().filter(follows).try_for_each(|value| value.lay_over(draft))?;
        draft.refuse_two_suns(|key| self.has(key))
    }
}

impl Value {
    fn lay_over(&self, draft: &mut Draft) -> sorairo::Result<()> {
        type Error = serde::de::value::Error;
        let key = keys::find(self.key).expect("the key of a value");
        let set = match &self.given {
            Given::Truth(truth) => draft.set(key, BoolDeserializer::<Error>::new(*truth)),
            Given::Number(number) => draft.set(key, F64Deserializer::<Error>::new(*number)),
            Given::Count(count) => draft.set(key, U32Deserializer::<Error>::new(*count)),
            Given::Numbers(numbers) => draft.set(key, SeqDeserializer::<_, Error>::new(numbers.iter().copied())),
            Given::Text(text) => draft.set(key, StrDeserializer::<Error>::new(text)),
            Given::DepthAt(depth, wavelength) => {
                let depth = draft.scene().optical_depth_from(*depth, *wavelength);
                draft.set(key, F64Deserializer::<Error>::new(depth))
            }
            Given::Aeronet(file) => {
                let modes = keys::find("atmosphere.aerosol.modes").expect("a key");
                draft.set(modes, serde_json::json!([{ "aeronet": file }]))
            }
            Given::Visibility(distance) => {
                let depth = draft.scene().optical_depth_from_visibility(*distance)?;
                draft.set(key, F64Deserializer::<Error>::new(depth))
            }
            Given::Cell(text) => set_cell(draft, key, text),
        };
        set.map_err(|error| match error {
            sorairo::Error::Text(complaint) => sorairo::Error::Text(format!("{}: {complaint}", self.said)),
            other => other,
        })
    }
}

/// Takes the value of a table as the first kind that the key is: wavelengths, a whole number, a number, true or false,
/// text.
fn set_cell(draft: &mut Draft, key: &'static Key, text: &str) -> sorairo::Result<()> {
    type Error = serde::de::value::Error;
    if key.name == "render.bands" {
        let list = text.strip_prefix('[').and_then(|text| text.strip_suffix(']')).unwrap_or(text);
        let numbers = ranges::wavelengths(list).map_err(sorairo::Error::Text)?;
        return draft.set(key, SeqDeserializer::<_, Error>::new(numbers.iter().copied()));
    }
    let is_set = whole(text).is_some_and(|count| draft.set(key, U32Deserializer::<Error>::new(count)).is_ok())
        || text.parse().is_ok_and(|number| draft.set(key, F64Deserializer::<Error>::new(number)).is_ok())
        || text.to_lowercase().parse().is_ok_and(|truth| draft.set(key, BoolDeserializer::<Error>::new(truth)).is_ok());
    if is_set { Ok(()) } else { draft.set(key, StrDeserializer::<Error>::new(key.word_or(text))) }
}

/// A whole number, which some programs write as 16.0.
fn whole(text: &str) -> Option<u32> {
    let number: f64 = text.parse().ok()?;
    let is_count = number.fract() == 0.0 && number.is_sign_positive() && number <= f64::from(u32::MAX);
    is_count.then_some(number as u32)
}

pub fn number(text: &str) -> Result<Given, String> {
    text.parse().map(Given::Number).map_err(|_| "a number is wanted, such as 12.5".into())
}

pub fn water(text: &str) -> Result<Given, String> {
    let column = text.strip_suffix("cm").unwrap_or(text).trim_end();
    column.parse().map(Given::Number).map_err(|_| "a column in cm is wanted, such as 1.4cm".into())
}

pub fn steps(text: &str) -> Result<Given, String> {
    let range = || keys::find("render.steps").map(Key::range).unwrap_or_default();
    text.parse().map(Given::Count).map_err(|_| format!("a whole number from {} is wanted", range()))
}

pub fn wavelengths(text: &str) -> Result<Given, String> {
    ranges::wavelengths(text).map(Given::Numbers)
}

pub fn exposure(text: &str) -> Result<Given, String> {
    text.parse().map(|exposure| match exposure {
        Exposure::Stops(stops) => Given::Number(stops),
        _ => Given::Text(text.to_lowercase()),
    })
}

pub fn shutter(text: &str) -> Result<Given, String> {
    text.parse().map(|Shutter(seconds)| Given::Number(seconds))
}

/// An optical depth and its wavelength in nm, as in `0.2@500`, or a file of AERONET, as in `aeronet:site.pfn`.
pub fn depth_at(text: &str) -> Result<Given, String> {
    if let Some(file) = text.strip_prefix("aeronet:") {
        return Ok(Given::Aeronet(file.into()));
    }
    let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    let pair = text.split_once('@').and_then(|(depth, wavelength)| Some((number(depth)?, number(wavelength)?)));
    pair.filter(|(depth, wavelength)| *depth >= 0.0 && (300.0..=3000.0).contains(wavelength))
        .map(|(depth, wavelength)| Given::DepthAt(depth, wavelength))
        .ok_or_else(|| {
            "an optical depth of 0 or more and a wavelength from 300 to 3000 nm are wanted, such as 0.2@500, or aeronet:FILE"
                .into()
        })
}

pub fn visibility(text: &str) -> Result<Given, String> {
    text.parse().map(Given::Visibility).map_err(|_| "a distance in km is wanted, such as 23".into())
}

pub fn orders(text: &str) -> Result<Given, String> {
    if text.eq_ignore_ascii_case("all") {
        return Ok(Given::Text(text.to_lowercase()));
    }
    let range = || keys::find("render.orders").map(Key::range).unwrap_or_default();
    text.parse().map(Given::Count).map_err(|_| format!("a whole number or `all` is wanted: {}", range()))
}

/// An albedo is a number, a surface or a table; which ones there are, its key says.
pub fn albedo(text: &str) -> Result<Given, String> {
    let key = keys::find("ground.albedo").expect("a key");
    Ok(text.parse().map_or_else(|_| Given::Text(key.word_or(text).to_owned()), Given::Number))
}

/// Reads a text that says a value of a type.
pub fn text_of<T: std::str::FromStr<Err = String>>(text: &str) -> Result<Given, String> {
    text.parse::<T>().map(|_| Given::Text(text.into()))
}
