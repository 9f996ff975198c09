//! The command that renders a scene.

use super::preset::Scene;
use crate::spectra::named_file::{is_table_file, is_text_file};

/// The `sorairo render` command, for a POSIX shell, that renders a scene on a device: the keys in which the scene
/// differs from its preset are its scene file.
pub fn command(scene: &Scene, device: &str) -> String {
    let device =
        if device == "auto" { String::new() } else { format!(" --device '{}'", device.replace('\'', r"'\''")) };
    format!("sorairo render --scene /dev/stdin{device} <<'END'\n{}END\n", scene_file(scene))
}

/// The scene file that holds only the preset and what differs from it.
fn scene_file(scene: &Scene) -> String {
    let table = |scene: &Scene| toml::Table::try_from(scene).expect("a scene is a table");
    let mut whole = table(scene);
    let preset = whole.remove("preset").expect("a scene has a preset");
    let mut file = toml::Table::from_iter([("preset".to_owned(), preset)]);
    file.extend(absolute(difference(whole, &table(&Scene::preset(scene.began_as())))));
    toml::to_string(&file).expect("a table can be written")
}

/// A table whose files have names that hold in every folder: a scene file's own are relative to its folder.
fn absolute(table: toml::Table) -> toml::Table {
    table.into_iter().map(|(key, value)| (key.clone(), with_absolute_names(&key, value))).collect()
}

fn with_absolute_names(key: &str, value: toml::Value) -> toml::Value {
    match value {
        toml::Value::Table(inner) => toml::Value::Table(absolute(inner)),
        toml::Value::Array(list) => {
            toml::Value::Array(list.into_iter().map(|value| with_absolute_names(key, value)).collect())
        }
        toml::Value::String(text) if key == "aeronet" || is_table_file(&text) || is_text_file(&text) => {
            let path = std::path::absolute(&text).ok().and_then(|path| path.into_os_string().into_string().ok());
            toml::Value::String(path.unwrap_or(text))
        }
        other => other,
    }
}

/// The keys of a table whose values are not those of `defaults`.
fn difference(table: toml::Table, defaults: &toml::Table) -> toml::Table {
    let differs = |(key, value): (String, toml::Value)| match (value, defaults.get(&key)) {
        (toml::Value::Table(inner), Some(toml::Value::Table(defaults))) => {
            let inner = difference(inner, defaults);
            (!inner.is_empty()).then_some((key, toml::Value::Table(inner)))
        }
        (value, default) => (Some(&value) != default).then_some((key, value)),
    };
    table.into_iter().filter_map(differs).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::file::Draft;
    use crate::scene::{Exposure, Preset, Projection};
    use crate::spectra::choice::OrTable;

    #[test]
    fn the_scene_file_of_a_command_is_the_scene() {
        for preset in [Preset::Earth, Preset::Paper] {
            let mut scene = Scene::preset(preset);
            scene.sun.elevation = -3.5;
            scene.atmosphere.ozone.column = 450.0;
            scene.camera.projection = Projection::Fisheye;
            scene.camera.fov = Some(140.0);
            scene.render.exposure = Exposure::Stops(1.25);
            assert_eq!(Scene::parse(&scene_file(&scene), "the command", None).unwrap(), scene);
        }
    }

    #[test]
    fn a_command_holds_what_differs_from_the_preset_and_no_more() {
        let mut scene = Scene::default();
        scene.sun.elevation = 10.0;
        let expected =
            "sorairo render --scene /dev/stdin <<'END'\npreset = \"standard\"\n\n[sun]\nelevation = 10.0\nEND\n";
        assert_eq!(command(&scene, "auto"), expected);
    }

    #[test]
    fn a_table_of_a_command_is_found_from_every_folder() {
        let folder = tempfile::tempdir_in(".").unwrap();
        let name = Path::new(folder.path().file_name().unwrap()).join("sun.csv");
        std::fs::write(&name, "380,1\n780,1\n").unwrap();
        let text = format!("[sun]\nspectrum = {:?}\n", name.to_str().unwrap());
        let scene = Scene::parse(&text, "scene.toml", None).unwrap();
        let elsewhere = std::env::temp_dir();
        let draft = Draft::parse(&scene_file(&scene), "the command", &elsewhere, None).unwrap();
        assert_eq!(draft.scene().sun.spectrum.file().unwrap().table(), scene.sun.spectrum.file().unwrap().table());
    }

    #[test]
    fn a_device_is_one_word_of_the_command_whatever_its_name() {
        let command = command(&Scene::default(), "Maker's GPU");
        assert!(command.starts_with(r"sorairo render --scene /dev/stdin --device 'Maker'\''s GPU' <<"), "{command}");
    }
}
