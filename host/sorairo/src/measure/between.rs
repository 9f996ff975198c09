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
use sorairo_shared::medium::atmosphere::ColumnDensities;

use crate::error::{Error, Result, check_wavelengths};
use crate::input::shown;
use crate::measure::direction::Direction;
use crate::measure::spectrum::integral_at;
use crate::medium::gases::{Absorption, SkyGases};
use crate::plan::integral::RayIntegral;
use crate::plan::strengths::{FIRST_LINE, Strengths, through_strengths, without_lines};
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
    /// Transmittance: the fraction of light from the far point that arrives, 1 over no distance. Where lines of gases
    /// absorb, it is that of sunlight as it falls on the far point, after the lines above.
    pub transmittance: f64,
    /// In-scattered radiance of all orders (W·m⁻²·sr⁻¹·nm⁻¹; sr⁻¹ with the flat sun).
    pub radiance: f64,
}

/// The air between an observer and other points, at given wavelengths. Data common to all points is prepared once.
pub struct AirBetween {
    /// For transmittance.
    integral: RayIntegral,
    irradiance: Vec<f64>,
    /// Where light goes through the lines of gases, the integral without them and at strengths.
    lines: Option<(RayIntegral, Strengths)>,
    /// What lines let through, where the integral for transmittance has none.
    through_lines: Option<ThroughLines>,
    is_night: bool,
}

/// Transmittance of the lines of gases. A bin of wavelengths has no one coefficient: light that crossed the same gases
/// before loses less to them.
struct ThroughLines {
    absorptions: Vec<Option<Absorption>>,
    gases: SkyGases,
}

impl ThroughLines {
    fn new(gases: &SkyGases, wavelengths: &[f64]) -> Self {
        let absorption = |&nm: &f64| (nm >= FIRST_LINE).then(|| gases.absorption(nm));
        Self { absorptions: wavelengths.iter().map(absorption).collect(), gases: gases.clone() }
    }

    /// Transmittance at each wavelength of light that crossed other air before.
    fn transmittance(&self, before: ColumnDensities, along: ColumnDensities) -> impl Iterator<Item = f64> {
        let [before, both] = [before, before + along].map(|c| self.gases.amounts(c.pairs.into(), c.water.into()));
        let of = move |at: &Absorption| at.transmittance(&both) / at.transmittance(&before);
        self.absorptions.iter().map(move |at| at.as_ref().map_or(1.0, of))
    }
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
        let optics = optics_of(&sky.scene);
        let air = Self::at(sky, &optics, wavelengths, Strengths::new(&sky.scene, &optics, wavelengths));
        let through_lines = optics.gases.as_ref().map(|gases| ThroughLines::new(gases, wavelengths));
        let integral = RayIntegral { bands: without_lines(&optics, wavelengths), ..air.integral };
        Ok(Self { integral, through_lines, ..air })
    }

    /// The same at the observer nodes, in means over their steps. Transmittance of colours has one coefficient for the
    /// lines of a node, as have volumes.
    pub(crate) fn over_steps(sky: &SkyPlan) -> Self {
        let (optics, nodes) = (&sky.base.optics, observer::wavelengths());
        Self::at(sky, optics, &nodes, Strengths::of_colours(optics, &nodes))
    }

    fn at(sky: &SkyPlan, optics: &Optics, wavelengths: &[f64], strengths: Option<Strengths>) -> Self {
        let integral = integral_at(sky, optics, wavelengths);
        let irradiance = wavelengths.iter().map(|&wavelength| optics.solar_irradiance(wavelength)).collect();
        let lines = strengths
            .map(|strengths| (through_strengths(&integral, optics, &strengths.behind(wavelengths)), strengths));
        Self { integral, irradiance, lines, through_lines: None, is_night: sky.is_night }
    }

    /// Transmittance at each wavelength up to a distance (km).
    fn transmittance_until(&self, view: Vec3, distance: f64) -> Vec<f64> {
        let mut transmittance = self.integral.transmittance_until(view, distance);
        if let Some(lines) = &self.through_lines {
            let before = self.integral.sunlight_columns_at(view, distance);
            let left = lines.transmittance(before, self.integral.columns_until(view, distance));
            transmittance.iter_mut().zip(left).for_each(|(transmittance, left)| *transmittance *= left);
        }
        transmittance
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
        let transmittance = self.transmittance_until(view, distance);
        let transfer = self.transfer_until(view, distance);
        let light = transmittance.into_iter().zip(transfer).zip(&self.irradiance);
        let sample = |(((transmittance, transfer), irradiance), &wavelength_nm): (((f64, f64), &f64), &f64)| {
            BetweenSample { wavelength_nm, transmittance, radiance: (transfer * irradiance).max(0.0) }
        };
        Ok(light.zip(&self.integral.wavelengths).map(sample).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::gases::Gases;
    use crate::scene::{Preset, Scene};

    /// What lies along a path as the profile itself has it: two columns stand for four classes of amounts.
    #[test]
    fn lines_absorb_by_what_lies_along_the_path() {
        let mut scene = Scene::preset(Preset::Standard);
        let profile = Gases::of(scene.atmosphere.profile.measured().unwrap());
        let wavelengths: Vec<f64> = (0..40).map(|i| 590.5 + 5.0 * f64::from(i)).collect();
        let paths = [(0.0, 0.0, 3.0), (0.0, 0.0, 30.0), (0.0, 5.0, 100.0), (3.0, -1.0, 100.0), (10.0, 0.5, 200.0)];
        for (altitude, elevation, distance) in paths {
            scene.observer.altitude = altitude;
            let air = Sky::new(&scene).unwrap().between(&wavelengths).unwrap();
            let lines = air.through_lines.as_ref().unwrap();
            let view = Direction { elevation, azimuth: 90.0 }.vector().unwrap();
            let found = lines.transmittance(ColumnDensities::ZERO, air.integral.columns_until(view, distance));
            let eye = f64::from(air.integral.uniform.atmosphere.ground_radius) + altitude;
            let height = |s: f64| (eye * eye + s * s + 2.0 * eye * s * f64::from(view.z)).sqrt() - eye + altitude;
            let mut amounts = lines.gases.amounts(0.0, 0.0);
            const STEPS: u32 = 1000;
            for i in 0..STEPS {
                let here = profile.at(height(distance * (f64::from(i) + 0.5) / f64::from(STEPS)));
                let step = distance / f64::from(STEPS);
                // Nitrogen dioxide, the last, is no line.
                amounts.iter_mut().zip(here).take(4).for_each(|(amount, here)| *amount += here * step);
            }
            let mut least = 1.0f64;
            for ((nm, absorption), found) in wavelengths.iter().zip(&lines.absorptions).zip(found) {
                let truth = absorption.as_ref().unwrap().transmittance(&amounts);
                // What the band model itself is known to; largest from 10 km, 8e-3 from the ground.
                assert!((found - truth).abs() < 0.015, "{nm} nm, {altitude} km, {distance} km: {found}, not {truth}");
                least = least.min(truth);
            }
            assert!(least < 0.7, "{altitude} km, {elevation}°, {distance} km: {least}");
        }
    }
}
