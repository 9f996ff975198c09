//! The command line: what it promises, how it refuses, and what a failure leaves behind.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use exr::prelude::read_first_flat_layer_from_file;
use serde_json::Value;
use sorairo::PixelFormat;
use sorairo::scene::{CameraScene, Projection, Scene};
use sorairo_tests::program::{Ended, command, contents, names, read_exr, read_png, run, succeed};
use sorairo_tests::sky::plan_of;
use sorairo_tests::wait;
use tempfile::{TempDir, tempdir};

fn folder() -> TempDir {
    tempdir().expect("a folder for temporary files")
}

/// The JSON value that a run printed as its only line.
fn json(ended: &Ended) -> Value {
    assert_eq!(ended.stdout.lines().count(), 1, "{}", ended.stdout);
    serde_json::from_str(&ended.stdout).expect("JSON")
}

#[test]
fn render_without_outputs_writes_sky_png_and_sky_exr() {
    let folder = folder();
    let ended = succeed(folder.path(), &["render", "--device", "cpu"]);
    assert_eq!(names(folder.path()), ["sky.exr", "sky.png"]);
    let png = read_png(&folder.path().join("sky.png"));
    let (exr, _) = read_exr(&folder.path().join("sky.exr"));
    assert_eq!([png.width, png.height, exr.width, exr.height], [1024, 512, 1024, 512]);
    assert_eq!(ended.stdout, "");
    for part in ["sky.png, sky.exr: 1024x512", "exposure", "CPU"] {
        assert!(ended.stderr.contains(part), "no {part} in the summary: {}", ended.stderr);
    }
}

#[test]
fn json_has_the_promised_keys() {
    let folder = folder();
    let out = ["render", "--size", "32x16", "-o", "a.png", "-o", "b.exr", "--json"];
    for (device, backend) in [("cpu", "cpu"), ("gpu", "gpu")] {
        let report = json(&succeed(folder.path(), &[&out[..], &["--device", device]].concat()));
        let known = [
            ("backend", Value::from(backend)),
            ("width", 32.into()),
            ("height", 16.into()),
            ("color", "folded".into()),
            ("rgb", "srgb".into()),
            ("observer", "cie1931".into()),
            ("white_balance", "none".into()),
            ("outputs", vec!["a.png", "b.exr"].into()),
        ];
        for (key, value) in known {
            assert_eq!(report[key], value, "{key} in {report}");
        }
        for key in ["device", "fit"] {
            assert!(!report[key].as_str().unwrap().is_empty(), "{key} in {report}");
        }
        assert!(report["steps"].as_u64().unwrap() > 0, "{report}");
        let irradiances =
            ["irradiance_w_m2", "direct_irradiance_w_m2", "ground_irradiance_w_m2", "sun_irradiance_w_m2"];
        for key in irradiances.into_iter().chain(["illuminance_lux", "luminance_zenith_cd_m2"]) {
            assert!(report[key].as_f64().unwrap() > 0.0, "{key} in {report}");
        }
        assert_eq!(report["irradiance_rgb"].as_array().unwrap().len(), 3, "{report}");
        let time =
            |key: &str| report[key].as_f64().filter(|time| *time >= 0.0).unwrap_or_else(|| panic!("{key}: {report}"));
        let parts: f64 = ["plan_ms", "kernel_ms", "readback_ms", "encode_ms"].map(time).iter().sum();
        assert!(time("kernel_ms") > 0.0 && parts <= time("total_ms"), "{report}");
    }
}

#[test]
fn a_map_says_whether_the_sun_is_in_it() {
    let folder = folder();
    let render = ["render", "--device", "cpu", "--size", "64x32", "-o", "a.exr", "--json"];
    for (flags, disc, words) in [
        (&[][..], false, "light of all orders, without the sun's disc"),
        (&["--sun-disc", "--orders", "1"], true, "single scattering, with the sun's disc"),
    ] {
        let report = json(&succeed(folder.path(), &[&render[..], flags].concat()));
        assert_eq!(report["sun_disc"], disc);
        let file = read_first_flat_layer_from_file(folder.path().join("a.exr")).unwrap();
        let comment = file.layer_data.attributes.comments.expect("a comment").to_string();
        assert!(comment.starts_with(words), "{comment}");
    }
}

/// The kind and the data of each chunk of a PNG.
fn png_chunks(path: &Path) -> Vec<(String, Vec<u8>)> {
    let bytes = std::fs::read(path).unwrap();
    let (mut rest, mut chunks) = (&bytes[8..], Vec::new());
    while let [a, b, c, d, after @ ..] = rest {
        let length = u32::from_be_bytes([*a, *b, *c, *d]) as usize;
        chunks.push((String::from_utf8(after[..4].to_vec()).unwrap(), after[4..4 + length].to_vec()));
        rest = &after[4 + length + 4..];
    }
    chunks
}

#[test]
fn a_png_says_that_it_is_srgb() {
    let folder = folder();
    let small = ["--device", "cpu", "--size", "8x4", "--rgb", "rec2020", "-o", "a#.png"];
    succeed(folder.path(), &[&["sequence", "--sun-elevation", "5:5:1"], &small[..]].concat());
    succeed(folder.path(), &[&["render", "-o", "linear.exr"], &small[..]].concat());
    for name in ["a0.png", "contact.png", "a#.png"] {
        let chunks = png_chunks(&folder.path().join(name));
        let kinds: Vec<&str> = chunks.iter().map(|(kind, _)| kind.as_str()).collect();
        let at = kinds.iter().position(|&kind| kind == "sRGB").unwrap_or_else(|| panic!("{name}: {kinds:?}"));
        assert!(at < kinds.iter().position(|&kind| kind == "IDAT").unwrap(), "{name}: {kinds:?}");
        // One byte: the intent, relative to the white of the display.
        assert_eq!(chunks[at].1, [1], "{name}");
    }
}

#[test]
fn an_exr_says_in_openexrs_own_words_what_it_is() {
    let folder = folder();
    let attributes = |flags: &str| {
        let line = format!("render --device cpu --size 8x4 -o a.exr {flags}");
        succeed(folder.path(), &line.split_whitespace().collect::<Vec<_>>());
        read_first_flat_layer_from_file(folder.path().join("a.exr")).unwrap().layer_data.attributes
    };
    let map = attributes("--place 43.06,141.35 --time 2026-06-21T04:30:07.5+09:00");
    assert_eq!(map.environment_map, Some(exr::meta::attribute::EnvironmentMap::LatitudeLongitude));
    // UTC is local time and the offset together.
    assert_eq!(map.capture_date.map(|date| date.to_string()).as_deref(), Some("2026:06:21 04:30:07"));
    assert_eq!((map.utc_offset, map.latitude, map.longitude), (Some(-32400.0), Some(43.06), Some(141.35)));
    // 683 lm/W, as for Y.
    assert!((map.white_luminance.unwrap() - 683.0).abs() < 0.01, "{:?}", map.white_luminance);
    let view = attributes("--projection perspective");
    assert_eq!((view.environment_map, view.capture_date, view.latitude), (None, None, None));
}

#[test]
fn an_exr_is_packed_as_was_asked_and_holds_the_same() {
    use exr::prelude::Compression;
    let folder = folder();
    // Neither side fills the blocks of 16 and 32 lines.
    let render = |exr: &str, compression: &str| {
        let flags = ["render", "--device", "cpu", "--size", "250x121", "-o", "a.exr", "--exr", exr];
        succeed(folder.path(), &[&flags[..], &["--exr-compression", compression]].concat());
        let path = folder.path().join("a.exr");
        let file = read_first_flat_layer_from_file(&path).unwrap();
        let channels = file.layer_data.channel_data.list.iter().map(|channel| channel.sample_data.clone());
        (file.layer_data.encoding.compression, channels.collect::<Vec<_>>(), path.metadata().unwrap().len())
    };
    for (exr, usual, most) in [("f32", Compression::PIZ, 0.6), ("f16", Compression::ZIP16, 0.5)] {
        let (compression, pixels, runs) = render(exr, "rle");
        assert_eq!(compression, Compression::RLE);
        for (name, expected) in [
            ("none", Compression::Uncompressed),
            ("zips", Compression::ZIP1),
            ("zip", Compression::ZIP16),
            ("piz", Compression::PIZ),
            ("auto", usual),
        ] {
            let (compression, found, bytes) = render(exr, name);
            assert_eq!(compression, expected, "{exr}, {name}");
            assert!(found == pixels, "{exr}, {name}: other pixels");
            // What nobody chose is much smaller than runs of equal bytes.
            assert!(name != "auto" || (bytes as f64) < most * runs as f64, "{exr}: {bytes} of {runs} bytes");
        }
    }
}

#[test]
fn the_usual_names_take_the_place_of_own_files_alone() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let render = |flags: &str| {
        let line = format!("render --device cpu --size 8x4 {flags}");
        run(folder.path(), &line.split_whitespace().collect::<Vec<_>>())
    };
    assert!(!render("").stderr.contains("replaced"));
    // Of another scene, by this program.
    let again = render("--sun-elevation 3 --json");
    assert!(again.stderr.contains("sky.png (replaced), sky.exr (replaced):"), "{}", again.stderr);
    assert_eq!(json(&again)["replaced"], Value::from(vec!["sky.png", "sky.exr"]));
    let whole = ["sky.png", "sky.exr"].map(|name| std::fs::read(at(name)).unwrap());
    for (name, whole) in ["sky.png", "sky.exr"].into_iter().zip(&whole) {
        let mut changed = whole.clone();
        *changed.last_mut().unwrap() ^= 1;
        // By another program, cut off, changed by another.
        for foreign in [&b"mine"[..], &[], &whole[..whole.len() - 1], &changed] {
            std::fs::write(at(name), foreign).unwrap();
            let before = contents(folder.path());
            for (flags, words) in [("", "--force"), ("--no-clobber", "exists"), ("-n -o b.png -o sky.exr", "exists")] {
                if flags.contains("-o") && name == "sky.png" {
                    continue;
                }
                let ended = render(flags);
                assert_eq!(ended.code, Some(2), "{name}, {flags}: {}", ended.stderr);
                let sentence = ended.stderr.lines().find(|line| line.starts_with("sorairo: ")).unwrap();
                assert!(sentence.contains(words), "{name}, {flags}: {sentence}");
                assert!(contents(folder.path()) == before, "{name}, {flags}: something was written");
            }
            let named = render(&format!("-o {name}"));
            assert!(named.code == Some(0) && named.stderr.contains(&format!("{name} (replaced):")), "{named:?}");
            std::fs::write(at(name), foreign).unwrap();
            assert_eq!(render("--force").code, Some(0));
            assert!(contents(folder.path())[name] != foreign);
        }
    }
    assert!(render("--no-clobber").code == Some(2) && render("-n -o new.png").code == Some(0));
    assert_eq!(render("--force --no-clobber").code, Some(2));
}

