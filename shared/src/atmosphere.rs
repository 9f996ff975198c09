//! What the atmosphere is made of: densities with altitude, and phase functions.

use bytemuck::{Pod, Zeroable};

use crate::geometry::Shell;
use crate::glam::Vec4;
use crate::math::{PI, exp, max, min, sqrt};

/// How the planet and the constituents of its atmosphere are laid out. The layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Atmosphere {
    /// Air.
    pub air: Exponential,
    /// Aerosol.
    pub aerosol: Exponential,
    /// Radius of the ground sphere (km).
    pub ground_radius: f32,
    /// Height of the top of the atmosphere above the ground (km).
    pub depth: f32,
    /// Asymmetry `g` of the aerosol's phase function, in (-1, 1).
    pub aerosol_asymmetry: f32,
    /// Altitude at which the ozone layer begins (km).
    pub ozone_bottom: f32,
    /// Altitude at which ozone is densest (km).
    pub ozone_peak: f32,
    /// Altitude at which the ozone layer ends (km).
    pub ozone_top: f32,
    /// Unused; fills the last 16 bytes.
    pub padding0: u32,
    /// Unused.
    pub padding1: u32,
}

/// A constituent whose density falls exponentially with altitude, and its column densities in closed form; see
/// [`crate::column`].
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Exponential {
    /// Coefficients of `t¹` to `t⁴` in the column's polynomial.
    pub low_coefficients: Vec4,
    /// Coefficients of `t⁵` to `t⁸`.
    pub high_coefficients: Vec4,
    /// Scale height `H` (km).
    pub scale_height: f32,
    /// `K = κ √(R / 2H)`: how fast the column falls with the cosine of the zenith angle.
    pub spread: f32,
    /// `H K` (km), the unit of the column.
    pub unit: f32,
    /// The level column at the ground (km): `H K` times the sum of all coefficients.
    pub level_column: f32,
}

impl Atmosphere {
    /// The two spheres between which the atmosphere lies.
    #[inline]
    pub fn shell(&self) -> Shell {
        Shell { ground_radius: self.ground_radius, depth: self.depth }
    }
}

impl Exponential {
    /// Density at an altitude (km) relative to the ground: `e^(-h/H)`.
    #[inline]
    pub fn density(&self, altitude: f32) -> f32 {
        exp(-altitude / self.scale_height)
    }
}

/// Density of ozone relative to its peak: a tent over bottom, peak and top (Bruneton 2017, "Ozone").
///
/// `altitude` in km; from 0 to 1.
#[inline]
pub fn ozone_density(atmosphere: &Atmosphere, altitude: f32) -> f32 {
    let rising = (altitude - atmosphere.ozone_bottom) / (atmosphere.ozone_peak - atmosphere.ozone_bottom);
    let falling = (atmosphere.ozone_top - altitude) / (atmosphere.ozone_top - atmosphere.ozone_peak);
    max(min(rising, falling), 0.0)
}

/// Rayleigh's phase function of air, `3/(16π) (1 + ν²)`, in sr⁻¹; its integral over the sphere is 1.
///
/// `nu` is the cosine of the scattering angle.
#[inline]
pub fn rayleigh_phase(nu: f32) -> f32 {
    3.0 / (16.0 * PI) * (1.0 + nu * nu)
}

/// The phase function of aerosol by Cornette and Shanks (1992, <https://doi.org/10.1364/AO.31.003152>, Eq. 8), in sr⁻¹:
/// `3/(8π) (1 - g²)(1 + ν²) / ((2 + g²)(1 + g² - 2 g ν)^(3/2))`; its integral over the sphere is 1.
///
/// `nu` is the cosine of the scattering angle, `g` the asymmetry in (-1, 1).
#[inline]
pub fn cornette_shanks_phase(nu: f32, g: f32) -> f32 {
    // (1 - g)² + 2g(1 - ν) is 1 + g² - 2gν, and keeps its digits in the forward peak.
    let spread = max((1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - nu), 1e-12);
    let scale = 3.0 / (8.0 * PI) * (1.0 - g * g) / (2.0 + g * g);
    scale * (1.0 + nu * nu) / (spread * sqrt(spread))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integral_over_the_sphere(phase: impl Fn(f32) -> f32) -> f64 {
        let n = 20_000;
        let cosine = |i: u32| -1.0 + (2.0 * f64::from(i) + 1.0) / f64::from(n);
        (0..n).map(|i| f64::from(phase(cosine(i) as f32))).sum::<f64>() * 4.0 * std::f64::consts::PI / f64::from(n)
    }

    #[test]
    fn phase_functions_integrate_to_one() {
        // 20 000 midpoints leave 1e-8 of the peak; rounding of single precision leaves 1e-7 a term.
        assert!((integral_over_the_sphere(rayleigh_phase) - 1.0).abs() < 1e-6);
        for g in [-0.5, 0.0, 0.3, 0.8, 0.9] {
            let integral = integral_over_the_sphere(|nu| cornette_shanks_phase(nu, g));
            // 1 - g keeps 1e-6 of itself at g = 0.9, and enters the peak cubed.
            assert!((integral - 1.0).abs() < 2e-5, "g = {g}: {integral}");
        }
    }

    #[test]
    fn an_isotropic_asymmetry_gives_the_rayleigh_phase() {
        for nu in [-1.0, -0.3, 0.0, 0.5, 1.0] {
            assert!((cornette_shanks_phase(nu, 0.0) / rayleigh_phase(nu) - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn ozone_is_a_tent() {
        let atmosphere = Atmosphere { ozone_bottom: 10.0, ozone_peak: 25.0, ozone_top: 40.0, ..Atmosphere::zeroed() };
        for (altitude, density) in [(0.0, 0.0), (10.0, 0.0), (17.5, 0.5), (25.0, 1.0), (32.5, 0.5), (41.0, 0.0)] {
            assert!((ozone_density(&atmosphere, altitude) - density).abs() < 1e-6);
        }
    }
}
