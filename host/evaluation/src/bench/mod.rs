//! `sorairo bench`: run time against error, and the resident GPU path against reading back and fitting on the CPU.

use std::path::Path;
use std::time::Duration;

use rayon::prelude::*;
use sorairo_shared::glam::Vec4;

use crate::chart::Point;
use crate::document::{Machine, make_folder};
use crate::error::{Reference, SUNS, plan};
use crate::metrics::Errors;
use crate::problem::Result;
use crate::timing::{Care, Job, Times, fitting_size, job};
use crate::{light_field, readback};
use sorairo::low_level::plan::fit::{CUBIC_BANDS, FIRST_ORDER_BANDS, TRANSFER_BANDS};
use sorairo::low_level::spectra::observer;
use sorairo::scene::{ColourPath, Exposure, Fit, PathChoice, Preset, Scene, Size};
use sorairo::{Device, PixelFormat, Plan};

mod measured;
mod report;

use measured::{Air, FITS, TIMED_AT};
pub use measured::{Bench, Configuration, Measured, Way};
use report::point;

/// Integration steps that are compared.
const STEPS: [u32; 6] = [4, 6, 8, 12, 16, 32];

/// Elevation (degrees) from which on the sun counts as up: where the default number of steps changes.
const DAY: f64 = 5.0;

/// Measures and writes `bench.csv`, `bench.json`, `report.md`, and `pareto` and `light_field` as `.svg` and `.png` into
/// a folder. `quick` measures fewer suns and smaller images, each once.
///
/// # Errors
///
/// [`crate::Error::Folder`] for a folder that cannot be made; [`crate::Error::Sky`] for a device or a file that fails.
pub fn bench(folder: &Path, device: &Device, quick: bool, stage: &dyn Fn(&str)) -> Result<Bench> {
    make_folder(folder)?;
    let suns = if quick { vec![-4.0, 0.0, 10.0, 45.0] } else { SUNS.to_vec() };
    let care = Care::of(quick);
    let ways = ways(device, quick, stage)?;
    let budget = Duration::from_micros(if quick { 2_000 } else { 10_000 });
    let size = fitting_size(device, &Scene::preset(Preset::Earth).first_order(), budget)?;
    let configurations = configurations();
    stage("measuring errors");
    let errors = errors(&configurations, &suns, quick)?;
    let mut measured = Vec::new();
    for (light, sun) in ["day", "twilight"].into_iter().zip(TIMED_AT) {
        stage(&format!("timing fits by {light}"));
        let times = times(&configurations, device, size, sun, care)?;
        for ((configuration, times), errors) in configurations.iter().zip(times).zip(&errors) {
            measured.push(gather(configuration, light, times, errors)?);
        }
    }
    for light in ["day", "twilight"] {
        mark_unbeaten(measured.iter_mut().filter(|measured| measured.light == light).collect());
    }
    stage("timing light fields");
    let light_fields = light_field::light_fields(care)?;
    let bench = Bench {
        machine: Machine::new(device),
        rounds: care.rounds,
        care,
        timed_at: TIMED_AT,
        size: size.to_string(),
        suns,
        ways,
        configurations: measured,
        light_fields,
    };
    bench.write(folder)?;
    Ok(bench)
}

/// Every configuration that is compared; the program's own is the last.
fn configurations() -> Vec<Configuration> {
    let mut list = Vec::new();
    for (fit, _) in FITS {
        let counts: &[usize] = match fit {
            Fit::Cubic | Fit::Transfer => &[3, 4, 6, 8, 12],
            Fit::Regression => &[3, 4, 6, 8],
            Fit::Dense => &[12, 81],
        };
        for &count in counts {
            list.extend(STEPS.map(|steps| Configuration { fit, bands: bands(fit, count), steps: Some(steps) }));
        }
    }
    list.push(Configuration { fit: Fit::Regression, bands: bands(Fit::Regression, 4), steps: None });
    list
}

