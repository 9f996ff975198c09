//! The files that the program writes: where things are in them, and what their numbers are.

use std::path::Path;

use sorairo_oracle::direction;
use sorairo_shared::display::tone::srgb_encode;
use sorairo_shared::glam::{DMat3, DVec2, DVec3, Vec3};
use sorairo_tests::compare::worst_in_images;
use sorairo_tests::program::{Image, read_exr, read_png, run, succeed};
use tempfile::tempdir;

/// Renders on the CPU into a picture and a linear image.
fn render(flags: &[&str]) -> (Image<u8>, Image<f32>) {
    render_scene("", "cpu", flags)
}

fn render_scene(scene: &str, device: &str, flags: &[&str]) -> (Image<u8>, Image<f32>) {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("scene.toml"), scene).unwrap();
    let outputs = ["render", "--scene", "scene.toml", "--device", device, "-o", "a.png", "-o", "a.exr"];
    succeed(folder.path(), &[&outputs, flags].concat());
    (read_png(&at("a.png")), read_exr(&at("a.exr")).0)
}

/// Haze that throws light forwards. Its glow has a width of 6°, and the rest of the sky moves its peak by less than 1°.
const HAZE: &str = "[atmosphere.aerosol]\noptical_depth = 0.3\nasymmetry = 0.9\n";

/// The pixel of the sun, 30° high at an azimuth, in a hazy sky.
fn sun_pixel(azimuth: f64, flags: &[&str]) -> [f64; 2] {
    let azimuth = format!("--sun-azimuth={azimuth}");
    let (_, image) = render_scene(HAZE, "cpu", &[&[azimuth.as_str()], flags].concat());
    let (column, row) = image.brightest();
    [column as f64 + 0.5, row as f64 + 0.5]
}

/// Checks a pixel against where it should be, to a pixel and a half: half the pixel's own size, and 1° of the glow's
/// peak.
fn assert_near(found: [f64; 2], expected: [f64; 2], what: &str) {
    let off = (0..2).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f64::max);
    assert!(off <= 1.5, "{what}: the sun is at {found:?} instead of {expected:?}");
}

#[test]
fn the_sun_is_where_its_azimuth_says_in_an_equirectangular_image() {
    for azimuth in [-90.0, 0.0, 60.0, 135.0, 250.0, 340.0] {
        let column = 256.0 * (azimuth / 360.0f64 + 0.5).rem_euclid(1.0);
        // 30° above the horizon lies a third of the way from the zenith row to the nadir row.
        assert_near(sun_pixel(azimuth, &["--size", "256x128"]), [column, 128.0 / 3.0], &format!("azimuth {azimuth}"));
    }
}

#[test]
fn a_fisheye_has_north_on_top_and_east_on_the_left() {
    // 60° from the zenith on a circle whose radius of 64 pixels spans 90°.
    let r = 64.0 * 60.0 / 90.0;
    let suns =
        [(0.0, [64.0, 64.0 - r]), (90.0, [64.0 - r, 64.0]), (180.0, [64.0, 64.0 + r]), (-90.0, [64.0 + r, 64.0])];
    for (azimuth, expected) in suns {
        let found = sun_pixel(azimuth, &["--projection", "fisheye", "--size", "128x128"]);
        assert_near(found, expected, &format!("azimuth {azimuth}"));
    }
}

#[test]
fn the_sun_is_where_its_azimuth_says_in_a_perspective() {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    for (azimuth, look) in [(100.0, 90.0), (80.0, 90.0), (-170.0, 175.0), (0.0, 0.0)] {
        let flags = ["--projection", "perspective", "--fov", "60", "--size", "96x72", "--look-elevation", "20"];
        let found = sun_pixel(azimuth, &[&flags[..], &[&format!("--look-azimuth={look}")]].concat());
        let sun = direction(30.0, azimuth);
        let along = |axis: [f64; 3]| dot(sun, axis) / dot(sun, direction(20.0, look));
        // A field of 60° is 96 pixels wide.
        let scale = 48.0 / 30f64.to_radians().tan();
        let right = scale * along(direction(0.0, look + 90.0));
        let up = scale * along(direction(110.0, look));
        assert_near(found, [48.0 + right, 36.0 - up], &format!("azimuth {azimuth}, looking to {look}"));
    }
}

#[test]
fn pixels_outside_a_fisheye_are_black() {
    let (picture, image) = render(&["--projection", "fisheye", "--size", "90x60"]);
    let (mut outside, mut inside) = (0, 0);
    for row in 0..60 {
        for column in 0..90 {
            let radius = (column as f64 + 0.5 - 45.0).hypot(row as f64 + 0.5 - 30.0);
            let place = format!("column {column}, row {row}");
            if radius > 30.0 {
                assert_eq!((picture.at(column, row), image.at(column, row)), ([0; 3], [0.0; 3]), "{place}");
                outside += 1;
            } else {
                assert!(image.at(column, row).iter().all(|value| *value > 0.0), "{place}");
                inside += 1;
            }
        }
    }
    assert!(outside > 2000 && inside > 2000);
}

