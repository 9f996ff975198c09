//! What a file says of itself: the program that wrote it and the scene that it shows, so that it can be rendered again,
//! and told from another; and the names of its channels.

use std::fmt::Write;

use super::spectral::Spectra;
use crate::scene::{self, Scene, keys};
use crate::spectra::named_file::NamedFile;

/// The program, as files name it.
pub(crate) const SOFTWARE: &str = concat!("sorairo ", env!("CARGO_PKG_VERSION"));

/// The keyword of the text of a PNG that names it.
pub(crate) const SOFTWARE_KEYWORD: &str = "Software";

/// The name of the attribute of an EXR, and the keyword of the text of a PNG, that hold the scene in TOML.
pub(crate) const SCENE: &str = "sorairoScene";

/// The name of the attribute of an EXR that holds by how many stops its values are exposed.
pub(crate) const EXPOSURE: &str = "sorairoExposure";

/// The scene as files hold it: in TOML with the sun where it stands, and in comments the place and the time that put it
/// there, and the checksums of the tables that the scene only names.
pub(crate) fn scene_text(scene: &Scene) -> String {
    // A scene that was rendered can be placed.
    let mut placed = scene.placed().unwrap_or_else(|_| scene.clone());
    keys::change_names(&mut placed, NamedFile::go_by_name);
    let mut text = scene::file::text(&placed);
    if let Some((place, time)) = scene.sun.place.zip(scene.sun.time) {
        let _ = writeln!(text, "# sun.place = \"{place}\"\n# sun.time = \"{time}\"");
    }
    for (key, _, checksum) in keys::files(scene) {
        // A text takes whatever is written to it.
        let _ = writeln!(text, "# CRC-32 of {key}: {checksum:08x}");
    }
    text
}

/// The channels of a file, in the order of the alphabet, which is the format's: linear RGB, and spectra.
pub(crate) fn channel_names(spectra: &Spectra) -> Vec<String> {
    ["B", "G", "R"].map(str::to_owned).into_iter().chain(spectra.channel_names()).collect()
}
