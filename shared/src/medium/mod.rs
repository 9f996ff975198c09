//! What fills the air.

pub mod bands;
pub mod phase;
pub mod profile;
