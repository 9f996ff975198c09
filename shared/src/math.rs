//! Elementary functions that mean the same on the CPU and on the GPU.
//!
//! This is the one file that asks for the target. On SPIR-V the functions become GLSL.std.450 instructions; on the
//! CPU they are branch-free code that the compiler vectorises.

use crate::glam::Vec4;

/// Element `index` of a buffer; `index` must lie inside it.
///
/// On the GPU the access is not checked by a branch, which would cost more than the kernel: drivers that wgpu accepts
/// bound buffer accesses themselves. On the CPU, where every kernel's indices are tested, it panics.
#[inline(always)]
pub fn fetch<T: Copy>(buffer: &[T], index: usize) -> T {
    #[cfg(target_arch = "spirv")]
    // SAFETY: callers derive `index` from the buffer's own length or size, and the device bounds buffer accesses.
    #[expect(unsafe_code, reason = "a bounds check is a branch around every load")]
    unsafe {
        *spirv_std::arch::IndexUnchecked::index_unchecked(buffer, index)
    }
    #[cfg(not(target_arch = "spirv"))]
    buffer[index]
}

/// Stores `value` as element `index` of a buffer; see [`fetch`].
#[inline(always)]
pub fn store<T: Copy>(buffer: &mut [T], index: usize, value: T) {
    #[cfg(target_arch = "spirv")]
    // SAFETY: as in `fetch`.
    #[expect(unsafe_code, reason = "a bounds check is a branch around every store")]
    unsafe {
        *spirv_std::arch::IndexUnchecked::index_unchecked_mut(buffer, index) = value;
    }
    #[cfg(not(target_arch = "spirv"))]
    {
        buffer[index] = value;
    }
}

/// Element `index` of an array, as those that the invocations of a workgroup share; see [`fetch`].
#[inline]
pub fn fetch_in<T: Copy, const N: usize>(array: &[T; N], index: usize) -> T {
    #[cfg(target_arch = "spirv")]
    // SAFETY: as in `fetch`.
    #[expect(unsafe_code, reason = "a bounds check is a branch around every load")]
    unsafe {
        *spirv_std::arch::IndexUnchecked::index_unchecked(array, index)
    }
    #[cfg(not(target_arch = "spirv"))]
    array[index]
}

/// Stores `value` as element `index` of an array; see [`fetch_in`].
#[inline]
pub fn store_in<T: Copy, const N: usize>(array: &mut [T; N], index: usize, value: T) {
    #[cfg(target_arch = "spirv")]
    // SAFETY: as in `fetch`.
    #[expect(unsafe_code, reason = "a bounds check is a branch around every store")]
    unsafe {
        *spirv_std::arch::IndexUnchecked::index_unchecked_mut(array, index) = value;
    }
    #[cfg(not(target_arch = "spirv"))]
    {
        array[index] = value;
    }
}

/// `π` in single precision.
pub const PI: f32 = core::f32::consts::PI;

/// The larger of two numbers; with a NaN the result is unspecified.
#[inline(always)]
pub fn max(a: f32, b: f32) -> f32 {
    #[cfg(target_arch = "spirv")]
    return libm::fmaxf(a, b);
    #[cfg(not(target_arch = "spirv"))]
    return if a > b { a } else { b };
}

/// The smaller of two numbers; with a NaN the result is unspecified.
#[inline(always)]
pub fn min(a: f32, b: f32) -> f32 {
    #[cfg(target_arch = "spirv")]
    return libm::fminf(a, b);
    #[cfg(not(target_arch = "spirv"))]
    return if a < b { a } else { b };
}

/// `x` limited to `[low, high]`.
#[inline(always)]
pub fn clamp(x: f32, low: f32, high: f32) -> f32 {
    min(max(x, low), high)
}

/// The square root of `x`, and 0 for the slightly negative `x` that rounding leaves.
#[inline(always)]
pub fn safe_sqrt(x: f32) -> f32 {
    sqrt(max(x, 0.0))
}

/// The square root of `x >= 0`.
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(target_arch = "spirv")]
    return libm::sqrtf(x);
    #[cfg(not(target_arch = "spirv"))]
    return x.sqrt();
}

/// The largest integer not above `x`.
#[inline(always)]
pub fn floor(x: f32) -> f32 {
    #[cfg(target_arch = "spirv")]
    return libm::floorf(x);
    #[cfg(not(target_arch = "spirv"))]
    return x.floor();
}

