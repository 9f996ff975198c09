//! What a kernel is specialised for: the bits of one constant.
//!
//! A GPU pipeline is compiled for one value, and the compiler drops what the scene does not need; nothing of it is decided per
//! pixel. On the CPU the value is the same for every pixel, and the branches on it are always predicted.

/// There is aerosol.
pub const AEROSOL: u32 = 1;
/// There is ozone.
pub const OZONE: u32 = 2;
/// What the exponential profiles hold above the top of the atmosphere is not negligible.
pub const ABOVE_TOP: u32 = 4;
/// A ray can meet the planet's shadow.
pub const SHADOW: u32 = 8;
/// A ray can descend: the observer stands above the ground.
pub const DESCENT: u32 = 16;
/// The sun can stand below the horizon of a point on a ray.
pub const LOW_SUN: u32 = 32;

/// The sun's disc is shown.
pub const SUN_DISC: u32 = 64;

/// The air is opaque along some rays: the columns of short stretches are sums of their own.
pub const OPAQUE: u32 = 128;
/// Everything that concerns the integral; right for every scene.
pub const WHOLE_INTEGRAL: u32 = 63 | OPAQUE;

/// Pixels are looked up in runs of [`crate::sky_table::RUN`], which share their entries: only in an equirectangular image whose width is a
/// multiple of that, and where the entries lie so much farther apart that a run reaches hardly beyond them.
pub const RUNS: u32 = 1 << 12;

/// Where the projection stands.
const PROJECTION_SHIFT: u32 = 8;
/// Where the kind of pixel stands.
const PIXEL_SHIFT: u32 = 10;

/// The projection of a variant: one of those in [`crate::camera`].
#[inline]
pub fn projection(variant: u32) -> u32 {
    (variant >> PROJECTION_SHIFT) & 3
}

/// The kind of pixel of a variant: a [`crate::frame::Pixel`].
#[inline]
pub fn pixel(variant: u32) -> u32 {
    (variant >> PIXEL_SHIFT) & 3
}

/// The variant for an integral, a projection and a kind of pixel.
#[inline]
pub fn of(integral: u32, projection: u32, pixel: u32) -> u32 {
    integral | (projection << PROJECTION_SHIFT) | (pixel << PIXEL_SHIFT)
}
