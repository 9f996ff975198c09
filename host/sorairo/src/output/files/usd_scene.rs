//! Scenes in Universal Scene Description (USD): a dome with the map beside the file, and the sun as a distant light. Y
//! is up, north is -Z and east is +X.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::text_scene;
use crate::error::{Error, Result};
use crate::output::encoding::Image;
use crate::scene::Scene;

/// Checks that a scene has its map beside it, and that this map shows the whole sphere without the sun's disc.
pub(super) fn check(path: &Path, outputs: &[PathBuf], scene: &Scene) -> Result<()> {
    let what = "a scene of USD (.usda)";
    text_scene::check_picture(path, &map(path), outputs, scene, (what, '@'))?;
    if scene.sun.disc {
        let complaint = format!(
            "is true; {what} has the sun as a light of its own, so its map does not hold it: leave the disc out"
        );
        return Err(Error::not_allowed("sun.disc", complaint));
    }
    Ok(())
}

/// The map beside a scene.
fn map(path: &Path) -> PathBuf {
    path.with_extension("exr")
}

/// How a scene names the map beside it, wherever the two lie.
fn map_name(path: &Path) -> String {
    let map = map(path);
    format!("@./{}@", map.file_name().unwrap_or_default().to_string_lossy())
}

/// What a file says of itself before its metadata.
fn label(scene: &Scene) -> String {
    format!("#usda 1.0\n{}", text_scene::label(scene, ""))
}

/// Whether a text is a whole file of this program for a scene, around the map beside `path`.
pub(super) fn is_whole(text: &str, path: &Path, scene: &Scene) -> bool {
    text_scene::is_whole(text, &label(scene)) && text.contains(&map_name(path))
}

/// Writes the scene around the map that lies beside `path`.
pub(super) fn encode(output: &mut impl Write, path: &Path, image: &Image) -> io::Result<()> {
    let text = format!(
        "{}(\n    defaultPrim = \"Sky\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\n\
         # Y is up, -Z north, +X east. Colours are of the linear space {}.\n\
         def Xform \"Sky\"\n{{\n{}{}}}\n\n",
        label(&image.scene),
        <&str>::from(image.scene.render.rgb),
        dome(path, image),
        sun(image)
    );
    text_scene::write(output, &text)
}

/// The dome. The centre of a map looks to its +Z and what is right of it to its -X, as in OpenEXR. Half a turn about Y
/// brings these to north and east. The exposure of the map is taken back, so that the dome has the radiance of the sky.
fn dome(path: &Path, image: &Image) -> String {
    let turn = 180.0 - image.scene.camera.look_azimuth.unwrap_or(0.0);
    format!(
        "    def DomeLight \"Dome\"\n    {{\n        float inputs:exposure = {}\n        float inputs:intensity = 1\n        \
         asset inputs:texture:file = {}\n        token inputs:texture:format = \"latlong\"\n        double xformOp:rotateY = {turn}\n        \
         uniform token[] xformOpOrder = [\"xformOp:rotateY\"]\n    }}\n",
        0.0 - image.exr_exposure,
        map_name(path)
    )
}

/// The sun, if it shines. A distant light shines along its -Z. Normalised, its intensity is the irradiance of a surface
/// that faces it.
fn sun(image: &Image) -> String {
    let rgb = image.sun.rgb;
    let intensity = rgb.into_iter().fold(0.0, f64::max);
    if intensity <= 0.0 {
        return String::new();
    }
    let [red, green, blue] = rgb.map(|value| (value / intensity) as f32);
    let sun = &image.scene.sun;
    format!(
        "\n    def DistantLight \"Sun\"\n    {{\n        float inputs:angle = {}\n        color3f inputs:color = ({red}, {green}, {blue})\n        \
         float inputs:intensity = {}\n        bool inputs:normalize = 1\n        double3 xformOp:rotateXYZ = ({}, {}, 0)\n        \
         uniform token[] xformOpOrder = [\"xformOp:rotateXYZ\"]\n    }}\n",
        image.sun.across as f32,
        intensity as f32,
        -sun.elevation,
        180.0 - sun.azimuth
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_whole_with_its_last_line_for_its_scene_and_its_map_alone() {
        let scene = Scene::default();
        let mut bytes = Vec::new();
        let body = format!("{}def DomeLight \"Dome\" {{ {} }}\n", label(&scene), map_name(Path::new("a/sky.usda")));
        text_scene::write(&mut bytes, &body).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        assert!(is_whole(&text, Path::new("b/sky.usda"), &scene));
        assert!(!is_whole(&text, Path::new("other.usda"), &scene));
        assert!(!is_whole(&text[..text.len() - 1], Path::new("sky.usda"), &scene));
        assert!(!is_whole(&text.replace("Dome\"", "Dame\""), Path::new("sky.usda"), &scene));
        let mut other = scene;
        other.sun.elevation += 1.0;
        assert!(!is_whole(&text, Path::new("sky.usda"), &other));
    }
}
