//! Light scattered more than once: how finely a sky's light field is resolved, and the lookup that kernels read; see
//! [`sorairo_shared::light_field::multiple`].
//!
//! # What is chosen, and why
//!
//! The light field is computed by successive orders over a table of altitudes and suns. What each resolution leaves was measured against
//! tables four times as fine, and those against a Monte Carlo reference. In thick layers, where orders do not come to an end, `sampling` says where altitudes
//! and samples stand and `plane_parallel` sums what remains.

mod device_field;
mod device_lists;
mod device_rays;
mod field;
mod grid;
mod kept;
mod plane_parallel;
mod rays;
mod refined;
mod resolution;
mod sampling;
mod series;
mod setting;
mod sights;
mod suns;
mod values;
mod view;
mod wavelengths;

pub use device_rays::scattered_once;
pub use field::{LightField, OrdersMade};
pub use kept::{Keep, LightFields};
pub use refined::Refined;
pub use resolution::{COMPARED_DEPTH, NEGLIGIBLE, Resolution};
pub use setting::{AerosolMoments, Setting};
pub use sights::{Light, Row};
pub use view::{MultipleLight, TOGETHER, View, light_of_rows};
pub use wavelengths::Wavelengths;
