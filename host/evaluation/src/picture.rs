//! Many pictures on one sheet, with titles.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use ::png::{ColorType, Decoder, DecodingError};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::chart::register_fonts;
use crate::problem::{Error, Result};
use sorairo::files::png;

/// Room above the columns, left of the rows, between pictures, and below for the scale (pixels).
const TOP: u32 = 34;
const LEFT: u32 = 52;
const GAP: u32 = 8;
const BOTTOM: u32 = 64;

/// A white sheet with a grid of square pictures.
pub struct Sheet {
    side: u32,
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

impl Sheet {
    /// An empty sheet for pictures of `side` pixels.
    pub fn new(side: u32, columns: u32, rows: u32) -> Self {
        register_fonts();
        let (width, height) = (LEFT + columns * (side + GAP), TOP + rows * (side + GAP) + BOTTOM);
        Self { side, width, height, rgb: vec![255; (3 * width * height) as usize] }
    }

    /// Copies a picture from a file into its place; what is black outside a fisheye's circle stays white.
    ///
    /// # Errors
    ///
    /// [`Error::Picture`] if the file cannot be read or has another size.
    pub fn place(&mut self, column: u32, row: u32, path: &Path) -> Result<()> {
        let unreadable = |reason: String| Error::Picture { path: path.to_owned(), reason };
        let (size, picture) = read(path).map_err(|error| unreadable(error.to_string()))?;
        if size != (self.side, self.side) {
            return Err(unreadable(format!("it is not {0} by {0} pixels", self.side)));
        }
        let (left, top) = self.corner(column, row);
        let half = f64::from(self.side) / 2.0;
        let places = (0..self.side).flat_map(|y| (0..self.side).map(move |x| (x, y)));
        for ((x, y), pixel) in places.zip(picture.chunks(3)) {
            let inside = (f64::from(x) + 0.5 - half).hypot(f64::from(y) + 0.5 - half) <= half;
            if inside {
                let at = (3 * ((top + y) * self.width + left + x)) as usize;
                self.rgb[at..at + 3].copy_from_slice(pixel);
            }
        }
        Ok(())
    }

    fn corner(&self, column: u32, row: u32) -> (u32, u32) {
        (LEFT + column * (self.side + GAP), TOP + row * (self.side + GAP))
    }

    /// Writes above a column.
    ///
    /// # Errors
    ///
    /// [`Error::Drawing`] if the text cannot be drawn.
    pub fn column_title(&mut self, column: u32, title: &str) -> Result<()> {
        let (left, top) = self.corner(column, 0);
        self.text(title, (left + self.side / 2, top - 16))
    }

    /// Writes left of a row.
    ///
    /// # Errors
    ///
    /// [`Error::Drawing`] if the text cannot be drawn.
    pub fn row_title(&mut self, row: u32, title: &str) -> Result<()> {
        let (left, top) = self.corner(0, row);
        self.text(title, (left - 26, top + self.side / 2))
    }

    /// Draws a scale at the bottom right: four decades of `heat` from 0.001 on, with a label at each.
    ///
    /// # Errors
    ///
    /// [`Error::Drawing`] if the text cannot be drawn.
    pub fn scale(&mut self, heat: impl Fn(f64) -> [u8; 3], labels: &[&str]) -> Result<()> {
        const LENGTH: u32 = 400;
        let (left, top) = (self.width - LENGTH - 40, self.height - BOTTOM + 10);
        for x in 0..LENGTH {
            let colour = heat(1e-3 * 10f64.powf(4.0 * f64::from(x) / f64::from(LENGTH)));
            for y in 0..18 {
                let at = (3 * ((top + y) * self.width + left + x)) as usize;
                // A frame, so that the white end can be seen.
                let edge = y == 0 || y == 17 || x == 0 || x == LENGTH - 1;
                self.rgb[at..at + 3].copy_from_slice(&if edge { [120; 3] } else { colour });
            }
        }
        let step = LENGTH / (labels.len() as u32 - 1);
        (0..).zip(labels).try_for_each(|(i, label)| self.text(label, (left + i * step, top + 32)))
    }

    /// Writes a text around a point.
    fn text(&mut self, text: &str, (x, y): (u32, u32)) -> Result<()> {
        let area = BitMapBackend::with_buffer(&mut self.rgb, (self.width, self.height)).into_drawing_area();
        let style = ("sans-serif", 15.0).into_font().color(&BLACK).pos(Pos::new(HPos::Center, VPos::Center));
        area.draw(&Text::new(text, (x as i32, y as i32), style))
            .map_err(|error| Error::Drawing { what: format!("the text {text:?}"), reason: error.to_string() })
    }

    /// Writes the sheet as PNG.
    ///
    /// # Errors
    ///
    /// [`Error::Sky`] if the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        Ok(png::write(path, self.width, self.height, &self.rgb)?.commit()?)
    }
}

/// Width, height and bytes (red, green, blue) of a picture that [`png::write`] wrote.
pub(crate) fn read(path: &Path) -> std::result::Result<((u32, u32), Vec<u8>), DecodingError> {
    let mut reader = Decoder::new(BufReader::new(File::open(path)?)).read_info()?;
    let mut rgb = vec![0; reader.output_buffer_size().unwrap_or(0)];
    let info = reader.next_frame(&mut rgb)?;
    assert_eq!(info.color_type, ColorType::Rgb, "pictures are written in RGB");
    Ok(((info.width, info.height), rgb))
}
