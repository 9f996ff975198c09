//! Queries of a sky: radiance, irradiance, transmittance.

pub mod between;
pub mod between_rgb;
pub mod broadband;
pub mod direction;
pub mod irradiance;
pub mod light_table;
pub mod spectral_irradiance;
pub mod spectrum;
pub mod stokes;
#[cfg(feature = "files")]
pub mod stokes_image;
pub mod suns;
pub mod surface;
pub mod volume;
