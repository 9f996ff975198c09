//! What a frame costs while the sun moves: its plan, which keeps the light fields of the frames before, and its
//! kernels.

use std::time::{Duration, Instant};

use serde::Serialize;
use sorairo::scene::{Preset, Scene, Size};
use sorairo::{Device, LightFields, PixelFormat, Plan};

use super::resident::Resident;
use super::timing::Spread;
use crate::problem::Result;

/// Frames of a sun that moves.
pub const FRAMES: u32 = 60;

/// Degrees by which it sinks from one to the next.
const STEP: f64 = 0.25;

/// Elevations (degrees) from which it sinks: by day, to the horizon, and through twilight.
const STARTS: [f64; 3] = [45.0, 15.0, 5.0];

/// What the frames of a sun that sinks cost: the default sky in light of all orders, linear pixels.
#[derive(Clone, Debug, Serialize)]
pub struct MovingSun {
    /// Elevation of the first frame's sun (degrees).
    pub from: f64,
    /// Elevation of the last one's.
    pub to: f64,
    /// Frames.
    pub frames: u32,
    /// Time of a frame's plan, the first's among them (ms).
    pub plan_ms: Spread,
    /// The mean of the same (ms).
    pub mean_plan_ms: f64,
    /// Time of a frame's kernels (ms).
    pub kernel_ms: Spread,
    /// Time of a frame from its scene to its last pixel, which is read and let go (ms).
    pub frame_ms: Spread,
    /// The mean of the same (ms).
    pub mean_frame_ms: f64,
    /// The mean time of a plan over that of the kernels.
    pub plan_over_kernels: f64,
    /// The median of the one over that of the other.
    pub median_plan_over_kernels: f64,
    /// Time of a frame whose pixels stay in a device of a program's own (ms); none on the CPU.
    pub resident_frame_ms: Option<Spread>,
    /// The mean of the same (ms).
    pub mean_resident_frame_ms: Option<f64>,
}

/// Renders the suns of [`STARTS`] on a device, so many frames of each.
///
/// # Errors
///
/// A device that fails.
pub fn moving_suns(device: &Device, size: Size, frames: u32) -> Result<Vec<MovingSun>> {
    let mut resident = Resident::beside(device, size)?;
    STARTS.into_iter().map(|from| moving_sun(device, resident.as_mut(), (size, frames), from)).collect()
}

fn moving_sun(
    device: &Device,
    resident: Option<&mut Resident>,
    (size, count): (Size, u32),
    from: f64,
) -> Result<MovingSun> {
    let scenes: Vec<Scene> = (0..count).map(|frame| sky(size, from - STEP * f64::from(frame))).collect();
    let (mut plans, mut kernels, mut frames) = (Vec::new(), Vec::new(), Vec::new());
    let light_fields = device.backend.light_fields().emptied();
    // A frame of another sky readies the device's pipelines and buffers.
    frame(device, &scenes[0], &light_fields.emptied())?;
    for scene in &scenes {
        let (plan, kernel, whole) = frame(device, scene, &light_fields)?;
        plans.push(plan);
        kernels.push(kernel);
        frames.push(whole);
    }
    let resident = resident.map(|resident| resident_frames(resident, &scenes)).transpose()?;
    let mean = |times: &[Duration]| times.iter().sum::<Duration>().as_secs_f64() * 1e3 / f64::from(count);
    let (mean_plan_ms, mean_frame_ms) = (mean(&plans), mean(&frames));
    let plan_over_kernels = mean_plan_ms / mean(&kernels);
    let (plan_ms, kernel_ms) = (Spread::of(plans), Spread::of(kernels));
    Ok(MovingSun {
        from,
        to: scenes[count as usize - 1].sun.elevation,
        frames: count,
        plan_ms,
        mean_plan_ms,
        kernel_ms,
        frame_ms: Spread::of(frames),
        mean_frame_ms,
        plan_over_kernels,
        median_plan_over_kernels: plan_ms.median / kernel_ms.median,
        mean_resident_frame_ms: resident.as_deref().map(mean),
        resident_frame_ms: resident.map(Spread::of),
    })
}

/// The times of the same frames in a program's own device.
fn resident_frames(resident: &mut Resident, scenes: &[Scene]) -> Result<Vec<Duration>> {
    let light_fields = resident.light_fields().emptied();
    resident.frame(&scenes[0], &light_fields.emptied())?;
    scenes.iter().map(|scene| resident.frame(scene, &light_fields)).collect()
}

/// The default sky under a sun.
fn sky(size: Size, sun: f64) -> Scene {
    let mut scene = Scene::preset(Preset::Standard);
    (scene.sun.elevation, scene.camera.size) = (sun, size);
    scene
}

/// The times of a plan, of its kernels and of the whole frame.
fn frame(device: &Device, scene: &Scene, light_fields: &LightFields) -> Result<(Duration, Duration, Duration)> {
    let start = Instant::now();
    let plan = Plan::with_light_fields(&scene.validated()?, PixelFormat::LinearRgb, light_fields);
    let planned = start.elapsed();
    let let_go = |_, rows: &[u32]| {
        std::hint::black_box(rows);
        Ok(())
    };
    let times = device.backend.rows(&plan, plan.kernel(), 0, &mut { let_go })?;
    Ok((planned, times.kernel, start.elapsed()))
}
