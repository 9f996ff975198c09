//! Pictures: 8 bits in PNG.

use std::path::Path;

use super::staged::{Staged, stage};
use crate::error::Result;
use crate::output::encoding::png::encode;
pub use crate::output::encoding::png::unpack;
use crate::scene::Display;

/// Writes an sRGB picture of 8 bits (red, green, blue) beside its place.
///
/// # Errors
///
/// [`crate::Error::Write`] if it cannot be written.
pub fn write(path: &Path, width: u32, height: u32, rgb: &[u8]) -> Result<Staged> {
    stage(path, |output| encode(output, width, height, Display::Srgb, None, |rows| rows.write_all(rgb)))
}

/// The same for a display, with a text in it under a keyword, which [`super::png_text`] reads.
///
/// # Errors
///
/// [`crate::Error::Write`] if it cannot be written.
pub fn write_with_text(
    path: &Path,
    (width, height): (u32, u32),
    rgb: &[u8],
    display: Display,
    keyword: &str,
    text: &str,
) -> Result<Staged> {
    let text = Some((keyword, text.to_owned()));
    stage(path, |output| encode(output, width, height, display, text, |rows| rows.write_all(rgb)))
}
