//! The commands that tell the air in front of things, and their flags.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use sorairo::aerial::{AerialRequest, DepthKind, DepthUnit};
use sorairo::files::Replace;
use sorairo::scene::Rgb;

use super::shared::{ReplaceFlags, number};
use crate::flags::{SceneFlags, SkyFlags, word_of};
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
    /// Distance of the far point (km); inf for all of the air.
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

#[derive(Args)]
pub struct AerialArguments {
    /// Scene file (TOML).
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub flags: SceneFlags,
    /// Depth image (EXR): its channel Z, or the only one.
    #[arg(long, value_name = "FILE.exr")]
    depth: PathBuf,
    /// Unit of the depth.
    #[arg(long, value_name = "UNIT", default_value = "m", ignore_case = true, value_parser = word_of::<DepthUnit>())]
    depth_unit: DepthUnit,
    /// Line along which the depth is measured.
    #[arg(long, value_name = "KIND", default_value = "z", ignore_case = true, value_parser = word_of::<DepthKind>())]
    depth_kind: DepthKind,
    /// Image (EXR) of the same size to which the air is applied, in place of layers: linear RGB in the scene's space
    /// and exposure.
    #[arg(long, value_name = "FILE.exr")]
    beauty: Option<PathBuf>,
    /// File to write [default: aerial.exr, in the place of one that sorairo wrote, and of no other].
    #[arg(short = 'o', long, value_name = "FILE.exr")]
    output: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceFlags,
    /// Print one JSON object about the file to standard output.
    #[arg(long)]
    pub json: bool,
}

impl AerialArguments {
    /// What to write, by which images.
    pub fn request(&self) -> AerialRequest {
        let usual = if self.output.is_some() { Replace::All } else { Replace::Own };
        AerialRequest {
            depth: self.depth.clone(),
            unit: self.depth_unit,
            kind: self.depth_kind,
            beauty: self.beauty.clone(),
            output: self.output.clone().unwrap_or_else(|| "aerial.exr".into()),
            replace: self.replace.or(usual),
        }
    }
}
