//! Whether a file is there already: whole, by this version of the program, and of the same scene.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::Path;

use ::exr::meta::MetaData;
use ::exr::meta::attribute::{AttributeValue, Text};
use crc32fast::Hasher;

use super::format::Format;
use super::{hdr, radiance_picture, radiance_scene, usd_scene};
use crate::output::encoding::checksum;
use crate::output::encoding::label::{SCENE, SOFTWARE, SOFTWARE_KEYWORD, channel_names, scene_text};
use crate::output::encoding::spectral::{FRAME, Spectra, frame_text};
use crate::scene::Scene;

/// Whether a file is whole, and was written by this version of the program for this scene; a spectral file, of these
/// spectra.
///
/// Every byte of the file counts: one that is missing, changed or added makes it another.
pub fn is_finished(path: &Path, format: Format, scene: &Scene, spectra: &Spectra) -> bool {
    let Some(file) = open(path) else { return false };
    let wavelengths = &spectra.wavelengths;
    let label = match format {
        Format::RadiancePicture => {
            let size = scene.camera.size;
            let header = |checksum| radiance_picture::header(size.width, size.height, scene, wavelengths, checksum);
            return has_header_and_checksum(&mut BufReader::new(file), header).unwrap_or(false);
        }
        Format::Hdr => {
            let header = |checksum| hdr::header(scene, checksum);
            return has_header_and_checksum(&mut BufReader::new(file), header).unwrap_or(false);
        }
        Format::RadianceScene => {
            let text = io::read_to_string(file);
            return text.is_ok_and(|text| radiance_scene::is_whole(&text, scene, wavelengths));
        }
        Format::UsdScene => {
            let text = io::read_to_string(file);
            return text.is_ok_and(|text| usd_scene::is_whole(&text, path, scene));
        }
        Format::Png => png_texts(file, SCENE),
        Format::Exr | Format::SpectralExr => {
            let none = Spectra::default();
            let spectra = if format == Format::Exr { &none } else { spectra };
            let (channels, frame) = (channel_names(spectra), spectra.stokes.map(frame_text));
            let is_same = |label: &ExrLabel| label.channels == channels && label.frame.as_deref() == frame;
            exr_label(file).filter(is_same).map(|label| (label.software, label.scene))
        }
    };
    label.is_some_and(|(software, text)| software == SOFTWARE && text == scene_text(scene))
}

/// All that [`is_finished`] asks of a file, as a text: files of which it is the same may stand for each other.
pub fn signature(format: Format, scene: &Scene, spectra: &Spectra) -> String {
    format!("{SOFTWARE}\n{format:?}\n{spectra:?}\n{}", scene_text(scene))
}

/// Whether a file is a picture or an EXR that is whole and was written by this program, whatever its version and its
/// scene.
pub fn is_own(path: &Path) -> bool {
    let Some(file) = open(path) else { return false };
    let software = match Format::of(path, false) {
        Ok(Format::Png) => png_texts(file, SOFTWARE_KEYWORD).map(|(software, _)| software),
        Ok(Format::Exr | Format::SpectralExr) => exr_label(file).map(|label| label.software),
        _ => None,
    };
    software.is_some_and(|software| software.split(' ').next() == Some(env!("CARGO_PKG_NAME")))
}

/// The text of a PNG under a keyword, if the file is whole and this version of the program wrote it.
pub fn png_text(path: &Path, keyword: &str) -> Option<String> {
    let (software, text) = png_texts(open(path)?, keyword)?;
    (software == SOFTWARE).then_some(text)
}

/// An ordinary file; to open a pipe is to wait for whoever writes into it.
fn open(path: &Path) -> Option<File> {
    if path.is_file() { File::open(path).ok() } else { None }
}

/// Whether a picture of Radiance has the header of its scene, and pixels with the checksum that it names.
fn has_header_and_checksum(file: &mut impl BufRead, header: impl Fn(u32) -> String) -> io::Result<bool> {
    let mut begin = vec![0; header(0).len()];
    file.read_exact(&mut begin)?;
    let mut pixels = Hasher::new();
    checksum::update(&mut pixels, file)?;
    Ok(begin == header(pixels.finalize()).as_bytes())
}

/// Program of a PNG that is whole, and its text under a keyword.
fn png_texts(file: File, keyword: &str) -> Option<(String, String)> {
    let mut file = BufReader::new(file);
    if !is_whole_png(&mut file).ok()? {
        return None;
    }
    file.rewind().ok()?;
    let reader = ::png::Decoder::new(file).read_info().ok()?;
    let texts = &reader.info().utf8_text;
    let text = |keyword: &str| texts.iter().find(|chunk| chunk.keyword == keyword)?.get_text().ok();
    Some((text(SOFTWARE_KEYWORD)?, text(keyword)?))
}

/// Whether a file is a PNG whose chunks have their checksums, and nothing after the last.
fn is_whole_png(file: &mut impl BufRead) -> io::Result<bool> {
    const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
    if array(file)? != SIGNATURE {
        return Ok(false);
    }
    loop {
        let (length, kind): ([u8; 4], [u8; 4]) = (array(file)?, array(file)?);
        let mut hasher = Hasher::new();
        hasher.update(&kind);
        let length = u64::from(u32::from_be_bytes(length));
        if checksum::update(&mut hasher, &mut file.take(length))? != length
            || array(file)? != hasher.finalize().to_be_bytes()
        {
            return Ok(false);
        }
        if kind == *b"IEND" {
            return Ok(file.fill_buf()?.is_empty());
        }
    }
}

fn array<const N: usize>(file: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    file.read_exact(&mut bytes).map(|()| bytes)
}

/// What an EXR says of itself.
struct ExrLabel {
    software: String,
    scene: String,
    channels: Vec<String>,
    /// From where polarisation counts.
    frame: Option<String>,
}

/// What an EXR says of itself, if it is whole.
fn exr_label(mut file: File) -> Option<ExrLabel> {
    if !checksum::is_right(&file).ok()? {
        return None;
    }
    file.rewind().ok()?;
    let meta = MetaData::read_from_buffered(BufReader::new(file), true).ok()?;
    let header = meta.headers.first()?;
    let channels = header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
    let software = header.own_attributes.software_name.as_ref()?.to_string();
    let text = |name: &str| match header.own_attributes.other.get(&Text::from(name)) {
        Some(AttributeValue::Text(text)) => Some(text.to_string()),
        _ => None,
    };
    Some(ExrLabel { software, scene: text(SCENE)?, channels, frame: text(FRAME) })
}
