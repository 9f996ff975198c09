//! Files that other programs light with: pictures of 8 bits and an exponent, skies with and without their sun.

use std::path::Path;

use serde_json::{Value, json};
use sorairo::low_level::files::{Format, Spectra, is_finished};
use sorairo::scene::Scene;
use sorairo_shared::math::max;
use sorairo_tests::program::{Image, contents, read_exr, read_png, run, succeed};
use sorairo_tests::python::check;
use sorairo_tests::sky::sky_of;
use tempfile::tempdir;

/// Runs the program with the words of a line.
fn say(folder: &Path, line: &str) -> String {
    succeed(folder, &line.split(' ').collect::<Vec<_>>()).stdout
}

/// Reads a picture of RGB with a shared exponent, as the crate `image` does.
fn read_hdr(path: &Path) -> Image<f32> {
    let image::DynamicImage::ImageRgb32F(image) = image::open(path).expect("a picture") else {
        panic!("{} is not RGB in floats", path.display())
    };
    Image { width: image.width() as usize, height: image.height() as usize, rgb: image.into_raw() }
}

/// Checks that two images differ nowhere by more than half a step of a pixel's largest component.
fn assert_within_a_step(found: &Image<f32>, expected: &Image<f32>, what: &str) {
    assert_eq!((found.width, found.height), (expected.width, expected.height), "{what}");
    assert!(!expected.rgb.is_empty());
    for (i, (found, expected)) in found.rgb.chunks(3).zip(expected.rgb.chunks(3)).enumerate() {
        let largest = expected.iter().copied().fold(0.0, max);
        for (found, expected) in found.iter().zip(expected) {
            // Half of a step, of which there are 128 to 256 in the largest; 127.75 where that rounds up to a power of
            // two.
            let error = (found - expected).abs();
            assert!(error <= 0.5001 * largest / 127.75, "{what}, pixel {i}: {found} for {expected}");
        }
    }
}

#[test]
fn an_hdr_holds_the_exr_within_a_part_in_256_of_a_pixels_largest_component_row_by_row() {
    for flags in [
        // Rows whose bytes are counted, rows that are stored as they are, light over many powers of ten, another space,
        // another camera.
        "--size 256x128",
        "--size 6x9",
        "--size 512x256 --sun-disc",
        "--size 64x32 --sun-elevation=-8 --rgb acescg",
        "--size 64x64 --projection fisheye --exr-exposure -3",
        // The exposure of half floats is theirs alone.
        "--size 64x32 --sun-elevation=-12",
    ] {
        for device in ["cpu", "gpu"] {
            let folder = tempdir().unwrap();
            say(folder.path(), &format!("render --device {device} --sun-azimuth 70 {flags} -o a.hdr -o a.exr"));
            let (found, (expected, _)) =
                (read_hdr(&folder.path().join("a.hdr")), read_exr(&folder.path().join("a.exr")));
            assert_within_a_step(&found, &expected, flags);
            let (column, row) = expected.brightest();
            assert!(
                found.at(column, row)[1] >= 0.99 * found.at(found.brightest().0, found.brightest().1)[1],
                "{flags}"
            );
        }
    }
}

#[test]
fn an_hdr_alone_or_beside_half_floats_is_the_same_file() {
    let folder = tempdir().unwrap();
    let sky = "render --device cpu --size 64x32 --sun-elevation 20 --sun-disc --exr f16";
    say(folder.path(), &format!("{sky} -o alone.hdr"));
    say(folder.path(), &format!("{sky} -o beside.hdr -o beside.exr -o beside.png"));
    let files = contents(folder.path());
    assert!(files["alone.hdr"] == files["beside.hdr"]);
}

