//! What to compute and what to skip, decided once per scene in double precision.
//!
//! [`SkyPlan`] decides what the sky alone depends on: samples, bands, fit, exposure. [`Plan`] decides what an image of it takes: the rows that can be
//! lit, the sky lookup, the sun's disc. [`SpectralPlan`] decides by which bands spectra are found.

pub mod aces;
pub(crate) mod below;
pub mod colour_space;
pub mod day;
pub mod directions;
pub mod explain;
pub(crate) mod exposure;
pub mod fit;
pub(crate) mod hemisphere;
mod image;
pub mod integral;
mod kernel;
pub mod lookup;
mod lookup_grid;
pub mod multiple;
pub mod on_device;
pub mod quadrature;
pub mod samples;
mod sky;
pub mod spectral;
pub mod sun_disc;
mod sun_irradiance;
pub mod upload;

pub use directions::direction;
pub use image::Plan;
pub use kernel::Kernel;
pub use lookup_grid::GridKind;
pub use multiple::LightFields;
pub(crate) use sky::optics_of;
pub use sky::{Colours, SkyPlan};
pub use spectral::SpectralPlan;
