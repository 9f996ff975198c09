//! Hills in air: what `sorairo aerial` writes, against every pixel integrated at every wavelength.

use std::path::Path;

use rayon::prelude::*;
use sorairo::scene::{Preset, Scene};
use sorairo::{BetweenRgb, Direction};
use sorairo_evaluation::metrics::ColourError;
use sorairo_shared::glam::DVec3;
use sorairo_tests::program::{read_channels, read_exr, succeed, write_channels};
use sorairo_tests::sky::sky_of;
use sorairo_tests::terrain::{Seen, Viewpoint};
use tempfile::tempdir;

/// Reflectance of the hills.
const GREEN: DVec3 = DVec3::new(0.06, 0.09, 0.04);

/// Hills under a sky: its preset, the sun, and the camera's altitude (km) and elevation (degrees).
const VIEWS: [(Preset, &str, f64, f64, f64); 4] = [
    (Preset::Standard, "standard", 55.0, 0.3, 1.0),
    (Preset::Hazy, "hazy", 25.0, 0.3, 1.0),
    (Preset::Standard, "standard", 1.0, 0.3, 2.0),
    (Preset::Standard, "standard", 30.0, 10.0, -8.0),
];

fn viewpoint(altitude: f64, elevation: f64) -> Viewpoint {
    Viewpoint { width: 32, height: 18, fov: 50.0, azimuth: 90.0, elevation, altitude }
}

/// The hills as they would be seen without air, lit by a sun of 1 from the left behind the camera (W·m⁻²·sr⁻¹).
fn beauty(seen: &Seen) -> DVec3 {
    let sun = DVec3::new(0.5, 0.6, 0.6).normalize();
    if seen.distance.is_infinite() { DVec3::ZERO } else { GREEN * (0.2 + seen.normal.dot(sun).max(0.0)) * 40.0 }
}

fn channels(pixels: &[Seen]) -> [(&'static str, Vec<f32>); 3] {
    [("R", 0), ("G", 1), ("B", 2)].map(|(name, i)| (name, pixels.iter().map(|seen| beauty(seen)[i] as f32).collect()))
}

/// The depth along the camera's axis (m).
fn depth(pixels: &[Seen]) -> Vec<f32> {
    pixels.iter().map(|seen| (1000.0 * seen.distance * seen.along_axis) as f32).collect()
}

fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

fn direction_of(view: DVec3) -> Direction {
    Direction { elevation: view.z.asin().to_degrees(), azimuth: (-view.y).atan2(view.x).to_degrees() }
}

#[test]
fn hills_are_seen_through_the_air_that_each_pixel_has() {
    let folder = tempdir().unwrap();
    for (preset, name, sun, altitude, elevation) in VIEWS {
        let camera = viewpoint(altitude, elevation);
        let pixels = camera.look();
        let size = (camera.width, camera.height);
        write_channels(&folder.path().join("depth.exr"), size, &[("Z", depth(&pixels))]);
        write_channels(&folder.path().join("beauty.exr"), size, &channels(&pixels));
        let sun_flag = format!("--sun-elevation={sun}");
        let mut line = vec!["aerial", "--depth", "depth.exr", "--beauty", "beauty.exr", "--preset", name, &sun_flag];
        let flags = camera.flags();
        line.extend(["-o", "seen.exr", "--rgb", "srgb"]);
        line.extend(flags.iter().map(String::as_str));
        succeed(folder.path(), &line);
        let found = read_exr(&folder.path().join("seen.exr")).0;

        let mut scene = Scene::preset(preset);
        (scene.sun.elevation, scene.observer.altitude) = (sun, altitude);
        let sky = sky_of(&scene);
        let air = sky.between_rgb();
        let expected: Vec<DVec3> = pixels
            .par_iter()
            .map(|seen| {
                let BetweenRgb { transmittance, radiance, .. } =
                    air.until(&direction_of(seen.view), seen.distance).expect("hills stand on the ground");
                DVec3::from_array(transmittance) * beauty(seen) + DVec3::from_array(radiance)
            })
            .collect();
        let to_xyz = sky.plan().space.from_xyz.inverse();
        let mut worst = (0.0, 0);
        for (at, expected) in expected.iter().enumerate() {
            let found = DVec3::from_array(std::array::from_fn(|i| f64::from(found.rgb[3 * at + i])));
            let error = ColourError::new(to_xyz * found, to_xyz * *expected).delta_e;
            worst = if error.is_nan() || error > worst.0 { (error, at) } else { worst };
        }
        let (column, row) = (worst.1 % camera.width, worst.1 / camera.width);
        println!("{name}, sun at {sun}°, {altitude} km: ΔE00 {:.3} at {column}, {row}", worst.0);
        assert!(worst.0 <= 1.0, "{name}, sun at {sun}°: {} at {column}, {row}", worst.0);
        let hills = pixels.iter().filter(|seen| seen.distance.is_finite()).count();
        assert!(hills > pixels.len() / 4 && hills < pixels.len(), "{hills} pixels of hills");
    }
}

/// The light of the air before a black wall at each of some distances (km), one a column, relative to the sky behind
/// it.
fn wall(folder: &Path, distances: &[f32], flags: &str) -> Vec<f64> {
    let size = (distances.len(), 4);
    let of = |values: &[f32]| {
        write_channels(&folder.join("depth.exr"), size, &[("depth", values.repeat(4))]);
        let line = format!("aerial --depth depth.exr --depth-unit km --depth-kind ray -o a.exr --fov 2 {flags}");
        let line = format!("{line} --projection perspective --look-elevation 0.3 --look-azimuth 60");
        succeed(folder, &line.split_whitespace().collect::<Vec<_>>());
        let channels = read_channels(&folder.join("a.exr"));
        let pixel = |at: usize| {
            luminance(DVec3::from_array(
                ["R", "G", "B"].map(|name| f64::from(channels[&format!("inscatter.{name}")][at])),
            ))
        };
        (0..distances.len()).map(pixel).collect::<Vec<f64>>()
    };
    let sky = of(&vec![f32::INFINITY; distances.len()]);
    of(distances).into_iter().zip(sky).map(|(before, sky)| before / sky).collect()
}

#[test]
fn hills_melt_into_the_sky_at_the_horizon() {
    let folder = tempdir().unwrap();
    let distances = [0.0, 0.1, 1.0, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0, 1500.0];
    for flags in ["--sun-elevation 50", "--preset hazy --sun-elevation 20", "--sun-elevation 1", "--sun-elevation=-4"] {
        let parts = wall(folder.path(), &distances, flags);
        println!("{flags}: {parts:.4?}");
        assert_eq!(parts[0], 0.0, "{flags}");
        assert!(parts.windows(2).all(|pair| pair[1] >= pair[0] * 0.999), "{flags}: {parts:?}");
        // Behind the last of the air there is no more to come: what is left is the walk against the integral of whole
        // rays.
        let last = parts[distances.len() - 1];
        assert!((last - 1.0).abs() < 1e-3, "{flags}: {last}");
        assert!(parts[1] < 0.05 && parts[8] > 0.5, "{flags}: {parts:?}");
    }
}
