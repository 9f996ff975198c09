//! `sorairo bench --speed`: what an image costs, against writing its pixels once.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::bench::{looked_up, with_lookup};
use super::chart::{Chart, Panel, Point};
use super::document::{Machine, make_folder, table, write};
use super::error::plan;
use super::moving_sun::{FRAMES, MovingSun, moving_suns};
use super::timing::{Care, Job, Spread, Times, job, repeated, streamed};
use crate::problem::{Error, Result};
use sorairo::low_level::plan::Kernel;
use sorairo::low_level::plan::lookup::LookupSize;
use sorairo::scene::{Exposure, Orders, PathChoice, Preset, Projection, Scene, Size, ViewTransform};
use sorairo::{Device, DeviceKind, LightFields, PixelFormat, Plan};

/// How much is measured.
#[derive(Clone, Copy)]
struct Extent {
    quick: bool,
    care: Care,
    /// The image on which paths and kernels are compared.
    common: Size,
    /// Images of 2 to this power of pixels are the largest.
    largest: u32,
    /// How often the window is opened, an odd number.
    windows: usize,
    /// Skies that it counts.
    skies: u32,
    /// Frames of a sun that moves.
    frames: u32,
}

impl Extent {
    fn of(quick: bool) -> Self {
        let care = Care::of(quick);
        if quick {
            let common = Size { width: 256, height: 128 };
            Self { quick, care, common, largest: 21, windows: 1, skies: 12, frames: 4 }
        } else {
            let common = Size { width: 1920, height: 960 };
            Self { quick, care, common, largest: 25, windows: 3, skies: 120, frames: FRAMES }
        }
    }
}

/// A path that would take longer than this for an image is not timed at larger sizes.
const PATIENCE: Duration = Duration::from_millis(1500);

/// Time against the number of pixels.
#[derive(Clone, Debug, Serialize)]
struct Scaling {
    way: &'static str,
    pixels: u64,
    kernel: Spread,
    megapixels_per_second: f64,
}

/// A kernel's time as a multiple of writing the same pixels once.
#[derive(Clone, Debug, Serialize)]
struct Multiple {
    kernel: &'static str,
    kernel_ms: Spread,
    times_fill: f64,
}

/// How fast a device writes pixels, and how near its kernels come to that.
#[derive(Clone, Debug, Serialize)]
struct Roofline {
    device: String,
    gigabytes_per_second: f64,
    kernels: Vec<Reached>,
}

/// A kernel beside the least time for its pixels: to write them once.
#[derive(Clone, Debug, Serialize)]
struct Reached {
    kernel: &'static str,
    megabytes: f64,
    memory_ms: f64,
    kernel_ms: Spread,
    /// The least time over the kernel's.
    reached: f64,
}

/// Time and error of a sky lookup of some size.
#[derive(Clone, Debug, Serialize)]
struct LookupRow {
    projection: Projection,
    #[serde(rename = "table")]
    lookup: LookupSize,
    kernel_ms: Spread,
    rmse_over_mean: f64,
}

/// Time of every pixel's integral with some samples.
#[derive(Clone, Debug, Serialize)]
struct StepRow {
    steps: u32,
    kernel_ms: Spread,
}

/// Time of a picture by a view transform.
#[derive(Clone, Debug, Serialize)]
struct TransformRow {
    view: &'static str,
    kernel_ms: Spread,
    /// Beside a picture of linear light in the curve of sRGB.
    times_ungraded: f64,
}

/// What light of all orders costs beside light that is scattered once: the default sky with the same ground, hence the
/// same lit pixels.
#[derive(Clone, Debug, Serialize)]
struct OrdersRow {
    /// Elevation of the sun (degrees).
    sun: f64,
    way: &'static str,
    once_ms: Spread,
    all_ms: Spread,
    all_over_once: f64,
}

/// What the plan of an image takes whose light is integrated on the device, beside one that the processor integrates;
/// each with its light fields to be made, and with those of a sun near by.
#[derive(Clone, Debug, Serialize)]
struct PlanRow {
    /// Elevation of the sun (degrees).
    sun: f64,
    on_processor_ms: Spread,
    on_device_ms: Spread,
    on_processor_with_fields_ms: Spread,
    on_device_with_fields_ms: Spread,
}

/// What a picture costs from an altitude and under a sun, beside the same picture from the ground with the sun at 30°.
#[derive(Clone, Debug, Serialize)]
struct PlaceRow {
    projection: Projection,
    /// Altitude of the observer (km).
    altitude: f64,
    /// Elevation of the sun (degrees).
    sun: f64,
    /// Anchors of its sky lookup; its pixels, where all are integrated.
    integrals: u64,
    kernel_ms: Spread,
    times_ground: f64,
}

/// What the window shows while its sun moves, as `sorairo view --frames` counts it.
#[derive(Clone, Debug, Serialize)]
struct Window {
    size: String,
    /// In each of some runs.
    skies: u32,
    skies_per_second: Spread,
    /// Skies whose pixels were read back, in all runs.
    read_back: u32,
}

