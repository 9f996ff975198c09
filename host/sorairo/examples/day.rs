//! A day of irradiance: what falls from the sky and from the sun on level ground at a place, hour by hour, as CSV.
//!
//! ```sh
//! cargo run --release --package sorairo --example day -- 43.06,141.35 2026-06-21 +09:00
//! ```

use sorairo::{Scene, Sky, SkyLight};

/// Of the spectrum, the peaks of what the three kinds of cones see, about (nm).
const WAVELENGTHS: [f64; 3] = [440.0, 540.0, 570.0];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [place, date, offset] = &arguments[..] else { return Err("usage: day LATITUDE,LONGITUDE DATE OFFSET".into()) };
    println!("hour,sun_elevation_deg,diffuse_w_m2,direct_w_m2,global_440_540_570_nm_w_m2_nm");
    for hour in 0..24 {
        let mut scene = Scene::default();
        scene.sun.place = Some(place.parse()?);
        scene.sun.time = Some(format!("{date}T{hour:02}:00:00{offset}").parse()?);
        let sky = Sky::new(&scene)?;
        let SkyLight { irradiance_w_m2, direct_irradiance_w_m2, .. } = sky.light();
        let spectral = sky.spectral_light(&WAVELENGTHS)?;
        let global = spectral.irradiance_w_m2_nm.iter().zip(&spectral.direct_irradiance_w_m2_nm);
        let global: Vec<String> = global.map(|(diffuse, direct)| format!("{:.4}", diffuse + direct)).collect();
        let elevation = sky.sun().elevation;
        println!("{hour},{elevation:.2},{irradiance_w_m2:.2},{direct_irradiance_w_m2:.2},{}", global.join(" "));
    }
    Ok(())
}
