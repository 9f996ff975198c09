//! `sorairo reproduce`: the experiment of Takahashi and Dobashi, *Full-spectrum rendering of the sky using GPU*, on the
//! machine at hand, and the same for the fits that came after it.

use std::path::Path;
use std::time::Duration;

use rayon::prelude::*;
use serde::Serialize;
use sorairo_shared::camera::{FISHEYE, pixel_view};
use sorairo_shared::display::rgb::into_gamut;
use sorairo_shared::display::tone::{NEAREST, srgb8};
use sorairo_shared::glam::{DVec3, Vec3};

use super::bench::looked_up;
use super::document::{Machine, make_folder, table, write};
use super::error::{plan, xyz};
use super::metrics::{ColourError, Errors, RadianceError};
use super::picture::Sheet;
use super::timing::{Care, Job, Times, fitting_size, job};
use crate::problem::Result;
use sorairo::files::png;
use sorairo::low_level::plan::{Plan, SpectralPlan};
use sorairo::low_level::spectrum::DenseSpectrum;
use sorairo::scene::{ColourPath, Fit, Preset, Projection, Scene, Size};
use sorairo::{Device, PixelFormat};

/// Elevations of the sun in the paper's Table 1 and Fig. 2 (degrees).
pub const SUNS: [f64; 5] = [0.0, 30.0, 45.0, 60.0, 90.0];

/// The fits that are compared.
const FITS: [(Fit, &str); 3] =
    [(Fit::Cubic, "cubic (paper)"), (Fit::Transfer, "transfer"), (Fit::Regression, "regression")];

/// Side of a picture (pixels).
const SIDE: u32 = 160;

/// Samples per piece for the dense pictures, which leave less than a step of 8 bits.
const DENSE_STEPS: u32 = 48;

/// Wavelengths of the paper's Table 1 (nm): 400 to 730 by 30.
pub fn wavelengths() -> Vec<f64> {
    (0..12).map(|i| 400.0 + 30.0 * f64::from(i)).collect()
}

/// The error of a fit in the setting of Table 1.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The fit.
    pub fit: Fit,
    /// Elevation of the sun (degrees); `None` for all of them together.
    pub sun: Option<f64>,
    /// The error of the radiance at the twelve wavelengths (sr⁻¹, the sun's irradiance being 1).
    pub radiance: RadianceError,
    /// The error of the colours of the picture.
    pub colour: Errors,
}

/// The time of one way to draw the sky.
#[derive(Clone, Debug, Serialize)]
pub struct Timing {
    /// What was drawn, and how.
    pub way: &'static str,
    /// Its time.
    pub times: Times,
    /// What the paper states for it.
    pub paper: Option<&'static str>,
    /// The time of twelve wavelengths, kernels only, as a multiple of this.
    pub twelve_over_this: f64,
}

/// The experiment's outcome.
#[derive(Clone, Debug, Serialize)]
pub struct Experiment {
    /// Where and when.
    pub machine: Machine,
    /// Table 1.
    pub table: Vec<Row>,
    /// Size of the timed images.
    pub timed_size: String,
    /// The timing.
    pub timing: Vec<Timing>,
}

/// Runs the experiment and writes `report.md`, `report.json` and the pictures into a folder.
///
/// # Errors
///
/// [`crate::Error::Folder`] for a folder that cannot be made; [`crate::Error::Sky`] for a device or a file that fails.
pub fn reproduce(folder: &Path, device: &Device, stage: &dyn Fn(&str)) -> Result<Experiment> {
    make_folder(folder)?;
    stage("timing 4 bands against 12");
    let size = fitting_size(device, &paper(Fit::Regression, 30.0), Duration::from_millis(200))?;
    let timing = timing(device, size)?;
    stage("integrating every wavelength of Table 1");
    let mut table = table_1()?;
    for (i, sun) in SUNS.into_iter().enumerate() {
        stage(&format!("drawing the sky, sun at {sun} degrees"));
        let colours = draw(folder, sun)?;
        for (fit, colour) in colours.into_iter().enumerate() {
            table[fit * (SUNS.len() + 1) + i].colour = colour;
            let all = &mut table[fit * (SUNS.len() + 1) + SUNS.len()].colour;
            *all = all.and(&colour);
        }
    }
    figure_2(folder)?;
    let experiment = Experiment { machine: Machine::new(device), table, timed_size: size.to_string(), timing };
    let json = serde_json::to_string_pretty(&experiment).expect("an experiment is plain data");
    write(&folder.join("report.json"), &json)?;
    write(&folder.join("report.md"), &experiment.markdown())?;
    Ok(experiment)
}

