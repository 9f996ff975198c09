//! The ray integral of a sky: what the air and the aerosol along a ray scatter towards the observer, at the bands, before any fit.

use sorairo_shared::geometry::Ray;
use sorairo_shared::glam::{Vec2, Vec3, Vec4};
use sorairo_shared::phase::{ScatteringAngle, cornette_shanks_phase, rayleigh_phase};
use sorairo_shared::single::{Bands, SingleScattering, single_scattering};
use sorairo_shared::sky::{Constituents, transfer, view_ray};
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant;

use super::directions::farthest_air;
use crate::scene::Scene;
use crate::spectra::optics::Optics;

/// The optical depth that may lie above the top of the atmosphere before column densities to the sun take it off. It changes
/// radiance by less than this part, a tenth of what the integral's own sampling leaves.
const NEGLIGIBLE_DEPTH_ABOVE_TOP: f64 = 1e-4;

/// The optical depth of a level ray at the ground up to which the column densities of short stretches may be differences of
/// those to infinity: single precision keeps 1e-5 of it.
const OPAQUE_DEPTH: f64 = 50.0;

/// Air or aerosol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constituent {
    /// Air.
    Air,
    /// Aerosol.
    Aerosol,
}

impl Constituent {
    /// The constituent's integral.
    pub fn of(self, scattered: &SingleScattering) -> Vec4 {
        match self {
            Self::Air => scattered.air,
            Self::Aerosol => scattered.aerosol,
        }
    }
}

/// The phase functions in a direction (sr⁻¹).
#[derive(Clone, Copy, Debug)]
pub struct Phases {
    /// Of air.
    pub air: f32,
    /// Of aerosol.
    pub aerosol: f32,
}

impl Phases {
    /// That of a constituent.
    pub fn of(self, constituent: Constituent) -> f32 {
        match constituent {
            Constituent::Air => self.air,
            Constituent::Aerosol => self.aerosol,
        }
    }

    /// Linear RGB of the sky from that of its constituents, whatever its gamut (W·m⁻²·sr⁻¹).
    pub fn applied(self, constituents: Constituents) -> Vec3 {
        constituents.air * self.air + constituents.aerosol * self.aerosol
    }
}

/// Planet, sun and observer, the bands, and the rule by which rays are integrated.
#[derive(Clone, Debug)]
pub struct RayIntegral {
    /// What the kernels are told of the sky; of an image it knows nothing.
    pub uniform: Uniform,
    /// The atmosphere's optical properties at any wavelength.
    pub optics: Optics,
    /// Wavelengths of the bands (nm), increasing.
    pub wavelengths: Vec<f64>,
    /// Optical properties at the bands, four to a group.
    pub bands: Vec<Bands>,
    /// Quadrature nodes of the ray integral on [0, 1], with their weights.
    pub quadrature: Vec<Vec2>,
    /// What the integral must not skip: bits of [`variant::WHOLE_INTEGRAL`].
    pub variant: u32,
    /// Azimuth of the sun (degrees).
    pub sun_azimuth: f64,
}

impl RayIntegral {
    /// The ray from the observer in a direction.
    pub fn ray(&self, view: Vec3) -> Ray {
        view_ray(&self.uniform, view)
    }

    /// The phase functions in a direction.
    pub fn phases(&self, view: Vec3) -> Phases {
        let ray = self.ray(view);
        Phases {
            air: rayleigh_phase(ray.nu),
            aerosol: cornette_shanks_phase(ScatteringAngle::of_ray(ray), self.uniform.atmosphere.aerosol_asymmetry),
        }
    }

    /// Transfer (sr⁻¹) in a direction at each band (Eq. 1).
    pub fn transfer(&self, view: Vec3) -> Vec<f64> {
        let four = |group| transfer(&self.uniform, group, &self.quadrature, view, self.variant);
        self.at_bands(self.bands.iter().map(four))
    }

    /// The integrals of a ray at some groups of bands, before their phase functions (transfer times sr).
    pub fn scattered(&self, groups: &[Bands], view: Vec3) -> Vec<SingleScattering> {
        let ray = self.ray(view);
        let atmosphere = &self.uniform.atmosphere;
        groups.iter().map(|group| single_scattering(atmosphere, group, &self.quadrature, ray, self.variant)).collect()
    }

    /// One value for each band from groups of four, the last of which may be filled up.
    pub fn at_bands(&self, groups: impl Iterator<Item = Vec4>) -> Vec<f64> {
        groups.flat_map(|four| four.to_array().map(f64::from)).take(self.wavelengths.len()).collect()
    }

    /// Whether there is aerosol.
    pub fn has_aerosol(&self) -> bool {
        self.variant & variant::AEROSOL != 0
    }
}

/// What a scene has that the integral must not skip: bits of [`variant::WHOLE_INTEGRAL`].
pub fn needed(scene: &Scene, optics: &Optics) -> u32 {
    let a = &scene.atmosphere;
    let from_above = scene.observer.altitude > 0.0;
    let low_sun = scene.sun.elevation <= farthest_air(scene).to_degrees();
    // By day no ray from the ground itself meets the shadow.
    let shadow = if from_above { low_sun } else { scene.sun.elevation <= 0.0 };
    let bit = |present: bool, bit: u32| if present { bit } else { 0 };
    bit(a.aerosol.optical_depth > 0.0, variant::AEROSOL)
        | bit(a.ozone.column > 0.0, variant::OZONE)
        | bit(optics.depth_above_top() > NEGLIGIBLE_DEPTH_ABOVE_TOP, variant::ABOVE_TOP)
        | bit(shadow, variant::SHADOW)
        | bit(from_above, variant::DESCENT)
        | bit(low_sun, variant::LOW_SUN)
        | bit(optics.level_depth() > OPAQUE_DEPTH, variant::OPAQUE)
}
