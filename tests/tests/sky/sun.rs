//! The sun's disc, and its light through the air.

use std::path::Path;

use sorairo::low_level::device::{self, Backend};
use sorairo::low_level::plan::picture::sun_disc::Sun;
use sorairo::low_level::spectra::table_file::TableFile;
use sorairo::scene::{ColourPath, Fit, OzoneCrossSection, PathChoice, Preset, Projection, Scene, SunSpectrum};
use sorairo::{PixelFormat, Plan};
use sorairo_evaluation::judge::{coefficients, medium};
use sorairo_oracle::column_to_top;
use sorairo_shared::camera::{EQUIRECTANGULAR, FISHEYE, OCTAHEDRAL, PERSPECTIVE, solid_angle_density};
use sorairo_shared::glam::{DVec3, Vec2};
use sorairo_tests::compare::worst_in_images;
use sorairo_tests::gpu;
use sorairo_tests::sky::{plan_of, scene, sky_of};

fn plan(scene: &Scene) -> Plan {
    plan_of(scene, PixelFormat::LinearRgb)
}

fn image(scene: &Scene, backend: &dyn Backend) -> Vec<f32> {
    let plan = plan(scene);
    let words = backend.run(&plan, plan.kernel()).expect("an image").words;
    words.into_iter().map(f32::from_bits).collect()
}

/// What the disc adds to an image, summed over the solid angles of its pixels (W·m⁻²).
fn energy(scene: &Scene) -> DVec3 {
    let mut without = scene.clone();
    without.sun.disc = false;
    let camera = plan(scene).uniform.camera;
    let [width, height] = [camera.width, camera.height].map(f64::from);
    let (projection, scale) = match scene.camera.projection {
        Projection::Equirectangular => (EQUIRECTANGULAR, std::f64::consts::TAU / width * std::f64::consts::PI / height),
        Projection::Fisheye => (FISHEYE, (2.0 * f64::from(camera.half_field) / width.min(height)).powi(2)),
        Projection::Octahedral => (OCTAHEDRAL, 4.0 / (width * height)),
        _ => (PERSPECTIVE, (2.0 * f64::from(camera.half_field) / width).powi(2)),
    };
    let [with, without] = [scene, &without].map(|scene| image(scene, &device::cpu::Cpu));
    let pixels = with.chunks(3).zip(without.chunks(3)).enumerate();
    pixels
        .map(|(i, (a, b))| {
            let (column, row) = (i as u32 % camera.width, i as u32 / camera.width);
            let centre = Vec2::new(column as f32 + 0.5, row as f32 + 0.5);
            let solid_angle = scale * f64::from(solid_angle_density(&camera, projection, centre));
            DVec3::from_array(std::array::from_fn(|i| f64::from(a[i]) - f64::from(b[i]))) * solid_angle
        })
        .sum()
}

fn with_disc(elevation: f64, size: &str) -> Scene {
    let mut scene = scene(Preset::Earth, elevation, size);
    scene.sun.disc = true;
    scene
}

fn assert_holds_the_suns_light(scene: &Scene, place: &str) {
    let expected = DVec3::from_array(plan(scene).sky.light().sun_irradiance_rgb);
    let error = ((energy(scene) - expected) / expected.max_element()).abs().max_element();
    // Some fifty samples across the disc, sixteen places in the disc's grid either way; coarse pixels far from where a
    // projection's density is level add up to half a per cent.
    assert!(error < 0.01, "{place}: {error:.1e}");
    println!("{place}: {error:.1e}");
}

#[test]
fn an_image_holds_the_energy_of_the_disc_at_any_resolution() {
    for elevation in [0.0, 0.2, 3.0, 40.0, 89.9, 90.0] {
        for (size, azimuth) in [("64x32", -179.9), ("200x100", 33.3), ("1024x512", 0.0)] {
            let mut scene = with_disc(elevation, size);
            scene.sun.azimuth = azimuth;
            assert_holds_the_suns_light(&scene, &format!("equirectangular {size}, sun at {elevation}, {azimuth}"));
        }
    }
    for (sun, azimuth) in [(50.0, 33.3), (1.0, 0.0), (0.2, 45.0), (89.9, 10.0)] {
        let mut scene = with_disc(sun, "128x128");
        (scene.camera.projection, scene.sun.azimuth) = (Projection::Octahedral, azimuth);
        assert_holds_the_suns_light(&scene, &format!("octahedral, sun at {sun}, {azimuth}"));
    }
    for (projection, fov, size) in [
        (Projection::Fisheye, 180.0, "40x40"),
        (Projection::Fisheye, 180.0, "700x500"),
        (Projection::Fisheye, 2.0, "300x300"),
        (Projection::Perspective, 60.0, "30x20"),
        (Projection::Perspective, 60.0, "640x360"),
        (Projection::Perspective, 1.0, "400x400"),
    ] {
        let mut scene = with_disc(35.0, size);
        scene.camera.projection = projection;
        scene.camera.fov = Some(fov);
        scene.camera.look_elevation = Some(if fov < 5.0 { 35.0 } else { 50.0 });
        scene.camera.look_azimuth = Some(0.0);
        assert_holds_the_suns_light(&scene, &format!("{projection:?} {fov} {size}"));
    }
}

