//! The sky in a program's own device: encoded into its commands, in its buffers and textures.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use sorairo::low_level::plan::{Plan, SkyPlan};
use sorairo::scene::{CameraScene, Preset, Projection, Rgb, Scene};
use sorairo::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};
use sorairo::{EnvironmentTarget, Error, LightFields, PixelFormat, ResidentRenderer, Sky, Target};
use sorairo_tests::compare::worst_in_images;
use sorairo_tests::own_device::{
    buffer, opened, opened_within, read, texels, texels_of_layer, texture, with_passthrough,
};
use sorairo_tests::sky::sky_of;
use sorairo_tests::{gpu, program, wait};

fn sky(sun: f64) -> Sky {
    let mut scene = Scene::preset(Preset::Standard);
    scene.sun.elevation = sun;
    sky_of(&scene)
}

/// Cameras whose rows a copy does and does not have to align.
fn cameras() -> Vec<CameraScene> {
    let camera = |projection, size: &str| {
        let size = size.parse().unwrap();
        CameraScene { projection, size, ..CameraScene::default() }
    };
    vec![
        camera(Projection::Equirectangular, "128x64"),
        camera(Projection::Equirectangular, "100x50"),
        camera(Projection::Fisheye, "60x60"),
        CameraScene { look_azimuth: Some(100.0), ..camera(Projection::Perspective, "90x45") },
        CameraScene { look_azimuth: Some(-80.0), ..camera(Projection::Perspective, "90x45") },
        // Wide enough for runs.
        CameraScene { look_azimuth: Some(60.0), ..camera(Projection::Perspective, "640x352") },
        CameraScene { shift_x: 0.3, shift_y: -0.1, ..camera(Projection::Perspective, "640x352") },
        CameraScene { roll: 25.0, ..camera(Projection::Perspective, "90x45") },
    ]
}

/// What the program's renderer makes of the same sky and camera.
fn expected(sky: &Sky, camera: &CameraScene, pixel: PixelFormat) -> Vec<u32> {
    let plan = Plan::seen(sky, camera, pixel).unwrap();
    gpu::backend().run(&plan, plan.kernel()).unwrap().words
}

#[test]
fn a_sky_in_a_programs_own_textures_is_that_of_the_renderer() {
    let (device, queue) = with_passthrough();
    let mut renderer = ResidentRenderer::with_device(&device, &queue);
    for sun in [25.0, -3.0] {
        let sky = sky(sun);
        for camera in cameras() {
            let size = (camera.size.width, camera.size.height);
            for (format, pixel) in [
                (TextureFormat::Rgba8Unorm, PixelFormat::Picture),
                (TextureFormat::Rgba16Float, PixelFormat::HalfRgb),
                (TextureFormat::Rgba32Float, PixelFormat::LinearRgba),
            ] {
                let texture = texture(&device, size, 1, format, TextureUsages::COPY_DST | TextureUsages::COPY_SRC);
                let mut encoder = device.create_command_encoder(&Default::default());
                let target = texture.create_view(&Default::default());
                renderer.encode(&mut encoder, &sky, &camera, &Target::Texture(&target)).unwrap();
                queue.submit([encoder.finish()]);
                let found = texels(&device, &queue, &texture, 0, pixel.words());
                assert!(found == expected(&sky, &camera, pixel), "sun at {sun}, {camera:?}, {format:?}");
            }
        }
    }
}

