//! `sorairo bench`: run time against error, and the resident GPU path against reading back and fitting on the CPU.

use std::path::Path;
use std::time::Duration;

use rayon::prelude::*;
use serde::Serialize;
use sorairo_shared::glam::Vec4;

use super::chart::{Chart, Panel, Point};
use super::document::{Machine, make_folder, table, write};
use super::error::{Reference, SUNS, plan};
use super::metrics::Errors;
use super::timing::{Care, Job, Times, fitting_size, job};
use super::{light_field, readback};
use crate::problem::Result;
use sorairo::low_level::plan::fit::{CUBIC_BANDS, FIRST_ORDER_BANDS, TRANSFER_BANDS};
use sorairo::low_level::spectra::observer;
use sorairo::scene::{ColourPath, Exposure, Fit, PathChoice, Preset, Scene, Size};
use sorairo::{Device, PixelFormat, Plan};

/// Integration steps that are compared.
const STEPS: [u32; 6] = [4, 6, 8, 12, 16, 32];

/// Elevation (degrees) from which on the sun counts as up: where the default number of steps changes.
const DAY: f64 = 5.0;

/// Elevations of the sun (degrees) at which run time is measured, for the day and for twilight.
const TIMED_AT: [f64; 2] = [30.0, -2.0];

/// The fits, as the chart names them.
const FITS: [(Fit, &str); 4] = [
    (Fit::Cubic, "polynomial, radiance (paper)"),
    (Fit::Transfer, "polynomial, transfer"),
    (Fit::Regression, "regression"),
    (Fit::Dense, "no fit"),
];

/// A fit, its wavelengths and its steps.
#[derive(Clone, Debug, Serialize)]
pub struct Configuration {
    /// The fit.
    pub fit: Fit,
    /// Wavelengths (nm).
    pub bands: Vec<f64>,
    /// Samples per piece; `None` for the program's choice by the height of the sun.
    pub steps: Option<u32>,
}

/// An atmosphere that errors are measured in.
#[derive(Clone, Copy, Debug, Serialize)]
struct Air {
    ozone: bool,
    aerosol: bool,
}

/// What was measured of a configuration while the sun is up, or in twilight.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// The configuration.
    pub configuration: Configuration,
    /// `day` or `twilight`.
    pub light: &'static str,
    /// Its steps in this light.
    pub steps: u32,
    /// Whether the program would choose it by itself.
    pub default: bool,
    /// Whether no other configuration beats both its time and its error in this light.
    pub unbeaten: bool,
    /// The error in each atmosphere over the suns of this light.
    errors: Vec<(Air, Errors)>,
    /// The error over all of them.
    pub all: Errors,
    /// Run time.
    pub times: Times,
}

/// Run time of one way to an image of linear RGB in the CPU's memory.
#[derive(Clone, Debug, Serialize)]
pub struct Way {
    /// Size of the image.
    pub size: String,
    /// What was done where.
    pub way: &'static str,
    /// Its time.
    pub times: Times,
}

/// Everything that the bench measured.
#[derive(Clone, Debug, Serialize)]
pub struct Bench {
    /// Where and when.
    pub machine: Machine,
    /// How often each time was measured.
    pub rounds: usize,
    #[serde(skip)]
    care: Care,
    /// Elevations of the sun (degrees) at which run time was measured, by day and in twilight.
    pub timed_at: [f64; 2],
    /// Size of the images of the comparison of fits.
    pub size: String,
    /// The sun's elevations (degrees).
    pub suns: Vec<f64>,
    /// The paths of the data.
    pub ways: Vec<Way>,
    /// The configurations.
    pub configurations: Vec<Measured>,
    /// Light fields of all orders.
    pub light_fields: Vec<light_field::Measured>,
}

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
pub(super) fn with_lookup(size: Size) -> Result<Plan> {
    let mut scene = Scene::preset(Preset::Earth).first_order();
    scene.camera.size = size;
    looked_up(scene)
}

