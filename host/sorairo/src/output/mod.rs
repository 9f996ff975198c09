//! Output of images: bytes, files, sequences.

#[cfg(feature = "files")]
pub mod aerial;
#[cfg(feature = "encoding")]
pub mod encoding;
#[cfg(feature = "files")]
pub mod files;
#[cfg(feature = "files")]
pub mod render;
#[cfg(feature = "files")]
pub mod sequence;
