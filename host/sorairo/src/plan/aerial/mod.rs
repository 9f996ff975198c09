//! In-scattered light and transmittance at many distances along a ray, in one march.
//!
//! [`crate::plan::integral::RayIntegral::transfer_until`] integrates a ray up to one distance. Here a ray is marched
//! once through increasing distances, and its partial integrals are stored at each. Below the ground the march
//! continues through air as it is at the ground. Volumes can then be interpolated between two rays of which only one
//! meets the ground.

mod colours;
mod every_direction;
mod light;
mod steps;

pub use colours::AirColours;
pub use every_direction::AirPlan;
pub use light::SlicedAir;
