//! The light of sun and sky over altitudes and suns: against surfaces and the sun's beam at places between its nodes,
//! and in a program's own textures.

use std::sync::LazyLock;

use sorairo::low_level::spectra::observer;
use sorairo::scene::{Preset, Rgb, Scene};
use sorairo::wgpu::{self, TextureFormat, TextureUsages};
use sorairo::{LightFields, LightTable, LightTextures, ResidentRenderer, Sky, Surface};
use sorairo_shared::glam::DVec3;
use sorairo_tests::own_device::{texels_of_layer, with_passthrough};
use sorairo_tests::sky::sky_of;

/// The top of the table (km).
const TOP: f64 = 20.0;

fn scene() -> Scene {
    Scene::preset(Preset::Standard)
}

/// The table, made once for all tests of a process.
fn table() -> &'static LightTable {
    static TABLE: LazyLock<LightTable> = LazyLock::new(|| {
        LightTable::new(&scene().validated().unwrap(), Rgb::Srgb, TOP, &LightFields::default()).unwrap()
    });
    &TABLE
}

fn sky(altitude: f64, sun: f64) -> Sky {
    let mut scene = scene();
    (scene.observer.altitude, scene.sun.elevation, scene.sun.azimuth) = (altitude, sun, 0.0);
    sky_of(&scene)
}

/// The largest difference of two colours, relative to the brightest channel of the second.
fn difference(found: [f64; 3], expected: [f64; 3]) -> f64 {
    let brightest = expected.into_iter().fold(0.0, f64::max);
    let off = found.into_iter().zip(expected).map(|(a, b)| (a - b).abs() / brightest);
    off.fold(0.0, |most, error| if error.is_nan() || error > most { error } else { most })
}

#[test]
fn between_its_nodes_a_table_of_light_is_that_of_surfaces_and_of_the_suns_beam() {
    // Five in each step of the observer: sunlight has lines.
    let around = |nm: f64| [-2.0, -1.0, 0.0, 1.0, 2.0].map(|beside| nm + beside);
    let wavelengths: Vec<f64> = observer::wavelengths().into_iter().flat_map(around).collect();
    let rgb = |sky: &Sky, spectrum: &[f64]| {
        let steps: Vec<f64> = spectrum.chunks(5).map(|five| five.iter().sum::<f64>() / 5.0).collect();
        sky.plan()
            .space
            .into_gamut(sky.plan().space.from_xyz * observer::xyz_of_samples(sky.plan().observer, &steps))
            .to_array()
    };
    let (mut direct_worst, mut diffuse_worst, mut harmonics_worst) = (0.0f64, 0.0f64, 0.0f64);
    for (altitude, sun) in [(0.0, 71.0), (0.4, 33.0), (1.3, 12.3), (0.05, 4.4), (3.3, 2.2), (7.0, 52.0), (15.0, 21.0)] {
        let (sky, light) = (sky(altitude, sun), table().at(altitude, sun));
        let through = sky.transmittance(&wavelengths).unwrap();
        let optics = sky.scene().optics();
        let beam: Vec<f64> = wavelengths.iter().zip(through).map(|(&nm, t)| t * optics.solar_irradiance(nm)).collect();
        let fallen = sky.irradiance(&[Surface::default()], &wavelengths).unwrap().remove(0);
        let errors =
            [difference(light.direct, rgb(&sky, &beam)), difference(light.diffuse, rgb(&sky, &fallen.diffuse))];
        // Of a surface that faces the sun, and of one that turns its back.
        let expected = sky.light().irradiance_harmonics_rgb;
        let of_harmonics = [DVec3::X, -DVec3::X, DVec3::Z, DVec3::new(0.6, 0.0, -0.8)]
            .map(|normal| difference(light.nine_harmonics().towards(normal), expected.towards(normal)));
        let of_harmonics = of_harmonics.into_iter().fold(0.0, f64::max);
        println!("{altitude} km, sun at {sun}: direct and diffuse {errors:.5?}, harmonics {of_harmonics:.5}");
        direct_worst = direct_worst.max(errors[0]);
        diffuse_worst = diffuse_worst.max(errors[1]);
        harmonics_worst = harmonics_worst.max(of_harmonics);
    }
    // What the table is to be good for.
    for (worst, bound) in [(direct_worst, 0.005), (diffuse_worst, 0.005), (harmonics_worst, 0.005)] {
        assert!(worst < bound, "{direct_worst}, {diffuse_worst}, {harmonics_worst}");
    }
}

