//! What the tests of sorairo share: comparators that can fail, the GPU, and the program as a person runs it.

pub mod air;
pub mod compare;
pub mod gpu;
pub mod interpreted;
pub mod own_device;
pub mod program;
pub mod python;
pub mod sky;
pub mod terrain;
pub mod wait;
