//! Rays of a sky: their directions, the rule by which they are integrated, and the light along them.

pub mod directions;
pub(crate) mod hemisphere;
pub mod integral;
pub mod quadrature;
pub mod samples;
pub mod source;
