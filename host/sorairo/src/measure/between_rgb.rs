//! Transmittance and in-scattered light between two points as linear RGB.
//!
//! In-scattered light is a colour, like that of the sky. Transmittance is a spectrum, and no three numbers are exact
//! for every light behind the air. Here they are those of sunlight above the atmosphere:
//!
//! ```text
//! T_i = RGB_i(∫ T(λ) E(λ) xyz(λ) dλ) / RGB_i(∫ E(λ) xyz(λ) dλ)
//! ```
//!
//! They are exact for a white wall in that light. For other light, the error is the variation of its spectrum within a
//! channel.

use serde::Serialize;
use sorairo_shared::glam::DVec3;

use crate::error::Result;
use crate::measure::between::AirBetween;
use crate::measure::direction::Direction;
use crate::plan::picture::colour_space::ColourSpace;
use crate::plan::{Sky, SkyPlan};
use crate::spectra::observer::{self, ColourObserver};

/// Transmittance and in-scattered light in linear RGB of the scene's space. Light `behind` the air arrives as
/// `transmittance * behind + radiance`, channel by channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct BetweenRgb {
    /// Transmittance of sunlight in each channel: 1 over no distance.
    pub transmittance: [f64; 3],
    /// In-scattered light of all orders (W·m⁻²·sr⁻¹; nm·sr⁻¹ with the flat sun).
    pub radiance: [f64; 3],
}

/// The air between an observer and other points in linear RGB. It uses the spectrum at each observer node from 380 to
/// 780 nm, and is the reference of fits through fewer bands. Data common to all points is prepared once.
pub struct AirBetweenRgb {
    air: AirBetween,
    observer: ColourObserver,
    space: ColourSpace,
    sun: DVec3,
}

impl Sky {
    /// The air between the observer and any point, in the sky's space of linear RGB.
    pub fn between_rgb(&self) -> AirBetweenRgb {
        AirBetweenRgb::new(self.plan())
    }
}

impl AirBetweenRgb {
    fn new(sky: &SkyPlan) -> Self {
        let air = AirBetween::over_steps(sky);
        let (observer, space) = (sky.observer, sky.space);
        let sun = space.into_gamut(space.from_xyz * observer::xyz_of_samples(observer, air.irradiance()));
        Self { air, observer, space, sun }
    }

    /// Transmittance and in-scattered light up to a distance (km) in a direction; infinity means all of the air.
    ///
    /// # Errors
    ///
    /// Those of [`AirBetween::until`].
    pub fn until(&self, direction: &Direction, distance: f64) -> Result<BetweenRgb> {
        let samples = self.air.until(direction, distance)?;
        let radiance: Vec<f64> = samples.iter().map(|sample| sample.radiance).collect();
        let of_sun = samples.iter().zip(self.air.irradiance()).map(|(sample, sun)| sample.transmittance * sun);
        let transmittance = self.colour(&of_sun.collect::<Vec<_>>()) / self.sun;
        Ok(BetweenRgb { transmittance: transmittance.to_array(), radiance: self.colour(&radiance).to_array() })
    }

    fn colour(&self, spectrum: &[f64]) -> DVec3 {
        self.space.into_gamut(self.space.from_xyz * observer::xyz_of_samples(self.observer, spectrum))
    }
}
