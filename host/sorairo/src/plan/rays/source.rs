//! Where light comes from: the sun, in double precision. What kernels are told of it is made from it, and not read
//! back.

use sorairo_shared::glam::{DVec3, Vec4};

use super::directions::direction;
use crate::scene::Scene;

/// A source of light, so far away that its direction is the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Elevation of its centre (degrees).
    pub elevation: f64,
    /// Azimuth (degrees), clockwise from north.
    pub azimuth: f64,
}

impl Source {
    /// The sun of a scene.
    pub fn sun(scene: &Scene) -> Self {
        Self { elevation: scene.sun.elevation, azimuth: scene.sun.azimuth }
    }

    /// The unit vector to it.
    pub fn direction(self) -> DVec3 {
        direction(self.elevation, self.azimuth)
    }

    /// The unit vector below or above it on the horizon's level.
    pub fn bearing(self) -> DVec3 {
        direction(0.0, self.azimuth)
    }

    /// Both, as a uniform has them.
    pub fn for_kernels(self) -> [Vec4; 2] {
        [self.direction(), self.bearing()].map(|vector| vector.as_vec3().extend(0.0))
    }
}
