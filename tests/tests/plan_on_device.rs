//! Plans whose light is integrated on a device, against those of the processor. Without a Vulkan device these tests fail.

use std::collections::HashSet;
use std::sync::Arc;

use sorairo::low_level::device::gpu;
use sorairo::low_level::device::{Backend, cpu::Cpu};
use sorairo::low_level::plan::on_device::{Look, Memory, PlanDevice, Work};
use sorairo::low_level::plan::{SpectralPlan, direction};
use sorairo::scene::{CameraScene, GroundAlbedo, Orders, PathChoice, Preset, Projection, Rgb, Scene};
use sorairo::{LightFields, PixelFormat, Plan, SkyPlan, wgpu};
use sorairo_shared::glam::Vec4;
use sorairo_shared::sky::Parts;
use sorairo_tests::compare::worst_in_images;
use sorairo_tests::interpreted::Interpreted;
use sorairo_tests::own_device::{opened, with_passthrough};

/// What the devices' own `exp` and `ln` may leave of a value: (3 + 2 |x|) ULP by the Vulkan specification, at the optical depths up to 40 that still count in a
/// sum; as of the kernels of images. llvmpipe leaves 2e-6.
const SAME_FUNCTION: f64 = 2e-4;

fn skies() -> Vec<(String, Scene)> {
    let of = |name: &str, preset, sun: f64, change: &dyn Fn(&mut Scene)| {
        let mut scene = Scene::preset(preset);
        scene.sun.elevation = sun;
        change(&mut scene);
        (format!("{name}, sun at {sun}°"), scene)
    };
    let mut skies = Vec::new();
    for sun in [60.0, 15.0, 5.0, 0.5, -4.0, -8.0] {
        skies.push(of("standard", Preset::Standard, sun, &|_| {}));
    }
    for sun in [30.0, 2.0] {
        skies.push(of("hazy", Preset::Hazy, sun, &|_| {}));
        skies.push(of("12 km over snow", Preset::Standard, sun, &|scene| {
            scene.observer.altitude = 12.0;
            scene.ground.albedo = GroundAlbedo::Grey(0.9);
        }));
        skies.push(of("400 km", Preset::Standard, sun, &|scene| scene.observer.altitude = 400.0));
        skies.push(of("without aerosol", Preset::Standard, sun, &|scene| scene.atmosphere.aerosol.optical_depth = 0.0));
        skies.push(of("three orders", Preset::Standard, sun, &|scene| scene.render.orders = Orders::UpTo(3)));
    }
    skies
}

fn planned(scene: &Scene, fields: &LightFields) -> Arc<SkyPlan> {
    Arc::new(SkyPlan::with_light_fields(&scene.clone().validated().unwrap(), Rgb::Srgb, fields))
}

fn flat(values: &[Vec4]) -> Vec<f32> {
    values.iter().flat_map(|value| value.to_array()).collect()
}

/// The largest difference of two lists, relative to the larger of a value and a thousandth of the brightest.
fn apart(found: &[f32], expected: &[f32]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let [found, expected] = [found, expected].map(|list| list.iter().map(|&value| f64::from(value)));
    let brightest = expected.clone().fold(0.0, f64::max);
    assert!(brightest > 0.0, "nothing is compared");
    let off = |(found, expected): (f64, f64)| {
        let off = (found - expected).abs() / expected.abs().max(1e-3 * brightest);
        if off.is_nan() { f64::INFINITY } else { off }
    };
    found.zip(expected).map(off).fold(0.0, f64::max)
}