#[test]
fn a_part_of_a_texture_takes_the_sky_and_the_rest_stays() {
    let (device, queue) = with_passthrough();
    let mut renderer = ResidentRenderer::with_device(&device, &queue);
    let sky = sky(25.0);
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 128, height: 128, depth_or_array_layers: 6 },
        mip_level_count: 2,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: TextureFormat::Rgba16Float,
        usage: TextureUsages::COPY_DST | TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let face = |side: u32, look_azimuth: f64| CameraScene {
        projection: Projection::Perspective,
        size: format!("{side}x{side}").parse().unwrap(),
        fov: Some(90.0),
        look_azimuth: Some(look_azimuth),
        ..CameraScene::default()
    };
    // A face of a cube, a face of its next level, a corner of a third.
    let parts = [(0, [0, 0, 2], face(128, 90.0)), (1, [0, 0, 3], face(64, 180.0)), (0, [64, 32, 5], face(50, 270.0))];
    let mut encoder = device.create_command_encoder(&Default::default());
    for (mip_level, [x, y, z], camera) in &parts {
        let (origin, aspect) = (wgpu::Origin3d { x: *x, y: *y, z: *z }, wgpu::TextureAspect::All);
        let part = wgpu::TexelCopyTextureInfo { texture: &texture, mip_level: *mip_level, origin, aspect };
        renderer.encode(&mut encoder, &sky, camera, &Target::Part(part)).unwrap();
    }
    queue.submit([encoder.finish()]);
    for (mip_level, [x, y, z], camera) in &parts {
        let side = 128 >> mip_level;
        let rows = expected(&sky, camera, PixelFormat::HalfRgb);
        let found = texels_of_layer(&device, &queue, &texture, (*mip_level, *z), 2);
        for row in 0..side {
            let found = &found[(2 * side * row) as usize..][..2 * side as usize];
            let drawn = if (*y..y + camera.size.height).contains(&row) {
                let first = (2 * camera.size.width * (row - y)) as usize;
                let black = |pixels: u32| vec![0; 2 * pixels as usize];
                [
                    black(*x),
                    rows[first..][..2 * camera.size.width as usize].to_vec(),
                    black(side - x - camera.size.width),
                ]
                .concat()
            } else {
                vec![0; 2 * side as usize]
            };
            assert!(found == drawn, "level {mip_level}, layer {z}, row {row}");
        }
    }
    let untouched = texels_of_layer(&device, &queue, &texture, (0, 1), 2);
    assert!(untouched.len() == 2 * 128 * 128 && untouched.iter().all(|&word| word == 0));
}

#[test]
fn a_camera_that_has_turned_around_sees_what_it_saw() {
    let (device, queue) = with_passthrough();
    let mut renderer = ResidentRenderer::with_device(&device, &queue);
    let sky = sky(25.0);
    let bytes = 4 * 90 * 45;
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
    let mut seen_at = |look_azimuth: f64| {
        let camera = CameraScene { look_azimuth: Some(look_azimuth), ..cameras()[3].clone() };
        let output = buffer(&device, bytes, usage);
        let mut encoder = device.create_command_encoder(&Default::default());
        renderer.encode(&mut encoder, &sky, &camera, &Target::Buffer(&output, PixelFormat::Picture)).map(|()| {
            queue.submit([encoder.finish()]);
            read(&device, &queue, &output)
        })
    };
    let before = seen_at(100.0).unwrap();
    for turned in [460.0, 100.0 + 360.0 * 1e6] {
        assert!(seen_at(turned).unwrap() == before, "{turned}");
    }
    assert!(seen_at(100.5).unwrap() != before, "negative control");
    for wrong in [f64::NAN, f64::INFINITY] {
        assert!(matches!(seen_at(wrong), Err(Error::NotAllowed { .. })), "{wrong}");
    }
}

#[test]
fn skies_encoded_before_any_is_submitted_do_not_disturb_each_other() {
    let (device, queue) = with_passthrough();
    let mut renderer = ResidentRenderer::with_device(&device, &queue);
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
    let skies: Vec<_> =
        [40.0, 3.0].map(sky).into_iter().flat_map(|sky| cameras().into_iter().map(move |c| (sky.clone(), c))).collect();
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut buffers = Vec::new();
    for (sky, camera) in &skies {
        let bytes = 12 * u64::from(camera.size.width * camera.size.height);
        let output = buffer(&device, bytes, usage);
        renderer.encode(&mut encoder, sky, camera, &Target::Buffer(&output, PixelFormat::LinearRgb)).unwrap();
        buffers.push(output);
    }
    queue.submit([encoder.finish()]);
    for ((sky, camera), buffer) in skies.iter().zip(&buffers) {
        let found = read(&device, &queue, buffer);
        assert!(found == expected(sky, camera, PixelFormat::LinearRgb), "{camera:?}");
    }
}

/// Whole numbers below a bound, the same in each run of the tests.
fn random_numbers() -> impl FnMut(usize) -> usize {
    let mut state = 1u64;
    move |below| {
        // Knuth, The Art of Computer Programming 2, 3.3.4, table 1, line 26.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as usize % below
    }
}

