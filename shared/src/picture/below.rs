//! What an image shows below the horizon: the ground that is there, or something in its place.
//!
//! A map that lights a scene ends at a plane of the scene's own, beside which a flat ground of another colour leaves a
//! hard line. What stands in its place is the sky of another direction, flat ground, or a mixture of both, so that
//! nothing below the horizon is integrated. In a picture an edge of the ground is smooth: a pixel that the horizon
//! crosses has a part of either side, by its distance from the line (pixels).

use crate::camera::{
    Camera, EQUIRECTANGULAR, FISHEYE, OCTAHEDRAL, equirectangular_elevation, perspective_vector, pixel_view,
    position_view,
};
use crate::glam::{Vec2, Vec3};
use crate::math::{PI, acos, clamp, exp, floor, ln, max, min, pow, sin_cos, sqrt};
use crate::uniform::Uniform;
use crate::variant::{self, PixelFormat};

/// The ground that is there.
pub const GROUND: u32 = 0;
/// Ground of one colour; black, too.
pub const FLAT: u32 = 1;
/// The air at the horizon, which goes over into ground of one colour as haze does.
pub const FADE: u32 = 2;
/// The sky above the horizon, as still water would mirror it without a loss; the sun's disc is not mirrored, so that it
/// lights once.
pub const MIRROR: u32 = 3;

/// Rays this close to the horizon, in units of the horizon's own depression and of [`DEEP`] at most, stand for the
/// horizon itself, seen from above the ground: one side is sky, the other ground.
const HORIZON_MARGIN: f32 = 1e-3;

/// See [`HORIZON_MARGIN`] (radians).
const DEEP: f32 = 0.01;

/// The optical depth of the haze beneath an observer, horizontal and even, through which a fade shows the ground: that
/// of half a kilometre of air in which one sees 20 km. A ray that sinks by the angle `d` meets the ground behind an
/// optical depth of `HAZE / tan d`, and haze that is lit as the air at the horizon is puts the part `1 - T` of that
/// air's light before it, `T = exp(-HAZE / tan d)` (Koschmieder 1924). Where the horizon glows in twilight the haze at
/// one's feet does not, so a fade has a power of that part, with the phase functions of its own direction
/// ([`has_set`]): `L = (1 - p) L_ground + p L_horizon`, `p = (1 - T)^n`. It leaves the horizon without an edge. See
/// [`haze_power`].
const HAZE: f32 = 0.1;

/// So far below the horizon (radians) no haze is brighter than the ground.
const FADED_AT: f32 = 40.0 * PI / 180.0;

/// What a pixel shows: the sky in a direction, and before it ground of one colour.
#[derive(Clone, Copy)]
pub struct SkyView {
    /// Unit vector of which the phase functions are.
    pub direction: Vec3,
    /// Unit vector of whose air the light is: above the horizon but where the ground that is there is seen through air.
    pub source: Vec3,
    /// False outside a fisheye's circle.
    pub covered: bool,
    /// The row of an equirectangular image in which the direction lies.
    pub row: u32,
    /// The row in which the source lies.
    pub source_row: u32,
    /// The part of the pixel that is ground of one colour, in [0, 1].
    pub ground: f32,
}

/// Linear RGB of a pixel of sky, of which a part is ground of one colour.
#[inline(always)]
pub fn with_ground(uniform: &Uniform, sky: Vec3, part: f32) -> Vec3 {
    let ground = uniform.ground.truncate();
    if part >= 1.0 { ground } else { sky + (ground - sky) * part }
}

/// What a pixel of the whole image shows.
#[inline(always)]
pub fn sky_view(uniform: &Uniform, column: u32, row: u32, variant: u32) -> SkyView {
    let projection = variant::projection(variant);
    if projection == EQUIRECTANGULAR {
        let (row, source_row, ground) = rows_seen(uniform, row, variant);
        let direction = pixel_view(&uniform.camera, projection, column, row).direction;
        let mut source = direction;
        if variant::below(variant) == FADE {
            source = pixel_view(&uniform.camera, projection, column, source_row).direction;
        }
        return SkyView { direction, source, covered: true, row, source_row, ground };
    }
    let view = pixel_view(&uniform.camera, projection, column, row);
    let below = variant::below(variant);
    let is_picture = variant::pixel_format(variant) == PixelFormat::Picture as u32;
    let (direction, source, ground) = if is_picture & !is_there(variant) & ((below == GROUND) | (below == FLAT)) {
        direction_at_edge(uniform, centre(column, row), view.direction, variant)
    } else {
        direction_seen(uniform, view.direction, variant)
    };
    SkyView { direction, source, covered: view.covered, row, source_row: row, ground }
}

