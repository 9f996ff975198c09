//! Files, written under temporary names and renamed once all are complete, so that no reader sees an incomplete one.

mod check;
mod format;
mod hdr;
mod layers;
mod place;
pub mod png;
mod radiance_picture;
mod radiance_scene;
mod signature;
mod staged;
pub mod text;
mod text_scene;
mod usd_scene;
mod wavelengths;
mod writer;

pub use crate::output::encoding::spectral::Spectra;
pub use crate::output::encoding::{Image, Sunlight, exr, spectral};
pub use check::check_scenes;
pub use check::{Replace, check_distinct, check_room, check_writable, make_folder};
pub use format::Format;
pub use layers::Layers;
pub(crate) use radiance_picture::step as band_width;
pub use signature::{is_finished, is_own, png_text, signature};
pub use staged::{Staged, Standstill, commit_all, remove_unfinished, stage};
pub use wavelengths::{MOST_WAVELENGTHS, default_wavelengths, wavelengths};
pub use writer::{Writer, write};