#[test]
fn encoders_may_be_dropped_and_submitted_in_any_order() {
    let (device, queue) = with_passthrough();
    let mut renderer = ResidentRenderer::with_device(&device, &queue);
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
    let cameras = &cameras()[..5];
    let images: Vec<_> = [40.0, 3.0]
        .map(sky)
        .iter()
        .flat_map(|sky| {
            cameras.iter().map(|camera| (sky.clone(), camera, expected(sky, camera, PixelFormat::LinearRgb)))
        })
        .collect();
    let mut random = random_numbers();
    let (mut drawn, mut dropped) = (0, 0);
    for round in 0..16 {
        let mut waiting = Vec::new();
        for _ in 0..4 {
            let (sky, camera, expected) = &images[random(images.len())];
            let output = buffer(&device, 12 * u64::from(camera.size.width * camera.size.height), usage);
            let mut encoder = device.create_command_encoder(&Default::default());
            renderer.encode(&mut encoder, sky, camera, &Target::Buffer(&output, PixelFormat::LinearRgb)).unwrap();
            if random(2) == 0 {
                dropped += 1;
            } else {
                waiting.insert(random(waiting.len() + 1), (encoder, output, expected, camera));
            }
        }
        for (encoder, output, expected, camera) in waiting {
            queue.submit([encoder.finish()]);
            assert!(read(&device, &queue, &output) == *expected, "round {round}, {camera:?}");
            drawn += 1;
        }
    }
    assert!(drawn > 20 && dropped > 20, "{drawn} drawn, {dropped} dropped");
}

#[test]
fn a_device_that_passes_nothing_through_draws_the_same_sky() {
    let (device, queue) = opened(wgpu::Features::empty());
    let mut renderer = ResidentRenderer::with_device(&device, &queue);
    let (sky, camera) = (sky(25.0), &cameras()[0]);
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
    let output = buffer(&device, 12 * 128 * 64, usage);
    let mut encoder = device.create_command_encoder(&Default::default());
    renderer.encode(&mut encoder, &sky, camera, &Target::Buffer(&output, PixelFormat::LinearRgb)).unwrap();
    queue.submit([encoder.finish()]);
    let floats = |words: Vec<u32>| words.into_iter().map(f32::from_bits).collect::<Vec<_>>();
    let (found, expected) =
        (floats(read(&device, &queue, &output)), floats(expected(&sky, camera, PixelFormat::LinearRgb)));
    // Another compiler orders the same sums in another way.
    let worst = worst_in_images(&found, &expected, 128, 3, 1e-6);
    assert!(worst.relative <= 2e-4, "{worst:?}");
}

#[test]
fn a_renderer_that_is_warm_compiles_nothing_through_a_day() {
    let (device, queue) = with_passthrough();
    let mut renderer = ResidentRenderer::with_device(&device, &queue);
    let mut scene = Scene::preset(Preset::Standard);
    scene.sun.disc = true;
    let camera = cameras().pop().unwrap();
    let output = buffer(&device, 12 * 640 * 352, BufferUsages::STORAGE | BufferUsages::COPY_DST);
    let map = texture(&device, (32, 16), 6, TextureFormat::Rgba16Float, TextureUsages::COPY_DST);
    let harmonics = buffer(&device, 144, BufferUsages::STORAGE);
    let valid = scene.validated().unwrap();
    let warm_up = renderer.warm_up(&valid, &camera, PixelFormat::Picture);
    std::thread::spawn(warm_up).join().unwrap();
    std::thread::spawn(renderer.warm_up_environment(&valid, "32x16".parse().unwrap())).join().unwrap();
    let warm = renderer.pipelines();
    for sun in [60.0, 9.0, 4.0, 0.1, -3.0, -7.5, -13.0] {
        scene.sun.elevation = sun;
        let sky = sky_of(&scene);
        let mut encoder = device.create_command_encoder(&Default::default());
        renderer.encode(&mut encoder, &sky, &camera, &Target::Buffer(&output, PixelFormat::Picture)).unwrap();
        let target = EnvironmentTarget { map: &map, harmonics: &harmonics };
        renderer.encode_environment(&mut encoder, &sky, &target).unwrap();
        queue.submit([encoder.finish()]);
        assert_eq!(renderer.pipelines(), warm, "sun at {sun}");
    }
    let mut encoder = device.create_command_encoder(&Default::default());
    let other = Target::Buffer(&output, PixelFormat::LinearRgb);
    renderer.encode(&mut encoder, &sky(60.0), &camera, &other).unwrap();
    assert!(renderer.pipelines() > warm, "negative control: another format");
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
}

