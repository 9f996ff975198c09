//! The air before a camera in a program's own textures: against each ray integrated, and against the sky behind it.

use rayon::prelude::*;
use sorairo::scene::{CameraScene, ColourPath, Scene};
use sorairo::wgpu::{self, TextureFormat, TextureUsages};
use sorairo::{
    AirPlan, AirVolumeTarget, Depth, DepthImage, Direction, Error, PixelFormat, Plan, ResidentRenderer, SeenImage,
    Target,
};
use sorairo_shared::glam::DVec3;
use sorairo_tests::air::{self, camera, largest, scenes, scenes_towards_the_sun};
use sorairo_tests::own_device::{opened, texels, texture, with_passthrough};
use sorairo_tests::sky::sky_of;

/// The image of every camera here.
const SIZE: (u32, u32) = (640, 352);

/// A device, what it draws with, and the air before a camera.
struct Drawn {
    device: wgpu::Device,
    queue: wgpu::Queue,
    renderer: ResidentRenderer,
    air: AirPlan,
    camera: CameraScene,
    volume: [wgpu::Texture; 2],
}

impl Drawn {
    fn new(scene: &Scene, elevation: f64, size: [u32; 3]) -> Self {
        Self::by(with_passthrough(), scene, elevation, size)
    }

    fn by((device, queue): (wgpu::Device, wgpu::Queue), scene: &Scene, elevation: f64, size: [u32; 3]) -> Self {
        let renderer = ResidentRenderer::with_device(&device, &queue);
        let sky = sky_of(scene);
        let air = AirPlan::new(&sky, size[2], AirPlan::middle_of(&sky)).unwrap();
        let volume = [(); 2].map(|()| volume(&device, size));
        let mut drawn = Self { device, queue, renderer, air, camera: camera(SIZE, elevation), volume };
        drawn.fill();
        drawn
    }

    fn fill(&mut self) {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let target = target(&self.volume);
        self.renderer.encode_volume(&mut encoder, &self.air, &self.camera, &target).unwrap();
        self.queue.submit([encoder.finish()]);
    }

    /// Red, green and blue of each pixel behind the air, of a colour and a depth along the ray (km) each.
    fn seen(&mut self, colour: [f32; 4], km: &[f32]) -> Vec<[f32; 3]> {
        let colours: Vec<[f32; 4]> = vec![colour; km.len()];
        let colour = image(&self.device, TextureFormat::Rgba32Float);
        write(&self.queue, &colour, bytemuck::cast_slice(&colours));
        let depth = image(&self.device, TextureFormat::R32Float);
        write(&self.queue, &depth, bytemuck::cast_slice(km));
        self.seen_at(&colour, DepthImage { texture: &depth, depth: Depth::AlongRay, metres: 1000.0 })
    }

    fn seen_at(&mut self, colour: &wgpu::Texture, depth: DepthImage<'_>) -> Vec<[f32; 3]> {
        let output = image(&self.device, TextureFormat::Rgba16Float);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let seen = SeenImage { colour, depth, output: &output };
        self.renderer.encode_air(&mut encoder, &self.air, &self.camera, &target(&self.volume), &seen).unwrap();
        self.queue.submit([encoder.finish()]);
        halves(&texels(&self.device, &self.queue, &output, 0, 2))
    }

    /// The directions of the pixels.
    fn directions(&self) -> Vec<Direction> {
        let plan = Plan::seen(self.air.sky(), &self.camera, PixelFormat::LinearRgb).unwrap();
        let pixels = (0..SIZE.1).flat_map(|row| (0..SIZE.0).map(move |column| (column, row)));
        pixels.map(|(column, row)| Direction::of_pixel(&plan, column, row).unwrap()).collect()
    }

    /// Red, green and blue of the sky of the camera, as the renderer draws it.
    fn sky(&mut self) -> Vec<[f32; 3]> {
        let image = image(&self.device, TextureFormat::Rgba32Float);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let view = image.create_view(&Default::default());
        let sky = self.air.sky().clone();
        self.renderer.encode(&mut encoder, &sky, &self.camera, &Target::Texture(&view)).unwrap();
        self.queue.submit([encoder.finish()]);
        let words = texels(&self.device, &self.queue, &image, 0, 4);
        words.chunks(4).map(|texel| [texel[0], texel[1], texel[2]].map(f32::from_bits)).collect()
    }
}

fn target(volume: &[wgpu::Texture; 2]) -> AirVolumeTarget<'_> {
    AirVolumeTarget { in_scatter: &volume[0], transmittance: &volume[1] }
}

