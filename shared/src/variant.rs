//! What a kernel is specialised for: the bits of one constant.
//!
//! A GPU pipeline is compiled for one value, and the compiler drops what the scene does not need; nothing of it is
//! decided per pixel. On the CPU the value is the same for every pixel, and the branches on it are always predicted.

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
/// The air is opaque along some rays: column densities of short stretches are sums of their own.
pub const OPAQUE: u32 = 128;
/// Everything that concerns the integral of light scattered once; right for every scene without tables.
pub const WHOLE_INTEGRAL: u32 = 63 | OPAQUE;
/// Densities and column densities come from tables; see [`crate::medium::tables`].
pub const TABLES: u32 = 1 << 30;
/// The phase function of aerosol comes from a table; see [`crate::medium::phase::tabulated_phase`].
pub const PHASE_TABLE: u32 = 1 << 31;
/// Everything that concerns what fills the air and where light goes.
pub const INTEGRAL: u32 = WHOLE_INTEGRAL | TABLES;

/// Pixels are looked up in runs, which share what they read: only in images whose width is a multiple of a run; see
/// [`crate::picture::run`] and [`crate::picture::perspective_run`].
pub const RUNS: u32 = 1 << 12;

/// There is light that was scattered more than once.
pub const MULTIPLE: u32 = 1 << 13;
/// The ground reflects light, and is seen.
pub const GROUND: u32 = 1 << 14;
/// There is light beside that which air and aerosol scatter once.
pub const REST: u32 = MULTIPLE | GROUND;

/// The bytes of a picture are dithered.
pub const DITHER: u32 = 1 << 15;

/// A regression fit has more than four bands.
pub const MORE_THAN_FOUR: u32 = 1 << 16;
/// A regression fit has more than eight bands; [`MORE_THAN_FOUR`] holds too.
pub const MORE_THAN_EIGHT: u32 = 1 << 17;
/// How many bands a regression fit has.
pub const BANDS: u32 = MORE_THAN_FOUR | MORE_THAN_EIGHT;

/// The fit is the regression, separately for each constituent of the light; see
/// [`crate::fit::spectrum::regression_rgb`]. Without this bit it is linear in the transfer: solve, observer sum and
/// XYZ→RGB (Eqs. 4-8) are one matrix, whose rows for red, green and blue are the colour rows of each group of four
/// bands.
pub const REGRESSION: u32 = 1 << 18;
/// The fit has four bands, and its 4×4 system is solved at every pixel. Without [`REGRESSION`] this is the paper's
/// mathematics, step by step (Eqs. 4-8): the cubic through four bands, its sum over the observer nodes in the colour
/// rows, XYZ→RGB.
pub const SOLVED: u32 = 1 << 19;
/// The fit: everything that its choice decides.
pub const FIT: u32 = BANDS | REGRESSION | SOLVED;

/// The lookup of light that was scattered more than once is so fine that straight lines do between its entries.
pub const REFINED: u32 = 1 << 22;

/// Of a pixel that is looked up, which has no use of [`REFINED`]: a polariser stands before the lens; see
/// [`crate::picture::polariser`].
pub const POLARISER: u32 = REFINED;

/// A pixel holds a spectrum beside its colour; see [`crate::spectral`].
pub const SPECTRUM: u32 = 1 << 20;
/// A pixel holds the radiance at every band and no colour. This is where the paper's own GPU part ends.
pub const AT_BANDS: u32 = 1 << 21;
/// A pixel holds light by wavelength, beside its colour or in its place.
pub const LIGHT: u32 = SPECTRUM | AT_BANDS;

/// Those bits of [`BANDS`] that hold for so many bands.
#[inline]
pub fn of_bands(bands: usize) -> u32 {
    let more_than_four = if bands > 4 { MORE_THAN_FOUR } else { 0 };
    let more_than_eight = if bands > 8 { MORE_THAN_EIGHT } else { 0 };
    more_than_four | more_than_eight
}

/// The view transform of a picture is AgX; see [`crate::display::agx`]. Without a view transform what is brighter than
/// 1 is cut.
pub const AGX: u32 = 1 << 23;
/// It is that of ACES 2.0; see [`crate::display::aces`].
pub const ACES: u32 = 1 << 24;