#[test]
fn an_hdr_says_its_scene_its_primaries_and_its_exposure() {
    let folder = tempdir().unwrap();
    say(
        folder.path(),
        "render --device cpu --size 16x8 --sun-elevation 20 --rgb rec2020 --exr-exposure -2 -o a.hdr --quiet",
    );
    let bytes = std::fs::read(folder.path().join("a.hdr")).unwrap();
    let end = bytes.windows(2).position(|pair| pair == b"\n\n").unwrap();
    let header = std::str::from_utf8(&bytes[..end]).unwrap();
    let value = |name: &str| {
        let lines = header.lines().filter_map(|line| line.strip_prefix(name)?.strip_prefix('='));
        lines.map(str::trim).collect::<Vec<_>>()
    };
    assert_eq!(header.lines().next(), Some("#?RADIANCE"));
    assert_eq!(value("SOFTWARE"), [concat!("sorairo ", env!("CARGO_PKG_VERSION"))]);
    assert_eq!(value("FORMAT"), ["32-bit_rle_rgbe"]);
    assert_eq!(value("PRIMARIES"), ["0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0.329"]);
    assert_eq!(value("EXPOSURE")[0].parse(), Ok(0.25));
    let scene = Scene::parse(&value("sorairoScene").join("\n"), "a.hdr", None).unwrap();
    assert_eq!((scene.sun.elevation, scene.camera.size.to_string()), (20.0, "16x8".into()));
}

#[test]
fn hdr_frames_are_rendered_again_where_any_byte_is_missing_changed_or_added() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    let line = "sequence --device cpu --size 8x4 --sun-elevation 5:6:1 --exposure auto -o #.hdr --quiet --json";
    let again = || -> (Value, Value) {
        let summary: Value = serde_json::from_str(&say(folder, line)).unwrap();
        (summary["rendered"].clone(), summary["skipped"].clone())
    };
    assert_eq!(again(), (json!(2), json!(0)));
    let whole = contents(folder);
    assert_eq!(whole.keys().collect::<Vec<_>>(), ["0.hdr", "1.hdr", "contact.png"]);
    assert_eq!(again(), (json!(0), json!(2)));
    let mut scene = Scene::default();
    (scene.sun.elevation, scene.camera.size) = (5.0, "8x4".parse().unwrap());
    let path = folder.join("spoilt.hdr");
    let is_whole = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        is_finished(&path, Format::Hdr, &scene, &Spectra::default())
    };
    let bytes = &whole["0.hdr"];
    assert!(is_whole(bytes) && !is_whole(&[&bytes[..], &[0]].concat()));
    for at in 0..bytes.len() {
        // A file that is cut is told by its length, whichever it is.
        assert!(at % 16 != 0 || !is_whole(&bytes[..at]), "the first {at} bytes");
        let mut changed = bytes.clone();
        changed[at] ^= 0x10;
        assert!(!is_whole(&changed), "byte {at} changed");
    }
    std::fs::remove_file(path).unwrap();
    std::fs::write(folder.join("1.hdr"), bytes).unwrap();
    assert_eq!(again(), (json!(1), json!(1)));
    assert!(contents(folder) == whole);
}

#[test]
fn an_image_in_memory_is_saved_as_the_same_hdr() {
    let folder = tempdir().unwrap();
    let mut scene = Scene::default();
    (scene.sun.elevation, scene.camera.size) = (12.0, "64x32".parse().unwrap());
    let sky = sky_of(&scene).image(&scene.camera, &mut sorairo::Device::cpu()).unwrap();
    sky.save(folder.path().join("saved.hdr")).unwrap();
    say(folder.path(), "render --device cpu --size 64x32 --sun-elevation 12 -o told.hdr");
    let files = contents(folder.path());
    assert!(files["saved.hdr"] == files["told.hdr"]);
    let error = sky.save(folder.path().join("a.rad")).unwrap_err().to_string();
    assert!(error.contains("holds RGB alone"), "{error}");
    let ended = run(folder.path(), &["render", "-o", "a.hdri"]);
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    assert!(ended.stderr.contains("the file name must end in .png, .exr, .hdr,"), "{}", ended.stderr);
}

