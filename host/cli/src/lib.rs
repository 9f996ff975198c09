//! The command line of sorairo.

pub mod arguments;
mod contact_sheet;
pub mod error;
mod evaluation;
pub mod flags;
mod progress;
mod scene;
mod sequence;

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

use clap::{CommandFactory, Parser};
use sorairo::device::{self, gpu};
use sorairo::plan::Plan;
use sorairo::spectrum::{Sample, spectrum};
use sorairo::{PixelFormat, files, render};

use arguments::{
    Arguments, Command, DevicesArguments, RenderArguments, SpectrumArguments, SpectrumFormat, ViewArguments,
};
use error::{Error, Result};
use progress::Progress;

/// The exit code of a process that was asked to stop, as shells give it for SIGINT.
const INTERRUPTED: i32 = 130;

/// Runs the command that the process was started with, and says how it ended: 0, 1 for a failure, 2 for a wrong request.
pub fn run() -> ExitCode {
    let arguments = Arguments::parse();
    log::set_logger(&Warnings).expect("this is the only logger");
    log::set_max_level(log::LevelFilter::Warn);
    let interrupted = || {
        if io::stderr().is_terminal() {
            // The line of the progress is left as it is.
            print_note("");
        }
        print_note("sorairo: interrupted; files that were not finished are removed");
        files::remove_unfinished();
        std::process::exit(INTERRUPTED)
    };
    // Without it an interruption still ends the process, and the next run removes what it leaves.
    let _ = ctrlc::set_handler(interrupted);
    let result = match arguments.command {
        Command::Render(arguments) => render_command(&arguments),
        Command::Sequence(arguments) => sequence::run(&arguments),
        Command::Spectrum(arguments) => spectrum_command(&arguments),
        Command::View(arguments) => view_command(&arguments),
        Command::Bands(arguments) => evaluation::bands(&arguments),
        Command::Reproduce(arguments) => evaluation::reproduce(&arguments),
        Command::Bench(arguments) => evaluation::bench(&arguments),
        Command::Stress(arguments) => evaluation::stress(&arguments),
        Command::Devices(arguments) => devices_command(&arguments),
        Command::Scene(command) => scene::run(&command),
        Command::Completions { shell } => print_bytes(|out| {
            clap_complete::generate(shell, &mut Arguments::command(), "sorairo", out);
            Ok(())
        }),
        Command::Man { command } => man_command(command.as_deref()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            print_note(&format!("sorairo: {error}"));
            ExitCode::from(error.exit_code())
        }
    }
}

fn render_command(arguments: &RenderArguments) -> Result<()> {
    let scene = arguments.scene.scene()?;
    let progress = Progress::start();
    let report = render::render(
        &scene,
        &arguments.request(),
        || device::open(&arguments.scene.device),
        |stage| progress.stage(stage),
    );
    drop(progress);
    let report = report?;
    print_note(&arguments::summary(&report));
    if arguments.explain && !arguments.json {
        print_line(&report.explain.join("\n"))?;
    }
    if arguments.json {
        print_line(&serde_json::to_string(&report).expect("a report is plain data"))?;
    }
    Ok(())
}

fn spectrum_command(arguments: &SpectrumArguments) -> Result<()> {
    let plan = Plan::new(&arguments.scene.scene()?, PixelFormat::LinearRgb)?;
    if !arguments.scene.device.eq_ignore_ascii_case("auto") {
        // One ray needs no device, but a wrong name is as wrong here as anywhere.
        device::open(&arguments.scene.device)?;
    }
    let samples = spectrum(&plan, arguments.view_elevation, arguments.view_azimuth, &arguments.wavelengths)?;
    match arguments.format {
        SpectrumFormat::Csv => {
            let mut csv = String::from("wavelength_nm,radiance,dense");
            for Sample { wavelength_nm, radiance, dense } in samples {
                csv.push_str(&format!("\n{wavelength_nm},{radiance:e},{dense:e}"));
            }
            print_line(&csv)
        }
        SpectrumFormat::Json => print_line(&serde_json::to_string(&samples).expect("samples are plain data")),
    }
}

#[cfg(feature = "view")]
fn view_command(arguments: &ViewArguments) -> Result<()> {
    let device = &arguments.scene.device;
    let options = sorairo_view::Options {
        scene: arguments.scene.scene()?,
        device,
        point: arguments.click,
        screenshot: arguments.screenshot.as_deref(),
    };
    Ok(sorairo_view::open(options, || device::open(device))?)
}

#[cfg(not(feature = "view"))]
fn view_command(_: &ViewArguments) -> Result<()> {
    Err(Error::request("this build of sorairo has no window; build it with `--features view`"))
}

fn devices_command(arguments: &DevicesArguments) -> Result<()> {
    let devices = gpu::devices();
    let cpu = device::cpu::device();
    if arguments.json {
        let mut list = serde_json::to_value(&devices).expect("devices are plain data");
        let cpu = serde_json::json!({ "name": cpu.name, "kind": "cpu", "driver": "" });
        list.as_array_mut().expect("a list of devices is an array").push(cpu);
        return print_line(&list.to_string());
    }
    for device in devices {
        print_line(&format!("{} ({}, {})", device.name, device.kind, device.driver))?;
    }
    print_line(&cpu.name)
}

/// Prints the library's warnings to standard error.
struct Warnings;

impl log::Log for Warnings {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.target().starts_with("sorairo")
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            print_note(&format!("sorairo: {}", record.args()));
        }
    }

    fn flush(&self) {}
}

/// The manual page of the program, or of a command.
fn man_command(name: Option<&str>) -> Result<()> {
    let mut command = Arguments::command().disable_help_subcommand(true);
    command.build();
    if let Some(name) = name {
        command = command.find_subcommand(name).cloned().ok_or_else(|| {
            let names: Vec<_> = command.get_subcommands().map(clap::Command::get_name).collect();
            Error::request(format!("there is no command {name:?}; there are {}", names.join(", ")))
        })?;
    }
    print_bytes(|out| clap_mangen::Man::new(command.clone()).render(out))
}

/// Prints to standard output what is written first to memory.
fn print_bytes(write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> Result<()> {
    let mut bytes = Vec::new();
    write(&mut bytes).expect("memory can be written");
    print_line(String::from_utf8_lossy(&bytes).trim_end())
}

/// Prints to standard error; where nobody can be told, the work still counts.
fn print_note(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Prints to standard output; a reader that has seen enough and closed the pipe is no failure.
fn print_line(text: &str) -> Result<()> {
    match writeln!(io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::Failure(format!("standard output cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}
