//! From a pixel to the direction it looks in.

use crate::glam::{Vec2, Vec3, Vec4};
use crate::math::{PI, abs, acos, clamp, max, safe_sqrt, sin_cos, sqrt};
use bytemuck::{Pod, Zeroable};

/// Whole sphere: columns are azimuths with the camera's azimuth in the centre, rows are elevations from the zenith
/// down.
pub const EQUIRECTANGULAR: u32 = 0;
/// Equidistant fisheye: the distance from the centre of the inscribed circle is proportional to the angle.
pub const FISHEYE: u32 = 1;
/// Pinhole camera.
pub const PERSPECTIVE: u32 = 2;
/// Whole sphere: the octahedron around it, unfolded to a square, with the zenith in the centre, the horizon on the
/// diamond between the middles of the sides, the nadir in the corners, and the camera's azimuth on top.
pub const OCTAHEDRAL: u32 = 3;

/// A camera at the observer. The layout is that of a GPU buffer.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Camera {
    /// Unit vector to the right of the image; `w`: how far right of the forward direction a perspective has its middle,
    /// on the plane at unit distance.
    pub right: Vec4,
    /// Unit vector to the top of the image; `w`: how far above it, likewise.
    pub up: Vec4,
    /// Unit vector into the image; `w` unused.
    pub forward: Vec4,
    /// Width of the whole image (pixels).
    pub width: u32,
    /// Height of the whole image (pixels).
    pub height: u32,
    /// Fisheye: half the angle across the circle (radians). Perspective: tangent of half the horizontal field of view.
    pub half_field: f32,
    /// Unused; fills the last 16 bytes.
    pub padding: u32,
}

/// The direction of a pixel, and whether the projection covers the pixel at all.
#[derive(Clone, Copy)]
pub struct PixelView {
    /// Unit vector; the forward direction where the pixel is not covered.
    pub direction: Vec3,
    /// False outside a fisheye's circle.
    pub covered: bool,
}

/// The view through the centre of the pixel at (`column`, `row`), counted from the top left, in the projection
/// [`EQUIRECTANGULAR`], [`FISHEYE`], [`PERSPECTIVE`] or [`OCTAHEDRAL`].
#[inline(always)]
pub fn pixel_view(camera: &Camera, projection: u32, column: u32, row: u32) -> PixelView {
    position_view(camera, projection, Vec2::new(column as f32 + 0.5, row as f32 + 0.5))
}

/// The view through a position of the image, in pixels from its top left corner.
#[inline(always)]
pub fn position_view(camera: &Camera, projection: u32, position: Vec2) -> PixelView {
    let size = Vec2::new(camera.width as f32, camera.height as f32);
    if projection == EQUIRECTANGULAR {
        PixelView { direction: equirectangular(camera, position / size), covered: true }
    } else if projection == OCTAHEDRAL {
        PixelView { direction: octahedral(camera, position / size), covered: true }
    } else {
        let from_centre = Vec2::new(position.x - 0.5 * size.x, 0.5 * size.y - position.y);
        if projection == FISHEYE {
            let diameter = if size.x < size.y { size.x } else { size.y };
            fisheye(camera, from_centre * (2.0 / diameter))
        } else {
            PixelView { direction: perspective(camera, from_centre * (2.0 / size.x)), covered: true }
        }
    }
}

/// Solid angle per area of the image at a position (pixels from the top left corner), to a factor that is one for the
/// whole image: cos(elevation), sin(θ)/θ or cos³(θ), with θ the angle from the forward direction; of an octahedron (|x|
/// + |y| + |z|)³.
#[inline(always)]
pub fn solid_angle_density(camera: &Camera, projection: u32, position: Vec2) -> f32 {
    let direction = position_view(camera, projection, position).direction;
    let forward = Vec3::new(camera.forward.x, camera.forward.y, camera.forward.z);
    let cosine = direction.dot(forward);
    if projection == EQUIRECTANGULAR {
        sqrt(direction.x * direction.x + direction.y * direction.y)
    } else if projection == OCTAHEDRAL {
        let sum = abs(cosine) + abs(direction.dot(camera.right.truncate())) + abs(direction.z);
        sum * sum * sum
    } else if projection == FISHEYE {
        let angle = acos(clamp(cosine, -1.0, 1.0));
        if angle > 1e-3 { safe_sqrt(1.0 - cosine * cosine) / angle } else { 1.0 }
    } else {
        cosine * cosine * cosine
    }
}

