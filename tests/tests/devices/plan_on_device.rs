//! Plans whose light is integrated on a device, against those of the processor. Without a Vulkan device these tests
//! fail.

use std::collections::HashSet;
use std::sync::{Arc, Mutex};

use sorairo::low_level::device::{Backend, cpu::Cpu, gpu};
use sorairo::low_level::medium::aerosol::AerosolKind;
use sorairo::low_level::medium::profile::Profile;
use sorairo::low_level::plan::on_device::{DeviceUses, Memory, PlanDevice, PlanPass, Views};
use sorairo::low_level::plan::{GridKind, SpectralPlan, direction};
use sorairo::scene::{CameraScene, GroundAlbedo, Orders, PathChoice, Polarisation, Preset, Projection, Rgb, Scene};
use sorairo::{Direction, Error, LightFields, PixelFormat, Plan, Result, Sky, StokesFrame, wgpu};
use sorairo_shared::glam::Vec4;
use sorairo_shared::sky::ByConstituent;
use sorairo_tests::compare::worst_in_images;
use sorairo_tests::interpreted::Interpreted;
use sorairo_tests::own_device::{opened, with_passthrough};

/// What the devices' own `exp` and `ln` may leave of a value: (3 + 2 |x|) ULP by the Vulkan specification, at the
/// optical depths up to 40 that still count in a sum; as of the kernels of images. llvmpipe leaves 2e-6.
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
    for sun in [30.0, -3.0] {
        skies.push(of("air in closed form", Preset::Standard, sun, &|scene| {
            (scene.atmosphere.profile, scene.atmosphere.refraction) = (Profile::Exponential, false);
        }));
        skies.push(of("natural light", Preset::Standard, sun, &|scene| {
            scene.render.polarisation = Polarisation::Off;
        }));
        skies.push(of("closed form, polarised", Preset::Earth, sun, &|scene| {
            scene.render.polarisation = Polarisation::On;
        }));
    }
    for sun in [30.0, 2.0] {
        skies.push(of("hazy", Preset::Hazy, sun, &|_| {}));
        skies.push(of("12 km over snow", Preset::Standard, sun, &|scene| {
            scene.observer.altitude = 12.0;
            scene.ground.albedo = GroundAlbedo::Grey(0.9);
        }));
        skies.push(of("400 km", Preset::Standard, sun, &|scene| scene.observer.altitude = 400.0));
        skies.push(of("desert", Preset::Standard, sun, &|scene| scene.atmosphere.aerosol.kind = AerosolKind::Desert));
        skies.push(of("without aerosol", Preset::Standard, sun, &|scene| scene.atmosphere.aerosol.optical_depth = 0.0));
        skies.push(of("three orders", Preset::Standard, sun, &|scene| scene.render.orders = Orders::UpTo(3)));
    }
    skies
}

