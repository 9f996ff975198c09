//! Files: written beside their place and renamed into it when all are whole, so that no reader ever sees half of one.

mod check;
pub mod exr;
mod format;
mod label;
mod place;
pub mod png;
mod signature;
pub mod spectral;
mod staged;
pub mod text;
mod writer;

pub use check::{check_distinct, check_room, check_writable, make_folder};
pub use format::Format;
pub use signature::is_finished;
pub use staged::{Staged, remove_unfinished, stage};
pub use writer::{Image, Writer, write};
