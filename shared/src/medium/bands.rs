//! Optical properties at the bands: what turns densities and column densities into coefficients and optical depths.

use bytemuck::{Pod, Zeroable};

use crate::glam::{Vec2, Vec4};
use crate::medium::atmosphere::ColumnDensities;
use crate::value::Value;

/// Optical properties of the atmosphere and the sun at four bands. The layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Bands {
    /// Scattering coefficient of air at the ground (km⁻¹).
    pub air_scattering: Vec4,
    /// Scattering coefficient of aerosol at the ground (km⁻¹).
    pub aerosol_scattering: Vec4,
    /// Extinction coefficient of aerosol at the ground (km⁻¹).
    pub aerosol_extinction: Vec4,
    /// Absorption coefficient of ozone at its peak (km⁻¹).
    pub ozone_absorption: Vec4,
    /// Optical depth of what absorbs as pairs of oxygen lie, from the ground to the zenith.
    pub pair_absorption: Vec4,
    /// That of what absorbs as water vapour lies.
    pub water_absorption: Vec4,
    /// Solar irradiance at the top of the atmosphere (W·m⁻²·nm⁻¹).
    pub solar_irradiance: Vec4,
    /// What the fit of an explicit solve multiplies the transfer with: the solar irradiance, or 1.
    pub fit_irradiance: Vec4,
    /// Albedo of the ground.
    pub albedo: Vec4,
    /// Abscissae of the aerosol's phase function; see [`crate::medium::phase::tabulated_phase`].
    pub abscissae: Vec4,
}

impl Bands {
    /// The coefficients of the atmosphere alone.
    #[inline(always)]
    pub fn coefficients(&self) -> Coefficients<Vec4> {
        Coefficients {
            air_scattering: self.air_scattering,
            aerosol_scattering: self.aerosol_scattering,
            aerosol_extinction: self.aerosol_extinction,
            ozone_absorption: self.ozone_absorption,
            pair_absorption: self.pair_absorption,
            water_absorption: self.water_absorption,
        }
    }
}

/// Coefficients of the atmosphere (km⁻¹): at the ground, those of ozone at its peak; of gases the optical depth from
/// the ground to the zenith.
#[derive(Clone, Copy, Debug)]
pub struct Coefficients<V> {
    /// Scattering by air.
    pub air_scattering: V,
    /// Scattering by aerosol.
    pub aerosol_scattering: V,
    /// Extinction by aerosol.
    pub aerosol_extinction: V,
    /// Absorption by ozone.
    pub ozone_absorption: V,
    /// By what lies as pairs of oxygen do.
    pub pair_absorption: V,
    /// By what lies as water vapour does.
    pub water_absorption: V,
}

/// One value for each constituent that scatters.
#[derive(Clone, Copy, Debug)]
pub struct ByScatterer<V> {
    /// Air.
    pub air: V,
    /// Aerosol.
    pub aerosol: V,
}

impl<V: Value> ByScatterer<V> {
    /// Nothing.
    pub const ZERO: Self = Self { air: V::ZERO, aerosol: V::ZERO };
}

impl<V: Value> Coefficients<V> {
    /// Optical depth of column densities (Eq. 2).
    #[inline(always)]
    pub fn optical_depth(&self, along: ColumnDensities) -> V {
        let mut depth = self.air_scattering.scaled(along.air);
        depth.add_scaled(&self.aerosol_extinction, along.aerosol);
        depth.add_scaled(&self.ozone_absorption, along.ozone);
        depth.add_scaled(&self.pair_absorption, along.pairs);
        depth.add_scaled(&self.water_absorption, along.water);
        depth
    }

    /// The part of light that column densities let through.
    #[inline(always)]
    pub fn transmittance(&self, along: ColumnDensities) -> V {
        self.optical_depth(along).decayed()
    }

    /// What air and aerosol of relative densities scatter of some light (km⁻¹ times that of the light).
    #[inline(always)]
    pub fn scattered(&self, light: &V, density: Vec2) -> ByScatterer<V> {
        ByScatterer {
            air: light.times(&self.air_scattering).scaled(density.x),
            aerosol: light.times(&self.aerosol_scattering).scaled(density.y),
        }
    }
}
