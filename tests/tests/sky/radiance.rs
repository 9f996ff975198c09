//! The sky and the sun as Radiance reads them.

use serde_json::{Value, json};
use sorairo::low_level::files::{Format, Spectra, is_finished};
use sorairo::scene::Scene;
use sorairo::{AlphaOpic, Direction, Surface};
use sorairo_tests::program::{binary, contents, names, run, succeed};
use sorairo_tests::python::check;
use sorairo_tests::sky::sky_of;
use tempfile::tempdir;

/// Bands: the middle of the first (nm), how many there are, and how wide (nm).
type Bands = (u32, u32, u32);

/// The mean over each band of the spectrum in some directions, nanometre by nanometre.
fn probes(elevation: f64, azimuth: f64, (first, count, width): Bands) -> Value {
    let mut scene = Scene::default();
    (scene.sun.elevation, scene.sun.azimuth) = (elevation, azimuth);
    let wavelengths: Vec<f64> = (0..=count * width).map(|i| f64::from(first - width / 2 + i)).collect();
    let places = [[75.0, 20.0], [30.0, 200.0], [10.0, 300.0], [45.0, 131.0]];
    let spectra = sky_of(&scene).radiance(&places.map(|[up, towards]| Direction::new(up, towards)), &wavelengths);
    let probe = |([elevation, azimuth], spectrum): ([f64; 2], Vec<f64>)| {
        let steps: Vec<f64> = spectrum.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        let radiance: Vec<f64> =
            steps.chunks(width as usize).map(|band| band.iter().sum::<f64>() / f64::from(width)).collect();
        json!({ "elevation": elevation, "azimuth": azimuth, "radiance": radiance })
    };
    places.into_iter().zip(spectra.unwrap()).map(probe).collect()
}

#[test]
fn a_sensor_in_radiance_gets_the_irradiance_of_the_report_and_sees_the_sky_where_it_is() {
    // The default; a low sun with its own wavelengths and a camera that looks elsewhere in an image of another shape;
    // twilight. A device's pixels are those of the processor, whatever is said of them.
    let (both, one) = (&["cpu", "gpu"][..], &["cpu"][..]);
    for (elevation, azimuth, picture, bands, devices) in [
        (40.0, 110.0, "--size 512x256", (390, 20, 20), both),
        (6.0, 250.0, "--size 300x420 --look-azimuth 200 --wavelengths 400:700:50", (400, 7, 50), one),
        (-3.0, 20.0, "--size 512x256", (390, 20, 20), one),
    ] {
        let probes = probes(elevation, azimuth, bands);
        let picture = format!("--sun-elevation={elevation} --sun-azimuth {azimuth} {picture}");
        for device in devices {
            let folder = tempdir().unwrap();
            let folder = folder.path();
            let image = ["render", "--device", device, "-o", "my sky.hsr", "-o", "my sky.rad", "--json"];
            let report = succeed(folder, &[&image[..], &picture.split(' ').collect::<Vec<_>>()].concat()).stdout;
            std::fs::write(folder.join("report.json"), report).unwrap();
            std::fs::write(folder.join("probes.json"), probes.to_string()).unwrap();
            check(folder, "radiance_sky.py", &["my sky.rad", "report.json", "probes.json"]);
        }
    }
}

#[test]
fn what_radiance_cannot_hold_is_refused_with_2_and_nothing_begun() {
    let pair = "-o a.hsr -o a.rad";
    let cases: [(&str, &[&str]); 10] = [
        ("-o a.hsr --wavelengths 380:630:10", &["--wavelengths holds 26 wavelengths", "4 to 24"]),
        ("-o a.hsr --wavelengths 450,550,650", &["--wavelengths holds 3 wavelengths", "4 to 24"]),
        ("-o a.hsr --wavelengths 350:750:50", &["--wavelengths holds 350", "360 and 830 nm"]),
        ("-o a.hsr --wavelengths 690:840:50", &["--wavelengths holds 840", "360 and 830 nm"]),
        ("-o a.hsr --wavelengths 400,450,500,560", &["--wavelengths is not evenly spaced", "390:770:20"]),
        ("-o a.rad", &["-o a.rad", "-o a.hsr too"]),
        ("-o a.rad -o b.hsr", &["-o a.rad", "-o a.hsr too"]),
        (&format!("{pair} --projection fisheye"), &["--projection (camera.projection)", "equirectangular"]),
        (&format!("{pair} --size 512x1"), &["--size (camera.size) is 512x1", "2x2"]),
        (&format!("{pair} --sun-disc"), &["--sun-disc (sun.disc)", "spectral file"]),
    ];
    for (flags, words) in cases {
        let folder = tempdir().unwrap();
        let line = format!("render --device cpu {flags}");
        let ended = run(folder.path(), &line.split(' ').collect::<Vec<_>>());
        assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""), "{flags}: {}", ended.stderr);
        assert!(
            ended.stderr.starts_with("sorairo: ") && ended.stderr.lines().count() == 1,
            "{flags}: {}",
            ended.stderr
        );
        for word in words {
            assert!(ended.stderr.contains(word), "{flags}: no {word:?} in {}", ended.stderr);
        }
        assert!(names(folder.path()).is_empty(), "{flags}");
    }
}

