//! The air before a camera on a device: froxels, filled from a table of the sky, and applied to an image.
//!
//! What the air before a distance adds and lets through depends on the direction alone, whoever looks. A table has it
//! at the directions of a [`MultipleLookup`] and at `n` distances from the observer,
//!
//! ```text
//! d_k = m w_k² / (1 - w_k²)     w_k = k / (n - 1)     w = √(d / (d + m))
//! ```
//!
//! from 0 to infinity; half of them lie within a third of the middle `m`. Light is kept by its constituents, before
//! their phase functions. A froxel has those of its own direction.
//!
//! A froxel of a column, a row and a slice is what lies up to the slice's distance in a direction of the image, whose
//! edges are the first and the last columns and rows. At the parts `(x, y)` of the image, from its top left corner, and
//! at a distance a texture of `c × r × n` texels is therefore read at
//!
//! ```text
//! ((x (c - 1) + ½) / c, (y (r - 1) + ½) / r, (w (n - 1) + ½) / n)
//! ```
//!
//! Straight lines go between columns and rows, cubics between slices: at 20 km by day and in twilight at 80 km slices
//! lie so far apart that straight lines leave 3 to 4 % of the brightest.
//!
//! The last slice is the sky. What the table lacks of it there, `S - A`, is found in the sky lookup, and nearer slices
//! take `w⁸` of it: with `w⁴`, from 20 km in late dusk, the bright limb puts 4 % of their brightest before near air.
//!
//! Near the sun an aerosol's phase function changes between two froxels by more than straight lines can follow. There a
//! pixel's light comes from the table, with the phase functions of its own direction.

use bytemuck::{Pod, Zeroable};

use crate::camera::{Camera, PERSPECTIVE, perspective_vector, position_view};
use crate::glam::{Vec2, Vec3, Vec4};
use crate::interpolation::cubic::{Stencil, lane, stencil};
use crate::light_field::multiple_lookup::{MultipleLookup, place_at};
use crate::math::{clamp, fetch, max, sqrt, to_half};
use crate::medium::phase::ScatteringAngle;
use crate::picture::lookup::{grid_constituents, grid_place};
use crate::sky::{Constituents, cosine_from_sun, with_phases};
use crate::uniform::Uniform;
use crate::variant;

/// Columns and rows of a volume that a workgroup fills along each side. The entry point repeats it as a literal, which
/// a test compares.
pub const VOLUME_SIDE: u32 = 8;

/// Slices of a volume that an invocation fills.
pub const SLICES_TOGETHER: u32 = 4;

/// Numbers of a node of the table, times four: air, aerosol and the rest of the light, each with a channel of what is
/// let through.
pub const NODE: u32 = 3;

/// A volume, and the table from which it is filled. The layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Froxels {
    /// The directions of the table; its groups are the slices.
    pub directions: MultipleLookup,
    /// Columns of the volume.
    pub columns: u32,
    /// Rows of the volume.
    pub rows: u32,
    /// Factor from the table's light to that of the volume.
    pub scale: f32,
    /// `1 - cos θ` of the angle `θ` from the sun below which a pixel has phase functions of its own.
    pub near_sun: f32,
}

impl Froxels {
    /// The direction of a column and a row of the volume, in a camera's image.
    #[inline(always)]
    pub fn view(&self, camera: &Camera, column: u32, row: u32) -> Vec3 {
        let part = Vec2::new(column as f32 / (self.columns - 1) as f32, row as f32 / (self.rows - 1) as f32);
        let position = part * Vec2::new(camera.width as f32, camera.height as f32);
        position_view(camera, PERSPECTIVE, position).direction
    }

    /// The part of a pixel's light, from 0 to 1, that has the phase functions of its own direction: all within 0.7 of
    /// the angle, none beyond it.
    #[inline(always)]
    pub fn own_phases(&self, uniform: &Uniform, place: VolumePlace, variant: u32) -> f32 {
        if variant & variant::AEROSOL == 0 {
            return 0.0;
        }
        let from_sun = 1.0 - place.view.dot(uniform.sun.truncate());
        clamp(2.0 * (self.near_sun - from_sun) / max(self.near_sun, 1e-12), 0.0, 1.0)
    }
}

/// What the air up to a distance adds, before its phase functions, and the part of sunlight that it lets through.
#[derive(Clone, Copy)]
pub struct Before {
    /// Linear RGB by constituents.
    pub light: Constituents,
    /// The part in each channel.
    pub transmittance: Vec3,
}