/// The sRGB byte of a linear value (IEC 61966-2-1:1999).
fn srgb(linear: f64) -> f64 {
    255.0 * if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[test]
fn a_picture_without_a_view_transform_is_the_srgb_of_the_linear_image_times_its_exposure() {
    for stops in [-6.0, -3.0] {
        let exposure = format!("--exposure={stops}");
        let flags = ["--preset", "paper", "--size", "128x64", "--sun-elevation", "12", "--view", "srgb", &exposure];
        let (picture, image) = render(&flags);
        for (byte, linear) in picture.rgb.iter().zip(&image.rgb) {
            let shown = (f64::from(*linear) * f64::exp2(stops)).min(1.0);
            // Half a step of rounding, and the other half for single precision beside a border.
            assert!((f64::from(*byte) - srgb(shown)).abs() <= 1.0, "{byte} for {shown}");
        }
        assert!(picture.rgb.iter().any(|&byte| byte > 100), "{stops} stops show nothing");
    }
}

/// Luminance of a picture's pixels down a column, each in linear light of the display.
fn down(picture: &Image<u8>, column: usize) -> Vec<f64> {
    let linear = |byte: u8| {
        let x = f64::from(byte) / 255.0;
        if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    let luminance = |rgb: [u8; 3]| 0.2126 * linear(rgb[0]) + 0.7152 * linear(rgb[1]) + 0.0722 * linear(rgb[2]);
    (0..picture.height).map(|row| luminance(picture.at(column, row))).collect()
}

#[test]
fn a_brighter_sky_is_no_darker_pixel() {
    const HORIZON: usize = 65;
    let camera = ["--projection", "perspective", "--size", "160x90", "--look-elevation", "12", "--fov", "80"];
    for sky in
        [&["--sun-elevation=0"][..], &["--sun-elevation=-6"], &["--preset=hazy", "--sun-elevation=8", "--sun-disc"]]
    {
        for view in ["agx", "aces"] {
            let (picture, image) = render(&[&camera, sky, &["--view", view][..]].concat());
            let shown = down(&picture, 80);
            let sky: Vec<f32> =
                (0..90).map(|row| image.at(80, row)).map(|c| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]).collect();
            let mut compared = 0;
            for (i, j) in (0..90).flat_map(|i| (0..90).map(move |j| (i, j))) {
                // The horizon is smooth in the picture alone.
                if sky[i] > sky[j] && i != HORIZON && j != HORIZON {
                    // Of two colours the more saturated may be shown darker, by as much as AgX does.
                    assert!(shown[i] > shown[j] - 0.03, "{view}, rows {i} and {j}: {} and {}", shown[i], shown[j]);
                    compared += 1;
                }
            }
            assert!(compared > 1000, "{compared}");
        }
    }
}

#[test]
fn every_view_transform_is_the_same_on_a_device() {
    for view in ["agx", "aces", "srgb"] {
        let flags = [
            "--size",
            "64x32",
            "--sun-elevation",
            "5",
            "--sun-disc",
            "--dither",
            "none",
            "--view",
            view,
            "--exposure=-3",
        ];
        let [ours, theirs] = ["cpu", "gpu"].map(|device| render_scene("", device, &flags).0);
        let alone = |device: &str| {
            let folder = tempdir().unwrap();
            succeed(folder.path(), &[&["render", "--device", device, "-o", "a.png"][..], &flags].concat());
            read_png(&folder.path().join("a.png"))
        };
        let apart = |a: &Image<u8>, b: &Image<u8>| {
            assert_eq!(a.rgb.len(), b.rgb.len());
            a.rgb.iter().zip(&b.rgb).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
        };
        // A value at a half may be rounded either way.
        assert!(
            apart(&ours, &theirs) <= 1 && apart(&ours, &alone("gpu")) <= 1 && apart(&ours, &alone("cpu")) <= 1,
            "{view}"
        );
        assert!(ours.rgb.iter().any(|&byte| byte != ours.rgb[0]));
    }
}

#[test]
fn a_picture_alone_is_the_picture_beside_a_linear_image() {
    let folder = tempdir().unwrap();
    let png = |outputs: &[&str]| {
        succeed(folder.path(), &[&["render", "--device", "cpu", "--size", "60x40"], outputs].concat());
        read_png(&folder.path().join("a.png"))
    };
    assert_eq!(png(&["-o", "a.png"]), png(&["-o", "b.exr", "-o", "a.png"]));
}

#[test]
fn an_exposure_is_that_of_what_the_camera_sees() {
    let folder = tempdir().unwrap();
    let stops = |flags: &[&str]| {
        let ended =
            succeed(folder.path(), &[&["render", "--device", "cpu", "--size", "8x4", "--json"], flags].concat());
        let report: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
        report["exposure_ev"].as_f64().unwrap()
    };
    let auto = stops(&[]);
    assert_eq!(auto, stops(&["--exposure", "auto"]));
    let zenith = ["--projection", "perspective", "--fov", "40", "--look-elevation", "90"];
    assert!(stops(&zenith) > auto + 0.3, "the zenith is darker than the low sky");
    // Stops are powers of two, and come back through a logarithm in single precision.
    assert!((stops(&["--exposure", "-2.5"]) + 2.5).abs() < 1e-6);
    assert!(stops(&["--sun-elevation", "-4"]) > auto + 3.0, "twilight needs a longer exposure");
}

#[test]
fn a_cameras_settings_are_its_exposure() {
    let folder = tempdir().unwrap();
    let render = ["render", "--device", "cpu", "--size", "8x4", "--force"];
    let png = |flags: &[&str]| {
        succeed(folder.path(), &[&render, flags, &["-o", "a.png"]].concat());
        read_png(&folder.path().join("a.png"))
    };
    let settings = ["--iso", "400", "--shutter", "1/125", "--aperture", "8"];
    // log2(8² · 125) - log2(400 / 100).
    assert_eq!(png(&settings), png(&["--exposure", "ev10.965784284662087"]));
    assert_ne!(png(&settings), png(&["--iso", "100", "--shutter", "0.008", "--aperture", "8"]));
    for (flags, words) in [
        (&settings[..4], "--iso (render.iso) needs --aperture (render.aperture) beside it"),
        (&settings[2..4], "--shutter (render.shutter) needs --iso (render.iso) beside it"),
        (&["--shutter", "1/0", "--iso", "100", "--aperture", "8"], "inf"),
        (&["--shutter", "quick"], "a fraction such as \"1/125\""),
        (&["--iso", "400", "--exposure", "auto"], "cannot be used with"),
    ] {
        let ended = run(folder.path(), &[&render, flags].concat());
        assert!(ended.code == Some(2) && ended.stderr.contains(words), "{flags:?}: {}", ended.stderr);
    }
    std::fs::write(folder.path().join("a.toml"), "[render]\niso = 100\nshutter = '1/30'\naperture = 8").unwrap();
    let ended = run(folder.path(), &[&render[..], &["--scene", "a.toml", "--exposure", "3"]].concat());
    assert!(
        ended.code == Some(2) && ended.stderr.contains("--exposure (render.exposure) cannot be"),
        "{}",
        ended.stderr
    );
}

/// EV100 of the pictures of views under a sun, less that of a meter which is held level and measures what falls on it.
fn beside_an_incident_meter<const N: usize>(elevation: f64, views: [&[&str]; N]) -> [f64; N] {
    /// C / S of ISO 2720:1974 with C = 250 lx·s and S = 100.
    const ILLUMINANCE_OF_EV100: f64 = 2.5;
    /// K / S with K = 12.5 cd·s/m².
    const LUMINANCE_OF_EV100: f64 = 0.125;
    const LUMENS_PER_WATT: f64 = 683.0;
    let folder = tempdir().unwrap();
    let sun = format!("--sun-elevation={elevation}");
    let camera = ["render", "--device", "cpu", "--size", "96x48", "-o", "a.png", &sun];
    // What falls is the same for all views, and takes a second to sum.
    let report = succeed(folder.path(), &[&camera[..], &["--json"]].concat()).stdout;
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let sunlight: Vec<f64> = serde_json::from_value(report["sun_irradiance_rgb"].clone()).unwrap();
    let direct = DVec3::from_slice(&sunlight).dot(DVec3::new(0.2126, 0.7152, 0.0722)) * LUMENS_PER_WATT;
    let falls = report["illuminance_lux"].as_f64().unwrap() + direct * elevation.to_radians().sin();
    views.map(|view| {
        // In words it has two digits.
        let said = succeed(folder.path(), &[&camera[..], view].concat()).stderr;
        let exposure =
            said.split_once("exposure ").and_then(|(_, rest)| rest.split_once(" EV")).expect("an exposure").0;
        let metered = (0.18 * LUMENS_PER_WATT / LUMINANCE_OF_EV100).log2() - exposure.parse::<f64>().unwrap();
        metered - (falls / ILLUMINANCE_OF_EV100).log2()
    })
}

#[test]
fn a_picture_is_exposed_about_as_an_incident_meter_says() {
    let views: [&[&str]; 4] =
        [&[], &["--sun-disc"], &["--projection", "perspective"], &["--projection", "perspective", "--sun-disc"]];
    // An incident meter is set for what sends back 0.05 π of the light that falls on it. An even sky is the source of
    // it all, log2(1 / 0.05 / π) brighter, of which a picture is opened by a third.
    let even = (20.0 / std::f64::consts::PI).log2() - 1.0 / 3.0;
    // Under a high sun the sky is the source of less, a twelfth at least.
    let least = even - 12f64.log2();
    // The perspective looks towards the sun, where a low one makes a sky five times as bright as it is in the mean.
    let towards_sun = even + 5f64.log2();
    let suns = [60.0, 30.0, 10.0, 0.0];
    let found = suns.map(|sun| beside_an_incident_meter(sun, views));
    for [map, with_disc, perspective, perspective_with_disc] in found {
        // In a map the haze below the horizon counts, which is brightest under a low sun.
        let is_near = (least..even + 0.5).contains(&map) && (map..towards_sun).contains(&perspective);
        // A disc of half a degree hardly counts.
        let is_small = (map - with_disc).abs() < 0.1 && (perspective - perspective_with_disc).abs() < 0.1;
        assert!(is_near && is_small, "suns at {suns:?}, map, with disc, perspective, with disc: {found:.2?}");
    }
}

/// The mean of a picture's bytes of green, from 0 to 255.
fn brightness(sun: &str, flags: &[&str]) -> f64 {
    let view = ["--projection", "perspective", "--size", "96x54", "--look-elevation", "12", "--sun-elevation", sun];
    let (picture, _) = render(&[&view[..], flags].concat());
    mean(picture.rgb.chunks_exact(3).map(|pixel| f64::from(pixel[1])))
}

#[test]
fn a_picture_gets_dark_after_civil_dusk() {
    let suns = ["-5", "-8", "-10", "-12", "-15", "-18"];
    let found = suns.map(|sun| brightness(sun, &[]));
    println!("{found:?}");
    assert!(found.is_sorted_by(|earlier, later| earlier > later), "{found:?}");
    // Found: 113, 106, 102, 79, 39 and 16.
    assert!(found[0] > 90.0 && found[3] < 0.8 * found[0], "{found:?}");
    assert!(found[4] < 0.45 * found[0] && found[5] < 0.2 * found[0], "{found:?}");
    // What is asked for stays.
    assert!(brightness("-12", &["--exposure", "14"]) > found[3], "{found:?}");
}

/// The code points of a PNG's chunk `cICP`; none of one that has none.
fn code_points(path: &Path) -> Option<[u8; 4]> {
    let bytes = std::fs::read(path).unwrap();
    let at = bytes.windows(4).position(|name| name == b"cICP")?;
    assert_eq!(bytes[at - 4..at], 4u32.to_be_bytes(), "its length");
    Some(bytes[at + 4..at + 8].try_into().unwrap())
}

/// Chromaticities (x, y) of red, green, blue and white.
type Chromaticities = [[f32; 2]; 4];

/// Those of a display (ITU-R BT.709-6, SMPTE EG 432-1, ITU-R BT.2020-2), and
/// the code points of its primaries, of the curve of sRGB, of RGB and of the full range (ITU-T H.273).
const DISPLAYS: [(&str, Chromaticities, Option<[u8; 4]>); 3] = [
    ("srgb", [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]], None),
    ("display-p3", [[0.68, 0.32], [0.265, 0.69], [0.15, 0.06], [0.3127, 0.329]], Some([12, 13, 0, 1])),
    ("Rec2020", [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], [0.3127, 0.329]], Some([9, 13, 0, 1])),
];