#[test]
fn frames_for_radiance_are_rendered_again_where_any_byte_of_a_picture_or_a_scene_is_missing_or_changed() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    let line =
        "sequence --device cpu --size 4x2 --sun-elevation 5:6:1 --exposure auto -o #.hsr -o #.rad --quiet --json";
    let again = |wavelengths: &str| -> (Value, Value) {
        let line = format!("{line}{wavelengths}");
        let summary = succeed(folder, &line.split(' ').collect::<Vec<_>>()).stdout;
        let summary: Value = serde_json::from_str(&summary).unwrap();
        (summary["rendered"].clone(), summary["skipped"].clone())
    };
    assert_eq!(again(""), (json!(2), json!(0)));
    let whole = contents(folder);
    assert_eq!(whole.keys().collect::<Vec<_>>(), ["0.hsr", "0.rad", "1.hsr", "1.rad", "contact.png"]);
    assert_eq!(again(""), (json!(0), json!(2)));
    let mut scene = Scene::default();
    (scene.sun.elevation, scene.camera.size) = (5.0, "4x2".parse().unwrap());
    let wavelengths: Vec<f64> = (0..20).map(|i| 390.0 + 20.0 * f64::from(i)).collect();
    let spectra = Spectra { wavelengths, ..Spectra::default() };
    for name in ["0.hsr", "0.rad"] {
        let (bytes, path) = (&whole[name], folder.join("spoilt").with_extension(&name[2..]));
        let is_whole = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            is_finished(&path, Format::of(&path, false).unwrap(), &scene, &spectra)
        };
        assert!(is_whole(bytes), "{name}");
        for at in 0..bytes.len() {
            // A file that is cut is told by its length, whichever it is.
            assert!(at % 16 != 0 || !is_whole(&bytes[..at]), "{name}, the first {at} bytes");
            let mut changed = bytes.clone();
            changed[at] ^= 0x10;
            assert!(!is_whole(&changed), "{name}, byte {at} changed");
        }
        std::fs::remove_file(path).unwrap();
    }
    std::fs::write(folder.join("1.rad"), &whole["0.rad"]).unwrap();
    assert_eq!(again(""), (json!(1), json!(1)));
    assert!(contents(folder) == whole);
    assert_eq!(again(" --wavelengths 400:700:20"), (json!(2), json!(0)));
}

#[test]
fn every_command_of_the_page_runs_and_gives_the_light_at_an_eye() {
    let page = include_str!("../../../docs/radiance.md");
    let script = page.split("```bash\n").nth(1).and_then(|rest| rest.split("```").next()).expect("the commands");
    let folder = tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("eye.sh"), script).unwrap();
    check(folder, "with_radiance.py", &["bash", "-euo", "pipefail", "eye.sh", &binary().display().to_string()]);
    let lux = |name: &str| -> Vec<f64> {
        let text = std::fs::read_to_string(folder.join(name)).unwrap();
        text.lines().rev().take(2).map(|line| line.trim().parse().unwrap()).collect()
    };
    let (photopic, melanopic) = (lux("photopic.txt"), lux("melanopic.txt"));
    println!("eye and level: photopic {photopic:?}, melanopic {melanopic:?}");
    for found in [photopic[1], photopic[0], melanopic[1], melanopic[0]] {
        check_is_on_the_page(page, found);
    }
    let report: Value = serde_json::from_slice(&std::fs::read(folder.join("sky.json")).unwrap()).unwrap();
    let number = |key: &str| report[key].as_f64().unwrap();
    let sun = &report["sun_irradiance_rgb"];
    let luminance: f64 =
        [0.2126, 0.7152, 0.0722].iter().enumerate().map(|(i, part)| part * sun[i].as_f64().unwrap()).sum();
    let level = number("illuminance_lux") + 683.0 * luminance * number("sun_elevation").to_radians().sin();
    // 179 lm/W in the place of 182.5, and half of a hundredth for 20 bands.
    assert!((photopic[1] / level / (179.0 / 182.5) - 1.0).abs() < 5e-3, "{photopic:?}, {level}");
    let mut scene = Scene::default();
    scene.sun.place = Some("51.48,0.0".parse().unwrap());
    scene.sun.time = Some("2026-06-21T09:00:00+00:00".parse().unwrap());
    let scene = scene.validated().unwrap();
    let sky = sky_of(&scene);
    for (tilt, radiance) in [(0.0, melanopic[1]), (90.0, melanopic[0])] {
        let fallen = sky.alpha_opic(&[Surface { tilt, azimuth: 180.0 }]).unwrap().remove(0);
        let own = AlphaOpic::Melanopic.equivalent_daylight(fallen[AlphaOpic::Melanopic as usize].global);
        check_is_on_the_page(page, own);
        // Half of a hundredth for 20 bands again.
        assert!((radiance / own - 1.0).abs() < 5e-3, "tilt {tilt}: {radiance}, {own}");
    }
}

/// Checks that a figure (lx) is in the page's table.
fn check_is_on_the_page(page: &str, found: f64) {
    let cells = page.lines().filter(|line| line.contains("(lx) |")).flat_map(|line| line.split('|'));
    let mut shown = cells.filter_map(|cell| cell.replace([' ', '\u{a0}'], "").parse::<f64>().ok());
    // Chance in the samples of `rtrace`, and devices.
    assert!(shown.any(|shown| (found / shown - 1.0).abs() < 2e-3), "{found} is not on the page");
}

#[test]
#[ignore = "genssky takes a minute and more of two cores for its tables; test.sh runs it"]
fn the_page_has_the_irradiance_beside_that_of_genssky() {
    let folder = tempdir().unwrap();
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/radiance.md");
    check(folder.path(), "beside_genssky.py", &[&binary().display().to_string(), page]);
}
