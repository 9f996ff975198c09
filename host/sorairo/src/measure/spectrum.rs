//! Spectra and appearance of the sky in directions.

use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sorairo_shared::glam::{DVec3, Vec3};
use sorairo_shared::processor::lanes::BLOCK;
use sorairo_shared::variant::ABOVE_TOP;
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

use crate::error::{Error, Result, check_range, check_wavelengths};
use crate::measure::direction::Direction;
use crate::plan::integral::RayIntegral;
use crate::plan::rays::quadrature::gauss_legendre;
use crate::plan::shortwave::{Lines, Shortwave};
use crate::plan::strengths::without_lines;
use crate::plan::upload::bands;
use crate::plan::{Sky, SkyPlan, SpectralPlan, optics_of};
use crate::spectra::optics::Optics;
use crate::spectra::{colour_temperature, observer};

/// Samples per piece of the dense spectrum: enough for 1e-5 in twilight, where the edges of the ozone tent slow the
/// convergence.
pub const DENSE_STEPS: u32 = 512;

/// The finest and the coarsest resolution of means (nm).
pub(crate) const RESOLUTIONS: (f64, f64) = (0.1, 200.0);

/// Radiance at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Sample {
    /// Wavelength (nm).
    pub wavelength_nm: f64,
    /// By the fit through the bands, at least 0 (W·m⁻²·sr⁻¹·nm⁻¹).
    pub radiance: f64,
    /// By the integral at this wavelength, with high accuracy (W·m⁻²·sr⁻¹·nm⁻¹).
    pub dense: f64,
}

/// Luminance and colour in a direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Appearance {
    /// Luminance (cd·m⁻²).
    pub luminance_cd_m2: f64,
    /// Chromaticity for the observer; `None` without light.
    pub x: Option<f64>,
    /// The same.
    pub y: Option<f64>,
    /// Correlated colour temperature (K); `None` for a colour without one.
    pub cct_k: Option<f64>,
}

impl Sky {
    /// The radiance by the fit (W·m⁻²·sr⁻¹·nm⁻¹, at least 0) in each direction, at each wavelength (nm); on all cores.
    ///
    /// # Errors
    ///
    /// Those of [`Sky::spectra`] and [`Spectra::in_directions`].
    pub fn radiance(&self, directions: &[Direction], wavelengths: &[f64]) -> Result<Vec<Vec<f64>>> {
        self.spectra(wavelengths, Method::Fit)?.in_directions(directions)
    }

    /// Radiance at wavelengths (nm), for any direction: by the fit through as many bands as they need, or by an
    /// integral at each wavelength.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] for a wavelength at which the scene has no data; see
    /// [`Scene::known_wavelengths_of_skies`](crate::Scene::known_wavelengths_of_skies).
    pub fn spectra(&self, wavelengths: &[f64], method: Method) -> Result<Spectra> {
        Spectra::new(self.plan(), wavelengths, method)
    }

    /// The spectrum in each direction by both methods, at wavelengths (nm), or in means about each over a resolution of
    /// 0.1 to 200 nm. Beyond visible light, and in means, both values of a sample are equal: radiance through the lines
    /// of gases.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] for a direction or a resolution, [`Error::NotAllowed`] for a wavelength out of range.
    pub fn spectrum(
        &self,
        directions: &[Direction],
        wavelengths: &[f64],
        resolution: Option<f64>,
    ) -> Result<Vec<Vec<Sample>>> {
        // Before any work.
        directions.iter().try_for_each(|direction| direction.vector().map(|_| ()))?;
        if let Some(width) = resolution {
            check_range("resolution", width, RESOLUTIONS, "nm")?;
        }
        let (fitted, dense) = match Spectra::beyond_visible_light(self.plan(), wavelengths, resolution)? {
            Some(beyond) => {
                let found = beyond.in_directions(directions)?;
                (found.clone(), found)
            }
            None => {
                let of = |method| Spectra::new(self.plan(), wavelengths, method)?.in_directions(directions);
                (of(Method::Fit)?, of(Method::Dense)?)
            }
        };
        let samples = |(fitted, dense): (Vec<f64>, Vec<f64>)| {
            let sample =
                |((&wavelength_nm, radiance), dense): ((&f64, f64), f64)| Sample { wavelength_nm, radiance, dense };
            wavelengths.iter().zip(fitted).zip(dense).map(sample).collect()
        };
        Ok(fitted.into_iter().zip(dense).map(samples).collect())
    }

    /// X, Y and Z for the sky's observer in each direction, from the fitted spectrum between 380 and 780 nm in means
    /// over 5 nm (W·m⁻²·sr⁻¹). The luminance (cd·m⁻²) is [`LUMENS_PER_WATT`](crate::observer::LUMENS_PER_WATT) times Y.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] for a direction.
    pub fn xyz(&self, directions: &[Direction]) -> Result<Vec<[f64; 3]>> {
        let xyz = |spectrum: &Vec<f64>| observer::xyz_of_samples(self.plan().observer, spectrum).to_array();
        Ok(Spectra::over_steps(self.plan()).in_directions(directions)?.iter().map(xyz).collect())
    }

