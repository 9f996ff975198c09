//! The keys as people read them: the reference page, and a scene file with a comment above every key.

use std::fmt::Write;

use strum::IntoEnumIterator;

use documented::DocumentedFields;

use super::aerosol::AerosolMode;
use super::keys::{self, KEYS, Key};
use super::preset::{Preset, Scene};
use crate::words::{Word, word};

/// The reference of every key, in Markdown: `docs/scene-reference.md`. `flag` says which flag of the command takes a key's place.
pub fn markdown(flag: fn(&str) -> Option<&'static str>) -> String {
    let mut page = String::from(HEAD);
    let mut table = None;
    for key in KEYS {
        let here = key.table_and_name().0;
        if table != Some(here) {
            let title = if here.is_empty() { "Above all tables".into() } else { format!("`[{here}]`") };
            page += &format!("## {title}\n\n");
            table = Some(here);
        }
        page += &entry(key, flag(key.name));
    }
    page + &modes() + PRESETS + &presets() + TABLES
}

const MODES: &str = "## `[[atmosphere.aerosol]]`

Several aerosols stand as tables of this name, in place of the one of `[atmosphere.aerosol]`. The sky has the sum of their spectra and phase
functions over the whole column, and a density that is theirs altitude by altitude: exact for aerosols that lie alike. Layers of
their own need a measured `atmosphere.profile`.

";

fn modes() -> String {
    let line = |(name, sentence): (&&str, &&str)| format!("* `{name}`: {}\n", sentence.replace('\n', " "));
    let lines: String = AerosolMode::FIELD_NAMES.iter().zip(AerosolMode::FIELD_DOCS).map(line).collect();
    format!("{MODES}{lines}\n")
}

const HEAD: &str = "# Scene files

Written by `sorairo scene reference`; do not edit. A scene file is TOML. Every key may be left out: then the value of the preset
holds. A flag takes the place of its key.

* `sorairo scene new` writes a file with every key and a comment above each.
* `sorairo scene check FILE` names everything that is wrong with a file.
* `sorairo scene show FILE` prints a file with everything filled in.

";

const PRESETS: &str = "## Presets

What each preset changes; every other key is as above.

";

const TABLES: &str = "
Light is of all orders, but in `paper`, which has the first alone over black ground.
The sky of `mars` is a pale butterscotch, because the dust absorbs blue at every scattering. The blue glow around the low sun is missing: it needs a forward
peak that is narrower in blue than in red, and the asymmetry here is the same at all wavelengths.

## Tables of a person's own

A key that takes the name of a `.csv` file reads it from the folder of the scene file. Each row is `wavelength_nm,value`; values between
rows are linear. Wavelengths increase from row to row and cover 380 to 780 nm. Lines that begin with `#` are comments, and the first
other line may name the columns. Cells may stand in quotes; commas part them. A row that stands twice, is out of order, negative, or not of two finite numbers is refused by
its line, and so is a value beyond what nature has in the unit of its key, such as a cross-section in cm². Where tables end, `render.bands` and the wavelengths of spectra end too. Images
name a table as it is found from the folder of the scene, with its checksum, and nothing of the machine.

Colours, irradiances over all wavelengths and illuminances take from a table, and from the sun's, the mean around each 5 nm of their sum, weighed by
the sun: lines between those wavelengths count, however fine. A spectrum at a wavelength takes what the table holds at that wavelength itself.

## A profile of a person's own

`atmosphere.profile` takes a file too. Its first row names the columns: `altitude_km`, `pressure_hpa`, `temperature_k` and, where they are known, `water_ppmv`,
`ozone_ppmv` and `no2_ppmv`, in place of which the mixing ratios of `us-standard` stand. Altitudes increase from the sea to 60 km or more. Air
grows thinner from row to row, and pressure falls as weight and temperature ask for, within a tenth. As with the others, the shape is taken:
`air.pressure`, `ozone.column` and `water.column` say how much there is.

## Place and time

`place` and `time` together stand for the sun's elevation and azimuth at the observer's altitude, and for its distance, 0.983 to 1.017 au. They
come from the Solar Position Algorithm (Reda and Andreas 2004, DOI 10.1016/j.solener.2003.12.003) and hold for the Earth: on a planet of another
radius they are refused. The direction is geometric: the renderer's rays are straight, so refraction, which lifts the real sun by 0.5° at the
horizon, is left out.
";