#[test]
fn words_are_read_in_any_case_of_letters_and_by_their_other_names() {
    let folder = tempdir().unwrap();
    let shown = |flags: &str| say(folder.path(), &format!("scene show {flags}"));
    for (said, meant) in [
        ("--rgb ACEScg", "--rgb acescg"),
        ("--rgb Rec2020", "--rgb rec2020"),
        ("--preset Mars", "--preset mars"),
        ("--fit DENSE --color Folded", "--fit dense --color folded"),
        // What some words and flags were called before.
        ("--fit extinction --path table --steps 5", "--fit regression --path lookup --samples 5"),
        ("--observer CIE2015 --white-balance D65", "--observer cie2015 --white-balance d65"),
        ("--exr F16 --exr-compression ZIP --dither None", "--exr f16 --exr-compression zip --dither none"),
        ("--exposure AUTO --orders All --albedo Snow", "--exposure auto --orders all --albedo snow"),
        ("--projection latlong", "--projection equirectangular"),
        ("--projection LatLong", "--projection equirectangular"),
        ("--projection Fisheye", "--projection fisheye"),
        ("--size 2k", "--size 2048x1024"),
        ("--size 4K", "--size 4096x2048"),
        ("--size 8k", "--size 8192x4096"),
        ("--size 20X10", "--size 20x10"),
    ] {
        assert_eq!(shown(said), shown(meant), "{said}");
        if meant != "--projection equirectangular" && !meant.contains("auto") {
            assert_ne!(shown(meant), shown("--quiet"), "{meant}");
        }
    }
}

#[test]
fn a_scene_file_and_a_table_take_the_names_of_maps_too() {
    let scene = Scene::parse("[camera]\nsize = '4k'\nprojection = 'latlong'", "a.toml", None).unwrap();
    assert_eq!(scene.camera.size.to_string(), "4096x2048");
    assert_eq!(scene.camera.projection, sorairo::scene::Projection::Equirectangular);
    let folder = tempdir().unwrap();
    let table = "sun.elevation,render.rgb,ground.albedo\n10,ACEScg,Snow\n11,xyz,0.3\n";
    std::fs::write(folder.path().join("cases.csv"), table).unwrap();
    say(folder.path(), "sequence --device cpu --size 8x4 --table cases.csv -o #.exr --quiet");
    let text = "sun.elevation = 10\ncamera.size = '8x4'\nrender.rgb = 'acescg'\nground.albedo = 'snow'";
    let scene = Scene::parse(text, "a.toml", None).unwrap();
    assert!(is_finished(&folder.path().join("0.exr"), Format::Exr, &scene, &Spectra::default()));
}

#[test]
fn a_sky_split_from_its_sun_is_two_files_as_two_commands_write_them() {
    let folder = tempdir().unwrap();
    let sky = "render --device cpu --size 64x32 --sun-elevation 20 --sun-azimuth 30";
    let report = say(folder.path(), &format!("{sky} --split-sun -o sky.exr -o sky.hdr --json"));
    let report: Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["outputs"], json!(["sky.exr", "sky.hdr", "sky.sun.exr", "sky.sun.hdr"]));
    // A program that lights with sky.exr adds a sun.
    assert_eq!((&report["sun_disc"], &report["replaced"]), (&json!(false), &json!([])));
    say(folder.path(), &format!("{sky} -o light.exr -o light.hdr"));
    say(folder.path(), &format!("{sky} --sun-disc -o seen.exr -o seen.hdr"));
    let files = contents(folder.path());
    for (split, alone) in
        [("sky.exr", "light.exr"), ("sky.hdr", "light.hdr"), ("sky.sun.exr", "seen.exr"), ("sky.sun.hdr", "seen.hdr")]
    {
        assert!(files[split] == files[alone], "{split}");
    }
    let brightest = |name: &str| {
        let (image, _) = read_exr(&folder.path().join(name));
        image.rgb.iter().copied().fold(0.0, max)
    };
    assert!(brightest("sky.sun.exr") > 100.0 * brightest("sky.exr"));
}

