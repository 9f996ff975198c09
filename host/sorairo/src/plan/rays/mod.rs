//! Rays of a sky: their directions, the source of its light, and the rule by which they are integrated.

pub mod directions;
pub mod quadrature;
pub mod source;
