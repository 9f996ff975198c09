//! Flags that take the place of keys of a scene, each a row: its key says what it means, its help and what it may be.

use std::ffi::OsStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use sorairo::scene::keys::{self, KEYS};
use sorairo::scene::place::{Place, Time};
use sorairo::scene::reference::help;
use sorairo::scene::rules::CAMERA;
use sorairo::scene::{Reflectance, Size};
use sorairo::words::{Word, Words, words};

use crate::values::{
    Given, Read, Value, Values, albedo, depth_at, exposure, number, orders, shutter, steps, text_of, visibility, water,
    wavelengths,
};

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
    /// True or false; true where neither is said.
    Truth,
    /// What is read from its text, and how the help calls it.
    Value(&'static str, Read),
}

const OPTICAL_DEPTH: &str = "atmosphere.aerosol.optical_depth";

/// The flags by which the sun of one sky stands, which a sequence says in its own way.
const SUN: [SceneFlag; 2] =
    [value("sun.elevation", "--sun-elevation", "DEG", number), value("sun.time", "--time", "TIME", text_of::<Time>)];

/// The exposure of one picture, likewise.
const EXPOSURE: [SceneFlag; 1] = [value("render.exposure", "--exposure", "EV", exposure)];

/// The flags of what a spectrum depends on too.
const SKY: [SceneFlag; 21] = [
    word("preset", "--preset"),
    value("sun.azimuth", "--sun-azimuth", "DEG", number),
    value("sun.place", "--place", "LAT,LON", text_of::<Place>),
    SceneFlag { key: "sun.apparent", name: "--apparent", takes: Takes::Nothing },
    value("observer.altitude", "--altitude", "KM", number),
    value("site.altitude", "--site-altitude", "KM", number),
    word("atmosphere.profile", "--profile"),
    SceneFlag { key: "atmosphere.refraction", name: "--refraction", takes: Takes::Truth },
    value("atmosphere.water.column", "--water", "CM", water),
    value("atmosphere.air.pressure", "--pressure", "HPA", number),
    word("atmosphere.aerosol.kind", "--aerosol-kind"),
    value(OPTICAL_DEPTH, "--aerosol", "DEPTH@NM", depth_at),
    value(OPTICAL_DEPTH, "--visibility", "KM", visibility),
    value("atmosphere.aerosol.angstrom_exponent", "--angstrom", "ALPHA", number),
    value("ground.albedo", "--albedo", "ALBEDO", albedo),
    value("render.orders", "--orders", "N", orders),
    word("render.polarisation", "--polarisation"),
    word("render.fit", "--fit"),
    value("render.bands", "--bands", "LIST", wavelengths),
    value("render.steps", "--samples", "N", steps),
    word("render.observer", "--observer"),
];

/// The flags of images alone.
const IMAGE: [SceneFlag; 28] = [
    SceneFlag { key: "sun.disc", name: "--sun-disc", takes: Takes::Nothing },
    word("camera.projection", "--projection"),
    value("camera.size", "--size", "WxH", text_of::<Size>),
    value("camera.fov", "--fov", "DEG", number),
    value("camera.look_azimuth", "--look-azimuth", "DEG", number),
    value("camera.look_elevation", "--look-elevation", "DEG", number),
    value("camera.roll", "--roll", "DEG", number),
    value("camera.shift_x", "--shift-x", "WIDTHS", number),
    value("camera.shift_y", "--shift-y", "WIDTHS", number),
    word("camera.below", "--below"),
    value("camera.below_color", "--below-color", "R,G,B", text_of::<Reflectance>),
    value("camera.polariser", "--polariser", "DEG", number),
    value("camera.polariser_extinction", "--polariser-extinction", "RATIO", number),
    word("render.color", "--color"),
    value("render.iso", "--iso", "ISO", number),
    value("render.shutter", "--shutter", "S", shutter),
    value("render.aperture", "--aperture", "N", number),
    word("render.view", "--view"),
    word("render.look", "--look"),
    SceneFlag { key: "render.purkinje", name: "--purkinje", takes: Takes::Nothing },
    word("render.display", "--display"),
    word("render.dither", "--dither"),
    word("render.exr", "--exr"),
    value("render.exr_exposure", "--exr-exposure", "EV", exposure),
    word("render.exr_compression", "--exr-compression"),
    word("render.rgb", "--rgb"),
    word("render.white_balance", "--white-balance"),
    word("render.path", "--path"),
];

/// All of them.
fn all() -> impl Iterator<Item = &'static SceneFlag> {
    SUN.iter().chain(&EXPOSURE).chain(&SKY).chain(&IMAGE)
}

