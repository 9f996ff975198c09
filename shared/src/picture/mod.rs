//! From a pixel to the sky that it shows.

pub mod air;
pub mod below;
pub mod disc;
pub mod environment;
pub mod formed_run;
pub mod lookup;
pub mod perspective_run;
pub mod polariser;
pub mod run;
