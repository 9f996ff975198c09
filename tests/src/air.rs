//! The air before a camera: skies, the way of its rays, and how far air is from each ray integrated.

use sorairo::low_level::plan::direction;
use sorairo::scene::{CameraScene, Preset, Projection, Scene, Size};
use sorairo::{BetweenRgb, Direction};
use sorairo_shared::glam::DVec3;

/// Skies with the sun at an azimuth (degrees), and the elevation at which their camera looks.
pub fn scenes(azimuth: f64) -> [(&'static str, Scene, f64); 8] {
    let of = |preset, sun, altitude| seen_from(preset, (sun, azimuth), altitude);
    [
        ("noon", of(Preset::Standard, 60.0, 0.002), 0.0),
        ("haze", of(Preset::Hazy, 30.0, 0.3), -2.0),
        ("sunset", of(Preset::Standard, 1.5, 0.05), 3.0),
        ("from 10 km", of(Preset::Standard, 35.0, 10.0), -12.0),
        ("from 20 km", of(Preset::Standard, 10.0, 20.0), -10.0),
        ("dusk", of(Preset::Standard, -4.0, 1.0), 0.0),
        ("dusk from 10 km", of(Preset::Standard, -4.0, 10.0), -5.0),
        ("dusk from 20 km", of(Preset::Standard, -4.0, 20.0), 2.0),
    ]
}

/// The same with the sun in view, or below its limb.
pub fn scenes_towards_the_sun() -> [(&'static str, Scene, f64); 4] {
    [
        ("towards a low sun", seen_from(Preset::Standard, (3.0, 10.0), 0.05), 3.0),
        ("towards a low sun in haze", seen_from(Preset::Hazy, (8.0, 5.0), 0.3), 3.0),
        ("the sun on the horizon at the edge", seen_from(Preset::Standard, (0.0, 30.0), 1.0), 0.0),
        ("late dusk from 20 km", seen_from(Preset::Standard, (-6.0, 0.0), 20.0), 0.0),
    ]
}

/// A preset under a sun at an elevation and an azimuth (degrees), from an altitude (km).
fn seen_from(preset: Preset, (elevation, azimuth): (f64, f64), altitude: f64) -> Scene {
    let mut scene = Scene::preset(preset);
    (scene.sun.elevation, scene.sun.azimuth, scene.observer.altitude) = (elevation, azimuth, altitude);
    scene
}

/// A camera that looks north at an elevation (degrees).
pub fn camera((width, height): (u32, u32), elevation: f64) -> CameraScene {
    CameraScene {
        projection: Projection::Perspective,
        size: Size { width, height },
        fov: Some(60.0),
        look_azimuth: Some(0.0),
        look_elevation: Some(elevation),
        ..CameraScene::default()
    }
}

/// The direction at a place of that camera's image, of which either side is 1.
pub fn towards(camera: &CameraScene, [x, y]: [f64; 2]) -> Direction {
    let (forward, right) = (direction(camera.look_elevation.unwrap_or_default(), 0.0), direction(0.0, 90.0));
    let up = right.cross(forward);
    let half = 30f64.to_radians().tan();
    let height = f64::from(camera.size.height) / f64::from(camera.size.width);
    let DVec3 { x: north, y: west, z } =
        (forward + right * (2.0 * x - 1.0) * half + up * (1.0 - 2.0 * y) * half * height).normalize();
    Direction { elevation: z.asin().to_degrees(), azimuth: (-west).atan2(north).to_degrees() }
}

/// How far light and transmittance are from each ray integrated: light relative to the brightest, then transmittance;
/// in the mean of the squares and at most.
pub fn errors(compared: &[([DVec3; 2], BetweenRgb)]) -> [[f64; 2]; 2] {
    let brightest = compared.iter().flat_map(|(_, expected)| expected.radiance).fold(0.0, f64::max);
    [0, 1].map(|which| {
        let of = |(found, expected): &([DVec3; 2], BetweenRgb)| {
            let (expected, scale) = [(expected.radiance, brightest), (expected.transmittance, 1.0)][which];
            let off = (found[which] - DVec3::from_array(expected)).abs() / scale;
            off.to_array().into_iter().fold(0.0, largest)
        };
        let squares: f64 = compared.iter().map(|pair| of(pair).powi(2)).sum();
        [(squares / compared.len() as f64).sqrt(), compared.iter().map(of).fold(0.0, largest)]
    })
}

/// The larger of two, or the one that is no number.
pub fn largest(most: f64, error: f64) -> f64 {
    if error.is_nan() || error > most { error } else { most }
}