/// The rows of an equirectangular image of which one of its rows shows the direction and the source, and the part of
/// ground.
#[inline(always)]
fn rows_seen(uniform: &Uniform, row: u32, variant: u32) -> (u32, u32, f32) {
    let below = variant::below(variant);
    if is_there(variant) {
        return (row, row, 0.0);
    }
    let middle = row as f32 + 0.5;
    let depth = uniform.horizon - equirectangular_elevation(&uniform.camera, middle);
    if depth <= 0.0 {
        return (row, row, 0.0);
    }
    let horizon = (0.5 - uniform.horizon / PI) * uniform.camera.height as f32;
    let at_horizon = max(floor(horizon - 0.5), 0.0) as u32;
    let mirrored = max(floor(2.0 * horizon - middle), 0.0) as u32;
    if below == FADE {
        (if has_set(uniform) { mirrored } else { row }, at_horizon, faded(uniform, depth))
    } else if below == MIRROR {
        (mirrored, mirrored, 0.0)
    } else {
        (row, row, 1.0)
    }
}

/// The direction and the source of the sky that an image shows in a direction, and the part of ground before it.
#[inline(always)]
pub fn direction_seen(uniform: &Uniform, direction: Vec3, variant: u32) -> (Vec3, Vec3, f32) {
    let below = variant::below(variant);
    let (sine, _) = horizon(uniform, variant);
    if is_there(variant) | (direction.z >= sine) {
        (direction, direction, 0.0)
    } else if below == MIRROR {
        let mirrored = mirrored(uniform, direction);
        (mirrored, mirrored, 0.0)
    } else if below == FADE {
        let depth = uniform.horizon - (0.5 * PI - acos(clamp(direction.z, -1.0, 1.0)));
        let own = if has_set(uniform) { mirrored(uniform, direction) } else { direction };
        (own, beside_horizon(uniform, direction, margin(uniform)), faded(uniform, depth))
    } else {
        (direction, direction, 1.0)
    }
}

/// The same of a pixel in a picture, where the edge of flat ground is smooth.
#[inline(always)]
fn direction_at_edge(uniform: &Uniform, position: Vec2, direction: Vec3, variant: u32) -> (Vec3, Vec3, f32) {
    let (sine, _) = horizon(uniform, variant);
    let part = part_below(uniform, position, direction, variant);
    let is_sky = (direction.z < sine) & (part < 1.0);
    let sky = if is_sky { beside_horizon(uniform, direction, margin(uniform)) } else { direction };
    (sky, sky, part)
}

/// Whether the ground is seen through air, as it is there.
#[inline(always)]
fn is_there(variant: u32) -> bool {
    (variant::below(variant) == GROUND) & (variant & variant::DESCENT != 0)
}

/// The two directions beside the horizon, above it and below, of a pixel that it crosses, and the part below; none
/// elsewhere, and none but in pictures of ground that is seen through air.
#[inline(always)]
pub fn edge(uniform: &Uniform, column: u32, row: u32, direction: Vec3, variant: u32) -> (Vec3, Vec3, f32) {
    let is_picture = variant::pixel_format(variant) == PixelFormat::Picture as u32;
    if !is_picture | !is_there(variant) | (variant::projection(variant) == EQUIRECTANGULAR) {
        return (direction, direction, 0.0);
    }
    let part = part_below(uniform, centre(column, row), direction, variant);
    let margin = margin(uniform);
    (beside_horizon(uniform, direction, margin), beside_horizon(uniform, direction, -margin), part)
}

#[inline(always)]
fn centre(column: u32, row: u32) -> Vec2 {
    Vec2::new(column as f32 + 0.5, row as f32 + 0.5)
}

/// The part of a pixel below the horizon; all or nothing at the rim of a fisheye, which is an edge itself.
#[inline(always)]
fn part_below(uniform: &Uniform, position: Vec2, direction: Vec3, variant: u32) -> f32 {
    let (sine, cosine) = horizon(uniform, variant);
    if (variant::projection(variant) == FISHEYE) & is_at_rim(&uniform.camera, position) {
        return if direction.z < sine { 1.0 } else { 0.0 };
    }
    let above = (direction.z - sine) / gradient(&uniform.camera, position, sine, cosine, variant);
    clamp(0.5 - above, 0.0, 1.0)
}