#[test]
fn frames_their_sheet_and_new_scenes_take_no_foreign_places_either() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("frames")).unwrap();
    let sequence = |flags: &str| {
        let line = format!("sequence --device cpu --size 8x4 --sun-elevation 0:1:1 {flags}");
        run(folder.path(), &line.split_whitespace().collect::<Vec<_>>())
    };
    for name in ["frames/sky.0000.png", "frames/contact.png"] {
        std::fs::write(folder.path().join(name), "mine").unwrap();
        let ended = sequence("");
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains(name) && ended.stderr.contains("--force"), "{}", ended.stderr);
        assert_eq!(std::fs::read(folder.path().join(name)).unwrap(), b"mine");
        assert_eq!(sequence("--force").code, Some(0));
        assert!(std::fs::read(folder.path().join(name)).unwrap() != b"mine");
    }
    // Own frames of other scenes are.
    let ended = sequence("--albedo 0.5");
    assert!(ended.stderr.contains("2 frames rendered, 2 of them replaced, 0 skipped"), "{}", ended.stderr);
    assert_eq!(sequence("--albedo 0.5 --no-clobber").code, Some(0));
    assert_eq!(sequence("--albedo 0.1 --no-clobber").code, Some(2));

    std::fs::write(folder.path().join("scene.toml"), "mine").unwrap();
    for (flag, code) in [("--no-clobber", 2), ("--quiet", 2), ("--force", 0)] {
        assert_eq!(run(folder.path(), &["scene", "new", flag]).code, Some(code), "{flag}");
        assert_eq!(std::fs::read(folder.path().join("scene.toml")).unwrap() == b"mine", code == 2);
    }
}

/// The exposure (stops) of the picture of a scene.
fn exposure(change: impl FnOnce(&mut Scene)) -> f64 {
    let mut scene = Scene::default();
    scene.camera.size = "32x16".parse().unwrap();
    change(&mut scene);
    plan_of(&scene, PixelFormat::Picture).exposure().into()
}

#[test]
fn a_meter_sees_what_the_camera_sees_and_not_the_suns_disc() {
    let perspective = |azimuth: f64| CameraScene {
        projection: Projection::Perspective,
        look_elevation: Some(20.0),
        look_azimuth: Some(azimuth),
        ..CameraScene::default()
    };
    let fisheye = CameraScene { projection: Projection::Fisheye, ..CameraScene::default() };
    for elevation in [60.0, 30.0, 10.0, 2.0, 0.0, -4.0, -9.0] {
        let seen = |camera: &CameraScene, disc: bool| {
            exposure(|scene| {
                scene.camera = CameraScene { size: scene.camera.size, ..camera.clone() };
                (scene.sun.elevation, scene.sun.disc) = (elevation, disc);
            })
        };
        for camera in [CameraScene::default(), perspective(0.0), fisheye.clone()] {
            let [without, with] = [false, true].map(|disc| seen(&camera, disc));
            // A disc that is hardly seen would darken what lies around it.
            assert!((with - without).abs() < 0.3, "{elevation}°, {camera:?}: {without} and {with} with its disc");
        }
        // The sky opposite is darker than that around the sun, unless the sun stands high.
        let [towards, away] = [0.0, 180.0].map(|azimuth| seen(&perspective(azimuth), false));
        assert!(away > towards + if elevation < 60.0 { 0.5 } else { -0.5 }, "{elevation}°: {towards}, {away}");
    }
    // From space the limb and the ground are metered, not the black above them: a sunlit Earth wants some EV100 15,
    // which are -5.1 stops.
    let down = exposure(|scene| {
        (scene.observer.altitude, scene.sun.elevation) = (400.0, 40.0);
        (scene.camera.projection, scene.camera.look_elevation) = (Projection::Perspective, Some(-30.0));
    });
    assert!((-8.0..-3.0).contains(&down), "{down}");
}

#[test]
fn a_cameras_setting_is_an_exposure_and_an_eye_that_adapts_lets_dusk_fall() {
    let under = |how: &str, elevation: f64| {
        exposure(|scene| (scene.render.exposure, scene.sun.elevation) = (how.parse().unwrap(), elevation))
    };
    // Middle grey, .18, is 2^15 K/S = 4096 cd/m² at an EV100 of 15, which is 6.00 W/m²/sr.
    let daylight = (0.18 * 683.0 / 4096.0f64).log2();
    assert!((under("ev15", 30.0) - daylight).abs() < 1e-6);
    assert!((under("ev12.5", 30.0) - daylight - 2.5).abs() < 1e-6);
    for elevation in [60.0, 0.0, -6.0, -12.0] {
        let [auto, adapted] = ["auto", "adapt"].map(|how| under(how, elevation));
        // From the end of civil dusk on, an EV100 of 0, it adapts too.
        let dusk = daylight + 15.0;
        assert_eq!(auto > dusk, elevation < -6.0, "sun at {elevation}: {auto}");
        let metered = if auto > dusk { dusk + (auto - dusk) / 0.62 } else { auto };
        let expected = daylight + 0.62 * (metered - daylight);
        assert!((adapted - expected).abs() < 1e-4, "sun at {elevation}: {metered}, {adapted}");
    }
}

#[test]
fn light_that_half_floats_would_cut_off_is_refused_with_the_exposure_that_keeps_it() {
    let folder = folder();
    std::fs::write(folder.path().join("near.toml"), "sun.distance = 0.01\nsun.elevation = 60\n").unwrap();
    for (device, outputs) in
        [("cpu", "-o a.exr"), ("gpu", "-o a.exr"), ("cpu", "-o a.exr -o a.png"), ("cpu", "-o a.spectral.exr")]
    {
        let render = |flags: &str| {
            let line = format!("render --device {device} --size 64x32 --scene near.toml --exr f16 {outputs} {flags}");
            run(folder.path(), &line.split_whitespace().collect::<Vec<_>>())
        };
        let ended = render("--exr-exposure 0");
        assert_eq!(ended.code, Some(2), "{outputs}: {}", ended.stderr);
        for words in ["--exr (render.exr) is f16", "65504", "% of the image's light would be lost", "--exr-exposure -"]
        {
            assert!(ended.stderr.contains(words), "{outputs}: no {words:?} in {}", ended.stderr);
        }
        assert_eq!(names(folder.path()), ["near.toml"]);
        // The exposure that it names is enough, and so is the one that nobody chose.
        let named = ended.stderr.split("--exr-exposure ").nth(1).unwrap().split(' ').next().unwrap();
        for flags in [&format!("--exr-exposure {named}")[..], ""] {
            let ended = render(flags);
            assert_eq!(ended.code, Some(0), "{outputs} {flags}: {}", ended.stderr);
        }
        names(folder.path()).iter().filter(|name| *name != "near.toml").for_each(|name| {
            std::fs::remove_file(folder.path().join(name)).unwrap();
        });
    }
}

/// The values of an EXR, channel after channel, as radiance; and by how many stops they are exposed.
fn exposed(path: &Path) -> (Vec<Vec<f32>>, f32) {
    use exr::prelude::{AttributeValue, FlatSamples};
    let file = read_first_flat_layer_from_file(path).unwrap();
    let attributes = &file.layer_data.attributes;
    let Some(AttributeValue::F32(stops)) = attributes.other.get(&exr::prelude::Text::from("sorairoExposure")) else {
        panic!("{}: no exposure", path.display())
    };
    // The luminance of 1 says the same to programs that know OpenEXR's own attribute.
    let white = attributes.white_luminance.unwrap() * stops.exp2();
    assert!((white / 683.0 - 1.0).abs() < 1e-4, "{white}");
    let values = |samples: &FlatSamples| match samples {
        FlatSamples::F16(samples) => samples.iter().map(|value| value.to_f32() / stops.exp2()).collect(),
        FlatSamples::F32(samples) => samples.iter().map(|value| value / stops.exp2()).collect(),
        FlatSamples::U32(_) => panic!("whole numbers"),
    };
    (file.layer_data.channel_data.list.iter().map(|channel| values(&channel.sample_data)).collect(), *stops)
}

#[test]
fn half_floats_hold_the_suns_disc_and_the_light_of_twilight() {
    let folder = folder();
    for (flags, is_brighter, sign) in [
        // Eight times what half floats reach, at this size of a pixel.
        ("-o NAME.exr --sun-disc --size 512x256 --sun-elevation 40", true, -1.0),
        // A quarter of these pixels became 0.
        ("-o NAME.spectral.exr --wavelengths 550 --size 64x32 --sun-elevation -12", false, 1.0),
        ("-o NAME.exr --size 64x32 --sun-elevation 40", false, 0.0),
    ] {
        let render = |name: &str, more: &str| {
            let line = format!("render --device cpu {} {more}", flags.replace("NAME", name));
            succeed(folder.path(), &line.split_whitespace().collect::<Vec<_>>());
            let extension = if flags.contains("spectral") { "spectral.exr" } else { "exr" };
            exposed(&folder.path().join(format!("{name}.{extension}")))
        };
        let (full, none) = render("full", "");
        let (half, stops) = render("half", "--exr f16");
        assert_eq!(none, 0.0);
        // By day as it is, where nothing is lost.
        assert!(if sign == 0.0 { stops == 0.0 } else { stops * sign > 0.0 && stops % 1.0 == 0.0 }, "{flags}: {stops}");
        let brightest = full.iter().flatten().copied().fold(0.0, sorairo_shared::math::max);
        assert_eq!(brightest > 65504.0, is_brighter, "{flags}: {brightest}");
        for (full, half) in full.iter().flatten().zip(half.iter().flatten()) {
            // Half floats have 11 bits, fewer below 2⁻¹⁴ of what they hold.
            let allowed = full * (-11f32).exp2() + (-25.0 - stops).exp2();
            assert!((full - half).abs() <= allowed && (*full == 0.0 || *half > 0.0), "{flags}: {half} for {full}");
        }
        // An exposure by hand holds in 32 bits too.
        let (by_hand, stops) = render("hand", "--exr-exposure -3");
        assert!(stops == -3.0 && by_hand == full, "{flags}");
    }
    let line = "render --device cpu -o a.spectral.exr --wavelengths 550 --size 64x32 --sun-elevation -12 --exr f16";
    let words = |more: &str| format!("{line} {more}").split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let ended = |more| run(folder.path(), &words(more).iter().map(String::as_str).collect::<Vec<_>>());
    let weak = ended("--exr-exposure 0").stderr;
    assert!(weak.contains("of the values that are not 0 lie below 6.1e-5") && weak.contains("become 0"), "{weak}");
    assert!(!ended("").stderr.contains("become 0"));
}

