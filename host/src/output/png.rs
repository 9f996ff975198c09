//! Pictures: 8 bit sRGB in PNG.

use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageError};
use rayon::prelude::*;
use sorairo_shared::color::{into_gamut, srgb8};
use sorairo_shared::glam::Vec3;

use super::{LinearImage, Staged, stage};
use crate::error::Result;
use crate::plan::colour_space::ColourSpace;

/// The bytes (red, green, blue) of packed pixels.
pub fn unpack(pixels: &[u32]) -> Vec<u8> {
    pixels.iter().flat_map(|pixel| pixel.to_le_bytes().into_iter().take(3)).collect()
}

/// The bytes (red, green, blue) of a linear image, exposed as the kernels would. The image is in `space`, the picture in
/// `display`, which is sRGB under the same white balance.
pub fn expose(image: &LinearImage, exposure: f32, space: &ColourSpace, display: &ColourSpace) -> Vec<u8> {
    let matrix = (display.from_xyz * space.from_xyz.inverse()).as_mat3();
    let gamut = display.for_kernels();
    let shown = |rgb: Vec3| if space == display { rgb } else { into_gamut(matrix * rgb, &gamut) };
    let mut bytes = vec![0; image.rgb.len()];
    bytes.par_chunks_mut(3).zip(image.rgb.par_chunks(3)).for_each(|(bytes, rgb)| {
        bytes.copy_from_slice(&srgb8(shown(Vec3::from_slice(rgb)), exposure).to_le_bytes()[..3]);
    });
    bytes
}

/// Writes a picture beside its place.
///
/// # Errors
///
/// [`crate::Error::Failure`] if the file cannot be written.
pub fn write(path: &Path, width: u32, height: u32, rgb: &[u8]) -> Result<Staged> {
    stage(path, |writer| {
        PngEncoder::new_with_quality(writer, CompressionType::Fast, FilterType::Adaptive)
            .write_image(rgb, width, height, ExtendedColorType::Rgb8)
            .map_err(|error| match error {
                ImageError::IoError(error) => error,
                other => std::io::Error::other(other),
            })
    })
}
