//! The default sky in light of all orders: its plans, and its kernels over suns, altitudes and view transforms.

use std::time::{Duration, Instant};

use serde::Serialize;
use sorairo::low_level::plan::lookup::LookupSize;
use sorairo::scene::{Exposure, Orders, PathChoice, Preset, Projection, Scene, Size, ViewTransform};
use sorairo::{Device, LightFields, PixelFormat, Plan};

use super::extent::Extent;
use crate::bench::looked_up;
use crate::error::plan;
use crate::problem::Result;
use crate::timing::{Job, Spread, Times, job, repeated};

/// Time of a picture by a view transform.
#[derive(Clone, Debug, Serialize)]
pub(super) struct TransformRow {
    pub(super) view: &'static str,
    pub(super) kernel_ms: Spread,
    /// Beside a picture of linear light in the curve of sRGB.
    pub(super) times_ungraded: f64,
}

/// What light of all orders costs beside light that is scattered once: the default sky with the same ground, hence the
/// same lit pixels.
#[derive(Clone, Debug, Serialize)]
pub(super) struct OrdersRow {
    /// Elevation of the sun (degrees).
    pub(super) sun: f64,
    pub(super) way: &'static str,
    pub(super) once_ms: Spread,
    pub(super) all_ms: Spread,
    pub(super) all_over_once: f64,
}

/// What a picture costs from an altitude and under a sun, beside the same picture from the ground with the sun at 30°.
#[derive(Clone, Debug, Serialize)]
pub(super) struct PlaceRow {
    pub(super) projection: Projection,
    /// Altitude of the observer (km).
    pub(super) altitude: f64,
    /// Elevation of the sun (degrees).
    pub(super) sun: f64,
    /// Anchors of its sky lookup; its pixels, where all are integrated.
    pub(super) integrals: u64,
    pub(super) kernel_ms: Spread,
    pub(super) times_ground: f64,
}

/// What the plan of an image takes whose light is integrated on the device, beside one that the processor integrates;
/// each with its light fields to be made, and with those of a sun near by.
#[derive(Clone, Debug, Serialize)]
pub(super) struct PlanRow {
    /// Elevation of the sun (degrees).
    pub(super) sun: f64,
    pub(super) on_processor_ms: Spread,
    pub(super) on_device_ms: Spread,
    pub(super) on_processor_with_fields_ms: Spread,
    pub(super) on_device_with_fields_ms: Spread,
}

/// Suns (degrees) at which orders are compared: day, and twilight.
const SUNS_OF_ORDERS: [f64; 3] = [30.0, 5.0, -4.0];

/// Altitudes (km) of the curve over altitude.
const ALTITUDES: [f64; 13] = [0.0, 5e-4, 0.0017, 0.02, 0.1, 0.5, 3.0, 8.0, 12.0, 25.0, 60.0, 100.0, 400.0];

/// Suns (degrees) of the curve over the sun.
const SUNS_OF_PLACES: [f64; 11] = [90.0, 60.0, 15.0, 5.0, 0.0, -3.0, -6.5, -7.0, -9.0, -12.0, -18.0];

/// Kernels by the sky lookup and by the integral at every pixel, and the plan, with light of all orders and with light
/// scattered once.
pub(super) fn orders(device: &Device, extent: Extent) -> Result<Vec<OrdersRow>> {
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

/// A picture, which in perspective looks a little below the level, from altitudes and under suns; all take turns.
/// A quick bench takes every eighth of them, and a smaller picture.
pub(super) fn places_of(device: &Device, projection: Projection, extent: Extent) -> Result<Vec<PlaceRow>> {
    let over_altitude = [30.0, 0.0].into_iter().flat_map(|sun| ALTITUDES.map(|altitude| (altitude, sun)));
    let over_sun = [0.0, 0.0017].into_iter().flat_map(|altitude| SUNS_OF_PLACES.map(|sun| (altitude, sun)));
    let places: Vec<(f64, f64)> = over_altitude.chain(over_sun).step_by(if extent.quick { 8 } else { 1 }).collect();
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
pub(super) fn transforms(device: &Device, extent: Extent) -> Result<Vec<TransformRow>> {
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
pub(super) fn plans(device: &Device, extent: Extent) -> Result<Vec<PlanRow>> {
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

/// The default sky in light of all orders: by the sky lookup, and every pixel integrated.
pub(super) fn in_all_orders(size: Size) -> Result<[Plan; 2]> {
    let mut scene = Scene::preset(Preset::Standard);
    scene.camera.size = size;
    let with_lookup = looked_up(scene.clone())?;
    scene.render.path = PathChoice::Direct;
    Ok([with_lookup, plan(&scene)?])
}
