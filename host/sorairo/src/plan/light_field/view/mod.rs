//! Light that was scattered more than once, as an observer sees it.

pub(crate) mod refined;
pub(crate) mod rows;
