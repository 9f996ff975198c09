//! What images show below the horizon, and how smooth their edges are.

use std::path::Path;

use serde_json::Value;
use sorairo_tests::compare::worst_in_images;
use sorairo_tests::program::{Image, read_exr, read_png, run, succeed};
use tempfile::tempdir;

/// Renders into a file and reads it.
fn render<T>(read: impl Fn(&Path) -> T, name: &str, flags: &str) -> T {
    let folder = tempdir().unwrap();
    let line = format!("render -o {name} {flags}");
    succeed(folder.path(), &line.split_whitespace().collect::<Vec<_>>());
    read(&folder.path().join(name))
}

fn linear(flags: &str) -> Image<f32> {
    render(|path| read_exr(path).0, "a.exr", flags)
}

fn picture(flags: &str) -> Image<u8> {
    render(read_png, "a.png", flags)
}

/// The pixels of some rows.
fn rows(image: &Image<f32>, rows: std::ops::Range<usize>) -> &[f32] {
    &image.rgb[3 * image.width * rows.start..3 * image.width * rows.end]
}

fn luminance(rgb: [f32; 3]) -> f64 {
    f64::from(0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2])
}

const MAP: &str = "--device cpu --path direct --size 64x64 --sun-elevation 25";

#[test]
fn the_sky_is_the_same_whatever_is_below_it_and_maps_have_the_ground_by_themselves() {
    let plain = linear(MAP);
    for below in ["ground", "fade", "mirror", "black", "colour", "COLOR"] {
        let image = linear(&format!("{MAP} --below {below}"));
        assert_eq!(rows(&image, 0..32), rows(&plain, 0..32), "{below}");
        assert_eq!(rows(&image, 32..64) == rows(&plain, 32..64), below == "ground", "{below}");
    }
}

#[test]
fn still_water_mirrors_the_sky_and_not_its_sun() {
    let image = linear(&format!("{MAP} --below mirror"));
    for row in 32..64 {
        assert_eq!(rows(&image, row..row + 1), rows(&image, 63 - row..64 - row), "row {row}");
    }
    let with_disc = linear(&format!("{MAP} --below mirror --sun-disc"));
    assert_eq!(rows(&with_disc, 32..64), rows(&image, 32..64));
    assert_ne!(rows(&with_disc, 0..32), rows(&image, 0..32));
}

#[test]
fn black_is_black_and_white_ground_sends_back_what_falls_on_it() {
    let black = linear(&format!("{MAP} --below black"));
    assert!(rows(&black, 32..64).iter().all(|&value| value == 0.0) && black.at(3, 31)[2] > 0.0);
    let white = linear(&format!("{MAP} --below colour --below-color 1,0.5,0"));
    let folder = tempdir().unwrap();
    let line = format!("render -o a.exr --json {MAP}");
    let report = succeed(folder.path(), &line.split(' ').collect::<Vec<_>>());
    let report: Value = serde_json::from_str(&report.stdout).unwrap();
    let number = |key: &str| report[key].as_f64().unwrap();
    let level = number("direct_irradiance_w_m2") / number("sun_irradiance_w_m2");
    for (channel, reflectance) in [(0, 1.0), (1, 0.5), (2, 0.0)] {
        let [sky, sun] = ["irradiance_rgb", "sun_irradiance_rgb"].map(|key| report[key][channel].as_f64().unwrap());
        let expected = reflectance * (sky + level * sun) / std::f64::consts::PI;
        for row in 32..64 {
            let found = f64::from(white.at(row, row)[channel]);
            // Single precision.
            assert!((found - expected).abs() <= 1e-5 * expected, "{channel}: {found}, not {expected}");
        }
    }
}