/// `position` in [0, 1]² from the top left. Azimuth grows to the right, clockwise from the camera's.
#[inline(always)]
fn equirectangular(camera: &Camera, position: Vec2) -> Vec3 {
    let (sin_azimuth, cos_azimuth) = sin_cos((position.x - 0.5) * 2.0 * PI);
    let (sin_elevation, cos_elevation) = sin_cos(elevation(position.y));
    let level = camera.forward * (cos_elevation * cos_azimuth) + camera.right * (cos_elevation * sin_azimuth);
    let up = camera.up * sin_elevation;
    Vec3::new(level.x + up.x, level.y + up.y, level.z + up.z)
}

/// `position` in [0, 1]² from the top left.
#[inline(always)]
fn octahedral(camera: &Camera, position: Vec2) -> Vec3 {
    let (across, along) = (2.0 * position.x - 1.0, 1.0 - 2.0 * position.y);
    let up = 1.0 - abs(across) - abs(along);
    // Beyond the horizon the corners are folded back beneath the centre.
    let folded = max(-up, 0.0);
    let across = if across < 0.0 { across + folded } else { across - folded };
    let along = if along < 0.0 { along + folded } else { along - folded };
    let inverse_length = 1.0 / sqrt(across * across + along * along + up * up);
    let v = (camera.right * across + camera.forward * along + camera.up * up) * inverse_length;
    Vec3::new(v.x, v.y, v.z)
}

/// The elevation (radians) at a height of the image, in [0, 1] from its top.
#[inline(always)]
fn elevation(y: f32) -> f32 {
    (0.5 - y) * PI
}

/// The elevation (radians) that an equirectangular image has at a height (pixels from its top).
#[inline(always)]
pub fn equirectangular_elevation(camera: &Camera, y: f32) -> f32 {
    elevation(y / camera.height as f32)
}

/// `position` in units of the circle's radius.
#[inline(always)]
fn fisheye(camera: &Camera, position: Vec2) -> PixelView {
    let radius = sqrt(position.x * position.x + position.y * position.y);
    let covered = radius <= 1.0;
    let (sine, cosine) = sin_cos(if covered { radius * camera.half_field } else { 0.0 });
    // sin(θ)/ρ tends to the half field at the centre.
    let outward = if radius > 1e-6 { sine / radius } else { camera.half_field };
    let v = camera.forward * cosine + (camera.right * position.x + camera.up * position.y) * outward;
    let v = if covered { v } else { camera.forward };
    PixelView { direction: Vec3::new(v.x, v.y, v.z), covered }
}

/// `position` in units of half the image's width.
#[inline(always)]
fn perspective(camera: &Camera, position: Vec2) -> Vec3 {
    let plane = position * camera.half_field + middle(camera);
    let inverse_length = 1.0 / sqrt(1.0 + plane.x * plane.x + plane.y * plane.y);
    towards_plane(camera, plane) * inverse_length
}

/// The middle of a perspective image on the plane at unit distance.
#[inline(always)]
fn middle(camera: &Camera) -> Vec2 {
    Vec2::new(camera.right.w, camera.up.w)
}

/// Towards a place of the plane at unit distance, in that unit.
#[inline(always)]
fn towards_plane(camera: &Camera, plane: Vec2) -> Vec3 {
    let v = camera.forward + camera.right * plane.x + camera.up * plane.y;
    Vec3::new(v.x, v.y, v.z)
}

/// The direction at a position of a perspective image (pixels from its top left corner): a vector whose part into the
/// image is 1, so that it is linear in the position.
#[inline(always)]
pub fn perspective_vector(camera: &Camera, position: Vec2) -> Vec3 {
    let from_centre = Vec2::new(position.x - 0.5 * camera.width as f32, 0.5 * camera.height as f32 - position.y);
    towards_plane(camera, from_centre * (2.0 / camera.width as f32) * camera.half_field + middle(camera))
}