/// The light of a byte of the curve of sRGB (IEC 61966-2-1:1999).
fn linear(byte: f64) -> f64 {
    let x = byte / 255.0;
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// A sky on each of the [`DISPLAYS`]: XYZ of each pixel, and how far a half of a byte moves it.
fn on_displays(flags: &[&str]) -> [Vec<(DVec3, DVec3)>; 3] {
    DISPLAYS.map(|(display, chromaticities, expected)| {
        let folder = tempdir().unwrap();
        let line = ["render", "--device", "cpu", "--size", "96x48", "--dither", "none"];
        succeed(folder.path(), &[&line, flags, &["--display", display, "-o", "a.png"]].concat());
        let path = folder.path().join("a.png");
        assert_eq!(code_points(&path), expected, "{display}");
        let matrix = to_xyz(chromaticities);
        let of_pixel = |rgb: &[u8]| {
            let rgb = DVec3::new(f64::from(rgb[0]), f64::from(rgb[1]), f64::from(rgb[2]));
            let [low, middle, high] =
                [-0.5, 0.0, 0.5].map(|off| DVec3::from_array((rgb + DVec3::splat(off)).to_array().map(linear)));
            (matrix * middle, matrix * (high - low) * 0.5)
        };
        read_png(&path).rgb.chunks(3).map(of_pixel).collect()
    })
}

/// How far a colour is from the white of a display, in the diagram of chromaticities.
fn saturation(xyz: DVec3) -> f64 {
    (xyz.truncate() / xyz.element_sum()).distance(DVec2::new(0.3127, 0.329))
}

/// How many pixels of a sky have the same colour on every display, within what is rounded and a part of it, and how
/// many are more saturated on wide ones.
fn same_and_more(flags: &[&str], within: f64) -> [usize; 2] {
    let [srgb, p3, rec2020] = on_displays(flags);
    let to_srgb = to_xyz(DISPLAYS[0].1).inverse();
    let (mut same, mut more) = (0, 0);
    for ((narrow, of_narrow), (wide, of_wide)) in srgb.iter().zip(&p3).chain(srgb.iter().zip(&rec2020)) {
        let rgb = to_srgb * *wide;
        // A component at an end of the range may have been cut.
        if wide.y > 0.02 && rgb.min_element() > 2e-3 && rgb.max_element() < 0.99 {
            let off = (*narrow - *wide).abs();
            assert!(off.cmple(*of_narrow + *of_wide + *wide * within).all(), "{flags:?}: {narrow} and {wide}");
            same += 1;
        } else if wide.y > 0.005 && rgb.min_element() < -0.1 * wide.y {
            assert!(saturation(*wide) > saturation(*narrow), "{flags:?}: {narrow} and {wide}");
            more += 1;
        }
    }
    [same, more]
}

#[test]
fn a_wide_display_shows_the_colours_of_srgb_alike_and_others_more_saturated() {
    // From 30 km a twilight is deep blue, and the look takes it out of sRGB.
    // What it adds to a colour ends softly before a display's gamut does, and so a little earlier on sRGB.
    // The look adds three tenths of chroma, which takes a twentieth of the pixels out: 514 of 9216.
    let [same, more] = same_and_more(&["--altitude=30", "--sun-elevation=-8", "--exposure=10.66"], 0.1);
    assert!(same > 2000 && more > 300, "{same} {more}");
    // A sky as it is lies within sRGB, before whose ends ACES bends colours softly too.
    for (view, within) in [("srgb", 0.0), ("aces", 0.1)] {
        let [same, _] = same_and_more(&["--sun-elevation=-6", "--view", view], within);
        assert!(same > 4000, "{view}: {same}");
    }
}

#[test]
fn a_wide_picture_is_the_same_beside_narrow_linear_light() {
    let folder = tempdir().unwrap();
    let line =
        ["render", "--device", "cpu", "--size", "60x40", "--dither", "none", "--display", "display-p3", "--force"];
    let png = |outputs: &[&str]| {
        succeed(folder.path(), &[&line, outputs].concat());
        read_png(&folder.path().join("a.png"))
    };
    let (alone, beside) = (png(&["-o", "a.png"]), png(&["-o", "a.exr", "-o", "a.png"]));
    assert!(alone == beside);
}

/// A picture by night vision and without, on a device.
fn by_night(device: &str, sun: &str) -> [Image<u8>; 2] {
    [&[][..], &["--purkinje"]].map(|flags| {
        let folder = tempdir().unwrap();
        let line =
            ["render", "--device", device, "--size", "64x32", "--sun-elevation", sun, "--look", "none", "-o", "a.png"];
        succeed(folder.path(), &[&line, flags].concat());
        read_png(&folder.path().join("a.png"))
    })
}

/// The parts of red, green and blue in the sum of each pixel's bytes.
fn parts(pixels: &[u8]) -> Vec<DVec3> {
    let parts = |rgb: &[u8]| {
        let rgb = DVec3::new(f64::from(rgb[0]), f64::from(rgb[1]), f64::from(rgb[2]));
        rgb / rgb.element_sum()
    };
    pixels.chunks(3).map(parts).collect()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

#[test]
fn a_night_is_greyer_and_its_ground_bluer_to_an_eye_and_a_day_stays() {
    let [cones, eye] = by_night("cpu", "-9");
    let (sky, ground) = (..64 * 16 * 3, 64 * 17 * 3..);
    let colour =
        |picture: &Image<u8>| mean(parts(&picture.rgb[sky]).iter().map(|part| part.distance(DVec3::splat(1.0 / 3.0))));
    let blue = |picture: &Image<u8>| mean(parts(&picture.rgb[ground.clone()]).iter().map(|part| part.z));
    assert!(colour(&eye) < 0.75 * colour(&cones), "{} of {}", colour(&eye), colour(&cones));
    assert!(blue(&eye) > blue(&cones) + 0.05, "{} after {}", blue(&eye), blue(&cones));
    let [_, on_device] = by_night("gpu", "-9");
    // A value at a half may be rounded either way.
    assert!(eye.rgb.iter().zip(&on_device.rgb).all(|(a, b)| a.abs_diff(*b) <= 1));
    let [cones, eye] = by_night("cpu", "20");
    assert_eq!(cones, eye);
}

#[test]
fn an_exr_says_that_it_is_rec_709() {
    let folder = tempdir().unwrap();
    succeed(folder.path(), &["render", "--device", "cpu", "--size", "9x7", "-o", "a.exr"]);
    let (image, chromaticities) = read_exr(&folder.path().join("a.exr"));
    assert_eq!((image.width, image.height, image.rgb.len()), (9, 7, 9 * 7 * 3));
    // ITU-R BT.709-6, items 1.3 and 1.4.
    assert_eq!(chromaticities, [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]]);
}

/// The matrix from linear RGB to XYZ of an EXR's chromaticities: of red, green, blue and white.
fn to_xyz(chromaticities: [[f32; 2]; 4]) -> DMat3 {
    let [red, green, blue, white] = chromaticities.map(|c| {
        let [x, y] = c.map(f64::from);
        DVec3::new(x, y, 1.0 - x - y)
    });
    let primaries = DMat3::from_cols(red, green, blue);
    primaries * DMat3::from_diagonal(primaries.inverse() * (white / white.y))
}

/// A picture, and a linear image with its chromaticities.
fn with_chromaticities(flags: &[&str]) -> (Image<u8>, Image<f32>, [[f32; 2]; 4]) {
    let folder = tempdir().unwrap();
    let outputs = ["render", "--device", "cpu", "--size", "64x32", "-o", "a.png", "-o", "a.exr"];
    succeed(folder.path(), &[&outputs, flags].concat());
    let (image, chromaticities) = read_exr(&folder.path().join("a.exr"));
    (read_png(&folder.path().join("a.png")), image, chromaticities)
}

#[test]
fn every_space_holds_the_same_colours_and_shows_the_same_picture() {
    // The fit is made in each space anew: where it leaves most, in measured air, the spaces are as far apart.
    let of = |rgb| with_chromaticities(&["--preset", "earth", "--sun-elevation", "8", "--rgb", rgb]);
    let (picture, image, chromaticities) = of("srgb");
    let xyz = |image: &Image<f32>, c| -> Vec<DVec3> {
        let matrix = to_xyz(c);
        image.rgb.chunks(3).map(|rgb| matrix * Vec3::from_slice(rgb).as_dvec3()).collect()
    };
    let reference = xyz(&image, chromaticities);
    for (rgb, expected) in [
        ("rec2020", [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], [0.3127, 0.329]]),
        ("acescg", [[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], [0.321_68, 0.337_67]]),
        ("xyz", [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]]),
    ] {
        let (shown, other, chromaticities) = of(rgb);
        assert_eq!(chromaticities, expected, "{rgb}");
        assert_ne!(other.rgb, image.rgb, "{rgb}");
        let mut compared = 0;
        for (i, (a, b)) in xyz(&other, chromaticities).into_iter().zip(&reference).enumerate() {
            let inside = image.rgb[3 * i..3 * i + 3].iter().all(|value| f64::from(*value) > 1e-3 * b.y);
            if b.y > 0.0 && inside {
                // The matrix of sRGB is rounded to four digits by its standard.
                assert!((a - *b).abs().max_element() <= 5e-4 * b.max_element(), "{rgb}, pixel {i}: {a} {b}");
                compared += 1;
            }
        }
        assert!(compared > 500, "{rgb}: {compared}");
        // Rounding may fall on the other side of a step.
        assert!(shown.rgb.iter().zip(&picture.rgb).all(|(a, b)| a.abs_diff(*b) <= 1), "{rgb}");
    }
}

