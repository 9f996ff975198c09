//! Between the nodes of tables.

pub mod azimuth;
pub mod cubic;