/// Whether a position of a fisheye lies within a pixel of its circle.
#[inline(always)]
fn is_at_rim(camera: &Camera, position: Vec2) -> bool {
    let from_centre = position - Vec2::new(0.5 * camera.width as f32, 0.5 * camera.height as f32);
    let rim = 0.5 * if camera.width < camera.height { camera.width } else { camera.height } as f32 - 1.0;
    from_centre.dot(from_centre) > rim * rim
}

/// The change of the sine of the elevation from a pixel to the next, straight up from the horizon.
#[inline(always)]
fn gradient(camera: &Camera, position: Vec2, sine: f32, cosine: f32, variant: u32) -> f32 {
    if variant::projection(variant) == FISHEYE {
        let diameter = if camera.width < camera.height { camera.width } else { camera.height };
        return cosine * camera.half_field * 2.0 / diameter as f32;
    }
    if variant::projection(variant) == OCTAHEDRAL {
        let sines = |beside: Vec2| {
            let at = |offset: Vec2| position_view(camera, OCTAHEDRAL, position + offset).direction.z;
            at(beside) - at(-beside)
        };
        let (across, up) = (sines(Vec2::new(0.5, 0.0)), sines(Vec2::new(0.0, 0.5)));
        return max(sqrt(across * across + up * up), 1e-6);
    }
    let vector = perspective_vector(camera, position);
    let length = sqrt(vector.dot(vector));
    let along = |axis: Vec3| axis.z - sine * vector.dot(axis) / length;
    let (across, up) = (along(camera.right.truncate()), along(camera.up.truncate()));
    let pixel = camera.half_field * 2.0 / camera.width as f32;
    max(sqrt(across * across + up * up), 1e-6) * pixel / length
}

/// Sine and cosine of the horizon's elevation.
#[inline(always)]
fn horizon(uniform: &Uniform, variant: u32) -> (f32, f32) {
    if variant & variant::DESCENT == 0 { (0.0, 1.0) } else { sin_cos(uniform.horizon) }
}

/// The direction of the same azimuth that lies so far above the horizon (radians).
#[inline(always)]
fn beside_horizon(uniform: &Uniform, direction: Vec3, above: f32) -> Vec3 {
    let (sine, cosine) = sin_cos(uniform.horizon + above);
    let level = cosine / max(sqrt(direction.x * direction.x + direction.y * direction.y), 1e-10);
    Vec3::new(direction.x * level, direction.y * level, sine)
}

/// The direction as far above the horizon as one lies below it.
#[inline(always)]
fn mirrored(uniform: &Uniform, direction: Vec3) -> Vec3 {
    let (sine, cosine) = sin_cos(2.0 * uniform.horizon);
    let across = max(sqrt(direction.x * direction.x + direction.y * direction.y), 1e-10);
    let level = (cosine * across + sine * direction.z) / across;
    Vec3::new(direction.x * level, direction.y * level, sine * across - cosine * direction.z)
}

/// Whether the sun stands below the level. Haze in its direction would glow as if it shone there: a fade then has the
/// phase functions of the mirrored direction, in which it is as far away as from the horizon or farther.
#[inline(always)]
fn has_set(uniform: &Uniform) -> bool {
    uniform.sun.z < 0.0
}

/// The part of ground so far below the horizon (radians), before haze of a power; see [`HAZE`].
#[inline(always)]
fn faded(uniform: &Uniform, depth: f32) -> f32 {
    1.0 - pow(part_of_haze(depth), uniform.ground.w)
}

/// `1 - T` so far below the horizon (radians).
#[inline(always)]
fn part_of_haze(depth: f32) -> f32 {
    let (sine, cosine) = sin_cos(depth);
    1.0 - exp(-HAZE * max(cosine, 0.0) / max(sine, 1e-6))
}

/// The power of a fade's haze over ground that the brightest horizon outshines so many times: 1 at least.
pub fn haze_power(contrast: f32) -> f32 {
    clamp(ln(max(contrast, 1.0)) / -ln(part_of_haze(FADED_AT)), 1.0, 20.0)
}

/// What directions beside the horizon lie from it at least (radians), so that one side is sky and the other ground; 0
/// on the ground itself.
#[inline(always)]
pub fn margin(uniform: &Uniform) -> f32 {
    HORIZON_MARGIN * min(-uniform.horizon, DEEP)
}
