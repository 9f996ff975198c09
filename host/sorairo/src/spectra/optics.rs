//! Optical properties of an atmosphere and its sun at any wavelength.

use sorairo_shared::glam::Vec4;
use sorairo_shared::medium::bands::{self, Bands};

use super::choice::{AirSpectrum, GroundAlbedo, OrTable, OzoneCrossSection, SunSpectrum};
use super::mean::Window;
use super::observer;
use super::table_file::TableFile;
use crate::medium::aerosol::{Mixture, abscissa};
use crate::medium::gases::{Depths, SkyGases};

const METRES_PER_KM: f64 = 1000.0;

/// What an atmosphere and its sun are made of, and hence their coefficients at any wavelength.
#[derive(Clone, Debug)]
pub struct Optics {
    /// Radius of the ground (km).
    pub ground_radius: f64,
    /// Radius of the top of the atmosphere (km).
    pub top_radius: f64,
    /// Scattering coefficient of air at the ground and 1 µm (km⁻¹).
    pub air_scattering: f64,
    /// How it depends on the wavelength.
    pub air_spectrum: AirSpectrum,
    /// Scale height of air (km).
    pub air_scale_height: f64,
    /// Aerosol.
    pub aerosol: Mixture,
    /// Molecules of ozone per m³ where it is densest.
    pub ozone_peak_density: f64,
    /// The part of the light scattered by aerosol that goes straight ahead, and counts as not scattered where bands are
    /// integrated.
    pub forward_peak: f64,
    /// Absorption cross-section of ozone.
    pub cross_section: OzoneCrossSection,
    /// Temperature of ozone (K).
    pub ozone_temperature: f64,
    /// Vertical column density of ozone (km).
    pub ozone_column: f64,
    /// The other gases of a measured profile.
    pub gases: Option<SkyGases>,
    /// Albedo of the ground.
    pub ground_albedo: GroundAlbedo,
    /// Spectrum of the sun.
    pub sun: SunSpectrum,
    /// Distance of the sun (astronomical units).
    pub sun_distance: f64,
}

/// Coefficients at one wavelength (km⁻¹, at the ground, ozone at its peak).
pub type Coefficients = bands::Coefficients<f64>;

impl Optics {
    /// The coefficients at a wavelength (nm).
    pub fn at(&self, wavelength: f64) -> Coefficients {
        let without = self.without_gases(wavelength);
        let Some(gases) = &self.gases else { return without };
        let Depths { pairs, water, nitrogen_dioxide } = gases.at(wavelength);
        Coefficients {
            // Nitrogen dioxide lies where ozone does; without ozone its layer may be anywhere, and no kernel asks for
            // it.
            ozone_absorption: if self.ozone_peak_density > 0.0 {
                without.ozone_absorption + nitrogen_dioxide / self.ozone_column
            } else {
                0.0
            },
            pair_absorption: pairs,
            water_absorption: water,
            ..without
        }
    }

    /// Those of air, aerosol and ozone alone: a beam has gases of its own, line by line.
    pub fn without_gases(&self, wavelength: f64) -> Coefficients {
        let micrometres = wavelength / 1000.0;
        let [aerosol_scattering, aerosol_extinction] = self.aerosol.coefficients(wavelength);
        let ozone = self.ozone_peak_density * self.cross_section.at(wavelength, self.ozone_temperature) * METRES_PER_KM;
        Coefficients {
            air_scattering: self.air_scattering * self.air_spectrum.relative(micrometres),
            aerosol_scattering,
            aerosol_extinction,
            ozone_absorption: ozone,
            pair_absorption: 0.0,
            water_absorption: 0.0,
        }
    }

    /// The same with tables of means over what a value stands for: a node of the observer's sum for colours, and the
    /// bands through which they are fitted; a band of a picture in bands. At a wavelength itself stand the values of a
    /// table in [`Optics`] as they are. See [`super::mean`].
    pub fn over(&self, window: Window) -> Self {
        Self {
            aerosol: self.aerosol.with_albedos(|albedo| albedo.over(window, &self.sun)),
            cross_section: self.cross_section.over(window, &self.sun),
            ground_albedo: self.ground_albedo.over(window, &self.sun),
            sun: self.sun.over(window),
            gases: self.gases.as_ref().map(|gases| gases.over(window)),
            ..self.clone()
        }
    }

    /// Whether what scatters, absorbs and reflects has no such means beside its values.
    pub fn is_on_steps(&self) -> bool {
        let files = [self.cross_section.file(), self.ground_albedo.file()];
        let albedos = self.aerosol.albedo_spectra().filter_map(OrTable::file);
        self.gases.is_none() && files.into_iter().flatten().chain(albedos).all(TableFile::is_on_steps)
    }

