//! Aerosol: known kinds, phase functions as tables, where aerosol lies, and the sum of several modes.

mod kind;
mod layers;
mod mixture;
mod phase;
mod polarisation;

pub use kind::{AerosolKind, Kind};
pub use layers::{Lane, Layer};
pub use mixture::{Albedo, Extinction, Mixture, Mode, Scattering};
pub use phase::{Phase, abscissa};