    /// Luminance, chromaticity and colour temperature in each direction, from [`Sky::xyz`].
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] for a direction.
    pub fn appearance(&self, directions: &[Direction]) -> Result<Vec<Appearance>> {
        let appearance = |colour: [f64; 3]| {
            let colour = DVec3::from_array(colour);
            let part = |value: f64| (colour.element_sum() > 0.0).then(|| value / colour.element_sum());
            Appearance {
                luminance_cd_m2: observer::LUMENS_PER_WATT * colour.y,
                x: part(colour.x),
                y: part(colour.y),
                cct_k: colour_temperature::correlated(self.plan().observer, colour),
            }
        };
        Ok(self.xyz(directions)?.into_iter().map(appearance).collect())
    }
}

/// The method for the radiance at a wavelength.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum Method {
    /// By the fit through the bands.
    #[default]
    Fit,
    /// By an integral at each wavelength, through the lines of gases.
    Dense,
}

/// Spectra of a sky at fixed wavelengths, in any direction. Data common to all directions is prepared once.
pub struct Spectra {
    by: By,
}

/// What gives the radiance.
enum By {
    Fit(Arc<SpectralPlan>),
    /// What lines leave of the light of each wavelength; none in air without gases.
    Dense(Box<DenseSpectrum>, Option<Box<Lines>>),
    /// Beyond visible light, through the lines of gases; none of a night.
    Shortwave(Option<Box<Shortwave>>, usize),
}

impl Spectra {
    /// See [`Sky::spectra`].
    pub(crate) fn new(sky: &SkyPlan, wavelengths: &[f64], method: Method) -> Result<Self> {
        if let Some(beyond) = Self::beyond_visible_light(sky, wavelengths, None)? {
            return Ok(beyond);
        }
        let by = match method {
            Method::Fit => By::Fit(Arc::new(SpectralPlan::new(sky, wavelengths))),
            Method::Dense => {
                let lines = if sky.is_night { None } else { Lines::new(sky, wavelengths).map(Box::new) };
                let dense = match lines {
                    Some(_) => DenseSpectrum::without_lines(sky, wavelengths),
                    None => DenseSpectrum::new(sky, wavelengths),
                };
                By::Dense(Box::new(dense), lines)
            }
        };
        Ok(Self { by })
    }

    /// Spectra of a sky that is asked for beyond visible light, or in means over a resolution (nm) about each
    /// wavelength (nm): all of them through the lines of its gases.
    fn beyond_visible_light(sky: &SkyPlan, wavelengths: &[f64], resolution: Option<f64>) -> Result<Option<Self>> {
        let (low, high) = sky.scene.known_wavelengths();
        if resolution.is_none() && wavelengths.iter().all(|nm| (low..=high).contains(nm)) {
            return Ok(None);
        }
        check_wavelengths_of_skies(sky, wavelengths)?;
        match Self::shortwave(sky, wavelengths, resolution) {
            None => {
                Err(Error::not_allowed("resolution", "is of lines of gases, which need a measured atmosphere.profile"))
            }
            spectra => Ok(spectra),
        }
    }

    /// Spectra for sums over the whole range; see [`Shortwave::for_sums`]. None in air without gases.
    pub(crate) fn for_sums(sky: &SkyPlan, wavelengths: &[f64]) -> Option<Self> {
        let shortwave = if sky.is_night { None } else { Some(Box::new(Shortwave::for_sums(sky, wavelengths)?)) };
        Some(Self { by: By::Shortwave(shortwave, wavelengths.len()) })
    }

    /// Spectra through the lines of gases; see [`Shortwave`]. None in air without gases.
    fn shortwave(sky: &SkyPlan, wavelengths: &[f64], resolution: Option<f64>) -> Option<Self> {
        let of = || Shortwave::new(sky, wavelengths, resolution).map(Box::new);
        let shortwave = if sky.is_night { None } else { Some(of()?) };
        Some(Self { by: By::Shortwave(shortwave, wavelengths.len()) })
    }

    /// Spectra at the nodes of the observer, for sums over them; see [`SpectralPlan::over_steps`].
    pub(crate) fn over_steps(sky: &SkyPlan) -> Self {
        Self { by: By::Fit(Arc::new(SpectralPlan::over_steps(sky))) }
    }

    /// Spectra that are planned.
    #[cfg(feature = "files")]
    pub(crate) fn planned(spectral: Arc<SpectralPlan>) -> Self {
        Self { by: By::Fit(spectral) }
    }

    /// The wavelengths (nm) at which rays are integrated, unordered.
    pub fn bands(&self) -> &[f64] {
        match &self.by {
            By::Fit(planned) => &planned.integral.wavelengths,
            By::Dense(dense, _) => &dense.integral.wavelengths,
            By::Shortwave(shortwave, _) => shortwave.as_ref().map_or(&[], |shortwave| shortwave.bands()),
        }
    }

