//! The planet and what lies about it: the radii, the profiles, and densities by altitude.

use bytemuck::{Pod, Zeroable};

use crate::geometry::Shell;
use crate::glam::{Vec2, Vec4};
use crate::math::exp4;
use crate::medium::exponential::Exponential;
use crate::variant;

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
    /// Anisotropy of the phase function of air; see [`crate::medium::phase::air_phase`].
    pub air_anisotropy: f32,
    /// Unused; fills the last 16 bytes.
    pub padding: u32,
}

impl Atmosphere {
    /// The two spheres between which the atmosphere lies.
    #[inline(always)]
    pub fn shell(&self) -> Shell {
        Shell { ground_radius: self.ground_radius, depth: self.depth }
    }
}

/// Relative densities of (air, aerosol) at an altitude (km); aerosol is 0 where `variant` leaves it out.
#[inline(always)]
pub fn relative_densities(atmosphere: &Atmosphere, altitude: f32, variant: u32) -> Vec2 {
    // Divisions of what a ray's samples share: the compiler makes them once.
    let fall_off = Vec4::NEG_ONE / lanes(atmosphere.air.scale_height, atmosphere.aerosol.scale_height);
    let density = exp4(fall_off * altitude);
    Vec2::new(density.x, if variant & variant::AEROSOL != 0 { density.y } else { 0.0 })
}

/// Two values, of air and of aerosol or of the two slopes of ozone, for each of two rays.
#[inline(always)]
pub(crate) fn lanes(first: f32, second: f32) -> Vec4 {
    Vec4::new(first, second, first, second)
}
