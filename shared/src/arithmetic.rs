//! The measure of arithmetic: multiply-adds alone, in registers. What a kernel does more slowly than this it loses to something else.

#[cfg(not(target_arch = "spirv"))]
use crate::block::lanes::{Three, ZERO, lanes};
use crate::glam::{UVec2, Vec3, Vec4};
use crate::kernels::store_rgb;
use crate::uniform::Uniform;

/// Multiply-adds one after the other.
const ROUNDS: u32 = 256;

/// Numbers of a pixel, which do not wait for each other.
const NUMBERS: usize = 8;

/// Operations of a pixel: a product and a sum for each number and round.
pub const OPERATIONS: u32 = 2 * NUMBERS as u32 * ROUNDS;

/// What every number is multiplied with, and what is added: below 1, so that the sums stay finite, and not known when the kernel is compiled.
#[inline(always)]
fn factor(uniform: &Uniform) -> f32 {
    1.0 / (uniform.exposure + 1.0)
}

/// Kernel `multiply_adds`: a pixel that only takes time.
#[inline]
pub fn multiply_adds_pixel(uniform: &Uniform, output: &mut [u32], pixel: UVec2, variant: u32) {
    let factor = Vec4::splat(factor(uniform));
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

/// The colours of a block of pixels from column `first` on, each as [`multiply_adds_pixel`] has it.
#[cfg(not(target_arch = "spirv"))]
#[inline(always)]
pub fn multiply_adds_of_block(uniform: &Uniform, first: u32, count: usize) -> Three {
    let factor = factor(uniform);
    let mut numbers = [ZERO; NUMBERS];
    for (number, values) in numbers.iter_mut().enumerate() {
        for lane in lanes(count) {
            values[lane] = (first + lane as u32) as f32 + number as f32;
        }
    }
    for _ in 0..ROUNDS {
        for values in &mut numbers {
            for lane in lanes(count) {
                values[lane] = values[lane] * factor + factor;
            }
        }
    }
    let mut colours = Three::ZERO;
    for lane in lanes(count) {
        let sum = |number: usize| numbers[number][lane] + numbers[number + 4][lane];
        colours.set(lane, Vec3::new(sum(0) + sum(3), sum(1), sum(2)));
    }
    colours
}
