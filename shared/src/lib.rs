//! The physics, spectra and colour of sorairo, written once for the CPU and for SPIR-V.
//!
//! The crate is the maths of Takahashi and Dobashi's *Full-spectrum rendering of the sky using GPU*: single
//! scattering of sunlight at a few wavelengths (Eqs. 1-3), a fit through them and its integral against a colour
//! observer (Eqs. 4-7), and RGB (Eq. 8). [`frame`] holds one function per GPU kernel and is the way in.
//!
//! # Conventions
//!
//! * Lengths in **km**, coefficients in **km⁻¹**, wavelengths in **nm**. Angles are cosines.
//! * `z` up, `x` north, `y` west. Azimuth runs clockwise from north as on a compass, elevation from the horizon.
//! * `altitude` (`h`) is above the ground sphere, `r` the distance from the planet's centre. `mu` is the cosine of a
//!   ray's zenith angle, `mu_s` that of the sun, `nu` the cosine between view and sun.
//! * The wavelengths that are integrated are **bands**; a [`glam::Vec4`] of spectral values holds one value per band.
//! * *Transfer* is radiance divided by the solar irradiance at the top of the atmosphere (sr⁻¹).
#![cfg_attr(target_arch = "spirv", no_std)]

pub use spirv_std::glam;

pub mod atmosphere;
pub mod camera;
pub mod color;
pub mod column;
pub mod frame;
pub mod geometry;
pub mod math;
pub mod scattering;
pub mod sky;
pub mod sky_spectrum;
pub mod sky_table;
pub mod spectrum;
pub mod sun_disc;
pub mod variant;
