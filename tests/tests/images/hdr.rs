//! Pictures of high dynamic range: 16 bits in the curve PQ.

use std::path::Path;

use sorairo::encoding::Image;
use sorairo::scene::{Display, Rgb, ViewTransform};
use sorairo::{Device, LightFields, PixelFormat, Plan, Preset, Scene, Sky};
use sorairo_shared::glam::DVec3;
use sorairo_tests::program::{read_exr, read_png, succeed};
use sorairo_tests::sky::sky_of;
use tempfile::tempdir;

/// The signal of a luminance (cd/m²) in 16 bits: the inverse EOTF of ITU-R BT.2100-3, table 4.
fn signal(luminance: f64) -> f64 {
    let power = (luminance / 1e4).powf(2610.0 / 16384.0);
    let (c1, c2, c3) = (3424.0 / 4096.0, 2413.0 / 128.0, 2392.0 / 128.0);
    65_535.0 * ((c1 + c2 * power) / (1.0 + c3 * power)).powf(2523.0 / 32.0)
}

/// The luminance (cd/m²) of a signal in 16 bits: the EOTF of the same table.
fn luminance(signal: f64) -> f64 {
    let power = (signal / 65_535.0).powf(32.0 / 2523.0);
    let (c1, c2, c3) = (3424.0 / 4096.0, 2413.0 / 128.0, 2392.0 / 128.0);
    1e4 * ((power - c1).max(0.0) / (c2 - c3 * power)).powf(16384.0 / 2610.0)
}

/// The largest signal of 16 bits: that of 1000 cd/m², rounded as single precision may.
const MOST: u16 = 49_272;

/// The pixels (red, green, blue) of a PNG of 16 bits that says it is PQ in the primaries of Rec. 2020.
fn decoded(png: &[u8]) -> Vec<[u16; 3]> {
    let at = png.windows(4).position(|name| name == b"cICP").expect("code points");
    assert_eq!(png[at - 4..at + 8], *b"\0\0\0\x04cICP\x09\x10\0\x01");
    assert!(at < png.windows(4).position(|name| name == b"IDAT").unwrap());
    let image::DynamicImage::ImageRgb16(image) = image::load_from_memory(png).unwrap() else {
        panic!("not 16 bit RGB");
    };
    image.pixels().map(|pixel| pixel.0).collect()
}

fn read(path: &Path) -> Vec<[u16; 3]> {
    decoded(&std::fs::read(path).unwrap())
}

fn hdr() -> Scene {
    let mut scene = Scene::preset(Preset::Paper);
    scene.render.display = Display::Rec2100Pq;
    scene
}

/// The pixels of a picture of greys.
fn of_greys(greys: &[f32]) -> Vec<[u16; 3]> {
    let scene = hdr().validated().unwrap();
    let plan = Plan::new(&scene, PixelFormat::Picture);
    let image = Image { width: greys.len() as u32, height: 1, factor: 1.0, ..Image::of(&plan, &scene) };
    let words: Vec<u32> = greys.iter().flat_map(|grey| [grey.to_bits(); 3]).collect();
    decoded(&image.png(&words).unwrap())
}

#[test]
fn a_ramp_is_monotone_and_white_has_203_candelas_and_middle_grey_26() {
    let ramp: Vec<f32> = (0..=4000).map(|step| (step as f32 * 0.01 - 30.0).exp2()).collect();
    let shown = of_greys(&ramp);
    assert!(shown.iter().all(|[red, green, blue]| red == green && green == blue));
    // Single precision may turn round a step of 16 bits where the curve is level.
    assert!(shown.windows(2).all(|pair| pair[1][0] + 1 >= pair[0][0]));
    assert!(shown[0][0] < 100 && shown[4000][0].abs_diff(MOST) <= 1, "{:?} to {:?}", shown[0], shown[4000]);
    let [black, grey, white, bright] = of_greys(&[0.0, 0.18, 1.0, 1e30])[..] else { panic!("four pixels") };
    assert_eq!(black[0], 0);
    // What the standards print has three digits: ITU-R BT.2408-7, table 1, says 38 % and 58 %.
    assert!((f64::from(grey[0]) / 65_535.0 - 0.380).abs() < 1e-3, "{grey:?}");
    assert!((f64::from(white[0]) / 65_535.0 - 0.5807).abs() < 1e-3, "{white:?}");
    assert!(bright[0].abs_diff(MOST) <= 1, "{bright:?}");
}

