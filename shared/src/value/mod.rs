//! What the physics is written for: a number for each of some bands or wavelengths, which share a path.
//!
//! On a device a value has four bands, in a `Vec4`; on a processor as many wavelengths as share a ray, in `Lanes`,
//! over which a compiler spreads its loops.

mod bands;
#[cfg(not(target_arch = "spirv"))]
mod lanes;

pub use bands::Value;
#[cfg(not(target_arch = "spirv"))]
pub use lanes::Lanes;
