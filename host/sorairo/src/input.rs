//! User input, read up to a size limit so that a wrong file name costs neither time nor memory, and its formatting.

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest scene file (bytes); the reader of TOML takes up to 90 times as much memory.
#[cfg(feature = "scene-files")]
pub const LARGEST_SCENE: u64 = 256 << 10;

/// Largest table of a spectrum (bytes): some 200 000 rows.
pub const LARGEST_TABLE: u64 = 4 << 20;

/// Reads a file of UTF-8 text that holds at most `largest` bytes; a byte order mark at its start is left out.
///
/// # Errors
///
/// What is wrong, in words that follow the file's name: `cannot be read: ...`, `is larger than ...`,
/// `is not UTF-8 text`.
pub fn read_text(path: &Path, largest: u64) -> Result<String, String> {
    let unreadable = |error: std::io::Error| format!("cannot be read: {error}");
    let file = File::open(path).map_err(unreadable)?;
    let too_large = || format!("is larger than {} KiB, the most that is read", largest >> 10);
    if file.metadata().is_ok_and(|metadata| metadata.is_file() && metadata.len() > largest) {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    // A pipe or a device does not say how long it is.
    file.take(largest + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > largest {
        return Err(too_large());
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let line =
            1 + error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|&&byte| byte == b'\n').count();
        format!("is not UTF-8 text, from line {line} on")
    })?;
    Ok(without_mark(&text).to_owned())
}

/// The text without a byte order mark at its start.
pub fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

/// A number in its shortest readable form, with an exponent if it would be long.
pub fn shown(number: f64) -> String {
    if number == 0.0 || (1e-9..1e12).contains(&number.abs()) { number.to_string() } else { format!("{number:e}") }
}

/// A part of light in per cent: of more than all of it, that alone.
pub(crate) fn percent(part: f64) -> String {
    if part > 1.0 { "more than 100 %".into() } else { format!("{:.1} %", 100.0 * part) }
}
