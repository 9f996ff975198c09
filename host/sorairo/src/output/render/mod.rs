//! From a scene to files.

use std::sync::Arc;
use std::time::Instant;

use crate::device::Device;
use crate::error::Result;
use crate::measure::broadband::Broadband;
use crate::measure::irradiance::SkyLight;
use crate::measure::spectral_irradiance::SpectralIrradiance;
use crate::measure::spectrum;
use crate::plan::LightFields;
use crate::scene::ValidScene;

mod compute;
mod job;
mod report;
mod request;

pub use compute::{Files, compute};
pub use job::Job;
use report::ms;
pub use report::{Report, Shown};
pub use request::Request;

/// Renders a scene into files; the device is opened once the request is known to be right.
///
/// # Errors
///
/// What is wrong with the device or the files' names, before any work; [`crate::Error::Device`] or
/// [`crate::Error::Write`] for a failed device or file.
pub fn render(
    scene: &ValidScene,
    request: &Request,
    open: impl FnOnce() -> Result<Device>,
    stage: impl Fn(&str),
) -> Result<Report> {
    let start = Instant::now();
    let jobs = Job::all(scene, request, &LightFields::default())?;
    render_jobs(start, &jobs, request, open, stage)
}

/// Renders jobs of one sky, and reports the first. All files take their places together.
fn render_jobs(
    start: Instant,
    jobs: &[Job],
    request: &Request,
    open: impl FnOnce() -> Result<Device>,
    stage: impl Fn(&str),
) -> Result<Report> {
    let (job, scene) = jobs.first().map(|job| (job, &job.scene)).expect("there is a job");
    let planned = start.elapsed();
    stage("opening the device");
    let mut device = open()?;
    let replaced = jobs.iter().flat_map(Job::replaced).collect();
    stage("computing the sky");
    let (times, encoding) = std::thread::scope(|scope| {
        let (times, files) = compute(jobs, scope, &mut device)?;
        stage("writing files");
        let computed = Instant::now();
        files.finish().map(|()| (times, computed.elapsed()))
    })?;
    let plan = job.plan();
    let sky_light = request.sky_light.then(|| {
        stage("measuring the sky's light");
        SkyLight::new(plan.sky.plan())
    });
    let broadband = if request.sky_light { Broadband::new(plan.sky.plan()) } else { None };
    let spectral = plan.spectral.as_ref().filter(|_| request.sky_light);
    let spectral_irradiance = spectral.map(|spectral| {
        let (spectra, sun) = (spectrum::Spectra::planned(Arc::clone(spectral)), job.first().sun());
        SpectralIrradiance::by(&spectra, plan.sky.plan(), &sun, plan.wavelengths())
    });
    Ok(Report {
        device: device.name,
        backend: device.kind,
        width: plan.width(),
        height: plan.height(),
        sun_elevation: scene.sun.elevation,
        sun_apparent_elevation: scene.apparent_elevation(),
        sun_azimuth: scene.sun.azimuth,
        sun_disc: scene.sun.disc,
        fit: scene.render.fit,
        color: scene.render.color,
        rgb: plan.sky.plan().space.rgb,
        observer: plan.sky.plan().observer,
        white_balance: plan.sky.plan().space.balance,
        steps: plan.samples_per_piece(),
        path: plan.lookup.clone(),
        explain: job.explain(),
        exposure_ev: job.picture().exposure(),
        exr_exposure_ev: plan.linear_exposure(scene.render.exr),
        sky_light,
        broadband,
        spectral_irradiance,
        plan_ms: ms(planned),
        kernel_ms: ms(times.kernel),
        readback_ms: ms(times.readback),
        encode_ms: ms(encoding),
        total_ms: ms(start.elapsed()),
        outputs: jobs.iter().flat_map(|job| &job.outputs).cloned().collect(),
        replaced,
    })
}