impl Before {
    /// As a node of the table holds it.
    #[inline]
    pub fn node(self) -> [Vec4; NODE as usize] {
        let Self { light, transmittance } = self;
        [light.air.extend(transmittance.x), light.aerosol.extend(transmittance.y), light.rest.extend(transmittance.z)]
    }
}

/// A direction of the image among those of the table.
#[derive(Clone, Copy)]
pub struct AirRay {
    angle: ScatteringAngle,
    /// The first of sixteen nodes, at its first slice.
    first: u32,
    down: Vec4,
    across: Vec4,
    /// What the table lacks of the sky.
    missing: Constituents,
}

impl AirRay {
    /// That of a unit vector.
    #[inline(always)]
    pub fn new(
        uniform: &Uniform,
        froxels: &Froxels,
        table: &[Vec4],
        lookup: &[Vec4],
        view: Vec3,
        variant: u32,
    ) -> Self {
        let grid = froxels.directions;
        let place = place_at(grid, view.z, cosine_from_sun(uniform, view));
        let (first_row, rows) = if place.is_above { (0, grid.above) } else { (grid.above, grid.below) };
        let (down, across) = (stencil(place.row, rows), stencil(place.column, grid.azimuths));
        let mut ray = Self {
            angle: ScatteringAngle::between(view, uniform.sun.truncate()),
            first: ((first_row + down.first) * grid.azimuths + across.first) * grid.groups,
            down: down.weights,
            across: across.weights,
            missing: Constituents::DARK,
        };
        if place.is_above & (uniform.lookup_azimuths > 0) {
            let sky = grid_constituents(uniform, lookup, grid_place(uniform, view, variant), variant);
            let own = ray.in_table(froxels, table, grid.groups - 1).light;
            ray.missing =
                Constituents { air: sky.air - own.air, aerosol: sky.aerosol - own.aerosol, rest: sky.rest - own.rest };
        }
        ray
    }

    /// What the table has of it up to a slice.
    #[inline(always)]
    fn in_table(&self, froxels: &Froxels, table: &[Vec4], slice: u32) -> Before {
        let grid = froxels.directions;
        let (mut air, mut aerosol, mut rest) = (Vec4::ZERO, Vec4::ZERO, Vec4::ZERO);
        let mut row = 0;
        while row < 4 {
            let mut column = 0;
            while column < 4 {
                let node = self.first + (row * grid.azimuths + column) * grid.groups + slice;
                let weight = lane(self.down, row) * lane(self.across, column);
                let at = (NODE * node) as usize;
                air += fetch(table, at) * weight;
                aerosol += fetch(table, at + 1) * weight;
                rest += fetch(table, at + 2) * weight;
                column += 1;
            }
            row += 1;
        }
        let light = Constituents {
            air: air.truncate() * froxels.scale,
            aerosol: aerosol.truncate() * froxels.scale,
            rest: rest.truncate() * froxels.scale,
        };
        Before { light, transmittance: Vec3::new(air.w, aerosol.w, rest.w) }
    }

    /// What lies up to a slice; the last one is the sky.
    #[inline(always)]
    fn before(&self, froxels: &Froxels, table: &[Vec4], slice: u32) -> Before {
        let Before { light, transmittance } = self.in_table(froxels, table, slice);
        let w = slice as f32 / (froxels.directions.groups - 1) as f32;
        let part = (w * w) * (w * w) * ((w * w) * (w * w));
        let light = Constituents {
            air: light.air + self.missing.air * part,
            aerosol: light.aerosol + self.missing.aerosol * part,
            rest: light.rest + self.missing.rest * part,
        };
        Before { light, transmittance }
    }

    /// Linear RGB that the air up to a slice adds (W·m⁻²·sr⁻¹), and the part that it lets through, as half floats.
    #[inline(always)]
    pub fn froxel(
        &self,
        uniform: &Uniform,
        froxels: &Froxels,
        table: &[Vec4],
        slice: u32,
        variant: u32,
    ) -> (Vec3, Vec3) {
        let Before { light, transmittance } = self.before(froxels, table, slice);
        let rgb = with_phases(uniform, light, self.angle, variant);
        (halves(rgb), halves(transmittance))
    }

