//! Scenes of other programs, as text around a picture beside them: they begin with what they say of themselves, and end
//! with the checksum of their lines.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::output::encoding::label::{SCENE, SOFTWARE, scene_text};
use crate::scene::{Projection, Scene};

/// What the last line says before the checksum of those above.
const CHECKSUM_LINE: &str = "# CRC-32 of the lines above: ";

/// Checks that the picture of a scene, `what`, is among the outputs, that it can be named in the scene, where `quote`
/// ends a name, and that the camera shows the whole sphere.
pub(super) fn check_picture(
    path: &Path,
    picture: &Path,
    outputs: &[PathBuf],
    scene: &Scene,
    (what, quote): (&str, char),
) -> Result<()> {
    let wrong = |complaint: String| Err(Error::FileName { path: path.to_owned(), complaint });
    if !outputs.iter().any(|output| output == picture) {
        return wrong(format!("{what} needs its picture beside it: -o {} too", picture.display()));
    }
    if picture.to_str().is_none_or(|name| name.contains(quote) || name.contains(char::is_control)) {
        return wrong(format!("{what} cannot name a file with such characters; choose another name"));
    }
    if scene.camera.projection != Projection::Equirectangular {
        let complaint = format!("must be equirectangular for {what}, whose sky is the whole sphere");
        return Err(Error::not_allowed("camera.projection", complaint));
    }
    Ok(())
}

/// What a file says of itself, in comments, with `more` lines of them before the scene.
pub(super) fn label(scene: &Scene, more: &str) -> String {
    let lines: String = scene_text(scene).lines().map(|line| format!("# {SCENE}: {line}\n")).collect();
    format!("# {SOFTWARE}\n{more}{lines}")
}

/// Whether a text is a whole file that begins so.
pub(super) fn is_whole(text: &str, begins: &str) -> bool {
    let Some((above, checksum)) = text.rsplit_once(CHECKSUM_LINE) else { return false };
    above.starts_with(begins) && checksum == format!("{:08x}\n", crc32fast::hash(above.as_bytes()))
}

/// Writes lines, and their checksum.
pub(super) fn write(output: &mut impl Write, text: &str) -> io::Result<()> {
    writeln!(output, "{text}{CHECKSUM_LINE}{:08x}", crc32fast::hash(text.as_bytes()))
}
