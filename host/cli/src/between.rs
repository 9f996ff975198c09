//! The command that prints what lies between an observer and a point.

use serde::Serialize;
use sorairo::{BetweenRgb, BetweenSample, Direction, LightFields, Sky};

use crate::arguments::{BetweenArguments, BetweenFormat, scene};
use crate::error::Result;
use crate::output::print_line;

/// `sorairo between`.
pub fn run(arguments: &BetweenArguments) -> Result<()> {
    let scene = scene(arguments.scene.as_deref(), &arguments.sky.0)?;
    let space = arguments.rgb.flatten().unwrap_or(scene.render.rgb);
    let sky = Sky::with_light_fields(&scene, space, &LightFields::default());
    let direction = Direction::new(arguments.view_elevation, arguments.view_azimuth);
    let printed = if arguments.rgb.is_some() {
        let found = sky.between_rgb().until(&direction, arguments.distance)?;
        printed(arguments.format, &found, || rows_of_channels(&found))
    } else {
        let found = sky.between(&arguments.wavelengths)?.until(&direction, arguments.distance)?;
        printed(arguments.format, &found, || rows_of_wavelengths(&found))
    };
    print_line(&printed)
}

fn printed(format: BetweenFormat, found: &impl Serialize, rows: impl FnOnce() -> String) -> String {
    match format {
        BetweenFormat::Csv => rows(),
        BetweenFormat::Json => serde_json::to_string(found).expect("what is printed is plain data"),
    }
}

fn rows_of_wavelengths(found: &[BetweenSample]) -> String {
    let row = |BetweenSample { wavelength_nm, transmittance, radiance, .. }: &BetweenSample| {
        format!("\n{wavelength_nm},{transmittance:e},{radiance:e}")
    };
    "wavelength_nm,transmittance,radiance".to_owned() + &found.iter().map(row).collect::<String>()
}

fn rows_of_channels(BetweenRgb { transmittance, radiance, .. }: &BetweenRgb) -> String {
    let row = |((channel, transmittance), radiance): ((&str, &f64), &f64)| {
        format!("\n{channel},{transmittance:e},{radiance:e}")
    };
    let rows = ["r", "g", "b"].into_iter().zip(transmittance).zip(radiance).map(row);
    "channel,transmittance,radiance".to_owned() + &rows.collect::<String>()
}