    /// Linear RGB that the air before a pixel's place adds (W·m⁻²·sr⁻¹).
    #[inline(always)]
    pub fn light_before(
        &self,
        uniform: &Uniform,
        froxels: &Froxels,
        table: &[Vec4],
        place: VolumePlace,
        variant: u32,
    ) -> Vec3 {
        let mut sum = Constituents::DARK;
        let mut index = 0;
        while index < 4 {
            let Before { light, .. } = self.before(froxels, table, place.deep.first + index);
            let weight = lane(place.deep.weights, index);
            sum.air += light.air * weight;
            sum.aerosol += light.aerosol * weight;
            sum.rest += light.rest * weight;
            index += 1;
        }
        with_phases(uniform, sum, self.angle, variant)
    }
}

/// The half floats nearest to a colour.
#[inline(always)]
pub fn halves(rgb: Vec3) -> Vec3 {
    Vec3::new(to_half(rgb.x), to_half(rgb.y), to_half(rgb.z))
}

/// A depth that a projection makes of the distance along the camera's axis.
pub const PROJECTED: u32 = 0;
/// A depth along the camera's axis.
pub const ALONG_AXIS: u32 = 1;
/// A depth along the pixel's ray.
pub const ALONG_RAY: u32 = 2;

/// An image to which a volume is applied, and what its depth means. The layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SeenThrough {
    /// The camera of the image and of the volume.
    pub camera: Camera,
    /// [`PROJECTED`], [`ALONG_AXIS`] or [`ALONG_RAY`].
    pub kind: u32,
    /// Of a projected depth `D`: `offset + slope D` is the inverse of the distance along the axis (km⁻¹). Of another
    /// one the distance is `slope D` (km).
    pub offset: f32,
    /// See `offset`.
    pub slope: f32,
    /// The depth of the sky, and of what lies behind it.
    pub sky: f32,
    /// 1 where depth falls with the distance, 0 where it grows.
    pub is_reversed: u32,
    /// The middle of the distances (km).
    pub middle: f32,
    /// Unused; fills the last 16 bytes.
    pub padding: Vec2,
    /// Columns, rows and slices of the volume; `w` unused.
    pub size: Vec4,
}

/// Where a pixel stands in a volume.
#[derive(Clone, Copy)]
pub struct VolumePlace {
    /// Whether nothing stands before the sky.
    pub is_sky: bool,
    /// The unit vector of the pixel's view.
    pub view: Vec3,
    /// Where the texture is read across and down, from 0 to 1.
    across: Vec2,
    /// The four slices about it.
    deep: Stencil,
    /// All slices.
    slices: f32,
}

impl VolumePlace {
    /// Where the texture is read in one of four slices, counted from 0, from 0 to 1 along each side; and the weight of
    /// what is read there.
    #[inline(always)]
    pub fn slice(&self, index: u32) -> (Vec3, f32) {
        let depth = ((self.deep.first + index) as f32 + 0.5) / self.slices;
        (self.across.extend(depth), lane(self.deep.weights, index))
    }
}