#[test]
fn a_sky_of_the_suns_own_colour_is_grey_when_balanced_for_the_sun() {
    // Without air and ozone, aerosol of one coefficient at all wavelengths scatters the sun's spectrum as it is.
    let grey = "render.orders = 1\nground.albedo = 0.0\n[atmosphere]\nprofile = 'exponential'\nair.scattering = 0.0\nozone.column = 0.0\n[atmosphere.aerosol]\noptical_depth = 0.1\nangstrom_exponent = 0.0\n";
    for rgb in ["srgb", "rec2020", "acescg", "xyz"] {
        for observer in ["cie1931", "cie2015"] {
            let of = |balance: &str| {
                let flags = ["--size", "16x8", "--rgb", rgb, "--observer", observer, "--white-balance", balance];
                render_scene(grey, "cpu", &flags).1
            };
            let spread = |image: &Image<f32>| {
                let pixel = image.at(3, 2);
                step(pixel, [pixel[1]; 3]) / pixel[1]
            };
            // The fit of the colour leaves 1e-4.
            assert!(spread(&of("sun")) < 1e-3, "{rgb}, {observer}: {:?}", of("sun").at(3, 2));
            assert!(spread(&of("none")) > 1e-2, "{rgb}, {observer}: {:?}", of("none").at(3, 2));
        }
    }
}

