//! Spectral images in OpenEXR, in the layout of Fichet, Pacanowski and Wilkie, *An OpenEXR Layout for Spectral Images* (JCGT 10(3),
//! 2021, <http://jcgt.org/published/0010/03/01/>).

use std::path::Path;

use exr::block::writer::ChunksWriter;
use exr::block::{self, UncompressedBlock, enumerate_ordered_header_block_indices};
use exr::meta::BlockDescription;
use exr::meta::header::Header;
use exr::prelude::*;
use sorairo_shared::math::half_bits;
use sorairo_shared::sky_spectrum::RGB_WORDS;

use super::exr::Labels;
use super::{Staged, stage};
use crate::error::Result;
use crate::scene::ExrDepth;

/// A spectral image: for each pixel its linear RGB and the radiance at each wavelength, as [`sorairo_shared::sky_spectrum`] stores
/// them.
pub struct SpectralImage<'a> {
    /// Width (pixels).
    pub width: usize,
    /// Height (pixels).
    pub height: usize,
    /// Wavelengths (nm), increasing.
    pub wavelengths: &'a [f64],
    /// The pixels' words, row by row from the top.
    pub words: &'a [u32],
}

/// The layout's only unit of emission, and why values per nanometre fit it.
const UNIT_NOTE: &str = "each S0 channel holds the radiance of the band 1 nm wide around its wavelength: \
    the spectral radiance in W.m^-2.sr^-1.nm^-1 times 1 nm";

/// The name of a wavelength's channel: the total radiance S0, the wavelength in nm with six decimals after a comma.
pub fn channel_name(wavelength: f64) -> String {
    format!("S0.{}nm", format!("{wavelength:.6}").replace('.', ","))
}

/// Writes a spectral image, losslessly compressed, beside its place.
///
/// # Errors
///
/// [`crate::Error::Failure`] if the file cannot be written.
pub fn write(path: &Path, image: &SpectralImage, labels: &Labels, depth: ExrDepth) -> Result<Staged> {
    let header = header(image, labels, depth);
    let row_words = image.width * (RGB_WORDS as usize + image.wavelengths.len());
    stage(path, |writer| {
        let written = block::write(writer, [header].into_iter().collect(), true, |meta, chunks| {
            let blocks = enumerate_ordered_header_block_indices(&meta.headers).map(|(at, index)| {
                let rows = index.pixel_position.y()..index.pixel_position.y() + index.pixel_size.height();
                let words = &image.words[rows.start * row_words..rows.end * row_words];
                (at, UncompressedBlock { index, data: lines(words, row_words, image.width, depth) })
            });
            chunks.on_progress(|_| {}).compress_all_blocks_parallel(&meta, blocks)
        });
        written.map_err(|error| match error {
            Error::Io(error) => error,
            other => std::io::Error::other(other),
        })
    })
}

fn header(image: &SpectralImage, labels: &Labels, depth: ExrDepth) -> Header {
    let sample = match depth {
        ExrDepth::Half => SampleType::F16,
        ExrDepth::Full => SampleType::F32,
    };
    // In the order of their names, as the format wants it; all wavelengths have three digits before the comma.
    let names =
        ["B", "G", "R"].map(str::to_owned).into_iter().chain(image.wavelengths.iter().map(|&nm| channel_name(nm)));
    let channels = names.map(|name| ChannelDescription::named(name.as_str(), sample)).collect();
    let mut attributes = labels.layer();
    for (name, text) in
        [("spectralLayoutVersion", "1.0"), ("emissiveUnits", "W.m^-2.sr^-1"), ("emissiveUnitsNote", UNIT_NOTE)]
    {
        attributes.other.insert(name.into(), AttributeValue::Text(text.into()));
    }
    let size = Vec2(image.width, image.height);
    let mut shared = ImageAttributes::with_size(size);
    shared.chromaticities = Some(labels.chromaticities());
    Header::new("sky".into(), size, channels)
        .with_encoding(Compression::ZIP16, BlockDescription::ScanLines, LineOrder::Increasing)
        .with_attributes(attributes)
        .with_shared_attributes(shared)
}

/// The bytes of some whole rows as the format stores them: for each row, all samples of its first channel, then of the next.
fn lines(words: &[u32], row_words: usize, width: usize, depth: ExrDepth) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(words.len() * if depth == ExrDepth::Full { 4 } else { 2 });
    let pixel = row_words / width;
    for row in words.chunks(row_words) {
        // Blue, green, red, then the wavelengths.
        for channel in [2, 1, 0].into_iter().chain(RGB_WORDS as usize..pixel) {
            for word in row.iter().skip(channel).step_by(pixel) {
                match depth {
                    ExrDepth::Full => bytes.extend(word.to_ne_bytes()),
                    ExrDepth::Half => bytes.extend((half_bits(f32::from_bits(*word)) as u16).to_ne_bytes()),
                }
            }
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_is_named_by_its_wavelength_with_a_comma() {
        assert_eq!(channel_name(550.0), "S0.550,000000nm");
        assert_eq!(channel_name(360.125), "S0.360,125000nm");
    }

    #[test]
    fn a_row_is_stored_channel_by_channel() {
        // Two rows of two pixels with one wavelength.
        let words: Vec<u32> = (0..16).collect();
        let stored: Vec<u32> = lines(&words, 8, 2, ExrDepth::Full)
            .chunks(4)
            .map(|bytes| u32::from_ne_bytes(bytes.try_into().unwrap()))
            .collect();
        assert_eq!(stored, [2, 6, 1, 5, 0, 4, 3, 7, 10, 14, 9, 13, 8, 12, 11, 15]);
    }
}
