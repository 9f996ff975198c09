//! The program as a person runs it, and what other programs make of its files.

mod aerial;
mod cli;
mod ecosystem;
mod examples;
mod farms;
mod faults;
mod scenes;
mod sequence;
mod view;