/// Arguments of [`exp`] below this give 0 to within 2e-38.
const EXP_MIN: f32 = -87.0;
/// Arguments of [`exp`] above this give the largest value it knows, `e^88`.
const EXP_MAX: f32 = 88.0;

/// `e^x`, with `x` limited to `[-87, 88]` so that the result is finite and never denormal; see [`exp4`].
#[inline(always)]
pub fn exp(x: f32) -> f32 {
    #[cfg(target_arch = "spirv")]
    return libm::expf(clamp(x, EXP_MIN, EXP_MAX));
    #[cfg(not(target_arch = "spirv"))]
    return exp4(Vec4::splat(x)).x;
}

/// `e^x` for each band, with `x` limited to `[-87, 88]` so that the result is finite and never denormal.
///
/// On the CPU: Cody-Waite reduction to `|r| <= ln 2 / 2` and the polynomial of Cephes' `expf` (Moshier 1992), relative
/// error below 2e-7. On the GPU: the `Exp` instruction, (3 + 2|x|) ULP by the Vulkan specification.
#[inline(always)]
pub fn exp4(x: Vec4) -> Vec4 {
    #[cfg(target_arch = "spirv")]
    return Vec4::new(exp(x.x), exp(x.y), exp(x.z), exp(x.w));
    #[cfg(not(target_arch = "spirv"))]
    {
        // Adding 1.5·2²³ rounds to an integer that then sits in the low bits of the sum.
        const ROUND: Vec4 = Vec4::splat(12_582_912.0);
        let x = x.max(Vec4::splat(EXP_MIN)).min(Vec4::splat(EXP_MAX));
        let shifted = x * core::f32::consts::LOG2_E + ROUND;
        let n = shifted - ROUND;
        let r = (x - n * 0.693_359_4) - n * -2.121_944_4e-4;
        let polynomial =
            horner([1.987_569_1e-4, 1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 5.000_000_1e-1], r);
        let mantissa = polynomial * (r * r) + r + Vec4::ONE;
        let bits: [u32; 4] = bytemuck::cast(shifted);
        let power_of_two = bits.map(|bits| f32::from_bits((bits << 23).wrapping_add(1.0f32.to_bits())));
        mantissa * Vec4::from_array(power_of_two)
    }
}

/// [`exp4`] of any number of values, in a loop that a compiler spreads over as many lanes as there are.
#[cfg(not(target_arch = "spirv"))]
#[inline(always)]
pub fn exp_lanes(values: &mut [f32]) {
    // As in `exp4`, step by step.
    const ROUND: f32 = 12_582_912.0;
    const COEFFICIENTS: [f32; 5] = [1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 5.000_000_1e-1];
    for value in values {
        let x = min(max(*value, EXP_MIN), EXP_MAX);
        let shifted = x * core::f32::consts::LOG2_E + ROUND;
        let n = shifted - ROUND;
        let r = (x - n * 0.693_359_4) - n * -2.121_944_4e-4;
        let mut polynomial = 1.987_569_1e-4;
        for coefficient in COEFFICIENTS {
            polynomial = polynomial * r + coefficient;
        }
        let mantissa = polynomial * (r * r) + r + 1.0;
        *value = mantissa * f32::from_bits((shifted.to_bits() << 23).wrapping_add(1.0f32.to_bits()));
    }
}

/// `ln x` for each band, of a normal `x > 0`.
///
/// On the CPU: `x = m 2ⁿ` with `√½ <= m < √2` and the polynomial of Cephes' `logf` (Moshier 1992), error below 1.2e-7
/// of the result. On the GPU: the `Log` instruction, 3 ULP by the Vulkan specification, and 2⁻²¹ for `x` between 1/2
/// and 2.
#[inline(always)]
pub fn ln4(x: Vec4) -> Vec4 {
    Vec4::new(ln(x.x), ln(x.y), ln(x.z), ln(x.w))
}

/// `ln x` of as many normal `x > 0` as there are; see [`ln4`].
#[inline(always)]
pub fn ln_lanes(values: &mut [f32]) {
    for value in values {
        *value = ln(*value);
    }
}