fn volume(device: &wgpu::Device, [width, height, depth_or_array_layers]: [u32; 3]) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format: TextureFormat::Rgba16Float,
        usage: TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

/// A texture of the camera's size with every usage that its format has here.
fn image(device: &wgpu::Device, format: TextureFormat) -> wgpu::Texture {
    let others = match format {
        TextureFormat::Rgba16Float => TextureUsages::STORAGE_BINDING | TextureUsages::COPY_DST,
        TextureFormat::Depth32Float => TextureUsages::RENDER_ATTACHMENT,
        _ => TextureUsages::COPY_DST,
    };
    texture(device, SIZE, 1, format, TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC | others)
}

fn write(queue: &wgpu::Queue, texture: &wgpu::Texture, bytes: &[u8]) {
    let bytes_per_row = Some(bytes.len() as u32 / texture.height());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
    queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
}

fn halves(words: &[u32]) -> Vec<[f32; 3]> {
    let half = |word: u32| exr::prelude::f16::from_bits(word as u16).to_f32();
    words.chunks(2).map(|texel| [half(texel[0]), half(texel[0] >> 16), half(texel[1])]).collect()
}

/// Numbers in [0, 1) that are spread as evenly as can be: steps of the golden ratio.
fn spread(at: usize) -> f64 {
    (0.5 + at as f64 * 0.618_033_988_749_894_8).fract()
}

/// How far the air of a device is from each ray integrated, relative to the brightest: light, then transmittance; in
/// the mean of the squares and at most.
fn errors(drawn: &mut Drawn) -> [[f64; 2]; 2] {
    /// Every so many pixels one is compared: in eight skies ten thousand.
    const STEP: usize = 173;
    let pixels = (SIZE.0 * SIZE.1) as usize;
    // Up to 100 km, as near ones as far ones.
    let km: Vec<f32> = (0..pixels).map(|at| (100.0 * spread(at / STEP).powi(2)) as f32).collect();
    let light = drawn.seen([0.0, 0.0, 0.0, 1.0], &km);
    // A light beside which that of the air is small.
    let with_one = drawn.seen([1000.0, 1000.0, 1000.0, 1.0], &km);
    let (each, directions) = (drawn.air.sky().between_rgb(), drawn.directions());
    let compared: Vec<_> = (0..pixels)
        .into_par_iter()
        .step_by(STEP)
        .filter_map(|at| {
            let expected = each.until(&directions[at], f64::from(km[at])).ok()?;
            let [added, with_one] = [light[at], with_one[at]].map(|rgb| DVec3::from_array(rgb.map(f64::from)));
            Some(([added, (with_one - added) / 1000.0], expected))
        })
        .collect();
    assert!(compared.len() > pixels / STEP / 3, "pixels before the ground: {}", compared.len());
    air::errors(&compared)
}

#[test]
fn air_in_a_programs_own_textures_is_that_of_each_ray() {
    for (name, scene, elevation) in scenes(50.0).into_iter().chain(scenes_towards_the_sun()) {
        let errors = errors(&mut Drawn::new(&scene, elevation, [32, 32, 32]));
        println!("{name}: light and transmittance, rms and at most: {errors:.5?}");
        for [rms, largest] in errors {
            // What a volume of that size is to be good for.
            assert!(rms < 0.01 && largest < 0.03, "{name}: {rms}, {largest}");
        }
    }
}

#[test]
fn a_camera_that_is_turned_and_shifted_has_the_air_of_its_own_rays() {
    let [_, (name, scene, elevation), ..] = scenes(50.0);
    let mut drawn = Drawn::new(&scene, elevation, [32, 32, 32]);
    drawn.camera = CameraScene { roll: 70.0, shift_x: -0.4, shift_y: -0.1, ..drawn.camera };
    let behind = errors(&mut drawn);
    drawn.fill();
    let errors = errors(&mut drawn);
    println!("{name}: {errors:.5?}, of the camera before {behind:.5?}");
    // As of cameras that stand upright.
    assert!(errors.into_iter().all(|[rms, largest]| rms < 0.01 && largest < 0.03), "{errors:?}");
    assert!(behind[0][1] > 0.1, "{behind:?}");
}

/// Seconds of a device for one of so many that are encoded together: the least of five turns.
fn seconds(drawn: &mut Drawn, many: u32, mut encode: impl FnMut(&mut Drawn, &mut wgpu::CommandEncoder)) -> f64 {
    let mut turn = || {
        let mut encoder = drawn.device.create_command_encoder(&Default::default());
        (0..many).for_each(|_| encode(drawn, &mut encoder));
        let start = std::time::Instant::now();
        drawn.queue.submit([encoder.finish()]);
        drawn.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        start.elapsed().as_secs_f64() / f64::from(many)
    };
    (0..5).map(|_| turn()).fold(f64::INFINITY, f64::min)
}

