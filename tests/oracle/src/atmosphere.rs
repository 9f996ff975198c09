//! A sky as people describe it, and from that its coefficients at a wavelength.

use crate::medium::{Coefficients, Medium};
use crate::published::{DOBSON_UNIT, air_cross_section, air_king_factor, depolarisation};
use crate::spectrum::Spectrum;

/// How the scattering of air depends on the wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AirLaw {
    /// As λ⁻⁴, without depolarisation (Rayleigh 1871, *On the scattering of light by small particles*).
    FourthPower,
    /// By the refractive index of air (Peck and Reeder 1972) and its King factor (Bates 1984).
    Measured,
}

/// What a sky is made of, in the numbers in which that is published.
#[derive(Clone, Debug, PartialEq)]
pub struct Atmosphere {
    /// Radius of the ground, km.
    pub ground_radius_km: f64,
    /// Radius at which the atmosphere ends, km.
    pub top_radius_km: f64,
    /// Lambertian albedo of the ground.
    pub ground_albedo: Spectrum,
    /// Scattering coefficient of air at the ground and a wavelength of 1 µm, km⁻¹.
    pub air_scattering_at_1_um: f64,
    /// How that depends on the wavelength, and how air depolarises.
    pub air_law: AirLaw,
    /// Scale height of the air's density, km.
    pub air_scale_height_km: f64,
    /// Optical depth of aerosol at a wavelength of 1 µm: extinction at the ground times the scale height.
    pub aerosol_optical_depth_at_1_um: f64,
    /// Ångström exponent of the aerosol's extinction.
    pub aerosol_angstrom_exponent: f64,
    /// The aerosol's extinction relative to that at 1 µm, in place of the exponent.
    pub aerosol_spectrum: Option<Spectrum>,
    /// Scale height of the aerosol's density, km.
    pub aerosol_scale_height_km: f64,
    /// The part of the aerosol's extinction that is scattering.
    pub aerosol_albedo: Spectrum,
    /// Asymmetry g of the aerosol's phase function, in (-1, 1).
    pub aerosol_asymmetry: f64,
    /// Vertical column of ozone, Dobson units.
    pub ozone_column_du: f64,
    /// Altitude under which there is no ozone, km.
    pub ozone_bottom_km: f64,
    /// Altitude at which ozone is densest, km.
    pub ozone_peak_km: f64,
    /// Altitude above which there is no ozone, km.
    pub ozone_top_km: f64,
    /// Absorption cross-section of ozone, m².
    pub ozone_cross_section_m2: Spectrum,
}

impl Atmosphere {
    /// Its shape, the same at every wavelength.
    pub fn medium(&self) -> Medium {
        Medium {
            ground_radius_km: self.ground_radius_km,
            top_radius_km: self.top_radius_km,
            air_scale_height_km: self.air_scale_height_km,
            aerosol_scale_height_km: self.aerosol_scale_height_km,
            aerosol_asymmetry: self.aerosol_asymmetry,
            ozone_bottom_km: self.ozone_bottom_km,
            ozone_peak_km: self.ozone_peak_km,
            ozone_top_km: self.ozone_top_km,
            levels: &[],
        }
    }

    /// What it does to light of a wavelength (nm).
    ///
    /// * Air scatters by its law.
    /// * The extinction of aerosol goes as λ^−α (Ångström 1929, *On the atmospheric transmission of sun radiation and
    ///   on dust in the air*).
    /// * Absorption is number density times cross-section. A tent of a base b holds a column N with N = n b / 2, so
    ///   that its peak n is 2 N / b.
    pub fn coefficients(&self, wavelength_nm: f64) -> Coefficients {
        let to_1_um = 1000.0 / wavelength_nm;
        let extinction_at_1_um = self.aerosol_optical_depth_at_1_um / self.aerosol_scale_height_km;
        let aerosol_relative = match &self.aerosol_spectrum {
            Some(measured) => measured.at(wavelength_nm),
            None => to_1_um.powf(self.aerosol_angstrom_exponent),
        };
        let aerosol_extinction = extinction_at_1_um * aerosol_relative;
        let (relative, air_depolarisation) = match self.air_law {
            AirLaw::FourthPower => (to_1_um.powi(4), 0.0),
            AirLaw::Measured => (
                air_cross_section(wavelength_nm) / air_cross_section(1000.0),
                depolarisation(air_king_factor(wavelength_nm)),
            ),
        };
        Coefficients {
            air_scattering: self.air_scattering_at_1_um * relative,
            air_depolarisation,
            aerosol_extinction,
            aerosol_scattering: self.aerosol_albedo.at(wavelength_nm) * aerosol_extinction,
            ozone_absorption: self.ozone_molecules_per_m2_km() * self.ozone_cross_section_m2.at(wavelength_nm),
            gas_absorption: [0.0; 2],
            ground_albedo: self.ground_albedo.at(wavelength_nm),
            aerosol_phase: None,
        }
    }

    /// Number density where ozone is densest, molecules per m² and km of height. Without a column the tent may be a
    /// line.
    fn ozone_molecules_per_m2_km(&self) -> f64 {
        if self.ozone_column_du == 0.0 {
            return 0.0;
        }
        2.0 * self.ozone_column_du * DOBSON_UNIT / (self.ozone_top_km - self.ozone_bottom_km)
    }
}
