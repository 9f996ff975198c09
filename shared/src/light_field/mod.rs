//! Light that was scattered more than once.

pub mod field_kernels;
pub mod field_uniform;
pub mod ground;
pub mod moments;
#[cfg(not(target_arch = "spirv"))]
pub mod multiple;
pub mod multiple_lookup;
pub mod rays;
pub mod source;