#[test]
fn a_fade_leaves_no_line_at_the_horizon_and_ends_in_the_ground() {
    for sun in [60, 25, 5, -3] {
        let flags = format!("--device cpu --size 16x720 --sun-elevation={sun}");
        let [ground, fade] = ["ground", "fade"].map(|below| linear(&format!("{flags} --below {below}")));
        for column in 0..16 {
            let step = |image: &Image<f32>| {
                let [above, below] = [359, 360].map(|row| luminance(image.at(column, row)));
                (below / above - 1.0).abs()
            };
            // Rows are a quarter of a degree apart: what the sky's own rows differ by there.
            assert!(step(&fade) < 0.03, "sun at {sun}, column {column}: {}", step(&fade));
            assert!(step(&ground) > 0.2, "sun at {sun}, column {column}: {}", step(&ground));
            for channel in 0..3 {
                let [found, expected] = [&fade, &ground].map(|image| image.at(column, 719)[channel]);
                // An eighth of a degree from the nadir the haze is 2e-4 of the horizon, which is up to a hundred times
                // as bright.
                assert!((found - expected).abs() <= 0.02 * expected, "sun at {sun}: {found}, not {expected}");
            }
        }
    }
}

#[test]
fn a_sun_that_has_set_leaves_no_spot_below_the_horizon() {
    for sun in [-2, -4, -7] {
        // The peak of dust is narrow.
        let image =
            linear(&format!("--device cpu --size 16x720 --sun-elevation={sun} --aerosol-kind desert --below fade"));
        let brightest = |row| (0..16).map(|column| luminance(image.at(column, row))).fold(0.0, f64::max);
        for row in 360..420 {
            let [above, below] = [row, row + 1].map(brightest);
            assert!(above > 0.0 && below <= 1.001 * above, "sun at {sun}, row {row}: {below} below {above}");
        }
    }
}

#[test]
fn a_glow_of_twilight_does_not_lie_over_the_ground_at_ones_feet() {
    for sun in [-3, -9, -15] {
        let flags = format!("--device cpu --size 16x720 --sun-elevation={sun}");
        let [ground, fade] = ["ground", "fade"].map(|below| linear(&format!("{flags} --below {below}")));
        let of_row =
            |image: &Image<f32>, row| (0..16).map(|column| luminance(image.at(column, row))).fold(0.0, f64::max);
        let [horizon, under] = [of_row(&ground, 359), of_row(&ground, 520)];
        // 40 degrees down haze is as bright as the ground, but for what the horizon differs between an eighth and half
        // a degree above it.
        let found = of_row(&fade, 520) / under;
        assert!((1.0..2.5).contains(&found), "sun at {sun}: {found}");
        // An even haze, the negative control, has the ninth part of the horizon's light there.
        assert!(horizon / under > 9.0 * 2.5, "sun at {sun}: {}", horizon / under);
    }
}

#[test]
fn pictures_of_the_whole_sphere_fade_by_themselves_and_those_of_a_camera_see_the_ground() {
    let camera = "--device cpu --size 64x64 --projection perspective --look-elevation 0";
    for (flags, below) in [(MAP, "fade"), (camera, "ground")] {
        assert_eq!(picture(flags).rgb, picture(&format!("{flags} --below {below}")).rgb, "{below}");
    }
    for of_ground in ["--albedo 0", "--altitude 12"] {
        let flags = format!("{MAP} {of_ground}");
        assert_eq!(picture(&flags).rgb, picture(&format!("{flags} --below ground")).rgb, "{of_ground}");
    }
}

#[test]
fn a_picture_is_the_same_beside_a_linear_image_of_its_sky() {
    let folder = tempdir().unwrap();
    let line = format!("render -o a.png -o a.exr {MAP}");
    succeed(folder.path(), &line.split(' ').collect::<Vec<_>>());
    assert_eq!(read_png(&folder.path().join("a.png")).rgb, picture(MAP).rgb);
    assert_eq!(read_exr(&folder.path().join("a.exr")).0.rgb, linear(MAP).rgb);
}

