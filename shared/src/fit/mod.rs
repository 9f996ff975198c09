//! The spectrum between bands, and its sum over an observer.

pub mod observer;
pub mod spectrum;