#[test]
fn every_flag_of_the_contract_is_accepted() {
    let folder = folder();
    std::fs::write(folder.path().join("scene.toml"), "[sun]\nelevation = 10\n").unwrap();
    let everything: [&[&str]; 32] = [
        &["--scene", "scene.toml"],
        &["-o", "x.png"],
        &["--preset", "earth"],
        &["--preset", "paper"],
        &["--sun-elevation", "-4"],
        &["--sun-azimuth", "-90"],
        &["--altitude", "2.5"],
        &["--projection", "equirectangular"],
        &["--projection", "fisheye", "--fov", "150"],
        &["--projection", "perspective", "--fov", "40", "--look-azimuth", "-20", "--look-elevation", "-5"],
        &["--size", "5x3"],
        &["--fit", "cubic"],
        &["--fit", "transfer"],
        &["--fit", "extinction"],
        &["--fit", "dense"],
        &["--bands", "440,500,550,600,660"],
        &["--color", "solve"],
        &["--color", "folded"],
        &["--samples", "3"],
        &["--exposure", "-2.5"],
        &["--exposure", "auto"],
        &["--rgb", "srgb"],
        &["--rgb", "rec2020"],
        &["--rgb", "acescg", "--white-balance", "d65"],
        &["--rgb", "xyz", "--white-balance", "none"],
        &["--white-balance", "sun"],
        &["--observer", "cie1931"],
        &["--observer", "cie2015"],
        &["--sun-disc"],
        &["--device", "auto"],
        &["--device", "gpu"],
        &["--json"],
    ];
    for flags in everything {
        let most: &[&str] = if flags[0] == "--size" { &[] } else { &["--size", "4x2"] };
        let device: &[&str] = if flags[0] == "--device" { &[] } else { &["--device", "cpu"] };
        succeed(folder.path(), &[&["render"], flags, most, device].concat());
        let spectrum = [&["spectrum"], flags, &SPECTRUM[1..], &["--wavelengths", "550"]].concat();
        if OF_A_SPECTRUM.contains(&flags[0]) {
            let ended = succeed(folder.path(), &spectrum);
            assert_eq!(ended.stdout.lines().count(), 2, "{flags:?}: {}", ended.stdout);
        } else {
            // What changes nothing is not taken.
            let ended = run(folder.path(), &spectrum);
            assert!(
                ended.code == Some(2) && ended.stderr.contains("unexpected argument"),
                "{flags:?}: {}",
                ended.stderr
            );
        }
    }
}

/// The flags of the contract that a spectrum takes.
const OF_A_SPECTRUM: [&str; 9] = [
    "--scene",
    "--preset",
    "--sun-elevation",
    "--sun-azimuth",
    "--altitude",
    "--fit",
    "--bands",
    "--samples",
    "--observer",
];

#[test]
fn a_flag_takes_the_place_of_its_key_and_a_key_that_of_the_preset() {
    let folder = folder();
    let spectrum = |scene: &str, flags: &[&str]| {
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let view = ["spectrum", "--view-elevation", "20", "--view-azimuth", "40", "--wavelengths", "450,600"];
        succeed(folder.path(), &[&view, flags].concat()).stdout
    };
    let from_file = &["--scene", "scene.toml"][..];
    let standard = spectrum("", &["--sun-elevation", "10"]);
    let paper = spectrum("", &["--sun-elevation", "10", "--preset", "paper"]);
    assert_ne!(standard, paper);
    assert_eq!(spectrum("[sun]\nelevation = 10", from_file), standard);
    assert_eq!(spectrum("preset = 'paper'\n[sun]\nelevation = 10", from_file), paper);
    assert_eq!(spectrum("[sun]\nelevation = 50", &[from_file, &["--sun-elevation", "10"]].concat()), standard);
    assert_eq!(
        spectrum("preset = 'paper'\n[sun]\nelevation = 10", &[from_file, &["--preset", "standard"]].concat()),
        standard
    );
}

#[test]
fn devices_lists_the_cpu_last() {
    let folder = folder();
    let list = json(&succeed(folder.path(), &["devices", "--json"]));
    let devices = list.as_array().unwrap();
    assert_eq!(devices.last().unwrap()["kind"], "cpu");
    let lines = succeed(folder.path(), &["devices"]).stdout;
    assert_eq!(lines.lines().count(), devices.len());
    for (line, device) in lines.lines().zip(devices) {
        assert!(line.starts_with(device["name"].as_str().unwrap()), "{line}");
    }
}

#[test]
fn part_of_a_name_chooses_the_device() {
    let folder = folder();
    let list = json(&succeed(folder.path(), &["devices", "--json"]));
    let name = list[0]["name"].as_str().unwrap();
    assert_ne!(list[0]["kind"], "cpu", "this test needs a Vulkan device");
    let part = &name[1..].to_uppercase();
    let report = json(&succeed(folder.path(), &["render", "--size", "4x2", "--json", "--device", part]));
    assert_eq!((&report["device"], &report["backend"]), (&name.into(), &"gpu".into()));
}

/// The program where no Vulkan driver is found.
fn run_without_vulkan(folder: &Path, arguments: &[&str]) -> Ended {
    let mut command = command(folder, arguments);
    for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        command.env(variable, folder.join("no-driver.json"));
    }
    command.output().expect("the program starts").into()
}

