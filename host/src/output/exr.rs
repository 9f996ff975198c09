//! Linear images in OpenEXR.

use std::path::Path;

use exr::prelude::*;
use sorairo_shared::math::half_bits;

use super::{LinearImage, Staged, stage};
use crate::error::Result;
use crate::scene::ExrDepth;

/// The chromaticities of Rec. 709 and D65 (ITU-R BT.709-6, items 1.3 and 1.4).
fn rec709() -> attribute::Chromaticities {
    attribute::Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.3, 0.6),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    }
}

/// Writes linear Rec. 709 RGB, losslessly compressed, with its chromaticities, beside its place.
///
/// # Errors
///
/// [`crate::Error::Failure`] if the file cannot be written.
pub fn write(path: &Path, image: &LinearImage, depth: ExrDepth) -> Result<Staged> {
    let at = |position: Vec2<usize>| 3 * (position.y() * image.width + position.x());
    let rgb = |position| [0, 1, 2].map(|channel| image.rgb[at(position) + channel]);
    let half = |value: f32| f16::from_bits(half_bits(value) as u16);
    match depth {
        ExrDepth::Full => write_channels(path, image.width, image.height, |position| rgb(position).into()),
        ExrDepth::Half => write_channels(path, image.width, image.height, |position| rgb(position).map(half).into()),
    }
}

/// [`write`] of half floats as the device packed them: two words a pixel.
///
/// # Errors
///
/// [`crate::Error::Failure`] if the file cannot be written.
pub fn write_half(path: &Path, width: usize, height: usize, words: &[u32]) -> Result<Staged> {
    write_channels(path, width, height, |position| {
        let at = 2 * (position.y() * width + position.x());
        let half = |bits: u32| f16::from_bits((bits & 0xffff) as u16);
        (half(words[at]), half(words[at] >> 16), half(words[at + 1]))
    })
}

fn write_channels<T: IntoSample + Sync + Send>(
    path: &Path,
    width: usize,
    height: usize,
    pixel: impl Fn(Vec2<usize>) -> (T, T, T) + Sync,
) -> Result<Staged> {
    let mut attributes = LayerAttributes::named("sky");
    attributes.comments = Some(
        "single scattering; radiance weighted by the CIE 1931 observer, W.m^-2.sr^-1, within the Rec. 709 gamut".into(),
    );
    attributes.software_name = Some(concat!("sorairo ", env!("CARGO_PKG_VERSION")).into());
    // Blocks are compressed by several threads; in any other order they would stand as they happened to be ready.
    let encoding = Encoding { line_order: LineOrder::Increasing, ..Encoding::FAST_LOSSLESS };
    let layer = Layer::new((width, height), attributes, encoding, SpecificChannels::rgb(pixel));
    let mut file = Image::from_layer(layer);
    file.attributes.chromaticities = Some(rec709());
    stage(path, |writer| {
        file.write().to_buffered(writer).map_err(|error| match error {
            Error::Io(error) => error,
            other => std::io::Error::other(other),
        })
    })
}