fn planned(scene: &Scene, fields: &LightFields) -> Sky {
    Sky::with_light_fields(&scene.clone().validated().unwrap(), Rgb::Srgb, fields)
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

/// What `plan` finds with light fields of a device that answers every question, and is asked some.
///
/// # Panics
///
/// If the processor answered any in its place: it would be compared with itself.
fn by_device_alone<T>(name: &str, fields: &LightFields, plan: impl FnOnce(&LightFields) -> T) -> T {
    let before = fields.device_uses();
    let found = plan(fields);
    let DeviceUses { answered, failed } = fields.device_uses();
    assert!(failed == before.failed, "{name}: the processor took the place of the device");
    assert!(answered > before.answered, "{name}: nobody asked the device");
    found
}

#[test]
fn multiply_scattered_light_of_a_device_is_that_of_the_processor() {
    let (device, queue) = with_passthrough();
    let on_device = gpu::light_fields(&device, &queue);
    let mut seen = Vec::new();
    for (name, scene) in skies() {
        let integral = |fields: &LightFields| planned(&scene, fields).plan().integral().clone();
        let (found, expected) = (by_device_alone(&name, &on_device, integral), integral(&LightFields::default()));
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
        let on_processor = LightFields::default();
        for path in [PathChoice::Lookup, PathChoice::Direct] {
            scene.render.path = path;
            let scene = scene.clone().validated().unwrap();
            let plan = |fields: &LightFields| Plan::with_light_fields(&scene, PixelFormat::LinearRgb, fields);
            let (found, expected) = (by_device_alone(&name, &on_device, plan), plan(&on_processor));
            let image = |plan: &Plan| -> Vec<f32> {
                Cpu.run(plan, plan.kernel()).unwrap().words.into_iter().map(f32::from_bits).collect()
            };
            let worst = worst_in_images(&image(&found), &image(&expected), 128, 3, 1e-3);
            let exposure = f64::from(found.uniform.exposure / expected.uniform.exposure) - 1.0;
            println!("{name}, {path:?}: {:.1e}, exposure {exposure:.1e}", worst.relative);
            // The fit learns from light that is off by that much, and has slopes of up to ten. A sky lookup may have a
            // row more or less: either is within 1e-3 of the integral.
            let bound = if path == PathChoice::Lookup { 2e-3 } else { 10.0 * SAME_FUNCTION };
            assert!(worst.relative < bound && exposure.abs() < bound, "{name}, {path:?}: {worst:?}, {exposure:e}");
        }
    }
}

#[test]
fn spectra_of_a_sky_planned_on_a_device_are_those_of_the_processor() {
    let (device, queue) = with_passthrough();
    let on_device = gpu::light_fields(&device, &queue);
    let wavelengths: Vec<f64> = (0..=20).map(|i| 380.0 + 20.0 * f64::from(i)).collect();
    let views =
        [(2.0, 0.0), (20.0, 60.0), (75.0, 170.0)].map(|(elevation, azimuth)| direction(elevation, azimuth).as_vec3());
    let mut before = Vec::new();
    // By day, with a low sun and in twilight.
    let suns = ["standard, sun at 60°", "standard, sun at 5°", "standard, sun at -4°"];
    let skies: Vec<_> = skies().into_iter().filter(|(name, _)| suns.contains(&name.as_str())).collect();
    assert_eq!(skies.len(), suns.len());
    for (name, scene) in skies {
        let spectra = |fields: &LightFields| -> Vec<f32> {
            let plan = SpectralPlan::new(planned(&scene, fields).plan(), &wavelengths);
            plan.radiance_of_directions(&views).into_iter().map(|radiance| radiance as f32).collect()
        };
        let (found, expected) = (by_device_alone(&name, &on_device, spectra), spectra(&LightFields::default()));
        let off = apart(&found, &expected);
        println!("{name}: {off:.1e}");
        // As of pictures: slopes of up to ten multiply what the light is off.
        assert!(off < 10.0 * SAME_FUNCTION, "{name}: {off:e}");
        before.push(expected);
    }
    assert!(apart(&before[1], &before[0]) > 0.1, "negative control");
}

#[test]
fn stokes_vectors_of_a_sky_planned_on_a_device_are_those_of_the_processor() {
    let (device, queue) = with_passthrough();
    let on_device = gpu::light_fields(&device, &queue);
    let directions: Vec<Direction> = [(3.0, 10.0), (20.0, 60.0), (75.0, 170.0), (60.0, 270.0)]
        .map(|(elevation, azimuth)| Direction { elevation, azimuth })
        .into();
    let suns = ["standard, sun at 60°", "standard, sun at 5°", "standard, sun at -4°", "hazy, sun at 30°"];
    let skies: Vec<_> = skies().into_iter().filter(|(name, _)| suns.contains(&name.as_str())).collect();
    assert_eq!(skies.len(), suns.len());
    for (name, scene) in skies {
        let stokes = |fields: &LightFields| {
            let spectra = planned(&scene, fields).stokes(&[400.0, 550.0, 700.0], StokesFrame::Vertical);
            spectra.unwrap().in_directions(&directions).unwrap()
        };
        let (found, expected) = (by_device_alone(&name, &on_device, stokes), stokes(&LightFields::default()));
        let mut polarised: f64 = 0.0;
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            let [found, expected] = [found, expected].map(|of| [of.stokes_i, of.stokes_q, of.stokes_u]);
            polarised = polarised.max(expected[1].hypot(expected[2]) / expected[0]);
            for (found, value) in found.into_iter().zip(expected) {
                // As of spectra: slopes of up to ten multiply what the light is off.
                let off = (found - value).abs() / expected[0];
                assert!(off < 10.0 * SAME_FUNCTION, "{name}: {found:e}, not {value:e}");
            }
        }
        assert!(polarised > 0.2, "{name}: light that is polarised, to {polarised}");
    }
}

#[test]
fn a_device_that_passes_nothing_through_plans_the_same_sky() {
    let (device, queue) = opened(wgpu::Features::empty());
    let scene = &skies()[3].1;
    let integral = |fields: &LightFields| planned(scene, fields).plan().integral().clone();
    let on_device = gpu::light_fields(&device, &queue);
    let (found, expected) = (by_device_alone("translated", &on_device, integral), integral(&LightFields::default()));
    let off = apart(&flat(&found.multiple), &flat(&expected.multiple));
    assert!(off > 0.0 && off < SAME_FUNCTION, "{off:e}");
}

#[test]
fn where_the_device_is_lost_the_processor_plans() {
    let (device, queue) = with_passthrough();
    let fields = gpu::light_fields(&device, &queue);
    let scene = &skies()[0].1;
    let rows = |fields: &LightFields| planned(scene, fields).plan().colours().rows.clone();
    let before = rows(&fields);
    device.destroy();
    let (lost, processor) = (rows(&fields.emptied()), rows(&LightFields::default()));
    assert!(lost == processor, "to the bit");
    assert!(before != processor, "negative control: a device rounds in its own way");
    // Fields that are kept in it are lost with it.
    assert!(rows(&fields) == processor);
    assert!(fields.device_uses().failed > 0);
}