#[test]
fn the_observers_agree_on_what_a_sky_looks_like_but_not_to_the_digit() {
    let of = |observer| with_chromaticities(&["--observer", observer]).1;
    let (old, new) = (of("cie1931"), of("cie2015"));
    let mut compared = 0;
    for (a, b) in old.rgb.chunks(3).zip(new.rgb.chunks(3)) {
        let (a, b) = ([a[0], a[1], a[2]], [b[0], b[1], b[2]]);
        if a[1] > 0.0 {
            // The observers differ by some per cent where the eye is most sensitive.
            assert!((1e-3..0.2).contains(&(step(a, b) / a[1])), "{a:?} {b:?}");
            compared += 1;
        }
    }
    assert!(compared > 500);
}

#[test]
fn a_linear_image_does_not_depend_on_the_exposure() {
    let flags = ["--size", "32x16", "--exposure"];
    let of = |stops: &'static str| render(&[&flags[..], &[stops]].concat());
    let ((dark_picture, dark), (bright_picture, bright)) = (of("-6"), of("2"));
    assert_eq!(dark, bright);
    assert_ne!(dark_picture, bright_picture);
}

fn brightest(image: &Image<f32>) -> f32 {
    assert!(image.rgb.iter().all(|value| value.is_finite() && *value >= 0.0), "a pixel is not finite or negative");
    image.rgb.iter().copied().fold(0.0, sorairo_shared::math::max)
}

