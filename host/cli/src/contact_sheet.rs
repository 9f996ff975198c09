//! A contact sheet: the frames of a sequence, small, on one picture.

use std::path::Path;

use sorairo::files::{self, png};
use sorairo::sequence::Frame;
use sorairo::{Device, LightFields, PixelFormat, Plan, Result, scene};

use crate::sheet::Sheet;

/// Most frames on a sheet; of a longer sequence it shows as many, evenly spread from the first to the last.
const MOST: usize = 64;
/// The longer side of a frame on the sheet (pixels).
const SIDE: u32 = 192;
/// Room below each frame for its number and sun, and around it (pixels).
const LABEL: u32 = 20;
const GAP: u32 = 6;

/// The keyword under which the sheet says what it was made of.
const KEYWORD: &str = "sorairoSequence";

/// What a sheet says that it was made of, if it is whole.
pub fn made_of(path: &Path) -> Option<String> {
    files::png_text(path, KEYWORD)
}

/// Renders the frames of a sequence small, and writes them as one picture with number and elevation of the sun below
/// each. `made_of` says in the file what it was made of; see [`crate::known`].
///
/// # Errors
///
/// What is wrong with a scene, [`sorairo::Error::Device`] if the device fails, [`sorairo::Error::Write`] if the picture
/// cannot be written.
pub fn contact_sheet(path: &Path, frames: &[Frame], made_of: &str, device: &mut Device) -> Result<()> {
    let shown = frames.len().min(MOST);
    let spread = |i: usize| i * (frames.len() - 1) / (shown - 1).max(1);
    let frames: Vec<&Frame> = (0..shown).map(|i| &frames[spread(i)]).collect();
    let Some(first) = frames.first() else { return Ok(()) };
    // The sheet has 8 bits.
    let asked = first.scene.render.display;
    let display = if asked.is_hdr() { scene::Display::Srgb } else { asked };
    let cell = small(first.scene.camera.size);
    let columns = (frames.len() as f64).sqrt().ceil() as u32;
    let rows = (frames.len() as u32).div_ceil(columns);
    let (width, height) = (GAP + columns * (cell.width + GAP), GAP + rows * (cell.height + LABEL + GAP));
    let (mut sheet, light_fields) = (Sheet::white(width, height), LightFields::default());
    for (i, frame) in (0..).zip(&frames) {
        let (left, top) = (GAP + i % columns * (cell.width + GAP), GAP + i / columns * (cell.height + LABEL + GAP));
        let mut scene = frame.scene.clone().into_scene();
        scene.camera.size = cell;
        scene.render.display = display;
        let plan = Plan::with_light_fields(&scene.validated()?, PixelFormat::Picture, &light_fields);
        let bytes = png::unpack(&device.pixels(&plan)?.words);
        sheet.paste(left, top, cell.width, &bytes);
        let label = format!("{}   sun {:.1}°", frame.number, scene.sun.elevation);
        sheet.write(left + cell.width / 2, top + cell.height + LABEL / 2, &label);
    }
    png::write_with_text(path, (width, height), &sheet.rgb, display, KEYWORD, made_of)?.commit()
}

/// The size of a frame on the sheet.
fn small(size: scene::Size) -> scene::Size {
    let longest = size.width.max(size.height);
    let side = |pixels: u32| ((f64::from(pixels) * f64::from(SIDE) / f64::from(longest)).round() as u32).max(1);
    scene::Size { width: side(size.width), height: side(size.height) }
}
