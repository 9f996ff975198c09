//! What the command says: results on standard output, all else on standard error.

use std::borrow::Cow;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, Result};

/// Whether nothing but errors and warnings is said beside results.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Says from now on nothing but errors and warnings beside results.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Whether nothing but errors and warnings is said beside results.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints what is good to know to standard error.
pub fn print_note(text: &str) {
    if !is_quiet() {
        print_error(text);
    }
}

/// Prints to standard error; where nobody can be told, the work still counts.
pub fn print_error(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", visible(text));
}

/// A text without what steers a terminal: control characters but ends of lines, and marks that turn the direction of
/// writing, are written as escapes. File names and values of scene files can hold any of them.
fn visible(text: &str) -> Cow<'_, str> {
    let steers = |c: char| {
        (c.is_control() && c != '\n')
            || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(steers) {
        return text.into();
    }
    let escaped = |c: char| if steers(c) { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(escaped).collect::<String>().into()
}

/// Ends the line of a progress that is shown on a terminal, and leaves it as it is.
pub fn end_line() {
    if io::stderr().is_terminal() {
        print_error("");
    }
}

/// Prints to standard output; a reader that has seen enough and closed the pipe is no failure.
///
/// # Errors
///
/// [`Error::Failure`] if it cannot be written for any other reason.
pub fn print_line(text: &str) -> Result<()> {
    match writeln!(io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::Failure(format!("standard output cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// Refuses a file that would take the place of the scene's own.
///
/// # Errors
///
/// [`Error::Request`] if one does.
pub fn refuse_scene_as_output<'a>(scene: Option<&Path>, outputs: impl Iterator<Item = &'a PathBuf>) -> Result<()> {
    let Some(scene) = scene.and_then(|path| path.canonicalize().ok()) else { return Ok(()) };
    let mut outputs = outputs;
    match outputs.find(|path| path.canonicalize().is_ok_and(|path| path == scene)) {
        Some(path) => {
            Err(Error::request(format!("-o {}: this is the scene file, which stays as it is", path.display())))
        }
        None => Ok(()),
    }
}

/// Prints the warnings of the library, and what else the variable `RUST_LOG` asks for, to standard error.
pub fn print_warnings() {
    env_logger::Builder::new()
        .filter_module("sorairo", log::LevelFilter::Warn)
        .parse_default_env()
        .format(|line, record| writeln!(line, "sorairo: {}", visible(&record.args().to_string())))
        .init();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_steers_a_terminal_is_printed() {
        assert_eq!(visible("a.toml: é 空色\nline"), "a.toml: é 空色\nline");
        assert_eq!(visible("\u{1b}[2J\u{7f}\u{9b}\r\t"), "\\u{1b}[2J\\u{7f}\\u{9b}\\r\\t");
        assert_eq!(visible("gpj.\u{202e}exe"), "gpj.\\u{202e}exe");
    }
}
