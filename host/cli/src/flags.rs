//! Flags that take the place of keys of a scene, each a row: its key says what it means, its help and what it may be.

use std::path::Path;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use serde::de::value::{BoolDeserializer, F64Deserializer, SeqDeserializer, StrDeserializer, U32Deserializer};
use sorairo::low_level::words::{Word, Words, words};
use sorairo::scene::file::Draft;
use sorairo::scene::keys::{self, Key};
use sorairo::scene::place::{Place, Time};
use sorairo::scene::reference::help;
use sorairo::scene::{Exposure, Preset, Size, ValidScene};

use crate::ranges::{self, Numbers};

/// A flag that takes the place of a key.
pub struct SceneFlag {
    /// The key.
    pub key: &'static str,
    /// The flag, with its dashes.
    pub name: &'static str,
    takes: Takes,
}

/// What a flag takes.
enum Takes {
    /// One of the words of its key.
    Word,
    /// Nothing: it says true.
    Nothing,
    /// What is read from its text, and how the help calls it.
    Value(&'static str, Read),
}

/// Reads the text of a flag, or says what is allowed.
type Read = fn(&str) -> Result<Given, String>;

/// What a flag gives to its key.
#[derive(Clone, Debug)]
enum Given {
    True,
    Number(f64),
    Count(u32),
    Numbers(Numbers),
    Text(String),
}

/// The flags of a scene that its sun moves by.
const SUN: [SceneFlag; 2] =
    [value("sun.elevation", "--sun-elevation", "DEG", number), value("sun.time", "--time", "TIME", text_of::<Time>)];

/// The flags of a scene that all frames of a sequence share.
const SKY: [SceneFlag; 23] = [
    word("preset", "--preset"),
    value("sun.azimuth", "--sun-azimuth", "DEG", number),
    value("sun.place", "--place", "LAT,LON", text_of::<Place>),
    value("observer.altitude", "--altitude", "KM", number),
    value("atmosphere.air.pressure", "--pressure", "HPA", number),
    value("ground.albedo", "--albedo", "ALBEDO", albedo),
    SceneFlag { key: "sun.disc", name: "--sun-disc", takes: Takes::Nothing },
    word("camera.projection", "--projection"),
    value("camera.size", "--size", "WxH", text_of::<Size>),
    value("camera.fov", "--fov", "DEG", number),
    value("camera.look_azimuth", "--look-azimuth", "DEG", number),
    value("camera.look_elevation", "--look-elevation", "DEG", number),
    value("render.orders", "--orders", "N", orders),
    word("render.fit", "--fit"),
    value("render.bands", "--bands", "LIST", wavelengths),
    word("render.color", "--color"),
    value("render.steps", "--steps", "N", steps),
    word("render.exr", "--exr"),
    word("render.rgb", "--rgb"),
    word("render.observer", "--observer"),
    word("render.white_balance", "--white-balance"),
    word("render.path", "--path"),
    value("render.exposure", "--exposure", "EV", exposure),
];

/// Arguments of the library that are no keys, with their flags.
const ARGUMENTS: [(&str, &str); 6] = [
    ("spectral", "--spectral"),
    ("wavelengths", "--wavelengths"),
    ("view_elevation", "--view-elevation"),
    ("view_azimuth", "--view-azimuth"),
    ("count", "--count"),
    ("sun_elevations", "--sun-elevations"),
];

/// The flag of a key or an argument.
pub fn flag(key: &str) -> Option<&'static str> {
    let flags = SUN.iter().chain(&SKY).map(|flag| (flag.key, flag.name));
    flags.chain(ARGUMENTS).find(|(name, _)| *name == key).map(|(_, flag)| flag)
}

const fn word(key: &'static str, name: &'static str) -> SceneFlag {
    SceneFlag { key, name, takes: Takes::Word }
}

const fn value(key: &'static str, name: &'static str, shown: &'static str, read: Read) -> SceneFlag {
    SceneFlag { key, name, takes: Takes::Value(shown, read) }
}

/// Values of keys that flags give.
#[derive(Clone, Debug, Default)]
pub struct Values(Vec<(&'static str, Given)>);

/// Every flag of a scene.
#[derive(Clone, Debug)]
pub struct SceneFlags(pub Values);

/// The flags of a scene that all frames of a sequence share.
#[derive(Clone, Debug)]
pub struct SkyFlags(pub Values);

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
        self.0.iter().find_map(|(key, value)| match value {
            Given::Text(name) if *key == "preset" => name.parse().ok(),
            _ => None,
        })
    }

    /// Whether a key is given.
    pub fn has(&self, key: &str) -> bool {
        self.0.iter().any(|(given, _)| *given == key)
    }

    /// These values and an elevation of the sun.
    pub fn with_elevation(&self, elevation: f64) -> Self {
        self.with("sun.elevation", Given::Number(elevation))
    }

    /// These values and a time.
    pub fn with_time(&self, time: Time) -> Self {
        self.with("sun.time", Given::Text(time.to_string()))
    }

    fn with(&self, key: &'static str, value: Given) -> Self {
        let mut values = self.clone();
        values.0.push((key, value));
        values
    }

    /// Lays the values over a scene; elevation and azimuth of the sun last, where they take the place of what a place and a time say.
    fn lay_over(&self, draft: &mut Draft) -> sorairo::Result<()> {
        let of_sun = |(key, _): &&(&str, Given)| ["sun.elevation", "sun.azimuth"].contains(key);
        let others = self.0.iter().filter(|value| !of_sun(value) && value.0 != "preset");
        others.into_iter().try_for_each(|(key, value)| value.lay_over(draft, key))?;
        if self.0.iter().any(|value| of_sun(&value)) {
            draft.place_sun()?;
        }
        self.0.iter().filter(of_sun).try_for_each(|(key, value)| value.lay_over(draft, key))
    }

    fn of(matches: &ArgMatches, flags: &[&[SceneFlag]]) -> Self {
        let given = |flag: &SceneFlag| match flag.takes {
            Takes::Nothing => matches.get_flag(flag.id()).then_some(Given::True),
            _ => matches.get_one::<Given>(flag.id()).cloned(),
        };
        Self(flags.iter().copied().flatten().filter_map(|flag| Some((flag.key, given(flag)?))).collect())
    }
}

