//! What the tests of sorairo share: an independent oracle in double precision, and comparators that can fail.

pub mod compare;
pub mod oracle;
pub mod sky;