#[test]
fn without_vulkan_the_cpu_renders_and_says_so() {
    let folder = folder();
    let ended = run_without_vulkan(folder.path(), &["render", "--size", "4x2", "--json"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert_eq!(json(&ended)["backend"], "cpu");
    // On a busy machine it says what it is doing besides.
    let is_said = |line: &&str| line.starts_with("sorairo: ") && !line.ends_with("...");
    let said: Vec<_> = ended.stderr.lines().filter(is_said).collect();
    assert!(said.len() == 1 && said[0].contains("no Vulkan device"), "{}", ended.stderr);

    let ended = run_without_vulkan(folder.path(), &["render", "--size", "4x2", "--device", "gpu"]);
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    assert!(ended.stderr.contains("--device \"gpu\"") && ended.stderr.contains("cpu"), "{}", ended.stderr);
}

/// Checks that a request is refused: exit code 2, one sentence with all of `named` in it, and no trace in the folder.
fn refuses(scene: Option<&str>, arguments: &[&str], named: &[&str]) {
    let folder = folder();
    let path = folder.path();
    std::fs::create_dir(path.join("folder.png")).unwrap();
    for name in ["sky.png", "sky.exr", "a.png"] {
        std::fs::write(path.join(name), "was here before").unwrap();
    }
    let mut arguments = arguments.to_vec();
    if let Some(scene) = scene {
        std::fs::write(path.join("scene.toml"), scene).unwrap();
        arguments.extend(["--scene", "scene.toml"]);
    }
    let before = contents(path);
    let Ended { code, stdout, stderr } = run(path, &arguments);
    let request = format!("{arguments:?} {}", scene.unwrap_or_default());
    assert_eq!(code, Some(2), "{request}: {stderr}");
    assert_eq!(stdout, "", "{request}");
    assert!(!stderr.contains("panicked"), "{request}: {stderr}");
    match stderr.strip_prefix("sorairo: ") {
        Some(sentence) => assert_eq!(sentence.trim_end().lines().count(), 1, "{request}: {stderr}"),
        // The parser of the flags adds where to find help.
        None => assert!(stderr.starts_with("error: ") && stderr.contains("--help"), "{request}: {stderr}"),
    }
    for part in named {
        assert!(stderr.contains(part), "{request}: no {part:?} in {stderr}");
    }
    assert!(contents(path) == before, "{request} changed the folder: {:?}", names(path));
}

const SPECTRUM: [&str; 5] = ["spectrum", "--view-elevation", "20", "--view-azimuth", "30"];

/// A clear sky with a low sun is polarised most across the sun, and hardly towards it.
#[test]
fn a_map_shows_where_light_is_polarised() {
    let folder = folder();
    let path = folder.path();
    let line = "render --device cpu --size 200x100 --sun-elevation 5 --sun-azimuth 180 --show polarisation-degree";
    succeed(path, &line.split(' ').collect::<Vec<_>>());
    let map = read_png(&path.join("polarisation-degree.png"));
    assert_eq!((map.width, map.height), (200, 132), "the legend stands below");
    let light = |column: usize, row: usize| map.at(column, row).map(u32::from).iter().sum::<u32>();
    // The zenith, and the sun in the middle; black ground has no light.
    assert!(light(100, 2) > 2 * light(100, 46), "{} {}", light(100, 2), light(100, 46));
    // What it wrote itself it may replace, and nothing else.
    succeed(path, &line.split(' ').collect::<Vec<_>>());
    std::fs::write(path.join("polarisation-degree.png"), "another's").unwrap();
    assert_eq!(run(path, &line.split(' ').collect::<Vec<_>>()).code, Some(2));
}

#[test]
fn a_wrong_flag_exits_with_2_and_one_sentence() {
    let table: &[(&str, &[&str])] = &[
        ("--sun-elevation 90.5", &["--sun-elevation", "90.5", "between -90 and 90"]),
        ("--sun-elevation -91", &["--sun-elevation", "-91", "between -90 and 90"]),
        ("--sun-elevation nan", &["--sun-elevation", "NaN", "between -90 and 90"]),
        ("--sun-elevation inf", &["--sun-elevation", "inf", "between -90 and 90"]),
        ("--sun-elevation=-inf", &["--sun-elevation", "-inf", "between -90 and 90"]),
        ("--sun-elevation high", &["--sun-elevation", "high", "a number"]),
        ("--polariser 10 --polarisation off", &["--polariser", "polarised light", "off"]),
        ("--polariser 10 --path direct", &["--polariser", "--path direct", "lookup"]),
        ("--polariser 10 --color solve", &["--polariser", "solve", "folded"]),
        ("--polariser 10 -o sky.spectral.exr", &["--polariser", "spectral"]),
        ("--polariser inf", &["--polariser", "inf"]),
        ("--polariser 10 --polariser-extinction 0.9", &["--polariser-extinction", "0.9", "between 1 and"]),
        ("--polariser-extinction 100", &["--polariser-extinction", "--polariser"]),
        ("--show polarisation", &["--show", "polarisation-degree", "polarisation-angle"]),
        ("--show polarisation-angle -o a.exr", &["-o a.exr", "--show", ".png"]),
        ("--show polarisation-angle --polariser 10", &["--show", "--polariser"]),
        ("--show polarisation-angle --polarisation off", &["--show", "--polarisation off"]),
        ("--show polarisation-degree --size 100x50", &["--show", "200 pixels", "100x50"]),
        ("--sun-elevation", &["--sun-elevation", "value is required"]),
        ("--sun-azimuth nan", &["--sun-azimuth", "is NaN", "a finite number of degrees"]),
        ("--look-azimuth inf", &["--look-azimuth", "is inf", "a finite number of degrees"]),
        ("--look-azimuth nan", &["--look-azimuth", "is NaN", "a finite number of degrees"]),
        ("--altitude -1", &["--altitude", "-1", "between 0 and 100000 km"]),
        ("--altitude 1e9", &["--altitude", "1000000000", "between 0 and 100000 km"]),
        ("--altitude nan", &["--altitude", "NaN", "between 0 and 100000 km"]),
        ("--projection fisheye --fov 361", &["--fov", "361", "between 0.01 and 360"]),
        ("--projection perspective --fov 171", &["--fov", "171", "between 0.01 and 170"]),
        ("--projection perspective --fov 0", &["--fov", "0", "between 0.01 and 170"]),
        ("--fov nan", &["--fov", "NaN", "between"]),
        ("--look-elevation -90.1", &["--look-elevation", "-90.1", "between -90 and 90"]),
        ("--samples 0", &["--samples", "0", "between 1 and 1024"]),
        ("--samples 1025", &["--samples", "1025", "between 1 and 1024"]),
        ("--samples -1", &["--samples", "-1", "from 1 to 1024"]),
        ("--samples 1.5", &["--samples", "1.5", "from 1 to 1024"]),
        ("--exposure 51", &["--exposure", "51", "between -50 and 50"]),
        ("--exposure nan", &["--exposure", "NaN", "between -50 and 50"]),
        ("--exposure bright", &["--exposure", "bright", "auto"]),
        ("--size 0x4", &["--size", "0x4", "each from 1 to 8388608"]),
        ("--size 4x0", &["--size", "4x0", "each from 1 to 8388608"]),
        ("--size=-4x4", &["--size", "-4x4", "each from 1 to 8388608"]),
        ("--size 8", &["--size", "\"8\"", "WIDTHxHEIGHT"]),
        ("--size 4x4x4", &["--size", "4x4x4", "WIDTHxHEIGHT"]),
        ("--size wide", &["--size", "wide", "WIDTHxHEIGHT"]),
        ("--size 4.5x4", &["--size", "4.5x4", "WIDTHxHEIGHT"]),
        ("--size 4000000000x4000000000", &["--size", "4000000000x4000000000", "each from 1 to 8388608"]),
        ("--size 99999999999999999999x1", &["--size", "99999999999999999999x1", "each from 1 to 8388608"]),
        ("--size 8388608x8388608", &["--size", "8388608x8388608", "GiB are free"]),
        ("--preset moon", &["--preset", "moon", "earth", "paper"]),
        (
            "--projection cubemap",
            &["--projection", "cubemap", "perspective --fov 90", "--look-azimuth 0", "equirectangular"],
        ),
        ("--projection Cube", &["--projection", "Cube", "perspective --fov 90"]),
        ("--size 3k", &["--size", "3k", "2k (2048x1024)", "8k (8192x4096)"]),
        ("--projection mercator", &["--projection", "mercator", "equirectangular", "fisheye", "perspective"]),
        ("--fit linear", &["--fit", "linear", "cubic", "transfer", "regression", "dense"]),
        ("--fit dense --color solve", &["--fit dense", "--color solve"]),
        ("--bands 450,500", &["--bands", "2", "3 to 8"]),
        ("--fit cubic --color solve --bands 450,500,600,650,700", &["--bands", "5", "4 to 4"]),
        ("--bands 450,500,500.1,600", &["--bands", "500", "500.1", "0.5 nm apart"]),
        ("--bands 300,450,500,600", &["--bands", "300", "between 360 and 830 nm"]),
        ("--bands blue", &["--bands", "blue", "a list"]),
        ("--color fast", &["--color", "fast", "solve", "folded"]),
        ("--rgb adobe", &["--rgb", "adobe", "srgb", "rec2020", "acescg", "xyz"]),
        ("--observer cie1964", &["--observer", "cie1964", "cie1931", "cie2015"]),
        ("--white-balance shade", &["--white-balance", "shade", "none", "d65", "sun"]),
        ("--device abacus", &["--device", "abacus", "auto", "cpu"]),
        ("--device=", &["--device", "auto", "cpu", "gpu"]),
        ("--scene missing.toml", &["scene file missing.toml", "No such file"]),
        ("--scene folder.png", &["scene file folder.png", "directory"]),
        ("-o sky.jpg", &["-o", "sky.jpg", ".png, .exr, .hdr, .hsr, .rad or .usda"]),
        ("-o sky", &["-o", "sky", ".png, .exr, .hdr, .hsr, .rad or .usda"]),
        ("-o a.png -o nowhere/b.png", &["-o", "nowhere/b.png", "folder does not exist"]),
        ("-o a.png/b.png", &["-o", "a.png/b.png", "cannot be written"]),
        ("-o folder.png", &["-o", "folder.png", "is a folder"]),
        ("-o a.png -o new.png/", &["-o", "new.png/", "does not end as that of a folder"]),
        ("-o a.png -o new.png/.", &["-o", "new.png/.", "does not end as that of a folder"]),
        ("-o a.png -o sky.png/", &["-o", "sky.png/", "cannot be written"]),
        ("-o a.png -o b.exr -o a.png", &["-o", "a.png", "twice"]),
        ("-o a.png -o ./folder.png/../a.png", &["-o", "a.png", "twice"]),
        ("--sky blue", &["--sky"]),
    ];
    for (flags, named) in table {
        let flags: Vec<&str> = flags.split(' ').collect();
        let device: &[&str] = if flags[0].starts_with("--device") { &[] } else { &["--device", "cpu"] };
        refuses(None, &[&["render"], device, &flags].concat(), named);
        if OF_A_SPECTRUM.contains(&flags[0]) && !flags.contains(&"--color") {
            refuses(None, &[&SPECTRUM, &flags[..]].concat(), named);
        }
    }
    let long = format!("{}.png", "x".repeat(300));
    refuses(None, &["render", "--device", "cpu", "-o", "a.png", "-o", &long], &["-o xxx", "too long"]);
}

#[test]
fn a_wrong_spectrum_exits_with_2_and_one_sentence() {
    let view: &[(&[&str], &[&str])] = &[
        (&["--view-elevation", "91", "--view-azimuth", "0"], &["--view-elevation", "91", "between -90 and 90"]),
        (&["--view-elevation", "nan", "--view-azimuth", "0"], &["--view-elevation", "NaN", "between -90 and 90"]),
        (&["--view-elevation", "0", "--view-azimuth=-inf"], &["--view-azimuth is -inf", "a finite number of degrees"]),
        (&["--view-elevation", "0", "--view-azimuth", "north"], &["--view-azimuth", "north", "a number"]),
        (&["--view-elevation", "0"], &["--view-azimuth", "required"]),
    ];
    for (flags, named) in view {
        refuses(None, &[&["spectrum"], *flags].concat(), named);
    }
    for list in
        ["", ",", "blue", "450,", "450:550", "500:400:5", "400:500:0", "400:500:-5", "360:830:1e-9", "400:nan:5"]
    {
        refuses(None, &[&SPECTRUM[..], &["--wavelengths", list]].concat(), &["--wavelengths", list, "START:END:STEP"]);
    }
    for (list, outside) in [("450,279.9", "279.9"), ("380:2600:5", "2505"), ("-450", "-450")] {
        let list = format!("--wavelengths={list}");
        refuses(None, &[&SPECTRUM[..], &[&list]].concat(), &["--wavelengths", outside, "between 280 and 2500 nm"]);
    }
    // Air in closed form has no gases, and snow and the sea have no albedo beyond visible light.
    let closed = [&SPECTRUM[..], &["--profile=exponential", "--wavelengths=450,359.9"]].concat();
    refuses(None, &closed, &["--wavelengths", "359.9", "between 360 and 830 nm"]);
    let snow = [&SPECTRUM[..], &["--albedo=snow", "--wavelengths=450,900"]].concat();
    refuses(None, &snow, &["--wavelengths", "900", "between 280 and 830 nm"]);
    let closed = [&SPECTRUM[..], &["--profile=exponential", "--resolution=5"]].concat();
    refuses(None, &closed, &["--resolution", "lines of gases", "a measured atmosphere.profile"]);
    refuses(None, &[&SPECTRUM[..], &["--format", "xml"]].concat(), &["--format", "xml", "csv", "json"]);
}

#[test]
fn a_wrong_spectral_file_exits_with_2_and_one_sentence() {
    let table: &[(&str, &[&str])] = &[
        ("--spectral -o a.png", &["--spectral", ".spectral.exr"]),
        ("--wavelengths 550 -o a.exr", &["--wavelengths", ".spectral.exr"]),
        ("--wavelengths 550", &["--wavelengths", "--spectral"]),
        ("--spectral --wavelengths 300,550", &["--wavelengths", "300", "between 360 and 830 nm"]),
        ("--spectral --wavelengths 550,450,550", &["--wavelengths", "550", "apart"]),
        ("--spectral --wavelengths 360:830:0.5", &["--wavelengths", "941", "1 to 512"]),
        ("--spectral --wavelengths blue", &["--wavelengths", "blue", "START:END:STEP"]),
        ("--color solve -o a.spectral.exr", &["--color solve", "--color folded"]),
        ("-o nowhere/a.spectral.exr", &["nowhere/a.spectral.exr", "folder does not exist"]),
    ];
    for (flags, named) in table {
        let flags: Vec<&str> = flags.split(' ').collect();
        refuses(None, &[&["render", "--device", "cpu"][..], &flags].concat(), named);
    }
}

#[test]
fn a_spectral_file_is_written_beside_any_other() {
    let folder = folder();
    let outputs = ["-o", "a.spectral.exr", "-o", "b.exr", "-o", "c.png", "--wavelengths", "450,550.5,650"];
    for (device, exr) in [("cpu", "f32"), ("gpu", "f32"), ("cpu", "f16")] {
        for scene in [&["--sun-elevation", "10"][..], &["--projection", "fisheye"], &["--sun-elevation", "-30"]] {
            let flags = ["render", "--size", "40x20", "--device", device, "--exr", exr];
            succeed(folder.path(), &[&flags[..], scene, &outputs].concat());
            assert_eq!(names(folder.path()), ["a.spectral.exr", "b.exr", "c.png"]);
        }
    }
    succeed(folder.path(), &["render", "--size", "40x20", "--device", "cpu", "--spectral"]);
    let (spectral, plain) = (folder.path().join("sky.exr"), folder.path().join("b.exr"));
    let channels = |path: &Path| {
        let file = exr::prelude::read_first_flat_layer_from_file(path).unwrap();
        file.layer_data.channel_data.list.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>()
    };
    assert_eq!(channels(&spectral).len(), 3 + 41);
    assert!(channels(&spectral).contains(&"S0.390,000000nm".to_owned()));
    assert_eq!(channels(&plain), ["B", "G", "R"]);
}

#[test]
fn a_wrong_scene_exits_with_2_and_one_sentence() {
    let out_of_range = [
        ("sun.elevation", "100", "between -90 and 90"),
        ("sun.elevation", "nan", "between -90 and 90"),
        ("sun.azimuth", "-inf", "a finite number of degrees"),
        ("observer.altitude", "-0.1", "between 0 and 100000 km"),
        ("atmosphere.ground_radius", "9", "between 10 and 100000 km"),
        ("atmosphere.ground_radius", "inf", "between 10 and 100000 km"),
        ("atmosphere.top_radius", "6360", "between 6361 and 7632 km"),
        ("atmosphere.air.scattering", "-0.001", "between 0 and 100"),
        ("atmosphere.air.scale_height", "0", "between 0.05 and 63.6 km"),
        ("atmosphere.air.scale_height", "64", "between 0.05 and 63.6 km"),
        ("atmosphere.aerosol.optical_depth", "-1", "between 0 and 1000"),
        ("atmosphere.aerosol.angstrom_exponent", "6", "between -5 and 5"),
        ("atmosphere.aerosol.scale_height", "nan", "between 0.05 and 63.6 km"),
        ("atmosphere.aerosol.single_scattering_albedo", "1.01", "between 0 and 1"),
        ("atmosphere.aerosol.asymmetry", "1", "between -0.9 and 0.99"),
        ("atmosphere.ozone.column", "-1", "between 0 and 2000 Dobson units"),
        ("atmosphere.ozone.bottom", "-1", "between 0 and 100 km"),
        ("atmosphere.ozone.peak", "10", "between 10.1 and 100 km"),
        ("atmosphere.ozone.top", "101", "between 25.1 and 100 km"),
        ("camera.fov", "0", "between 0.01 and 360"),
        ("camera.look_azimuth", "inf", "a finite number of degrees"),
        ("camera.look_elevation", "91", "between -90 and 90"),
        ("render.steps", "0", "between 1 and 1024"),
        ("render.exposure", "-51", "between -50 and 50"),
    ];
    for (key, value, allowed) in out_of_range {
        let shown = if value == "nan" { "NaN" } else { value };
        refuses(Some(&format!("{key} = {value}\n")), &["render", "--device", "cpu"], &[key, shown, allowed]);
    }
    let table: [(&str, &[&str]); 18] = [
        ("[sun]\nelevation = 3\nelevatoin = 4", &["scene.toml, line 3", "column 1", "elevatoin", "`elevation`"]),
        ("[moon]\nelevation = 3", &["line 1", "moon", "`sun`"]),
        ("\n\n[sun]\nelevation = \"high\"", &["line 4", "elevation", "high", "a number"]),
        ("[sun]\nspectrum = \"red\"", &["line 2", "spectrum", "red", "astm-g173", "flat"]),
        ("sun = 3", &["line 1", "sun = 3", "a table"]),
        ("preset = \"moon\"", &["line 1", "preset", "moon", "earth", "paper"]),
        ("camera.size = \"0x3\"", &["line 1", "camera.size", "0x3", "each from 1 to 8388608"]),
        ("camera.size = 5", &["line 1", "camera.size", "5", "string"]),
        ("camera.projection = \"cube\"", &["line 1", "camera.projection", "cube", "fisheye"]),
        ("render.steps = -1", &["line 1", "render.steps", "-1", "a whole number"]),
        ("render.steps = 2.5", &["line 1", "render.steps", "2.5", "a whole number"]),
        ("render.exposure = true", &["line 1", "render.exposure", "true", "stops, \"auto\" or \"adapt\""]),
        ("render.exposure = \"bright\"", &["line 1", "render.exposure", "bright", "\"auto\", \"adapt\" or"]),
        ("render.rgb = \"adobe\"", &["line 1", "render.rgb", "adobe", "acescg"]),
        ("render.white_balance = 5", &["line 1", "render.white_balance", "5"]),
        ("sun.elevation = 3\nsun.elevation = 4", &["line 2", "sun.elevation = 4", "duplicate"]),
        (
            "atmosphere.air.scattering = 1\natmosphere.top_radius = 6370",
            &["atmosphere.top_radius", "6370", "optical depth of", "at most 20"],
        ),
        ("[sun", &["line 1", "[sun", "`]`"]),
    ];
    for (scene, named) in table {
        refuses(Some(scene), &["render", "--device", "cpu"], named);
        refuses(Some(scene), &SPECTRUM, named);
    }
}

#[test]
fn whole_turns_of_the_sun_and_of_what_looks_at_it_are_nothing() {
    let folder = folder();
    let path = folder.path();
    std::fs::write(path.join("scene.toml"), "sun.azimuth = 760\ncamera.look_azimuth = -685\n").unwrap();
    std::fs::write(path.join("cases.csv"), "sun.azimuth,camera.look_azimuth\n40,-325\n3640,-1045\n").unwrap();
    let camera = "--device cpu --size 16x8 --projection perspective";
    for words in [
        format!("render {camera} --sun-azimuth 40 --look-azimuth -325 -o once.png"),
        format!("render {camera} --sun-azimuth 400 --look-azimuth -3925 -o flags.png"),
        format!("render {camera} --scene scene.toml -o file.png"),
        format!("sequence {camera} --table cases.csv -o #.png"),
    ] {
        succeed(path, &words.split(' ').collect::<Vec<_>>());
    }
    let files = contents(path);
    for same in ["flags.png", "file.png", "0.png", "1.png"] {
        assert!(files[same] == files["once.png"], "{same}");
    }
    let spectrum = |sun: &str, view: &str| {
        let line =
            format!("spectrum --sun-azimuth {sun} --view-elevation 20 --view-azimuth {view} --wavelengths 450,550");
        succeed(path, &line.split(' ').collect::<Vec<_>>()).stdout
    };
    assert_eq!(spectrum("400", "3630"), spectrum("40", "30"));
}

/// Runs the program where no file may grow beyond some KiB, which ends a write as a full disk does.
#[cfg(unix)]
fn run_with_small_files(folder: &Path, arguments: &[&str]) -> Ended {
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", "ulimit -f 16; exec \"$@\"", "sh"]).arg(sorairo_tests::program::binary());
    shell.args(arguments).current_dir(folder).output().expect("the shell starts").into()
}