#[test]
fn twilight_is_dark_and_night_is_black_and_both_are_finite() {
    for device in ["cpu", "gpu"] {
        for preset in ["earth", "paper"] {
            for color in ["solve", "folded"] {
                let of = |sun: &'static str| {
                    let flags = ["--preset", preset, "--color", color, "--size", "48x24", "--sun-elevation", sun];
                    render_scene("", device, &flags)
                };
                let place = format!("{device}, {preset}, {color}");
                let day = brightest(&of("30").1);
                let (picture, twilight) = of("-4");
                let twilight = brightest(&twilight);
                assert!(twilight > 0.0 && twilight < 0.2 * day, "{place}: {twilight:e} of {day:e}");
                assert!(picture.rgb.iter().any(|byte| *byte > 60), "{place}: the exposure shows no twilight");
                // 100 km above ground is in the shadow overhead below -10°, and as far as one sees below -20.2°.
                let (picture, night) = of("-30");
                assert_eq!(brightest(&night), 0.0, "{place}");
                assert!(picture.rgb.iter().all(|byte| *byte == 0), "{place}");
            }
        }
    }
}

/// The absolute differences of two pixels' channels, the largest.
fn step(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, sorairo_shared::math::max)
}

/// Single precision leaves this much of the brightest pixel between neighbours.
const NOISE: f32 = 1e-5;

