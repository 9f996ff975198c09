//! What sorairo says about itself: the error of its fits, the paper's experiment, run time against error.

pub mod bands;
pub mod error;
pub mod metrics;
