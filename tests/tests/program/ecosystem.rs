//! The program's files in other people's programs. These tests need Python with what `tests/python/requirements.txt`
//! lists.

use std::path::Path;

use serde_json::{Value, json};
use sorairo_tests::program::{binary, read_png, succeed};
use sorairo_tests::python::{blender, check, check_by};
use tempfile::tempdir;

fn write_json(path: &Path, value: &Value) {
    std::fs::write(path, value.to_string()).expect("a file");
}

/// What `sorairo spectrum` says of a pixel of an equirectangular image of 64x32 pixels.
fn samples(folder: &Path, arguments: &[&str], scene: &[&str], (column, row): (u32, u32)) -> Vec<Value> {
    let azimuth = (f64::from(column) + 0.5) * 360.0 / 64.0 - 180.0;
    let elevation = 90.0 - (f64::from(row) + 0.5) * 180.0 / 32.0;
    let (elevation, azimuth) = (format!("--view-elevation={elevation}"), format!("--view-azimuth={azimuth}"));
    let spectrum = ["spectrum", &elevation, &azimuth, "--format", "json"];
    let samples = succeed(folder, &[&spectrum[..], arguments, scene].concat()).stdout;
    let samples: Value = serde_json::from_str(&samples).expect("JSON");
    samples.as_array().expect("samples").clone()
}

fn pixel(folder: &Path, scene: &[&str], column: u32, row: u32) -> Value {
    let samples = samples(folder, &["--wavelengths", "380:780:5"], scene, (column, row));
    let radiance: Vec<&Value> = samples.iter().map(|sample| &sample["radiance"]).collect();
    json!({ "column": column, "row": row, "radiance": radiance })
}

fn stokes_of_pixel(folder: &Path, scene: &[&str], column: u32, row: u32) -> Value {
    let samples = samples(folder, &["--stokes", "--wavelengths", "380:780:10"], scene, (column, row));
    let stokes: Vec<[&Value; 3]> =
        samples.iter().map(|sample| ["stokes_i", "stokes_q", "stokes_u"].map(|name| &sample[name])).collect();
    json!({ "column": column, "row": row, "stokes": stokes })
}

#[test]
fn a_spectral_file_is_what_other_readers_expect_and_holds_the_spectrum() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    let wavelengths: Vec<f64> = (0..81).map(|i| 380.0 + 5.0 * f64::from(i)).collect();
    for scene in [
        &["--sun-elevation", "20", "--sun-azimuth", "70"][..],
        &["--sun-elevation", "-2"],
        &["--fit", "dense", "--altitude", "3"],
    ] {
        let pixels: Vec<Value> = [(40, 3), (10, 9), (5, 15), (32, 14)]
            .iter()
            .map(|&(column, row)| pixel(folder, scene, column, row))
            .collect();
        write_json(&folder.join("expected.json"), &json!({ "wavelengths": wavelengths, "pixels": pixels }));
        for device in ["cpu", "gpu"] {
            let image = ["render", "--size", "64x32", "-o", "sky.spectral.exr", "--wavelengths", "380:780:5"];
            succeed(folder, &[&image[..], scene, &["--device", device]].concat());
            check(folder, "spectral_layout.py", &["sky.spectral.exr", "expected.json"]);
        }
    }
}

#[test]
fn a_spectral_file_holds_the_stokes_parameters_that_other_readers_expect() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    let wavelengths: Vec<f64> = (0..41).map(|i| 380.0 + 10.0 * f64::from(i)).collect();
    // Of parts Q/I and U/I on straight lines between bands. The red edge of grass lies between two of them.
    let [elevation, azimuth] = [["--sun-elevation", "20"], ["--sun-azimuth", "70"]];
    let by_day = [elevation, azimuth].concat();
    for (scene, bound) in [
        (&by_day[..], 0.03),
        (&[&by_day[..], &["--albedo", "0.2"]].concat(), 0.01),
        (&["--sun-elevation=-2"], 0.01),
        (&["--preset", "earth"], 0.005),
    ] {
        let pixels: Vec<Value> = [(40, 3), (10, 9), (5, 13), (52, 6)]
            .iter()
            .map(|&(column, row)| stokes_of_pixel(folder, scene, column, row))
            .collect();
        let expected = json!({ "wavelengths": wavelengths, "pixels": pixels, "bound": bound });
        write_json(&folder.join("expected.json"), &expected);
        let image = ["render", "--size", "64x32", "-o", "sky.spectral.exr", "--stokes"];
        succeed(folder, &[&image[..], scene].concat());
        check(folder, "spectral_layout.py", &["sky.spectral.exr", "expected.json"]);
    }
}

