//! What the tests of sorairo share: an independent oracle in double precision, comparators that can fail, and the program
//! as a person runs it.

pub mod compare;
pub mod oracle;
pub mod program;
pub mod sky;
