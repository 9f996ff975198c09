//! The light field on a device: which kernels run after each other, and what lies where.

pub(crate) mod field;
mod lists;
pub(crate) mod rays;
