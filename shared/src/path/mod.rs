//! Where light goes, and what is scattered once on its way.

pub mod single;
