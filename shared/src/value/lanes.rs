//! Values at the wavelengths that share a ray on a processor.

use crate::math::{abs, exp_lanes, ln_lanes, max};
use crate::value::bands::Value;

/// Numbers at some wavelengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes<const N: usize>(pub [f32; N]);

impl<const N: usize> Value for Lanes<N> {
    const ZERO: Self = Self([0.0; N]);

    #[inline(always)]
    fn add_scaled(&mut self, other: &Self, factor: f32) {
        for i in 0..N {
            self.0[i] += other.0[i] * factor;
        }
    }

    #[inline(always)]
    fn add_product(&mut self, a: &Self, b: &Self) {
        for i in 0..N {
            self.0[i] += a.0[i] * b.0[i];
        }
    }

    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        let mut product = *self;
        for i in 0..N {
            product.0[i] *= other.0[i];
        }
        product
    }

    #[inline(always)]
    fn scaled(&self, factor: f32) -> Self {
        let mut product = *self;
        for value in &mut product.0 {
            *value *= factor;
        }
        product
    }

    #[inline(always)]
    fn weighted(a: Self, b: Self, c: Self, d: Self, [wa, wb, wc, wd]: [f32; 4]) -> Self {
        let mut sum = Self::ZERO;
        for i in 0..N {
            sum.0[i] = a.0[i] * wa + b.0[i] * wb + c.0[i] * wc + d.0[i] * wd;
        }
        sum
    }

    #[inline(always)]
    fn decayed(&self) -> Self {
        let mut power = self.scaled(-1.0);
        exp_lanes(&mut power.0);
        power
    }

    #[inline(always)]
    fn logarithm(&self) -> Self {
        let mut logarithm = *self;
        ln_lanes(&mut logarithm.0);
        logarithm
    }

    #[inline(always)]
    fn magnitude(&self) -> Self {
        let mut magnitude = *self;
        for value in &mut magnitude.0 {
            *value = abs(*value);
        }
        magnitude
    }

    #[inline(always)]
    fn inverse(&self) -> Self {
        let mut inverse = *self;
        for value in &mut inverse.0 {
            *value = 1.0 / *value;
        }
        inverse
    }

    #[inline(always)]
    fn at_least(&self, least: &Self) -> Self {
        let mut larger = *self;
        for i in 0..N {
            larger.0[i] = max(larger.0[i], least.0[i]);
        }
        larger
    }

    #[inline(always)]
    fn at_least_number(&self, least: f32) -> Self {
        let mut larger = *self;
        for value in &mut larger.0 {
            *value = max(*value, least);
        }
        larger
    }
}