/// Where what an image shows below the horizon stands.
const BELOW_SHIFT: u32 = 28;
/// What an image shows below the horizon; see [`below`].
pub const BELOW: u32 = 3 << BELOW_SHIFT;
/// A picture's display has the primaries of Display P3. Without this bit and the next it is one of sRGB.
pub const DISPLAY_P3: u32 = 1 << 25;
/// It has those of Rec. 2020.
pub const REC2020: u32 = 1 << 26;
/// A picture shows a dark sky as an eye sees it; see [`crate::display::night`].
pub const NIGHT: u32 = 1 << 27;
/// What few pictures have.
pub const SELDOM: u32 = DISPLAY_P3 | REC2020 | NIGHT;

/// Where the projection stands.
const PROJECTION_SHIFT: u32 = 8;
/// Where the format of pixels stands.
pub(crate) const PIXEL_FORMAT_SHIFT: u32 = 10;

/// What decides how a pixel of an image lies and is stored.
pub const IMAGE: u32 = (15 << PROJECTION_SHIFT) | BELOW;

/// How a pixel of the sky is stored.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFormat {
    /// Three `f32` words: linear RGB.
    LinearRgb = 0,
    /// One word: 8 bit sRGB, exposed, red in the lowest byte.
    Picture = 1,
    /// Two words: linear RGB as half floats, red and green, then blue and 1: a texel of `rgba16float`.
    HalfRgb = 2,
    /// Four `f32` words: linear RGB and 1, a texel of `rgba32float`. No file has it.
    LinearRgba = 3,
}

impl PixelFormat {
    /// Words of a pixel without light.
    pub fn black(self) -> &'static [u32] {
        /// 1 as a half float, in the upper half of a word.
        const HALF_ONE: u32 = 0x3c00 << 16;
        match self {
            Self::LinearRgb => &[0, 0, 0],
            Self::Picture => &[0xff00_0000],
            Self::HalfRgb => &[0, HALF_ONE],
            Self::LinearRgba => &[0, 0, 0, 0x3f80_0000],
        }
    }

    /// Words that a pixel takes.
    pub const fn words(self) -> u32 {
        match self {
            Self::LinearRgb => 3,
            Self::Picture => 1,
            Self::HalfRgb => 2,
            Self::LinearRgba => 4,
        }
    }
}

/// The count of the groups of four bands: a number that the compiler knows, where the fit tells it.
#[inline(always)]
pub fn group_count(groups: usize, variant: u32) -> usize {
    if variant & MORE_THAN_EIGHT != 0 {
        3
    } else if variant & MORE_THAN_FOUR != 0 {
        2
    } else if variant & (REGRESSION | SOLVED) != 0 {
        1
    } else {
        groups
    }
}

/// Whether a fit is the paper's cubic, solved at every pixel.
#[inline(always)]
pub fn is_solved_cubic(variant: u32) -> bool {
    variant & (REGRESSION | SOLVED) == SOLVED
}

/// The number of what a variant's image shows below the horizon, one of [`crate::picture::below`].
#[inline(always)]
pub fn below(variant: u32) -> u32 {
    (variant & BELOW) >> BELOW_SHIFT
}

/// The bits of such a number.
#[inline(always)]
pub fn of_below(below: u32) -> u32 {
    below << BELOW_SHIFT
}

/// The number of a variant's projection, one of the camera's.
#[inline(always)]
pub fn projection(variant: u32) -> u32 {
    (variant >> PROJECTION_SHIFT) & 3
}

/// The same variant with a projection.
#[inline(always)]
pub fn with_projection(variant: u32, projection: u32) -> u32 {
    variant & !(3 << PROJECTION_SHIFT) | (projection << PROJECTION_SHIFT)
}

/// The number of a variant's [`PixelFormat`].
#[inline(always)]
pub fn pixel_format(variant: u32) -> u32 {
    (variant >> PIXEL_FORMAT_SHIFT) & 3
}

/// The variant for an integral, a projection and a [`PixelFormat`].
#[inline(always)]
pub fn of(integral: u32, projection: u32, pixel_format: u32) -> u32 {
    integral | (projection << PROJECTION_SHIFT) | (pixel_format << PIXEL_FORMAT_SHIFT)
}
