//! What is asked of the window.

use std::path::Path;

use sorairo::scene::ValidScene;

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
    /// So many skies are shown while the sun moves; then the window closes.
    pub frames: Option<u32>,
}