#[test]
fn both_pictures_of_a_split_sky_have_one_exposure_and_differ_where_the_sun_is_alone() {
    for (flags, name) in [("", "png"), (" --exr f16", "exr")] {
        let folder = tempdir().unwrap();
        let line =
            format!("render --device cpu --size 64x32 --sun-elevation 40 --split-sun{flags} -o sky.{name} --quiet");
        say(folder.path(), &line);
        let pixels = |name: &str| -> Vec<[u8; 12]> {
            let image = match name.ends_with("png") {
                true => image::open(folder.path().join(name)).unwrap().to_rgb32f(),
                false => {
                    use exr::prelude::{ReadChannels, ReadLayers, read};
                    let file = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
                    let file = file.all_attributes().from_file(folder.path().join(name)).unwrap();
                    let values = file.layer_data.channel_data.list.iter().flat_map(|c| c.sample_data.values_as_f32());
                    let values: Vec<f32> = values.collect();
                    let pixels = values.len() / 3;
                    let rgb = (0..pixels).flat_map(|i| [2, 1, 0].map(|channel| values[channel * pixels + i])).collect();
                    image::Rgb32FImage::from_raw(64, 32, rgb).unwrap()
                }
            };
            image.pixels().map(|pixel| bytemuck::cast(pixel.0)).collect()
        };
        let (light, seen) = (pixels(&format!("sky.{name}")), pixels(&format!("sky.sun.{name}")));
        let others = light.iter().zip(&seen).filter(|(light, seen)| light != seen).count();
        assert!(light.len() == 64 * 32 && (1..=4).contains(&others), "{name}: {others} pixels differ");
    }
}

#[test]
fn a_split_sky_to_which_an_eye_adapts_has_the_one_exposure_of_its_sun() {
    let folder = tempdir().unwrap();
    // The disc fills a seventieth of this picture, so a meter sees it.
    let sky = "render --device cpu --size 64x32 --sun-elevation 8 --projection perspective --fov 6 --look-elevation 8 \
               --exposure adapt --dither none";
    let exposure = |flags: &str| {
        let report: Value = serde_json::from_str(&say(folder.path(), &format!("{sky} {flags} --json"))).unwrap();
        report["exposure_ev"].as_f64().unwrap()
    };
    let both = exposure("--split-sun -o sky.png");
    let (light, seen) = (exposure("-o light.png"), exposure("--sun-disc -o seen.png"));
    assert!((both - seen).abs() < 1e-6 && (both - light).abs() > 0.1, "{both} {seen} {light}");
    let files = contents(folder.path());
    assert!(files["sky.sun.png"] != files["sky.png"]);
    let [without, with] = ["sky.png", "sky.sun.png"].map(|name| read_png(&folder.path().join(name)));
    // Where there is no disc, one is the other.
    let corner = |image: &Image<u8>| (0..32).map(|row| image.at(0, row)).collect::<Vec<_>>();
    assert_eq!(corner(&without), corner(&with));
    assert!(without.at(32, 16) != with.at(32, 16));
}

#[test]
fn a_split_sky_takes_the_place_of_files_by_the_rules_of_all_or_is_refused_with_2_and_nothing_begun() {
    for (flags, there, words) in [
        ("-o a.exr --no-clobber", Some("a.sun.exr"), "a.sun.exr exists"),
        ("", Some("sky.sun.png"), "sky.sun.png exists, and sorairo did not write it"),
        ("-o a.exr -o a.sun.exr", None, "-o a.sun.exr is given twice"),
        ("-o a.spectral.exr", None, "split off .png, .exr and .hdr files alone"),
        ("-o a.exr --spectral", None, "split off .png, .exr and .hdr files alone"),
        ("-o a.hsr", None, "-o a.hsr: the sun's disc is split off .png, .exr and .hdr files alone"),
        ("-o a.hsr -o a.rad", None, "split off .png, .exr and .hdr files alone"),
        ("-o a.usda", None, "-o a.exr too"),
    ] {
        let folder = tempdir().unwrap();
        if let Some(there) = there {
            std::fs::write(folder.path().join(there), "was here before").unwrap();
        }
        let before = contents(folder.path());
        let line = format!("render --device cpu --size 8x4 --split-sun {flags}");
        let ended = run(folder.path(), &line.split_whitespace().collect::<Vec<_>>());
        assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""), "{flags}: {}", ended.stderr);
        // What computes is told beside the sentence, where a file is known to stay at the end alone.
        assert!(ended.stderr.contains(words) && !ended.stderr.contains("panicked"), "{flags}: {}", ended.stderr);
        assert!(contents(folder.path()) == before, "{flags}");
    }
    let folder = tempdir().unwrap();
    std::fs::write(folder.path().join("a.sun.png"), "was here before").unwrap();
    let report = say(folder.path(), "render --device cpu --size 8x4 --split-sun -o a.png --json");
    let report: Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["replaced"], json!(["a.sun.png"]));
}