/// Runs the program in an address space of so many megabytes.
#[cfg(target_os = "linux")]
fn run_in_memory(folder: &Path, megabytes: u32, line: &str) -> Ended {
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &format!("ulimit -v {}; exec \"$@\"", megabytes * 1024), "sh"]);
    shell.arg(sorairo_tests::program::binary()).args(line.split(' ')).current_dir(folder);
    // Each thread takes address space for its stack and for what it allocates.
    shell.env("RAYON_NUM_THREADS", "2");
    shell.output().expect("the shell starts").into()
}

#[cfg(target_os = "linux")]
#[test]
fn where_memory_is_limited_no_driver_crashes_and_what_does_not_fit_is_a_failure() {
    let folder = folder();
    let small = "render --size 32x16 -o small.exr --json";
    // Mesa's driver alone takes about as much.
    let limited = run_in_memory(folder.path(), 1000, small);
    let report: Value = serde_json::from_str(&limited.stdout).unwrap_or_else(|_| panic!("{limited:?}"));
    assert_eq!((limited.code, &report["backend"]), (Some(0), &"cpu".into()), "{limited:?}");
    assert!(limited.stderr.contains("limited to 1000 MB"), "{}", limited.stderr);
    let refused = run_in_memory(folder.path(), 1000, &format!("{small} --device gpu"));
    assert!(refused.code == Some(1) && refused.stderr.contains("--device cpu needs none"), "{refused:?}");
    // 401 planes of radiance in half of what they take.
    let before = contents(folder.path());
    for megabytes in [100, 200, 400] {
        let large = "render --device cpu --size 1024x512 --wavelengths 380:780:1 -o large.spectral.exr";
        let failed = run_in_memory(folder.path(), megabytes, large);
        assert_eq!(failed.code, Some(1), "{megabytes} MB: {failed:?}");
        assert!(failed.stderr.contains("memory") || failed.stderr.contains("thread"), "{megabytes} MB: {failed:?}");
    }
    // What they left is removed by the next run.
    succeed(folder.path(), &["render", "--device", "cpu", "--size", "32x16", "-o", "next.exr"]);
    let mut after = contents(folder.path());
    assert!(after.remove("next.exr").is_some() && after == before, "{:?}", after.keys());
}

