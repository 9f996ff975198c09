//! Spectral irradiance of surfaces of any orientation.

use rayon::prelude::*;
use serde::Serialize;
use sorairo_shared::glam::DVec3;

use crate::azimuth::within_a_turn;
use crate::error::{Result, check_range, check_wavelengths};
use crate::measure::irradiance::{Pair, pairs};
use crate::measure::spectrum::{Method, RESOLUTIONS, Spectra};
use crate::plan::picture::sun_disc::Sun;
use crate::plan::{Sky, SkyPlan, direction};
use crate::spectra::alpha_opic::{self, AlphaOpic};
use crate::spectra::observer;

/// A surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surface {
    /// Angle between its normal and the zenith (degrees, 0 to 180): 0 for a level one that faces up, 90 for a wall.
    pub tilt: f64,
    /// Azimuth of its normal (degrees, clockwise from north).
    pub azimuth: f64,
}

/// Irradiance of a surface, by source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Irradiance<T> {
    /// From the sun's disc.
    pub direct: T,
    /// From the upper hemisphere, without the sun.
    pub diffuse: T,
    /// From the lower hemisphere: the ground and the air in front of it.
    pub ground: T,
    /// The sum of all.
    pub global: T,
}

impl<T> Irradiance<T> {
    /// The same of each part.
    pub fn map<U>(self, of: impl Fn(T) -> U) -> Irradiance<U> {
        let Self { direct, diffuse, ground, global } = self;
        Irradiance { direct: of(direct), diffuse: of(diffuse), ground: of(ground), global: of(global) }
    }
}

impl Surface {
    /// Its normal.
    fn normal(&self) -> Result<DVec3> {
        check_range("surface_tilt", self.tilt, (0.0, 180.0), "degrees")?;
        Ok(direction(90.0 - self.tilt, within_a_turn("surface_azimuth", self.azimuth)?))
    }
}

impl Sky {
    /// Spectral irradiance of each surface (W·m⁻²·nm⁻¹) at wavelengths (nm). The parts of the sky and the ground use
    /// the fit, that of the sun its disc.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) or [`Error::NotAllowed`](crate::Error::NotAllowed) for an
    /// invalid surface, [`Error::NotAllowed`](crate::Error::NotAllowed) for a wavelength at which the scene has no
    /// data.
    pub fn irradiance(&self, surfaces: &[Surface], wavelengths: &[f64]) -> Result<Vec<Irradiance<Vec<f64>>>> {
        let normals: Vec<DVec3> = surfaces.iter().map(Surface::normal).collect::<Result<_>>()?;
        let spectra = Spectra::new(self.plan(), wavelengths, Method::Fit)?;
        Ok(irradiances_on(&normals, self.plan(), &spectra, &Sun::at(self.plan(), wavelengths)))
    }

    /// Illuminance of each surface (lx) by the sky's observer.
    ///
    /// # Errors
    ///
    /// Those of [`Sky::irradiance`] for a surface.
    pub fn illuminance(&self, surfaces: &[Surface]) -> Result<Vec<Irradiance<f64>>> {
        let lux = |spectrum: Vec<f64>| {
            observer::LUMENS_PER_WATT * observer::xyz_of_samples(self.plan().observer, &spectrum).y
        };
        let normals: Vec<DVec3> = surfaces.iter().map(Surface::normal).collect::<Result<_>>()?;
        let fallen = irradiances_on(&normals, self.plan(), &Spectra::over_steps(self.plan()), &Sun::new(self.plan()));
        Ok(fallen.into_iter().map(|of_surface| of_surface.map(lux)).collect())
    }

    /// The five α-opic irradiances of each surface (W·m⁻²) of CIE S 026, in the order of [`AlphaOpic::all`];
    /// [`AlphaOpic::equivalent_daylight`] converts them to illuminances (lx).
    ///
    /// # Errors
    ///
    /// Those of [`Sky::irradiance`].
    pub fn alpha_opic(&self, surfaces: &[Surface]) -> Result<Vec<[Irradiance<f64>; 5]>> {
        let of_quantities = |fallen: Irradiance<Vec<f64>>| {
            AlphaOpic::all().map(|quantity| fallen.clone().map(|spectrum| quantity.of_samples(&spectrum)))
        };
        Ok(self.irradiance(surfaces, &alpha_opic::wavelengths())?.into_iter().map(of_quantities).collect())
    }

