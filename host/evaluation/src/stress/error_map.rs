//! The picture of the ray integral's error: one panel for each altitude, the view over the sun.

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::integral::{Cell, MAP_ALTITUDES, MAP_SUNS, MAP_VIEWS};
use crate::chart::{Drawn, font, register_fonts};
use crate::problem::{Error, Result};
use sorairo::files::png;
use sorairo::low_level::plan::samples::BOUND;

/// Size of the picture (pixels).
const SIZE: (u32, u32) = (2700, 1880);
/// Height of the title and the colour scale.
const HEAD: u32 = 150;
/// Where the cells of a panel begin, and how large one is.
const CORNER: (i32, i32) = (120, 60);
const CELL: (i32, i32) = (40, 35);
/// Decades of the colour scale; what lies above its end exceeds the bound.
const DECADES: (f64, f64) = (-7.0, -3.0);
/// Colours (Okabe and Ito 2008, *Color universal design*; the scale from white to dark blue).
const DARK_SCALE: RGBColor = RGBColor(0, 45, 105);
const ABOVE: RGBColor = RGBColor(213, 94, 0);
const UNLIT: RGBColor = RGBColor(200, 200, 200);

/// Writes `integral.png`.
///
/// # Errors
///
/// [`Error::Drawing`] or [`Error::Sky`] if it cannot be drawn or written.
pub fn draw(folder: &Path, cells: &[Cell]) -> Result<()> {
    register_fonts();
    let mut rgb = vec![255; (3 * SIZE.0 * SIZE.1) as usize];
    let area = BitMapBackend::with_buffer(&mut rgb, SIZE).into_drawing_area();
    picture(&area, cells).map_err(|error| Error::Drawing { what: "integral.png".into(), reason: error.to_string() })?;
    drop(area);
    Ok(png::write(&folder.join("integral.png"), SIZE.0, SIZE.1, &rgb)?.commit()?)
}

fn picture<B: DrawingBackend>(area: &DrawingArea<B, Shift>, cells: &[Cell]) -> Drawn<B> {
    area.fill(&WHITE)?;
    let title = "The ray integral in single precision against the oracle: earth preset, largest error of four bands and two azimuths";
    area.draw(&Text::new(title, (32, 22), font(36.0, FontStyle::Bold)))?;
    scale(area)?;
    let (_, below) = area.split_vertically(HEAD);
    for (panel, altitude) in below.split_evenly((2, 3)).iter().zip(MAP_ALTITUDES) {
        draw_panel(panel, altitude, cells)?;
    }
    area.present()
}

/// The colour of an error; white at the low end of the scale.
fn colour(error: Option<f64>) -> RGBColor {
    let Some(error) = error else { return UNLIT };
    if error > BOUND {
        return ABOVE;
    }
    let (low, high) = DECADES;
    let part = ((error.max(1e-30).log10() - low) / (high - low)).clamp(0.0, 1.0);
    let mix = |dark: u8| (255.0 + (f64::from(dark) - 255.0) * part).round() as u8;
    RGBColor(mix(DARK_SCALE.0), mix(DARK_SCALE.1), mix(DARK_SCALE.2))
}

fn scale<B: DrawingBackend>(area: &DrawingArea<B, Shift>) -> Drawn<B> {
    let (low, high) = DECADES;
    let words = |text: String, left: i32| area.draw(&Text::new(text, (left, 112), font(24.0, FontStyle::Normal)));
    for i in 0..400 {
        let error = 10f64.powf(low + (high - low) * f64::from(i) / 400.0);
        let left = 60 + 2 * i;
        area.draw(&Rectangle::new([(left, 78), (left + 2, 106)], colour(Some(error)).filled()))?;
    }
    for decade in low as i32..=high as i32 {
        words(format!("1e{decade}"), 40 + 200 * (decade - low as i32))?;
    }
    for (left, swatch, text) in [(960, ABOVE, "above the bound of 1e-3"), (1360, UNLIT, "nothing is lit")] {
        area.draw(&Rectangle::new([(left, 78), (left + 40, 106)], swatch.filled()))?;
        area.draw(&Text::new(text, (left + 52, 80), font(24.0, FontStyle::Normal)))?;
    }
    let meaning = "error relative to the radiance; below 1e-9 of the scene's maximum relative to 1e-6 of that";
    area.draw(&Text::new(meaning, (1580, 80), font(24.0, FontStyle::Normal)))
}

fn draw_panel<B: DrawingBackend>(area: &DrawingArea<B, Shift>, altitude: f64, cells: &[Cell]) -> Drawn<B> {
    let small = || font(21.0, FontStyle::Normal);
    let upright = small().transform(FontTransform::Rotate270);
    let caption = format!("observer at {altitude} km");
    area.draw(&Text::new(caption, (CORNER.0, 12), font(28.0, FontStyle::Bold)))?;
    let place = |column: usize, row: usize| (CORNER.0 + CELL.0 * column as i32, CORNER.1 + CELL.1 * row as i32);
    for cell in cells.iter().filter(|cell| cell.altitude == altitude) {
        let column = MAP_SUNS.iter().position(|&sun| sun == cell.sun).expect("a column of the map");
        let row = MAP_VIEWS.iter().rev().position(|&view| view == cell.view).expect("a row of the map");
        let corners = [place(column, row), place(column + 1, row + 1)];
        area.draw(&Rectangle::new(corners, colour(cell.error).filled()))?;
        area.draw(&Rectangle::new(corners, RGBColor(225, 225, 225).stroke_width(1)))?;
    }
    for (row, view) in MAP_VIEWS.iter().rev().enumerate() {
        let (left, top) = place(0, row);
        area.draw(&Text::new(format!("{view}"), (left - 52, top + 8), small()))?;
    }
    let bottom = place(0, MAP_VIEWS.len()).1;
    for (column, sun) in MAP_SUNS.iter().enumerate() {
        let number = format!("{sun}");
        let left = place(column, 0).0 + CELL.0 / 2 - 5 * number.len() as i32;
        area.draw(&Text::new(number, (left, bottom + 8), small()))?;
    }
    area.draw(&Text::new("elevation of the sun (degrees)", (CORNER.0 + 230, bottom + 40), small()))?;
    area.draw(&Text::new("view above the observer's horizon (degrees)", (24, bottom - 130), upright))
}
