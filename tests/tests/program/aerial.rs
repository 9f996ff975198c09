//! `sorairo between --rgb` and `sorairo aerial`: what they write, and what they refuse.

use std::path::Path;

use serde_json::Value;
use sorairo_tests::program::{contents, names, read_channels, run, succeed, write_channels};
use tempfile::tempdir;

const VIEW: [&str; 6] = ["--projection", "perspective", "--fov", "40", "--sun-elevation", "30"];

fn aerial(folder: &Path, flags: &str) -> sorairo_tests::program::Ended {
    run(folder, &[&["aerial"], &VIEW[..], &flags.split_whitespace().collect::<Vec<_>>()].concat())
}

fn depth(folder: &Path, name: &str, values: [f32; 4]) {
    write_channels(&folder.join(name), (2, 2), &[("Z", values.to_vec())]);
}

#[test]
fn a_hill_is_told_as_rgb_in_the_space_that_is_named() {
    let folder = tempdir().unwrap();
    let of = |flags: &str| {
        let line = format!("between --view-elevation 1 --view-azimuth 60 --distance 40 --sun-elevation 20 {flags}");
        succeed(folder.path(), &line.split_whitespace().collect::<Vec<_>>()).stdout
    };
    let json: Value = serde_json::from_str(&of("--rgb --format json")).unwrap();
    let channel = |json: &Value, name: &str, i: usize| json[name][i].as_f64().unwrap();
    // Air takes blue from what is behind it, and gives blue.
    assert!(channel(&json, "transmittance", 0) > channel(&json, "transmittance", 2));
    assert!(channel(&json, "radiance", 0) < channel(&json, "radiance", 2));
    let lines: Vec<String> = of("--rgb").lines().map(str::to_owned).collect();
    assert_eq!((lines[0].as_str(), lines.len()), ("channel,transmittance,radiance", 4));
    assert!(lines[3].starts_with("b,") && lines[3].ends_with(&format!("{:e}", channel(&json, "radiance", 2))));
    let wide: Value = serde_json::from_str(&of("--rgb acescg --format json")).unwrap();
    assert!(channel(&wide, "radiance", 0) > channel(&json, "radiance", 0), "less of the sky's blue is negative red");
    let refused = run(
        folder.path(),
        &["between", "--view-elevation=1", "--view-azimuth=0", "--distance=1", "--rgb", "--wavelengths=500"],
    );
    assert!(refused.code == Some(2) && refused.stderr.contains("--rgb"), "{}", refused.stderr);
}

#[test]
fn a_depth_becomes_layers_of_air() {
    let folder = tempdir().unwrap();
    depth(folder.path(), "depth.exr", [0.0, 5000.0, 50_000.0, f32::INFINITY]);
    let ended = aerial(folder.path(), "--depth depth.exr --json");
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let report: Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!((report["width"].as_u64(), report["sky_pixels"].as_u64()), (Some(2), Some(1)));
    let channels = read_channels(&folder.path().join("aerial.exr"));
    let expected =
        ["inscatter.B", "inscatter.G", "inscatter.R", "transmittance.B", "transmittance.G", "transmittance.R"];
    assert_eq!(channels.keys().map(String::as_str).collect::<Vec<_>>(), expected);
    for (name, values) in &channels {
        let light = name.starts_with("inscatter");
        assert_eq!(values[0], if light { 0.0 } else { 1.0 }, "{name} before no distance");
        assert!(values.iter().all(|value| value.is_finite() && *value >= 0.0), "{name}: {values:?}");
        assert_eq!(
            light,
            values[0] < values[1] && values[1] < values[2] && values[2] < values[3] * 1.5,
            "{name}: {values:?}"
        );
    }
    // The unit, and along which line a depth lies.
    depth(folder.path(), "km.exr", [0.0, 5.0, 50.0, 1e10]);
    assert_eq!(aerial(folder.path(), "--depth km.exr --depth-unit km -o km-out.exr").code, Some(0));
    assert_eq!(read_channels(&folder.path().join("km-out.exr")), channels);
    assert_eq!(aerial(folder.path(), "--depth km.exr --depth-unit km --depth-kind ray -o ray.exr").code, Some(0));
    let along_rays = &read_channels(&folder.path().join("ray.exr"))["transmittance.B"];
    assert!(along_rays[1] > channels["transmittance.B"][1], "a ray is longer than its part along the axis");
    // Twice the light is a stop more; transmittance stays.
    assert_eq!(aerial(folder.path(), "--depth depth.exr --exr-exposure 1 -o up.exr").code, Some(0));
    for (name, values) in read_channels(&folder.path().join("up.exr")) {
        let factor = if name.starts_with("inscatter") { 2.0 } else { 1.0 };
        assert_eq!(values, channels[&name].iter().map(|value| value * factor).collect::<Vec<_>>(), "{name}");
    }
}