#[cfg(unix)]
#[test]
fn an_existing_file_survives_a_failure() {
    let folder = folder();
    for name in ["small.png", "large.exr", "large.png"] {
        std::fs::write(folder.path().join(name), "was here before").unwrap();
    }
    let first = contents(folder.path());
    // So little exposed, the picture is black and small; the floats are not.
    let small_then_large =
        ["render", "--device", "cpu", "--size", "100x60", "--exposure", "-30", "-o", "small.png", "-o", "large.exr"];
    let large_picture = ["render", "--device", "cpu", "--size", "400x200", "-o", "large.png"];
    for (arguments, name) in [(&small_then_large[..], "large.exr"), (&large_picture, "large.png")] {
        let before = contents(folder.path());
        let ended = run_with_small_files(folder.path(), arguments);
        assert_eq!(ended.code, Some(1), "{}", ended.stderr);
        assert!(ended.stderr.starts_with(&format!("sorairo: -o {name} cannot be written")), "{}", ended.stderr);
        assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
        assert!(contents(folder.path()) == before, "{:?}", names(folder.path()));
        // The same request with room replaces the files.
        succeed(folder.path(), arguments);
    }
    let after = contents(folder.path());
    assert!(after.iter().all(|(name, bytes)| *bytes != first[name]), "a file was not replaced");
    assert!(after["small.png"].len() < 8 * 1024, "the small file must fit under the limit");
}

#[cfg(unix)]
#[test]
fn no_partial_file_is_left() {
    let folder = folder();
    let ended = run_with_small_files(folder.path(), &["render", "--device", "cpu", "--size", "400x200"]);
    assert_eq!(ended.code, Some(1), "{}", ended.stderr);
    assert_eq!(names(folder.path()), [""; 0]);
}

#[cfg(unix)]
#[test]
fn a_link_is_followed_and_a_file_keeps_its_mode() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = folder();
    let path = folder.path();
    std::fs::create_dir(path.join("disk")).unwrap();
    let mode = |name: &str| path.join(name).metadata().unwrap().permissions().mode() & 0o7777;
    for name in ["disk/old.png", "secret.exr"] {
        std::fs::write(path.join(name), "was here before").unwrap();
        std::fs::set_permissions(path.join(name), std::fs::Permissions::from_mode(0o640)).unwrap();
    }
    // A link to a link, and one to nothing yet.
    symlink("old.png", path.join("disk/link.png")).unwrap();
    symlink("disk/link.png", path.join("a.png")).unwrap();
    symlink("disk/new.png", path.join("b.png")).unwrap();
    let render = ["render", "--device", "cpu", "--size", "4x2"];
    succeed(path, &[&render[..], &["-o", "a.png", "-o", "b.png", "-o", "secret.exr"]].concat());
    assert_eq!(names(path), ["a.png", "b.png", "disk", "secret.exr"]);
    assert_eq!(names(&path.join("disk")), ["link.png", "new.png", "old.png"]);
    for link in ["a.png", "b.png", "disk/link.png"] {
        assert!(path.join(link).symlink_metadata().unwrap().is_symlink(), "{link}");
    }
    assert_eq!((mode("disk/old.png"), mode("secret.exr"), mode("disk/new.png") & 0o600), (0o640, 0o640, 0o600));
    read_png(&path.join("disk/old.png"));
    // Two names of one file, a link that leads to itself, and a pipe.
    symlink("round.png", path.join("round.png")).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(path.join("pipe.png")).status().unwrap().success());
    for (outputs, words) in [
        (["a.png", "disk/old.png"], "disk/old.png is given twice"),
        (["b.png", "round.png"], "round.png cannot be written"),
        (["b.png", "pipe.png"], "pipe.png cannot be written: it is no ordinary file"),
    ] {
        let ended = run(path, &[&render[..], &["-o", outputs[0], "-o", outputs[1]]].concat());
        assert!(ended.code == Some(2) && ended.stderr.contains(words), "{}", ended.stderr);
    }
}

#[cfg(unix)]
#[test]
fn a_folder_that_takes_no_files_is_refused_before_any_work() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let closed = folder.path().join("closed");
    std::fs::create_dir(&closed).unwrap();
    std::fs::set_permissions(&closed, std::fs::Permissions::from_mode(0o555)).unwrap();
    let ended = run(folder.path(), &["render", "--device", "cpu", "--size", "4x2", "-o", "closed/sky.png"]);
    if std::fs::write(closed.join("probe"), "").is_ok() {
        // Permissions do not bind the superuser: for such a user the folder is open, and the file must be there.
        assert_eq!((ended.code, names(&closed)), (Some(0), vec!["probe".into(), "sky.png".into()]), "{}", ended.stderr);
    } else {
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains("-o closed/sky.png") && ended.stderr.contains("denied"), "{}", ended.stderr);
        assert_eq!(names(&closed), [""; 0]);
    }
    if cfg!(target_os = "linux") {
        // A folder that takes no files from anyone.
        let ended = run(folder.path(), &["render", "--device", "cpu", "--size", "4x2", "-o", "/proc/sky.png"]);
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains("-o /proc/sky.png cannot be written"), "{}", ended.stderr);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_a_failure_and_a_full_standard_error_is_not() {
    let folder = folder();
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let arguments = ["render", "--device", "cpu", "--size", "4x2", "--json"];
    let ended: Ended = command(folder.path(), &arguments).stdout(full()).output().unwrap().into();
    assert_eq!(ended.code, Some(1), "{}", ended.stderr);
    assert!(ended.stderr.contains("standard output cannot be written"), "{}", ended.stderr);
    let ended: Ended = command(folder.path(), &arguments).stderr(full()).output().unwrap().into();
    assert_eq!(ended.code, Some(0));
    assert_eq!(json(&ended)["width"], 4);
    let refused = command(folder.path(), &["render", "--samples", "0"]).stderr(full()).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_name_may_hold_any_bytes() {
    use std::os::unix::ffi::OsStrExt;
    let folder = folder();
    let name = std::ffi::OsStr::from_bytes(b"sky \xff.png");
    let mut command = command(folder.path(), &["render", "--device", "cpu", "--size", "4x2", "--json", "-o"]);
    let ended: Ended = command.arg(name).output().unwrap().into();
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert_eq!(json(&ended)["outputs"][0], "sky \u{fffd}.png");
    assert!(folder.path().join(name).is_file());
}

#[test]
fn a_closed_pipe_is_no_error() {
    let folder = folder();
    // Some 200 KB: more than a pipe holds.
    let mut spectrum = command(folder.path(), &[&SPECTRUM[..], &["--wavelengths", "380:780:0.1"]].concat());
    let mut child = spectrum.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::with_capacity(16, child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert_eq!(line, "wavelength_nm,radiance,dense\n");
    let ended: Ended = child.wait_with_output().unwrap().into();
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
}

#[test]
fn a_spectrum_is_the_same_in_csv_and_json() {
    let folder = folder();
    let of = |flags: &[&str]| succeed(folder.path(), &[&SPECTRUM[..], flags].concat());
    let csv = of(&[]).stdout;
    assert_eq!(csv, of(&["--format", "csv", "--wavelengths", "380:780:5"]).stdout);
    let (header, rows) = csv.split_once('\n').unwrap();
    assert_eq!(header, "wavelength_nm,radiance,dense");
    let rows: Vec<Vec<f64>> =
        rows.lines().map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let samples = json(&of(&["--format", "json"]));
    let samples = samples.as_array().unwrap();
    assert_eq!((rows.len(), samples.len()), (81, 81));
    for (i, (row, sample)) in rows.iter().zip(samples).enumerate() {
        let expected = ["wavelength_nm", "radiance", "dense"].map(|key| sample[key].as_f64().unwrap());
        // The reader of JSON may round the last digit the other way.
        assert!(row.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-15 * b.abs()), "{row:?} {expected:?}");
        assert_eq!(row[0], 380.0 + 5.0 * i as f64);
    }
}

#[test]
fn many_directions_are_each_as_one_by_itself() {
    let folder = folder();
    let of = |flags: &str| {
        let line = format!("spectrum --sun-elevation 12 {flags}");
        succeed(folder.path(), &line.split(' ').collect::<Vec<_>>()).stdout
    };
    std::fs::write(folder.path().join("scan.csv"), "elevation,azimuth\n20,30\n# up\n90,0\n-1.5,200\n").unwrap();
    let directions = [("20", "30"), ("90", "0"), ("-1.5", "200")];
    for what in ["--wavelengths 450,600", "--luminance"] {
        let many = of(&format!("--directions scan.csv {what}"));
        let many_json: Value =
            serde_json::from_str(&of(&format!("--directions scan.csv {what} --format json"))).unwrap();
        let mut expected = String::new();
        for (i, (elevation, azimuth)) in directions.iter().enumerate() {
            let view = format!("--view-elevation {elevation} --view-azimuth {azimuth} {what}");
            let one = of(&view);
            let mut rows = one.lines();
            let header = rows.next().unwrap();
            if i == 0 {
                expected += &format!("view_elevation,view_azimuth,{header}\n");
            }
            rows.for_each(|row| expected += &format!("{elevation},{azimuth},{row}\n"));
            let mut one_json: Value = serde_json::from_str(&of(&format!("{view} --format json"))).unwrap();
            if one_json.is_array() {
                one_json = serde_json::json!({ "spectrum": one_json });
            }
            one_json["view_elevation"] = elevation.parse::<f64>().unwrap().into();
            one_json["view_azimuth"] = azimuth.parse::<f64>().unwrap().into();
            assert_eq!(many_json[i], one_json);
        }
        assert_eq!(many, expected, "{what}");
    }
    // Columns go by their names, whichever program wrote them.
    let radiances = |table: &str| {
        std::fs::write(folder.path().join("named.csv"), table).unwrap();
        of("--directions named.csv --wavelengths 550")
    };
    let expected = radiances("elevation,azimuth\n20,90\n");
    for table in [
        "azimuth,elevation\n90,20\n",
        "zenith,azimuth\n70,90\n",
        "\u{feff}\"elevation_rad\",\"azimuth_rad\"\r\n\"0.3490658503988659\",\"1.5707963267948966\"\r\n",
    ] {
        assert_eq!(radiances(table), expected, "{table:?}");
    }
    std::fs::write(folder.path().join("bad.csv"), "20,30\n200,30\n").unwrap();
    std::fs::write(folder.path().join("semicolons.csv"), "20;30\n").unwrap();
    std::fs::write(folder.path().join("unknown.csv"), "azimuth,altitude\n20,30\n").unwrap();
    for (flags, words) in [
        ("--directions bad.csv", "--directions bad.csv, line 2: view_elevation is 200"),
        ("--directions semicolons.csv", "--directions semicolons.csv, line 1: semicolons part the cells"),
        ("--directions unknown.csv", "line 1, column 2: \"altitude\" is no column of directions"),
        #[cfg(unix)]
        ("--directions /dev/zero", "--directions /dev/zero is larger than 32768 KiB"),
        ("--directions none.csv", "--directions none.csv cannot be read: No such file"),
        ("--directions scan.csv --view-elevation 3", "cannot be used with"),
        ("--view-elevation 3", "--view-azimuth"),
        ("--directions scan.csv --luminance --wavelengths 550", "cannot be used with"),
    ] {
        let ended = run(folder.path(), &["spectrum", flags].join(" ").split(' ').collect::<Vec<_>>());
        assert!(ended.code == Some(2) && ended.stderr.contains(words), "{flags}: {}", ended.stderr);
    }
}

#[test]
fn the_zenith_is_bluer_than_the_horizon_and_as_bright_as_the_json_of_an_image_says() {
    let folder = folder();
    std::fs::write(folder.path().join("two.csv"), "90,0\n2,180\n").unwrap();
    let csv = succeed(folder.path(), &["spectrum", "--directions", "two.csv", "--luminance"]).stdout;
    assert_eq!(csv.lines().next(), Some("view_elevation,view_azimuth,luminance_cd_m2,x,y,cct_k"));
    let row = |row: &str| row.split(',').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>();
    let rows: Vec<Vec<f64>> = csv.lines().skip(1).map(row).collect();
    // Clear skies lie at 10 000 K and more overhead (Hernández-Andrés et al. 2001, who measured up to 30 000 K).
    assert!((10_000.0..60_000.0).contains(&rows[0][5]) && rows[1][5] < rows[0][5], "{rows:?}");
    assert!(rows[0][3] < rows[1][3] && rows[0][4] < rows[1][4], "{rows:?}");
    let report =
        json(&succeed(folder.path(), &["render", "--device", "cpu", "--size", "8x4", "-o", "a.exr", "--json"]));
    let zenith = report["luminance_zenith_cd_m2"].as_f64().unwrap();
    // One by the colour rows in single precision, the other by the fit's spectrum.
    assert!((rows[0][2] / zenith - 1.0).abs() < 5e-3, "{} {zenith}", rows[0][2]);
}

#[cfg(target_os = "linux")]
#[test]
fn where_no_thread_can_be_started_that_is_said() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    let folder = folder();
    std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(0o777)).unwrap();
    // The limit does not bind the superuser, who becomes nobody; and nobody may have no way to the program's own
    // folder.
    let program = folder.path().join("sorairo");
    std::fs::copy(sorairo_tests::program::binary(), &program).unwrap();
    let is_superuser = std::fs::metadata("/proc/self").unwrap().uid() == 0;
    let nobody: &[&str] =
        if is_superuser { &["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"] } else { &["env"] };
    for line in [
        "render --quiet --device cpu --size 8x4 -o a.png",
        "sequence --quiet --device cpu --size 8x4 --sun-elevation 0:1:1 -o #.png",
    ] {
        // From no thread at all to all that the program starts for itself.
        for processes in 1..=12 {
            let mut limited = std::process::Command::new(nobody[0]);
            limited.args(&nobody[1..]).args(["prlimit", &format!("--nproc={processes}")]).arg(&program);
            let ended: Ended = limited.args(line.split(' ')).current_dir(folder.path()).output().unwrap().into();
            if ended.code != Some(0) {
                assert_eq!(ended.code, Some(1), "{line}, {processes} processes: {}", ended.stderr);
                assert!(ended.stderr.contains("no thread can be started: "), "{}", ended.stderr);
                assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
                assert_eq!(names(folder.path()), ["sorairo"], "{line}, {processes} processes");
            }
            assert!(processes > 1 || ended.code == Some(1), "{line} needs no thread");
            names(folder.path()).iter().filter(|name| *name != "sorairo").for_each(|name| {
                std::fs::remove_file(folder.path().join(name)).unwrap();
            });
        }
    }
}

