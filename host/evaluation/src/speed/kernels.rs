//! Kernels of an image in light that was scattered once: against its pixels, its lookup and its samples.

use std::time::Duration;

use serde::Serialize;
use sorairo::low_level::plan::Kernel;
use sorairo::low_level::plan::lookup::LookupSize;
use sorairo::scene::{Preset, Projection, Scene, Size};
use sorairo::{Device, DeviceKind, Plan};

use super::extent::Extent;
use crate::bench::{looked_up, with_lookup};
use crate::error::plan;
use crate::problem::{Error, Result};
use crate::timing::{Care, Job, Spread, Times, job, repeated, streamed};

/// A path that would take longer than this for an image is not timed at larger sizes.
const PATIENCE: Duration = Duration::from_millis(1500);

/// Images of 2 to this power of pixels and more give the exponent.
const FITTED_FROM: u32 = 20;

/// Time against the number of pixels.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Scaling {
    pub(super) way: &'static str,
    pub(super) pixels: u64,
    pub(super) kernel: Spread,
    pub(super) megapixels_per_second: f64,
}

/// A kernel's time as a multiple of writing the same pixels once.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Multiple {
    pub(super) kernel: &'static str,
    pub(super) kernel_ms: Spread,
    pub(super) times_fill: f64,
}

/// How fast a device writes pixels, and how near its kernels come to that.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Roofline {
    pub(super) device: String,
    pub(super) gigabytes_per_second: f64,
    pub(super) kernels: Vec<Reached>,
}

/// A kernel beside the least time for its pixels: to write them once.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Reached {
    pub(super) kernel: &'static str,
    pub(super) megabytes: f64,
    pub(super) memory_ms: f64,
    pub(super) kernel_ms: Spread,
    /// The least time over the kernel's.
    pub(super) reached: f64,
}

/// Time and error of a sky lookup of some size.
#[derive(Clone, Debug, Serialize)]
pub(super) struct LookupRow {
    pub(super) projection: Projection,
    #[serde(rename = "table")]
    pub(super) lookup: LookupSize,
    pub(super) kernel_ms: Spread,
    pub(super) rmse_over_mean: f64,
}

/// Time of every pixel's integral with some samples.
#[derive(Clone, Debug, Serialize)]
pub(super) struct StepRow {
    pub(super) steps: u32,
    pub(super) kernel_ms: Spread,
}

/// Times of an image's kernels (ms).
pub(super) struct Paths {
    pub(super) lookup: Spread,
    pub(super) direct: Spread,
    pub(super) cpu_lookup: Spread,
    pub(super) cpu_direct: Spread,
}

/// The default plan of an image, every pixel integrated.
pub(super) fn integrated(size: Size) -> Result<Plan> {
    let mut scene = Scene::preset(Preset::Earth).first_order();
    scene.camera.size = size;
    plan(&scene)
}

/// Images of 2^16 pixels and more, by the sky lookup and by the integral. All sizes take turns, and the lookup's
/// large ones compute as many pixels in each: a machine whose speed changes meanwhile changes it for all of them.
pub(super) fn scaling(device: &Device, extent: Extent) -> Result<Vec<Scaling>> {
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

/// The slope of ln time against ln pixels of the sky lookup above 2^20 pixels, by least squares.
pub(super) fn exponent(rows: &[Scaling]) -> f64 {
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

pub(super) fn multiples(device: &Device, extent: Extent) -> Result<Vec<Multiple>> {
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
pub(super) fn lookups(device: &Device, extent: Extent) -> Result<Vec<LookupRow>> {
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

pub(super) fn steps(device: &Device, extent: Extent) -> Result<Vec<StepRow>> {
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

impl Paths {
    /// Time of the CPU backend over that of the device, by the sky lookup and by the integral.
    pub(super) fn cpu_over_device(&self) -> [f64; 2] {
        [self.cpu_lookup.median / self.lookup.median, self.cpu_direct.median / self.direct.median]
    }
}

/// The sky lookup against the integral at every pixel, and the CPU backend against the device, in one run.
pub(super) fn paths(device: &Device, [with_lookup, direct]: [Plan; 2], extent: Extent) -> Result<Paths> {
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
pub(super) fn rooflines(device: &Device, multiples: &[Multiple], extent: Extent) -> Result<Vec<Roofline>> {
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