#[test]
fn multiply_scattered_light_of_a_device_is_that_of_the_processor() {
    let (device, queue) = with_passthrough();
    let on_device = gpu::light_fields(&device, &queue);
    let mut seen = Vec::new();
    for (name, scene) in skies() {
        let [found, expected] =
            [&on_device, &LightFields::default()].map(|fields| planned(&scene, fields).integral().clone());
        let off = apart(&flat(&found.multiple), &flat(&expected.multiple));
        println!("{name}: {off:.1e}, {} orders", found.orders_made[0].computed);
        assert!(off < SAME_FUNCTION, "{name}: {off:e}");
        assert_eq!(found.orders_made[0].computed, expected.orders_made[0].computed, "{name}");
        assert_eq!(found.quadrature, expected.quadrature, "{name}");
        seen.push(flat(&expected.multiple));
    }
    assert!(apart(&seen[1], &seen[0]) > 0.1, "negative control");
}

#[test]
fn pictures_of_a_sky_planned_on_a_device_are_those_of_the_processor() {
    let (device, queue) = with_passthrough();
    let on_device = gpu::light_fields(&device, &queue);
    for (name, mut scene) in skies() {
        scene.camera.size = "128x64".parse().unwrap();
        for path in [PathChoice::Lookup, PathChoice::Direct] {
            scene.render.path = path;
            let scene = scene.clone().validated().unwrap();
            let [found, expected] = [&on_device, &LightFields::default()]
                .map(|fields| Plan::with_light_fields(&scene, PixelFormat::LinearRgb, fields));
            let image = |plan: &Plan| -> Vec<f32> {
                Cpu.run(plan, plan.kernel()).unwrap().words.into_iter().map(f32::from_bits).collect()
            };
            let worst = worst_in_images(&image(&found), &image(&expected), 128, 3, 1e-3);
            let exposure = f64::from(found.uniform.exposure / expected.uniform.exposure) - 1.0;
            println!("{name}, {path:?}: {:.1e}, exposure {exposure:.1e}", worst.relative);
            // The fit learns from light that is off by that much, and has slopes of up to ten. A sky lookup may have a row more or less: either is within 1e-3
            // of the integral.
            let bound = if path == PathChoice::Lookup { 1e-3 } else { 10.0 * SAME_FUNCTION };
            assert!(worst.relative < bound && exposure.abs() < bound, "{name}, {path:?}: {worst:?}, {exposure:e}");
        }
    }
}

#[test]
fn spectra_of_a_sky_planned_on_a_device_are_those_of_the_processor() {
    let (device, queue) = with_passthrough();
    let on_device = gpu::light_fields(&device, &queue);
    let wavelengths: Vec<f64> = (0..=40).map(|i| 380.0 + 10.0 * f64::from(i)).collect();
    let views =
        [(2.0, 0.0), (20.0, 60.0), (75.0, 170.0)].map(|(elevation, azimuth)| direction(elevation, azimuth).as_vec3());
    let mut before = Vec::new();
    for (name, scene) in skies().into_iter().filter(|(name, _)| name.starts_with("standard")) {
        let spectra = |fields: &LightFields| -> Vec<f32> {
            let plan = SpectralPlan::new(&planned(&scene, fields), &wavelengths);
            plan.radiance_of_directions(&views).into_iter().map(|radiance| radiance as f32).collect()
        };
        let (found, expected) = (spectra(&on_device), spectra(&LightFields::default()));
        let off = apart(&found, &expected);
        println!("{name}: {off:.1e}");
        // As of pictures: slopes of up to ten multiply what the light is off.
        assert!(off < 10.0 * SAME_FUNCTION, "{name}: {off:e}");
        before.push(expected);
    }
    assert!(apart(&before[1], &before[0]) > 0.1, "negative control");
}

#[test]
fn a_device_that_passes_nothing_through_plans_the_same_sky() {
    let (device, queue) = opened(wgpu::Features::empty());
    let scene = &skies()[3].1;
    let [found, expected] = [&gpu::light_fields(&device, &queue), &LightFields::default()]
        .map(|fields| planned(scene, fields).integral().clone());
    let off = apart(&flat(&found.multiple), &flat(&expected.multiple));
    assert!(off > 0.0 && off < SAME_FUNCTION, "{off:e}");
}

