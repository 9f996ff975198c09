//! What becomes of images: bytes, files, frames one after the other.

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