    /// Transmittance of the sun's beam to a surface at the observer that faces the sun, at each wavelength (nm). It is
    /// the mean over the disc, part of which the ground may hide.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`](crate::Error::NotAllowed) for a wavelength at which the beam is not known; see
    /// [`Sky::sun_beam`].
    pub fn transmittance(&self, wavelengths: &[f64]) -> Result<Vec<f64>> {
        check_wavelengths(self.scene().known_wavelengths_of_beams(), wavelengths)?;
        let facing = Sun::at(self.plan(), wavelengths).spectral_irradiance(|_| 1.0);
        let optics = self.scene().optics();
        let transmittance = |(facing, &nm): (f64, &f64)| match optics.solar_irradiance(nm) {
            // A spectrum of one's own may hold no light there.
            0.0 => 0.0,
            irradiance => facing / irradiance,
        };
        Ok(facing.into_iter().zip(wavelengths).map(transmittance).collect())
    }

    /// The sun's beam at wavelengths (nm). With a resolution (nm), values are means about each wavelength. Without it,
    /// the transmittance of gases is the mean over bins of 1 nm (up to 1000 nm) or 5 nm. A measured profile contains
    /// gases, and its beam is known from 280 to 2500 nm.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`](crate::Error::NotAllowed) for a wavelength at which the beam is not known;
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for a resolution that is none.
    pub fn sun_beam(&self, wavelengths: &[f64], resolution: Option<f64>) -> Result<Vec<BeamSample>> {
        let parts = match resolution {
            Some(width) => {
                check_range("resolution", width, RESOLUTIONS, "nm")?;
                (width / LONGEST_PART).ceil() as usize
            }
            None => 1,
        };
        let width = resolution.unwrap_or(0.0);
        let part = |nm: f64, i: usize| nm + width * ((i as f64 + 0.5) / parts as f64 - 0.5);
        let finely: Vec<f64> = wavelengths.iter().flat_map(|&nm| (0..parts).map(move |i| part(nm, i))).collect();
        check_wavelengths(self.scene().known_wavelengths_of_beams(), &finely)?;
        let sun = Sun::at(self.plan(), &finely);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / parts as f64;
        let (transmittance, irradiance) = (sun.transmittance_of_centre(), sun.spectral_irradiance(|_| 1.0));
        let of = |((&wavelength_nm, transmittance), irradiance): ((&f64, &[f64]), &[f64])| BeamSample {
            wavelength_nm,
            transmittance: mean(transmittance),
            irradiance: mean(irradiance),
        };
        Ok(wavelengths.iter().zip(transmittance.chunks(parts)).zip(irradiance.chunks(parts)).map(of).collect())
    }
}

/// Spectral irradiance (W·m⁻²·nm⁻¹) of surfaces by their normals, from spectra and the sun at the same wavelengths.
pub(crate) fn irradiances_on(
    normals: &[DVec3],
    sky: &SkyPlan,
    spectra: &Spectra,
    sun: &Sun<'_>,
) -> Vec<Irradiance<Vec<f64>>> {
    let sides = if sky.is_night { [Vec::new(), Vec::new()] } else { pairs(sky) };
    let lit = sides.map(|pairs| lit_pairs(pairs, normals, spectra));
    let of_surface = |&normal: &DVec3| {
        let direct = sun.spectral_irradiance(|view| view.dot(normal));
        let [diffuse, ground] = lit.each_ref().map(|lit| {
            // One after the other, so that equal skies have equal sums.
            lit.iter().fold(vec![0.0; direct.len()], |mut sum, (pair, radiance)| {
                let weight = weight(pair, normal);
                if weight > 0.0 {
                    sum.iter_mut().zip(radiance).for_each(|(sum, value)| *sum += value * weight);
                }
                sum
            })
        });
        let global = direct.iter().zip(&diffuse).zip(&ground).map(|((a, b), c)| a + b + c).collect();
        Irradiance { direct, diffuse, ground, global }
    };
    normals.iter().map(of_surface).collect()
}

/// Pairs of directions that any of some surfaces faces, each with its radiance.
fn lit_pairs(pairs: Vec<Pair>, normals: &[DVec3], spectra: &Spectra) -> Vec<(Pair, Vec<f64>)> {
    let facing = |pair: &Pair| normals.iter().any(|&normal| weight(pair, normal) > 0.0);
    let facing: Vec<Pair> = pairs.into_iter().filter(facing).collect();
    facing.into_par_iter().map(|pair| (pair, spectra.radiance(pair.0.as_vec3()))).collect()
}

/// What a pair of directions counts on a surface (sr).
fn weight(&(view, mirrored, solid_angle): &Pair, normal: DVec3) -> f64 {
    let cosine = |view: DVec3| view.dot(normal).max(0.0);
    0.5 * solid_angle * (cosine(view) + cosine(mirrored))
}

/// The sun's beam at a wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct BeamSample {
    /// Wavelength (nm).
    pub wavelength_nm: f64,
    /// Transmittance from the disc's centre, without the spreading of the beam by refraction; 0 for a centre below the
    /// horizon.
    pub transmittance: f64,
    /// Irradiance of a surface that faces the sun (W·m⁻²·nm⁻¹), by the visible part of the disc with its apparent size.
    pub irradiance: f64,
}

