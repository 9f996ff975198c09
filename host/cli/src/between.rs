//! The command that prints what lies between an observer and a point.

use sorairo::low_level::spectrum::Direction;
use sorairo::{AirBetween, BetweenSample, SkyPlan};

use crate::arguments::{BetweenArguments, BetweenFormat, scene};
use crate::error::Result;
use crate::output::print_line;

/// `sorairo between`.
pub fn run(arguments: &BetweenArguments) -> Result<()> {
    let scene = scene(arguments.scene.as_deref(), &arguments.sky.0)?;
    let sky = SkyPlan::new(&scene, scene.render.rgb);
    let direction = Direction { elevation: arguments.view_elevation, azimuth: arguments.view_azimuth };
    let found = AirBetween::new(&sky, &arguments.wavelengths)?.until(&direction, arguments.distance)?;
    let row = |BetweenSample { wavelength_nm, transmittance, radiance }: &BetweenSample| {
        format!("\n{wavelength_nm},{transmittance:e},{radiance:e}")
    };
    print_line(&match arguments.format {
        BetweenFormat::Csv => {
            "wavelength_nm,transmittance,radiance".to_owned() + &found.iter().map(row).collect::<String>()
        }
        BetweenFormat::Json => serde_json::to_string(&found).expect("what is printed is plain data"),
    })
}
