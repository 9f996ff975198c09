//! The command that tells the air in front of things, and its flags.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use sorairo::scene::Rgb;

use super::shared::number;
use crate::flags::{SkyFlags, word_of};
use crate::ranges::{Numbers, wavelengths};

#[derive(Args)]
pub struct BetweenArguments {
    /// Scene file (TOML).
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub sky: SkyFlags,
    /// Elevation of the direction (degrees).
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = number)]
    pub view_elevation: f64,
    /// Azimuth of the direction, clockwise from north (degrees).
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = number)]
    pub view_azimuth: f64,
    /// Distance up to which air counts (km); inf for all of it.
    #[arg(long, value_name = "KM", allow_negative_numbers = true, value_parser = number)]
    pub distance: f64,
    /// Wavelengths in nm: START:END:STEP, or a list with commas.
    #[arg(long, value_name = "LIST", default_value = "380:780:5", value_parser = wavelengths)]
    pub wavelengths: Numbers,
    /// Linear RGB in place of wavelengths, the transmittance as that of sunlight [default space: that of the scene].
    #[arg(long, value_name = "SPACE", num_args = 0..=1, conflicts_with = "wavelengths", ignore_case = true, value_parser = word_of::<Rgb>())]
    pub rgb: Option<Option<Rgb>>,
    /// Format of the output.
    #[arg(long, value_enum, ignore_case = true, default_value_t = BetweenFormat::Csv)]
    pub format: BetweenFormat,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum BetweenFormat {
    /// Rows of wavelength_nm,transmittance,radiance; with --rgb of channel,transmittance,radiance.
    Csv,
    /// An array of objects with the same names; with --rgb one object of two arrays.
    Json,
}
