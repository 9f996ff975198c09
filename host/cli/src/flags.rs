//! Flags that take the place of keys of a scene, each a row: its key says what it means, its help and what it may be.

use std::path::Path;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use serde::de::value::{BoolDeserializer, F64Deserializer, SeqDeserializer, StrDeserializer, U32Deserializer};
use sorairo::low_level::words::{Word, Words, words};
use sorairo::scene::file::Draft;
use sorairo::scene::keys::{self, KEYS, Key};
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
    /// An optical depth of aerosol and its wavelength (nm).
    DepthAt(f64, f64),
    /// How far one sees (km).
    Visibility(f64),
    /// A value of a table, which has no kind of its own.
    Cell(String),
}

const OPTICAL_DEPTH: &str = "atmosphere.aerosol.optical_depth";

/// The flags by which the sun of one sky stands, which a sequence says in its own way.
const SUN: [SceneFlag; 2] =
    [value("sun.elevation", "--sun-elevation", "DEG", number), value("sun.time", "--time", "TIME", text_of::<Time>)];

/// The exposure of one picture, likewise.
const EXPOSURE: [SceneFlag; 1] = [value("render.exposure", "--exposure", "EV", exposure)];

/// The flags of what a spectrum depends on too.
const SKY: [SceneFlag; 14] = [
    word("preset", "--preset"),
    value("sun.azimuth", "--sun-azimuth", "DEG", number),
    value("sun.place", "--place", "LAT,LON", text_of::<Place>),
    value("observer.altitude", "--altitude", "KM", number),
    value("atmosphere.air.pressure", "--pressure", "HPA", number),
    value(OPTICAL_DEPTH, "--aerosol", "DEPTH@NM", depth_at),
    value(OPTICAL_DEPTH, "--visibility", "KM", visibility),
    value("atmosphere.aerosol.angstrom_exponent", "--angstrom", "ALPHA", number),
    value("ground.albedo", "--albedo", "ALBEDO", albedo),
    value("render.orders", "--orders", "N", orders),
    word("render.fit", "--fit"),
    value("render.bands", "--bands", "LIST", wavelengths),
    value("render.steps", "--steps", "N", steps),
    word("render.observer", "--observer"),
];

/// The flags of images alone.
const IMAGE: [SceneFlag; 12] = [
    SceneFlag { key: "sun.disc", name: "--sun-disc", takes: Takes::Nothing },
    word("camera.projection", "--projection"),
    value("camera.size", "--size", "WxH", text_of::<Size>),
    value("camera.fov", "--fov", "DEG", number),
    value("camera.look_azimuth", "--look-azimuth", "DEG", number),
    value("camera.look_elevation", "--look-elevation", "DEG", number),
    word("render.color", "--color"),
    word("render.dither", "--dither"),
    word("render.exr", "--exr"),
    word("render.rgb", "--rgb"),
    word("render.white_balance", "--white-balance"),
    word("render.path", "--path"),
];

/// All of them.
fn all() -> impl Iterator<Item = &'static SceneFlag> {
    SUN.iter().chain(&EXPOSURE).chain(&SKY).chain(&IMAGE)
}

/// Arguments of the library that are no keys, with their flags.
const ARGUMENTS: [(&str, &str); 7] = [
    ("visibility", "--visibility"),
    ("spectral", "--spectral"),
    ("wavelengths", "--wavelengths"),
    ("view_elevation", "--view-elevation"),
    ("view_azimuth", "--view-azimuth"),
    ("count", "--count"),
    ("sun_elevations", "--sun-elevations"),
];

/// The flag of a key or an argument.
pub fn flag(key: &str) -> Option<&'static str> {
    let flags = all().map(|flag| (flag.key, flag.name));
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
pub struct SharedFlags(pub Values);

/// The flags of a sky that no camera looks at.
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

    /// These values and an exposure.
    pub fn with_exposure(&self, exposure: Exposure) -> Self {
        let given = match exposure {
            Exposure::Auto => Given::Text("auto".into()),
            Exposure::Stops(stops) => Given::Number(stops),
        };
        self.with("render.exposure", given)
    }

    /// These values and those of a table's row, by their keys.
    pub fn with_cells<'a>(&self, cells: impl Iterator<Item = (&'static str, &'a str)>) -> Self {
        let mut values = self.clone();
        values.0.extend(cells.map(|(key, text)| (key, Given::Cell(text.to_owned()))));
        values
    }

    fn with(&self, key: &'static str, value: Given) -> Self {
        let mut values = self.clone();
        values.0.push((key, value));
        values
    }

    /// Lays the values over a scene; those last that follow from others.
    fn lay_over(&self, draft: &mut Draft) -> sorairo::Result<()> {
        let given = || self.0.iter().filter(|(key, _)| *key != "preset");
        let follows = |(_, value): &&(&str, Given)| matches!(value, Given::DepthAt(..) | Given::Visibility(_));
        given().filter(|value| !follows(value)).try_for_each(|(key, value)| value.lay_over(draft, key))?;
        given().filter(follows).try_for_each(|(key, value)| value.lay_over(draft, key))?;
        draft.refuse_two_suns(|key| self.has(key))
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
            Self::DepthAt(depth, wavelength) => {
                let depth = draft.scene().optical_depth_from(*depth, *wavelength);
                draft.set(key, F64Deserializer::<Error>::new(depth))
            }
            Self::Visibility(distance) => {
                let depth = draft.scene().optical_depth_from_visibility(*distance)?;
                draft.set(key, F64Deserializer::<Error>::new(depth))
            }
            Self::Cell(text) => set_cell(draft, key, text),
        };
        let flag = match self {
            Self::Cell(_) => key.name,
            _ => flag(key.name).unwrap_or(key.name),
        };
        set.map_err(|error| match error {
            sorairo::Error::Text(complaint) => sorairo::Error::Text(format!("{flag}: {complaint}")),
            other => other,
        })
    }
}

