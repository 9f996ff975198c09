//! Environment maps in a program's own device: every level of a map, and its irradiance in spherical harmonics.

use sorairo::scene::{CameraScene, GroundAlbedo, Preset, Projection, Scene};
use sorairo::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};
use sorairo::{Device, EnvironmentTarget, Error, PixelFormat, Plan, ResidentRenderer, Sky};
use sorairo_shared::glam::{DVec3, Vec3, Vec4};
use sorairo_shared::math::half_bits;
use sorairo_shared::picture::environment::{Level, LevelStep, level_pixel, levels};
use sorairo_tests::gpu;
use sorairo_tests::own_device::{buffer, opened, opened_within, read, texels, texture, with_passthrough};
use sorairo_tests::sky::sky_of;

type OwnDevice = (wgpu::Device, wgpu::Queue);

/// Bytes of nine coefficients.
const HARMONICS: u64 = 144;

fn sky(sun: f64) -> Sky {
    let mut scene = Scene::preset(Preset::Standard);
    (scene.sun.elevation, scene.sun.azimuth) = (sun, 120.0);
    // Light from below, too.
    scene.ground.albedo = GroundAlbedo::Grey(0.3);
    sky_of(&scene)
}

/// The levels of a map, and its coefficients.
struct Drawn {
    levels: Vec<Vec<u32>>,
    harmonics: Vec<Vec4>,
}

fn map(device: &wgpu::Device, (width, height): (u32, u32), format: TextureFormat) -> wgpu::Texture {
    let count = levels(width, height, 1).count() as u32;
    texture(device, (width, height), count, format, TextureUsages::COPY_DST | TextureUsages::COPY_SRC)
}

fn draw(device: &OwnDevice, sky: &Sky, size: (u32, u32), format: TextureFormat) -> Drawn {
    draw_exposed(device, sky, size, format, 0.0)
}