/// Good wavelengths (nm) for a fit. Polynomials take the roots of Chebyshev's, but with four the fit's own.
fn bands(fit: Fit, count: usize) -> Vec<f64> {
    match (fit, count) {
        (Fit::Cubic, 4) => CUBIC_BANDS.to_vec(),
        (Fit::Transfer, 4) => TRANSFER_BANDS.to_vec(),
        (Fit::Regression, 3) => vec![447.0, 544.0, 612.0],
        (Fit::Regression, 4) => FIRST_ORDER_BANDS.to_vec(),
        (Fit::Regression, 6) => vec![435.0, 475.0, 506.0, 555.0, 608.0, 659.0],
        (Fit::Regression, _) => vec![405.0, 456.0, 481.0, 512.0, 525.0, 558.0, 611.0, 662.0],
        (Fit::Dense, 81) => observer::wavelengths(),
        (Fit::Dense, _) => (0..count).map(|i| 400.0 + 330.0 * i as f64 / (count - 1) as f64).collect(),
        (Fit::Cubic | Fit::Transfer, _) => {
            let root = |i: usize| ((2 * i + 1) as f64 * std::f64::consts::PI / (2 * count) as f64).cos();
            (0..count).rev().map(|i| (550.0 + 150.0 * root(i)).round()).collect()
        }
    }
}

fn scene(configuration: &Configuration, sun: f64) -> Scene {
    let mut scene = Scene::preset(Preset::Earth).first_order();
    scene.sun.elevation = sun;
    scene.render.fit = configuration.fit;
    scene.render.bands = Some(configuration.bands.clone());
    scene.render.steps = configuration.steps;
    scene
}

/// For each configuration, its errors in each atmosphere by day and in twilight.
type Skies = Vec<(Air, bool, Errors)>;

fn errors(configurations: &[Configuration], suns: &[f64], quick: bool) -> Result<Vec<Skies>> {
    let airs =
        [(true, true), (false, false), (true, false), (false, true)].map(|(ozone, aerosol)| Air { ozone, aerosol });
    let airs = if quick { &airs[..2] } else { &airs[..] };
    let mut all: Vec<Skies> = vec![Vec::new(); configurations.len()];
    for &air in airs {
        for &sun in suns {
            let in_air = |mut scene: Scene| {
                scene.atmosphere.ozone.column *= f64::from(u8::from(air.ozone));
                scene.atmosphere.aerosol.optical_depth *= f64::from(u8::from(air.aerosol));
                scene
            };
            let reference = Reference::new(&in_air(scene(&configurations[0], sun)))?;
            let errors: Vec<Errors> = configurations
                .par_iter()
                .map(|configuration| Ok(reference.errors(&plan(&in_air(scene(configuration, sun)))?)))
                .collect::<Result<_>>()?;
            for (skies, errors) in all.iter_mut().zip(errors) {
                skies.push((air, sun >= DAY, errors));
            }
        }
    }
    Ok(all)
}

fn times(configurations: &[Configuration], device: &Device, size: Size, sun: f64, care: Care) -> Result<Vec<Times>> {
    let sized = |configuration: &Configuration| {
        let mut scene = scene(configuration, sun);
        scene.camera.size = size;
        plan(&scene)
    };
    let plans: Vec<Plan> = configurations.iter().map(sized).collect::<Result<_>>()?;
    let mut jobs: Vec<Job> = plans.iter().map(|plan| job(device, plan, plan.kernel())).collect();
    care.interleaved(&mut jobs)
}

fn gather(configuration: &Configuration, light: &'static str, times: Times, skies: &Skies) -> Result<Measured> {
    let day = light == "day";
    let sun = TIMED_AT[usize::from(!day)];
    let steps = plan(&scene(configuration, sun))?.samples_per_piece();
    let mut errors: Vec<(Air, Errors)> = Vec::new();
    for (air, _, error) in skies.iter().filter(|sky| sky.1 == day) {
        match errors.last_mut() {
            Some((last, sum)) if (last.ozone, last.aerosol) == (air.ozone, air.aerosol) => *sum = sum.and(error),
            _ => errors.push((*air, *error)),
        }
    }
    let all = errors.iter().fold(Errors::default(), |sum, (_, errors)| sum.and(errors));
    let default = configuration.steps.is_none();
    let unbeaten = false;
    Ok(Measured { configuration: configuration.clone(), light, steps, default, unbeaten, errors, all, times })
}

