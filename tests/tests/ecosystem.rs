//! The program's files in other people's programs. These tests need Python with what `tests/python/requirements.txt` lists.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};
use sorairo_tests::program::succeed;
use tempfile::tempdir;

/// Python: the one that `SORAIRO_PYTHON` names, or the one that test.sh makes.
fn python() -> PathBuf {
    let made = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/python/bin/python");
    let python = std::env::var_os("SORAIRO_PYTHON").map_or_else(made, PathBuf::from);
    assert!(
        python.is_file(),
        "{} is missing: run ./test.sh, which makes it, or set SORAIRO_PYTHON to a Python that has what tests/python/requirements.txt lists",
        python.display()
    );
    python
}

/// Runs a script of `tests/python` in a folder, successfully.
fn check(folder: &Path, script: &str, arguments: &[&str]) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("python").join(script);
    let output =
        Command::new(python()).arg(&script).args(arguments).current_dir(folder).output().expect("Python starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    println!("{}", text(&output.stdout));
    assert!(output.status.success(), "{}: {}\n{}", script.display(), text(&output.stdout), text(&output.stderr));
}

fn write_json(path: &Path, value: &Value) {
    std::fs::write(path, value.to_string()).expect("a file");
}

/// What `sorairo spectrum` says of a pixel of an equirectangular image of 64x32 pixels.
fn pixel(folder: &Path, scene: &[&str], column: u32, row: u32) -> Value {
    let azimuth = (f64::from(column) + 0.5) * 360.0 / 64.0 - 180.0;
    let elevation = 90.0 - (f64::from(row) + 0.5) * 180.0 / 32.0;
    let (elevation, azimuth) = (format!("--view-elevation={elevation}"), format!("--view-azimuth={azimuth}"));
    let spectrum = ["spectrum", &elevation, &azimuth, "--wavelengths", "380:780:5", "--format", "json"];
    let samples = succeed(folder, &[&spectrum[..], scene].concat()).stdout;
    let samples: Value = serde_json::from_str(&samples).expect("JSON");
    let radiance: Vec<&Value> = samples.as_array().expect("samples").iter().map(|sample| &sample["radiance"]).collect();
    json!({ "column": column, "row": row, "radiance": radiance })
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