    /// Solar irradiance at the top of the atmosphere (W·m⁻²·nm⁻¹; for the flat sun 1 at 1 au).
    pub fn solar_irradiance(&self, wavelength: f64) -> f64 {
        self.sun.at(wavelength) / self.sun_distance.powi(2)
    }

    /// Optical depth, at the observer's shortest wavelength and on a level ray, of what the exponential profiles hold
    /// above the top of the atmosphere.
    pub fn depth_above_top(&self) -> f64 {
        self.depth_above(self.top_radius)
    }

    /// Optical depth, at the observer's shortest wavelength, of the exponential profiles on a level ray from the
    /// ground.
    pub fn level_depth(&self) -> f64 {
        self.depth_above(self.ground_radius)
    }

    /// Optical depth of the exponential profiles on a level ray from a distance from the planet's centre (km).
    fn depth_above(&self, radius: f64) -> f64 {
        let coefficients = self.at(observer::START);
        let level = |scale_height: f64, extinction: f64| {
            let column_density = (std::f64::consts::FRAC_PI_2 * radius * scale_height).sqrt();
            extinction * column_density * (-(radius - self.ground_radius) / scale_height).exp()
        };
        level(self.air_scale_height, coefficients.air_scattering)
            + level(self.aerosol.lane.scale_height, coefficients.aerosol_extinction)
    }

    /// The coefficients at four wavelengths (nm), as the kernels take them: extinction by aerosol is without the
    /// forward peak, scattering whole. Light that was scattered once then has the whole phase function, and what the
    /// peak scatters on the way is not lost (Nakajima and Tanaka 1988, <https://doi.org/10.1016/0022-4073(88)90031-3>,
    /// Eq. 5).
    pub fn bands(&self, wavelengths: [f64; 4]) -> Bands {
        let at = wavelengths.map(|wavelength| {
            let whole = self.at(wavelength);
            let aerosol_extinction = whole.aerosol_extinction - self.forward_peak * whole.aerosol_scattering;
            Coefficients { aerosol_extinction, ..whole }
        });
        let solar_irradiance = vec4(wavelengths.map(|wavelength| self.solar_irradiance(wavelength)));
        Bands {
            air_scattering: vec4(at.map(|c| c.air_scattering)),
            aerosol_scattering: vec4(at.map(|c| c.aerosol_scattering)),
            aerosol_extinction: vec4(at.map(|c| c.aerosol_extinction)),
            ozone_absorption: vec4(at.map(|c| c.ozone_absorption)),
            pair_absorption: vec4(at.map(|c| c.pair_absorption)),
            water_absorption: vec4(at.map(|c| c.water_absorption)),
            solar_irradiance,
            fit_irradiance: solar_irradiance,
            albedo: vec4(wavelengths.map(|wavelength| self.ground_albedo.at(wavelength))),
            abscissae: vec4(wavelengths.map(abscissa)),
        }
    }
}

/// Four values as the kernels take them.
pub(crate) fn vec4(values: [f64; 4]) -> Vec4 {
    Vec4::from_array(values.map(|value| value as f32))
}

#[cfg(test)]
mod tests {
    use super::super::observer::ColourObserver;
    use super::*;
    use crate::scene::{Preset, Scene};

    #[test]
    fn the_sum_over_the_observer_has_the_sun_as_a_sum_over_tenths_of_a_nanometre_has_it() {
        let (points, means) =
            (Scene::preset(Preset::Standard).optics(), Scene::preset(Preset::Standard).optics().over(Window::STEP));
        for observer in [ColourObserver::Cie1931, ColourObserver::Cie2015] {
            let weights = |nm: f64| observer::weights(observer, nm) / observer::STEP * 0.1;
            let tenths = (0..4000).map(|i| observer::START + 0.1 * (f64::from(i) + 0.5));
            let truth: sorairo_shared::glam::DVec3 = tenths.map(|nm| weights(nm) * points.solar_irradiance(nm)).sum();
            let error = |optics: &Optics| {
                let sum = observer::xyz(observer, |nm| optics.solar_irradiance(nm));
                ((sum - truth) / truth).abs().max_element()
            };
            println!("{observer:?}: {:.1e} of points, {:.1e} of means", error(&points), error(&means));
            // The observer's functions are straight between the nodes to some 1e-5; where CIE 2015 begins a step is
            // missed.
            assert!(error(&means) < 2e-4, "{observer:?}: {}", error(&means));
            assert!(error(&points) > 3e-3, "negative control");
        }
    }
}