#[test]
fn light_fields_that_are_asked_for_twice_are_the_same() {
    let (device, queue) = with_passthrough();
    let renderer = ResidentRenderer::with_device(&device, &queue);
    let backend = gpu::backend();
    for (name, ask) in [
        ("renderer", &|| renderer.light_fields()),
        ("device", &|| backend.light_fields()),
        ("device's own", &|| backend.own_light_fields().unwrap()),
    ] as [(&str, &dyn Fn() -> LightFields); 3]
    {
        SkyPlan::with_light_fields(sky(25.0).scene(), Rgb::Srgb, &ask()).integral();
        let kept = format!("{:?}", ask());
        assert!(kept.starts_with("LightFields") && kept != format!("{:?}", ask().emptied()), "{name}: {kept}");
    }
}

#[test]
fn pipelines_are_compiled_with_the_cache_of_a_program() {
    let adapter = wgpu::Instance::default().request_adapter(&wgpu::RequestAdapterOptions::default());
    let adapter = pollster::block_on(adapter).expect("a Vulkan device; on Debian: apt-get install mesa-vulkan-drivers");
    let open = || {
        pollster::block_on(adapter.request_device(&ResidentRenderer::device_descriptor(&adapter))).expect("it opens")
    };
    let [(device, queue), (other, _)] = [open(), open()];
    assert!(device.features().contains(wgpu::Features::PIPELINE_CACHE), "the descriptor asks for what Vulkan has");
    let cache = |device: &wgpu::Device| {
        let descriptor = wgpu::PipelineCacheDescriptor { label: None, data: None, fallback: true };
        // SAFETY: there is no data that a driver could have written for another device.
        #[expect(unsafe_code, reason = "wgpu cannot check what is in a cache")]
        unsafe {
            device.create_pipeline_cache(&descriptor)
        }
    };
    let (sky, camera) = (sky(25.0), cameras()[0].clone());
    let bytes = 12 * u64::from(camera.size.width * camera.size.height);
    let output = buffer(&device, bytes, BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC);
    let complaint = |cache: wgpu::PipelineCache| {
        let mut renderer = ResidentRenderer::with_device(&device, &queue).with_pipeline_cache(cache);
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let mut encoder = device.create_command_encoder(&Default::default());
        let target = Target::Buffer(&output, PixelFormat::LinearRgb);
        renderer.encode(&mut encoder, &sky, &camera, &target).unwrap();
        queue.submit([encoder.finish()]);
        pollster::block_on(scope.pop())
    };
    assert!(complaint(cache(&device)).is_none());
    assert!(read(&device, &queue, &output) == expected(&sky, &camera, PixelFormat::LinearRgb));
    // A cache of another device is an error of wgpu's, which shows that the cache is used.
    assert!(complaint(cache(&other)).is_some());
}

#[test]
fn a_camera_that_turns_zooms_or_grows_plans_nothing_of_the_sky_anew() {
    let sky = sky(20.0);
    for camera in cameras() {
        let plan = Plan::seen(&sky, &camera, PixelFormat::LinearRgb).unwrap();
        assert!(plan.sky.is_same(&sky), "{camera:?}");
        let mut scene = Scene::clone(sky.scene());
        scene.camera = camera;
        let anew = Plan::new(&scene.validated().unwrap(), PixelFormat::LinearRgb);
        assert_eq!((plan.variant, &plan.lookup.size, plan.uniform), (anew.variant, &anew.lookup.size, anew.uniform));
    }
}

#[test]
fn a_night_is_opaque_and_black() {
    let (device, queue) = with_passthrough();
    let mut renderer = ResidentRenderer::with_device(&device, &queue);
    let texture =
        texture(&device, (100, 50), 1, TextureFormat::Rgba8Unorm, TextureUsages::COPY_DST | TextureUsages::COPY_SRC);
    let mut encoder = device.create_command_encoder(&Default::default());
    let target = texture.create_view(&Default::default());
    renderer.encode(&mut encoder, &sky(-60.0), &cameras()[1], &Target::Texture(&target)).unwrap();
    queue.submit([encoder.finish()]);
    let found = texels(&device, &queue, &texture, 0, 1);
    assert!(found.len() == 5000 && found.iter().all(|&word| word == 0xff00_0000));
}

