//! Scenes of the tests.

use sorairo::scene::{Preset, Scene};
use sorairo_oracle::Spectrum;

/// The sun's elevations (degrees) at which every accuracy is stated.
pub const SUNS: [f64; 6] = [-4.0, 0.0, 30.0, 45.0, 60.0, 90.0];

/// A preset in light of one order over black ground, with the sun at an elevation (degrees), in the north.
pub fn scene(preset: Preset, sun_elevation: f64, size: &str) -> Scene {
    let mut scene = Scene::preset(preset).first_order();
    scene.sun.elevation = sun_elevation;
    scene.camera.size = size.parse().expect("a size");
    scene
}

/// The measured sun at a distance of 1 au (W·m⁻²·nm⁻¹), as the oracle reads its table.
pub fn sun() -> Spectrum {
    Spectrum::from_csv(include_str!("../../host/sorairo/data/astm_g173_extraterrestrial.csv"))
}
