//! Runs of a perspective image: neighbouring pixels of a row, between a few places of which the colours of the
//! constituents are interpolated.
//!
//! A row lies on a great circle. Along it the sky without its phase functions is smooth, across the zenith too: a cubic
//! goes through four places, the ends of the run among them, so that neighbouring runs meet. From the ground no row
//! crosses the horizon, since the camera stands upright. From above it a run beside the horizon is none: its pixels are
//! looked up alone.
//!
//! With the direction `v` not yet of unit length, `v`, `v · s` and `v × s` are linear along the row, and so the angle
//! from the sun `s` costs each pixel one root: `cos θ = v · s / |v|`, `sin² θ = |v × s|² / |v|²`.

use crate::camera::{perspective_step, perspective_vector};
use crate::glam::{Vec3, Vec4};
use crate::interpolation::cubic::{Stencil, stencil};
use crate::math::{abs, sin_cos, sqrt};
use crate::medium::phase::ScatteringAngle;
use crate::picture::lookup::{grid_constituents, grid_place};
use crate::picture::run::{Colours, PLACES, RUN, SPACING, middle_position};
use crate::uniform::Uniform;
use crate::variant;

/// What the pixels of a run share.
#[derive(Clone, Copy)]
pub struct PerspectiveRun {
    /// The direction in the middle, whose part into the image is of unit length, and its change per pixel.
    middle: Vec3,
    step: Vec3,
    /// Its product with the unit vector towards the sun, likewise.
    cosine: f32,
    cosine_step: f32,
    sine: Vec3,
    sine_step: Vec3,
    colours: Colours,
}

/// Whether a run of an observer above the ground may reach the horizon, or lies no farther from it than it is long.
#[inline(always)]
pub fn may_meet_horizon(uniform: &Uniform, column: u32, row: u32, variant: u32) -> bool {
    let middle = perspective_vector(&uniform.camera, middle_position(column, row));
    let step = perspective_step(&uniform.camera);
    let (sine_of_horizon, _) = sin_cos(uniform.horizon);
    let from_horizon = abs(middle.z / sqrt(middle.dot(middle)) - sine_of_horizon);
    // A sine changes by no more than its angle, and that by no more than the way in the plane at unit distance.
    (variant & variant::DESCENT != 0) & (from_horizon <= 1.5 * RUN as f32 * sqrt(step.dot(step)))
}

impl PerspectiveRun {
    /// Without light.
    #[inline(always)]
    pub fn dark(uniform: &Uniform) -> Self {
        let (none, colours) = (Vec3::ZERO, Colours::dark(uniform));
        Self { middle: none, step: none, cosine: 0.0, cosine_step: 0.0, sine: none, sine_step: none, colours }
    }

    /// The run that begins with a pixel of the whole image.
    #[inline(always)]
    pub fn new(uniform: &Uniform, lookup: &[Vec4], column: u32, row: u32, variant: u32) -> Self {
        let sun = Vec3::new(uniform.sun.x, uniform.sun.y, uniform.sun.z);
        let middle = perspective_vector(&uniform.camera, middle_position(column, row));
        let step = perspective_step(&uniform.camera);
        let mut run = Self {
            middle,
            step,
            cosine: middle.dot(sun),
            cosine_step: step.dot(sun),
            sine: middle.cross(sun),
            sine_step: step.cross(sun),
            colours: Colours::dark(uniform),
        };
        let near = stencil(0.5 * (PLACES - 1) as f32, PLACES);
        let mut place = 0;
        while place < PLACES {
            run.look(uniform, lookup, near, place, variant);
            place += 1;
        }
        run
    }

    /// Looks up one of the places.
    #[inline(always)]
    fn look(&mut self, uniform: &Uniform, lookup: &[Vec4], near: Stencil, place: u32, variant: u32) {
        let vector = self.middle + self.step * (SPACING * place as f32 - 0.5 * RUN as f32);
        let view = vector * (1.0 / sqrt(vector.dot(vector)));
        let found = grid_constituents(uniform, lookup, grid_place(uniform, view, variant), variant);
        self.colours.add(found, near, place, variant);
    }

    /// Linear RGB of the sky so many pixels beside its middle.
    #[inline(always)]
    pub fn sky(self, uniform: &Uniform, beside: f32, variant: u32) -> Vec3 {
        let vector = self.middle + self.step * beside;
        let sine = self.sine + self.sine_step * beside;
        let inverse = 1.0 / sqrt(vector.dot(vector));
        let cosine = (self.cosine + self.cosine_step * beside) * inverse;
        let angle = ScatteringAngle::new(cosine, sine.dot(sine) * (inverse * inverse));
        self.colours.sky(uniform, beside * (1.0 / SPACING), angle, variant)
    }
}