/// `ln x` of a normal `x > 0`; see [`ln4`].
#[inline(always)]
pub fn ln(x: f32) -> f32 {
    #[cfg(target_arch = "spirv")]
    return libm::logf(x);
    #[cfg(not(target_arch = "spirv"))]
    {
        const SQRT_HALF: i32 = core::f32::consts::FRAC_1_SQRT_2.to_bits() as i32;
        const COEFFICIENTS: [f32; 8] = [
            -1.151_461_03e-1,
            1.167_699_87e-1,
            -1.242_014_08e-1,
            1.424_932_28e-1,
            -1.666_805_77e-1,
            2.000_071_48e-1,
            -2.499_999_4e-1,
            3.333_333_12e-1,
        ];
        let bits = x.to_bits() as i32;
        let exponent = (bits - SQRT_HALF) >> 23;
        let (n, r) = (exponent as f32, f32::from_bits((bits - (exponent << 23)) as u32) - 1.0);
        let mut polynomial = 7.037_683_6e-2;
        for coefficient in COEFFICIENTS {
            polynomial = polynomial * r + coefficient;
        }
        let r2 = r * r;
        let low = polynomial * r * r2 + n * -2.121_944_4e-4 - r2 * 0.5;
        r + low + n * 0.693_359_4
    }
}

/// `x^y`, where `x` below 1e-37, zero among them, counts as 1e-37.
///
/// On the CPU `e^(y ln x)`, whose relative error is that of [`exp`] and 1.2e-7 of `y ln x`. On the GPU the `Pow`
/// instruction, which is undefined for what is left out here.
#[inline(always)]
pub fn pow(x: f32, y: f32) -> f32 {
    /// A little above the smallest normal number.
    const SMALLEST: f32 = 1e-37;
    let base = max(x, SMALLEST);
    #[cfg(target_arch = "spirv")]
    return libm::powf(base, y);
    #[cfg(not(target_arch = "spirv"))]
    return exp(y * ln(base));
}

/// The polynomial with these coefficients, that of the highest power first.
#[cfg(not(target_arch = "spirv"))]
#[inline(always)]
fn horner<const N: usize>(coefficients: [f32; N], x: Vec4) -> Vec4 {
    let highest = Vec4::splat(coefficients[0]);
    coefficients[1..].iter().fold(highest, |sum, &coefficient| sum * x + Vec4::splat(coefficient))
}

/// `|x|`.
#[inline(always)]
pub fn abs(x: f32) -> f32 {
    if x < 0.0 { -x } else { x }
}

/// The square root of `x >= 0` in each lane.
#[inline(always)]
pub fn sqrt4(x: Vec4) -> Vec4 {
    Vec4::new(sqrt(x.x), sqrt(x.y), sqrt(x.z), sqrt(x.w))
}

/// The larger of `x` and `low` in each lane.
#[inline(always)]
pub fn max4(x: Vec4, low: f32) -> Vec4 {
    #[cfg(target_arch = "spirv")]
    return Vec4::new(max(x.x, low), max(x.y, low), max(x.z, low), max(x.w, low));
    #[cfg(not(target_arch = "spirv"))]
    return x.max(Vec4::splat(low));
}

/// The sine and the cosine of `x` in radians, for `|x| <= 2π`, to an absolute error of 2e-7 on every device.
///
/// The GPU's own instructions are only good to 2⁻¹¹ by the Vulkan specification, too coarse for a direction. The
/// polynomials are those of Cephes' `sinf` and `cosf` (Moshier 1992) on `|r| <= π/4`.
#[inline(always)]
pub fn sin_cos(x: f32) -> (f32, f32) {
    let quadrant = floor(x * core::f32::consts::FRAC_2_PI + 0.5);
    // π/2 in two parts, so that the subtraction is exact for the few quadrants allowed.
    let r = (x - quadrant * 1.570_312_5) - quadrant * 4.838_268e-4;
    let r2 = r * r;
    let sine = ((-1.951_529_6e-4 * r2 + 8.332_161e-3) * r2 - 1.666_665_5e-1) * r2 * r + r;
    let cosine = ((2.443_315_7e-5 * r2 - 1.388_731_6e-3) * r2 + 4.166_664_6e-2) * r2 * r2 - 0.5 * r2 + 1.0;
    let turn = quadrant - 4.0 * floor(quadrant * 0.25);
    if turn < 0.5 {
        (sine, cosine)
    } else if turn < 1.5 {
        (cosine, -sine)
    } else if turn < 2.5 {
        (-sine, -cosine)
    } else {
        (-cosine, sine)
    }
}

/// The angle in `[0, π]` whose cosine is `x`, to 4.5e-7 radians on every device.
///
/// Hastings' polynomial (Abramowitz and Stegun 1964, 4.4.46). The GPU's own instruction is only good to 4096 ULP.
#[inline(always)]
pub fn acos(x: f32) -> f32 {
    let y = min(if x < 0.0 { -x } else { x }, 1.0);
    let angle = acos_beside(y, 1.0 - y);
    if x < 0.0 { PI - angle } else { angle }
}

