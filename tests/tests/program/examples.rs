//! The examples of the library, which `cargo test` builds beside the tests, against the command.

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use sorairo_tests::program::{binary, read_exr, read_png, succeed};
use tempfile::tempdir;

/// Runs an example of the library in a folder, and gives what it printed.
fn example(folder: &Path, name: &str, arguments: &[&str]) -> String {
    let example = binary().with_file_name("examples").join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    let ended = Command::new(&example).args(arguments).current_dir(folder).env("XDG_RUNTIME_DIR", folder).output();
    let ended = ended.unwrap_or_else(|error| panic!("{}: {error}", example.display()));
    assert!(ended.status.success(), "{name}: {}", String::from_utf8_lossy(&ended.stderr));
    String::from_utf8(ended.stdout).unwrap()
}

#[test]
fn one_image_is_that_of_the_command() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    example(folder, "image", &["sky"]);
    let flags = "--preset hazy --sun-elevation 8 --sun-azimuth 250 --projection fisheye --size 512x512";
    let line = format!("render {flags} -o one.exr -o one.png");
    succeed(folder, &line.split(' ').collect::<Vec<_>>());
    assert!(read_exr(&folder.join("sky.exr")) == read_exr(&folder.join("one.exr")));
    // The command's picture is formed on the device, that of the library from linear pixels: a byte may round
    // otherwise.
    let [ours, theirs] = ["sky.png", "one.png"].map(|name| read_png(&folder.join(name)).rgb);
    let apart: Vec<u8> = ours.iter().zip(&theirs).map(|(a, b)| a.abs_diff(*b)).filter(|apart| *apart > 0).collect();
    assert!(ours.len() == theirs.len() && apart.len() < ours.len() / 1000 && apart.iter().all(|apart| *apart == 1));
}

/// The numbers of the rows of a CSV, under its header.
fn numbers(csv: &str) -> Vec<Vec<f64>> {
    let row = |line: &str| line.split([',', ' ']).map(|cell| cell.parse().unwrap()).collect();
    csv.lines().skip(1).map(row).collect()
}

#[test]
fn a_spectrum_is_that_of_the_command() {
    let folder = tempdir().unwrap();
    let found = numbers(&example(folder.path(), "spectrum", &["30", "180"]));
    let line = "spectrum --view-elevation 30 --view-azimuth 180 --wavelengths 380:780:10";
    let expected = numbers(&succeed(folder.path(), &line.split(' ').collect::<Vec<_>>()).stdout);
    assert_eq!((found.len(), expected.len()), (41, 41));
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        // The example rounds to six digits after the point.
        assert!((found - expected).abs() <= 0.51e-6, "{found}, not {expected}");
    }
}

#[test]
fn a_day_of_irradiance_has_a_night_and_a_noon_that_is_the_commands() {
    let folder = tempdir().unwrap();
    let day = numbers(&example(folder.path(), "day", &["43.06,141.35", "2026-06-21", "+09:00"]));
    assert_eq!(day.len(), 24);
    let line = "render --device cpu --size 2x1 --place 43.06,141.35 --time 2026-06-21T12:00:00+09:00 -o a.png --json";
    let report: Value =
        serde_json::from_str(&succeed(folder.path(), &line.split(' ').collect::<Vec<_>>()).stdout).unwrap();
    for (column, key) in [(1, "sun_elevation"), (2, "irradiance_w_m2"), (3, "direct_irradiance_w_m2")] {
        let (found, expected) = (day[12][column], report[key].as_f64().unwrap());
        assert!((found - expected).abs() <= 0.006, "{key}: {found}, not {expected}");
    }
    assert_eq!(day[0][2..], [0.0; 5], "at midnight the sun stands at {}", day[0][1]);
    assert!(day[12][4..].iter().all(|&light| (0.5..2.5).contains(&light)), "{:?}", day[12]);
}
