//! Aerosol: known kinds, phase functions as tables, where aerosol lies, and the sum of several modes; spheres by Mie's
//! theory, and the inversions of AERONET.

pub mod inversion;
mod kind;
mod layers;
mod mie;
mod mixture;
mod phase;
mod polarisation;
mod spheres;

pub use kind::{AerosolKind, Kind};
pub use layers::{Lane, Layer};
pub use mie::Sphere;
pub use mixture::{Albedo, Extinction, Mixture, Mode, Scattering};
pub use nalgebra::Complex;
pub use phase::{Phase, abscissa};
pub use spheres::{LONGEST, Optics, scattered};