/// Marks the configurations of one light that lie on the front of time and error.
fn mark_unbeaten(measured: Vec<&mut Measured>) {
    let points: Vec<Point> = measured.iter().map(|measured| point(measured)).collect();
    let front = super::chart::front(&points);
    for (measured, at) in measured.into_iter().zip(&points) {
        measured.unbeaten = front.iter().any(|other| std::ptr::eq(*other, at));
    }
}

/// The resident paths and the paper's design, at several sizes.
fn ways(device: &Device, quick: bool, stage: &dyn Fn(&str)) -> Result<Vec<Way>> {
    let sizes = [(512, 256), (1920, 960), (3840, 1920)];
    let mut ways = Vec::new();
    for (width, height) in &sizes[..if quick { 1 } else { 3 }] {
        stage(&format!("timing the paths at {width}x{height}"));
        ways.extend(ways_at(device, Size { width: *width, height: *height }, Care::of(quick))?);
    }
    Ok(ways)
}

fn ways_at(device: &Device, size: Size, care: Care) -> Result<Vec<Way>> {
    let of = |fit: Fit, color: ColourPath| {
        let mut scene = Scene::preset(Preset::Earth).first_order();
        scene.camera.size = size;
        (scene.render.fit, scene.render.color) = (fit, color);
        plan(&scene)
    };
    let regression = of(Fit::Regression, ColourPath::Folded)?;
    let lookup = with_lookup(size)?;
    let (solved, folded) = (of(Fit::Cubic, ColourPath::Solve)?, of(Fit::Cubic, ColourPath::Folded)?);
    let at_bands = solved.clone().at_bands();
    let irradiance = folded.buffers().bands[0].solar_irradiance;
    let matrix: [Vec4; 3] = [0, 1, 2].map(|row| folded.colour[row] / irradiance);
    let read_back = |finish: &dyn Fn(&[u32]) -> Vec<f32>| {
        let run = device.backend.run(&at_bands, at_bands.kernel())?;
        std::hint::black_box(finish(&run.words));
        Ok(run.kernel)
    };
    let mut jobs: Vec<Job> = vec![
        job(device, &lookup, lookup.kernel()),
        job(device, &regression, regression.kernel()),
        job(device, &folded, folded.kernel()),
        job(device, &solved, solved.kernel()),
        Box::new(|| {
            read_back(&|words| {
                readback::solve(words, solved.uniform.band_wavelengths, &solved.colour, &solved.uniform.rgb)
            })
        }),
        Box::new(|| read_back(&|words| readback::fold(words, matrix, &solved.uniform.rgb))),
    ];
    let names = [
        "resident: regression fit, sky lookup (default)",
        "resident: regression fit, every pixel integrated",
        "resident: cubic, folded matrix",
        "resident: cubic, solve and 81 samples",
        "read back, then solve and 81 samples on the CPU (the paper's design)",
        "read back, then the folded matrix on the CPU",
    ];
    let times = care.interleaved(&mut jobs)?;
    let size = size.to_string();
    Ok(names.into_iter().zip(times).map(|(way, times)| Way { size: size.clone(), way, times }).collect())
}

/// The plan of the default sky, of this size, interpolated from a sky lookup.
pub(crate) fn with_lookup(size: Size) -> Result<Plan> {
    let mut scene = Scene::preset(Preset::Earth).first_order();
    scene.camera.size = size;
    looked_up(scene)
}

/// A scene's plan, interpolated from a sky lookup.
///
/// # Errors
///
/// [`crate::Error::Sky`] if a value of the scene is out of range.
pub(crate) fn looked_up(mut scene: Scene) -> Result<Plan> {
    scene.render.exposure = Exposure::Stops(0.0);
    scene.render.path = PathChoice::Lookup;
    Ok(Plan::new(&scene.validated()?, PixelFormat::LinearRgb))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_configuration_makes_a_plan() {
        let list = configurations();
        assert!(list.last().unwrap().steps.is_none());
        for configuration in list.iter().filter(|configuration| configuration.steps.is_none_or(|steps| steps == 4)) {
            let plan = plan(&scene(configuration, 30.0)).unwrap();
            assert_eq!(plan.sky.plan().integral().wavelengths, configuration.bands);
        }
        // The bench's default is the program's.
        let default = plan(&Scene::preset(Preset::Earth).first_order()).unwrap();
        assert_eq!(default.sky.plan().integral().wavelengths, list.last().unwrap().bands);
    }
}
