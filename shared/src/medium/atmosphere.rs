//! The planet and what lies about it: the radii and the profiles.

use core::ops::{Add, Mul, Sub};

use bytemuck::{Pod, Zeroable};

use crate::geometry::{Shadow, Shell};
use crate::glam::{Vec3, Vec4};
use crate::math::max;
use crate::medium::exponential::Exponential;

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
    /// What the tables hold, as a number that no other tables have; 0 without tables. See [`crate::medium::tables`].
    pub tables: u32,
    /// How much wider the planet's shadow is at its centre than the planet (km); see [`Shadow`].
    pub shadow_offset: f32,
    /// By how much the shadow narrows with the distance.
    pub shadow_slope: f32,
    /// The distance behind the planet's centre at which it begins (km).
    pub shadow_begin: f32,
    /// Unused; fills the last 16 bytes.
    pub padding: u32,
}

/// What lies along one path. Numbers one by one: vectors of three in a structure are laid out otherwise in WGSL.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColumnDensities {
    /// Column density of air (km).
    pub air: f32,
    /// Of aerosol (km).
    pub aerosol: f32,
    /// Of ozone (km).
    pub ozone: f32,
    /// Amount of what absorbs as pairs of oxygen lie, relative to that over the ground; 0 in air of closed form.
    pub pairs: f32,
    /// That of what absorbs as water vapour lies.
    pub water: f32,
}

impl ColumnDensities {
    /// Nothing.
    pub const ZERO: Self = Self { air: 0.0, aerosol: 0.0, ozone: 0.0, pairs: 0.0, water: 0.0 };

    /// Those of air, aerosol and ozone (km), without gases.
    #[inline(always)]
    pub fn without_gases(main: Vec3) -> Self {
        Self { air: main.x, aerosol: main.y, ozone: main.z, ..Self::ZERO }
    }

    /// Without what rounding made negative.
    #[inline(always)]
    pub fn at_least_zero(self) -> Self {
        self.with(Self::ZERO, max)
    }

    #[inline(always)]
    fn with(self, other: Self, of: impl Fn(f32, f32) -> f32) -> Self {
        Self {
            air: of(self.air, other.air),
            aerosol: of(self.aerosol, other.aerosol),
            ozone: of(self.ozone, other.ozone),
            pairs: of(self.pairs, other.pairs),
            water: of(self.water, other.water),
        }
    }
}

impl Add for ColumnDensities {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }
}

impl Sub for ColumnDensities {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(other, |a, b| a - b)
    }
}

impl Mul<f32> for ColumnDensities {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f32) -> Self {
        self.with(self, |a, _| a * factor)
    }
}

/// What fills the air: the planet and the constituents, and the tables of profiles that have no closed form.
#[derive(Clone, Copy, Debug)]
pub struct Medium<'a> {
    /// The planet and the constituents.
    pub atmosphere: &'a Atmosphere,
    /// See [`crate::medium::tables`]; read where the variant says that there are some.
    pub tables: &'a [Vec4],
}

impl Medium<'_> {
    /// The two spheres between which the atmosphere lies.
    #[inline(always)]
    pub fn shell(&self) -> Shell {
        self.atmosphere.shell()
    }
}

impl Atmosphere {
    /// The two spheres between which the atmosphere lies.
    #[inline(always)]
    pub fn shell(&self) -> Shell {
        let shadow = Shadow { offset: self.shadow_offset, slope: self.shadow_slope, begin: self.shadow_begin };
        Shell { ground_radius: self.ground_radius, depth: self.depth, shadow }
    }
}

/// Two values, of air and of aerosol or of the two slopes of ozone, for each of two rays.
#[inline(always)]
pub(crate) fn lanes(first: f32, second: f32) -> Vec4 {
    Vec4::new(first, second, first, second)
}
