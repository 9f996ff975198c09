//! What crosses the bus to a device: the uniform, and the buffers beside it.

use bytemuck::{Pod, Zeroable};

use crate::camera::Camera;
use crate::display::grade::Grade;
use crate::display::night::Eye;
use crate::display::rgb::RgbSpace;
use crate::glam::{Vec2, Vec4};
use crate::light_field::multiple_lookup::MultipleLookup;
use crate::medium::atmosphere::{Atmosphere, Medium};
use crate::medium::bands::Bands;
use crate::medium::phase::PHASE_ENTRIES;

/// Rows of observer nodes that the uniform has room for: the four of each of sixteen nodes of each of four
/// constituents.
pub const NODE_ROWS: usize = 256;

/// Everything that every pixel of a dispatch shares. The layout is that of a GPU uniform buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Uniform {
    /// Planet and profiles.
    pub atmosphere: Atmosphere,
    /// Camera and image size.
    pub camera: Camera,
    /// Unit vector to the sun; `w` unused.
    pub sun: Vec4,
    /// Unit vector along the ground to the sun's bearing; `z` and `w` are 0.
    pub bearing: Vec4,
    /// Wavelengths of the first four bands, mapped to [-1, 1] over the observer's range.
    pub band_wavelengths: Vec4,
    /// The space of linear RGB that pixels are stored in.
    pub rgb: RgbSpace,
    /// The sun's disc, where the variant has it.
    pub disc: SunDisc,
    /// How a picture is graded.
    pub grade: Grade,
    /// How an eye sees linear RGB, where the variant asks for it.
    pub eye: Eye,
    /// The lookup of light that was scattered more than once, where the variant has it.
    pub multiple: MultipleLookup,
    /// Linear RGB of the ground on which the observer stands (W·m⁻²·sr⁻¹), where the variant has it and no ray can
    /// descend; `w`: the power of a fade's haze.
    pub ground: Vec4,
    /// Altitude of the observer (km).
    pub altitude: f32,
    /// First row of the image that this dispatch computes.
    pub first_row: u32,
    /// Rows that this dispatch computes.
    pub rows: u32,
    /// Factor from linear RGB to a picture's linear value.
    pub exposure: f32,
    /// Observer nodes of a regression fit for each constituent of the light; 0 for other fits. In `node_rows` those of
    /// the constituents that there are follow each other in the order of [`crate::sky::ByConstituent`].
    pub nodes: u32,
    /// Rows of the sky lookup above the horizon; 0 without one. For an equirectangular image they are its own.
    pub lookup_above: u32,
    /// Rows of the sky lookup below the horizon, likewise; 0 from the ground itself, where nothing is seen there.
    pub lookup_below: u32,
    /// Columns of the sky lookup.
    pub lookup_azimuths: u32,
    /// Elevation of the horizon (radians): 0 on the ground, negative above it.
    pub horizon: f32,
    /// Wavelengths of a spectral image, which stand last in the colour rows; 0 for other images.
    pub spectral_wavelengths: u32,
    /// Pixels from the start of a row of the output to that of the next: the image's width, or more where rows are
    /// aligned.
    pub row_pixels: u32,
    /// 1 where every entry and anchor of the sky lookup is computed, for any camera; 0 where those are that this one
    /// can see.
    pub fills_whole_lookup: u32,
    /// From the horizon to the zenith, or from outside the atmosphere to its upper edge (radians): what the rows of the
    /// sky lookup above the horizon span.
    pub lookup_span: f32,
    /// Rows of the sky lookup's anchors above the horizon; 0 without a lookup. See [`crate::picture::lookup`].
    pub anchors_above: u32,
    /// Their rows below it.
    pub anchors_below: u32,
    /// Their columns.
    pub anchor_azimuths: u32,
    /// The rows of the observer nodes of a regression fit; see [`crate::fit::spectrum::regression_rgb`]. Every pixel
    /// reads all of them: a device that fetches for several pixels at a time knows of a uniform, and of no buffer, that
    /// all fetch the same.
    pub node_rows: [Vec4; NODE_ROWS],
    /// The polariser before the lens, where the variant has it.
    pub polariser: Polariser,
    /// How colours read the table of the aerosol's phase function, where the variant has one.
    pub cones: Cones,
    /// That table; see [`crate::medium::phase::tabulated_phase`].
    pub aerosol_phase: [Vec4; PHASE_ENTRIES],
}

