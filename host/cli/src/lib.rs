//! The command line of sorairo.

mod aerial;
pub mod arguments;
mod between;
mod cases;
mod contact_sheet;
mod devices;
mod directions;
pub mod error;
#[cfg(feature = "evaluation")]
mod evaluation;
pub mod flags;
mod frames;
mod help;
mod known;
mod manifest;
mod memory;
mod output;
mod polarisation_map;
mod progress;
mod ranges;
mod render;
mod scene;
mod sequence;
mod sheet;
mod spectrum;
mod table;
mod values;
mod view;

use std::ffi::OsString;

use clap::Parser;
use sorairo::{files, threads};

use arguments::{Arguments, Command};
use error::Result;

/// The exit code of a process that was asked to stop, as shells give it for SIGINT.
const INTERRUPTED: i32 = 130;

/// Runs the command that a process was started with, the first of whose arguments is its own name, and says how it
/// ended: 0, 1 for a failure, 2 for a wrong request. For arguments that are none of a command, and for questions such
/// as `--help`, it ends the process.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments = Arguments::parse_from(arguments);
    if arguments.quiet {
        output::be_quiet();
    }
    output::print_warnings();
    fail_at_the_file_size_limit();
    memory::fail_at_the_limit();
    // Without it an interruption still ends the process, and the next run removes what it leaves.
    let _ = ctrlc::set_handler(interrupted);
    match threads::start().map_err(Into::into).and_then(|()| dispatch(arguments.command)) {
        Ok(()) => 0,
        Err(error) => {
            output::print_error(&format!("sorairo: {error}"));
            error.exit_code()
        }
    }
}

fn dispatch(command: Command) -> Result<()> {
    match command {
        Command::Render(arguments) => render::run(&arguments),
        Command::Sequence(arguments) => sequence::run(&arguments),
        Command::Spectrum(arguments) => spectrum::run(&arguments),
        Command::Between(arguments) => between::run(&arguments),
        Command::Aerial(arguments) => aerial::run(&arguments),
        Command::View(arguments) => view::run(&arguments),
        #[cfg(feature = "evaluation")]
        Command::Evaluation(command) => evaluation::run(&command),
        Command::Devices(arguments) => devices::run(&arguments),
        Command::Scene(command) => scene::run(&command),
        Command::Completions { shell } => help::completions(shell),
        Command::Man { command } => help::man(command.as_deref()),
    }
}

/// Lets a write beyond the largest file that is allowed fail, which is told; by default it ends the process.
fn fail_at_the_file_size_limit() {
    #[cfg(unix)]
    // Without it the process ends as it would, and the next run removes what it leaves.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
}

fn interrupted() {
    output::end_line();
    output::print_error("sorairo: interrupted; files that were not finished are removed");
    let _until_the_end = files::remove_unfinished();
    std::process::exit(INTERRUPTED)
}
