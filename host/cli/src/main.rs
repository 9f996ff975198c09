//! The command `sorairo`.

use std::process::ExitCode;

fn main() -> ExitCode {
    sorairo_cli::run()
}
