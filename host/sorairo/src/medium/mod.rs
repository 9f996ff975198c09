//! What fills the air: measured profiles, and the tables that the kernels take of them.

pub mod aerosol;
pub mod bent;
pub mod density;
pub mod gases;
pub mod levels;
pub mod profile;
mod sounding;
pub mod tables;
