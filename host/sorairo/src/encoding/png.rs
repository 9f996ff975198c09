//! Pictures: 8 bit sRGB in PNG.

use std::io::{self, Write};

use ::png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter, SrgbRenderingIntent};

use super::label::{SOFTWARE, SOFTWARE_KEYWORD};

/// The bytes (red, green, blue) of packed pixels.
pub fn unpack(pixels: &[u32]) -> Vec<u8> {
    pixels.iter().flat_map(|pixel| pixel.to_le_bytes().into_iter().take(3)).collect()
}

/// Encodes a picture whose bytes `fill` writes, from the top, and a text under its keyword.
///
/// The difference from the pixel to the left and the fastest deflate are both the fastest choice and the smallest fast one for
/// the smooth gradients of a sky: 6.6 ms for 1920×960 pixels against 9 to 11 ms for other filters and 49 ms upwards for
/// other deflates, in 0.29 MB against 0.33 to 4.1 MB and 0.16 MB upwards (one core of a Xeon at 2.5 GHz).
pub(crate) fn encode(
    output: &mut impl Write,
    width: u32,
    height: u32,
    text: Option<(&str, String)>,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let plain = |error: EncodingError| match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    };
    let mut encoder = Encoder::new(output, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Sub);
    // The picture is made for the eye already: brought into range, and into the gamut.
    encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
    encoder.add_itxt_chunk(SOFTWARE_KEYWORD.into(), SOFTWARE.into()).map_err(plain)?;
    if let Some((keyword, text)) = text {
        encoder.add_itxt_chunk(keyword.into(), text).map_err(plain)?;
    }
    let mut writer = encoder.write_header().map_err(plain)?;
    let mut rows = writer.stream_writer().map_err(plain)?;
    fill(&mut rows)?;
    rows.finish().map_err(plain)
}
