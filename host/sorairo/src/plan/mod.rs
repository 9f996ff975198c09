//! What to compute and what to skip, decided once per scene in double precision.
//!
//! [`SkyPlan`] decides what depends on the sky alone: samples, bands, fit, exposure. [`Plan`] decides what an image
//! needs: the rows that can be lit, the sky lookup, the sun's disc. [`SpectralPlan`] chooses the bands of spectra.

pub(crate) mod aerial;
pub mod day;
pub mod explain;
pub mod fit;
mod held;
pub(crate) mod hemisphere;
pub mod integral;
mod kernel;
pub mod light_field;
pub mod lookup;
pub mod on_device;
pub mod picture;
mod planner;
pub mod rays;
pub mod samples;
pub(crate) mod shortwave;
mod sky;
pub mod spectral;
pub(crate) mod strengths;
mod stretch;
pub mod upload;

pub use held::Sky;
pub use kernel::Kernel;
pub use light_field::LightFields;
pub use lookup::grid::GridKind;
pub use picture::image::Plan;
pub use planner::SkyPlanner;
pub use rays::directions::direction;
pub(crate) use sky::optics_of;
pub use sky::{Colours, SkyPlan};
pub use spectral::SpectralPlan;
