//! Cubics through four neighbours of a row of equidistant values.

use crate::glam::{Vec3, Vec4};
use crate::math::{clamp, floor};

/// Four neighbours about a position, and what each adds to the cubic through them there.
#[derive(Clone, Copy)]
pub struct Stencil {
    /// The first of the four.
    pub first: u32,
    /// The weights of their values.
    pub weights: Vec4,
    /// The weights of the cubic's slope, per step from one to the next.
    pub slopes: Vec4,
    /// The weights of half of its second derivative.
    pub bends: Vec4,
}

/// The weights of a sixth of the cubic's third derivative, which is the same everywhere.
pub const TWISTS: Vec4 = Vec4::new(-1.0 / 6.0, 0.5, -0.5, 1.0 / 6.0);

/// The cubic of a colour, about a position.
#[derive(Clone, Copy)]
pub struct ColourCubic {
    /// The colour there.
    pub value: Vec3,
    /// Its change per step.
    pub slope: Vec3,
    /// Half of the change of that per step.
    pub bend: Vec3,
    /// A third of the change of that.
    pub twist: Vec3,
}

impl ColourCubic {
    /// No light.
    pub const DARK: Self = Self { value: Vec3::ZERO, slope: Vec3::ZERO, bend: Vec3::ZERO, twist: Vec3::ZERO };

    /// Adds what one of the four colours of a stencil, counted from 0, is to the cubic.
    #[inline(always)]
    pub fn add(&mut self, colour: Vec3, of: Stencil, index: u32) {
        self.value += colour * lane(of.weights, index);
        self.slope += colour * lane(of.slopes, index);
        self.bend += colour * lane(of.bends, index);
        self.twist += colour * lane(TWISTS, index);
    }

    /// The colour so many steps beside the position.
    #[inline(always)]
    pub fn beside(self, steps: f32) -> Vec3 {
        self.value + (self.slope + (self.bend + self.twist * steps) * steps) * steps
    }
}

/// One of four values, counted from 0.
#[inline(always)]
pub fn lane(four: Vec4, index: u32) -> f32 {
    if index == 0 {
        four.x
    } else if index == 1 {
        four.y
    } else if index == 2 {
        four.z
    } else {
        four.w
    }
}

/// The stencil at a position among `count` values, four at least; one-sided at the ends.
///
/// Lagrange's polynomials on the nodes 0, 1, 2 and 3.
#[inline(always)]
pub fn stencil(position: f32, count: u32) -> Stencil {
    let first = clamp(floor(position) - 1.0, 0.0, (count - 4) as f32);
    let a = position - first;
    let (b, c, d) = (a - 1.0, a - 2.0, a - 3.0);
    let weights = Vec4::new(b * c * d * (-1.0 / 6.0), a * c * d * 0.5, a * b * d * -0.5, a * b * c * (1.0 / 6.0));
    let slopes = Vec4::new(
        (b * c + b * d + c * d) * (-1.0 / 6.0),
        (a * c + a * d + c * d) * 0.5,
        (a * b + a * d + b * d) * -0.5,
        (a * b + a * c + b * c) * (1.0 / 6.0),
    );
    let bends = Vec4::new((b + c + d) * (-1.0 / 6.0), (a + c + d) * 0.5, (a + b + d) * -0.5, (a + b + c) * (1.0 / 6.0));
    Stencil { first: first as u32, weights, slopes, bends }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_of_a_colour_goes_through_its_four_colours() {
        let colours = [3.0f32, -1.0, 0.5, 7.0];
        let middle = stencil(1.5, 4);
        let mut cubic = ColourCubic::DARK;
        for (index, &colour) in (0..).zip(&colours) {
            cubic.add(Vec3::new(colour, 2.0 * colour, 0.0), middle, index);
        }
        for (place, colour) in [-1.5, -0.5, 0.5, 1.5].into_iter().zip(colours) {
            // A dozen roundings of numbers below ten.
            assert!((cubic.beside(place) - Vec3::new(colour, 2.0 * colour, 0.0)).abs().max_element() < 1e-5);
        }
    }

    #[test]
    fn a_cubic_and_its_derivatives_are_exact_between_any_two_values() {
        let cubic = |x: f32| ((0.5 * x - 2.0) * x + 1.0) * x - 3.0;
        let slope = |x: f32| (1.5 * x - 4.0) * x + 1.0;
        let bend = |x: f32| 1.5 * x - 2.0;
        for count in [4, 5, 9] {
            for i in 0..=40 {
                let x = (count - 1) as f32 * i as f32 / 40.0;
                let Stencil { first, weights, slopes, bends } = stencil(x, count);
                assert!(first + 4 <= count);
                let values = Vec4::from_array([0, 1, 2, 3].map(|k| cubic((first + k) as f32)));
                // Four products of up to 250, each rounded by 6e-8.
                assert!((weights.dot(values) - cubic(x)).abs() < 2e-4, "{x} of {count}");
                assert!((slopes.dot(values) - slope(x)).abs() < 2e-4, "{x} of {count}");
                assert!((bends.dot(values) - bend(x)).abs() < 2e-4, "{x} of {count}");
                assert!((TWISTS.dot(values) - 0.5).abs() < 2e-4, "{x} of {count}");
            }
        }
    }
}
