//! A contact sheet: the frames of a sequence, small, on one picture.

use std::path::Path;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::chart::register_fonts;
use crate::PixelFormat;
use crate::backend::Device;
use crate::error::{Error, Result};
use crate::output::png;
use crate::plan::Plan;
use crate::scene::Size;
use crate::sequence::Frame;

/// Most frames on a sheet; of a longer sequence it shows as many, evenly spread.
const MOST: usize = 64;
/// The longer side of a frame on the sheet (pixels).
const SIDE: u32 = 192;
/// Room below each frame for its number and sun, and around it (pixels).
const LABEL: u32 = 20;
const GAP: u32 = 6;

/// Renders the frames of a sequence small, and writes them as one picture with number and elevation of the sun below each.
///
/// # Errors
///
/// [`Error::Request`] for a wrong scene, [`Error::Device`] if the device fails, [`Error::Failure`] if the picture cannot be
/// written.
pub fn contact_sheet(path: &Path, frames: &[Frame], device: &mut Device) -> Result<()> {
    register_fonts();
    let shown = frames.len().min(MOST);
    let frames: Vec<&Frame> = (0..shown).map(|i| &frames[i * frames.len() / shown]).collect();
    let Some(first) = frames.first() else { return Ok(()) };
    let cell = small(first.scene.camera.size);
    let columns = (frames.len() as f64).sqrt().ceil() as u32;
    let rows = (frames.len() as u32).div_ceil(columns);
    let (width, height) = (GAP + columns * (cell.width + GAP), GAP + rows * (cell.height + LABEL + GAP));
    let mut rgb = vec![255; 3 * width as usize * height as usize];
    for (i, frame) in (0..).zip(&frames) {
        let (left, top) = (GAP + i % columns * (cell.width + GAP), GAP + i / columns * (cell.height + LABEL + GAP));
        let mut scene = frame.scene.clone();
        scene.camera.size = cell;
        let plan = Plan::new(&scene, PixelFormat::Picture)?;
        let bytes = png::unpack(&device.run(&plan, plan.kernel())?.words);
        for (row, line) in (top..).zip(bytes.chunks(3 * cell.width as usize)) {
            let at = 3 * (row as usize * width as usize + left as usize);
            rgb[at..at + line.len()].copy_from_slice(line);
        }
        let label = format!("{}   sun {:.1}°", frame.number, scene.sun.elevation);
        let place = ((left + cell.width / 2) as i32, (top + cell.height + LABEL / 2) as i32);
        let style = ("sans-serif", 13.0).into_font().color(&BLACK).pos(Pos::new(HPos::Center, VPos::Center));
        BitMapBackend::with_buffer(&mut rgb, (width, height))
            .into_drawing_area()
            .draw(&Text::new(label, place, style))
            .map_err(|error| Error::failure(format!("the contact sheet cannot be drawn: {error}")))?;
    }
    png::write(path, width, height, &rgb)?.commit()
}

/// The size of a frame on the sheet.
fn small(size: Size) -> Size {
    let longest = size.width.max(size.height);
    let side = |pixels: u32| ((f64::from(pixels) * f64::from(SIDE) / f64::from(longest)).round() as u32).max(1);
    Size { width: side(size.width), height: side(size.height) }
}