#[test]
fn both_devices_and_both_paths_show_the_same_below_the_horizon() {
    let views = [
        "--projection equirectangular --size 128x64",
        "--projection equirectangular --size 128x63 --altitude 3",
        "--projection fisheye --fov 250 --size 96x96",
        "--projection perspective --look-elevation -10 --size 128x64 --altitude 0.3",
        "--projection perspective --look-elevation -10 --size 128x64",
    ];
    for (view, below) in views.into_iter().flat_map(|view| ["fade", "mirror", "black"].map(|below| (view, below))) {
        let of = |way: &str| linear(&format!("{view} --below {below} --sun-elevation 20 {way}"));
        let [cpu, gpu, direct] =
            ["--device cpu --path lookup", "--device gpu --path lookup", "--device cpu --path direct"].map(of);
        let gpu = worst_in_images(&gpu.rgb, &cpu.rgb, cpu.width, 3, 1e-3);
        // What devices may differ by; see the tests of devices.
        assert!(gpu.relative < 1e-3, "{view}, {below}: {gpu:?}");
        let direct = worst_in_images(&cpu.rgb, &direct.rgb, cpu.width, 3, 1e-3);
        // A mean error of 1e-3 is the lookup's own tolerance; beside the horizon of a small image it is up to some per
        // cent.
        assert!(direct.relative < 0.05, "{view}, {below}: {direct:?}");
    }
}

/// The largest difference between a picture and the mean of one so many times as fine, in bytes, and how many pixels
/// differ by more than 8 of them, within the circle of a fisheye.
fn beside_finer(fine: &Image<u8>, coarse: &Image<u8>) -> (f64, usize) {
    let times = fine.width / coarse.width;
    let to_linear = |byte: u8| (f64::from(byte) / 255.0).powf(2.2);
    let (mut worst, mut many) = (0.0f64, 0);
    for (row, column) in (0..coarse.height).flat_map(|row| (0..coarse.width).map(move |column| (row, column))) {
        let from_middle = |place: usize| place as f64 + 0.5 - 0.5 * coarse.width as f64;
        if from_middle(row).hypot(from_middle(column)) > 0.5 * coarse.width as f64 - 1.0 {
            continue;
        }
        let inside = (0..times * times).map(|i| fine.at(column * times + i % times, row * times + i / times)[1]);
        let mean = inside.map(to_linear).sum::<f64>() / (times * times) as f64;
        let off = (255.0 * mean.powf(1.0 / 2.2) - f64::from(coarse.at(column, row)[1])).abs();
        worst = worst.max(off);
        many += usize::from(off > 8.0);
    }
    (worst, many)
}

#[test]
fn the_horizon_and_the_suns_disc_have_no_steps_in_pictures() {
    // A horizon that is a curve, in both projections and seen through air and without it, and a disc of 11 pixels.
    // Farther up the limb itself is finer than a pixel, and the sky is taken once in each.
    let views = [
        "--projection fisheye --look-elevation 0 --altitude 0 --exposure -5",
        "--projection fisheye --look-elevation 10 --altitude 8 --exposure -5",
        "--projection perspective --look-elevation -5 --altitude 20 --fov 50 --below black --exposure -5",
        "--projection perspective --look-elevation -5 --altitude 20 --fov 50 --exposure -5",
        "--projection perspective --look-elevation 30 --fov 3 --sun-disc --exposure -10",
    ];
    const SIZE: usize = 64;
    for view in views {
        for device in ["cpu", "gpu"] {
            let of = |size: usize| {
                let flags = format!("--device {device} {view} --view srgb --dither none --path lookup");
                picture(&format!("{flags} --size {size}x{size}"))
            };
            let (coarse, fine) = (of(SIZE), of(8 * SIZE));
            let (worst, many) = beside_finer(&fine, &coarse);
            println!("{view}, {device}: {worst} bytes, {many} pixels");
            // By the distance from a line, an edge is off where that is curved or crosses a pixel aslant; without a
            // mean, by half of the step, 60 to 120.
            assert!(worst < 20.0 && many < 32, "{view}, {device}: {worst} bytes, {many} pixels");
        }
    }
}

#[test]
fn a_wrong_lower_half_is_refused_in_one_sentence() {
    let folder = tempdir().unwrap();
    for (flags, word) in [
        ("--below sky", "mirror"),
        ("--below colour --below-color 1,2,3", "each from 0 to 1"),
        ("--below-color 1,0,0", "applies only with"),
        ("--below fade -o a.spectral.exr", "a spectral file shows the ground"),
    ] {
        let line = format!("render {flags}");
        let ended = run(folder.path(), &line.split(' ').collect::<Vec<_>>());
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains(word), "{}", ended.stderr);
    }
}