/// Everything that was measured. The JSON keeps the keys that it always had.
#[derive(Clone, Debug, Serialize)]
pub struct Speed {
    machine: Machine,
    /// How often each time was measured.
    rounds: usize,
    #[serde(skip)]
    care: Care,
    /// The image on which paths and kernels are compared.
    size: String,
    scaling: Vec<Scaling>,
    /// Exponent of time against pixels above 2^20, for the sky lookup.
    exponent: f64,
    multiples: Vec<Multiple>,
    #[serde(rename = "tables")]
    lookups: Vec<LookupRow>,
    steps: Vec<StepRow>,
    transforms: Vec<TransformRow>,
    orders: Vec<OrdersRow>,
    /// Of perspectives, then of maps: over altitudes with the sun at 30° and at 0°, then over suns from the ground and
    /// from an eye's height above it.
    places: Vec<PlaceRow>,
    /// None on the CPU.
    plans: Vec<PlanRow>,
    /// Frames of a sun that moves, on the device and on the CPU.
    moving_sun: Vec<MovingSun>,
    moving_sun_on_cpu: Vec<MovingSun>,
    /// Pixels per second by the sky lookup over those by the integral at every pixel.
    #[serde(rename = "table_over_direct")]
    lookup_over_direct: f64,
    /// Time of the kernels by the sky lookup (ms).
    #[serde(rename = "table_ms")]
    lookup_ms: Spread,
    /// Million pixels per second by the sky lookup, by the median time.
    lookup_megapixels_per_second: f64,
    /// Time of the CPU backend over that of the device, by the sky lookup and by the integral.
    cpu_over_device: [f64; 2],
    /// The same of the default sky, in light of all orders.
    cpu_over_device_in_all_orders: [f64; 2],
    /// None where this build has no window, or no display would show it.
    window: Option<Window>,
    /// How fast the device and the CPU write pixels, and what their kernels reach of it, by light of one order.
    rooflines: Vec<Roofline>,
    /// Wall time of a cold process that renders 1024x512 to PNG (ms).
    first_picture_ms: Spread,
    /// Largest memory that the process held (MiB), where the system tells.
    peak_memory_mib: Option<f64>,
}

/// Measures and writes `speed.json`, `speed.md`, `speed.svg` and `speed.png` into a folder.
///
/// # Errors
///
/// [`Error::Folder`] for a folder that cannot be made; [`Error::Sky`] for a device or a file that fails.
pub fn speed(folder: &Path, device: &Device, quick: bool, stage: &dyn Fn(&str)) -> Result<Speed> {
    make_folder(folder)?;
    let extent = Extent::of(quick);
    stage("timing a cold process");
    let first_picture_ms = cold_process(folder, &device.name, device.kind, extent)?;
    stage("counting skies of the window");
    let window = window(device, extent)?;
    stage("timing sizes");
    let scaling = scaling(device, extent)?;
    stage("timing kernels");
    let multiples = multiples(device, extent)?;
    stage("timing sizes of the sky lookup");
    let lookups = lookups(device, extent)?;
    stage("timing samples");
    let steps = steps(device, extent)?;
    stage("timing view transforms");
    let transforms = transforms(device, extent)?;
    stage("timing orders of scattering");
    let orders = orders(device, extent)?;
    stage("timing altitudes and suns");
    let places = [Projection::Perspective, Projection::Equirectangular];
    let places =
        places.map(|projection| places_of(device, projection, extent)).into_iter().collect::<Result<Vec<_>>>()?;
    stage("timing plans");
    let plans = plans(device, extent)?;
    stage("timing a sun that moves");
    let moving = |device: &Device| moving_suns(device, extent.common, extent.frames);
    let (moving_sun, moving_sun_on_cpu) = (moving(device)?, moving(&sorairo::Device::cpu())?);
    stage("measuring limits");
    let rooflines = rooflines(device, &multiples, extent)?;
    stage("timing paths");
    let paths = paths(device, [with_lookup(extent.common)?, integrated(extent.common)?], extent)?;
    let in_all_orders = self::paths(device, in_all_orders(extent.common)?, extent)?;
    let speed = Speed {
        machine: Machine::new(device),
        rounds: extent.care.rounds,
        care: extent.care,
        size: extent.common.to_string(),
        exponent: exponent(&scaling),
        lookup_ms: paths.lookup,
        lookup_megapixels_per_second: f64::from(extent.common.width * extent.common.height) / paths.lookup.median / 1e3,
        scaling,
        multiples,
        lookups,
        steps,
        transforms,
        orders,
        places: places.concat(),
        plans,
        moving_sun,
        moving_sun_on_cpu,
        rooflines,
        lookup_over_direct: paths.direct.median / paths.lookup.median,
        cpu_over_device: paths.cpu_over_device(),
        cpu_over_device_in_all_orders: in_all_orders.cpu_over_device(),
        window,
        first_picture_ms,
        peak_memory_mib: peak_memory(),
    };
    write(&folder.join("speed.json"), &serde_json::to_string_pretty(&speed).expect("measurements are plain data"))?;
    write(&folder.join("speed.md"), &speed.markdown())?;
    speed.chart().write(folder, "speed")?;
    Ok(speed)
}