    /// The radiance at each wavelength (W·m⁻²·sr⁻¹·nm⁻¹, at least 0) in each direction; on all cores.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] for a direction.
    pub fn in_directions(&self, directions: &[Direction]) -> Result<Vec<Vec<f64>>> {
        let views: Vec<Vec3> = directions.iter().map(Direction::vector).collect::<Result<_>>()?;
        let spectra = |views: &[Vec3]| {
            let radiance = self.radiance_of_directions(views);
            let count = radiance.len() / views.len();
            (0..views.len()).map(move |i| radiance[i * count..][..count].to_vec())
        };
        // Bands alone are integrated a block of directions at a time.
        let at_once = if matches!(self.by, By::Fit(_)) { BLOCK } else { 1 };
        Ok(views.par_chunks(at_once).flat_map_iter(spectra).collect())
    }

    /// Radiance at each wavelength in a direction.
    pub(crate) fn radiance(&self, view: Vec3) -> Vec<f64> {
        self.radiance_of_directions(&[view])
    }

    /// The same in many directions, one after the other.
    fn radiance_of_directions(&self, views: &[Vec3]) -> Vec<f64> {
        let mut radiance = match &self.by {
            By::Fit(planned) => planned.radiance_of_directions(views),
            By::Dense(dense, None) => views.iter().flat_map(|&view| dense.radiance(view)).collect(),
            By::Dense(dense, Some(lines)) => {
                let of_view = |&view: &Vec3| {
                    let both = dense.radiance(view).into_iter().zip(lines.left(view));
                    both.map(|(radiance, left)| radiance * left).collect::<Vec<_>>()
                };
                views.iter().flat_map(of_view).collect()
            }
            By::Shortwave(Some(shortwave), _) => views.iter().flat_map(|&view| shortwave.radiance(view)).collect(),
            By::Shortwave(None, count) => vec![0.0; views.len() * count],
        };
        // A polynomial can pass below zero between its bands; light cannot.
        radiance.iter_mut().for_each(|value| *value = value.max(0.0));
        radiance
    }
}

/// Checks that a sky's light is known at wavelengths (nm), in visible light or beyond it.
fn check_wavelengths_of_skies(sky: &SkyPlan, wavelengths: &[f64]) -> Result<()> {
    let (visible, all) = (sky.scene.known_wavelengths(), sky.scene.known_wavelengths_of_skies());
    check_wavelengths((visible.0.min(all.0), visible.1.max(all.1)), wavelengths)
}

/// The integral of a sky at wavelengths (nm), with [`DENSE_STEPS`] samples.
pub(crate) fn integral_at(sky: &SkyPlan, optics: &Optics, wavelengths: &[f64]) -> RayIntegral {
    RayIntegral {
        wavelengths: wavelengths.to_vec(),
        optics: optics.clone(),
        bands: bands(optics, wavelengths),
        quadrature: gauss_legendre(DENSE_STEPS),
        variant: sky.base.variant | ABOVE_TOP,
        ..sky.base.clone()
    }
}

/// The spectrum integrated at every one of its wavelengths with [`DENSE_STEPS`] samples: the reference of every fit.
pub struct DenseSpectrum {
    integral: RayIntegral,
    irradiance: Vec<f64>,
    /// What lines of gases leave, where they do not stand in the integral by one coefficient.
    lines: Option<Box<Lines>>,
}

impl DenseSpectrum {
    /// Prepares the spectrum at wavelengths in nm, at which tables say what holds.
    pub fn new(sky: &SkyPlan, wavelengths: &[f64]) -> Self {
        Self::of(integral_at(sky, &optics_of(&sky.scene), wavelengths))
    }

    /// The same without the lines of gases.
    fn without_lines(sky: &SkyPlan, wavelengths: &[f64]) -> Self {
        Self::smooth(sky, &optics_of(&sky.scene), wavelengths)
    }

    fn smooth(sky: &SkyPlan, optics: &Optics, wavelengths: &[f64]) -> Self {
        let bands = without_lines(optics, wavelengths);
        Self::of(RayIntegral { bands, ..integral_at(sky, optics, wavelengths) })
    }

    /// The spectrum at the nodes of the observer, through the lines of gases, for sums over them; see
    /// [`SpectralPlan::over_steps`].
    pub fn over_steps(sky: &SkyPlan) -> Self {
        let lines = Lines::over_steps(sky).map(Box::new);
        Self { lines, ..Self::smooth(sky, &sky.base.optics, &observer::wavelengths()) }
    }

    fn of(integral: RayIntegral) -> Self {
        let optics = &integral.optics;
        let irradiance = integral.wavelengths.iter().map(|&wavelength| optics.solar_irradiance(wavelength)).collect();
        Self { irradiance, integral: integral.with_spectral_light(), lines: None }
    }

    /// Radiance at each wavelength in a direction (W·m⁻²·sr⁻¹·nm⁻¹).
    pub fn radiance(&self, view: Vec3) -> Vec<f64> {
        let mut radiance = self.integral.transfer(view);
        radiance.iter_mut().zip(&self.irradiance).for_each(|(radiance, irradiance)| *radiance *= irradiance);
        if let Some(lines) = &self.lines {
            radiance.iter_mut().zip(lines.left(view)).for_each(|(radiance, left)| *radiance *= left);
        }
        radiance
    }
}
