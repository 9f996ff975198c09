//! The command that prints the spectrum of a direction, or of many.

use std::fmt::Write;

use serde::Serialize;
use sorairo::{Appearance, BeamSample, Direction, Sample, Sky, Stokes};

use crate::arguments::{SpectrumArguments, SpectrumFormat, scene};
use crate::directions;
use crate::error::Result;
use crate::output::print_line;

/// What is printed of a direction of many.
#[derive(Serialize)]
struct Of<'a, T> {
    #[serde(flatten)]
    direction: &'a Direction,
    #[serde(flatten)]
    what: T,
}

/// A spectrum by its name.
#[derive(Serialize)]
struct Spectrum<'a, T> {
    spectrum: &'a [T],
}

/// The columns of Stokes vectors.
const STOKES: &str = "wavelength_nm,stokes_i,stokes_q,stokes_u,degree_of_polarisation,angle_of_polarisation_deg";

/// `sorairo spectrum`.
pub fn run(arguments: &SpectrumArguments) -> Result<()> {
    let scene = scene(arguments.scene.as_deref(), &arguments.sky.0)?;
    let sky = Sky::new(&scene)?;
    if arguments.direct {
        let beam = sky.sun_beam(&arguments.wavelengths, arguments.resolution)?;
        return print_line(&direct(&beam, arguments.format));
    }
    let directions = match (&arguments.directions, arguments.view_elevation.zip(arguments.view_azimuth)) {
        (None, Some((elevation, azimuth))) => vec![Direction::new(elevation, azimuth)],
        (path, _) => directions::read(path.as_deref().expect("without a direction the table is required"))?,
    };
    let are_many = arguments.directions.is_some();
    let text = if arguments.luminance {
        let found = sky.appearance(&directions)?;
        match arguments.format {
            SpectrumFormat::Csv => {
                csv(&directions, are_many, "luminance_cd_m2,x,y,cct_k", found.iter().map(|found| vec![row(found)]))
            }
            SpectrumFormat::Json => json(&directions, are_many, &found, |found| found),
        }
    } else if arguments.stokes {
        let found = sky.stokes(&arguments.wavelengths, arguments.stokes_frame)?.in_directions(&directions)?;
        match arguments.format {
            SpectrumFormat::Csv => {
                let rows = found.iter().map(|spectrum| spectrum.iter().map(stokes_row).collect());
                csv(&directions, are_many, STOKES, rows)
            }
            SpectrumFormat::Json if are_many => json(&directions, true, &found, |spectrum| Spectrum { spectrum }),
            SpectrumFormat::Json => text_of(&found[0]),
        }
    } else {
        let found = sky.spectrum(&directions, &arguments.wavelengths, arguments.resolution)?;
        match arguments.format {
            SpectrumFormat::Csv => {
                let rows = found.iter().map(|spectrum| spectrum.iter().map(sample_row).collect());
                csv(&directions, are_many, "wavelength_nm,radiance,dense", rows)
            }
            SpectrumFormat::Json if are_many => json(&directions, true, &found, |spectrum| Spectrum { spectrum }),
            SpectrumFormat::Json => text_of(&found[0]),
        }
    };
    print_line(&text)
}

/// The sun's beam at each wavelength.
fn direct(beam: &[BeamSample], format: SpectrumFormat) -> String {
    let row = |BeamSample { wavelength_nm, transmittance, irradiance, .. }: &BeamSample| {
        format!("\n{wavelength_nm},{transmittance:e},{irradiance:e}")
    };
    match format {
        SpectrumFormat::Csv => {
            "wavelength_nm,transmittance,irradiance".to_owned() + &beam.iter().map(row).collect::<String>()
        }
        SpectrumFormat::Json => text_of(&beam),
    }
}

fn sample_row(Sample { wavelength_nm, radiance, dense, .. }: &Sample) -> String {
    format!("{wavelength_nm},{radiance:e},{dense:e}")
}

fn stokes_row(found: &Stokes) -> String {
    let Stokes {
        wavelength_nm, stokes_i, stokes_q, stokes_u, degree_of_polarisation, angle_of_polarisation_deg, ..
    } = found;
    format!(
        "{wavelength_nm},{stokes_i:e},{stokes_q:e},{stokes_u:e},{degree_of_polarisation:e},{angle_of_polarisation_deg:e}"
    )
}

fn row(found: &Appearance) -> String {
    let cell = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
    format!("{:e},{},{},{}", found.luminance_cd_m2, cell(found.x), cell(found.y), cell(found.cct_k))
}

/// A table of the rows of each direction, which stands before each row where there are many.
fn csv(directions: &[Direction], are_many: bool, header: &str, rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut text = if are_many { format!("view_elevation,view_azimuth,{header}") } else { header.into() };
    for (Direction { elevation, azimuth }, rows) in directions.iter().zip(rows) {
        for row in rows {
            let before = if are_many { format!("{elevation},{azimuth},") } else { String::new() };
            // A text takes whatever is written to it.
            let _ = write!(text, "\n{before}{row}");
        }
    }
    text
}

/// What was found in the one direction, or in an array each with its direction.
fn json<'a, T, S: Serialize>(
    directions: &[Direction],
    are_many: bool,
    found: &'a [T],
    shown: fn(&'a T) -> S,
) -> String {
    if !are_many {
        return text_of(&shown(&found[0]));
    }
    let each = directions.iter().zip(found).map(|(direction, found)| Of { direction, what: shown(found) });
    text_of(&each.collect::<Vec<_>>())
}

fn text_of(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("what is printed is plain data")
}
