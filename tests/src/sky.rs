//! Scenes of the tests.

use std::sync::LazyLock;

use sorairo::scene::{Preset, Scene};
use sorairo::{LightFields, PixelFormat, Plan, Sky};
use sorairo_oracle::Spectrum;

/// The light fields of all skies that a process plans. Skies of the same air under suns that are near each other share
/// them, to the bit.
static LIGHT_FIELDS: LazyLock<LightFields> = LazyLock::new(LightFields::default);

/// The sun's elevations (degrees) at which every accuracy is stated.
pub const SUNS: [f64; 6] = [-4.0, 0.0, 30.0, 45.0, 60.0, 90.0];

/// A preset in light of one order over black ground, with the sun at an elevation (degrees), in the north.
pub fn scene(preset: Preset, sun_elevation: f64, size: &str) -> Scene {
    let mut scene = Scene::preset(preset).first_order();
    scene.sun.elevation = sun_elevation;
    scene.camera.size = size.parse().expect("a size");
    scene
}

/// The sky of a scene.
///
/// # Panics
///
/// If the scene is not valid.
pub fn sky_of(scene: &Scene) -> Sky {
    let scene = scene.validated().expect("a valid scene");
    Sky::with_light_fields(&scene, scene.render.rgb, &LIGHT_FIELDS)
}

/// The plan of a scene's image.
///
/// # Panics
///
/// As [`sky_of`].
pub fn plan_of(scene: &Scene, pixel: PixelFormat) -> Plan {
    Plan::with_light_fields(&scene.validated().expect("a valid scene"), pixel, &LIGHT_FIELDS)
}

/// The measured sun at a distance of 1 au (W·m⁻²·nm⁻¹), as the oracle reads its table.
pub fn sun() -> Spectrum {
    Spectrum::from_csv(include_str!("../../host/sorairo/data/astm_g173_extraterrestrial.csv"))
}