#[test]
fn in_twilight_a_table_of_light_is_near_to_that_of_the_sky() {
    for (altitude, sun) in [(0.1, 0.3), (0.0, -3.1), (2.0, -5.7), (10.0, -8.8)] {
        let (expected, light) = (sky(altitude, sun).light(), table().at(altitude, sun));
        let off = difference(light.diffuse, expected.irradiance_rgb);
        println!("{altitude} km, sun at {sun}: {off:.5}");
        // Light falls by half within a degree there, and skies are planned a degree apart.
        assert!(off < 0.01, "{altitude} km, {sun}: {off}");
    }
    let night = table().at(0.0, -30.0);
    assert!(night.diffuse.iter().all(|light| *light < 1e-6) && night.direct == [0.0; 3], "{night:?}");
}

fn texture(device: &wgpu::Device, layers: u32, format: TextureFormat) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: LightTable::COLUMNS, height: LightTable::ROWS, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: TextureUsages::COPY_DST | TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

#[test]
fn a_program_finds_the_light_in_its_textures() {
    let (device, queue) = with_passthrough();
    let mut renderer = ResidentRenderer::with_device(&device, &queue);
    renderer.set_linear_exposure(-2.0);
    let of = |layers| texture(&device, layers, TextureFormat::Rgba16Float);
    let (direct, diffuse, harmonics) = (of(1), of(1), of(6));
    let textures = LightTextures { direct: &direct, diffuse: &diffuse, harmonics: &harmonics };
    renderer.write_light(table(), &textures).unwrap();
    let half = |bits: u32| f64::from(exr::prelude::f16::from_bits(bits as u16).to_f32());
    let mut signs = [false; 2];
    for (texture, layer) in [(&direct, 0), (&diffuse, 0)].into_iter().chain((0..6).map(|layer| (&harmonics, layer))) {
        let words = texels_of_layer(&device, &queue, texture, (0, layer), 2);
        for (words, light) in words.chunks(2).zip(table().texels()) {
            let expected = if texture == &direct {
                light.direct
            } else if texture == &diffuse {
                light.diffuse
            } else {
                light.harmonics[layer as usize]
            };
            let found = [half(words[0] & 0xffff), half(words[0] >> 16), half(words[1] & 0xffff)];
            for (found, expected) in found.into_iter().zip(expected) {
                // Half a step of a half float, whose smallest is 6e-8.
                assert!((found - expected / 4.0).abs() <= 5e-4 * found.abs() + 6e-8, "{found} {expected}");
                signs[usize::from(found < 0.0)] = true;
            }
        }
    }
    assert_eq!(signs, [true; 2]);
    let (small, other) = (of(5), texture(&device, 1, TextureFormat::Rgba32Float));
    let refused = |textures: LightTextures<'_>| renderer.write_light(table(), &textures).unwrap_err().to_string();
    assert!(refused(LightTextures { harmonics: &small, ..textures }).contains("256x64 in 5 layers"));
    assert!(refused(LightTextures { direct: &other, ..textures }).contains("light has Rgba16Float"));
}

#[test]
fn a_table_that_cannot_be_made_is_refused() {
    let scene = scene().validated().unwrap();
    for top in [0.0, 2000.0, f64::NAN] {
        let error = LightTable::new(&scene, Rgb::Srgb, top, &LightFields::default()).unwrap_err().to_string();
        assert!(error.starts_with("top is "), "{error}");
    }
}
