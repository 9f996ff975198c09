//! What sorairo says about itself: the error of its fits, the paper's experiment, run time against error.

pub mod bands;
pub mod bench;
pub mod chart;
pub mod comparison;
pub mod document;
pub mod error;
pub mod judge;
pub mod light_field;
pub mod measured;
mod measured_picture;
pub mod metrics;
mod moving_sun;
pub mod picture;
mod problem;
pub mod readback;
pub mod reproduce;
mod resident;
pub mod speed;
pub mod stress;
pub mod timing;

pub use problem::{Error, Result};