/// On a graphics processor the air of a frame costs little more than moving it. Software devices copy fast and compute
/// slowly: llvmpipe takes 80 copies.
#[test]
fn air_costs_a_graphics_processor_little_more_than_copies() {
    let mut drawn = Drawn::new(&scenes(50.0)[0].1, 0.0, [32, 32, 32]);
    let info = drawn.device.adapter_info();
    // An H100 takes 0.4 to 0.7 copies, and 240 µs for a volume.
    let (many, most_copies, most) =
        if info.device_type == wgpu::DeviceType::Cpu { (2, 400.0, f64::INFINITY) } else { (50, 2.0, 1000.0) };
    let size = (1920, 1080);
    drawn.camera = camera(size, 0.0);
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING;
    let usage = usage | TextureUsages::COPY_SRC | TextureUsages::COPY_DST;
    let [colour, copied, output] = [(); 3].map(|()| texture(&drawn.device, size, 1, TextureFormat::Rgba16Float, usage));
    let depth = texture(&drawn.device, size, 1, TextureFormat::R32Float, TextureUsages::TEXTURE_BINDING);
    let depth = DepthImage { texture: &depth, depth: Depth::AlongRay, metres: 1000.0 };
    let seen = SeenImage { colour: &colour, depth, output: &output };
    let volume = seconds(&mut drawn, many, |drawn, encoder| {
        let target = target(&drawn.volume);
        drawn.renderer.encode_volume(encoder, &drawn.air, &drawn.camera, &target).unwrap();
    });
    let applied = seconds(&mut drawn, many, |drawn, encoder| {
        let target = target(&drawn.volume);
        drawn.renderer.encode_air(encoder, &drawn.air, &drawn.camera, &target, &seen).unwrap();
    });
    let copy = seconds(&mut drawn, many, |_, encoder| {
        encoder.copy_texture_to_texture(colour.as_image_copy(), copied.as_image_copy(), colour.size());
    });
    let [volume, applied, copy] = [volume, applied, copy].map(|seconds| 1e6 * seconds);
    println!("{}: volume {volume:.1} µs, air on 1920 x 1080 {applied:.1} µs, a copy of it {copy:.1} µs", info.name);
    assert!(applied <= most_copies * copy && volume < most, "{volume} µs, {applied} µs, {copy} µs");
}

/// Of 257 columns and 65 rows every fifth pixel of a row and every eleventh row from the third and the sixth on lie at
/// texels: `i = (c - 1) (p + ½) / width`. What is seen there is what the volume holds.
#[test]
fn the_far_end_of_the_air_is_the_sky_behind_it() {
    let [towards_sun, ..] = scenes_towards_the_sun();
    for (name, scene, elevation) in scenes(50.0).into_iter().chain([towards_sun]) {
        let mut drawn = Drawn::new(&scene, elevation, [257, 65, 8]);
        let pixels = (SIZE.0 * SIZE.1) as usize;
        // So far that nothing is behind it but the sky.
        let found = drawn.seen([0.0, 0.0, 0.0, 1.0], &vec![9e9; pixels]);
        let (sky, directions) = (drawn.sky(), drawn.directions());
        let (mut compared, mut worst) = (0, 0.0);
        for row in (5..SIZE.1 as usize).step_by(11) {
            for column in (2..SIZE.0 as usize).step_by(5) {
                let at = row * SIZE.0 as usize + column;
                // On a level ray the horizon of an image is smoothed over a pixel.
                if directions[at].elevation < 0.1 {
                    continue;
                }
                for (found, sky) in found[at].into_iter().zip(sky[at]) {
                    // Where half floats are coarsest for their size.
                    let half_step = f64::from(sky) / 2048.0;
                    worst = largest(worst, (f64::from(found) - f64::from(sky)).abs() / half_step);
                    compared += 1;
                }
            }
        }
        println!("{name}: {compared} values, {worst} of half a step");
        assert!(compared > 1000, "{name}: {compared}");
        // What is stored is rounded by up to half a step; single precision leaves a part of that.
        assert!(worst <= 1.05, "{name}: {worst} of half a step");
    }
}