#[test]
fn where_the_device_is_lost_the_processor_plans() {
    let (device, queue) = with_passthrough();
    let fields = gpu::light_fields(&device, &queue);
    let scene = &skies()[0].1;
    let rows = |fields: &LightFields| planned(scene, fields).colours().rows.clone();
    let before = rows(&fields);
    device.destroy();
    let (lost, processor) = (rows(&fields.emptied()), rows(&LightFields::default()));
    assert!(lost == processor, "to the bit");
    assert!(before != processor, "negative control: a device rounds in its own way");
    // Fields that are kept in it are lost with it.
    assert!(rows(&fields) == processor);
}

#[test]
fn kernels_of_plans_on_a_device_are_their_functions_on_the_processor() {
    let (device, queue) = with_passthrough();
    let mut seen = HashSet::new();
    for (name, scene) in skies().into_iter().filter(|(name, _)| name.contains("sun at 2°") || name.contains("-4°")) {
        let interpreted = Arc::new(Interpreted::default());
        let fields = LightFields::on_device(interpreted.clone());
        let [found, expected] =
            [&gpu::light_fields(&device, &queue), &fields].map(|fields| planned(&scene, fields).integral().clone());
        assert!(interpreted.calls() > 0);
        let off = apart(&flat(&found.multiple), &flat(&expected.multiple));
        println!("{name}: {off:.1e}");
        assert!(off < SAME_FUNCTION, "{name}: {off:e}");
        seen.insert(found.variant);
    }
    assert!(seen.len() > 3, "skies of several variants");
}

#[test]
fn a_sky_that_a_device_planned_is_drawn_without_asking_it_again() {
    let device = Arc::new(Interpreted::default());
    let sky = planned(&skies()[1].1, &LightFields::on_device(device.clone()));
    assert!(device.calls() > 0, "its samples");
    sky.colours();
    let asked = device.calls();
    for projection in [Projection::Equirectangular, Projection::Perspective, Projection::Fisheye] {
        for pixel in [PixelFormat::LinearRgb, PixelFormat::Picture] {
            let camera = CameraScene { projection, size: "256x128".parse().unwrap(), ..CameraScene::default() };
            Plan::seen(&sky, &camera, pixel).unwrap();
        }
    }
    assert_eq!(device.calls(), asked);
    // A sun near by finds the light fields made; the other questions are asked again.
    let mut near = skies()[1].1.clone();
    near.sun.elevation += 0.01;
    let again = planned(&near, &sky.base.light_fields);
    again.colours();
    assert!(device.calls() > asked && device.calls() < 2 * asked, "{} after {asked}", device.calls());
}

/// A device whose kernels write nothing.
struct Broken(Interpreted);

impl PlanDevice for Broken {
    fn reserve(&self, numbers: usize) -> Option<Memory> {
        self.0.reserve(numbers)
    }

    fn run(&self, work: &Work<'_>) -> Option<Vec<Vec4>> {
        let &Work { variant, bands, quadratures, tables, memory, .. } = work;
        self.0.run(&Work {
            steps: &[],
            variant,
            bands,
            quadratures,
            tables,
            memory,
            keep: None,
            read: work.read.clone(),
        })
    }

    fn look(&self, at: &[Look<'_>]) -> Option<Vec<Vec<Parts<Vec4>>>> {
        let nothing = Parts { air: Vec4::NAN, ..Parts::default() };
        Some(at.iter().map(|look| vec![nothing; look.views.len() * look.buffers.bands.len()]).collect())
    }
}

#[test]
fn where_the_device_finds_no_numbers_the_processor_plans() {
    let scene = &skies()[2].1;
    let colours = |fields: &LightFields| {
        let sky = planned(scene, fields);
        (sky.integral().multiple.clone(), sky.colours().rows.clone(), sky.colours().exposure, sky.lookup_grid(true))
    };
    let broken = LightFields::on_device(Arc::new(Broken(Interpreted::default())));
    assert!(colours(&broken) == colours(&LightFields::default()), "to the bit");
}