#[test]
fn a_wrong_target_or_camera_is_refused_and_the_device_goes_on() {
    let (device, queue) = with_passthrough();
    let mut renderer = ResidentRenderer::with_device(&device, &queue);
    let (sky, camera) = (sky(20.0), cameras()[0].clone());
    let both = TextureUsages::COPY_DST | TextureUsages::COPY_SRC;
    let view = |size, format, usage| texture(&device, size, 1, format, usage).create_view(&Default::default());
    let small = buffer(&device, 100, BufferUsages::STORAGE | BufferUsages::COPY_DST);
    let unusable = buffer(&device, 12 * 128 * 64, BufferUsages::COPY_DST);
    let wrong_format = view((128, 64), TextureFormat::R32Float, both);
    let wrong_size = view((64, 64), TextureFormat::Rgba8Unorm, both);
    let wrong_usage = view((128, 64), TextureFormat::Rgba8Unorm, TextureUsages::TEXTURE_BINDING);
    let many_samples = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 128, height: 64, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 4,
        dimension: wgpu::TextureDimension::D2,
        format: TextureFormat::Rgba8Unorm,
        usage: both | TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let many_samples = many_samples.create_view(&Default::default());
    let parted = |size, layers, levels, dimension| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { depth_or_array_layers: layers, ..size },
            mip_level_count: levels,
            sample_count: 1,
            dimension,
            format: TextureFormat::Rgba8Unorm,
            usage: both,
            view_formats: &[],
        })
    };
    let size = wgpu::Extent3d { width: 128, height: 64, depth_or_array_layers: 1 };
    let [cube, levels] =
        [(6, 1), (1, 3)].map(|(layers, levels)| parted(size, layers, levels, wgpu::TextureDimension::D2));
    let deep = parted(size, 4, 1, wgpu::TextureDimension::D3);
    let of_layer = wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2),
        base_array_layer: 2,
        array_layer_count: Some(1),
        ..Default::default()
    };
    let of_level = wgpu::TextureViewDescriptor { base_mip_level: 1, ..Default::default() };
    let (layer, level) = (cube.create_view(&of_layer), levels.create_view(&of_level));
    let part = |texture, mip_level, [x, y, z]: [u32; 3]| {
        let (origin, aspect) = (wgpu::Origin3d { x, y, z }, wgpu::TextureAspect::All);
        Target::Part(wgpu::TexelCopyTextureInfo { texture, mip_level, origin, aspect })
    };
    for (target, words) in [
        (Target::Texture(&layer), "6 layers and 1 levels, and wgpu does not tell which"),
        (Target::Texture(&level), "1 layers and 3 levels, and wgpu does not tell which"),
        (part(&cube, 0, [0, 0, 6]), "layer 6 and level 0 of a texture with 6 layers and 1 levels"),
        (part(&levels, 3, [0, 0, 0]), "layer 0 and level 3 of a texture with 1 layers and 3 levels"),
        (part(&levels, 1, [0, 0, 0]), "a level of 64x32, where the camera's 128x64 do not fit"),
        (part(&cube, 0, [1, 0, 0]), "begins at 1,0 of a level of 128x64"),
        (part(&cube, 0, [0, u32::MAX, 0]), "where the camera's 128x64 do not fit"),
        (part(&deep, 0, [0, 0, 1]), "another dimension than D2"),
        (Target::Buffer(&small, PixelFormat::LinearRgb), "100 bytes; 128x64 pixels take 98304"),
        (Target::Buffer(&unusable, PixelFormat::LinearRgb), "without the usages STORAGE"),
        (Target::Texture(&wrong_format), "the format R32Float; Rgba8Unorm"),
        (Target::Texture(&wrong_size), "64x64; the camera has 128x64"),
        (Target::Texture(&wrong_usage), "without the usage COPY_DST"),
        (Target::Texture(&many_samples), "several samples a pixel"),
    ] {
        let mut encoder = device.create_command_encoder(&Default::default());
        let refused = renderer.encode(&mut encoder, &sky, &camera, &target).unwrap_err();
        assert!(matches!(refused, Error::Target(_)) && refused.to_string().contains(words), "{refused}");
    }
    let good = view((128, 64), TextureFormat::Rgba8Unorm, both);
    let mut encoder = device.create_command_encoder(&Default::default());
    let wide = CameraScene { fov: Some(500.0), projection: Projection::Perspective, ..camera.clone() };
    let refused = renderer.encode(&mut encoder, &sky, &wide, &Target::Texture(&good)).unwrap_err();
    assert!(matches!(refused, Error::OutOfRange { .. }), "{refused}");
    let xyz = Sky::with_light_fields(sky.scene(), Rgb::Xyz, &LightFields::default());
    let refused = renderer.encode(&mut encoder, &xyz, &camera, &Target::Texture(&good)).unwrap_err();
    assert!(refused.to_string().contains("render.rgb"), "{refused}");
    renderer.encode(&mut encoder, &sky, &camera, &Target::Texture(&good)).unwrap();
    queue.submit([encoder.finish()]);
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
}