fn draw_exposed((device, queue): &OwnDevice, sky: &Sky, size: (u32, u32), format: TextureFormat, stops: f32) -> Drawn {
    let mut renderer = ResidentRenderer::with_device(device, queue);
    renderer.set_linear_exposure(stops);
    let map = map(device, size, format);
    let harmonics = buffer(device, HARMONICS, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
    let mut encoder = device.create_command_encoder(&Default::default());
    let target = EnvironmentTarget { map: &map, harmonics: &harmonics };
    renderer.encode_environment(&mut encoder, sky, &target).unwrap();
    queue.submit([encoder.finish()]);
    let words = if format == TextureFormat::Rgba16Float { 2 } else { 4 };
    Drawn {
        levels: (0..map.mip_level_count()).map(|level| texels(device, queue, &map, level, words)).collect(),
        harmonics: bytemuck::pod_collect_to_vec(&read(device, queue, &harmonics)),
    }
}

fn floats(words: &[u32]) -> Vec<Vec4> {
    let float = |word: &u32| f32::from_bits(*word);
    words.chunks(4).map(|texel| Vec4::from_slice(&texel.iter().map(float).collect::<Vec<_>>())).collect()
}

/// The levels of a map as the CPU filters them.
fn filtered(first: &[Vec4], width: u32, height: u32) -> Vec<Vec<Vec4>> {
    let levels: Vec<Level> = levels(width, height, 1).collect();
    let last = levels.last().unwrap();
    let mut pixels = first.to_vec();
    pixels.resize((last.first + 1) as usize, Vec4::NAN);
    for pair in levels.windows(2) {
        let step = LevelStep { source: pair[0], target: pair[1] };
        for row in 0..step.target.height {
            (0..step.target.width).for_each(|column| level_pixel(&step, &mut pixels, column, row));
        }
    }
    let of_level = |level: &Level| {
        let from = level.first as usize;
        pixels[from..from + (level.width * level.height) as usize].to_vec()
    };
    levels.iter().map(of_level).collect()
}

/// Mean radiance over the sphere of a level, each row by its exact solid angle.
fn mean(pixels: &[Vec4], height: u32) -> [f64; 3] {
    let sine = |edge: u32| ((0.5 - f64::from(edge) / f64::from(height)) * std::f64::consts::PI).sin();
    let width = pixels.len() as u32 / height;
    let mut sum = [0.0; 3];
    for (index, pixel) in (0u32..).zip(pixels) {
        let row = index / width;
        let part = 0.5 * (sine(row) - sine(row + 1)) / f64::from(width);
        sum.iter_mut().zip(pixel.to_array()).for_each(|(sum, value)| *sum += part * f64::from(value));
    }
    sum
}

#[test]
fn a_map_is_the_renderers_image_and_its_levels_are_those_of_the_cpu() {
    let device = with_passthrough();
    // Halves of a power of two, and levels that share pixels.
    for (width, height) in [(128, 64), (100, 50), (61, 33)] {
        let sky = sky(25.0);
        let drawn = draw(&device, &sky, (width, height), TextureFormat::Rgba32Float);
        let size = format!("{width}x{height}").parse().unwrap();
        let camera = CameraScene { projection: Projection::Equirectangular, size, ..CameraScene::default() };
        let plan = Plan::seen(&sky, &camera, PixelFormat::LinearRgba).unwrap();
        assert!(drawn.levels[0] == gpu::backend().run(&plan, plan.kernel()).unwrap().words, "{size:?}");
        let expected = filtered(&floats(&drawn.levels[0]), width, height);
        assert_eq!(drawn.levels.len(), expected.len());
        for (level, (found, expected)) in drawn.levels.iter().zip(&expected).enumerate().skip(1) {
            for (found, expected) in floats(found).iter().zip(expected) {
                // The same function; a sum of a few products, each rounded in another place, level after level.
                assert!((*found - *expected).abs().max_element() <= 1e-5 * expected.max_element(), "{level}: {found}");
                assert_eq!(found.w, 1.0);
            }
        }
    }
}

#[test]
fn every_level_of_a_map_has_the_mean_radiance_of_its_first() {
    let device = with_passthrough();
    let drawn = draw(&device, &sky(25.0), (256, 128), TextureFormat::Rgba32Float);
    let expected = mean(&floats(&drawn.levels[0]), 128);
    assert!(expected.iter().all(|&channel| channel > 0.0));
    for (level, words) in drawn.levels.iter().enumerate() {
        let found = mean(&floats(words), (128 >> level).max(1));
        for (found, expected) in found.iter().zip(&expected) {
            // Single precision, and a GPU's division, for each of eight levels.
            assert!((found / expected - 1.0).abs() < 1e-5, "{level}: {found} {expected}");
        }
    }
    // Rows that all count alike have another mean: bright rows at the horizon are longer than those at the zenith.
    let alike: f64 = floats(&drawn.levels[0]).iter().map(|pixel| f64::from(pixel.x)).sum::<f64>() / (256.0 * 128.0);
    assert!((alike / expected[0] - 1.0).abs() > 1e-2, "{alike} {expected:?}");
}

/// The direction of a pixel of an octahedral map by the formula of `docs/environment-maps.md`.
fn octahedral(side: u32, at: usize) -> DVec3 {
    let place = |index: u32| 2.0 * (f64::from(index) + 0.5) / f64::from(side) - 1.0;
    let (east, north) = (place(at as u32 % side), -place(at as u32 / side));
    let up = 1.0 - east.abs() - north.abs();
    let unfolded = if up < 0.0 {
        DVec3::new((1.0 - east.abs()).copysign(north), -(1.0 - north.abs()).copysign(east), up)
    } else {
        DVec3::new(north, -east, up)
    };
    unfolded.normalize()
}

#[test]
fn an_octahedral_map_has_the_radiance_of_an_equirectangular_one() {
    const SIDE: u32 = 128;
    let sky = sky(25.0);
    let image = |projection, size: &str| {
        let camera = CameraScene { projection, size: size.parse().unwrap(), ..CameraScene::default() };
        sky.image(&camera, &mut Device::cpu()).unwrap().rgb
    };
    let map = image(Projection::Equirectangular, "256x128");
    let map: Vec<Vec4> = map.chunks(3).map(|rgb| Vec4::new(rgb[0], rgb[1], rgb[2], 1.0)).collect();
    let unfolded = image(Projection::Octahedral, "128x128");
    let (mut sum, mut whole) = (DVec3::ZERO, 0.0);
    for (at, rgb) in unfolded.chunks(3).enumerate() {
        let view = octahedral(SIDE, at);
        // The solid angle of a pixel, to its square: of a face of the octahedron as far away as it is there.
        let weight = 4.0 / f64::from(SIDE * SIDE) * view.abs().element_sum().powi(3);
        // A pixel whose centre is on the horizon is sky, and half of it is ground, of one colour from the ground.
        let is_on_horizon = view.z.abs() < 1e-9;
        let ground = &unfolded[..3];
        let light = [0, 1, 2].map(|i| f64::from(if is_on_horizon { 0.5 * (rgb[i] + ground[i]) } else { rgb[i] }));
        (sum, whole) = (sum + DVec3::from_array(light) * weight, whole + weight);
        if at % 97 == 0 {
            let expected = sky.plan().rgb_towards(view.as_vec3());
            let off = (Vec3::new(rgb[0], rgb[1], rgb[2]) - expected).abs().max_element() / expected.max_element();
            // What the sky lookup may be off.
            assert!(off < 4e-3, "{view}: {off}");
        }
    }
    assert!((whole / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3, "{whole}");
    for (found, expected) in (sum / whole).to_array().into_iter().zip(mean(&map, 128)) {
        // A pixel's centre stands for it.
        assert!((found / expected - 1.0).abs() < 3e-3, "{found} {expected}");
    }
}

#[test]
fn a_map_of_half_floats_is_the_same_map_rounded() {
    let device = with_passthrough();
    for size in [(128, 64), (50, 30)] {
        let [half, single] = [TextureFormat::Rgba16Float, TextureFormat::Rgba32Float]
            .map(|format| draw(&device, &sky(25.0), size, format));
        for (level, (half, single)) in half.levels.iter().zip(&single.levels).enumerate() {
            let rounded = floats(single).into_iter().flat_map(|pixel| {
                let [red, green, blue, alpha] = pixel.to_array().map(half_bits);
                [red | (green << 16), blue | (alpha << 16)]
            });
            assert!(rounded.eq(half.iter().copied()), "{size:?}, level {level}");
        }
        assert_eq!(half.harmonics, single.harmonics);
    }
}

#[test]
fn an_exposed_map_of_half_floats_keeps_the_light_of_the_suns_disc() {
    let device = with_passthrough();
    let mut scene = Scene::preset(Preset::Standard);
    (scene.sun.elevation, scene.sun.azimuth, scene.sun.disc) = (25.0, 120.0, true);
    let sky = sky_of(&scene);
    let size = (512, 256);
    let camera = CameraScene { size: "512x256".parse().unwrap(), ..CameraScene::default() };
    let stops = ResidentRenderer::exposure_of_halves(&sky, &camera).unwrap();
    assert!(stops < 0.0 && stops % 1.0 == 0.0, "{stops}");
    let single = draw(&device, &sky, size, TextureFormat::Rgba32Float);
    let light = mean(&floats(&single.levels[0]), 256);
    let halves = |words: &[u32]| {
        let value = |bits: u32| exr::prelude::f16::from_bits(bits as u16).to_f32();
        let texel = |words: &[u32]| Vec4::from_array([words[0], words[0] >> 16, words[1], words[1] >> 16].map(value));
        words.chunks(2).map(texel).collect::<Vec<_>>()
    };
    let part = |drawn: &Drawn, level: usize, stops: f32| {
        let found = mean(&halves(&drawn.levels[level]), 256 >> level);
        std::array::from_fn::<f64, 3, _>(|i| found[i] / f64::from(stops.exp2()) / light[i])
    };
    // The sun sends several times the light of the sky, and its pixels end at 65504.
    let cut = part(&draw(&device, &sky, size, TextureFormat::Rgba16Float), 0, 0.0);
    assert!(cut.iter().all(|&part| part < 0.6), "{cut:?}");
    let exposed = draw_exposed(&device, &sky, size, TextureFormat::Rgba16Float, stops);
    for level in 0..9 {
        // A half float has 11 bits, so that each pixel is right to 2⁻¹¹.
        let found = part(&exposed, level, stops);
        assert!(found.iter().all(|part| (part - 1.0).abs() < 5e-4), "{level}: {found:?}");
        assert!(halves(&exposed.levels[level]).iter().all(|pixel| pixel.w == 1.0));
    }
    for (exposed, single) in exposed.harmonics.iter().zip(&single.harmonics) {
        // Every number of the sums is smaller by the same power of two.
        assert_eq!(*exposed, *single * stops.exp2());
    }
}

#[test]
fn an_exposure_scales_what_is_linear_and_leaves_pictures_as_they_are() {
    use sorairo::low_level::device::Backend;
    use sorairo::low_level::device::cpu::Cpu;
    use sorairo::scene::{ColourPath, Fit, PathChoice};
    for (fit, color, path) in [
        (Fit::Regression, ColourPath::Folded, PathChoice::Lookup),
        (Fit::Regression, ColourPath::Folded, PathChoice::Direct),
        (Fit::Transfer, ColourPath::Folded, PathChoice::Lookup),
        (Fit::Cubic, ColourPath::Solve, PathChoice::Direct),
    ] {
        let mut scene = Scene::preset(Preset::Standard);
        (scene.sun.elevation, scene.sun.disc, scene.camera.size) = (20.0, true, "64x32".parse().unwrap());
        (scene.render.fit, scene.render.color, scene.render.path) = (fit, color, path);
        let scene = scene.validated().unwrap();
        let words = |pixel, stops| {
            let plan = Plan::new(&scene, pixel).exposed(stops);
            Cpu.run(&plan, plan.kernel()).unwrap().words
        };
        assert!(words(PixelFormat::Picture, -6.0) == words(PixelFormat::Picture, 0.0), "{fit:?}");
        let [plain, exposed] = [0.0, -6.0].map(|stops| words(PixelFormat::LinearRgb, stops));
        let is_scaled = |(plain, exposed): (&u32, &u32)| f32::from_bits(*plain) / 64.0 == f32::from_bits(*exposed);
        assert!(plain.iter().any(|&word| word != 0) && plain.iter().zip(&exposed).all(is_scaled), "{fit:?}");
    }
}

#[test]
fn the_harmonics_of_a_map_are_those_that_the_command_prints() {
    let device = with_passthrough();
    for sun in [60.0, 25.0, -3.0] {
        let sky = sky(sun);
        let drawn = draw(&device, &sky, (512, 256), TextureFormat::Rgba16Float);
        let expected = sky.light().irradiance_harmonics_rgb.coefficients;
        let largest = expected[0].map(f64::abs);
        for (which, (found, expected)) in drawn.harmonics.iter().zip(&expected).enumerate() {
            for channel in 0..3 {
                let error = (f64::from(found[channel]) - expected[channel]).abs() / largest[channel];
                println!("sun at {sun}, {which}, {channel}: {error:.1e}");
                // The command's nodes are good to 1e-3 (see its own test); found: 2e-4.
                assert!(error < 1e-3, "sun at {sun}, coefficient {which}: {found} {expected:?}");
            }
            assert_eq!(found.w, 0.0);
        }
        // The sun stands in the east-south-east: the light comes from there, not from where it is mirrored.
        let towards_sun = Vec3::new(-0.5, -0.75f32.sqrt(), 0.0);
        let level = Vec3::new(drawn.harmonics[3].y, drawn.harmonics[1].y, 0.0);
        assert!(level.normalize().dot(towards_sun) > 0.99, "{level}");
    }
}

#[test]
fn a_night_has_a_black_map_and_no_irradiance() {
    let device = with_passthrough();
    let drawn = draw(&device, &sky(-60.0), (32, 16), TextureFormat::Rgba32Float);
    assert!(drawn.levels.iter().flat_map(|words| floats(words)).all(|pixel| pixel == Vec4::W));
    assert!(drawn.harmonics.iter().all(|coefficient| *coefficient == Vec4::ZERO));
}

#[test]
fn a_device_that_passes_nothing_through_makes_the_same_map() {
    let [passed, translated] = [with_passthrough(), opened(wgpu::Features::empty())]
        .map(|device| draw(&device, &sky(25.0), (64, 32), TextureFormat::Rgba32Float));
    let near = |found: Vec4, expected: Vec4| {
        // Another compiler orders the same sums in another way; as for an image.
        assert!((found - expected).abs().max_element() <= 2e-4 * expected.abs().max_element(), "{found} {expected}");
    };
    for (found, expected) in translated.levels.iter().zip(&passed.levels) {
        floats(found).into_iter().zip(floats(expected)).for_each(|(found, expected)| near(found, expected));
    }
    let largest = passed.harmonics[0];
    for (found, expected) in translated.harmonics.iter().zip(&passed.harmonics) {
        assert!((*found - *expected).abs().max_element() <= 2e-4 * largest.max_element(), "{found} {expected}");
    }
}

#[test]
fn maps_are_encoded_beside_images_and_one_after_the_other() {
    let (device, queue) = &with_passthrough();
    let mut renderer = ResidentRenderer::with_device(device, queue);
    let (high, low) = (sky(40.0), sky(3.0));
    let maps = [(64, 32), (64, 32), (32, 16)].map(|size| map(device, size, TextureFormat::Rgba32Float));
    let harmonics = [(); 3].map(|()| buffer(device, HARMONICS, BufferUsages::STORAGE | BufferUsages::COPY_SRC));
    let image = buffer(device, 12 * 60 * 30, BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC);
    let camera =
        CameraScene { projection: Projection::Perspective, size: "60x30".parse().unwrap(), ..CameraScene::default() };
    let mut encoder = device.create_command_encoder(&Default::default());
    for (sky, (map, harmonics)) in [&high, &low, &high].into_iter().zip(maps.iter().zip(&harmonics)) {
        renderer.encode_environment(&mut encoder, sky, &EnvironmentTarget { map, harmonics }).unwrap();
        let target = sorairo::Target::Buffer(&image, PixelFormat::LinearRgb);
        renderer.encode(&mut encoder, sky, &camera, &target).unwrap();
    }
    queue.submit([encoder.finish()]);
    let own = (device.clone(), queue.clone());
    for (index, (sky, size)) in [(&high, (64, 32)), (&low, (64, 32)), (&high, (32, 16))].into_iter().enumerate() {
        let alone = draw(&own, sky, size, TextureFormat::Rgba32Float);
        let coefficients: Vec<Vec4> = bytemuck::pod_collect_to_vec(&read(device, queue, &harmonics[index]));
        assert!(alone.harmonics == coefficients, "{index}");
        for (level, expected) in (0..).zip(&alone.levels) {
            assert!(*expected == texels(device, queue, &maps[index], level, 4), "{index}, level {level}");
        }
    }
    let plan = Plan::seen(&high, &camera, PixelFormat::LinearRgb).unwrap();
    assert!(read(device, queue, &image) == gpu::backend().run(&plan, plan.kernel()).unwrap().words);
}

#[test]
fn a_map_is_whole_after_one_whose_encoder_was_dropped() {
    let own = with_passthrough();
    let (device, queue) = &own;
    let mut renderer = ResidentRenderer::with_device(device, queue);
    let (sky, map) = (sky(40.0), map(device, (64, 32), TextureFormat::Rgba32Float));
    let harmonics = buffer(device, HARMONICS, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
    for is_submitted in [false, true] {
        let mut encoder = device.create_command_encoder(&Default::default());
        let target = EnvironmentTarget { map: &map, harmonics: &harmonics };
        renderer.encode_environment(&mut encoder, &sky, &target).unwrap();
        if is_submitted {
            queue.submit([encoder.finish()]);
        }
    }
    let alone = draw(&own, &sky, (64, 32), TextureFormat::Rgba32Float);
    for (level, expected) in (0..).zip(&alone.levels) {
        assert!(*expected == texels(device, queue, &map, level, 4), "level {level}");
    }
}

#[test]
fn a_wrong_target_is_refused_before_anything_is_encoded() {
    let (device, queue) = &with_passthrough();
    let mut renderer = ResidentRenderer::with_device(device, queue);
    let both = TextureUsages::COPY_DST | TextureUsages::COPY_SRC;
    let map = |levels, format, usage| texture(device, (64, 32), levels, format, usage);
    let good = map(7, TextureFormat::Rgba16Float, both);
    let storage = buffer(device, HARMONICS, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
    let small = buffer(device, 100, BufferUsages::STORAGE);
    let unusable = buffer(device, HARMONICS, BufferUsages::COPY_DST);
    let packed = map(7, TextureFormat::Rgba8Unorm, both);
    let few = map(3, TextureFormat::Rgba16Float, both);
    let fixed = map(7, TextureFormat::Rgba32Float, TextureUsages::TEXTURE_BINDING);
    let size = wgpu::Extent3d { width: 64, height: 32, depth_or_array_layers: 6 };
    let layered = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 7,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: TextureFormat::Rgba16Float,
        usage: both,
        view_formats: &[],
    });
    let sky = sky(20.0);
    for (map, harmonics, words) in [
        (&packed, &storage, "the format Rgba8Unorm; an environment map has Rgba16Float or Rgba32Float"),
        (&few, &storage, "a texture of 3 levels; an environment map of 64x32 has 7"),
        (&fixed, &storage, "without the usage COPY_DST"),
        (&layered, &storage, "several layers"),
        (&good, &small, "a buffer of 100 bytes; nine coefficients take 144"),
        (&good, &unusable, "a buffer without the usage STORAGE"),
    ] {
        let mut encoder = device.create_command_encoder(&Default::default());
        let refused =
            renderer.encode_environment(&mut encoder, &sky, &EnvironmentTarget { map, harmonics }).unwrap_err();
        assert!(matches!(refused, Error::Target(_)) && refused.to_string().contains(words), "{refused}");
        // The encoder holds nothing that a queue would refuse.
        queue.submit([encoder.finish()]);
    }
    let mut encoder = device.create_command_encoder(&Default::default());
    let target = EnvironmentTarget { map: &good, harmonics: &storage };
    renderer.encode_environment(&mut encoder, &sky, &target).unwrap();
    queue.submit([encoder.finish()]);
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    assert!(read(device, queue, &storage).iter().any(|&word| word != 0));
}

#[test]
fn a_map_beyond_a_limit_is_refused_and_the_device_makes_a_smaller_one() {
    let own = opened_within(wgpu::Features::PASSTHROUGH_SHADERS, |limits| wgpu::Limits {
        max_storage_buffer_binding_size: 1 << 20,
        ..limits
    });
    let encoded = |size| {
        let (device, queue) = &own;
        let map = map(device, size, TextureFormat::Rgba32Float);
        let harmonics = buffer(device, HARMONICS, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        let mut encoder = device.create_command_encoder(&Default::default());
        let target = EnvironmentTarget { map: &map, harmonics: &harmonics };
        let done = ResidentRenderer::with_device(device, queue).encode_environment(&mut encoder, &sky(20.0), &target);
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        done
    };
    // Its first level alone takes 2 MB.
    let refused = encoded((512, 256)).unwrap_err();
    assert!(matches!(&refused, Error::Device(told) if told.contains("limits")), "{refused}");
    encoded((64, 32)).unwrap();
}
