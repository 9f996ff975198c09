//! The command that prints the spectrum of a direction.

use sorairo::PixelFormat;
use sorairo::Plan;
use sorairo::low_level::device;
use sorairo::low_level::spectrum::{Sample, spectrum};

use crate::arguments::{SpectrumArguments, SpectrumFormat};
use crate::error::Result;
use crate::output::print_line;

/// `sorairo spectrum`.
pub fn run(arguments: &SpectrumArguments) -> Result<()> {
    let plan = Plan::new(&arguments.scene.scene()?, PixelFormat::LinearRgb);
    if !arguments.scene.device.eq_ignore_ascii_case("auto") {
        // One ray needs no device, but a wrong name is as wrong here as anywhere.
        device::open(&arguments.scene.device)?;
    }
    let samples = spectrum(&plan.sky, arguments.view_elevation, arguments.view_azimuth, &arguments.wavelengths)?;
    match arguments.format {
        SpectrumFormat::Csv => print_line(&csv(&samples)),
        SpectrumFormat::Json => print_line(&serde_json::to_string(&samples).expect("samples are plain data")),
    }
}

fn csv(samples: &[Sample]) -> String {
    let row = |Sample { wavelength_nm, radiance, dense }: &Sample| format!("\n{wavelength_nm},{radiance:e},{dense:e}");
    samples.iter().map(row).fold("wavelength_nm,radiance,dense".into(), |csv, row| csv + &row)
}
