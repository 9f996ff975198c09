//! The sun's disc: its size, its limb, its light at the observer, and where it lies in the image.

mod disc;
mod in_image;
mod limb;

pub use disc::Sun;
pub use limb::limb_darkening;

pub use crate::plan::picture::sun_irradiance::SunIrradiance;
