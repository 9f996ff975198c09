//! The light field on the processor: one order of scattering after the other, and where they end.

pub(crate) mod azimuths;
pub(crate) mod field;
pub(crate) mod irradiance;
pub(crate) mod made;
mod plane_parallel;
pub(crate) mod rays;
pub(crate) mod room;
pub(crate) mod sampling;
pub(crate) mod series;
pub(crate) mod values;
