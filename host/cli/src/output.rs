//! What the command says: results on standard output, all else on standard error.

use std::io::{self, ErrorKind, IsTerminal, Write};

use crate::error::{Error, Result};

/// Prints to standard error; where nobody can be told, the work still counts.
pub fn print_note(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Ends the line of a progress that is shown on a terminal, and leaves it as it is.
pub fn end_line() {
    if io::stderr().is_terminal() {
        print_note("");
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

/// Prints the warnings of the library, and what else the variable `RUST_LOG` asks for, to standard error.
pub fn print_warnings() {
    env_logger::Builder::new()
        .filter_module("sorairo", log::LevelFilter::Warn)
        .parse_default_env()
        .format(|line, record| writeln!(line, "sorairo: {}", record.args()))
        .init();
}
