//! Linear images in OpenEXR.

use std::path::Path;

use exr::prelude::*;

use super::{LinearImage, Staged, stage};

/// The chromaticities of Rec. 709 and D65 (ITU-R BT.709-6, items 1.3 and 1.4).
fn rec709() -> attribute::Chromaticities {
    attribute::Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.3, 0.6),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    }
}

/// Writes linear Rec. 709 RGB as 32 bit floats, losslessly compressed, with its chromaticities, beside its
/// place.
///
/// # Errors
///
/// [`crate::Error::Failure`] if the file cannot be written.
pub fn write(path: &Path, image: &LinearImage) -> crate::error::Result<Staged> {
    let pixel = |position: Vec2<usize>| {
        let at = 3 * (position.y() * image.width + position.x());
        (image.rgb[at], image.rgb[at + 1], image.rgb[at + 2])
    };
    let mut attributes = LayerAttributes::named("sky");
    attributes.comments = Some("single scattering; radiance weighted by the CIE 1931 observer, W.m^-2.sr^-1".into());
    attributes.software_name = Some(concat!("sorairo ", env!("CARGO_PKG_VERSION")).into());
    let layer =
        Layer::new((image.width, image.height), attributes, Encoding::FAST_LOSSLESS, SpecificChannels::rgb(pixel));
    let mut file = Image::from_layer(layer);
    file.attributes.chromaticities = Some(rec709());
    stage(path, |writer| {
        file.write().to_buffered(writer).map_err(|error| match error {
            Error::Io(error) => error,
            other => std::io::Error::other(other),
        })
    })
}
