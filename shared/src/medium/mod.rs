//! What fills the air.

pub mod atmosphere;
pub mod bands;
pub mod columns;
pub mod density;
pub mod exponential;
pub mod ozone;
pub mod phase;
pub mod tables;