#[test]
fn kernels_of_plans_on_a_device_are_their_functions_on_the_processor() {
    let (device, queue) = with_passthrough();
    let mut seen = HashSet::new();
    for (name, scene) in skies().into_iter().filter(|(name, _)| name.contains("sun at 2°") || name.contains("-4°")) {
        let interpreted = Arc::new(Interpreted::default());
        let fields = LightFields::on_device(interpreted.clone());
        let [found, expected] = [&gpu::light_fields(&device, &queue), &fields]
            .map(|fields| by_device_alone(&name, fields, |fields| planned(&scene, fields).plan().integral().clone()));
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
    sky.plan().colours();
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
    // Lower: at 15° a sun stands half way between two centres, and belongs to the one below.
    near.sun.elevation -= 0.01;
    let again = planned(&near, &sky.plan().base.light_fields);
    again.plan().colours();
    assert!(device.calls() > asked && device.calls() < 2 * asked, "{} after {asked}", device.calls());
}

/// A device of some name whose kernels write nothing.
struct Broken(Interpreted, &'static str);

impl PlanDevice for Broken {
    fn name(&self) -> String {
        self.1.into()
    }

    fn reserve(&self, numbers: usize) -> Result<Memory> {
        self.0.reserve(numbers)
    }

    fn run(&self, work: &PlanPass<'_>) -> Result<Vec<Vec4>> {
        let &PlanPass { variant, bands, quadratures, tables, columns, memory, .. } = work;
        self.0.run(&PlanPass {
            steps: &[],
            variant,
            bands,
            quadratures,
            tables,
            columns,
            memory,
            keep: None,
            read: work.read.clone(),
        })
    }

    fn light_of_views(&self, at: &[Views<'_>]) -> Result<Vec<Vec<ByConstituent<Vec4>>>> {
        let nothing = ByConstituent { air: Vec4::NAN, ..ByConstituent::default() };
        Ok(at.iter().map(|look| vec![nothing; look.views.len() * look.buffers.bands.len()]).collect())
    }
}

#[test]
fn where_the_device_finds_no_numbers_the_processor_plans() {
    let scene = &skies()[2].1;
    let colours = |fields: &LightFields| {
        let sky = planned(scene, fields);
        (
            sky.plan().integral().multiple.clone(),
            sky.plan().colours().rows.clone(),
            sky.plan().lookup_grid(GridKind::Rows),
        )
    };
    let broken = LightFields::on_device(Arc::new(Broken(Interpreted::default(), "broken")));
    assert!(colours(&broken) == colours(&LightFields::default()), "to the bit");
}

/// A device that has no memory left.
struct Full;

impl PlanDevice for Full {
    fn name(&self) -> String {
        "Full".into()
    }

    fn reserve(&self, _: usize) -> Result<Memory> {
        Err(Error::Device("it has no memory left".into()))
    }

    fn run(&self, _: &PlanPass<'_>) -> Result<Vec<Vec4>> {
        self.reserve(1).map(|_| Vec::new())
    }

    fn light_of_views(&self, _: &[Views<'_>]) -> Result<Vec<Vec<ByConstituent<Vec4>>>> {
        self.reserve(1).map(|_| Vec::new())
    }
}

/// Warnings of the library.
struct Warnings(Mutex<Vec<String>>);

static WARNINGS: Warnings = Warnings(Mutex::new(Vec::new()));

impl log::Log for Warnings {
    fn enabled(&self, _: &log::Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &log::Record<'_>) {
        if record.level() == log::Level::Warn {
            self.0.lock().unwrap().push(record.args().to_string());
        }
    }

    fn flush(&self) {}
}

#[test]
fn a_device_that_fails_plans_is_told_once_and_every_failure_counts() {
    log::set_logger(&WARNINGS).unwrap();
    log::set_max_level(log::LevelFilter::Warn);
    let scene = &skies()[2].1;
    for (device, reason) in [
        (Arc::new(Full) as Arc<dyn PlanDevice>, "it has no memory left"),
        (Arc::new(Broken(Interpreted::default(), "told")), "its kernels return values that are not finite"),
    ] {
        let name = device.name();
        let fields = LightFields::on_device(device);
        planned(scene, &fields).plan().colours();
        let after_one = fields.device_uses();
        // Its samples, what the fit learns, its light field, its exposure.
        assert!(after_one.failed >= 4 && after_one.answered == 0, "{name}: {after_one:?}");
        planned(scene, &fields.emptied()).plan().colours();
        assert!(fields.device_uses().failed > after_one.failed, "{name}: they count together");
        let warnings = WARNINGS.0.lock().unwrap();
        let warnings: Vec<_> = warnings.iter().filter(|warning| warning.contains(&format!("{name:?}"))).collect();
        assert!(warnings.len() == 1 && warnings[0].contains(reason), "{warnings:?}");
        assert!(warnings[0].ends_with("planning on the CPU"), "{warnings:?}");
    }
    let fields = LightFields::on_device(Arc::new(Interpreted::default()));
    planned(scene, &fields).plan().colours();
    let DeviceUses { answered, failed } = fields.device_uses();
    assert!(answered > 0 && failed == 0, "negative control");
    assert_eq!(LightFields::default().device_uses(), DeviceUses::default(), "the processor is no device");
}