#[test]
fn the_seam_of_an_equirectangular_image_is_continuous() {
    for (sun, azimuth) in [("30", "170"), ("30", "180"), ("2", "90"), ("-4", "175")] {
        let (_, image) = render(&["--size", "128x64", "--sun-elevation", sun, "--sun-azimuth", azimuth]);
        let (w, noise) = (image.width, NOISE * brightest(&image));
        assert!(noise > 0.0);
        for row in 0..32 {
            let p = |column: usize| image.at(column % w, row);
            // The difference between columns of a smooth sky is like that of their neighbours.
            let beside = sorairo_shared::math::max(step(p(w - 2), p(w - 1)), step(p(0), p(1)));
            let across = step(p(w - 1), p(0));
            assert!(
                across <= 1.5 * beside + noise,
                "sun at {sun}, {azimuth}, row {row}: {across:e}, beside {beside:e}"
            );
        }
    }
}

#[test]
fn the_zenith_is_continuous() {
    for sun in ["90", "80", "30", "-4"] {
        let (_, image) = render(&["--size", "128x64", "--sun-elevation", sun]);
        let noise = NOISE * brightest(&image);
        assert!(noise > 0.0);
        let columns = || 0..image.width;
        // Across the zenith two pixels of the top row lie as far apart as a pixel of the second row lies from the
        // first.
        let beside =
            columns().map(|column| step(image.at(column, 0), image.at(column, 1))).fold(0.0, sorairo_shared::math::max);
        for column in columns() {
            let across = step(image.at(column, 0), image.at((column + 64) % 128, 0));
            assert!(across <= 1.5 * beside + noise, "sun at {sun}, column {column}: {across:e}, beside {beside:e}");
        }
    }
}

