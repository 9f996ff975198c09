//! A picture with labels.

use std::convert::Infallible;

use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::iso_8859_1::FONT_7X13;
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::text::{Alignment, Baseline, Text, TextStyleBuilder};

/// The picture: three bytes a pixel, row by row from the top.
pub struct Sheet {
    width: u32,
    height: u32,
    /// Its bytes.
    pub rgb: Vec<u8>,
}

impl Sheet {
    /// White all over.
    pub fn white(width: u32, height: u32) -> Self {
        Self { width, height, rgb: vec![255; 3 * width as usize * height as usize] }
    }

    fn at(&self, column: u32, row: u32) -> usize {
        3 * (row as usize * self.width as usize + column as usize)
    }

    /// Copies a picture of so many columns to a place.
    pub fn paste(&mut self, left: u32, top: u32, columns: u32, bytes: &[u8]) {
        for (row, line) in (top..).zip(bytes.chunks(3 * columns as usize)) {
            let at = self.at(left, row);
            self.rgb[at..at + line.len()].copy_from_slice(line);
        }
    }

    /// Writes a label centred about a pixel.
    pub fn write(&mut self, column: u32, row: u32, label: &str) {
        let font = MonoTextStyle::new(&FONT_7X13, Rgb888::BLACK);
        let centred = TextStyleBuilder::new().alignment(Alignment::Center).baseline(Baseline::Middle).build();
        let text = Text::with_text_style(label, Point::new(column as i32, row as i32), font, centred);
        match text.draw(self) {
            Ok(_) => {}
            Err(never) => match never {},
        }
    }
}

impl OriginDimensions for Sheet {
    fn size(&self) -> Size {
        Size::new(self.width, self.height)
    }
}

impl DrawTarget for Sheet {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> std::result::Result<(), Infallible> {
        let inside = self.bounding_box();
        for Pixel(point, colour) in pixels.into_iter().filter(|Pixel(point, _)| inside.contains(*point)) {
            let at = self.at(point.x as u32, point.y as u32);
            self.rgb[at..at + 3].copy_from_slice(&[colour.r(), colour.g(), colour.b()]);
        }
        Ok(())
    }
}
