//! A value, and that of four bands.

use crate::glam::Vec4;
use crate::math::{abs, exp4, ln4, max};

/// A number for each of some bands.
pub trait Value: Copy {
    /// Nothing.
    const ZERO: Self;

    /// Adds `other` times a number.
    fn add_scaled(&mut self, other: &Self, factor: f32);

    /// Adds the product of two.
    fn add_product(&mut self, a: &Self, b: &Self);

    /// Times another.
    fn times(&self, other: &Self) -> Self;

    /// Times a number.
    fn scaled(&self, factor: f32) -> Self;

    /// The sum of four, each times its weight.
    fn weighted(a: Self, b: Self, c: Self, d: Self, weights: [f32; 4]) -> Self;

    /// `e` to the power of its negative.
    fn decayed(&self) -> Self;

    /// Its natural logarithm; it is a normal number above 0.
    fn logarithm(&self) -> Self;

    /// Without its sign.
    fn magnitude(&self) -> Self;

    /// 1 divided by it.
    fn inverse(&self) -> Self;

    /// Each number, or that of another where it is larger.
    fn at_least(&self, least: &Self) -> Self;

    /// Each number, or this one where it is larger.
    fn at_least_number(&self, least: f32) -> Self;
}

impl Value for Vec4 {
    const ZERO: Self = Self::ZERO;

    #[inline(always)]
    fn add_scaled(&mut self, other: &Self, factor: f32) {
        *self += *other * factor;
    }

    #[inline(always)]
    fn add_product(&mut self, a: &Self, b: &Self) {
        *self += *a * *b;
    }

    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        *self * *other
    }

    #[inline(always)]
    fn scaled(&self, factor: f32) -> Self {
        *self * factor
    }

    #[inline(always)]
    fn weighted(a: Self, b: Self, c: Self, d: Self, [wa, wb, wc, wd]: [f32; 4]) -> Self {
        a * wa + b * wb + c * wc + d * wd
    }

    #[inline(always)]
    fn decayed(&self) -> Self {
        exp4(-*self)
    }

    #[inline(always)]
    fn logarithm(&self) -> Self {
        ln4(*self)
    }

    #[inline(always)]
    fn magnitude(&self) -> Self {
        Self::new(abs(self.x), abs(self.y), abs(self.z), abs(self.w))
    }

    #[inline(always)]
    fn inverse(&self) -> Self {
        Self::ONE / *self
    }

    #[inline(always)]
    fn at_least(&self, least: &Self) -> Self {
        Self::new(max(self.x, least.x), max(self.y, least.y), max(self.z, least.z), max(self.w, least.w))
    }

    #[inline(always)]
    fn at_least_number(&self, least: f32) -> Self {
        self.at_least(&Self::splat(least))
    }
}