/// The paper's scene: no ozone, a sun of 1 at every wavelength, seen by a fisheye.
fn paper(fit: Fit, sun: f64) -> Scene {
    let mut scene = Scene::preset(Preset::Paper);
    scene.sun.elevation = sun;
    scene.render.fit = fit;
    scene.camera.projection = Projection::Fisheye;
    scene.camera.size = Size { width: SIDE, height: SIDE };
    scene
}

/// The directions of the picture's pixels, from the top left; `None` outside the circle. `every` counts pixels each
/// way.
fn pixels(plan: &Plan, every: u32) -> Vec<Option<Vec3>> {
    let coordinates = (0..SIDE / every).flat_map(|row| (0..SIDE / every).map(move |column| (column, row)));
    let view = |(column, row)| {
        let view = pixel_view(&plan.uniform.camera, FISHEYE, column * every + every / 2, row * every + every / 2);
        view.covered.then_some(view.direction)
    };
    coordinates.map(view).collect()
}

/// The radiance errors of Table 1: for each fit a row for each sun and one for all.
///
/// # Errors
///
/// None for the scenes of the paper.
pub fn table_1() -> Result<Vec<Row>> {
    let wavelengths = wavelengths();
    let mut pairs: Vec<Vec<Vec<(f64, f64)>>> = vec![Vec::new(); FITS.len()];
    for sun in SUNS {
        let plans = FITS.map(|(fit, _)| plan(&paper(fit, sun)));
        let plans: Vec<Plan> = plans.into_iter().collect::<Result<_>>()?;
        let dense = DenseSpectrum::new(plans[0].sky.plan(), &wavelengths);
        let views: Vec<Vec3> = pixels(&plans[0], 4).into_iter().flatten().collect();
        let reference: Vec<Vec<f64>> = views.par_iter().map(|&view| dense.radiance(view)).collect();
        for (plan, pairs) in plans.iter().zip(&mut pairs) {
            let fitted = SpectralPlan::of_own_bands(plan.sky.plan(), &wavelengths);
            let of_view = |(view, reference): (&Vec3, &Vec<f64>)| {
                fitted.radiance(*view).into_iter().zip(reference.iter().copied()).collect::<Vec<_>>()
            };
            pairs.push(views.iter().zip(&reference).flat_map(of_view).collect());
        }
    }
    let row = |fit, sun, pairs: &[(f64, f64)]| Row {
        fit,
        sun,
        radiance: RadianceError::of(pairs),
        colour: Errors::default(),
    };
    let rows = FITS.into_iter().zip(&pairs).flat_map(|((fit, _), pairs)| {
        let each = SUNS.into_iter().zip(pairs).map(move |(sun, pairs)| row(fit, Some(sun), pairs));
        each.chain([row(fit, None, &pairs.concat())])
    });
    Ok(rows.collect())
}

/// Draws one sun's sky by every fit and without one, and where the fits differ; returns the fits' errors of colour.
fn draw(folder: &Path, sun: f64) -> Result<Vec<Errors>> {
    let mut scene = paper(Fit::Dense, sun);
    scene.render.steps = Some(DENSE_STEPS);
    let dense = plan(&scene)?;
    let views = pixels(&dense, 1);
    let image = |plan: &Plan| -> Vec<DVec3> {
        views.par_iter().map(|view| view.map_or(DVec3::ZERO, |view| xyz(plan, view))).collect()
    };
    let reference = image(&dense);
    let exposure = Plan::new(&paper(Fit::Transfer, sun).validated()?, PixelFormat::LinearRgb).uniform.exposure;
    let picture = |name: &str, xyz: &[DVec3]| {
        let (to_rgb, space) = (dense.sky.plan().space.from_xyz, &dense.uniform.rgb);
        let bytes = xyz.iter().flat_map(|&xyz| {
            srgb8(into_gamut((to_rgb * xyz).as_vec3(), space), exposure, NEAREST).to_le_bytes().into_iter().take(3)
        });
        png::write(&folder.join(file(sun, name)), SIDE, SIDE, &bytes.collect::<Vec<u8>>())
    };
    picture("dense", &reference)?.commit()?;
    let mut errors = Vec::new();
    for (fit, _) in FITS {
        let image = image(&plan(&paper(fit, sun))?);
        picture(fit.name(), &image)?.commit()?;
        let pairs = || image.iter().copied().zip(reference.iter().copied());
        errors.push(Errors::of(pairs()));
        let shade = |(xyz, reference): (DVec3, DVec3)| {
            if reference.y > 0.0 { heat(ColourError::new(xyz, reference).delta_e) } else { [255; 3] }
        };
        let difference: Vec<u8> = pairs().flat_map(shade).collect();
        png::write(&folder.join(file(sun, &format!("{}_difference", fit.name()))), SIDE, SIDE, &difference)?
            .commit()?;
    }
    Ok(errors)
}