/// Arguments of the library that are no keys, with their flags.
const ARGUMENTS: [(&str, &str); 12] = [
    ("depth", "--depth"),
    ("beauty", "--beauty"),
    ("distance", "--distance"),
    ("resolution", "--resolution"),
    ("visibility", "--visibility"),
    ("spectral", "--spectral"),
    ("stokes", "--stokes"),
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

/// Every flag of a scene.
#[derive(Clone, Debug)]
pub struct SceneFlags(pub Values);

/// The flags of a scene that all frames of a sequence share.
#[derive(Clone, Debug)]
pub struct SharedFlags(pub Values);

/// The flags of a sky that no camera looks at.
#[derive(Clone, Debug)]
pub struct SkyFlags(pub Values);

/// The values that the flags of some lists were given.
fn given(matches: &ArgMatches, flags: &[&[SceneFlag]]) -> Values {
    let given = |flag: &SceneFlag| match flag.takes {
        Takes::Nothing => matches.get_flag(flag.id()).then_some(Given::Truth(true)),
        Takes::Truth => matches.get_one(flag.id()).map(|&truth| Given::Truth(truth)),
        _ => matches.get_one::<Given>(flag.id()).cloned(),
    };
    flags
        .iter()
        .copied()
        .flatten()
        .filter_map(|flag| Some(Value { key: flag.key, said: flag.name, given: given(flag)? }))
        .collect()
}

impl SceneFlag {
    /// The name of the flag in the parser.
    fn id(&self) -> &'static str {
        self.name.trim_start_matches('-')
    }

    fn arg(&self) -> Arg {
        let arg = Arg::new(self.id()).long(self.id()).help(match self.name {
            "--aerosol" => "Vertical optical depth of aerosol at a wavelength in nm, such as 0.2@500; with the Ångström exponent it is that at 1 µm \
                            [default: that of the preset]. Or aeronet:FILE[@TIME], an aerosol that AERONET derived from the sky: the .pfn \
                            or the .siz of an inversion, with the .aod, .ssa and .rin of the same name beside it; of several rows that \
                            nearest to --time, or of TIME (UTC)"
                .into(),
            "--visibility" => "How far one sees a black object against the sky (km), which says the optical depth of aerosol".into(),
            _ => help(self.key),
        });
        // What some flags were called before.
        let arg = if self.name == "--samples" { arg.alias("steps") } else { arg };
        match self.takes {
            Takes::Nothing => arg.action(ArgAction::SetTrue),
            Takes::Truth => arg
                .value_name("true|false")
                .num_args(0..=1)
                .require_equals(true)
                .default_missing_value("true")
                .value_parser(clap::value_parser!(bool)),
            Takes::Word => {
                let words = keys::find(self.key).expect("the key of a flag").words();
                let arg = arg.value_name(self.id().replace('-', "_").to_uppercase()).ignore_case(true);
                match self.key {
                    "camera.projection" => arg.value_parser(projection(words).map(Given::Text)),
                    "atmosphere.profile" => arg.value_parser(ProfileParser(words)),
                    _ => arg.value_parser(named(words).map(Given::Text)),
                }
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
                    key if CAMERA.contains(&key) => arg.allow_negative_numbers(true).conflicts_with("exposure"),
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
                Ok(Self(given(matches, &[$(&$list),+])))
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

/// Reads one of some words, by any of its names; the help lists them with their sentences.
fn named(words: Vec<Word>) -> impl TypedValueParser<Value = String> {
    PossibleValuesParser::new(possible(&words)).map(move |text| name_of(&words, text))
}

fn possible(words: &[Word]) -> Vec<PossibleValue> {
    let value = |word: &Word| PossibleValue::new(word.name).aliases(word.alias).help(word.sentence);
    words.iter().map(value).collect()
}

/// The name of the word that a text is.
fn name_of(words: &[Word], text: String) -> String {
    words.iter().find(|word| word.is(&text)).map_or(text, |word| word.name.to_owned())
}

/// Reads one of the words of a profile, or the name of a file.
#[derive(Clone)]
struct ProfileParser(Vec<Word>);

impl ProfileParser {
    fn possible(&self) -> Vec<PossibleValue> {
        let file = PossibleValue::new("FILE.csv").help("A table of pressure and temperature, or a sounding (.txt)");
        possible(&self.0).into_iter().chain([file]).collect()
    }
}

impl TypedValueParser for ProfileParser {
    type Value = Given;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<Given, clap::Error> {
        let key = keys::find("atmosphere.profile").expect("a key");
        match value.to_str().filter(|text| key.is_file(text)) {
            Some(file) => Ok(Given::Text(file.into())),
            None => {
                let name = PossibleValuesParser::new(self.possible()).parse_ref(command, arg, value)?;
                Ok(Given::Text(name_of(&self.0, name)))
            }
        }
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(self.possible().into_iter()))
    }
}

/// Reads a projection; who asks for a cube is told how to come by one.
fn projection(words: Vec<Word>) -> impl TypedValueParser<Value = String> {
    const CUBE: [&str; 2] = ["cubemap", "cube"];
    let cube = PossibleValue::new(CUBE[0]).aliases(&CUBE[1..]).hide(true);
    let values = possible(&words).into_iter().chain([cube]);
    PossibleValuesParser::new(values).try_map(move |text| {
        if CUBE.iter().any(|name| name.eq_ignore_ascii_case(&text)) {
            let names: Vec<_> = words.iter().map(|word| word.name).collect();
            return Err(format!(
                "one of {} is wanted; the faces of a cube are six images of \
                 --projection perspective --fov 90 and a square --size: --look-azimuth 0, \
                 90, 180 and 270 with --look-elevation 0, and --look-elevation 90 and -90",
                names.join(", ")
            ));
        }
        Ok(name_of(&words, text))
    })
}

/// Reads one of the words of a type.
pub fn word_of<T: Words + Clone + Send + Sync + 'static>() -> impl TypedValueParser<Value = T> {
    named(words::<T>()).map(|text| text.parse().ok().expect("every word of a type is one of its values"))
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
