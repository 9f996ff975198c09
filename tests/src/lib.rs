//! What the tests of sorairo share: comparators that can fail, and the program
//! as a person runs it.

pub mod compare;
pub mod program;
pub mod sky;