/// The longest part (nm) into which a mean is divided: the finest bins of the sun.
const LONGEST_PART: f64 = 0.5;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn sky(sun: f64) -> Sky {
        let mut scene = Scene::default();
        (scene.sun.elevation, scene.sun.azimuth) = (sun, 120.0);
        let scene = scene.validated().unwrap();
        Sky::new(&scene).unwrap()
    }

    #[test]
    fn a_surface_gets_what_a_fine_grid_of_directions_sends() {
        let wavelengths = [400.0, 550.0, 700.0];
        for sun in [50.0, 4.0] {
            let sky = sky(sun);
            let spectra = Spectra::new(sky.plan(), &wavelengths, Method::Fit).unwrap();
            for surface in
                [Surface::default(), Surface { tilt: 90.0, azimuth: 100.0 }, Surface { tilt: 40.0, azimuth: 250.0 }]
            {
                let normal = surface.normal().unwrap();
                let fallen = sky.irradiance(&[surface], &wavelengths).unwrap().remove(0);
                // Cells of a degree.
                let cell = |elevation: u32, azimuth: u32| {
                    let (e, a) = (f64::from(elevation) - 89.5, f64::from(azimuth) + 0.5);
                    let view = direction(e, a);
                    let weight = e.to_radians().cos() * 1f64.to_radians().powi(2) * view.dot(normal).max(0.0);
                    if weight == 0.0 {
                        vec![0.0; 3]
                    } else {
                        spectra.radiance(view.as_vec3()).iter().map(|l| l * weight).collect()
                    }
                };
                let sum = |rows: std::ops::Range<u32>| -> Vec<f64> {
                    let cells = rows.into_par_iter().flat_map_iter(|e| (0..360).map(move |a| (e, a)));
                    let add = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(b).map(|(a, b)| a + b).collect();
                    cells.map(|(e, a)| cell(e, a)).reduce(|| vec![0.0; 3], add)
                };
                let expected = sum(90..180).into_iter().zip(sum(0..90)).zip(fallen.diffuse.iter().zip(&fallen.ground));
                for ((above, below), (diffuse, ground)) in expected {
                    let error = ((above - diffuse).abs() + (below - ground).abs()) / (above + below);
                    println!("sun at {sun}, {surface:?}: {error:.1e}");
                    // The cosine ends in an edge at the surface's plane, and the grid is of a degree around the glow of
                    // the sun.
                    assert!(error < 5e-3, "sun at {sun}, {surface:?}: {error}");
                }
            }
        }
    }

    #[test]
    fn the_sun_lights_a_surface_by_its_cosine_and_none_that_turns_its_back() {
        let (sky, wavelengths) = (sky(30.0), [500.0]);
        let direct = |tilt, azimuth| sky.irradiance(&[Surface { tilt, azimuth }], &wavelengths).unwrap()[0].direct[0];
        // Air has lifted it.
        let seen = sky.scene().apparent_elevation().unwrap();
        let facing = direct(90.0 - seen, 120.0);
        // The disc is half a degree wide.
        assert!((direct(0.0, 0.0) / facing - seen.to_radians().sin()).abs() < 1e-4);
        assert_eq!(direct(90.0, 300.0), 0.0);
        let above = sky.scene().optics().solar_irradiance(500.0);
        assert!((facing / above / sky.transmittance(&wavelengths).unwrap()[0] - 1.0).abs() < 5e-5);
    }

    #[test]
    fn a_surface_gets_the_same_beside_others() {
        let (sky, wavelengths) = (sky(20.0), [450.0, 600.0]);
        let surfaces = [(0.0, 0.0), (180.0, 0.0), (70.0, 120.0)].map(|(tilt, azimuth)| Surface { tilt, azimuth });
        let together = sky.irradiance(&surfaces, &wavelengths).unwrap();
        assert_eq!(together, surfaces.map(|surface| sky.irradiance(&[surface], &wavelengths).unwrap().remove(0)));
        assert!(sky.irradiance(&[], &wavelengths).unwrap().is_empty());
    }

    #[test]
    fn a_surface_or_a_wavelength_that_is_none_is_refused() {
        let sky = sky(30.0);
        let refused = |surface: Surface, wavelength| sky.irradiance(&[surface], &[wavelength]).unwrap_err().to_string();
        assert_eq!(
            refused(Surface { tilt: 181.0, azimuth: 0.0 }, 500.0),
            "surface_tilt is 181; it must lie between 0 and 180 degrees"
        );
        assert!(refused(Surface::default(), 270.0).starts_with("wavelengths holds 270"));
        assert!(sky.transmittance(&[f64::NAN]).is_err());
    }
}
