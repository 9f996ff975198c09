//! Light scattered more than once: how finely a sky's light field is resolved, and the lookup that kernels read; see
//! [`sorairo_shared::light_field`].
//!
//! # What is chosen, and why
//!
//! The light field is computed by successive orders over a table of altitudes and suns. What each resolution leaves was
//! measured against tables four times as fine, and those against a Monte Carlo reference. In thick layers, where orders
//! do not come to an end, `orders::sampling` says where altitudes and samples stand and `orders::plane_parallel` sums
//! what remains. `cache` keeps what was computed, `device` has kernels do it, and `view` is what an observer sees of
//! it.

mod cache;
mod device;
mod grid;
mod orders;
mod resolution;
mod setting;
mod sights;
mod suns;
mod view;
mod wavelengths;

pub use cache::{Cacheable, LightFields};
pub use device::rays::scattered_once;
pub use orders::field::LightField;
pub use orders::made::OrdersMade;
pub(crate) use orders::rays::OwnedRay;
pub(crate) use orders::room::Room;
pub use resolution::{COMPARED_DEPTH, NEGLIGIBLE, Resolution};
pub use setting::{AerosolMoments, Setting};
pub use sights::{Light, Row};
pub use view::refined::Refined;
pub use view::rows::{MultipleLight, PolarisedLight, TOGETHER, View, light_of_rows};
pub use wavelengths::Wavelengths;
