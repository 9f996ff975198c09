//! The diffuse irradiance of the ground under the suns of a light field.

use sorairo_shared::light_field::table::{between, exp_between_logarithms, logarithms_of_light};
use sorairo_shared::value::Lanes;

use crate::plan::light_field::grid::Grid;

/// The irradiance of the ground under the suns of a grid.
pub struct Irradiance<const N: usize> {
    /// It, or its logarithms.
    of_suns: Vec<Lanes<N>>,
    logarithmic: bool,
}

impl<const N: usize> Irradiance<N> {
    pub(crate) fn new(of_suns: &[Lanes<N>], logarithmic: bool) -> Self {
        // What corrects a light field may be less than nothing, and has no logarithm.
        let logarithmic = logarithmic && of_suns.iter().flat_map(|irradiance| irradiance.0).all(|value| value >= 0.0);
        let taken = |irradiance: &Lanes<N>| if logarithmic { logarithms_of_light(irradiance) } else { *irradiance };
        Self { of_suns: of_suns.iter().map(taken).collect(), logarithmic }
    }

    /// That under a sun with a zenith angle (radians).
    pub fn at(&self, grid: &Grid, angle: f32) -> Lanes<N> {
        let stencil = grid.sun_angles.axis().stencil(angle, 0);
        if self.logarithmic { exp_between_logarithms(&self.of_suns, stencil) } else { between(&self.of_suns, stencil) }
    }
}