#[test]
fn a_beauty_is_seen_through_the_layers() {
    let folder = tempdir().unwrap();
    depth(folder.path(), "depth.exr", [100.0, 5000.0, 50_000.0, f32::INFINITY]);
    let colour = |name, value: f32| (name, vec![value, 2.0 * value, 3.0 * value, 0.0]);
    let beauty = [colour("View.Combined.R", 0.1), colour("View.Combined.G", 0.2), colour("View.Combined.B", 0.3)];
    let alpha = ("View.Combined.A", vec![1.0, 1.0, 0.5, 0.0]);
    write_channels(&folder.path().join("beauty.exr"), (2, 2), &[&beauty[..], std::slice::from_ref(&alpha)].concat());
    assert_eq!(aerial(folder.path(), "--depth depth.exr -o layers.exr").code, Some(0));
    let ended = aerial(folder.path(), "--depth depth.exr --beauty beauty.exr -o seen.exr");
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let (layers, seen) =
        (read_channels(&folder.path().join("layers.exr")), read_channels(&folder.path().join("seen.exr")));
    assert_eq!(seen["A"], alpha.1);
    for (name, (_, values)) in ["R", "G", "B"].into_iter().zip(&beauty) {
        for (at, value) in values.iter().enumerate() {
            let expected =
                value * layers[&format!("transmittance.{name}")][at] + layers[&format!("inscatter.{name}")][at];
            assert_eq!(seen[name][at], expected, "{name}, pixel {at}");
        }
    }
}

/// Without terrain there is what `render` shows: the sky, and the ground below it.
#[test]
fn nothing_before_the_sky_is_the_sky_that_render_shows() {
    let folder = tempdir().unwrap();
    write_channels(&folder.path().join("depth.exr"), (24, 16), &[("Z", vec![f32::INFINITY; 24 * 16])]);
    let view = "--look-elevation 0 --altitude 2";
    assert_eq!(aerial(folder.path(), &format!("--depth depth.exr {view}")).code, Some(0));
    let line = format!("render --device cpu --path direct --size 24x16 -o sky.exr {} {view}", VIEW.join(" "));
    succeed(folder.path(), &line.split_whitespace().collect::<Vec<_>>());
    let (air, sky) = (read_channels(&folder.path().join("aerial.exr")), read_channels(&folder.path().join("sky.exr")));
    for name in ["R", "G", "B"] {
        let brightest = sky[name].iter().copied().fold(0.0, sorairo_shared::math::max);
        for (found, expected) in air[&format!("inscatter.{name}")].iter().zip(&sky[name]) {
            // Pixels of more than a lookup's entries read light of all orders along straight lines: 4e-4.
            assert!((found - expected).abs() < 1e-3 * brightest, "{name}: {found}, not {expected}");
        }
    }
}

