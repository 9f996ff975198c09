//! The picture of the solve: what rounding does to each form, and what becomes of a sky's spectrum.

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;
use rand::RngExt;
use rayon::prelude::*;

use super::outcome::generator;
use super::solve::{Form, error_of, reference};
use crate::chart::{Drawn, font, register_fonts, short};
use crate::problem::{Error, Result};
use sorairo::files::png;
use sorairo::low_level::plan::direction;
use sorairo::low_level::spectra::observer;
use sorairo::scene::rules::CLOSEST_BANDS;
use sorairo::scene::{Fit, Preset, Scene};
use sorairo::{PixelFormat, Plan};

/// Size of the picture (pixels).
const SIZE: (u32, u32) = (2400, 980);

/// Height of the text above the panels.
const HEAD: u32 = 130;

/// Colours of the forms (Okabe and Ito 2008, *Color universal design*).
const COLOURS: [RGBColor; 3] = [RGBColor(213, 94, 0), RGBColor(230, 159, 0), RGBColor(0, 114, 178)];

/// Sets of bands in the first panel.
const SETS: u64 = 900;

/// Bands (nm) of the sky in the other two panels: the matrix in nm gives a wrong spectrum for the first, none for the
/// second.
pub const SHOWN: [[f64; 4]; 2] = [[593.0, 595.5, 598.0, 600.5], [597.0, 599.0, 601.0, 603.0]];

/// Where the sky is looked at: elevation and azimuth from the sun (degrees).
const VIEW: (f64, f64) = (40.0, 90.0);

/// The transfer (sr⁻¹) of the paper preset's sky at four bands (nm), as the kernels have it.
///
/// # Errors
///
/// None for bands that a scene allows.
pub fn sky_at(bands: [f64; 4]) -> Result<[f32; 4]> {
    let mut scene = Scene::preset(Preset::Paper);
    scene.render.fit = Fit::Transfer;
    scene.render.bands = Some(bands.to_vec());
    let plan = Plan::new(&scene.validated()?, PixelFormat::LinearRgb);
    let view = direction(VIEW.0, plan.sky.plan().integral().source.azimuth + VIEW.1).as_vec3();
    let transfer = plan.sky.plan().integral().transfer(view);
    Ok(std::array::from_fn(|i| transfer[i] as f32))
}

/// Writes `solve.png`.
///
/// # Errors
///
/// [`Error::Drawing`] or [`Error::Sky`] if it cannot be drawn or written.
pub fn solve(folder: &Path, seed: u64) -> Result<()> {
    register_fonts();
    let mut rgb = vec![255; (3 * SIZE.0 * SIZE.1) as usize];
    let skies = [(SHOWN[0], sky_at(SHOWN[0])?), (SHOWN[1], sky_at(SHOWN[1])?)];
    let area = BitMapBackend::with_buffer(&mut rgb, SIZE).into_drawing_area();
    draw(&area, &errors(seed), &skies)
        .map_err(|error| Error::Drawing { what: "solve.png".into(), reason: error.to_string() })?;
    drop(area);
    Ok(png::write(&folder.join("solve.png"), SIZE.0, SIZE.1, &rgb)?.commit()?)
}

/// The closest distance of random bands (nm), and the error of each form there.
fn errors(seed: u64) -> Vec<(f64, [f64; 3])> {
    let set = |number: u64| {
        let mut rng = generator(seed, number);
        let closest = CLOSEST_BANDS * 260f64.powf(number as f64 / SETS as f64);
        let (shortest, longest) = sorairo::low_level::spectra::measured::MEASURED_RANGE;
        let others: [f64; 2] = std::array::from_fn(|_| closest * rng.random_range(1.0..1.2));
        let span = closest + others[0] + others[1];
        let first = shortest + (longest - shortest - span) * rng.random_range(0.0..1.0);
        let bands = [first, first + others[0], first + others[0] + closest, first + span];
        let sky = bands.map(|band| (band / 550.0).powf(-3.5) as f32);
        (closest, Form::ALL.map(|form| error_of(form, bands, sky, reference)))
    };
    (0..SETS).into_par_iter().map(set).collect()
}

fn draw<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    errors: &[(f64, [f64; 3])],
    skies: &[([f64; 4], [f32; 4])],
) -> Drawn<B> {
    area.fill(&WHITE)?;
    let title = "A cubic through four bands in single precision: why the Vandermonde matrix in nm is not used";
    area.draw(&Text::new(title, (32, 24), font(36.0, FontStyle::Bold)))?;
    let mut left = 48;
    for (form, colour) in Form::ALL.into_iter().zip(COLOURS) {
        area.draw(&Circle::new((left, 96), 11, colour.filled()))?;
        area.draw(&Text::new(form.name(), (left + 22, 82), font(27.0, FontStyle::Normal)))?;
        left += 60 + 15 * form.name().len() as i32;
    }
    area.draw(&PathElement::new(vec![(left, 96), (left + 50, 96)], BLACK.stroke_width(3)))?;
    area.draw(&Text::new("exact", (left + 62, 82), font(27.0, FontStyle::Normal)))?;
    let (_, below) = area.split_vertically(HEAD);
    let panels = below.split_evenly((1, 3));
    draw_errors(&panels[0], errors)?;
    for (panel, (bands, sky)) in panels[1..].iter().zip(skies) {
        draw_sky(panel, *bands, *sky)?;
    }
    area.present()
}