fn entry(key: &Key, flag: Option<&str>) -> String {
    let flag = flag.map(|flag| format!("; flag `{flag}`")).unwrap_or_default();
    let mut text = format!(
        "### `{}`\n\n{}\n\n*{}; default: {}{flag}*\n\n",
        key.name,
        key.sentence(),
        allowed(key),
        default_words(key)
    );
    for Word { name, alias, sentence } in key.words() {
        let alias = alias.map(|alias| format!(" or `{alias}`")).unwrap_or_default();
        writeln!(text, "* `{name}`{alias}: {sentence}").expect("a text can be written");
    }
    if !key.words().is_empty() {
        text.push('\n');
    }
    text
}

/// The help of a flag, from its key.
///
/// # Panics
///
/// If there is no such key.
pub fn help(name: &str) -> String {
    let key = keys::find(name).expect("the flag of a key");
    format!("{} [default: {}]", key.sentence().trim_end_matches('.'), default_words(key))
}

/// What holds without the key.
fn default_words(key: &Key) -> String {
    key.stand_in().unwrap_or_else(|| match value(key, &Scene::default()) {
        Some(toml::Value::String(word)) => word,
        Some(value) => plain(&value),
        None => String::new(),
    })
}

/// The value in a scene, as it stands in a file; `None` if it does not.
fn value(key: &Key, scene: &Scene) -> Option<toml::Value> {
    toml::Value::try_from(key.value(scene)).ok()
}

/// A number as a person writes it.
fn plain(value: &toml::Value) -> String {
    match value {
        toml::Value::Float(number) => number.to_string(),
        other => other.to_string(),
    }
}

/// What a key may be, with its unit unless its sentence has it.
fn allowed(key: &Key) -> String {
    if key.unit.is_empty() || key.sentence().contains(key.unit) {
        return key.range();
    }
    format!("{}, {}", key.unit, key.range())
}

fn presets() -> String {
    let mut text = String::from("| preset | keys |\n| --- | --- |\n");
    for preset in Preset::iter() {
        let (scene, default) = (Scene::preset(preset), Scene::default());
        let differs = |key: &&Key| key.name != "preset" && value(key, &scene) != value(key, &default);
        let changed: Vec<_> = KEYS
            .iter()
            .filter(differs)
            .filter_map(|key| Some(format!("`{} = {}`", key.name, plain(&value(key, &scene)?))))
            .collect();
        let changed = if changed.is_empty() { "the defaults".into() } else { changed.join(", ") };
        writeln!(text, "| `{}` | {changed} |", word(preset)).expect("a text can be written");
    }
    text
}

/// A scene file with every key of a preset, and a comment above each.
pub fn commented(preset: Preset) -> String {
    let scene = Scene::preset(preset);
    let mut text =
        String::from("# A scene of sorairo. Every key may be left out: then the value of the preset holds.\n");
    let mut table = "";
    for key in KEYS {
        let (here, name) = key.table_and_name();
        if table != here {
            write!(text, "\n[{here}]").expect("a text can be written");
            table = here;
        }
        let allowed = allowed(key).replace('`', "");
        let sentence = key.sentence().replace('`', "");
        write!(text, "\n# {sentence}\n# {allowed}\n").expect("a text can be written");
        match value(key, &scene) {
            Some(value) => writeln!(text, "{name} = {value}"),
            None => writeln!(text, "# {name} = # without it: {}", key.stand_in().unwrap_or_default().replace('`', "")),
        }
        .expect("a text can be written");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_says_what_holds_without_it() {
        assert!(KEYS.iter().all(|key| !default_words(key).is_empty()));
    }

    #[test]
    fn the_commented_file_of_a_preset_is_that_preset() {
        for preset in Preset::iter() {
            let text = commented(preset);
            assert_eq!(Scene::parse(&text, "scene.toml", None).unwrap(), Scene::preset(preset), "{text}");
            for key in KEYS {
                let name = key.table_and_name().1;
                assert!(text.contains(&format!("\n{name} = ")) || text.contains(&format!("\n# {name} = ")), "{name}");
            }
        }
    }
}