/// Where the sun's disc is in the image, and its grid of colours. The layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SunDisc {
    /// Left edge of the bounding box (pixels from the image's left edge; an equirectangular image goes on beyond its
    /// sides).
    pub left: f32,
    /// Top edge (pixels from the image's top edge).
    pub top: f32,
    /// Right edge (pixels).
    pub right: f32,
    /// Bottom edge (pixels).
    pub bottom: f32,
    /// Sine of the disc's angular radius.
    pub sine_radius: f32,
    /// Sine of the elevation of the grid's first row.
    pub lowest: f32,
    /// Sine of the elevation of the grid's last row.
    pub highest: f32,
    /// Sine of the horizon's elevation, below which the ground hides the disc.
    pub horizon: f32,
    /// Unit vector to where the disc's centre is seen; `w`: by how much the disc is flattened, 1 for a round one.
    pub centre: Vec4,
    /// Where the grid begins in the colour rows.
    pub first_entry: u32,
    /// Samples along either side of a pixel's part of the box.
    pub samples: u32,
    /// Unused; fills the last 16 bytes.
    pub padding0: u32,
    /// Unused, too.
    pub padding1: u32,
}

/// The cone responses, in which colours read a table of a phase function; see [`crate::sky::scattered_by_aerosol`]. The
/// layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Cones {
    /// Where the long, middle and short cones read the table; `w` unused.
    pub abscissae: Vec4,
    /// Columns of the matrix from linear RGB to cone responses.
    pub from_rgb: [Vec4; 3],
    /// Columns of its inverse.
    pub to_rgb: [Vec4; 3],
}

/// A polariser, and where that stands which it reads beside the sky lookup; see
/// [`crate::picture::polariser`]. The layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Polariser {
    /// What passes of `I`, `Q` and `U` relative to the top of the image; `w` unused. 0 without a polariser.
    pub passes: Vec4,
    /// The lookup of light of higher orders: linear RGB of `Q`, then of `U` over the sine of the azimuth from the sun,
    /// relative to the vertical.
    pub lookup: MultipleLookup,
    /// Where the degrees of polarisation stand in the colour rows, for the cones where the variant has a table of the
    /// phase function, else for red, green and blue; the lookup's entries follow.
    pub first: u32,
    /// Unused; fills the last 16 bytes.
    pub padding0: u32,
    /// Unused, too.
    pub padding1: u32,
    /// Unused, too.
    pub padding2: u32,
}

/// The buffers from which a kernel integrates and fits.
#[derive(Clone, Copy)]
pub struct Buffers<'a> {
    /// Optical properties at the bands, four to a group.
    pub bands: &'a [Bands],
    /// Quadrature nodes: (place, weight) on [0, 1].
    pub quadrature: &'a [Vec2],
    /// The colour rows of a linear fit, as the fit takes them, then those of the wavelengths of a spectral image, or
    /// the tables of a view transform, what a polariser reads, and the grid of the sun's disc.
    pub colour: &'a [Vec4],
    /// The lookup of light that was scattered more than once; see [`crate::light_field::multiple_lookup`].
    pub multiple: &'a [Vec4],
    /// The tables of the medium; see [`crate::medium::tables`].
    pub columns: &'a [Vec4],
}

impl<'a> Buffers<'a> {
    /// What fills the air.
    #[inline(always)]
    pub fn medium(&self, uniform: &'a Uniform) -> Medium<'a> {
        Medium { atmosphere: &uniform.atmosphere, tables: self.columns }
    }
}