/// Takes the value of a table as the first kind that the key is: a whole number, a number, true or false, text.
fn set_cell(draft: &mut Draft, key: &'static Key, text: &str) -> sorairo::Result<()> {
    type Error = serde::de::value::Error;
    let is_set = text.parse().is_ok_and(|count| draft.set(key, U32Deserializer::<Error>::new(count)).is_ok())
        || text.parse().is_ok_and(|number| draft.set(key, F64Deserializer::<Error>::new(number)).is_ok())
        || text.parse().is_ok_and(|truth| draft.set(key, BoolDeserializer::<Error>::new(truth)).is_ok());
    if is_set { Ok(()) } else { draft.set(key, StrDeserializer::<Error>::new(text)) }
}

impl SceneFlag {
    /// The name of the flag in the parser.
    fn id(&self) -> &'static str {
        self.name.trim_start_matches('-')
    }

    fn arg(&self) -> Arg {
        let arg = Arg::new(self.id()).long(self.id()).help(match self.name {
            "--aerosol" => "Vertical optical depth of aerosol at a wavelength in nm, such as 0.2@500; with the Ångström exponent it is that at 1 µm \
                            [default: that of the preset]"
                .into(),
            "--visibility" => "How far one sees a black object against the sky (km), which says the optical depth of aerosol".into(),
            _ => help(self.key),
        });
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
                    OPTICAL_DEPTH if self.name == "--visibility" => {
                        arg.allow_negative_numbers(true).conflicts_with("aerosol")
                    }
                    "camera.size" | "render.bands" => arg,
                    _ => arg.allow_negative_numbers(true),
                }
            }
        }
    }
}

/// Adds flags to a command, in the order of their keys, which puts a place beside a time.
fn with_flags(command: Command, flags: &[&[SceneFlag]]) -> Command {
    let mut flags: Vec<&SceneFlag> = flags.iter().copied().flatten().collect();
    flags.sort_by_key(|flag| KEYS.iter().position(|key| key.name == flag.key));
    command.args(flags.into_iter().map(SceneFlag::arg))
}

/// Makes a type the flags of some lists.
macro_rules! flags {
    ($name:ident: $($list:ident),+) => {
        impl Args for $name {
            fn augment_args(command: Command) -> Command {
                with_flags(command, &[$(&$list),+])
            }

            fn augment_args_for_update(command: Command) -> Command {
                Self::augment_args(command)
            }
        }

        impl FromArgMatches for $name {
            fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
                Ok(Self(Values::of(matches, &[$(&$list),+])))
            }

            fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
                *self = Self::from_arg_matches(matches)?;
                Ok(())
            }
        }
    };
}

flags!(SceneFlags: SUN, EXPOSURE, SKY, IMAGE);
flags!(SharedFlags: SKY, IMAGE);
flags!(SkyFlags: SUN, SKY);

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

/// An optical depth and its wavelength in nm, as in `0.2@500`.
fn depth_at(text: &str) -> Result<Given, String> {
    let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    let pair = text.split_once('@').and_then(|(depth, wavelength)| Some((number(depth)?, number(wavelength)?)));
    pair.filter(|(depth, wavelength)| *depth >= 0.0 && (300.0..=3000.0).contains(wavelength))
        .map(|(depth, wavelength)| Given::DepthAt(depth, wavelength))
        .ok_or_else(|| {
            "an optical depth of 0 or more and a wavelength from 300 to 3000 nm are wanted, such as 0.2@500".into()
        })
}

fn visibility(text: &str) -> Result<Given, String> {
    text.parse().map(Given::Visibility).map_err(|_| "a distance in km is wanted, such as 23".into())
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
        for flag in all() {
            assert!(keys::find(flag.key).is_some(), "{}", flag.name);
        }
    }
}