#[test]
fn the_sky_is_copied_and_so_is_what_nothing_stands_before() {
    let (_, ref scene, elevation) = scenes(50.0)[0];
    let mut drawn = Drawn::new(scene, elevation, [32, 32, 32]);
    let pixels = (SIZE.0 * SIZE.1) as usize;
    let colour = [0.25, 3.0, 1.5, 1.0];
    for depth in [f32::INFINITY, f32::NAN, 1e10, 0.0, -3.0] {
        let found = drawn.seen(colour, &vec![depth; pixels]);
        // Each is a half float, and before 0 km nothing is added and all comes through.
        assert!(found.iter().all(|rgb| rgb == &colour[..3]), "{depth}: {:?}", found[0]);
    }
}

/// A depth buffer that was cleared to a value.
fn cleared(drawn: &Drawn, value: f32) -> wgpu::Texture {
    let texture = image(&drawn.device, TextureFormat::Depth32Float);
    let view = texture.create_view(&Default::default());
    let mut encoder = drawn.device.create_command_encoder(&Default::default());
    let operations = wgpu::Operations { load: wgpu::LoadOp::Clear(value), store: wgpu::StoreOp::Store };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: None,
        color_attachments: &[],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &view,
            depth_ops: Some(operations),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    drawn.queue.submit([encoder.finish()]);
    texture
}

#[test]
fn depth_buffers_say_the_same_as_distances() {
    let (_, ref scene, elevation) = scenes(50.0)[0];
    let mut drawn = Drawn::new(scene, elevation, [32, 32, 32]);
    let black = image(&drawn.device, TextureFormat::Rgba16Float);
    // A wall 8 km before the camera, near and far planes in metres.
    let wall = 8000.0;
    let pixels = (SIZE.0 * SIZE.1) as usize;
    let linear = image(&drawn.device, TextureFormat::R32Float);
    write(&drawn.queue, &linear, bytemuck::cast_slice(&vec![wall as f32; pixels]));
    let expected = drawn.seen_at(&black, DepthImage { texture: &linear, depth: Depth::AlongAxis, metres: 1.0 });
    let brightest = expected.iter().flatten().map(|value| f64::from(*value)).fold(0.0, largest);
    assert!(brightest > 1.0, "{brightest}");
    let (near, far) = (10.0, 40_000.0);
    let reversed = near * (far - wall) / (wall * (far - near));
    for (depth, value) in [
        (Depth::ReversedZ { near: 0.1, far: f64::INFINITY }, 0.1 / wall),
        (Depth::ReversedZ { near, far }, reversed),
        (Depth::ForwardZ { near, far }, 1.0 - reversed),
    ] {
        let texture = cleared(&drawn, value as f32);
        let found = drawn.seen_at(&black, DepthImage { texture: &texture, depth, metres: 1.0 });
        let worst = found
            .iter()
            .flatten()
            .zip(expected.iter().flatten())
            .map(|(a, b)| f64::from((a - b).abs()))
            .fold(0.0, largest);
        // A step of a forward depth near 1 is 6e-8 of 1/10 m: 5e-5 of 8 km, and a half float is rounded by 5e-4.
        assert!(worst < 1.5e-3 * brightest, "{depth:?}: {worst} of {brightest}");
    }
    let at_sky = cleared(&drawn, 0.0);
    let depth = Depth::ReversedZ { near: 0.1, far: f64::INFINITY };
    let found = drawn.seen_at(&black, DepthImage { texture: &at_sky, depth, metres: 1.0 });
    assert!(found.iter().flatten().all(|value| *value == 0.0));
}

#[test]
fn light_is_exposed_and_what_comes_through_is_not() {
    let (_, ref scene, elevation) = scenes(50.0)[1];
    let mut drawn = Drawn::new(scene, elevation, [32, 32, 32]);
    let pixels = (SIZE.0 * SIZE.1) as usize;
    let km = vec![20.0; pixels];
    let plain = drawn.seen([0.0, 0.0, 0.0, 1.0], &km);
    drawn.renderer.set_linear_exposure(-3.0);
    drawn.fill();
    let darker = drawn.seen([0.0, 0.0, 0.0, 1.0], &km);
    for (a, b) in plain.iter().flatten().zip(darker.iter().flatten()) {
        // Both are rounded to half floats, and so are their froxels.
        assert!((a / 8.0 - b).abs() <= 2e-3 * b + 1e-6, "{a} {b}");
    }
}