/// A scene's plan, interpolated from a sky lookup.
///
/// # Errors
///
/// [`crate::Error::Sky`] if a value of the scene is out of range.
pub(super) fn looked_up(mut scene: Scene) -> Result<Plan> {
    scene.render.exposure = Exposure::Stops(0.0);
    scene.render.path = PathChoice::Lookup;
    Ok(Plan::new(&scene.validated()?, PixelFormat::LinearRgb))
}

impl Bench {
    fn write(&self, folder: &Path) -> Result<()> {
        write(&folder.join("bench.csv"), &self.csv())?;
        let json = serde_json::to_string_pretty(self).expect("a bench is plain data");
        write(&folder.join("bench.json"), &json)?;
        self.chart().write(folder, "pareto")?;
        light_field::chart(&self.light_fields, self.machine.to_string()).write(folder, "light_field")?;
        write(&folder.join("report.md"), &self.markdown())
    }

    fn csv(&self) -> String {
        let mut csv = String::from(
            "light,fit,bands,wavelengths_nm,steps,default,ozone,aerosol,de00_max,de00_mean,luminance_max,duv_max,\
             relative_rmse,kernel_ms,kernel_ms_min,kernel_ms_max,wall_ms,wall_ms_min,wall_ms_max\n",
        );
        for m in &self.configurations {
            let bands: Vec<String> = m.configuration.bands.iter().map(f64::to_string).collect();
            let (kernel, wall) = (m.times.kernel, m.times.wall);
            for (air, e) in &m.errors {
                csv.push_str(&format!(
                    "{},{},{},{},{},{},{},{},{:e},{:e},{:e},{:e},{:e},{},{},{},{},{},{}\n",
                    m.light,
                    m.configuration.fit.name(),
                    bands.len(),
                    bands.join(" "),
                    m.steps,
                    m.default,
                    air.ozone,
                    air.aerosol,
                    e.delta_e_max,
                    e.delta_e_mean,
                    e.luminance_max,
                    e.chromaticity_max,
                    e.relative_rmse,
                    kernel.median,
                    kernel.min,
                    kernel.max,
                    wall.median,
                    wall.min,
                    wall.max
                ));
            }
        }
        csv
    }

    fn chart(&self) -> Chart {
        let panel = |light: &'static str, title: &str| {
            let measured = self.configurations.iter().filter(|m| m.light == light);
            let points: Vec<Point> = measured.map(point).filter(|point| point.y.is_finite() && point.y > 0.0).collect();
            Panel { title: title.into(), finding: finding(&points), points }
        };
        Chart {
            title: "What a tenth of the colour error costs".into(),
            source: format!("{}; {} pixels", self.machine, self.size),
            x: "time of the kernel (ms)".into(),
            y: "largest colour error of the sky, ΔE₀₀".into(),
            series: FITS.iter().map(|(_, name)| *name).collect(),
            levels: vec![(1.0, "ΔE 1: just visible side by side"), (0.1, "ΔE 0.1")],
            panels: vec![panel("day", "Day: sun from 5° to 90°"), panel("twilight", "Twilight: sun from −4° to 2°")],
        }
    }

    fn markdown(&self) -> String {
        let ways = table(
            &["image", "way to linear RGB in memory", "kernels (ms)", "end to end (ms)"],
            self.ways.iter().map(|way| {
                vec![way.size.clone(), way.way.into(), way.times.kernel.to_string(), way.times.wall.to_string()]
            }),
        );
        let suns: Vec<String> = self.suns.iter().map(f64::to_string).collect();
        format!(
            "# Run time against error\n\n{}. Times are medians (shortest–longest) of {}, in turn \
             with their rivals.\n\n![Run time against error](pareto.png)\n\nEvery point is a fit, its wavelengths (the larger the mark, \
             the more) and its samples per piece; time for an image of {} with ozone and aerosol, the sun at {}° by day and {}° in \
             twilight. Errors are the largest over the whole sky, suns at {}°, with and without ozone and aerosol, against \
             the sum of 81 wavelengths integrated with 512 samples each and summed in double precision; each colour scaled so that the reference has Y = 50, before the \
             gamut of the display. Every figure is in `bench.csv`.\n\n## The default, and what nothing beats\n\n{}\n## GPU-resident against \
             read back, then fit\n\nThe sun at 30°, 12 samples per piece. Reading back goes through the same code; the CPU side uses all cores and \
             vector instructions.\n\n{ways}\n## Light of all orders\n\nThe light field of all orders at four bands and 63 rays through it, against one three times \
             as fine in everything.\n\n![Time against error of a light field](light_field.png)\n\n{}",
            self.machine,
            self.care,
            self.size,
            TIMED_AT[0],
            TIMED_AT[1],
            suns.join(", "),
            self.fronts(),
            self.light_fields(),
        )
    }

    fn light_fields(&self) -> String {
        let row = |row: &light_field::Measured| {
            let percent = |error: f64| format!("{:.3} %", 100.0 * error);
            vec![row.sky.into(), row.what.clone(), row.time.to_string(), percent(row.largest), percent(row.rms)]
        };
        table(&["sky", "light field", "time (ms)", "largest", "rms"], self.light_fields.iter().map(row))
    }

    /// The configurations on the front, and the default.
    fn fronts(&self) -> String {
        let shown = self.configurations.iter().filter(|m| m.default || m.unbeaten);
        let mut shown: Vec<&Measured> = shown.collect();
        shown.sort_by(|a, b| a.light.cmp(b.light).then(a.times.kernel.median.total_cmp(&b.times.kernel.median)));
        let head = [
            "light",
            "fit",
            "bands",
            "samples per piece",
            "ΔE₀₀ max",
            "ΔE₀₀ mean",
            "luminance max",
            "Δu′v′ max",
            "RMSE",
            "kernel (ms)",
            "wall (ms)",
        ];
        table(&head, shown.into_iter().map(row))
    }
}

