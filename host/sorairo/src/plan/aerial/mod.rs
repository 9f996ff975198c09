//! The air in front of things at many distances along a ray, in one walk along it.
//!
//! [`crate::plan::integral::RayIntegral::transfer_until`] integrates a ray up to one distance. Here a ray is walked
//! once, through distances that grow, and what it has gathered is told at each. Beneath the ground the walk goes on
//! through air as it is on it: of a ray that something hides that is nothing, and what stands between two rays, of
//! which one meets the ground before it, is interpolated from smooth numbers.

mod colours;
mod every_direction;
mod light;
mod steps;

pub use colours::AirColours;
pub use every_direction::AirPlan;
pub use light::SlicedAir;
