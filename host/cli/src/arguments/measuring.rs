//! The commands that measure the program, and their flags.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::shared::{SceneArguments, device};

/// The commands that measure.
#[derive(Subcommand)]
pub enum EvaluationCommand {
    /// Finds the best wavelengths of the regression fit for a scene, and states their error.
    Bands(Box<BandsArguments>),
    /// Runs the experiment of Takahashi and Dobashi on this machine, and writes a report.
    Reproduce(ReproduceArguments),
    /// Measures run time against error on a device, and writes a report.
    Bench(BenchArguments),
    /// Tests random bands, scenes and rays for a given time, counts failures, and writes a report.
    Stress(StressArguments),
}

#[derive(Args)]
pub struct BandsArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Number of wavelengths (3 to 8).
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub count: u32,
    /// Elevations of the sun for which the error is minimised (degrees): a list with commas.
    #[arg(
        long,
        value_name = "LIST",
        default_value = "-4,0,5,30,90",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    pub sun_elevations: Vec<f64>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub struct ReproduceArguments {
    /// Folder to write report.md, report.json and the pictures to.
    #[arg(long, value_name = "DIR", default_value = "report")]
    pub out: PathBuf,
    /// Compare with measured skies instead, and write measured.md, measured.csv and measured.json.
    #[arg(long)]
    pub measured: bool,
    /// Device that is timed: auto, cpu, gpu, or part of the name of a graphics device.
    #[arg(long, default_value = "auto", value_name = "NAME")]
    pub device: String,
}

#[derive(Args)]
pub struct BenchArguments {
    /// Folder to write report.md, bench.csv, bench.json and the pictures to.
    #[arg(long, value_name = "DIR", default_value = "bench")]
    pub out: PathBuf,
    /// Fewer suns and smaller images: under a minute.
    #[arg(long)]
    pub quick: bool,
    /// Measure speed instead: kernels relative to writing their pixels, sizes, sky lookups, samples, a cold start.
    #[arg(long)]
    pub speed: bool,
    /// Print the measurements as one JSON object, in place of the report's name.
    #[arg(long)]
    pub json: bool,
    /// Device: auto, cpu, gpu, or part of the name of a graphics device.
    #[arg(long, default_value = "auto", value_name = "NAME")]
    pub device: String,
}

#[derive(Args)]
pub struct StressArguments {
    /// Folder to write report.md, stress.json and the pictures to.
    #[arg(long, value_name = "DIR", default_value = "stress")]
    pub out: PathBuf,
    /// Duration (minutes, 0 to 10 000); every sweep has at least one turn.
    #[arg(long, value_name = "N", default_value_t = 1.0, allow_negative_numbers = true, value_parser = minutes)]
    pub minutes: f64,
    /// Seed of the random numbers: the same seed tests the same cases.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Spectra per turn (1 to 1 000 000).
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub spectra: u64,
    /// Device beside the CPU: auto, cpu, gpu, or part of the name of a graphics device.
    #[arg(long, default_value = "auto", value_name = "NAME", value_parser = device)]
    pub device: String,
}

fn minutes(text: &str) -> std::result::Result<f64, String> {
    let minutes = text.parse().ok().filter(|minutes| (0.0..=10_000.0).contains(minutes));
    minutes.ok_or_else(|| "a number of minutes from 0 to 10000 is wanted".into())
}
