//! The air and the ground at the wavelengths of a light field.

use sorairo_shared::glam::Vec4;
use sorairo_shared::medium::bands::{Bands, Coefficients};
use sorairo_shared::value::Lanes;

/// What scatters, absorbs and reflects at some wavelengths.
pub struct Wavelengths<const N: usize> {
    /// The air's optical properties.
    pub air: Coefficients<Lanes<N>>,
    /// Albedo of the ground.
    pub albedo: Lanes<N>,
}

impl<const N: usize> Wavelengths<N> {
    /// Up to so many, from groups of four bands; the last group fills up.
    pub fn new(bands: &[Bands]) -> Self {
        let lanes = |value: &dyn Fn(usize) -> Vec4| {
            Lanes(std::array::from_fn(|i| value((i / 4).min(bands.len() - 1)).to_array()[i % 4]))
        };
        let air = Coefficients {
            air_scattering: lanes(&|group| bands[group].air_scattering),
            aerosol_scattering: lanes(&|group| bands[group].aerosol_scattering),
            aerosol_extinction: lanes(&|group| bands[group].aerosol_extinction),
            ozone_absorption: lanes(&|group| bands[group].ozone_absorption),
            pair_absorption: lanes(&|group| bands[group].pair_absorption),
            water_absorption: lanes(&|group| bands[group].water_absorption),
        };
        Self { air, albedo: lanes(&|group| bands[group].albedo) }
    }
}