/// Encodes the sky of a camera into a buffer.
fn encoded(device: &wgpu::Device, queue: &wgpu::Queue, camera: &CameraScene) -> Result<(), Error> {
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let output = buffer(device, 12 * u64::from(camera.size.width * camera.size.height), usage);
    let mut renderer = ResidentRenderer::with_device(device, queue);
    let mut encoder = device.create_command_encoder(&Default::default());
    let done = renderer.encode(&mut encoder, &sky(20.0), camera, &Target::Buffer(&output, PixelFormat::LinearRgb));
    // Whether or not it was refused, the encoder holds nothing that a queue would not take.
    queue.submit([encoder.finish()]);
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    done
}

#[test]
fn an_image_beyond_a_limit_is_refused_and_the_device_draws_a_smaller_one() {
    let sized = |size: &str| CameraScene { size: size.parse().unwrap(), ..cameras()[0].clone() };
    let within = |limits: fn(wgpu::Limits) -> wgpu::Limits, words: &str, small: Option<&str>| {
        let (device, queue) = opened_within(wgpu::Features::PASSTHROUGH_SHADERS, limits);
        let refused = encoded(&device, &queue, &sized("8192x64")).unwrap_err();
        let is_told = matches!(&refused, Error::Device(told) if told.contains("limits") && told.contains(words));
        assert!(is_told, "{refused}");
        if let Some(small) = small {
            encoded(&device, &queue, &sized(small)).unwrap();
        }
    };
    let bytes = |limits| wgpu::Limits { max_storage_buffer_binding_size: 1 << 20, ..limits };
    within(bytes, "the pixels", Some("128x64"));
    let groups = |limits| wgpu::Limits { max_compute_workgroups_per_dimension: 511, ..limits };
    within(groups, "the workgroups", Some("256x128"));
    let bindings = |limits| wgpu::Limits { max_storage_buffers_per_shader_stage: 5, ..limits };
    within(bindings, "the kernels", None);
}

#[test]
fn a_lost_device_is_told_before_anything_is_encoded_and_another_goes_on() {
    let sky = sky(25.0);
    let camera = &cameras()[0];
    let encoded = |(device, queue): &(wgpu::Device, wgpu::Queue), is_lost: bool| {
        let usage = TextureUsages::COPY_DST | TextureUsages::COPY_SRC;
        let size = (camera.size.width, camera.size.height);
        let texture = texture(device, size, 1, TextureFormat::Rgba8Unorm, usage);
        let target = texture.create_view(&Default::default());
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut renderer = ResidentRenderer::with_device(device, queue);
        if is_lost {
            device.destroy();
        }
        renderer.encode(&mut encoder, &sky, camera, &Target::Texture(&target))
    };
    let lost = encoded(&with_passthrough(), true).unwrap_err();
    assert!(matches!(&lost, Error::Device(complaint) if complaint.contains("lost")), "{lost}");
    encoded(&with_passthrough(), false).unwrap();
}

/// The example of the library, which `cargo test` builds beside the tests.
fn example(folder: &Path) -> Command {
    let path = program::binary().with_file_name("examples").join(format!("embed{}", std::env::consts::EXE_SUFFIX));
    assert!(path.is_file(), "{} is not built: `cargo test --workspace` builds it", path.display());
    let mut command = Command::new(path);
    for display in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(display);
    }
    command.current_dir(folder).env("XDG_RUNTIME_DIR", folder);
    command
}

