//! The command line of sorairo.

pub mod arguments;
mod contact_sheet;
mod devices;
pub mod error;
#[cfg(feature = "evaluation")]
mod evaluation;
pub mod flags;
mod frames;
mod help;
mod output;
mod progress;
mod ranges;
mod render;
mod scene;
mod sequence;
mod spectrum;
mod view;

use std::process::ExitCode;

use clap::Parser;
use sorairo::low_level::files;

use arguments::{Arguments, Command};
use error::Result;

/// The exit code of a process that was asked to stop, as shells give it for SIGINT.
const INTERRUPTED: i32 = 130;

/// Runs the command that the process was started with, and says how it ended: 0, 1 for a failure, 2 for a wrong request.
pub fn run() -> ExitCode {
    let arguments = Arguments::parse();
    output::print_warnings();
    // Without it an interruption still ends the process, and the next run removes what it leaves.
    let _ = ctrlc::set_handler(interrupted);
    match dispatch(arguments.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            output::print_note(&format!("sorairo: {error}"));
            ExitCode::from(error.exit_code())
        }
    }
}

fn dispatch(command: Command) -> Result<()> {
    match command {
        Command::Render(arguments) => render::run(&arguments),
        Command::Sequence(arguments) => sequence::run(&arguments),
        Command::Spectrum(arguments) => spectrum::run(&arguments),
        Command::View(arguments) => view::run(&arguments),
        #[cfg(feature = "evaluation")]
        Command::Evaluation(command) => evaluation::run(&command),
        Command::Devices(arguments) => devices::run(&arguments),
        Command::Scene(command) => scene::run(&command),
        Command::Completions { shell } => help::completions(shell),
        Command::Man { command } => help::man(command.as_deref()),
    }
}

fn interrupted() {
    output::end_line();
    output::print_note("sorairo: interrupted; files that were not finished are removed");
    files::remove_unfinished();
    std::process::exit(INTERRUPTED)
}
