//! The measure of arithmetic: multiply-adds alone, in registers. What a kernel does more slowly than this it loses to something else.

use crate::glam::{UVec2, Vec3, Vec4};
use crate::kernels::store_rgb;
use crate::uniform::Uniform;

/// Multiply-adds one after the other.
const ROUNDS: u32 = 256;

/// Operations of a pixel: a product and a sum for each of eight numbers that do not wait for each other.
pub const OPERATIONS: u32 = 2 * 8 * ROUNDS;

/// Kernel `multiply_adds`: a pixel that only takes time.
#[inline]
pub fn multiply_adds_pixel(uniform: &Uniform, output: &mut [u32], pixel: UVec2, variant: u32) {
    // Below 1, so that the sums stay finite, and not known when the kernel is compiled.
    let factor = Vec4::splat(1.0 / (uniform.exposure + 1.0));
    let start = pixel.x as f32;
    let mut a = Vec4::new(start, start + 1.0, start + 2.0, start + 3.0);
    let mut b = a + Vec4::splat(4.0);
    let mut round = 0;
    while round < ROUNDS {
        a = a * factor + factor;
        b = b * factor + factor;
        round += 1;
    }
    let sum = a + b;
    store_rgb(uniform, output, pixel, Vec3::new(sum.x + sum.w, sum.y, sum.z), variant);
}