/// The change of [`perspective_vector`] from a pixel to the one on its right.
#[inline(always)]
pub fn perspective_step(camera: &Camera) -> Vec3 {
    let step = camera.right * (2.0 / camera.width as f32 * camera.half_field);
    Vec3::new(step.x, step.y, step.z)
}

/// The top of the image as it lies across a direction (a unit vector, or less where none is): the vertical in an image
/// of the whole sphere, and in others the camera's own, turned with the direction about the axis across both, as a lens
/// that is round carries it.
#[inline(always)]
pub fn top_of_image(camera: &Camera, projection: u32, direction: Vec3) -> Vec3 {
    let vector = |axis: Vec4| Vec3::new(axis.x, axis.y, axis.z);
    let (up, forward) = (vector(camera.up), vector(camera.forward));
    let along = up.dot(direction);
    if (projection == EQUIRECTANGULAR) | (projection == OCTAHEDRAL) {
        let across = up - direction * along;
        across * (1.0 / max(sqrt(across.dot(across)), 1e-10))
    } else {
        up - (forward + direction) * (along / max(1.0 + forward.dot(direction), 1e-6))
    }
}

/// Whether a direction may lie within an angle (radians, less than a quarter turn) of what a perspective sees: never
/// false where it does.
#[inline(always)]
pub fn is_within(camera: &Camera, direction: Vec3, angle: f32) -> bool {
    let (beyond, _) = sin_cos(angle);
    let along = |axis: Vec4| axis.x * direction.x + axis.y * direction.y + axis.z * direction.z;
    let (right, up, forward) = (along(camera.right), along(camera.up), along(camera.forward));
    let across = camera.half_field;
    let upright = camera.half_field * camera.height as f32 / camera.width as f32;
    let middle = middle(camera);
    // The distances from the planes of the image's edges.
    let within = |side: f32, edge: f32| edge * forward - side >= -beyond * sqrt(1.0 + edge * edge);
    within(right, across + middle.x)
        & within(-right, across - middle.x)
        & within(up, upright + middle.y)
        & within(-up, upright - middle.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks north and level.
    fn camera(width: u32, height: u32, half_field: f32) -> Camera {
        Camera {
            right: Vec4::new(0.0, -1.0, 0.0, 0.0),
            up: Vec4::new(0.0, 0.0, 1.0, 0.0),
            forward: Vec4::new(1.0, 0.0, 0.0, 0.0),
            width,
            height,
            half_field,
            padding: 0,
        }
    }

    #[test]
    fn every_covered_pixel_has_a_unit_direction() {
        for (projection, half_field) in
            [(EQUIRECTANGULAR, 0.0), (FISHEYE, PI / 2.0), (PERSPECTIVE, 1.0), (OCTAHEDRAL, 0.0)]
        {
            let camera = camera(64, 48, half_field);
            let mut covered = 0;
            for row in 0..48 {
                for column in 0..64 {
                    let view = pixel_view(&camera, projection, column, row);
                    covered += u32::from(view.covered);
                    // Six products and two polynomials, each rounded once.
                    assert!((view.direction.length() - 1.0).abs() < 1e-6);
                }
            }
            assert!(covered > 1000);
        }
    }

    #[test]
    fn an_equirectangular_image_has_north_in_the_centre_and_east_to_its_right() {
        let camera = camera(360, 180, 0.0);
        let east = pixel_view(&camera, EQUIRECTANGULAR, 269, 89).direction;
        assert!(east.y < -0.99, "{east}");
        assert!(pixel_view(&camera, EQUIRECTANGULAR, 180, 90).direction.x > 0.99);
        assert!(pixel_view(&camera, EQUIRECTANGULAR, 0, 0).direction.z > 0.99);
    }

    #[test]
    fn an_octahedron_is_unfolded_about_the_zenith() {
        let camera = camera(8, 8, 0.0);
        for (position, expected) in [
            ((4.0, 4.0), Vec3::Z),
            ((0.0, 0.0), Vec3::NEG_Z),
            ((8.0, 0.0), Vec3::NEG_Z),
            ((4.0, 0.0), Vec3::X),
            ((8.0, 4.0), Vec3::NEG_Y),
            ((6.0, 2.0), Vec3::new(1.0, -1.0, 0.0).normalize()),
            // The middles of a face above and of one below.
            ((5.0, 3.0), Vec3::new(0.25, -0.25, 0.5).normalize()),
            ((1.0, 7.0), Vec3::new(-0.25, 0.25, -0.5).normalize()),
        ] {
            let found = position_view(&camera, OCTAHEDRAL, position.into()).direction;
            // Products of single precision.
            assert!((found - expected).length() < 1e-6, "{position:?}: {found}");
        }
    }

    #[test]
    fn the_densities_of_an_octahedron_add_up_to_the_sphere() {
        let camera = camera(256, 256, 0.0);
        let pixels = (0..256).flat_map(|row| (0..256).map(move |column| Vec2::new(column as f32, row as f32)));
        let sum: f64 = pixels.map(|at| f64::from(solid_angle_density(&camera, OCTAHEDRAL, at + 0.5))).sum();
        // Of 4 units of area; the centres of pixels stand for them but for the square of their size.
        assert!((sum / 16384.0 - 4.0 * std::f64::consts::PI).abs() < 1e-3, "{sum}");
    }

    #[test]
    fn a_fisheye_covers_its_inscribed_circle_only() {
        let camera = camera(100, 60, PI / 2.0);
        assert!(!pixel_view(&camera, FISHEYE, 0, 0).covered);
        assert!(!pixel_view(&camera, FISHEYE, 10, 30).covered);
        assert!(pixel_view(&camera, FISHEYE, 21, 30).covered);
    }

    #[test]
    fn what_a_perspective_sees_is_within_any_angle_of_it_and_what_lies_farther_is_not() {
        let camera = camera(64, 32, 30f32.to_radians().tan());
        for (column, row) in (0..32).flat_map(|row| (0..64).map(move |column| (column, row))) {
            assert!(is_within(&camera, pixel_view(&camera, PERSPECTIVE, column, row).direction, 0.0));
        }
        // 30° to the side the picture ends, and 16.1° above its middle; behind the camera nothing is seen.
        let towards = |azimuth: f32, elevation: f32| {
            let ((across, along), (up, level)) = (sin_cos(azimuth.to_radians()), sin_cos(elevation.to_radians()));
            Vec3::new(level * along, level * across, up)
        };
        for (azimuth, elevation, beyond) in
            [(40.0, 0.0, 10.0f32), (-40.0, 0.0, 10.0), (0.0, 26.1, 10.0), (0.0, -26.1, 10.0)]
        {
            let within = |degrees: f32| is_within(&camera, towards(azimuth, elevation), degrees.to_radians());
            assert!(within(beyond + 0.1) && !within(beyond - 0.1), "{azimuth}°, {elevation}°");
        }
        assert!(!is_within(&camera, towards(180.0, 0.0), 0.5));
    }

    #[test]
    fn a_quarter_of_a_picture_is_a_picture_whose_middle_lies_aside() {
        let whole = camera(64, 32, 1.0);
        // The upper right one, whose middle is half a side from the whole one's.
        let mut quarter = camera(32, 16, 0.5);
        (quarter.right.w, quarter.up.w) = (0.5, 0.25);
        for (column, row) in (0..16).flat_map(|row| (0..32).map(move |column| (column, row))) {
            let direction = pixel_view(&quarter, PERSPECTIVE, column, row).direction;
            assert!((direction - pixel_view(&whole, PERSPECTIVE, column + 32, row).direction).length() < 1e-6);
            assert!(is_within(&quarter, direction, 0.0));
            for (beside, above) in [(0, 0), (0, 16), (32, 16)] {
                let other = pixel_view(&whole, PERSPECTIVE, column + beside, row + above).direction;
                assert!(!is_within(&quarter, other, 0.0));
            }
        }
    }

    #[test]
    fn a_perspective_image_spans_its_horizontal_field() {
        let camera = camera(1000, 500, 30f32.to_radians().tan());
        let edge = pixel_view(&camera, PERSPECTIVE, 999, 250).direction;
        let azimuth = (-edge.y).atan2(edge.x).to_degrees();
        // The centre of the last pixel lies half a pixel inside the 30° edge.
        assert!((azimuth - 30.0).abs() < 0.05, "{azimuth}");
    }
}