#[test]
fn wavelengths_are_a_range_or_a_list_in_any_order() {
    let folder = folder();
    let of = |list: &str| -> Vec<Vec<f64>> {
        let csv = succeed(folder.path(), &[&SPECTRUM[..], &["--wavelengths", list]].concat()).stdout;
        csv.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
    };
    let list = of("650,450,550.5,360,830");
    assert_eq!(list.iter().map(|row| row[0]).collect::<Vec<_>>(), [650.0, 450.0, 550.5, 360.0, 830.0]);
    let range = of("450:650:200");
    assert_eq!(range.len(), 2);
    assert_eq!(of("450:450:1").len(), 1);
    for (a, b) in range.iter().zip([&list[1], &list[0]]) {
        // A fit learns at the wavelengths that are asked for; those that are computed together share their samples,
        // within what the dense spectrum promises.
        let bounds = [0.0, 1e-3, 1e-4];
        assert!(a.iter().zip(b).zip(bounds).all(|((a, b), bound)| (a - b).abs() <= bound * b), "{a:?} {b:?}");
    }
}

/// So many samples that their work takes many minutes.
const ENDLESS: [&str; 11] =
    ["render", "--device", "cpu", "--path", "direct", "--steps", "1024", "--size", "16384x8192", "-o", "a.png"];

#[test]
fn after_a_second_the_work_has_a_name() {
    let folder = folder();
    let mut child = command(folder.path(), &ENDLESS).stderr(Stdio::piped()).spawn().unwrap();
    // On a busy machine the plan may take longer than a second, and have its own line before.
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let named = lines.find(|line| line == "sorairo: computing the sky ...");
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(named.is_some(), "no line before the end");
}

#[test]
fn quiet_commands_say_nothing_but_what_was_asked_for_and_what_is_wrong() {
    let folder = folder();
    let said = |line: &str| {
        let ended = succeed(folder.path(), &line.split(' ').collect::<Vec<_>>());
        (ended.stdout, ended.stderr)
    };
    let nothing = (String::new(), String::new());
    assert_eq!(said("render --device cpu --size 8x4 -o a.png --quiet"), nothing);
    assert_eq!(said("--quiet scene new a.toml"), nothing);
    assert_eq!(said("--quiet sequence --device cpu --size 8x4 --sun-elevation 0:1:1 -o #.png"), nothing);
    let (stdout, stderr) = said("render --quiet --device cpu --size 8x4 -o a.png --json");
    assert!(stdout.starts_with('{') && stderr.is_empty(), "{stderr}");
    let wrong = run(folder.path(), &["render", "--quiet", "--samples", "0"]);
    assert!(wrong.code == Some(2) && wrong.stderr.contains("--samples"), "{}", wrong.stderr);
}

#[test]
fn aerosol_is_said_as_people_know_it() {
    let folder = folder();
    let depth = |line: &str| {
        let shown = succeed(folder.path(), &format!("scene show {line}").split(' ').collect::<Vec<_>>()).stdout;
        let row = shown.lines().find_map(|row| row.strip_prefix("optical_depth = ")).expect("an optical depth");
        row.parse::<f64>().unwrap()
    };
    // By the spectrum of clean country, whose exponent is 1.3 to 1.5; with a flag for it 0.2 · 0.5^1.3, in whichever
    // order.
    let by_kind = depth("--aerosol 0.2@500");
    assert!(by_kind > 0.2 * 0.5f64.powf(1.5) && by_kind < 0.2 * 0.5f64.powf(1.3), "{by_kind}");
    assert!((depth("--angstrom 1.3 --aerosol 0.2@500") - 0.081_225).abs() < 1e-6);
    assert!((depth("--aerosol 0.2@500 --angstrom 2") - 0.05).abs() < 1e-12);
    assert!((depth("--angstrom 0 --aerosol 0.2@550") - 0.2).abs() < 1e-12);
    std::fs::write(folder.path().join("a.toml"), "[atmosphere.aerosol]\nangstrom_exponent = 1\n").unwrap();
    assert!((depth("a.toml --aerosol 0.2@500") - 0.1).abs() < 1e-12);
    // 3.912/23 km less the air's 0.0971/8 km⁻¹, through 2 km, at 1 µm.
    let plain = depth("--angstrom 1.3 --visibility 23");
    assert!((plain - 2.0 * (3.912 / 23.0 - 0.0971 / 8.0) * 0.55_f64.powf(1.3)).abs() < 1e-4);
    assert!(depth("--visibility 5") > depth("--visibility 23") && depth("--visibility 300") > 0.0);
    refuses(None, &["render", "--visibility", "1000"], &["--visibility is 1000", "air alone allows"]);
    refuses(None, &["render", "--visibility", "0"], &["--visibility is 0", "more than 0"]);
    refuses(None, &["render", "--visibility", "5", "--aerosol", "0.1@550"], &["--visibility", "cannot be used with"]);
    for wrong in ["0.2", "0.2@", "-1@500", "0.2@50", "nan@500", "a@b"] {
        refuses(None, &["render", &format!("--aerosol={wrong}")], &["--aerosol", "such as 0.2@500"]);
    }
    refuses(None, &["render", "--aerosol", "1e9@500"], &["--aerosol", "between 0 and 1000"]);
}

/// Light at two wavelengths in one direction.
const BLUE_AND_RED: [&str; 7] =
    ["spectrum", "--view-elevation", "60", "--view-azimuth", "30", "--wavelengths", "440,675"];

