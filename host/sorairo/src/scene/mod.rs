//! The input of a user: the sun, the observer, the atmosphere, the camera and how to render.
//!
//! [`keys`] holds everything about a key except its name and its description: range, unit, default.

mod aerosol;
mod camera;
#[cfg(feature = "scene-files")]
pub mod command;
mod exposure;
mod field;
#[cfg(feature = "scene-files")]
pub mod file;
pub mod filmstrip;
#[cfg(feature = "scene-files")]
mod implied;
pub mod keys;
mod matrices;
mod optics;
mod orders;
pub mod place;
mod plausible;
mod preset;
#[cfg(feature = "scene-files")]
pub mod reference;
pub mod rules;
mod settings;
pub(crate) mod sky;
mod valid;

pub use crate::medium::aerosol::AerosolKind;
pub use crate::medium::profile::Profile;
pub use crate::spectra::choice::{AirSpectrum, AlbedoSpectrum, GroundAlbedo, OzoneCrossSection, SunSpectrum};
pub use crate::spectra::observer::ColourObserver;
pub use aerosol::{Aeronet, Aerosol, AerosolMode, AerosolProfile, ModeAlbedo, PhaseFunction};
pub use camera::{Below, CameraScene, LONGEST_SIDE, Projection, Reflectance, Size, View};
pub use exposure::{Exposure, MOST_STOPS, Shutter, stops_of_ev100};
pub use orders::Orders;
pub use preset::{Preset, Scene};
pub use settings::{
    ColourPath, Display, Dither, ExrCompression, ExrDepth, Fit, PathChoice, PictureLook, Polarisation, Render, Rgb,
    ViewTransform, WhiteBalance,
};
pub use sky::{Air, AtmosphereScene, Ground, Observer, Ozone, STANDARD_PRESSURE, Site, Sun, Water};
pub use valid::ValidScene;