/// Starts this program anew and renders a picture, several times.
fn cold_process(folder: &Path, device: &str, kind: DeviceKind, extent: Extent) -> Result<Spread> {
    let program = program()?;
    let picture = folder.join(".first-picture.png");
    let mut durations = Vec::new();
    for _ in 0..extent.care.rounds {
        let start = Instant::now();
        let status = Command::new(&program)
            .args([
                "render",
                "--size",
                "1024x512",
                "--device",
                if kind == DeviceKind::Cpu { "cpu" } else { device },
                "-o",
            ])
            .arg(&picture)
            .stderr(Stdio::null())
            .status()
            .map_err(not_started)?;
        durations.push(start.elapsed());
        if !status.success() {
            return Err(Error::Nothing("a cold process did not render its picture".into()));
        }
    }
    // What is left of it is no part of the report.
    let _ = std::fs::remove_file(&picture);
    Ok(Spread::of(durations))
}

/// What `sorairo view --frames N --json` prints.
#[derive(Deserialize)]
struct Count {
    size: String,
    skies_per_second: f64,
    read_back: u32,
}

/// Opens the window several times, and has it count its skies.
fn window(device: &Device, extent: Extent) -> Result<Option<Window>> {
    let mut runs = Vec::new();
    for _ in 0..extent.windows {
        let skies = extent.skies.to_string();
        let name = if device.kind == DeviceKind::Cpu { "cpu" } else { &device.name };
        let counting = ["view", "--projection", "perspective", "--frames", &skies, "--json", "--device", name];
        let ended = Command::new(program()?).args(counting).stderr(Stdio::null()).output().map_err(not_started)?;
        if !ended.status.success() {
            return Ok(None);
        }
        let unread = |error| Error::Nothing(format!("the window's count cannot be read: {error}"));
        runs.push(serde_json::from_slice::<Count>(&ended.stdout).map_err(unread)?);
    }
    let mut rates: Vec<f64> = runs.iter().map(|run| run.skies_per_second).collect();
    rates.sort_by(f64::total_cmp);
    Ok(Some(Window {
        size: runs[0].size.clone(),
        skies: extent.skies,
        skies_per_second: Spread { median: rates[extent.windows / 2], min: rates[0], max: rates[extent.windows - 1] },
        read_back: runs.iter().map(|run| run.read_back).sum(),
    }))
}

fn not_started(error: std::io::Error) -> Error {
    Error::Nothing(format!("the program cannot be started anew: {error}"))
}

/// This program.
fn program() -> Result<PathBuf> {
    std::env::current_exe().map_err(not_started)
}

/// The default plan of an image, every pixel integrated.
fn integrated(size: Size) -> Result<Plan> {
    let mut scene = Scene::preset(Preset::Earth).first_order();
    scene.camera.size = size;
    plan(&scene)
}

