//! Where light goes, and what is scattered once on its way.

pub mod ground;
pub(crate) mod observer;
pub mod pieces;
pub(crate) mod ray;
pub(crate) mod samples;
pub mod single;
