//! The GPU entry points of sorairo: each fetches its index and calls the kernel of the same name in `sorairo-shared`.
//!
//! Two modules are compiled of them, one for each feature: who draws needs none of what plans ask of a device. The
//! specialisation constant 0 is the kernel's variant (`sorairo_shared::variant`).
#![cfg_attr(target_arch = "spirv", no_std)]
#![deny(warnings)] // a shader build does not show them otherwise

#[cfg(feature = "images")]
pub mod images;
#[cfg(feature = "plans")]
pub mod plans;

/// The module of what draws and measures in SPIR-V, as `cargo xtask shaders` compiled it.
#[cfg(not(target_arch = "spirv"))]
pub const IMAGES: &[u8] = include_bytes!("../compiled/images.spv");

/// The module of what plans ask of a device.
#[cfg(not(target_arch = "spirv"))]
pub const PLANS: &[u8] = include_bytes!("../compiled/plans.spv");
