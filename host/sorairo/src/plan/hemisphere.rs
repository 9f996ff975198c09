//! Directions and weights of a quadrature over the hemispheres above and below an observer.

use std::f64::consts::PI;

use sorairo_shared::glam::{DVec3, Vec2};

use crate::plan::rays::directions::direction;
use crate::plan::rays::quadrature::gauss_legendre;
use crate::plan::sky::SkyPlan;

/// Nodes between the horizon and the sun's elevation, and as many from there to the zenith.
const ELEVATIONS: u32 = 16;

/// Nodes over half of the azimuths, which mirror the other half.
const AZIMUTHS: u32 = 24;

/// A direction of a quadrature over half of a hemisphere, which the other half mirrors.
#[derive(Clone, Copy)]
pub struct Node {
    /// Elevation (degrees).
    pub elevation: f64,
    /// Azimuth from the sun (degrees).
    pub azimuth: f64,
    /// Solid angle of it and its mirror image (sr).
    pub solid_angle: f64,
}

impl Node {
    /// Unit vector.
    pub fn direction(self, sky: &SkyPlan) -> DVec3 {
        direction(self.elevation, sky.base.source.azimuth + self.azimuth)
    }

    /// On the other side of the vertical plane through the sun.
    pub fn mirrored(self) -> Self {
        Self { azimuth: -self.azimuth, ..self }
    }

    /// What it counts on a level surface (sr).
    pub fn level(self) -> f64 {
        self.solid_angle * self.elevation.to_radians().sin().abs()
    }
}

/// Nodes of the hemisphere above, crowded around the sun; `finer` times as many along either side.
pub fn nodes(sky: &SkyPlan, finer: u32) -> Vec<Node> {
    let sun = sky.base.source.elevation.max(0.0);
    nodes_between(&[(sun, 0.0), (sun, 90.0)], finer * ELEVATIONS, finer * AZIMUTHS)
}

/// Nodes of the hemisphere below, crowded around the horizon.
pub fn nodes_below(sky: &SkyPlan) -> Vec<Node> {
    let horizon = f64::from(sky.base.uniform.horizon).to_degrees();
    nodes_between(&[(horizon, 0.0), (horizon, -90.0)], ELEVATIONS, AZIMUTHS)
}

/// Nodes between elevations (degrees), crowded towards the first of each pair.
fn nodes_between(ranges: &[(f64, f64); 2], elevations: u32, azimuths: u32) -> Vec<Node> {
    let azimuths = crowded(azimuths, 0.0, 180.0);
    let row = |(elevation, weight): (f64, f64)| {
        let around = 2.0 * elevation.to_radians().cos() * weight;
        let node = move |&(azimuth, across): &(f64, f64)| Node { elevation, azimuth, solid_angle: around * across };
        azimuths.iter().map(node)
    };
    ranges.iter().flat_map(|&(from, to)| crowded(elevations, from, to)).flat_map(row).collect()
}

/// Nodes (degrees) and weights (radians) of a rule that crowds towards `from` as a cube.
fn crowded(n: u32, from: f64, to: f64) -> Vec<(f64, f64)> {
    let node = |p: Vec2| {
        let (u, weight) = (f64::from(p.x), f64::from(p.y));
        (from + (to - from) * u * u * u, 3.0 * u * u * weight * (to - from).abs() * PI / 180.0)
    };
    gauss_legendre(n).into_iter().map(node).collect()
}
