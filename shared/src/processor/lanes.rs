//! Numbers of all pixels of a block, each kind beside its own.

use std::ops::Range;

use crate::glam::{Vec3, Vec4};

/// Pixels of a block, at most: whole registers of any processor, and few enough that a block stays in the nearest
/// cache.
pub const BLOCK: usize = 64;

/// A number of each pixel.
pub type Lanes = [f32; BLOCK];

/// A number of no pixel yet.
pub const ZERO: Lanes = [0.0; BLOCK];

/// The pixels of a block that has so many.
#[inline(always)]
pub fn lanes(count: usize) -> Range<usize> {
    // The compiler then knows that none is beyond its array.
    0..count.min(BLOCK)
}

/// A vector or a colour of each pixel.
#[derive(Clone, Copy)]
pub struct Three([Lanes; 3]);

impl Three {
    /// Zeros.
    pub const ZERO: Self = Self([ZERO; 3]);

    /// The same of each pixel.
    #[inline(always)]
    pub fn splat(value: Vec3) -> Self {
        Self([[value.x; BLOCK], [value.y; BLOCK], [value.z; BLOCK]])
    }

    /// That of a pixel.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vec3 {
        let [x, y, z] = &self.0;
        Vec3::new(x[lane], y[lane], z[lane])
    }

    /// Sets that of a pixel.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, value: Vec3) {
        let [x, y, z] = &mut self.0;
        (x[lane], y[lane], z[lane]) = (value.x, value.y, value.z);
    }
}

/// Values of each pixel at four bands.
#[derive(Clone, Copy)]
pub struct Four([Lanes; 4]);

impl Four {
    /// Zeros.
    pub const ZERO: Self = Self([ZERO; 4]);

    /// Those of a pixel.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vec4 {
        let [x, y, z, w] = &self.0;
        Vec4::new(x[lane], y[lane], z[lane], w[lane])
    }

    /// Sets those of a pixel.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, value: Vec4) {
        let [x, y, z, w] = &mut self.0;
        (x[lane], y[lane], z[lane], w[lane]) = (value.x, value.y, value.z, value.w);
    }
}
