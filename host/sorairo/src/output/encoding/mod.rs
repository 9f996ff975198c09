//! Images as bytes: what a file holds, wherever it goes.

pub(crate) mod checksum;
pub mod exr;
mod halves;
mod image;
pub(crate) mod label;
pub mod png;
pub mod spectral;

pub use image::{Image, Sunlight};
#[cfg(feature = "files")]
pub(crate) use image::{linear, picture};