fn file(sun: f64, name: &str) -> String {
    format!("sun{sun:02}_{name}.png")
}

/// The range of ΔE₀₀ that [`heat`] shows.
const HEAT: (f64, f64) = (0.001, 10.0);

/// A colour for a difference ΔE₀₀, on a logarithmic scale from black at 0.001 over blue, red and yellow to white at 10:
/// one colour for each factor of ten.
fn heat(delta_e: f64) -> [u8; 3] {
    const STOPS: [[f64; 3]; 5] =
        [[0.0, 0.0, 0.0], [40.0, 50.0, 160.0], [200.0, 40.0, 90.0], [255.0, 180.0, 40.0], [255.0, 255.0, 255.0]];
    let at = 4.0 * (delta_e / HEAT.0).max(1.0).ln() / (HEAT.1 / HEAT.0).ln();
    let at = at.min(3.999_999);
    let (below, part) = (at as usize, at.fract());
    std::array::from_fn(|i| (STOPS[below][i] * (1.0 - part) + STOPS[below + 1][i] * part).round() as u8)
}

/// All pictures on one sheet, as in Fig. 2, with a scale for the differences.
fn figure_2(folder: &Path) -> Result<()> {
    let mut columns: Vec<(String, String)> = vec![("dense".into(), "every 5 nm, no fit".into())];
    columns.extend(FITS.map(|(fit, title)| (fit.name().to_owned(), title.to_owned())));
    columns.extend(FITS.map(|(fit, _)| (format!("{}_difference", fit.name()), format!("ΔE₀₀ of {}", fit.name()))));
    let mut sheet = Sheet::new(SIDE, columns.len() as u32, SUNS.len() as u32);
    for (i, (name, title)) in columns.iter().enumerate() {
        sheet.column_title(i as u32, title)?;
        for (j, sun) in SUNS.into_iter().enumerate() {
            sheet.place(i as u32, j as u32, &folder.join(file(sun, name)))?;
        }
    }
    for (j, sun) in SUNS.into_iter().enumerate() {
        sheet.row_title(j as u32, &format!("sun {sun}°"))?;
    }
    sheet.scale(heat, &["0.001", "0.01", "0.1", "ΔE₀₀ 1", "10"])?;
    sheet.write(&folder.join("figure2.png"))
}

/// What the paper states for the first ways of its comparison, on its machine.
const STATED: [Option<&str>; 3] = [Some("408.05 s"), None, Some("186.38 s, 2.19×")];

/// Times the paper's comparison: twelve wavelengths integrated, against four, a fit and a colour.
fn timing(device: &Device, size: Size) -> Result<Vec<Timing>> {
    let of = |fit: Fit, color: ColourPath, bands: Option<Vec<f64>>| {
        let mut scene = paper(fit, 30.0);
        scene.camera.projection = Projection::Equirectangular;
        scene.camera.size = size;
        (scene.render.color, scene.render.bands) = (color, bands);
        plan(&scene)
    };
    let twelve = of(Fit::Dense, ColourPath::Folded, Some(wavelengths()))?.at_bands();
    let solve = of(Fit::Cubic, ColourPath::Solve, None)?;
    let four = solve.clone().at_bands();
    let folded = of(Fit::Cubic, ColourPath::Folded, None)?;
    let regression = of(Fit::Regression, ColourPath::Folded, None)?;
    let regression_solve = of(Fit::Regression, ColourPath::Solve, None)?;
    let mut looked_up_scene = paper(Fit::Regression, 30.0);
    looked_up_scene.camera.projection = Projection::Equirectangular;
    looked_up_scene.camera.size = size;
    let lookup = looked_up(looked_up_scene)?;
    let named: Vec<(&str, Job)> = vec![
        ("12 wavelengths, radiance only", job(device, &twelve, twelve.kernel())),
        ("4 bands, radiance only", job(device, &four, four.kernel())),
        ("4 bands, cubic solved, 81 samples (the paper's steps)", job(device, &solve, solve.kernel())),
        ("4 bands, cubic or transfer, folded into one matrix", job(device, &folded, folded.kernel())),
        ("4 bands, regression, 4×4 solved", job(device, &regression_solve, regression_solve.kernel())),
        ("4 bands, regression, every pixel integrated", job(device, &regression, regression.kernel())),
        ("4 bands, regression, sky lookup (default)", job(device, &lookup, lookup.kernel())),
    ];
    let (names, mut jobs): (Vec<&str>, Vec<Job>) = named.into_iter().unzip();
    let times = Care::FULL.interleaved(&mut jobs)?;
    let twelve = times[0].kernel.median;
    let timing = |(i, (way, times)): (usize, (_, Times))| {
        let paper = STATED.get(i).copied().flatten();
        Timing { way, times, paper, twelve_over_this: twelve / times.kernel.median }
    };
    Ok(names.into_iter().zip(times).enumerate().map(timing).collect())
}