/// Haze whose glow shows where the sun is, in air whose light over the whole spectrum of the sun is soon told.
const HAZE: &str = "preset = \"hazy\"\n[atmosphere.aerosol]\noptical_depth = 0.3\nasymmetry = 0.75\n";

#[test]
fn a_usd_scene_has_the_sun_where_it_stands_with_its_irradiance_and_a_dome_that_is_brightest_there() {
    // A device's pixels are those of the processor, whatever is said of them.
    let (both, one) = (&["cpu", "gpu"][..], &["cpu"][..]);
    for (flags, shines, devices) in [
        ("--sun-elevation 40 --sun-azimuth 60", "yes", both),
        // A map that looks elsewhere, in half floats that are exposed, in another space, beside the same sky with its
        // sun.
        ("--sun-elevation 25 --sun-azimuth 215 --look-azimuth 130 --exr f16 --rgb acescg --split-sun", "yes", one),
        ("--sun-elevation 30 --sun-azimuth=-75 --exr-exposure 3 --spectral --wavelengths 450,550,650", "yes", one),
        ("--place 38.72,-9.14 --time 2026-01-03T11:00:00+00:00", "yes", one),
        ("--sun-elevation=-4 --sun-azimuth 20 --orders 1", "no", one),
    ] {
        for device in devices {
            let folder = tempdir().unwrap();
            let folder = folder.path();
            std::fs::write(folder.join("scene.toml"), HAZE).unwrap();
            let line = format!("render --scene scene.toml --device {device} --size 512x256 {flags} --json");
            let files = ["-o", "my sky.exr", "-o", "my sky.usda"];
            let report = succeed(folder, &[&line.split(' ').collect::<Vec<_>>()[..], &files].concat()).stdout;
            std::fs::write(folder.join("report.json"), report).unwrap();
            check(folder, "usd_sky.py", &["my sky.usda", "report.json", shines]);
        }
    }
}

#[test]
fn what_a_usd_scene_cannot_hold_is_refused_with_2_and_nothing_begun() {
    let pair = "-o a.usda -o a.exr";
    for (flags, words) in [
        ("-o a.usda", &["-o a.usda", "needs its picture beside it", "-o a.exr too"][..]),
        ("-o a.usda -o a.hdr", &["-o a.exr too"]),
        ("-o a.usda -o b.exr", &["-o a.exr too"]),
        ("-o a@.usda -o a@.exr", &["-o a@.usda", "choose another name"]),
        (&format!("{pair} --projection fisheye"), &["--projection (camera.projection)", "equirectangular"]),
        (&format!("{pair} --sun-disc"), &["--sun-disc (sun.disc) is true", "leave the disc out"]),
    ] {
        let folder = tempdir().unwrap();
        let line = format!("render --device cpu --size 8x4 {flags}");
        let ended = run(folder.path(), &line.split(' ').collect::<Vec<_>>());
        assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""), "{flags}: {}", ended.stderr);
        assert_eq!(ended.stderr.lines().count(), 1, "{flags}: {}", ended.stderr);
        for word in words {
            assert!(ended.stderr.contains(word), "{flags}: no {word:?} in {}", ended.stderr);
        }
        assert!(contents(folder.path()).is_empty(), "{flags}");
    }
}

#[test]
fn usd_frames_are_rendered_again_where_any_byte_is_missing_or_changed() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    let line = "sequence --device cpu --size 8x4 --sun-elevation 5:6:1 -o #.exr -o #.usda --quiet --json";
    let again = || -> (Value, Value) {
        let summary: Value = serde_json::from_str(&say(folder, line)).unwrap();
        (summary["rendered"].clone(), summary["skipped"].clone())
    };
    assert_eq!(again(), (json!(2), json!(0)));
    let whole = contents(folder);
    assert_eq!(whole.keys().collect::<Vec<_>>(), ["0.exr", "0.usda", "1.exr", "1.usda", "contact.png"]);
    assert_eq!(again(), (json!(0), json!(2)));
    for spoilt in [&whole["0.usda"][..], &whole["1.usda"][..whole["1.usda"].len() - 1]] {
        std::fs::write(folder.join("1.usda"), spoilt).unwrap();
        assert_eq!(again(), (json!(1), json!(1)));
        assert!(contents(folder) == whole);
    }
}
