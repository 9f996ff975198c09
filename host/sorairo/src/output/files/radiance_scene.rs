//! Scenes of the program Radiance: a sky from a hyperspectral picture beside the file, the ground below it, and the sun
//! as a source.

use std::f64::consts::PI;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::radiance_picture::VISIBLE_RANGE;
use super::text_scene;
use crate::error::{Error, Result};
use crate::plan::direction;
use crate::scene::{CameraScene, Scene};

/// What a source of Radiance takes for the sun: the angle across it (degrees).
const SUN_ACROSS: f64 = 0.533;

/// Checks that a scene has its picture beside it, and that the camera shows the whole sphere in enough pixels.
pub(super) fn check(path: &Path, outputs: &[PathBuf], scene: &Scene) -> Result<()> {
    let what = "a scene of Radiance (.rad)";
    text_scene::check_picture(path, &path.with_extension("hsr"), outputs, scene, (what, '"'))?;
    let size = scene.camera.size;
    if size.width < 2 || size.height < 2 {
        let complaint = format!("is {size}; {what} interpolates between 2x2 pixels or more");
        return Err(Error::not_allowed("camera.size", complaint));
    }
    Ok(())
}

/// What a file says of itself before the first primitive.
fn label(scene: &Scene, wavelengths: &[f64]) -> String {
    text_scene::label(scene, &format!("# wavelengths (nm): {wavelengths:?}\n"))
}

/// Whether a text is a whole file of this program for a scene and its wavelengths (nm).
pub(super) fn is_whole(text: &str, scene: &Scene, wavelengths: &[f64]) -> bool {
    text_scene::is_whole(text, &label(scene, wavelengths))
}

/// Writes the scene around the picture that lies beside `path`.
///
/// `sun` is the irradiance of the sun on a surface that faces it, at wavelengths (nm, increasing), in W·m⁻²·nm⁻¹.
pub(super) fn encode(
    output: &mut impl Write,
    path: &Path,
    scene: &Scene,
    wavelengths: &[f64],
    sun: &[f64],
) -> io::Result<()> {
    let text =
        label(scene, wavelengths) + &sky(&path.with_extension("hsr"), &scene.camera) + &source(scene, wavelengths, sun);
    text_scene::write(output, &text)
}

/// The sky and the ground. Radiance spreads the pixels' centres from 0 to the picture's size, the shorter side of which
/// is 1, so that a pixel's number is the place times the pixels but one.
fn sky(picture: &Path, camera: &CameraScene) -> String {
    let [width, height] = [camera.size.width, camera.size.height].map(f64::from);
    let place = |pixels: f64, part: String| {
        let scale = pixels / width.min(height) / (pixels - 1.0);
        format!("{scale}*({pixels}*{part}-.5)")
    };
    let turn = camera.look_azimuth.unwrap_or(0.0) / 360.0;
    let across = place(width, format!("frac(Atan2(Dx,Dy)/(2*PI)+{}", (0.5 - turn).rem_euclid(1.0)) + ")");
    let up = place(height, "(1-Acos(Dz)/PI)".into());
    format!(
        "\n# X is east, Y north, Z up. The name of the picture counts from where Radiance runs.\n\
         void specpict sky_radiance\n5 noop {} . {across} {up}\n0\n0\n\n\
         sky_radiance glow sky_glow\n0\n0\n4 1 1 1 0\n\n\
         sky_glow source sky\n0\n0\n4 0 0 1 180\n\n\
         sky_glow source ground\n0\n0\n4 0 0 -1 180\n\n",
        name(picture)
    )
}

/// A file name as Radiance reads it: not looked for in its library, and in quotes where there are spaces.
fn name(path: &Path) -> String {
    let shown = path.display().to_string();
    let found = if path.is_absolute() || shown.starts_with('.') { shown } else { format!("./{shown}") };
    if found.contains(char::is_whitespace) { format!("\"{found}\"") } else { found }
}

/// The sun, if it shines.
fn source(scene: &Scene, wavelengths: &[f64], sun: &[f64]) -> String {
    let ([shortest, .., longest], true) = (wavelengths, sun.iter().any(|&irradiance| irradiance > 0.0)) else {
        return String::new();
    };
    let solid_angle = 2.0 * PI * (1.0 - (0.5 * SUN_ACROSS).to_radians().cos());
    let values: String =
        sun.iter().rev().map(|irradiance| format!(" {:.6e}", irradiance * VISIBLE_RANGE / solid_angle)).collect();
    let towards = direction(scene.sun.elevation, scene.sun.azimuth);
    format!(
        "void spectrum sun_radiance\n0\n0\n{} {longest} {shortest}{values}\n\n\
         sun_radiance light sun_light\n0\n0\n3 1 1 1\n\n\
         sun_light source sun\n0\n0\n4 {:.9} {:.9} {:.9} {SUN_ACROSS}\n\n",
        sun.len() + 2,
        -towards.y,
        towards.x,
        towards.z
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_not_looked_for_elsewhere_and_may_hold_spaces() {
        for (path, expected) in
            [("sky.hsr", "./sky.hsr"), ("a/b.hsr", "./a/b.hsr"), ("../a.hsr", "../a.hsr"), ("/a b.hsr", "\"/a b.hsr\"")]
        {
            assert_eq!(name(Path::new(path)), expected);
        }
    }

    #[test]
    fn a_scene_is_whole_with_its_last_line_for_its_scene_and_wavelengths_alone() {
        let (scene, wavelengths) = (Scene::default(), [400.0, 500.0, 600.0, 700.0]);
        let mut bytes = Vec::new();
        encode(&mut bytes, Path::new("sky.rad"), &scene, &wavelengths, &[1.0; 4]).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        assert!(is_whole(&text, &scene, &wavelengths));
        assert!(!is_whole(&text[..text.len() - 1], &scene, &wavelengths));
        assert!(!is_whole(&text.replace("0.533", "0.534"), &scene, &wavelengths));
        assert!(!is_whole(&text, &scene, &wavelengths[1..]));
        let mut other = scene;
        other.sun.elevation += 1.0;
        assert!(!is_whole(&text, &other, &wavelengths));
    }
}
