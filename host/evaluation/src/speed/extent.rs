//! How much a bench measures.

use sorairo::scene::Size;

use crate::moving_sun::FRAMES;
use crate::timing::Care;

/// How much is measured.
#[derive(Clone, Copy)]
pub(super) struct Extent {
    pub(super) quick: bool,
    pub(super) care: Care,
    /// The image on which paths and kernels are compared.
    pub(super) common: Size,
    /// Images of 2 to this power of pixels are the largest.
    pub(super) largest: u32,
    /// How often the window is opened, an odd number.
    pub(super) windows: usize,
    /// Skies that it counts.
    pub(super) skies: u32,
    /// Frames of a sun that moves.
    pub(super) frames: u32,
}

impl Extent {
    pub(super) fn of(quick: bool) -> Self {
        let care = Care::of(quick);
        if quick {
            let common = Size { width: 256, height: 128 };
            Self { quick, care, common, largest: 21, windows: 1, skies: 12, frames: 4 }
        } else {
            let common = Size { width: 1920, height: 960 };
            Self { quick, care, common, largest: 25, windows: 3, skies: 120, frames: FRAMES }
        }
    }
}
