//! A spectrum: the radiance of one direction of the sky, as CSV.
//!
//! ```sh
//! cargo run --release --package sorairo --example spectrum -- 30 180
//! ```
//!
//! prints it at an elevation and an azimuth in degrees: by the fit, and integrated at each wavelength itself.

use sorairo::{Direction, Scene, Sky};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<f64> = std::env::args().skip(1).map(|number| number.parse()).collect::<Result<_, _>>()?;
    let [elevation, azimuth] = arguments[..] else { return Err("usage: spectrum ELEVATION AZIMUTH".into()) };
    let sky = Sky::new(&Scene::default())?;
    let wavelengths: Vec<f64> = (0..=40).map(|i| 380.0 + 10.0 * f64::from(i)).collect();
    println!("wavelength_nm,radiance_w_m2_sr_nm,dense_w_m2_sr_nm");
    for sample in &sky.spectrum(&[Direction::new(elevation, azimuth)], &wavelengths, None)?[0] {
        println!("{},{:.6},{:.6}", sample.wavelength_nm, sample.radiance, sample.dense);
    }
    Ok(())
}