#[test]
fn what_cannot_be_filled_or_applied_is_refused_before_anything_is_encoded() {
    let (_, ref scene, elevation) = scenes(50.0)[0];
    let mut drawn = Drawn::new(scene, elevation, [32, 32, 32]);
    let Drawn { device, renderer, air, camera, volume: [in_scatter, transmittance], .. } = &mut drawn;
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut refused = |of: &CameraScene, target: AirVolumeTarget<'_>| {
        renderer.encode_volume(&mut encoder, air, of, &target).unwrap_err().to_string()
    };
    let good = AirVolumeTarget { in_scatter, transmittance };
    let other = volume(device, [32, 16, 32]);
    let thin = volume(device, [32, 32, 8]);
    let flat = image(device, TextureFormat::Rgba16Float);
    let with = |texture| AirVolumeTarget { transmittance: texture, ..good };
    assert!(refused(camera, with(&other)).contains("both have one size"));
    assert!(refused(camera, with(&flat)).contains("a volume of air has Rgba16Float and D3"));
    let both = AirVolumeTarget { in_scatter: &thin, transmittance: &thin };
    assert!(refused(camera, both).contains("8 slices, and the air was planned with 32"));
    assert!(refused(&CameraScene::default(), good).starts_with("camera.projection"));

    let [colour, output] = [(); 2].map(|()| image(device, TextureFormat::Rgba16Float));
    let depth = image(device, TextureFormat::R32Float);
    let small = texture(device, (64, 32), 1, TextureFormat::R32Float, TextureUsages::TEXTURE_BINDING);
    let depth = DepthImage { texture: &depth, depth: Depth::AlongAxis, metres: 1.0 };
    let image = SeenImage { colour: &colour, depth, output: &output };
    let mut refused =
        |image: SeenImage<'_>| -> Error { renderer.encode_air(&mut encoder, air, camera, &good, &image).unwrap_err() };
    fn with_depth<'a>(image: SeenImage<'a>, depth: DepthImage<'a>) -> SeenImage<'a> {
        SeenImage { depth, ..image }
    }
    let kinds = [
        (
            refused(with_depth(image, DepthImage { texture: &small, ..depth })),
            "is a texture of 64x32; the camera has 640x352",
        ),
        (
            refused(with_depth(image, DepthImage { texture: &colour, ..depth })),
            "a depth image has one of depth or R32Float",
        ),
        (refused(SeenImage { output: &colour, ..image }), "another one is drawn into"),
        (refused(SeenImage { output: depth.texture, ..image }), "without the usage STORAGE_BINDING"),
    ];
    for (error, words) in kinds {
        assert!(matches!(error, Error::Target(_)) && error.to_string().contains(words), "{error}");
    }
    for (near, far) in [(0.0, 1.0), (1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (1.0, f64::NAN)] {
        for kind in [Depth::ReversedZ { near, far }, Depth::ForwardZ { near, far }] {
            let error = refused(with_depth(image, DepthImage { depth: kind, ..depth }));
            assert!(matches!(error, Error::NotAllowed { .. }), "{near} {far}: {error}");
        }
    }
    for metres in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = refused(with_depth(image, DepthImage { metres, ..depth }));
        assert!(error.to_string().starts_with("metres is "), "{error}");
    }
}

#[test]
fn air_that_cannot_be_planned_is_refused() {
    let mut scene = Scene::default();
    let planned = sky_of(&scene);
    let refused = |sky, slices, middle| AirPlan::new(sky, slices, middle).unwrap_err().to_string();
    assert!(refused(&planned, 3, 25.0).starts_with("slices is 3; it must lie between 4 and 256"));
    for middle in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refused(&planned, 32, middle).starts_with("middle is "), "{middle}");
    }
    scene.render.color = ColourPath::Solve;
    assert!(refused(&sky_of(&scene), 32, 25.0).starts_with("render.color"));
}

#[test]
fn the_air_of_translated_kernels_is_the_same() {
    let pixels = (SIZE.0 * SIZE.1) as usize;
    let km: Vec<f32> = (0..pixels).map(|at| (100.0 * spread(at)) as f32).collect();
    // With the aureole in view the kernel computes what it reads elsewhere.
    let [(_, scene, elevation), ..] = scenes_towards_the_sun();
    let [passed, translated] = [with_passthrough(), opened(wgpu::Features::empty())]
        .map(|device| Drawn::by(device, &scene, elevation, [16, 16, 8]).seen([1.0; 4], &km));
    let each = || passed.iter().flatten().zip(translated.iter().flatten());
    // Half floats round by 5e-4 of themselves, and one may round to the neighbour of the other.
    assert!(each().all(|(a, b)| (a - b).abs() <= 1e-3 * (1.0 + a.abs())));
    assert!(each().any(|(a, _)| (a - 1.0).abs() > 0.1));
}