#[test]
fn what_is_no_depth_or_no_beauty_is_refused_in_a_sentence_and_writes_nothing() {
    let folder = tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    depth(folder.path(), "depth.exr", [1.0, 2.0, 3.0, 4.0]);
    depth(folder.path(), "nan.exr", [1.0, 2.0, f32::NAN, 4.0]);
    depth(folder.path(), "negative.exr", [1.0, -2.0, 3.0, 4.0]);
    write_channels(&place("two.exr"), (2, 2), &[("A", vec![1.0; 4]), ("B", vec![1.0; 4])]);
    let grey = |size: (usize, usize)| ["R", "G", "B"].map(|name| (name, vec![0.1; size.0 * size.1]));
    write_channels(&place("large.exr"), (4, 2), &grey((4, 2)));
    write_channels(&place("grey.exr"), (2, 2), &grey((2, 2))[..2]);
    std::fs::write(place("text.exr"), "no image").unwrap();
    let before = contents(folder.path());
    let cases = [
        ("--depth nan.exr", "--depth nan.exr holds NaN at column 0, row 1"),
        ("--depth negative.exr", "--depth negative.exr holds -2 at column 1, row 0"),
        ("--depth two.exr", "--depth two.exr has no depth; a channel Z is wanted, or one alone, and it has A, B"),
        ("--depth text.exr", "--depth text.exr cannot be read as OpenEXR"),
        ("--depth none.exr", "--depth none.exr cannot be read as OpenEXR"),
        ("--depth depth.exr --beauty large.exr", "--beauty large.exr has 4x2 pixels, and the depth image 2x2"),
        ("--depth depth.exr --beauty grey.exr", "--beauty grey.exr has no channel B; it has G, R"),
        ("--depth depth.exr --beauty nan.exr", "--beauty nan.exr has no channel B; it has Z"),
        ("--depth depth.exr --color solve --fit cubic", "--color (render.color) is solve"),
        ("--depth depth.exr -o air.png", "-o air.png: a name that ends in .exr is wanted"),
        ("--depth depth.exr -o missing/air.exr", "-o missing/air.exr cannot be written"),
        ("--depth depth.exr -o depth.exr --no-clobber", "depth.exr exists"),
        ("--depth depth.exr --depth-unit mile", "--depth-unit"),
        ("", "--depth"),
    ];
    for (flags, sentence) in cases {
        let ended = aerial(folder.path(), flags);
        assert_eq!(ended.code, Some(2), "{flags}: {}", ended.stderr);
        assert!(ended.stderr.contains(sentence), "{flags}: {}", ended.stderr);
    }
    let round = run(folder.path(), &["aerial", "--depth", "depth.exr", "--projection", "fisheye"]);
    let sentence = "--projection (camera.projection) is fisheye; the air before a camera takes perspective";
    assert!(round.code == Some(2) && round.stderr.contains(sentence), "{}", round.stderr);
    assert_eq!(names(folder.path()), before.keys().cloned().collect::<Vec<_>>());
    assert_eq!(contents(folder.path()), before);
}

/// A depth behind the ground ends on it, and the sky below the horizon is the ground.
#[test]
fn a_depth_inside_the_ground_ends_on_the_ground() {
    let folder = tempdir().unwrap();
    let of = |kilometres: f32| {
        write_channels(&folder.path().join("depth.exr"), (2, 2), &[("Z", vec![kilometres; 4])]);
        let flags = "--depth depth.exr --depth-unit km --look-elevation=-60 --altitude 1 -o a.exr";
        assert_eq!(aerial(folder.path(), flags).code, Some(0));
        read_channels(&folder.path().join("a.exr"))
    };
    let (inside, deeper) = (of(5.0), of(500.0));
    assert_eq!(inside, deeper);
    let on_ground = of(1e10);
    for name in ["R", "G", "B"] {
        let name = format!("transmittance.{name}");
        let off = (inside[&name][0] - on_ground[&name][0]).abs();
        assert!(off < 1e-3, "{name}: {off}");
    }
}
