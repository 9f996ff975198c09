//! Light between two points as linear RGB, for whoever has no spectra.
//!
//! What the air adds is a colour, as that of the sky. What it lets through is a spectrum, and no three numbers are
//! right for every light behind it. Here they are those of sunlight as it is above the atmosphere:
//!
//! ```text
//! T_i = RGB_i(∫ T(λ) E(λ) xyz(λ) dλ) / RGB_i(∫ E(λ) xyz(λ) dλ)
//! ```
//!
//! A white wall in that light is seen as it would be by its spectrum; light of another colour is off by as much as its
//! spectrum bends within what an eye takes together.

use serde::Serialize;
use sorairo_shared::glam::DVec3;

use crate::error::Result;
use crate::measure::between::AirBetween;
use crate::measure::direction::Direction;
use crate::plan::picture::colour_space::ColourSpace;
use crate::plan::{Sky, SkyPlan};
use crate::spectra::observer::{self, ColourObserver};

/// What the air between two points does to linear RGB of a scene's space: light from behind, `behind`, arrives as
/// `transmittance * behind + radiance`, channel by channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct BetweenRgb {
    /// The part of sunlight from the far point that arrives, in each channel: 1 over no distance.
    pub transmittance: [f64; 3],
    /// Light of all orders that is scattered towards the observer on the way (W·m⁻²·sr⁻¹; of the flat sun nm·sr⁻¹).
    pub radiance: [f64; 3],
}

/// The air between an observer and other points in linear RGB, by the spectrum at each of the observer's nodes, from
/// 380 to 780 nm: the reference of what fits through fewer bands. What all points share is prepared once.
pub struct AirBetweenRgb {
    air: AirBetween,
    observer: ColourObserver,
    space: ColourSpace,
    sun: DVec3,
}

impl Sky {
    /// The air between the observer and any point, in the sky's space of linear RGB.
    pub fn between_rgb(&self) -> AirBetweenRgb {
        AirBetweenRgb::new(self)
    }
}

impl AirBetweenRgb {
    fn new(sky: &SkyPlan) -> Self {
        let air = AirBetween::over_steps(sky);
        let (observer, space) = (sky.observer, sky.space);
        let sun = space.into_gamut(space.from_xyz * observer::xyz_of_samples(observer, air.irradiance()));
        Self { air, observer, space, sun }
    }

    /// What lies up to a distance (km) in a direction; an infinite distance is all air there.
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
