//! What a file says of itself: the program that wrote it and the scene that it shows, so that it can be rendered again, and told
//! from another.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use ::exr::block::reader::ChunksReader;
use ::exr::meta::attribute::{AttributeValue, Text};

use super::{Format, exr};
use crate::scene::{self, Scene};

/// The program, as files name it.
pub(super) const SOFTWARE: &str = concat!("sorairo ", env!("CARGO_PKG_VERSION"));

/// The name of the attribute of an EXR, and the keyword of the text of a PNG, that hold the scene in TOML.
pub(super) const SCENE: &str = "sorairoScene";

/// Whether a file is whole, and was written by this version of the program for this scene; a spectral file, for these wavelengths
/// (nm).
///
/// The file is decoded to its end: what was cut off or damaged is not whole.
pub fn is_finished(path: &Path, format: Format, scene: &Scene, wavelengths: &[f64]) -> bool {
    let Ok(file) = File::open(path) else { return false };
    let file = BufReader::new(file);
    let decoded = match format {
        Format::Png => decode_png(file),
        Format::Exr => decode_exr(file, &exr::channel_names(&[])),
        Format::SpectralExr => decode_exr(file, &exr::channel_names(wavelengths)),
    };
    decoded.is_some_and(|(software, text)| software == SOFTWARE && text == scene::file::text(scene))
}

/// Program and scene of a PNG that decodes to its end.
fn decode_png(file: BufReader<File>) -> Option<(String, String)> {
    let mut reader = ::png::Decoder::new(file).read_info().ok()?;
    let texts = &reader.info().utf8_text;
    let text = |keyword: &str| texts.iter().find(|chunk| chunk.keyword == keyword)?.get_text().ok();
    let named = (text("Software")?, text(SCENE)?);
    while reader.next_row().ok()?.is_some() {}
    Some(named)
}

/// Program and scene of an EXR of these channels that decodes to its end.
fn decode_exr(file: BufReader<File>, channels: &[String]) -> Option<(String, String)> {
    let reader = ::exr::block::read(file, true).ok()?;
    let header = reader.headers().first()?;
    if !header.channels.list.iter().map(|channel| channel.name.to_string()).eq(channels.iter().cloned()) {
        return None;
    }
    let software = header.own_attributes.software_name.as_ref()?.to_string();
    let AttributeValue::Text(scene) = header.shared_attributes.other.get(&Text::from(SCENE))? else { return None };
    let scene = scene.to_string();
    let mut blocks = reader.all_chunks(true).ok()?.sequential_decompressor(true);
    blocks.all(|block| block.is_ok()).then_some((software, scene))
}
