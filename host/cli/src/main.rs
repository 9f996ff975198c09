//! The command `sorairo`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(sorairo_cli::run(std::env::args_os()))
}
