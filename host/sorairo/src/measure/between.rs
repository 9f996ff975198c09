//! Transmittance and in-scattered radiance of the air between two points.
//!
//! For any point `P` on a ray
//!
//! ```text
//! L(observer) = L(observer to P) + T(observer to P) · L(P)
//! ```
//!
//! where `L(observer to P)` is the radiance of all orders that the air in front of `P` scatters towards the observer.
//! It is the integral of a whole ray, ended at `P`; see [`sorairo_shared::path::single`] and
//! [`sorairo_shared::light_field`].

use serde::Serialize;
use sorairo_shared::glam::Vec3;

use crate::error::{Error, Result, check_wavelengths};
use crate::input::shown;
use crate::measure::direction::Direction;
use crate::measure::spectrum::integral_at;
use crate::plan::integral::RayIntegral;
use crate::plan::strengths::{Strengths, through_strengths};
use crate::plan::{Sky, SkyPlan, optics_of};
use crate::spectra::observer;
use crate::spectra::optics::Optics;

/// How far behind the ground (as a part of its distance) a distance may lie that was meant to end on it.
const ON_THE_GROUND: f64 = 1e-3;

/// Transmittance and in-scattered radiance of the air between two points at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct BetweenSample {
    /// Wavelength (nm).
    pub wavelength_nm: f64,
    /// Transmittance: the fraction of light from the far point that arrives, 1 over no distance.
    pub transmittance: f64,
    /// In-scattered radiance of all orders (W·m⁻²·sr⁻¹·nm⁻¹; sr⁻¹ with the flat sun).
    pub radiance: f64,
}

/// The air between an observer and other points, at given wavelengths. Data common to all points is prepared once.
pub struct AirBetween {
    integral: RayIntegral,
    irradiance: Vec<f64>,
    /// Where light goes through the lines of gases, the integral without them and at strengths.
    lines: Option<(RayIntegral, Strengths)>,
    is_night: bool,
}

impl Sky {
    /// The air between the observer and any point, at wavelengths (nm) of visible light.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] for a wavelength at which the scene has no data.
    pub fn between(&self, wavelengths: &[f64]) -> Result<AirBetween> {
        AirBetween::new(self.plan(), wavelengths)
    }
}

impl AirBetween {
    fn new(sky: &SkyPlan, wavelengths: &[f64]) -> Result<Self> {
        check_wavelengths(sky.scene.known_wavelengths(), wavelengths)?;
        Ok(Self::as_read(sky, &optics_of(&sky.scene), wavelengths))
    }

    /// The same at the observer nodes, in means over their steps, with light through the lines of gases.
    pub(crate) fn over_steps(sky: &SkyPlan) -> Self {
        let (optics, nodes) = (&sky.base.optics, observer::wavelengths());
        let air = Self::as_read(sky, optics, &nodes);
        let lines = Strengths::of_colours(optics, &nodes)
            .map(|strengths| (through_strengths(&air.integral, optics, &strengths.behind(&nodes)), strengths));
        Self { lines, ..air }
    }

    fn as_read(sky: &SkyPlan, optics: &Optics, wavelengths: &[f64]) -> Self {
        let integral = integral_at(sky, optics, wavelengths);
        let irradiance = wavelengths.iter().map(|&wavelength| integral.optics.solar_irradiance(wavelength)).collect();
        Self { integral, irradiance, lines: None, is_night: sky.is_night }
    }

    /// Transfer (sr⁻¹) at each wavelength up to a distance (km).
    fn transfer_until(&self, view: Vec3, distance: f64) -> Vec<f64> {
        if self.is_night {
            return vec![0.0; self.irradiance.len()];
        }
        match &self.lines {
            Some((integral, strengths)) => strengths.through(integral.transfer_until(view, distance)),
            None => self.integral.transfer_until(view, distance),
        }
    }

    /// Solar irradiance above the atmosphere at each wavelength (W·m⁻²·nm⁻¹).
    pub(crate) fn irradiance(&self) -> &[f64] {
        &self.irradiance
    }

    /// Distance of the ground in a direction (km); `None` if the ray does not meet it.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] for an invalid direction.
    pub fn ground(&self, direction: &Direction) -> Result<Option<f64>> {
        Ok(self.integral.ground_distance(direction.vector()?))
    }

    /// Transmittance and in-scattered radiance up to a distance (km) in a direction; infinity means all of the air.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] for an invalid direction, [`Error::NotAllowed`] for a distance that is negative, NaN, or
    /// beyond the ground.
    pub fn until(&self, direction: &Direction, distance: f64) -> Result<Vec<BetweenSample>> {
        let view = direction.vector()?;
        if distance.is_nan() || distance < 0.0 {
            return Err(Error::not_allowed("distance", format!("is {distance}; it must be 0 km or more")));
        }
        let ground = self.integral.ground_distance(view).unwrap_or(f64::INFINITY);
        if distance > ground * (1.0 + ON_THE_GROUND) {
            let complaint = format!("is {} km, and the ground is {ground:.3} km away there", shown(distance));
            return Err(Error::not_allowed("distance", complaint));
        }
        let distance = distance.min(ground);
        let transmittance = self.integral.transmittance_until(view, distance);
        let transfer = self.transfer_until(view, distance);
        let light = transmittance.into_iter().zip(transfer).zip(&self.irradiance);
        let sample = |(((transmittance, transfer), irradiance), &wavelength_nm): (((f64, f64), &f64), &f64)| {
            BetweenSample { wavelength_nm, transmittance, radiance: (transfer * irradiance).max(0.0) }
        };
        Ok(light.zip(&self.integral.wavelengths).map(sample).collect())
    }
}