#[test]
fn a_sky_has_the_light_of_its_linear_image_up_to_the_knee_and_its_hues_above() {
    for (sun, exposure) in [("30", "-4"), ("2", "-1")] {
        let folder = tempdir().unwrap();
        let line = ["render", "--device", "cpu", "--projection", "perspective", "--size", "96x64", "--sun-disc"];
        let sky = ["--sun-elevation", sun, "--look-elevation", "20", "--fov", "60", "--below", "ground"];
        let hdr = ["--display", "rec2100-pq", "--rgb", "rec2020", "--exposure", exposure, "-o", "a.png", "-o", "a.exr"];
        succeed(folder.path(), &[&line[..], &sky, &hdr].concat());
        let (linear, _) = read_exr(&folder.path().join("a.exr"));
        let factor = exposure.parse::<f64>().unwrap().exp2();
        let (mut same, mut white, mut most, mut turned) = (0, 0, 0, 0.0f64);
        for (shown, rgb) in read(&folder.path().join("a.png")).iter().zip(linear.rgb.chunks(3)) {
            let rgb = DVec3::new(f64::from(rgb[0]), f64::from(rgb[1]), f64::from(rgb[2])) * factor;
            // The parts of ITU-R BT.2020-2, table 4, of four digits, move the luminance by a part in ten thousand.
            let light = rgb * 203.0 * DVec3::new(0.2627, 0.6780, 0.0593).dot(rgb).powf(0.2);
            let shown = DVec3::from_array(shown.map(f64::from));
            if light.max_element() < 317.0 {
                let off = (shown - DVec3::from_array(light.to_array().map(signal))).abs().max_element();
                // A half is rounded; the parts and single precision leave as much.
                assert!(off < 1.5, "{light}: {shown}, off by {off}");
                same += 1;
            }
            white += usize::from(shown.max_element() > signal(203.0));
            most = most.max(shown.max_element() as u16);
            let seen = DVec3::from_array(shown.to_array().map(luminance));
            if light.max_element() > 1.0 {
                turned = turned.max(seen.angle_between(light).to_degrees());
            }
        }
        assert!(same > 1000 && white > 20, "sun {sun}: {same} below the knee, {white} above white");
        assert!(most.abs_diff(MOST) <= 1, "the disc has {most}");
        // Half a step of a signal is a part in ten thousand of its light, more in the darkest component.
        assert!(turned < 0.05 && turned > 0.0, "sun {sun}: {turned} degrees");
    }
}

#[test]
fn frames_are_pictures_of_16_bits_and_their_contact_sheet_is_one_of_8() {
    let folder = tempdir().unwrap();
    let line = "sequence --device cpu --size 32x16 --sun-elevation 10:30:10 --display rec2100-pq -o #.png";
    succeed(folder.path(), &line.split(' ').collect::<Vec<_>>());
    for frame in ["0.png", "1.png", "2.png"] {
        let zenith = read(&folder.path().join(frame))[0];
        assert!(zenith[2] > zenith[0] && zenith[0] > 10_000, "{frame}: {zenith:?}");
    }
    let [red, _, blue] = read_png(&folder.path().join("contact.png")).at(6, 6);
    assert!(red > 0 && blue > red);
}

#[test]
fn an_image_of_the_library_is_saved_in_high_dynamic_range_where_it_has_the_colours() {
    let folder = tempdir().unwrap();
    let mut scene = hdr();
    scene.camera.size = "16x8".parse().unwrap();
    let image = |scene: &Scene| sky_of(scene).image(&scene.camera, &mut Device::cpu()).unwrap();
    let refused = image(&scene).save(folder.path().join("a.png")).unwrap_err().to_string();
    assert!(refused.contains("rec2100-pq") && refused.contains("rec2020 would do"), "{refused}");
    scene.render.rgb = Rgb::Rec2020;
    image(&scene).save(folder.path().join("a.png")).unwrap();
    assert_eq!(read(&folder.path().join("a.png")).len(), 128);
}

#[test]
fn a_view_transform_and_a_target_of_8_bits_are_refused() {
    let mut scene = hdr();
    let sky = Sky::with_light_fields(&scene.validated().unwrap(), Rgb::Rec2020, &LightFields::default());
    let refused = Plan::seen(&sky, &scene.camera, PixelFormat::Picture).unwrap_err().to_string();
    assert!(refused.contains("render.display is rec2100-pq") && refused.contains("8 bits"), "{refused}");
    for view in [ViewTransform::Aces, ViewTransform::Srgb] {
        scene.render.view = view;
        let refused = scene.validated().unwrap_err().to_string();
        assert!(refused.contains("render.view") && refused.contains("no view transform"), "{refused}");
    }
}
