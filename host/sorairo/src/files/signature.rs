//! What a file says of itself: the program that wrote it and the scene that it shows, so that it can be rendered again, and told
//! from another.

use std::fmt::Write;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use ::exr::block::reader::ChunksReader;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{AttributeValue, Text};
use crc32fast::Hasher;

use super::{Format, exr};
use crate::scene::{self, AlbedoSpectrum, OzoneCrossSection, Scene, SunSpectrum};
use crate::spectra::tables::TableFile;

/// The program, as files name it.
pub(super) const SOFTWARE: &str = concat!("sorairo ", env!("CARGO_PKG_VERSION"));

/// The name of the attribute of an EXR, and the keyword of the text of a PNG, that hold the scene in TOML.
pub(super) const SCENE: &str = "sorairoScene";

/// The name of the attribute of an EXR that holds the CRC-32 of its lines before their compression, from the top: the format
/// itself has nothing that tells damaged pixels. PNG has a CRC-32 in every chunk.
pub(super) const CHECKSUM: &str = "sorairoChecksum";

/// The scene as files hold it: in TOML, and in comments the checksums of the tables that it only names.
pub(super) fn scene_text(scene: &Scene) -> String {
    let mut text = scene::file::text(scene);
    for (key, table) in tables(scene) {
        // A text takes whatever is written to it.
        let _ = writeln!(text, "# CRC-32 of {key}: {:08x}", table.checksum());
    }
    text
}

/// The tables of a person's own in a scene, by the names of their keys.
fn tables(scene: &Scene) -> impl Iterator<Item = (&'static str, &TableFile)> {
    let sun = match &scene.sun.spectrum {
        SunSpectrum::File(table) => Some(("sun.spectrum", table)),
        _ => None,
    };
    let albedo = match &scene.atmosphere.aerosol.single_scattering_albedo_spectrum {
        AlbedoSpectrum::File(table) => Some(("atmosphere.aerosol.single_scattering_albedo_spectrum", table)),
        _ => None,
    };
    let ozone = match &scene.atmosphere.ozone.cross_section {
        OzoneCrossSection::File(table) => Some(("atmosphere.ozone.cross_section", table)),
        _ => None,
    };
    sun.into_iter().chain(albedo).chain(ozone)
}

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
