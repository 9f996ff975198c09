//! A camera as engines have it: from a view and a projection matrix.

use sorairo_shared::glam::{DMat3, DMat4, DVec2, DVec3};

use super::camera::{CameraScene, Projection, Size};
use crate::error::{Error, Result};

/// How far from a right angle the sides of an image may lie, as a cosine: what single precision leaves of matrices.
const SKEW: f64 = 1e-4;

impl CameraScene {
    /// The axes of a world of which y is up, x east and -z north: bevy, Godot, three.js, glTF.
    pub const Y_UP: DMat3 = DMat3::from_cols(DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X);
    /// The axes of a world of which z is up, x east and y north: Blender, local coordinates of maps.
    pub const Z_UP: DMat3 = DMat3::from_cols(DVec3::NEG_Y, DVec3::X, DVec3::Z);

    /// The perspective camera of an engine's matrices for an image of some size, with everything else at its default.
    ///
    /// `view` takes the world to the camera and `projection` the camera to clip space, in which x points to the right
    /// of the image and y to its top. Near and far planes, reversed and infinite ones too, do not matter; off-centre
    /// and jittered projections become [`Self::shift_x`] and [`Self::shift_y`]. A program that has their product alone
    /// passes it as the projection with [`DMat4::IDENTITY`] as the view; that is the inverse of an inverse
    /// view-projection matrix.
    ///
    /// The columns of `axes` are the world's x, y and z in x north, y west, z up: [`Self::Y_UP`], [`Self::Z_UP`], or
    /// those at the observer on a round planet. Of a left-handed world they are left-handed. Where the camera stands
    /// does not matter: the observer of the sky has an altitude alone, of which the length of the place from the
    /// planet's centre less its radius is `observer.altitude` (km).
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] for matrices that are no perspective's, such as a singular or an orthographic one, for a
    /// picture that is mirrored or skewed, and for pixels that are not square.
    pub fn from_matrices(view: DMat4, projection: DMat4, axes: DMat3, size: Size) -> Result<Self> {
        let clip = projection * view;
        // Where clip space is (x, y, 1) the direction is linear in x and y, wherever the camera stands.
        let rows = [0, 1, 3].map(|row| clip.row(row).truncate());
        let seen = axes * DMat3::from_cols_array_2d(&rows.map(|row| row.to_array())).transpose().inverse();
        if !seen.is_finite() {
            return Err(refused("is no perspective: directions do not follow from it"));
        }
        let (right, up) = (seen.x_axis.normalize_or_zero(), seen.y_axis.normalize_or_zero());
        let forward = up.cross(right).normalize_or_zero();
        let distance = forward.dot(seen.z_axis);
        if right.dot(up).abs() > SKEW || distance == 0.0 {
            return Err(refused("is no perspective of a flat image with a right angle between its sides"));
        }
        if distance < 0.0 {
            return Err(refused("mirrors the picture: y of its clip space points up, and axes are those of the world"));
        }
        let half = [seen.x_axis, seen.y_axis].map(|side| side.length() / distance);
        let rows = f64::from(size.width) * half[1] / half[0];
        if (rows - f64::from(size.height)).abs() > 1.0 {
            return Err(refused(&format!(
                "is of {rows:.1} rows of {} square pixels, and the size is {size}",
                size.width
            )));
        }
        let (azimuth, elevation, roll) = turned(forward, right);
        let [shift_x, shift_y] = [right, up].map(|axis| axis.dot(seen.z_axis) / distance / (2.0 * half[0]));
        Ok(Self {
            projection: Projection::Perspective,
            size,
            fov: Some(2.0 * half[0].atan().to_degrees()),
            look_azimuth: Some(azimuth),
            look_elevation: Some(elevation),
            roll,
            shift_x,
            shift_y,
            ..Self::default()
        })
    }
}

/// Azimuth, elevation and roll (degrees) of a view and what lies right of it.
fn turned(forward: DVec3, right: DVec3) -> (f64, f64, f64) {
    // Straight up or down any azimuth does, with the roll that belongs to it.
    let level = forward.truncate().try_normalize().unwrap_or(DVec2::X);
    let beside = DVec3::new(level.y, -level.x, 0.0);
    let elevation = forward.z.atan2(forward.truncate().length());
    let roll = (-right.dot(beside.cross(forward))).atan2(right.dot(beside));
    ((-level.y).atan2(level.x).to_degrees(), elevation.to_degrees(), roll.to_degrees())
}

fn refused(complaint: &str) -> Error {
    Error::not_allowed("projection", complaint)
}