#[test]
fn the_sky_is_its_own_mirror_image_about_the_sun() {
    for sun in ["60", "10", "-4"] {
        let (_, image) = render(&["--size", "128x64", "--sun-elevation", sun, "--sun-azimuth", "45"]);
        // The sun stands on the border between columns 79 and 80.
        let mirrored: Vec<f32> =
            (0..image.width * image.height).flat_map(|i| image.at((159 + 128 - i % 128) % 128, i / 128)).collect();
        let worst = worst_in_images(&mirrored, &image.rgb, image.width, 3, 1e-6);
        assert!(worst.relative <= MIRROR, "sun at {sun}: {worst:?}");
        let shifted: Vec<f32> =
            (0..image.width * image.height).flat_map(|i| image.at((i + 1) % 128, i / 128)).collect();
        assert!(worst_in_images(&shifted, &image.rgb, image.width, 3, 1e-6).relative > 10.0 * MIRROR);
    }
}

/// The two directions differ by the rounding of a sine, 1e-7. Beside the horizon at twilight radiance grows a hundred
/// times as fast as the cosine of the zenith angle.
const MIRROR: f64 = 5e-5;

#[test]
fn a_taller_image_shows_the_same_sky() {
    let (_, coarse) = render(&["--path", "direct", "--size", "64x33"]);
    let (_, fine) = render(&["--path", "direct", "--size", "192x99"]);
    // The centre of every pixel is the centre of the middle one of nine.
    let picked: Vec<f32> = (0..64 * 33).flat_map(|i| fine.at(3 * (i % 64) + 1, 3 * (i / 64) + 1)).collect();
    let worst = worst_in_images(&picked, &coarse.rgb, 64, 3, 1e-6);
    assert!(worst.relative <= MIRROR, "{worst:?}");
}

#[test]
fn an_image_of_any_size_is_written() {
    for size in ["1x1", "1x7", "7x1", "3x2"] {
        for projection in ["equirectangular", "fisheye", "perspective"] {
            let (picture, image) = render(&["--size", size, "--projection", projection]);
            assert_eq!(format!("{}x{}", image.width, image.height), size);
            assert_eq!((picture.width, picture.height), (image.width, image.height));
            assert!(brightest(&image) > 0.0, "{size} {projection}");
        }
    }
}

#[test]
fn outputs_of_one_run_go_to_their_own_folders() {
    let folder = tempdir().unwrap();
    let there = |name: &str| folder.path().join(name).is_file();
    for name in ["one", "two"] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
    }
    let absolute = folder.path().join("two/SKY.EXR");
    let outputs = ["-o", "one/a.png", "-o", "two/a.png", "-o", &absolute.to_string_lossy()];
    succeed(folder.path(), &[&["render", "--device", "cpu", "--size", "4x2"], &outputs[..]].concat());
    assert!(there("one/a.png") && there("two/a.png") && absolute.is_file() && !there("sky.png"));
    assert_eq!(read_png(Path::new(&folder.path().join("one/a.png"))), read_png(&folder.path().join("two/a.png")));
}

/// The largest difference between the mean of a picture's bytes over eight by eight pixels and that of the values which
/// they stand for.
fn worst_mean(dither: &str, device: &str) -> f64 {
    let flags =
        ["--projection=perspective", "--fov=20", "--size=256x128", "--exposure=-9", "--view=srgb", "--dither", dither];
    let (picture, linear) = render_scene("", device, &flags);
    let value = |rgb: &[f32]| (Vec3::from_slice(rgb) * (-9.0f32).exp2()).to_array().map(|x| 255.0 * srgb_encode(x));
    let values: Vec<f32> = linear.rgb.chunks(3).flat_map(value).collect();
    let at = |column: usize, row: usize, channel: usize| 3 * (row * linear.width + column) + channel;
    let mut worst = 0.0;
    for (column, row, channel) in
        (0..32).flat_map(|c| (0..16).flat_map(move |r| (0..3).map(move |k| (8 * c, 8 * r, k))))
    {
        let block = || (0..64).map(|i| at(column + i % 8, row + i / 8, channel));
        let bytes: f64 = block().map(|i| f64::from(picture.rgb[i])).sum();
        let light: f64 = block().map(|i| f64::from(values[i])).sum();
        assert!(bytes > 0.0 && light < 64.0 * 255.0, "the picture is neither black nor white");
        worst = f64::max(worst, (bytes - light).abs() / 64.0);
    }
    worst
}

#[test]
fn a_picture_has_no_rings_because_a_few_pixels_have_the_mean_of_their_light() {
    for device in ["cpu", "gpu"] {
        // 64 thresholds are even to a few parts in 64; bytes that are all rounded one way are off by up to a half.
        assert!(worst_mean("ordered", device) < 0.1);
        assert!(worst_mean("none", device) > 0.3);
    }
}