fn pixels(path: &Path) -> Vec<u8> {
    image::open(path).unwrap().into_rgb8().into_raw()
}

#[test]
fn the_example_draws_a_moving_sun_as_the_command_does() {
    let folder = tempfile::tempdir().unwrap();
    let done = example(folder.path()).args(["--frames", "3", "--out", "frames"]).output().expect("it starts");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let pixels = |name: &str| pixels(&folder.path().join(name));
    for (frame, sun) in [15.0, 14.75, 14.5].into_iter().enumerate() {
        let sun = format!("{sun}");
        let request =
            ["render", "--projection", "perspective", "--size", "960x540", "--sun-elevation", &sun, "-o", "sky.png"];
        assert_eq!(program::run(folder.path(), &request).code, Some(0));
        let (shown, rendered) = (pixels(&format!("frames/{frame:04}.png")), pixels("sky.png"));
        assert_eq!(shown.len(), rendered.len());
        let apart: Vec<u8> =
            shown.iter().zip(&rendered).map(|(a, b)| a.abs_diff(*b)).filter(|&step| step > 0).collect();
        // The command plans on a device of hardware, the example on the processor: 1e-6 apart, which takes one value in
        // a thousand to the byte beside.
        assert!(
            apart.iter().all(|&step| step == 1) && 1000 * apart.len() <= shown.len(),
            "sun at {sun}: {}",
            apart.len()
        );
    }
    assert_ne!(pixels("frames/0000.png"), pixels("frames/0002.png"));
    // It is to be read in a minute.
    assert!(include_str!("../../../host/sorairo/examples/embed.rs").lines().count() < 120);
    let wrong = example(folder.path()).arg("--out").output().unwrap();
    assert!(!wrong.status.success() && String::from_utf8_lossy(&wrong.stderr).contains("usage"));
}

/// A process that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Red, green and blue on the screen of an Xvfb with `-fbdir`: a dump in the format of xwd (X11/XWDFile.h) that the
/// server keeps up to date.
fn screen(folder: &Path) -> Option<Vec<u8>> {
    const COLOUR_BYTES: usize = 12;
    let bytes = std::fs::read(folder.join("Xvfb_screen0")).ok()?;
    let field = |index: usize| Some(u32::from_be_bytes(bytes.get(4 * index..4 * index + 4)?.try_into().ok()?) as usize);
    let (header, height, row, colours) = (field(0)?, field(5)?, field(12)?, field(19)?);
    let first = header + COLOUR_BYTES * colours;
    let pixels = bytes.get(first..first + height * row)?;
    Some(pixels.chunks(4).flat_map(|pixel| [pixel[2], pixel[1], pixel[0]]).collect())
}

#[test]
fn the_example_shows_a_sun_that_moves_in_a_window() {
    let folder = tempfile::tempdir().unwrap();
    let done = example(folder.path()).args(["--frames", "120", "--out", "frames"]).output().expect("it starts");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let frames: Vec<_> = (0..120).map(|frame| pixels(&folder.path().join(format!("frames/{frame:04}.png")))).collect();
    let mut server = Command::new("Xvfb");
    server.args(["-displayfd", "1", "-screen", "0", "960x540x24", "-nolisten", "tcp", "-fbdir", "."]);
    let started = server.current_dir(folder.path()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
    let mut server = Running(started.expect("Xvfb starts: install it (Debian: apt-get install xvfb)"));
    let mut display = String::new();
    BufReader::new(server.0.stdout.take().unwrap()).read_line(&mut display).unwrap();
    let empty = screen(folder.path()).expect("a screen");
    assert!(empty.len() == frames[0].len() && !frames.contains(&empty));
    let display = format!(":{}", display.trim());
    let mut window = Running(example(folder.path()).env("DISPLAY", display).spawn().unwrap());
    // Frames that are on the screen as a whole: the server may be read while it takes the next one.
    let mut seen = BTreeSet::new();
    wait::until("three frames on the screen", || {
        assert!(
            window.0.try_wait().unwrap().is_none(),
            "the window closed by itself; what it loads is what test.sh installs beside Xvfb"
        );
        let shown = screen(folder.path());
        seen.extend(frames.iter().position(|frame| Some(frame) == shown.as_ref()));
        seen.len() >= 3
    });
}