/// The same of a cosine `y` in `[0, 1]`, and of `1 - y` with all its digits: a small angle has as many.
#[inline(always)]
pub fn acos_beside(y: f32, from_one: f32) -> f32 {
    let high = ((-1.262_491_1e-3 * y + 6.670_09e-3) * y - 1.708_812_6e-2) * y + 3.089_188_1e-2;
    let polynomial = (((high * y - 5.017_430_5e-2) * y + 8.897_899e-2) * y - 2.145_988e-1) * y + 0.5 * PI;
    sqrt(from_one) * polynomial
}

/// The angle of the point (`x`, `y`) in `[0, 2π]`, counted from the axis of `x` towards that of `y`, to 7e-7 radians on
/// every device; 0 for the origin.
///
/// Hastings' polynomial of the arctangent of at most 1 (Abramowitz and Stegun 1964, 4.4.49). The GPU's own instruction
/// is only good to 4096 ULP.
#[inline(always)]
pub fn angle_of(x: f32, y: f32) -> f32 {
    let (width, height) = (abs(x), abs(y));
    let t = min(width, height) / max(max(width, height), 1e-37);
    let t2 = t * t;
    let high = ((2.866_225_7e-3 * t2 - 1.616_573_67e-2) * t2 + 4.290_961_38e-2) * t2 - 7.528_964e-2;
    let low = ((high * t2 + 1.065_626_393e-1) * t2 - 1.420_889_944e-1) * t2 + 1.999_355_085e-1;
    let octant = ((low * t2 - 3.333_314_528e-1) * t2 + 1.0) * t;
    let quadrant = if height > width { 0.5 * PI - octant } else { octant };
    let half = if x < 0.0 { PI - quadrant } else { quadrant };
    if y < 0.0 { 2.0 * PI - half } else { half }
}

/// The bits of the half float nearest to `x >= 0` (IEEE 754 binary16, ties to even); beyond its largest number, 65504,
/// that.
#[inline(always)]
pub fn half_bits(x: f32) -> u32 {
    const LARGEST: f32 = 65504.0;
    /// 2⁻¹⁴: below this the exponent stays and the step is 2⁻²⁴.
    const SMALLEST_NORMAL: f32 = 6.103_515_6e-5;
    let x = clamp(x, 0.0, LARGEST);
    if x < SMALLEST_NORMAL {
        // The sum has its last digit at 2⁻²⁴, so the addition itself rounds.
        (x + 0.5).to_bits() - 0.5f32.to_bits()
    } else {
        let bits = x.to_bits();
        let rounded = bits + 0xfff + ((bits >> 13) & 1);
        (rounded >> 13) - ((127 - 15) << 10)
    }
}

/// The half float nearest to `x >= 0`, as a single one: what a device that cuts off digits then stores is rounded.
#[inline(always)]
pub fn to_half(x: f32) -> f32 {
    const LARGEST: f32 = 65504.0;
    let bits = clamp(x, 0.0, LARGEST).to_bits();
    f32::from_bits((bits + 0xfff + ((bits >> 13) & 1)) & 0xffff_e000)
}

