//! How pictures are graded about their view transform.

use bytemuck::{Pod, Zeroable};

/// The linear value of a picture, of 1 as white, that is middle grey: what a meter is set to, and what a grade turns
/// about.
pub const MIDDLE_GREY: f32 = 0.18;

/// How a picture is graded. The layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Grade {
    /// Factor of the stops about middle grey, before the view transform.
    pub contrast: f32,
    /// Factor of the differences of a colour's stops from their mean by luminance, likewise.
    pub saturation: f32,
    /// Factor of what is shown about the grey of its luminance, as far as the display's gamut goes.
    pub chroma: f32,
    /// Where the tables of [`crate::display::aces`] begin in the colour rows, where the variant has them.
    pub tables: u32,
}

impl Grade {
    /// The grade of a contrast and a saturation before the view transform, and a chroma after it.
    pub const fn new(contrast: f32, saturation: f32, chroma: f32) -> Self {
        Self { contrast, saturation, chroma, tables: 0 }
    }

    /// None.
    pub const NONE: Self = Self::new(1.0, 1.0, 1.0);
}
