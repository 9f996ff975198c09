//! Random sweeps that look for what the tests' chosen cases miss: `sorairo stress`.
//!
//! A case follows from a seed and its number alone, whatever else is tried and on however many threads.

pub mod between;
pub mod energy;
mod error_map;
mod figures;
pub mod integral;
pub mod orders;
mod outcome;
mod report;
pub mod scenes;
pub mod solve;
pub mod spectra;
pub mod steps;

pub use outcome::Outcome;
pub use report::{Extent, Stress, stress};