fn row(m: &Measured) -> Vec<String> {
    let mark = if m.default { " (default)" } else { "" };
    vec![
        m.light.into(),
        format!("{}{mark}", m.configuration.fit.name()),
        m.configuration.bands.len().to_string(),
        m.steps.to_string(),
        format!("{:.4}", m.all.delta_e_max),
        format!("{:.4}", m.all.delta_e_mean),
        format!("{:.3} %", 100.0 * m.all.luminance_max),
        format!("{:.5}", m.all.chromaticity_max),
        format!("{:.4} %", 100.0 * m.all.relative_rmse),
        m.times.kernel.to_string(),
        m.times.wall.to_string(),
    ]
}

fn point(m: &Measured) -> Point {
    let bands = m.configuration.bands.len();
    Point {
        series: FITS.iter().position(|(fit, _)| *fit == m.configuration.fit).expect("every fit has a name"),
        radius: 2.5 + 1.3 * (bands as f64).sqrt().min(5.0),
        x: m.times.kernel.median,
        y: m.all.delta_e_max,
        label: format!("{bands} bands, {} steps", m.steps),
        default: m.default,
    }
}

/// What a tenth of the error costs along the front: the cheapest below ΔE 1 against the cheapest below ΔE 0.1.
fn finding(points: &[Point]) -> String {
    let cheapest = |error: f64| points.iter().filter(|p| p.y <= error).map(|p| p.x).min_by(f64::total_cmp);
    let cost = match (cheapest(1.0), cheapest(0.1)) {
        (Some(coarse), Some(fine)) => format!("From ΔE 1 to ΔE 0.1: {:.1} times the time", fine / coarse),
        _ => "Nothing measured comes below ΔE 0.1".into(),
    };
    let default = points.iter().find(|point| point.default);
    default.map_or(cost.clone(), |point| format!("{cost}. Default: {}, ΔE {:.2}", point.label, point.y))
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
            assert_eq!(plan.sky.integral().wavelengths, configuration.bands);
        }
        // The bench's default is the program's.
        let default = plan(&Scene::preset(Preset::Earth).first_order()).unwrap();
        assert_eq!(default.sky.integral().wavelengths, list.last().unwrap().bands);
    }
}