#[test]
fn the_disc_is_the_same_on_the_gpu_and_by_every_way_to_a_colour() {
    for (fit, color, path) in [
        (Fit::Regression, ColourPath::Folded, PathChoice::Lookup),
        (Fit::Regression, ColourPath::Folded, PathChoice::Direct),
        (Fit::Regression, ColourPath::Solve, PathChoice::Direct),
        (Fit::Cubic, ColourPath::Solve, PathChoice::Direct),
        (Fit::Transfer, ColourPath::Folded, PathChoice::Direct),
    ] {
        let mut scene = with_disc(20.0, "256x128");
        scene.camera.projection = Projection::Perspective;
        (scene.camera.fov, scene.camera.look_elevation) = (Some(3.0), Some(20.0));
        (scene.render.fit, scene.render.color, scene.render.path) = (fit, color, path);
        let [on_gpu, on_cpu] = [gpu::backend(), &device::cpu::Cpu].map(|backend| image(&scene, backend));
        let brightest = on_cpu.iter().copied().fold(0.0, sorairo_shared::math::max);
        assert!(brightest > 1e4, "{brightest}");
        let mut differing = 0;
        for (a, b) in on_gpu.chunks(3).zip(on_cpu.chunks(3)) {
            let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, sorairo_shared::math::max);
            assert!(apart.is_finite());
            // A sample on the very edge may fall to either side of it: one in n² of a pixel's.
            differing += u32::from(apart > 1e-3 * brightest);
        }
        assert!(differing < 40, "{fit:?} {color:?} {path:?}: {differing} pixels");
        let worst = worst_in_images(&on_gpu, &on_cpu, 256, 3, 1e-6);
        assert!(worst.relative < 0.3, "{worst:?}");
    }
}

#[test]
fn sunlight_is_weakened_by_the_optical_depth_of_the_oracle() {
    for (elevation, altitude) in [(90.0, 0.0), (30.0, 0.0), (5.0, 2.0), (1.0, 0.0), (-1.0, 12.0)] {
        let mut scene = scene(Preset::Earth, elevation, "8x4");
        scene.observer.altitude = altitude;
        // A sun small enough that the air in front of it is the same all over.
        scene.sun.distance = 50.0;
        let outside = |scene: &Scene| {
            let mut scene = scene.clone();
            (scene.observer.altitude, scene.sun.elevation) = (1e4, 45.0);
            DVec3::from_array(plan(&scene).sky.light().sun_irradiance_rgb)
        };
        let weakened = DVec3::from_array(plan(&scene).sky.light().sun_irradiance_rgb);
        let expected = {
            let column = column_to_top(&medium(&scene), altitude, elevation.to_radians().sin());
            let plan = plan(&scene);
            let transmittance = |nm: f64| {
                let c = coefficients(&scene, nm);
                let depth =
                    c.air_scattering * column[0] + c.aerosol_extinction * column[1] + c.ozone_absorption * column[2];
                (-depth).exp()
            };
            let xyz = sorairo::low_level::spectra::observer::xyz(plan.sky.plan().observer, |nm| {
                plan.sky.plan().base.optics.solar_irradiance(nm) * transmittance(nm)
            });
            plan.sky.plan().space.into_gamut(plan.sky.plan().space.from_xyz * xyz)
        };
        let error = ((weakened - expected) / expected.max_element()).abs().max_element();
        // The column in closed form has 1e-5 of an optical depth of up to some ten; 50 au are not infinitely far.
        assert!(error < 2e-3, "{elevation}, {altitude}: {weakened} instead of {expected}, {error:.1e}");
        assert!(weakened.max_element() < outside(&scene).max_element());
    }
}

#[test]
fn more_air_never_makes_the_sun_brighter() {
    let brightness = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene(Preset::Earth, 10.0, "8x4");
        change(&mut scene);
        sky_of(&scene).plan().sun_irradiance().facing
    };
    let falls = |values: Vec<f64>, what: &str| {
        assert!(values.iter().all(|value| value.is_finite() && *value >= 0.0), "{what}: {values:?}");
        assert!(values.windows(2).all(|pair| pair[1] < pair[0] || pair == [0.0, 0.0]), "{what}: {values:?}");
        assert!(values[0] > 1.0, "{what}: {values:?}");
    };
    let factors: Vec<f64> = (0..=70).map(|i| 1e-4 * 10f64.powf(f64::from(i) / 10.0)).collect();
    let over = |change: &dyn Fn(&mut Scene, f64)| -> Vec<f64> {
        factors.iter().map(|&factor| brightness(&|scene| change(scene, factor))).collect()
    };
    falls(over(&|scene, factor| scene.atmosphere.air.scattering *= factor), "air");
    falls(over(&|scene, factor| scene.atmosphere.aerosol.optical_depth = 0.1 * factor), "aerosol");
    falls(over(&|scene, factor| scene.atmosphere.ozone.column = 1.9 * factor), "ozone");
    let lower: Vec<f64> = (0..=90).map(|i| brightness(&|scene| scene.sun.elevation = 90.0 - f64::from(i))).collect();
    falls(lower, "a lower sun");
}

