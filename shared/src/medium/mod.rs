//! What fills the air.

pub mod phase;
pub mod profile;