impl SeenThrough {
    /// Where a pixel of a depth stands. A depth that is no number is the sky's, and one behind the camera is 0 km away.
    #[inline(always)]
    pub fn place(&self, column: u32, row: u32, depth: f32) -> VolumePlace {
        let position = Vec2::new(column as f32 + 0.5, row as f32 + 0.5);
        let vector = perspective_vector(&self.camera, position);
        let length = sqrt(vector.dot(vector));
        let is_behind_sky = if self.is_reversed != 0 { depth <= self.sky } else { depth >= self.sky };
        // Whether it is finite, of which a device knows by its bits alone.
        let is_number = (depth.to_bits() & 0x7fff_ffff) < 0x7f80_0000;
        // d/(d + m), without a distance that overflows.
        let along = if self.kind == PROJECTED {
            let inverse = max(self.offset + self.slope * depth, 0.0);
            length / (length + self.middle * inverse)
        } else {
            let longer = if self.kind == ALONG_AXIS { length } else { 1.0 };
            let distance = max(self.slope * depth, 0.0) * longer;
            distance / (distance + self.middle)
        };
        let part = position / Vec2::new(self.camera.width as f32, self.camera.height as f32);
        let (size, slices) = (Vec2::new(self.size.x, self.size.y), self.size.z);
        VolumePlace {
            is_sky: is_behind_sky | !is_number,
            view: vector / length,
            across: (part * (size - Vec2::ONE) + Vec2::splat(0.5)) / size,
            deep: stencil(sqrt(along) * (slices - 1.0), slices as u32),
            slices,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(kind: u32, offset: f32, slope: f32, sky: f32, is_reversed: u32) -> SeenThrough {
        let camera = Camera {
            right: Vec4::new(0.0, -1.0, 0.0, 0.0),
            up: Vec4::new(0.0, 0.0, 1.0, 0.0),
            forward: Vec4::new(1.0, 0.0, 0.0, 0.0),
            width: 4,
            height: 2,
            half_field: 1.0,
            padding: 0,
        };
        let size = Vec4::new(8.0, 5.0, 33.0, 0.0);
        SeenThrough { camera, kind, offset, slope, sky, is_reversed, middle: 25.0, padding: Vec2::ZERO, size }
    }

    /// Where a place stands in the texture: a cubic keeps a straight line.
    fn coordinate(place: VolumePlace) -> Vec3 {
        (0..4).map(|index| place.slice(index)).fold(Vec3::ZERO, |sum, (coordinate, weight)| sum + coordinate * weight)
    }

    /// The distance of a place in the volume (km).
    fn distance(place: VolumePlace) -> f32 {
        let w = (coordinate(place).z * 33.0 - 0.5) / 32.0;
        25.0 * w * w / (1.0 - w * w)
    }

    #[test]
    fn every_kind_of_depth_is_the_same_distance_along_the_ray() {
        // 12 km along the axis; near and far planes at 0.1 m and 50 km.
        let (near, far, z) = (1e-4f32, 50.0f32, 12.0f32);
        let slope = 1.0 / near - 1.0 / far;
        let reversed = (1.0 / z - 1.0 / far) / slope;
        let forward = 1.0 - reversed;
        let length = sqrt(1.0 + 0.75 * 0.75 + 0.25 * 0.25);
        for (seen, depth, tolerance) in [
            (seen(PROJECTED, 0.0, 1.0 / near, 0.0, 1), near / z, 1e-5),
            (seen(PROJECTED, 1.0 / far, slope, 0.0, 1), reversed, 1e-5),
            // A step of such a depth near 1 is 6e-8, of which 1e4 make 6e-4/km against 1/12 km: why depth is reversed.
            (seen(PROJECTED, 1.0 / near, -slope, 1.0, 0), forward, 2e-2),
            (seen(ALONG_AXIS, 0.0, 1e-3, 1e10, 0), 1000.0 * z, 1e-5),
            (seen(ALONG_RAY, 0.0, 1e-3, 1e10, 0), 1000.0 * z * length, 1e-5),
        ] {
            let place = seen.place(3, 0, depth);
            assert!(!place.is_sky);
            // The others: a root and a quotient of single precision, where 1 - w² loses a digit.
            let found = distance(place) / (z * length) - 1.0;
            assert!(found.abs() < tolerance, "{}: {found}", seen.kind);
        }
    }

    #[test]
    fn the_sky_is_what_a_cleared_buffer_holds_and_what_is_no_number() {
        let reversed = seen(PROJECTED, 0.0, 1e4, 0.0, 1);
        let forward = seen(PROJECTED, 1e4, -1e4, 1.0, 0);
        let linear = seen(ALONG_AXIS, 0.0, 1e-3, 1e10, 0);
        for (seen, sky, near) in [(reversed, 0.0, 1.0), (forward, 1.0, 0.0), (linear, 1e10, 0.0)] {
            for depth in [sky, f32::NAN, f32::INFINITY] {
                assert!(seen.place(0, 0, depth).is_sky, "{depth}");
            }
            let place = seen.place(0, 0, near);
            assert!(!place.is_sky);
            assert!((0.0..=1.0).contains(&coordinate(place).z), "{}", coordinate(place));
        }
        let behind = linear.place(0, 0, -5.0);
        // Half a texel: the first slice.
        assert!(!behind.is_sky && (coordinate(behind).z - 0.5 / 33.0).abs() < 1e-6);
    }

    #[test]
    fn the_corners_of_an_image_are_half_a_texel_inside_of_a_volume_but_for_half_a_pixel() {
        let seen = seen(ALONG_RAY, 0.0, 1.0, 1e10, 0);
        let [first, last] = [(0, 0), (3, 1)].map(|(column, row)| coordinate(seen.place(column, row, 1.0)));
        // The centre of the first pixel is 1/8 and 1/4 of the image from its edges.
        assert!((first - Vec3::new((7.0 / 8.0 + 0.5) / 8.0, (4.0 / 4.0 + 0.5) / 5.0, first.z)).length() < 1e-6);
        assert!((last - Vec3::new(1.0 - first.x, 1.0 - first.y, first.z)).length() < 1e-6);
    }
}
