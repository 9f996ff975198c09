//! The commands that measure: `bands`, `reproduce`, `bench`, `stress`.

use serde::Serialize;
use sorairo::Device;
use sorairo_evaluation::bands::{Found, best};
use sorairo_evaluation::metrics::Errors;
use sorairo_evaluation::stress::{Extent, Outcome};

use crate::arguments::{BandsArguments, BenchArguments, EvaluationCommand, ReproduceArguments, StressArguments};
use crate::error::{Error, Result};
use crate::memory;
use crate::output::print_line;
use crate::progress::Progress;

/// Runs one of them.
pub fn run(command: &EvaluationCommand) -> Result<()> {
    match command {
        EvaluationCommand::Bands(arguments) => bands(arguments),
        EvaluationCommand::Reproduce(arguments) => reproduce(arguments),
        EvaluationCommand::Bench(arguments) => bench(arguments),
        EvaluationCommand::Stress(arguments) => stress(arguments),
    }
}

/// `sorairo bands`.
fn bands(arguments: &BandsArguments) -> Result<()> {
    let scene = arguments.scene.scene()?;
    let progress = Progress::start();
    progress.stage("searching the best wavelengths");
    let found = best(&scene, arguments.count, &arguments.sun_elevations);
    drop(progress);
    let found = found?;
    if arguments.json {
        return print_line(&json(&found));
    }
    print_line(&table(&found))
}

fn json(measured: &impl Serialize) -> String {
    serde_json::to_string(measured).expect("measurements are plain data")
}

/// `sorairo reproduce`.
fn reproduce(arguments: &ReproduceArguments) -> Result<()> {
    if arguments.measured {
        return measured(arguments);
    }
    let device = Device::open(&memory::device(&arguments.device)?)?;
    let progress = Progress::start();
    let experiment = sorairo_evaluation::reproduce::reproduce(&arguments.out, &device, &|stage| progress.stage(stage));
    drop(progress);
    experiment?;
    print_line(&arguments.out.join("report.md").display().to_string())
}

/// `sorairo reproduce --measured`.
fn measured(arguments: &ReproduceArguments) -> Result<()> {
    let progress = Progress::start();
    let done = sorairo_evaluation::measured::measured(&arguments.out, &|stage| progress.stage(stage));
    drop(progress);
    done?;
    print_line(&arguments.out.join("measured.md").display().to_string())
}

/// `sorairo bench`.
fn bench(arguments: &BenchArguments) -> Result<()> {
    let device = Device::open(&memory::device(&arguments.device)?)?;
    let progress = Progress::start();
    let stage = |stage: &str| progress.stage(stage);
    let BenchArguments { out, quick, .. } = arguments;
    let done = if arguments.speed {
        sorairo_evaluation::speed::speed(out, &device, *quick, &stage).map(|speed| json(&speed))
    } else {
        sorairo_evaluation::bench::bench(out, &device, *quick, &stage).map(|bench| json(&bench))
    };
    drop(progress);
    let measured = done?;
    if arguments.json {
        return print_line(&measured);
    }
    let report = if arguments.speed { "speed.md" } else { "report.md" };
    print_line(&out.join(report).display().to_string())
}

/// `sorairo stress`: prints what each sweep found, and fails if a case did.
fn stress(arguments: &StressArguments) -> Result<()> {
    let device = Device::open(&memory::device(&arguments.device)?)?;
    let progress = Progress::start();
    let stage = |stage: &str| progress.stage(stage);
    let &StressArguments { minutes, seed, spectra, .. } = arguments;
    let done = sorairo_evaluation::stress::stress(&arguments.out, &device, Extent { minutes, seed, spectra }, &stage);
    drop(progress);
    let done = done?;
    let line = |outcome: &Outcome| {
        let Outcome { subject, cases, failures, worst, bound, .. } = outcome;
        format!("{cases:>10}  {failures:>8}  {worst:>9.3e}  {bound:>9.3e}  {subject}\n")
    };
    let lines: String = done.outcomes.iter().map(line).collect();
    let report = arguments.out.join("report.md");
    print_line(&format!(
        "     cases  failures      worst      bound  seed {}\n{lines}{}",
        done.seed,
        report.display()
    ))?;
    match done.failures() {
        0 => Ok(()),
        failures => Err(Error::Failure(format!("{failures} cases failed; {} names the worst", report.display()))),
    }
}

/// The outcome of a search as a table.
fn table(found: &Found) -> String {
    let list = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    let width = list(&found.bands).len().max(list(&found.default_bands).len() + " (default)".len());
    let row = |bands: String, errors: &Errors| {
        format!(
            "{bands:width$}  {:>8.4}  {:>9.4}  {:>9.3} %  {:>8.5}",
            errors.delta_e_max,
            errors.delta_e_mean,
            100.0 * errors.luminance_max,
            errors.chromaticity_max
        )
    };
    format!(
        "{:width$}  dE00 max  dE00 mean  luminance max  u'v' max\n{}\n{}\nregression fit, whole sky, sun at {} degrees; {} choices compared",
        "bands (nm)",
        row(list(&found.bands), &found.errors),
        row(list(&found.default_bands) + " (default)", &found.default_errors),
        list(&found.sun_elevations),
        found.candidates
    )
}