fn draw_errors<B: DrawingBackend>(area: &DrawingArea<B, Shift>, errors: &[(f64, [f64; 3])]) -> Drawn<B> {
    let all =
        || errors.iter().flat_map(|(_, errors)| errors).copied().filter(|error| *error > 0.0 && error.is_finite());
    let decade = |value: f64, round: fn(f64) -> f64| 10f64.powf(round(value.log10()));
    let (low, high) =
        (decade(all().fold(f64::MAX, f64::min), f64::floor), decade(all().fold(0.0, f64::max), f64::ceil));
    let mut chart = ChartBuilder::on(area)
        .margin(24)
        .caption("Largest error over 380-780 nm ÷ largest value", font(28.0, FontStyle::Normal))
        .x_label_area_size(80)
        .y_label_area_size(120)
        .build_cartesian_2d((CLOSEST_BANDS..150.0).log_scale(), (low..3.0 * high).log_scale())?;
    mesh(&mut chart, "distance of neighbouring bands (nm)", "", &short)?;
    for (i, colour) in COLOURS.into_iter().enumerate() {
        // Where a matrix is singular the error is infinite: at the top.
        let point = |(distance, errors): &(f64, [f64; 3])| (*distance, errors[i].clamp(low, 3.0 * high));
        chart.draw_series(errors.iter().map(|set| Circle::new(point(set), 4, colour.mix(0.7).filled())))?;
    }
    Ok(())
}

fn draw_sky<B: DrawingBackend>(area: &DrawingArea<B, Shift>, bands: [f64; 4], sky: [f32; 4]) -> Drawn<B> {
    let at: Vec<f64> = (0..=400).map(|i| observer::START + f64::from(i)).collect();
    let curve = |form: Form| form.values(bands, sky, &at).into_iter().map(f64::from).collect::<Vec<f64>>();
    // Newton's form in double precision on its own nodes: exact for a picture.
    let nodes = bands.map(|band| Form::Newton.place(band));
    let truth: Vec<f64> = at.iter().map(|&x| reference(nodes, sky, Form::Newton.place(x))).collect();
    let top = 1.6 * truth.iter().copied().fold(0.0, f64::max);
    let bottom = (-0.4 * top).max(1.6 * truth.iter().copied().fold(0.0, f64::min).min(-0.05 * top));
    let list = bands.map(|band| format!("{band}")).join(", ");
    let mut chart = ChartBuilder::on(area)
        .margin(24)
        .caption(format!("Transfer of the sky, bands at {list} nm"), font(28.0, FontStyle::Normal))
        .x_label_area_size(80)
        .y_label_area_size(120)
        .build_cartesian_2d(observer::START..observer::END, bottom..top)?;
    mesh(&mut chart, "wavelength (nm)", "transfer (sr⁻¹)", &|value: f64| format!("{:.3}", value + 0.0))?;
    let points = |curve: Vec<f64>| at.clone().into_iter().zip(curve).filter(|(_, y)| (bottom..=top).contains(y));
    chart.draw_series(LineSeries::new(points(truth), BLACK.stroke_width(9)))?;
    for (form, colour) in Form::ALL.into_iter().zip(COLOURS) {
        let values = curve(form);
        if values.iter().any(|value| !value.is_finite()) {
            let words = format!("{}: singular, no spectrum", form.name());
            let place = (observer::START + 40.0, bottom + 0.93 * (top - bottom));
            chart.draw_series([Text::new(words, place, font(25.0, FontStyle::Normal).color(&colour))])?;
        }
        chart.draw_series(LineSeries::new(points(values), colour.stroke_width(3)))?;
    }
    chart.draw_series(
        bands
            .into_iter()
            .zip(sky)
            .map(|(band, value)| Circle::new((band, f64::from(value)), 10, BLACK.stroke_width(3))),
    )?;
    Ok(())
}

/// Axes and their names.
fn mesh<B, X, Y>(
    chart: &mut ChartContext<'_, B, Cartesian2d<X, Y>>,
    x: &str,
    y: &str,
    number: &dyn Fn(f64) -> String,
) -> Drawn<B>
where
    B: DrawingBackend,
    X: Ranged<ValueType = f64> + plotters::coord::ranged1d::ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + plotters::coord::ranged1d::ValueFormatter<f64>,
{
    chart
        .configure_mesh()
        .x_desc(x)
        .y_desc(y)
        .axis_desc_style(font(27.0, FontStyle::Normal))
        .label_style(font(24.0, FontStyle::Normal))
        .x_label_formatter(&|value| short(*value))
        .y_label_formatter(&|value| number(*value))
        .bold_line_style(RGBColor(215, 215, 215))
        .light_line_style(RGBColor(243, 243, 243))
        .draw()
}
