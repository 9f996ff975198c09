//! Files that other programs light with: pictures of 8 bits and an exponent, skies with and without their sun.

use std::path::Path;

use serde_json::{Value, json};
use sorairo::low_level::files::{Format, is_finished};
use sorairo::scene::Scene;
use sorairo_tests::program::{Image, contents, read_exr, run, succeed};
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
        let largest = expected.iter().copied().fold(0.0, f32::max);
        for (found, expected) in found.iter().zip(expected) {
            // Half of a step, of which there are 128 to 256 in the largest; 127.75 where that rounds up to a power of two.
            let error = (found - expected).abs();
            assert!(error <= 0.5001 * largest / 127.75, "{what}, pixel {i}: {found} for {expected}");
        }
    }
}

#[test]
fn an_hdr_holds_the_exr_within_a_part_in_256_of_a_pixels_largest_component_row_by_row() {
    for flags in [
        // Rows whose bytes are counted, rows that are stored as they are, light over many powers of ten, another space, another camera.
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
    let line = "sequence --device cpu --size 16x8 --sun-elevation 5:6:1 --exposure auto -o #.hdr --quiet --json";
    let again = || -> (Value, Value) {
        let summary: Value = serde_json::from_str(&say(folder, line)).unwrap();
        (summary["rendered"].clone(), summary["skipped"].clone())
    };
    assert_eq!(again(), (json!(2), json!(0)));
    let whole = contents(folder);
    assert_eq!(whole.keys().collect::<Vec<_>>(), ["0.hdr", "1.hdr", "contact.png"]);
    assert_eq!(again(), (json!(0), json!(2)));
    let mut scene = Scene::default();
    (scene.sun.elevation, scene.camera.size) = (5.0, "16x8".parse().unwrap());
    let path = folder.join("spoilt.hdr");
    let is_whole = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        is_finished(&path, Format::Hdr, &scene, &[])
    };
    let bytes = &whole["0.hdr"];
    assert!(is_whole(bytes) && !is_whole(&[&bytes[..], &[0]].concat()));
    for at in 0..bytes.len() {
        assert!(!is_whole(&bytes[..at]), "the first {at} bytes");
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
    let sky = sorairo::Renderer::open("cpu").unwrap().render(&scene).unwrap();
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
    assert!(is_finished(&folder.path().join("0.exr"), Format::Exr, &scene, &[]));
}