impl Experiment {
    fn markdown(&self) -> String {
        format!(
            "# The paper's experiment\n\nTakahashi and Dobashi, *Full-spectrum rendering of the sky using GPU*, on {}.\n\n\
             ## Table 1: error of the radiance\n\nTwelve wavelengths, 400 to 730 nm by 30; the sun's spectrum is 1, no ozone; every \
             fourth pixel each way of the fisheye below. RMSE against the integral with 512 samples at the very wavelength. The \
             paper's cubic is at 430, 520, 610, 700 nm; the others at their own wavelengths, which were chosen for colour.\n\n{}\n\
             The paper states an RMSE of 0.02 to 0.04, and doesn't say of what it is a part.\n\n## Fig. 2: the sky\n\n\
             ![The sky by every fit](figure2.png)\n\nThe sun is in the north, at the top. Each row has one exposure. Differences are \
             of colours scaled so that the reference has Y = 50, before the gamut of the display, from black at ΔE₀₀ = 0.001 to white at 10; \
             the reference integrates every 5 nm with {DENSE_STEPS} samples.\n\n{}\n## Run time\n\n{} pixels, the sun at 30°, 12 \
             samples per piece; medians (shortest–longest) of {}, in turn with their rivals.\n\n{}",
            self.machine,
            self.radiance_table(),
            self.colour_table(),
            self.timed_size,
            Care::FULL,
            self.time_table(),
        )
    }

    fn radiance_table(&self) -> String {
        let rows = self.table.iter().map(|row| {
            let paper = if row.fit == Fit::Cubic { "0.02–0.04" } else { "" };
            let RadianceError { rmse, over_mean, over_max } = row.radiance;
            let sun = row.sun.map_or("all".into(), |sun| format!("{sun}°"));
            let figures = [rmse, over_mean, over_max].map(|figure| format!("{figure:.6}"));
            [vec![row.fit.name().into(), sun], figures.to_vec(), vec![paper.into()]].concat()
        });
        table(&["fit", "sun", "RMSE (sr⁻¹)", "RMSE ÷ mean", "RMSE ÷ max", "the paper"], rows)
    }

    fn colour_table(&self) -> String {
        let rows = self.table.iter().filter(|row| row.sun.is_none()).map(|row| {
            vec![
                row.fit.name().into(),
                format!("{:.4}", row.colour.delta_e_max),
                format!("{:.4}", row.colour.delta_e_mean),
                format!("{:.3} %", 100.0 * row.colour.luminance_max),
                format!("{:.5}", row.colour.chromaticity_max),
            ]
        });
        table(&["fit", "ΔE₀₀ max", "ΔE₀₀ mean", "luminance max", "Δu′v′ max"], rows)
    }

    fn time_table(&self) -> String {
        let rows = self.timing.iter().map(|timing| {
            let Timing { way, times, paper, twelve_over_this } = timing;
            let [kernel, wall] = [times.kernel, times.wall].map(|spread| spread.to_string());
            vec![(*way).into(), kernel, wall, format!("{twelve_over_this:.2}×"), paper.unwrap_or_default().into()]
        });
        table(&["what", "kernels (ms)", "end to end (ms)", "12 wavelengths ÷ this", "the paper"], rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_have_one_colour_a_decade() {
        assert_eq!(heat(0.0), [0; 3]);
        assert_eq!(heat(0.01), [40, 50, 160]);
        assert_eq!(heat(1.0), [255, 180, 40]);
        assert_eq!(heat(100.0), [255; 3]);
    }

    #[test]
    fn table_1_has_the_papers_wavelengths() {
        assert_eq!(wavelengths().len(), 12);
        assert_eq!(wavelengths().last(), Some(&730.0));
    }
}