impl Given {
    fn lay_over(&self, draft: &mut Draft, key: &str) -> sorairo::Result<()> {
        type Error = serde::de::value::Error;
        let key = keys::find(key).expect("the key of a flag");
        let set = match self {
            Self::True => draft.set(key, BoolDeserializer::<Error>::new(true)),
            Self::Number(number) => draft.set(key, F64Deserializer::<Error>::new(*number)),
            Self::Count(count) => draft.set(key, U32Deserializer::<Error>::new(*count)),
            Self::Numbers(numbers) => draft.set(key, SeqDeserializer::<_, Error>::new(numbers.iter().copied())),
            Self::Text(text) => draft.set(key, StrDeserializer::<Error>::new(text)),
        };
        let flag = flag(key.name).unwrap_or(key.name);
        set.map_err(|error| match error {
            sorairo::Error::Text(complaint) => sorairo::Error::Text(format!("{flag}: {complaint}")),
            other => other,
        })
    }
}

impl SceneFlag {
    /// The name of the flag in the parser.
    fn id(&self) -> &'static str {
        self.name.trim_start_matches('-')
    }

    fn arg(&self) -> Arg {
        let arg = Arg::new(self.id()).long(self.id()).help(help(self.key));
        match self.takes {
            Takes::Nothing => arg.action(ArgAction::SetTrue),
            Takes::Word => {
                let words = keys::find(self.key).expect("the key of a flag").words();
                arg.value_name(self.id().replace('-', "_").to_uppercase()).value_parser(named(words).map(Given::Text))
            }
            Takes::Value(shown, read) => {
                let arg = arg.value_name(shown).value_parser(read);
                match self.key {
                    // South of the equator a latitude looks like a flag.
                    "sun.place" => arg.allow_hyphen_values(true).conflicts_with_all(["sun-elevation", "sun-azimuth"]),
                    "sun.time" => arg.conflicts_with_all(["sun-elevation", "sun-azimuth"]),
                    "camera.size" | "render.bands" => arg,
                    _ => arg.allow_negative_numbers(true),
                }
            }
        }
    }
}

/// Adds flags to a command.
fn with_flags(command: Command, flags: &[&[SceneFlag]]) -> Command {
    command.args(flags.iter().copied().flatten().map(SceneFlag::arg))
}

impl Args for SceneFlags {
    fn augment_args(command: Command) -> Command {
        with_flags(command, &[&SUN, &SKY])
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for SceneFlags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self(Values::of(matches, &[&SUN, &SKY])))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for SkyFlags {
    fn augment_args(command: Command) -> Command {
        with_flags(command, &[&SKY])
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for SkyFlags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self(Values::of(matches, &[&SKY])))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Reads one of some words; the help lists them with their sentences.
fn named(words: Vec<Word>) -> impl TypedValueParser<Value = String> {
    PossibleValuesParser::new(words.into_iter().map(|word| PossibleValue::new(word.name).help(word.sentence)))
}

/// Reads one of the words of a type.
pub fn word_of<T: Words + Clone + Send + Sync + 'static>() -> impl TypedValueParser<Value = T> {
    named(words::<T>()).map(|text| text.parse().ok().expect("every word of a type is one of its values"))
}

fn number(text: &str) -> Result<Given, String> {
    text.parse().map(Given::Number).map_err(|_| "a number is wanted, such as 12.5".into())
}

fn steps(text: &str) -> Result<Given, String> {
    let range = || keys::find("render.steps").map(Key::range).unwrap_or_default();
    text.parse().map(Given::Count).map_err(|_| format!("a whole number from {} is wanted", range()))
}

fn wavelengths(text: &str) -> Result<Given, String> {
    ranges::wavelengths(text).map(Given::Numbers)
}

fn exposure(text: &str) -> Result<Given, String> {
    text.parse().map(|exposure| match exposure {
        Exposure::Auto => Given::Text(text.into()),
        Exposure::Stops(stops) => Given::Number(stops),
    })
}

fn orders(text: &str) -> Result<Given, String> {
    if text == "all" {
        return Ok(Given::Text(text.into()));
    }
    let range = || keys::find("render.orders").map(Key::range).unwrap_or_default();
    text.parse().map(Given::Count).map_err(|_| format!("a whole number or `all` is wanted: {}", range()))
}

/// An albedo is a number, a surface or a table; which ones there are, its key says.
fn albedo(text: &str) -> Result<Given, String> {
    Ok(text.parse().map_or_else(|_| Given::Text(text.into()), Given::Number))
}

/// Reads a text that says a value of a type.
fn text_of<T: std::str::FromStr<Err = String>>(text: &str) -> Result<Given, String> {
    text.parse::<T>().map(|_| Given::Text(text.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flag_has_a_key() {
        for flag in SUN.iter().chain(&SKY) {
            assert!(keys::find(flag.key).is_some(), "{}", flag.name);
        }
    }
}