/// `a + (b - a) t`.
#[inline(always)]
pub fn mix(a: Vec4, b: Vec4, t: f32) -> Vec4 {
    a + (b - a) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_was_rounded_to_a_half_float_has_no_digits_to_cut_off() {
        for i in 0..200_000u32 {
            let x = 6.2e-5 * exp(i as f32 * 1e-4);
            let rounded = to_half(x);
            // Down to 2⁻¹⁴ a half float has ten digits behind the first.
            assert_eq!((half_bits(rounded), rounded.to_bits() & 0x1fff), (half_bits(x), 0), "{x}");
        }
        assert_eq!([to_half(0.0), to_half(1.0), to_half(1e6)], [0.0, 1.0, 65504.0]);
    }

    #[test]
    fn exponential_is_accurate_over_its_whole_range() {
        let mut worst: f64 = 0.0;
        for i in 0..=1_750_000 {
            let x = -87.0 + i as f32 * 1e-4;
            let truth = f64::from(x).exp();
            worst = worst.max((f64::from(exp(x)) / truth - 1.0).abs());
        }
        // One rounding of the reduction, one of the polynomial and one of the product: 3 half ULPs of 2⁻²⁴.
        assert!(worst < 2e-7, "{worst:e}");
    }

    #[test]
    fn exponentials_of_many_are_those_of_four() {
        for i in 0..2000 {
            let x: [f32; 8] = std::array::from_fn(|k| -100.0 + 0.1 * (i as f32 + 0.125 * k as f32));
            let [low, high] = [0, 4].map(|at| exp4(Vec4::from_slice(&x[at..])).to_array());
            let mut many = x;
            exp_lanes(&mut many);
            assert_eq!(many.map(f32::to_bits), std::array::from_fn(|k| [low, high][k / 4][k % 4].to_bits()));
        }
    }

    #[test]
    fn logarithm_is_accurate_over_its_whole_range() {
        let mut worst: f64 = 0.0;
        for i in 0..=1_750_000 {
            let x = (-87.0 + f64::from(i) * 1e-4).exp() as f32;
            for x in [x, 1.0 + (x - 1.0) * 1e-3] {
                let truth = f64::from(x).ln();
                worst = worst.max((f64::from(ln4(Vec4::splat(x)).x) - truth).abs() / truth.abs().max(1e-30));
            }
        }
        // Two half ULPs of 2⁻²⁴: the sum of the last two terms, and what is small beside them.
        assert!(worst < 1.2e-7, "{worst:e}");
    }

    #[test]
    fn exponential_saturates_instead_of_overflowing() {
        assert!(exp(-1e30) < 2e-38 && exp(-1e30) > 0.0);
        assert!(exp(1e30) > 1e38 && exp(1e30).is_finite());
    }

    #[test]
    fn half_floats_are_the_nearest() {
        let value = |bits: u32| {
            let (exponent, fraction) = ((bits >> 10) as i32, f64::from(bits & 0x3ff));
            if exponent == 0 { fraction * 2f64.powi(-24) } else { (1.0 + fraction / 1024.0) * 2f64.powi(exponent - 15) }
        };
        for bits in 0..0x7bff {
            let (low, high) = (value(bits), value(bits + 1));
            for part in [0.0, 0.2, 0.49, 0.51, 0.8] {
                let x = low + part * (high - low);
                let expected = if part < 0.5 { bits } else { bits + 1 };
                assert_eq!(half_bits(x as f32), expected, "{x:e}");
            }
        }
        assert_eq!(half_bits(1e9), 0x7bff);
    }

    #[test]
    fn arccosine_is_accurate_over_its_whole_range() {
        for i in -100_000..=100_000 {
            let x = i as f32 * 1e-5;
            // Two roundings near π, half a ULP of 2.4e-7 each, and the polynomial.
            assert!((f64::from(acos(x)) - f64::from(x).acos()).abs() < 4.5e-7, "{x}");
        }
        assert_eq!(acos(1.1), 0.0);
    }

    #[test]
    fn powers_are_accurate_and_never_of_zero() {
        for i in -400..=400 {
            let x = (f64::from(i) * 0.05).exp() as f32;
            for y in [0.42, 1.0 / 0.42, 1.15, -0.5] {
                let truth = f64::from(x).powf(f64::from(y));
                let tolerance = 2e-7 + 2e-7 * (f64::from(y) * f64::from(x).ln()).abs();
                assert!((f64::from(pow(x, y)) / truth - 1.0).abs() < tolerance, "{x}^{y}");
            }
        }
        assert!(pow(0.0, 0.42) < 1e-15 && pow(-1.0, 0.42) >= 0.0);
    }

    #[test]
    fn angles_are_accurate_over_a_whole_turn() {
        for i in 0..100_000 {
            let angle = f64::from(i) * 6.2831e-5;
            let (x, y) = ((3.0 * angle.cos()) as f32, (3.0 * angle.sin()) as f32);
            let truth = f64::from(y).atan2(f64::from(x)).rem_euclid(2.0 * std::f64::consts::PI);
            // One rounding near 2π of 2.4e-7, one near π of 1.2e-7, 1.7e-7 and 0.9e-7 of these numbers, and the
            // polynomial.
            assert!((f64::from(angle_of(x, y)) - truth).abs() < 7e-7, "{angle}");
        }
        assert_eq!(angle_of(0.0, 0.0), 0.0);
    }

    #[test]
    fn sine_and_cosine_are_accurate_over_two_turns() {
        for i in -62_832..=62_832 {
            let x = i as f32 * 1e-4;
            let (sine, cosine) = sin_cos(x);
            // Two ULPs of 1: the reduction and the polynomial each round once.
            assert!((f64::from(sine) - f64::from(x).sin()).abs() < 2.4e-7, "sin {x}");
            assert!((f64::from(cosine) - f64::from(x).cos()).abs() < 2.4e-7, "cos {x}");
        }
    }
}
