//! What is asked of the window.

use std::path::Path;
use std::time::Duration;

use sorairo::scene::{Size, ValidScene};

/// What the window shows as it opens.
pub struct Options<'a> {
    /// The scene; the window decides the size of its image.
    pub scene: ValidScene,
    /// The device, as it was asked for.
    pub device: &'a str,
    /// The point whose spectrum is plotted: fractions of the sky's width and height from the top left.
    pub point: Option<[f64; 2]>,
    /// The file that takes the window's content once all of it is shown; then the window closes.
    pub screenshot: Option<&'a Path>,
    /// So many skies of 960x540 points, where a perspective fills them, are shown while the sun moves; then the window
    /// closes.
    pub frames: Option<u32>,
}

/// Skies that were shown, each with its own sun, and what they took.
#[derive(Clone, Copy, Debug)]
pub struct Counted {
    /// How many.
    pub skies: u32,
    /// Their size (pixels).
    pub size: Size,
    /// The time from the first to the last of them.
    pub time: Duration,
    /// The longest time from one to the next.
    pub longest: Duration,
    /// Pipelines that were compiled for them, and ahead for the rest of their day.
    pub pipelines: usize,
    /// Those that were drawn on the device that shows the window.
    pub drawn: u32,
    /// Those whose pixels came back from a device to be shown.
    pub read_back: u32,
}
