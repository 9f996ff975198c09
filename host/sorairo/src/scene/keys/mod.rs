//! The keys of a scene: one row each, with the way to its value, its unit, what it may be, and what stands in for it.
//! Validation, scene files, the help of the flags, the reference page, random scenes and the words of the fuzz targets
//! are all made from these rows; a key's sentence is the doc comment of its field.

use crate::azimuth::within_a_turn;
use crate::error::{Error, Result};
use crate::medium::profile::Profile;
use crate::scene::aerosol::AerosolMode;
use crate::scene::preset::Scene;
use crate::spectra::named_file::NamedFile;
use crate::spectra::table_file::TableFile;

mod key;
mod list;

pub use key::{Allowed, Bound, Key};
pub use list::{DENSEST_TOP, KEYS, find};

/// The user tables that a scene reads, each with its key.
pub fn tables(scene: &Scene) -> impl Iterator<Item = (&'static str, &TableFile)> {
    KEYS.iter().filter_map(|key| Some((key.name, key.table?.table(scene)?)))
}

/// The files that a scene reads, each with its key and the CRC-32 of what it holds.
pub fn files(scene: &Scene) -> impl Iterator<Item = (&'static str, &NamedFile, u32)> {
    let tables = tables(scene).map(|(key, table)| (key, &table.file, table.checksum()));
    let profile = match &scene.atmosphere.profile {
        Profile::File(own) => Some(("atmosphere.profile", &own.file, own.checksum)),
        _ => None,
    };
    let modes = scene.atmosphere.aerosol.modes.iter().flat_map(AerosolMode::files);
    tables.chain(profile).chain(modes.map(|(file, checksum)| ("atmosphere.aerosol", file, checksum)))
}

/// Changes the name of each of [`files`].
#[cfg_attr(
    not(feature = "scene-files"),
    allow(dead_code, reason = "scenes that come from files alone have names to change")
)]
pub(crate) fn change_names(scene: &mut Scene, mut change: impl FnMut(&mut NamedFile)) {
    for way in KEYS.iter().filter_map(|key| key.table) {
        way.table_mut(scene).into_iter().for_each(|table| change(&mut table.file));
    }
    if let Profile::File(own) = &mut scene.atmosphere.profile {
        change(&mut own.file);
    }
    scene.atmosphere.aerosol.modes.iter_mut().flat_map(AerosolMode::names_mut).for_each(change);
}

/// The errors of a scene, key by key.
pub fn problems(scene: &Scene) -> Vec<Error> {
    KEYS.iter().filter_map(|key| key.check(scene).err()).collect()
}

/// Takes whole turns off the azimuths of a scene.
pub(super) fn unwind(scene: &mut Scene) -> Result<()> {
    for key in KEYS.iter().filter(|key| key.wraps) {
        let Allowed::Range { number, .. } = &key.allowed else { continue };
        if let Some(azimuth) = number.number(scene)
            && let Some(place) = number.number_mut(scene)
        {
            *place = within_a_turn(key.name, azimuth)?;
        }
    }
    Ok(())
}

/// Checks the keys of one table of a scene.
pub(super) fn check_table(table: &str, scene: &Scene) -> Result<()> {
    KEYS.iter().filter(|key| key.table_and_name().0 == table).try_for_each(|key| key.check(scene))
}

#[cfg(test)]
mod tests {
    use strum::IntoEnumIterator;

    use super::key::{TABLES, Table};
    use super::*;
    use crate::scene::Preset;

    #[test]
    fn every_field_of_a_scene_is_a_key() {
        let is_table = |name: &str| TABLES.iter().any(|table| table.name == name);
        let of_table =
            |table: &Table| table.fields.iter().map(|field| format!("{}.{field}", table.name)).collect::<Vec<_>>();
        let mut names: Vec<String> = TABLES
            .iter()
            .flat_map(of_table)
            .map(|name| name.trim_start_matches('.').to_owned())
            .filter(|name| !is_table(name))
            .collect();
        let mut keys: Vec<_> = KEYS.iter().map(|key| key.name.to_owned()).collect();
        names.sort();
        keys.sort();
        assert_eq!(keys, names);
    }

    #[test]
    fn every_key_has_a_sentence_and_a_range() {
        for key in KEYS {
            let texts = [key.sentence(), key.range()];
            assert!(texts.iter().all(|text| !text.is_empty()), "{}: {texts:?}", key.name);
        }
    }

    #[test]
    fn every_key_is_the_way_to_its_own_value() {
        for key in KEYS.iter().filter(|key| key.bounds(&Scene::default()).is_some()) {
            let mut scene = Scene::default();
            key.set(&mut scene, serde::de::value::U32Deserializer::<serde::de::value::Error>::new(77)).unwrap();
            let value = serde_json::to_value(key.value(&scene)).unwrap();
            let at = format!("/{}", key.name.replace('.', "/"));
            let whole = serde_json::to_value(&scene).unwrap();
            assert!(value.as_f64() == Some(77.0) && whole.pointer(&at) == Some(&value), "{}: {value}", key.name);
        }
    }

    #[test]
    fn each_key_that_takes_the_name_of_a_file_is_in_the_list_of_tables() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, "380,0.25\n780,0.5\n").unwrap();
        let name = path.to_str().unwrap();
        let mut found = 0;
        for key in KEYS {
            let mut scene = Scene::default();
            let value = serde::de::value::StrDeserializer::<serde::de::value::Error>::new(name);
            let is_read = key.set(&mut scene, value).is_ok();
            let listed: Vec<_> = tables(&scene).map(|(key, table)| (key, table.table().at(780.0))).collect();
            assert_eq!(listed, if is_read { vec![(key.name, [0.5])] } else { vec![] }, "{}", key.name);
            assert_eq!(is_read, key.takes_table(), "{}", key.name);
            found += u32::from(is_read);
        }
        assert!(found >= 4, "{found} keys take tables");
    }

    #[test]
    fn every_preset_is_allowed() {
        for preset in Preset::iter() {
            assert!(Scene::preset(preset).validated().is_ok(), "{preset:?}");
        }
    }
}
