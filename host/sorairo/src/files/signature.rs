//! Whether a file is there already: whole, by this version of the program, and of the same scene.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use ::exr::block::reader::ChunksReader;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{AttributeValue, Text};
use crc32fast::Hasher;

use super::format::Format;
use super::label::{CHECKSUM, SCENE, SOFTWARE, channel_names, scene_text};
use crate::scene::Scene;

/// Whether a file is whole, and was written by this version of the program for this scene; a spectral file, for these wavelengths
/// (nm).
///
/// The file is decoded to its end: what was cut off or damaged is not whole.
pub fn is_finished(path: &Path, format: Format, scene: &Scene, wavelengths: &[f64]) -> bool {
    let Ok(file) = File::open(path) else { return false };
    let file = BufReader::new(file);
    let decoded = match format {
        Format::Png => decode_png(file),
        Format::Exr => decode_exr(file, &channel_names(&[])),
        Format::SpectralExr => decode_exr(file, &channel_names(wavelengths)),
    };
    decoded.is_some_and(|(software, text)| software == SOFTWARE && text == scene_text(scene))
}

/// Program and scene of a PNG that decodes to its end.
fn decode_png(file: BufReader<File>) -> Option<(String, String)> {
    let mut reader = ::png::Decoder::new(file).read_info().ok()?;
    let texts = &reader.info().utf8_text;
    let text = |keyword: &str| texts.iter().find(|chunk| chunk.keyword == keyword)?.get_text().ok();
    let named = (text("Software")?, text(SCENE)?);
    while reader.next_row().ok()?.is_some() {}
    reader.finish().ok()?;
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
    let attribute = |name: &str| header.own_attributes.other.get(&Text::from(name));
    let AttributeValue::Text(scene) = attribute(SCENE)? else { return None };
    let scene = scene.to_string();
    let &AttributeValue::I32(checksum) = attribute(CHECKSUM)? else { return None };
    let mut hasher = Hasher::new();
    for (line, block) in reader.all_chunks(true).ok()?.sequential_decompressor(true).enumerate() {
        let block = block.ok().filter(|block| block.index.pixel_position == Vec2(0, line))?;
        hasher.update(&block.data);
    }
    (hasher.finalize() == checksum.cast_unsigned()).then_some((software, scene))
}