#[test]
fn the_tutorials_scene_is_lit_by_sky_and_sun() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    let image =
        ["render", "--size", "256x128", "--sun-elevation", "25", "--sun-azimuth", "110", "-o", "sky.exr", "--json"];
    std::fs::write(folder.join("sky.json"), succeed(folder, &image).stdout).unwrap();
    check(folder, "../../docs/lit_scene.py", &["sky.exr", "sky.json", "lit.png"]);
    let lit = read_png(&folder.join("lit.png"));
    let mean = |columns: std::ops::Range<usize>, rows: std::ops::Range<usize>| {
        let pixels: Vec<[u8; 3]> =
            rows.flat_map(|row| columns.clone().map(move |column| (column, row))).map(|(c, r)| lit.at(c, r)).collect();
        [0, 1, 2].map(|channel| pixels.iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>() / pixels.len() as f64)
    };
    // In the shadow of the orange sphere, and on the open ground beside it.
    let (shade, open) = (mean(50..100, 240..250), mean(350..400, 240..250));
    assert!(open[1] > 1.5 * shade[1], "{open:?} {shade:?}");
    assert!(shade[2] / shade[0] > 1.1 * open[2] / open[0], "shadows are not bluer than the ground: {shade:?} {open:?}");
    // Mitsuba's sky is the one above the ground.
    let sky = mean(0..480, 0..20);
    assert!(sky[1] > 50.0, "{sky:?}");
}

#[test]
fn a_scene_has_one_sun_whether_it_is_in_the_map_or_a_light() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    let linear = |value: u8| (f64::from(value) / 255.0).powf(2.2);
    let contrast = |flags: &[&str]| {
        let image =
            ["render", "--size", "512x256", "--sun-elevation", "25", "--sun-azimuth", "110", "-o", "sky.exr", "--json"];
        std::fs::write(folder.join("sky.json"), succeed(folder, &[&image[..], flags].concat()).stdout).unwrap();
        check(folder, "../../docs/lit_scene.py", &["sky.exr", "sky.json", "lit.png"]);
        let lit = read_png(&folder.join("lit.png"));
        let sum = |columns: std::ops::Range<usize>| {
            (240..250)
                .flat_map(|row| columns.clone().map(move |column| (column, row)))
                .map(|(c, r)| linear(lit.at(c, r)[1]))
                .sum::<f64>()
        };
        sum(350..400) / sum(50..100)
    };
    let (light, map) = (contrast(&[]), contrast(&["--sun-disc"]));
    println!("open ground over shade: {light:.2} with a light, {map:.2} with the map's own sun");
    // A second sun would nearly double it. The map's sun is wider, and rays find it by chance.
    assert!((map / light - 1.0).abs() < 0.25, "{light} {map}");
}

/// Haze whose glow shows where the sun is.
const HAZE: &str = "[atmosphere.aerosol]\noptical_depth = 0.2\nasymmetry = 0.85\n";

#[test]
fn an_environment_map_lights_the_ground_and_has_its_sun_where_mitsuba_has_it() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("scene.toml"), HAZE).unwrap();
    for (elevation, azimuth) in [("40", "60"), ("15", "215")] {
        let image = ["render", "--scene", "scene.toml", "--size", "1024x512", "-o", "sky.exr", "--json"];
        let sun = ["--sun-elevation", elevation, "--sun-azimuth", azimuth];
        let report = succeed(folder, &[&image[..], &sun].concat()).stdout;
        std::fs::write(folder.join("report.json"), report).unwrap();
        check(folder, "environment_map.py", &["sky.exr", "report.json", elevation, azimuth]);
    }
}

#[test]
#[ignore = "needs Blender, which takes Python 3.11 and 1 GB: tests/python/blender.txt; test.sh runs it where it can"]
fn blender_sees_the_sky_that_sorairo_sees_in_its_brightness_and_with_its_light() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("scene.toml"), HAZE).unwrap();
    let image = "render --scene scene.toml --size 512x256 --sun-elevation 40 --sun-azimuth 60 \
                 --look none --dither none --below ground -o sky.exr -o sky.png --json";
    let image: Vec<&str> = image.split(' ').collect();
    std::fs::write(folder.join("sky.json"), succeed(folder, &image).stdout).unwrap();
    check_by(&blender(), folder, "blender_map.py", &[]);
}

#[test]
#[ignore = "needs Blender, which takes Python 3.11 and 1 GB: tests/python/blender.txt; test.sh runs it where it can"]
fn the_add_on_of_blender_lights_a_scene_by_the_sky_and_the_sun_of_its_panel() {
    let folder = tempdir().unwrap();
    check_by(&blender(), folder.path(), "blender_addon.py", &[binary().to_str().expect("a path of text")]);
}