/// Images of 2^16 pixels and more, by the sky lookup and by the integral. All sizes take turns, and the lookup's
/// large ones compute as many pixels in each: a machine whose speed changes meanwhile changes it for all of them.
fn scaling(device: &Device, extent: Extent) -> Result<Vec<Scaling>> {
    let largest = extent.largest;
    let mut plans = Vec::new();
    let mut direct_is_bearable = true;
    for power in (16..=largest).filter(|power| power % 2 == 1 || *power == 16 || *power >= FITTED_FROM) {
        let size = Size { width: 1 << power.div_ceil(2), height: 1 << (power / 2) };
        let images = if power >= FITTED_FROM { 1 << (largest - power) } else { 1 };
        plans.push(("sky lookup", power, images, with_lookup(size)?));
        if direct_is_bearable {
            let direct = integrated(size)?;
            let time = device.backend.run(&direct, direct.kernel())?.kernel;
            direct_is_bearable = time < PATIENCE / 4;
            plans.push(("every pixel integrated", power, 1, direct));
        }
    }
    let mut jobs: Vec<Job> =
        plans.iter().map(|(_, _, images, plan)| repeated(streamed(device, plan, plan.kernel()), *images)).collect();
    let times = extent.care.interleaved(&mut jobs)?;
    let row = |(&(way, power, _, _), kernel): (&(&'static str, u32, u32, Plan), Spread)| {
        let pixels = 1 << power;
        Scaling { way, pixels, kernel, megapixels_per_second: pixels as f64 / kernel.median / 1e3 }
    };
    Ok(plans.iter().zip(times.into_iter().map(|times| times.kernel)).map(row).collect())
}

/// Images of 2 to this power of pixels and more give the exponent.
const FITTED_FROM: u32 = 20;

/// The slope of ln time against ln pixels of the sky lookup above 2^20 pixels, by least squares.
fn exponent(rows: &[Scaling]) -> f64 {
    let points: Vec<(f64, f64)> = rows
        .iter()
        .filter(|row| row.way == "sky lookup" && row.pixels >= 1 << FITTED_FROM)
        .map(|row| ((row.pixels as f64).ln(), row.kernel.median.ln()))
        .collect();
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let covariance: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    covariance / points.iter().map(|point| (point.0 - x).powi(2)).sum::<f64>()
}

fn multiples(device: &Device, extent: Extent) -> Result<Vec<Multiple>> {
    let with_lookup = with_lookup(extent.common)?;
    let direct = integrated(extent.common)?;
    let plans = [
        ("writing every pixel once", &direct, Kernel::Fill, 32),
        ("sky lookup, all kernels", &with_lookup, with_lookup.kernel(), 8),
        ("every pixel integrated", &direct, direct.kernel(), 1),
    ];
    let mut jobs: Vec<Job> =
        plans.iter().map(|(_, plan, kernel, images)| repeated(job(device, plan, *kernel), *images)).collect();
    let times = extent.care.interleaved(&mut jobs)?;
    let fill = times[0].kernel.median;
    let row = |(&(kernel, ..), times): (&(&'static str, &Plan, Kernel, u32), Times)| Multiple {
        kernel,
        kernel_ms: times.kernel,
        times_fill: times.kernel.median / fill,
    };
    Ok(plans.iter().zip(times).map(row).collect())
}

/// Sky lookups from coarse to fine, timed and compared with the integral at every pixel: of an image that has the rows
/// of its lookup, and of one that does not.
fn lookups(device: &Device, extent: Extent) -> Result<Vec<LookupRow>> {
    let map = common(Projection::Equirectangular, extent.common);
    let mut rows = lookups_of(device, map, &[4, 8, 16, 32, 64].map(|columns| (0, columns)), extent.care)?;
    let grids = [(32, 8), (64, 16), (128, 16), (256, 32), (512, 64)];
    rows.extend(lookups_of(device, common(Projection::Fisheye, extent.common), &grids, extent.care)?);
    Ok(rows)
}

/// The default scene in so many pixels.
fn common(projection: Projection, size: Size) -> Scene {
    let mut scene = Scene::preset(Preset::Earth).first_order();
    (scene.camera.size, scene.camera.projection) = (size, projection);
    scene
}

/// Sky lookups of some rows (0: those that the plan chose) and azimuths.
fn lookups_of(device: &Device, scene: Scene, sizes: &[(u32, u32)], care: Care) -> Result<Vec<LookupRow>> {
    let projection = scene.camera.projection;
    let integrated = plan(&scene)?;
    let chosen = looked_up(scene)?;
    let planned = chosen.lookup.size.ok_or_else(|| Error::Nothing("the default scene has no sky lookup".into()))?;
    let sized = |&(above, azimuths): &(u32, u32)| {
        let size = LookupSize { above: if above > 0 { above } else { planned.above }, below: 0, azimuths };
        (size, chosen.clone().with_lookup(size))
    };
    let plans: Vec<(LookupSize, Plan)> = sizes.iter().map(sized).collect();
    let mut jobs: Vec<Job> = plans.iter().map(|(_, plan)| job(device, plan, plan.kernel())).collect();
    let times = care.interleaved(&mut jobs)?;
    let floats = |plan: &Plan| -> Result<Vec<f64>> {
        let words = device.backend.run(plan, plan.kernel())?.words;
        Ok(words.into_iter().map(|word| f64::from(f32::from_bits(word))).collect())
    };
    let truth = floats(&integrated)?;
    let mean = truth.iter().sum::<f64>() / truth.len() as f64;
    let row = |((lookup, plan), times): (&(LookupSize, Plan), Times)| {
        let square: f64 = floats(plan)?.iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum();
        let rmse_over_mean = (square / truth.len() as f64).sqrt() / mean;
        Ok(LookupRow { projection, lookup: *lookup, kernel_ms: times.kernel, rmse_over_mean })
    };
    plans.iter().zip(times).map(row).collect()
}

fn steps(device: &Device, extent: Extent) -> Result<Vec<StepRow>> {
    let counts = [4, 8, 12, 16, 32, 64];
    let sized = |steps| {
        let mut scene = Scene::preset(Preset::Earth).first_order();
        scene.camera.size = Size { width: 512, height: 256 };
        scene.render.steps = Some(steps);
        plan(&scene)
    };
    let plans: Vec<Plan> = counts.into_iter().map(sized).collect::<Result<_>>()?;
    let mut jobs: Vec<Job> = plans.iter().map(|plan| job(device, plan, plan.kernel())).collect();
    let times = extent.care.interleaved(&mut jobs)?;
    Ok(counts.into_iter().zip(times).map(|(steps, times)| StepRow { steps, kernel_ms: times.kernel }).collect())
}

/// Suns (degrees) at which orders are compared: day, and twilight.
const SUNS_OF_ORDERS: [f64; 3] = [30.0, 5.0, -4.0];

/// Kernels by the sky lookup and by the integral at every pixel, and the plan, with light of all orders and with light
/// scattered once.
fn orders(device: &Device, extent: Extent) -> Result<Vec<OrdersRow>> {
    let mut rows = Vec::new();
    for sun in SUNS_OF_ORDERS {
        let scene = |orders| {
            let mut scene = Scene::preset(Preset::Standard);
            (scene.sun.elevation, scene.camera.size, scene.render.orders) = (sun, extent.common, orders);
            scene
        };
        let scenes = [scene(Orders::UpTo(1)), scene(Orders::All)];
        let lookups = [looked_up(scenes[0].clone())?, looked_up(scenes[1].clone())?];
        let direct = scenes.clone().map(|mut scene| {
            scene.render.path = PathChoice::Direct;
            plan(&scene)
        });
        let [once, all] = direct;
        let direct = [once?, all?];
        let mut jobs: Vec<Job> = Vec::new();
        jobs.extend(lookups.iter().map(|plan| repeated(job(device, plan, plan.kernel()), 8)));
        jobs.extend(direct.iter().map(|plan| job(device, plan, plan.kernel())));
        jobs.extend(scenes.iter().map(planning));
        let times = extent.care.interleaved(&mut jobs)?;
        for (way, pair) in ["sky lookup", "every pixel integrated", "plan"].into_iter().zip(times.chunks(2)) {
            let (once, all) = (pair[0].kernel, pair[1].kernel);
            rows.push(OrdersRow { sun, way, once_ms: once, all_ms: all, all_over_once: all.median / once.median });
        }
    }
    Ok(rows)
}

/// Altitudes (km) of the curve over altitude.
const ALTITUDES: [f64; 13] = [0.0, 5e-4, 0.0017, 0.02, 0.1, 0.5, 3.0, 8.0, 12.0, 25.0, 60.0, 100.0, 400.0];

/// Suns (degrees) of the curve over the sun.
const SUNS_OF_PLACES: [f64; 11] = [90.0, 60.0, 15.0, 5.0, 0.0, -3.0, -6.5, -7.0, -9.0, -12.0, -18.0];

/// A picture, which in perspective looks a little below the level, from altitudes and under suns; all take turns.
/// A quick bench takes every fourth of them, and a smaller picture.
fn places_of(device: &Device, projection: Projection, extent: Extent) -> Result<Vec<PlaceRow>> {
    let over_altitude = [30.0, 0.0].into_iter().flat_map(|sun| ALTITUDES.map(|altitude| (altitude, sun)));
    let over_sun = [0.0, 0.0017].into_iter().flat_map(|altitude| SUNS_OF_PLACES.map(|sun| (altitude, sun)));
    let places: Vec<(f64, f64)> = over_altitude.chain(over_sun).step_by(if extent.quick { 4 } else { 1 }).collect();
    let (width, height) = if projection == Projection::Perspective { (960, 540) } else { (1024, 512) };
    let size = if extent.quick { Size { width: width / 4, height: height / 4 } } else { Size { width, height } };
    let planned = |&(altitude, sun): &(f64, f64)| {
        let mut scene = Scene::preset(Preset::Standard);
        (scene.observer.altitude, scene.sun.elevation) = (altitude, sun);
        (scene.camera.projection, scene.camera.look_elevation) = (projection, Some(-3.0));
        scene.camera.size = size;
        as_chosen(scene, PixelFormat::LinearRgb)
    };
    let plans: Vec<Plan> = places.iter().map(planned).collect::<Result<_>>()?;
    let mut jobs: Vec<Job> = plans.iter().map(|plan| job(device, plan, plan.kernel())).collect();
    let times = extent.care.interleaved(&mut jobs)?;
    // The first is from the ground with the sun at 30°.
    let ground = times[0].kernel.median;
    let row = |((&(altitude, sun), plan), times): ((&(f64, f64), &Plan), &Times)| PlaceRow {
        projection,
        altitude,
        sun,
        integrals: plan.lookup.anchors.map_or_else(|| plan.lit_pixels(), LookupSize::entries),
        kernel_ms: times.kernel,
        times_ground: times.kernel.median / ground,
    };
    Ok(places.iter().zip(&plans).zip(&times).map(row).collect())
}

/// A plan by the path that the scene chooses, unexposed.
fn as_chosen(mut scene: Scene, format: PixelFormat) -> Result<Plan> {
    scene.render.exposure = Exposure::Stops(0.0);
    Ok(Plan::new(&scene.validated()?, format))
}

/// The default sky as a picture by every view transform, beside linear floats.
fn transforms(device: &Device, extent: Extent) -> Result<Vec<TransformRow>> {
    let mut plans =
        vec![("none, linear floats", as_chosen(shown(ViewTransform::Srgb, extent.common), PixelFormat::LinearRgb)?)];
    for view in [ViewTransform::Srgb, ViewTransform::Agx, ViewTransform::Aces] {
        plans.push((view.into(), as_chosen(shown(view, extent.common), PixelFormat::Picture)?));
    }
    let mut jobs: Vec<Job> = plans.iter().map(|(_, plan)| job(device, plan, plan.kernel())).collect();
    let times = extent.care.interleaved(&mut jobs)?;
    let ungraded = times[1].kernel.median;
    let row = |(&(view, _), times): (&(&'static str, Plan), Times)| {
        let kernel_ms = times.kernel;
        TransformRow { view, kernel_ms, times_ungraded: kernel_ms.median / ungraded }
    };
    Ok(plans.iter().zip(times).map(row).collect())
}

/// The default sky in so many pixels, by a view transform.
fn shown(view: ViewTransform, size: Size) -> Scene {
    let mut scene = Scene::preset(Preset::Standard);
    (scene.camera.size, scene.render.view) = (size, view);
    scene
}

/// The job of planning a scene.
fn planning(scene: &Scene) -> Job<'_> {
    Box::new(move || {
        let start = Instant::now();
        std::hint::black_box(as_chosen(scene.clone(), PixelFormat::LinearRgb)?);
        Ok(start.elapsed())
    })
}

/// Plans of the default sky on the processor and on the device, each time of another sun that has the same light
/// fields.
fn plans(device: &Device, extent: Extent) -> Result<Vec<PlanRow>> {
    let suns = if extent.quick { &SUNS_OF_ORDERS[..1] } else { &SUNS_OF_ORDERS };
    let Some(own) = device.backend.own_light_fields() else { return Ok(Vec::new()) };
    let row = |&sun: &f64| {
        let kept = [LightFields::default(), own.emptied()];
        let mut number = 0;
        let mut next = || {
            number += 1;
            let mut scene = Scene::preset(Preset::Standard);
            // No two plans are of the same sun.
            (scene.sun.elevation, scene.camera.size) = (sun + 1e-4 * f64::from(number), extent.common);
            scene
        };
        let mut planned = |fields: LightFields| -> Result<Duration> {
            let scene = next().validated()?;
            let start = Instant::now();
            std::hint::black_box(Plan::with_light_fields(&scene, PixelFormat::LinearRgb, &fields));
            let time = start.elapsed();
            // A device that fails would be measured as the processor.
            if fields.device_uses().failed > 0 {
                return Err(sorairo::Error::Device(format!("device {:?} failed to plan", device.name)).into());
            }
            Ok(time)
        };
        let mut times: [Vec<Duration>; 4] = Default::default();
        for round in 0..=extent.care.rounds {
            let fields = [LightFields::default(), own.emptied(), kept[0].clone(), kept[1].clone()];
            for (times, fields) in times.iter_mut().zip(fields) {
                let time = planned(fields)?;
                if round > 0 {
                    times.push(time);
                }
            }
        }
        let [processor, device, processor_with_fields, device_with_fields] = times.map(Spread::of);
        Ok(PlanRow {
            sun,
            on_processor_ms: processor,
            on_device_ms: device,
            on_processor_with_fields_ms: processor_with_fields,
            on_device_with_fields_ms: device_with_fields,
        })
    };
    suns.iter().map(row).collect()
}

/// Times of an image's kernels (ms).
struct Paths {
    lookup: Spread,
    direct: Spread,
    cpu_lookup: Spread,
    cpu_direct: Spread,
}

impl Paths {
    /// Time of the CPU backend over that of the device, by the sky lookup and by the integral.
    fn cpu_over_device(&self) -> [f64; 2] {
        [self.cpu_lookup.median / self.lookup.median, self.cpu_direct.median / self.direct.median]
    }
}

/// The default sky in light of all orders: by the sky lookup, and every pixel integrated.
fn in_all_orders(size: Size) -> Result<[Plan; 2]> {
    let mut scene = Scene::preset(Preset::Standard);
    scene.camera.size = size;
    let with_lookup = looked_up(scene.clone())?;
    scene.render.path = PathChoice::Direct;
    Ok([with_lookup, plan(&scene)?])
}

/// The sky lookup against the integral at every pixel, and the CPU backend against the device, in one run.
fn paths(device: &Device, [with_lookup, direct]: [Plan; 2], extent: Extent) -> Result<Paths> {
    let cpu = sorairo::Device::cpu();
    let mut jobs = vec![
        repeated(job(device, &with_lookup, with_lookup.kernel()), 8),
        job(device, &direct, direct.kernel()),
        repeated(job(&cpu, &with_lookup, with_lookup.kernel()), 8),
        job(&cpu, &direct, direct.kernel()),
    ];
    let times: Vec<Spread> = extent.care.interleaved(&mut jobs)?.into_iter().map(|times| times.kernel).collect();
    Ok(Paths { lookup: times[0], direct: times[1], cpu_lookup: times[2], cpu_direct: times[3] })
}

/// The rates at which the device and the CPU write pixels, and what their kernels reach of them.
fn rooflines(device: &Device, multiples: &[Multiple], extent: Extent) -> Result<Vec<Roofline>> {
    let mut rooflines = vec![Roofline::of(device, multiples, extent.common)?];
    if device.kind != DeviceKind::Cpu {
        let cpu = sorairo::Device::cpu();
        rooflines.push(Roofline::of(&cpu, &self::multiples(&cpu, extent)?, extent.common)?);
    }
    Ok(rooflines)
}

impl Roofline {
    /// Of a device that took these times for the image.
    fn of(device: &Device, multiples: &[Multiple], size: Size) -> Result<Self> {
        let direct = integrated(size)?;
        let megabytes = 4e-6 * f64::from(direct.pixel_words()) * direct.lit_pixels() as f64;
        let least = multiples[0].kernel_ms.median;
        let reached = |row: &Multiple| Reached {
            kernel: row.kernel,
            megabytes,
            memory_ms: least,
            kernel_ms: row.kernel_ms,
            reached: 1.0 / row.times_fill,
        };
        Ok(Self {
            device: device.name.clone(),
            gigabytes_per_second: megabytes / least,
            kernels: multiples.iter().map(reached).collect(),
        })
    }
}

/// The largest resident memory of this process (MiB), as Linux tells it.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse::<f64>().ok().map(|kib| kib / 1024.0)
}

/// A roofline as a table.
fn limits(roofline: &Roofline) -> String {
    let row =
        |row: &Reached| vec![row.kernel.into(), row.kernel_ms.to_string(), format!("{:.0} %", 100.0 * row.reached)];
    let table = table(&["kernel", "kernels (ms)", "reached"], roofline.kernels.iter().map(row));
    format!("{}: {:.1} GB/s written.\n\n{table}\n", roofline.device, roofline.gigabytes_per_second)
}

impl Speed {
    fn markdown(&self) -> String {
        let scaling = self.scaling.iter().map(|row| {
            vec![
                row.way.into(),
                row.pixels.to_string(),
                row.kernel.to_string(),
                format!("{:.1}", row.megapixels_per_second),
            ]
        });
        let multiples = self
            .multiples
            .iter()
            .map(|row| vec![row.kernel.into(), row.kernel_ms.to_string(), format!("{:.2}", row.times_fill)]);
        let lookups = self.lookups.iter().map(|row| {
            vec![
                format!("{:?}", row.projection).to_lowercase(),
                format!("{}x{}", row.lookup.above, row.lookup.azimuths),
                row.kernel_ms.to_string(),
                format!("{:.1e}", row.rmse_over_mean),
            ]
        });
        let steps = self.steps.iter().map(|row| vec![row.steps.to_string(), row.kernel_ms.to_string()]);
        let transforms = self
            .transforms
            .iter()
            .map(|row| vec![row.view.into(), row.kernel_ms.to_string(), format!("{:.2}", row.times_ungraded)]);
        let orders = self.orders.iter().map(|row| {
            vec![
                row.sun.to_string(),
                row.way.into(),
                row.once_ms.to_string(),
                row.all_ms.to_string(),
                format!("{:.2}", row.all_over_once),
            ]
        });
        let places = self.places.iter().map(|row| {
            vec![
                format!("{:?}", row.projection).to_lowercase(),
                row.altitude.to_string(),
                row.sun.to_string(),
                row.integrals.to_string(),
                row.kernel_ms.to_string(),
                format!("{:.2}", row.times_ground),
            ]
        });
        let plans = self.plans.iter().map(|row| {
            let columns =
                [row.on_processor_ms, row.on_device_ms, row.on_processor_with_fields_ms, row.on_device_with_fields_ms];
            [row.sun.to_string()].into_iter().chain(columns.map(|spread| spread.to_string())).collect()
        });
        let on_both = self.moving_sun.iter().map(|row| ("this device", row));
        let on_both = on_both.chain(self.moving_sun_on_cpu.iter().map(|row| ("CPU", row)));
        let moving_sun = on_both.map(|(device, row)| {
            vec![
                device.into(),
                format!("{} to {}", row.from, row.to),
                row.plan_ms.to_string(),
                row.kernel_ms.to_string(),
                format!("{:.2}", row.plan_over_kernels),
                row.frame_ms.to_string(),
                format!("{:.1}", row.mean_frame_ms),
            ]
        });
        let [cpu_lookup, cpu_direct] = self.cpu_over_device;
        let [all_lookup, all_direct] = self.cpu_over_device_in_all_orders;
        let window = self.window.as_ref().map_or("not counted, without a display or a window".into(), |window| {
            let Window { size, skies_per_second: Spread { median, min, max }, read_back, .. } = window;
            format!("{median:.1} ({min:.1}–{max:.1}) skies of {size} a second, {read_back} read back")
        });
        let (size, care) = (&self.size, self.care);
        let memory = self.peak_memory_mib.map_or("not told by this system".into(), |mib| format!("{mib:.0} MiB"));
        format!(
            "# Speed\n\nOn {}. Medians (shortest–longest) of {care}, in ms, in turn with their rivals, and as \
             many images in each as last as long. \
             The default scene: earth preset, sun at 30°, regression fit, equirectangular, linear floats.\n\n\
             * Sky lookup over the integral at every pixel, {size}: **{:.1}** times the pixels per second.\n\
             * Sky lookup, {size}, of which the upper half can be lit: **{:.0}** million pixels per second ({} ms).\n\
             * Time against pixels above 2²⁰, sky lookup: exponent **{:.3}**.\n\
             * CPU backend over this device, time: **{cpu_lookup:.2}** by the lookup, **{cpu_direct:.2}** by the integral; of the \
             default sky in light of all orders {all_lookup:.2} and {all_direct:.2}.\n\
             * The window: {window}.\n\
             * A cold process, 1024x512 to PNG: **{} ms**.\n\
             * Peak memory of this run: {memory}.\n\n\
             ![Time against pixels](speed.png)\n\n{}\n\
             ## Kernels against writing the pixels once\n\n{size}, 12 bytes a pixel, the rows that can be lit.\n\n{}\n\
             ## What the kernels reach\n\n{}\n\
             ## Size of the sky lookup\n\n{size}; RMSE against the integral at every pixel, divided by the image's mean.\n\n{}\n\
             ## Samples per piece\n\n512x256, every pixel integrated.\n\n{}\n\
             ## View transforms\n\n{size}, standard preset, all orders, pictures of 8 bits.\n\n{}\n\
             ## Light of all orders\n\n{size}, standard preset; light scattered once over the same ground.\n\n{}\n\
             ## Altitudes and suns\n\n960x540 in perspective, 3° below the level, and maps of 1024x512, standard preset, all orders; beside the ground and a sun at 30°.\n\n{}\n\
             ## Plans\n\n{size}, standard preset, all orders (ms).\n\n{}\n\
             ## A sun that moves\n\n{size}, standard preset, all orders; frames a quarter of a degree apart.\n\n{}",
            self.machine,
            self.lookup_over_direct,
            self.lookup_megapixels_per_second,
            self.lookup_ms,
            self.exponent,
            self.first_picture_ms,
            table(&["way", "pixels", "kernels (ms)", "Mpx/s"], scaling),
            table(&["kernel", "kernels (ms)", "multiple"], multiples),
            self.rooflines.iter().map(limits).collect::<String>(),
            table(&["projection", "lookup", "kernels (ms)", "RMSE ÷ mean"], lookups),
            table(&["samples per piece", "kernels (ms)"], steps),
            table(&["view", "kernels (ms)", "times sRGB"], transforms),
            table(&["sun (°)", "", "scattered once (ms)", "all orders (ms)", "ratio"], orders),
            table(&["projection", "altitude (km)", "sun (°)", "integrals", "kernels (ms)", "times the ground"], places),
            table(&["sun (°)", "processor", "device", "processor, fields kept", "device, fields kept"], plans),
            table(
                &["device", "sun (°)", "plan (ms)", "kernels (ms)", "plan ÷ kernels", "frame (ms)", "mean frame (ms)"],
                moving_sun
            ),
        )
    }

    fn chart(&self) -> Chart {
        let series = ["sky lookup", "every pixel integrated"];
        let point = |row: &Scaling| Point {
            series: series.iter().position(|way| *way == row.way).unwrap_or_default(),
            radius: 5.0,
            x: row.pixels as f64 / 1e6,
            y: row.kernel.median,
            label: String::new(),
            default: false,
        };
        let found = format!("sky lookup: time grows as pixels^{:.2} above a million", self.exponent);
        Chart {
            title: "Time of an image against its pixels".into(),
            source: self.machine.to_string(),
            x: "megapixels".into(),
            y: "kernels (ms)".into(),
            series: series.into(),
            levels: vec![(1000.0 / 60.0, "60 frames a second")],
            panels: vec![Panel {
                title: "Default scene".into(),
                finding: found,
                points: self.scaling.iter().map(point).collect(),
            }],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponent_of_a_power_law_is_found() {
        let row = |pixels: u64| {
            let median = (pixels as f64).powf(0.9);
            let spread = Spread { median, min: median, max: median };
            Scaling { way: "sky lookup", pixels, kernel: spread, megapixels_per_second: 0.0 }
        };
        let rows: Vec<Scaling> = [1 << 18, 1 << 20, 1 << 22, 1 << 24].map(row).into();
        assert!((exponent(&rows) - 0.9).abs() < 1e-9);
    }
}