#[test]
fn the_ground_hides_the_sun_and_the_limb_is_darker_than_the_centre() {
    let mut scene = with_disc(0.0, "100x100");
    scene.camera.projection = Projection::Perspective;
    (scene.camera.fov, scene.camera.look_elevation) = (Some(1.0), Some(0.0));
    let half = image(&scene, &device::cpu::Cpu);
    let bright = |row: usize| half[3 * (100 * row + 50)] > 1.0;
    assert!((30..49).all(bright) && !(50..100).any(bright));

    scene.sun.elevation = 60.0;
    scene.camera.look_elevation = Some(60.0);
    let disc = image(&scene, &device::cpu::Cpu);
    let at = |column: usize| &disc[3 * (50 * 100 + column)..][..3];
    // 0.2666 degrees are 26.7 pixels.
    let (centre, limb) = (at(50), at(75));
    assert!(limb[1] < 0.75 * centre[1] && limb[1] > 0.3 * centre[1], "{centre:?} {limb:?}");
    assert!(limb[2] / centre[2] < limb[0] / centre[0], "the limb is not redder");
    assert!(at(78)[1] < 1e-3 * centre[1]);
}

#[test]
fn a_disc_beyond_what_a_file_can_hold_is_refused() {
    let request = |name: &str| sorairo::Request { outputs: vec![name.into()], ..Default::default() };
    let mut scene = with_disc(30.0, "8x4");
    let folder = tempfile::tempdir().unwrap();
    let refused = |scene: &Scene, name: &str, named: &str| {
        let path = folder.path().join(name);
        let request = request(&path.display().to_string());
        match scene
            .validated()
            .and_then(|scene| sorairo::low_level::render::Job::new(&scene, &request, &sorairo::LightFields::default()))
        {
            Err(error) => assert!(error.to_string().contains(named), "{error}"),
            Ok(_) => panic!("{name} is not refused"),
        }
    };
    refused(&scene, "a.spectral.exr", "sun.disc");
    scene.sun.distance = 60.0;
    refused(&scene, "a.exr", "50");
}

/// Elevation of the sun (degrees) and the red of its irradiance on a surface that faces it, over the standard scene
/// with the ozone of the references: the double integral over the part of the disc that the ground does not hide,
/// computed apart from the program.
const SUNSET: [(f64, f64); 32] = [
    (-0.268, 0.0),
    (-0.256, 0.0012315),
    (-0.244, 0.0044495),
    (-0.232, 0.0091335),
    (-0.22, 0.015164),
    (-0.208, 0.022462),
    (-0.196, 0.030976),
    (-0.184, 0.04067),
    (-0.172, 0.051519),
    (-0.16, 0.0635),
    (-0.148, 0.076598),
    (-0.136, 0.090799),
    (-0.124, 0.10609),
    (-0.112, 0.12247),
    (-0.1, 0.13992),
    (-0.088, 0.15843),
    (-0.076, 0.17814),
    (-0.064, 0.19876),
    (-0.052, 0.22041),
    (-0.04, 0.2431),
    (-0.028, 0.2668),
    (-0.016, 0.29151),
    (-0.004, 0.31721),
    (0.008, 0.3439),
    (0.02, 0.37155),
    (0.032, 0.40015),
    (0.044, 0.42969),
    (0.056, 0.46013),
    (0.068, 0.49146),
    (0.08, 0.52365),
    (0.092, 0.55681),
    (0.104, 0.59063),
];

#[test]
fn the_light_of_a_setting_sun_fades_as_its_disc_sets() {
    let ozone = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/data/ozone_cross_section_of_the_references.csv"));
    let red = |elevation: f64| {
        let mut scene = Scene::preset(Preset::Standard).in_closed_form();
        (scene.sun.elevation, scene.sun.spectrum) = (elevation, SunSpectrum::AstmG173);
        scene.atmosphere.ozone.cross_section = OzoneCrossSection::File(TableFile::read(ozone).unwrap());
        Sun::new(plan(&scene).sky.plan()).irradiance().rgb.x
    };
    let whole = red(0.3);
    let (mut before, mut worst, mut compared) = (0.0, 0.0f64, 0);
    for (elevation, truth) in SUNSET {
        let red = red(elevation);
        println!("{elevation}: {red:.6}, {:+.2} %", 100.0 * (red / truth - 1.0));
        assert!(red >= before && red.is_finite(), "{elevation}: {red} after {before}");
        before = red;
        // The light of a thinner sliver, of a hundredth of a degree, hangs on the fourth digit of the sun's radius.
        if truth > 2e-3 * whole {
            worst = worst.max((red / truth - 1.0).abs());
            compared += 1;
        }
    }
    assert!(compared > 25 && worst < 0.01, "{worst}");
}