#[test]
fn a_file_of_aeronet_is_an_aerosol_or_is_refused_with_what_is_wrong() {
    let folder = folder();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/aeronet");
    let stem = data.join("160605_160605_Pretoria_CSIR-DPSS");
    let named = |ending: &str| stem.with_extension(ending);
    let said = |path: &Path| format!("--aerosol=aeronet:{}", path.display());
    let asked = |arguments: &[&str]| succeed(folder.path(), arguments).stdout;
    for ending in ["pfn", "siz"] {
        let flag = format!("{}@06:35:30", said(&named(ending)));
        let spectrum = asked(&[&BLUE_AND_RED[..], &[&flag]].concat());
        assert_eq!(spectrum.lines().count(), 3);
        // As a scene file that is shown says it again.
        let shown = asked(&["scene", "show", &flag]);
        assert!(shown.contains("[[atmosphere.aerosol]]") && shown.contains("@2016-06-05T06:35:30\""), "{shown}");
        std::fs::write(folder.path().join("again.toml"), &shown).unwrap();
        assert_eq!(asked(&[&BLUE_AND_RED[..], &["--scene", "again.toml"]].concat()), spectrum);
    }
    let [whole, siz] = ["pfn", "siz"].map(|ending| std::fs::read_to_string(named(ending)).unwrap());
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let one_row = |text: &str| text.lines().take(5).map(|line| format!("{line}\n")).collect::<String>();
    let cut = write("cut.pfn", &whole[..8000]);
    let empty = write("empty.pfn", &whole[..5000]);
    let missing = write("missing.pfn", &whole.replace("27.864170", "-999.000000"));
    let alone = write("alone.pfn", &one_row(&whole));
    let spheres = write("alone.siz", &one_row(&siz));
    let at = |path: &Path, time: &str| format!("{}{time}", said(path));
    for (flag, words) in [
        (said(&named("pfn")), ["sun.time", "choose one by @HH:MM:SS"]),
        (at(&named("pfn"), "@06:35:31"), ["has no row at 06:35:31", "2016-06-05T08:07:34"]),
        (at(&named("pfn"), "@morning"), ["@morning", "@YYYY-MM-DDTHH:MM:SS"]),
        (said(&named("ssa")), ["neither phase functions nor a size distribution", ".pfn"]),
        (said(&data.join("../astm_g173.csv")), ["is no file of AERONET", "Date("]),
        (said(Path::new("nowhere.pfn")), ["nowhere.pfn", "cannot be read"]),
        (at(&cut, "@06:35:30"), ["cut.pfn, line 5", "columns instead of 366"]),
        (at(&empty, "@06:35:30"), ["empty.pfn, it ends", "after the names of its columns"]),
        (at(&missing, "@06:35:30"), ["missing.pfn, line 5, column 5", "1.7100[439nm] is missing"]),
        (said(&alone), ["holds no single-scattering albedo", "single_scattering_albedo"]),
        (said(&spheres), ["holds no refractive index", ".rin"]),
    ] {
        refuses(None, &["render", &flag], &words);
    }
    let kind = at(&named("pfn"), "@06:35:30");
    refuses(
        None,
        &["render", &kind, "--aerosol-kind", "urban"],
        &["atmosphere.aerosol.kind", "reads one from AERONET"],
    );
    let mode = |keys: &str| format!("[[atmosphere.aerosol]]\naeronet = '{}'\n{keys}", alone.display());
    refuses(Some(&mode("kind = 'urban'")), &["render"], &["kind and aeronet", "one of them"]);
    refuses(Some(&mode("refractive_index = 'n.csv'")), &["render"], &["n.csv", "cannot be read"]);
    // What the file lacks, the mode may say.
    std::fs::write(folder.path().join("said.toml"), mode("single_scattering_albedo = 0.9")).unwrap();
    asked(&[&BLUE_AND_RED[..], &["--scene", "said.toml"]].concat());
}

#[test]
fn spheres_of_a_size_distribution_of_ones_own_scatter() {
    let folder = folder();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("sizes.csv", "radius_um,dv_dlnr\n0.05,0\n0.15,0.08\n0.4,0\n");
    write("index.csv", "wavelength_nm,n,k\n400,1.45,0.01\n700,1.45,0.01\n");
    let keys = "[[atmosphere.aerosol]]\nsize_distribution = 'sizes.csv'\nrefractive_index = 'index.csv'\n";
    write("scene.toml", keys);
    let spectrum = [&BLUE_AND_RED[..], &["--scene", "scene.toml"]].concat();
    let of = |keys: &str| {
        write("scene.toml", keys);
        succeed(folder.path(), &spectrum).stdout
    };
    let (found, thicker) = (of(keys), of(&format!("{keys}optical_depth = 0.5\n")));
    assert!(found.lines().count() == 3 && found != thicker, "{found}");
    refuses(Some(keys), &["render"], &["index.csv", "cannot be read"]);
    let refused = |sizes: &str, index: &str, keys: &str, words: &str| {
        write("sizes.csv", sizes);
        write("index.csv", index);
        write("scene.toml", keys);
        let ended = run(folder.path(), &spectrum);
        assert!(ended.code == Some(2) && ended.stderr.contains(words), "{words}: {}", ended.stderr);
    };
    let (sizes, index) = ("0.05,0\n0.15,0.08\n", "400,1.45,0.01\n700,1.45,0.01\n");
    refused(sizes, index, &keys.replace("refractive_index = 'index.csv'\n", ""), "with one of size_distribution");
    refused("0.0001,0\n0.15,1\n", index, keys, "0.001 to 50 µm are allowed");
    refused("0.1,0\n0.15,0\n", index, keys, "there is nothing at any radius");
    refused(sizes, "400,1.45\n700,1.45\n", keys, "2 columns instead of wavelength_nm, n, k");
    refused(sizes, "400,1.45,0\n700,0.1,0\n", keys, "line 2: 0.1 + 0i; n lies between");
}

#[test]
fn what_lies_before_a_point_is_printed_and_no_point_below_the_ground() {
    let folder = folder();
    let line = "between --altitude 1 --view-elevation -3 --view-azimuth 60 --wavelengths 450,650 --distance";
    let of = |distance: &str| {
        let line = format!("{line} {distance}");
        let printed = succeed(folder.path(), &line.split(' ').collect::<Vec<_>>()).stdout;
        let rows: Vec<Vec<f64>> =
            printed.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
        assert!(printed.starts_with("wavelength_nm,transmittance,radiance\n450,") && rows.len() == 2, "{printed}");
        rows
    };
    assert_eq!(of("0"), [[450.0, 1.0, 0.0], [650.0, 1.0, 0.0]]);
    let (near, far) = (of("5"), of("15"));
    assert!(near.iter().zip(&far).all(|(near, far)| near[1] > far[1] && near[2] < far[2]), "{near:?} {far:?}");
    // Blue light is lost and won first.
    assert!(far[0][1] < far[1][1] && far[0][2] > far[1][2], "{far:?}");
    for (distance, words) in [("100", "--distance is 100 km, and the ground is 19.688 km away"), ("-1", "0 km or more")]
    {
        refuses(None, &format!("{line} {distance}").split(' ').collect::<Vec<_>>(), &[words]);
    }
}

#[test]
fn work_of_less_than_a_second_is_silent() {
    let folder = folder();
    let mut silent = 0;
    wait::until("five runs of less than a second", || {
        let began = Instant::now();
        let ended = succeed(folder.path(), &["render", "--device", "cpu", "--size", "64x32"]);
        // Of a run that other work has held up longer, nothing was promised.
        if began.elapsed() < Duration::from_secs(1) {
            assert!(!ended.stderr.contains("..."), "{}", ended.stderr);
            silent += 1;
        }
        silent == 5
    });
}

/// What a table saves is counted, since time depends on what else the machine does: an entry is an integral, as a pixel
/// is without a table.
#[test]
fn a_large_image_takes_few_integrals() {
    let folder = folder();
    let report = json(&succeed(folder.path(), &["render", "--size", "1920x960", "-o", "a.png", "--json"]));
    let side = |key: &str| report["path"]["table"][key].as_u64().unwrap_or_else(|| panic!("{key} in {report}"));
    let entries = (side("above") + side("below")) * side("azimuths");
    // Half of the pixels lie below the horizon, and are of one colour.
    assert!((1..1920 * 480 / 10).contains(&entries), "{report}");
}

#[test]
fn reproduce_writes_the_papers_experiment() {
    let folder = folder();
    succeed(folder.path(), &["reproduce", "--device", "cpu", "--out", "r"]);
    let report = std::fs::read_to_string(folder.path().join("r/report.md")).expect("a report");
    for part in ["Table 1", "Fig. 2", "2.19×", "RMSE ÷ mean", "12 wavelengths ÷ this"] {
        assert!(report.contains(part), "no {part} in the report");
    }
    let json = std::fs::read_to_string(folder.path().join("r/report.json")).expect("the same as JSON");
    let _: Value = serde_json::from_str(&json).expect("JSON");
    assert!(read_png(&folder.path().join("r/figure2.png")).width > 1000);
}

#[test]
fn bench_writes_time_against_error_and_speed() {
    let folder = folder();
    succeed(folder.path(), &["bench", "--quick", "--out", "b"]);
    for name in ["report.md", "bench.csv", "bench.json", "pareto.svg", "pareto.png"] {
        assert!(folder.path().join("b").join(name).metadata().expect(name).len() > 100, "{name} is empty");
    }
    let printed = succeed(folder.path(), &["bench", "--speed", "--json", "--quick", "--out", "s"]);
    let speed: Value = serde_json::from_str(&printed.stdout).expect("JSON");
    let written = std::fs::read_to_string(folder.path().join("s/speed.json")).expect("figures");
    assert_eq!(speed, serde_json::from_str::<Value>(&written).expect("JSON"), "what is printed is what is written");
    let of_a_sun = ["/median_plan_over_kernels", "/mean_frame_ms", "/mean_resident_frame_ms"];
    let of_a_sun = of_a_sun.map(|figure| format!("/moving_sun/2{figure}"));
    let figures = ["/table_over_direct", "/multiples/1/times_fill", "/cpu_over_device/0", "/orders/8/all_over_once"];
    let figures =
        figures.map(String::from).into_iter().chain(of_a_sun).chain(["/rooflines/1/kernels/2/reached".into()]);
    for figure in figures {
        let is_measured = speed.pointer(&figure).and_then(Value::as_f64).is_some_and(|number| number > 0.0);
        assert!(is_measured, "{figure} of {speed}");
    }
}
