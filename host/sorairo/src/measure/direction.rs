//! A direction of view.

use serde::Serialize;
use sorairo_shared::camera::{PixelView, pixel_view};
use sorairo_shared::glam::Vec3;
use sorairo_shared::variant;

use crate::azimuth::within_a_turn;
use crate::error::{Result, check_range};
use crate::plan::{Plan, Sky, direction, upload};
use crate::scene::ValidScene;

/// A direction of view. It is fully described by two angles, so its fields are public and exhaustive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Direction {
    /// Elevation above the horizontal plane (degrees, -90 to 90).
    #[serde(rename = "view_elevation")]
    pub elevation: f64,
    /// Azimuth, clockwise from north (degrees, any finite number).
    #[serde(rename = "view_azimuth")]
    pub azimuth: f64,
}

impl Direction {
    /// The direction with an elevation (degrees, -90 to 90) and an azimuth (degrees, clockwise from north). Functions
    /// that use it check both.
    pub const fn new(elevation: f64, azimuth: f64) -> Self {
        Self { elevation, azimuth }
    }

    /// The direction as a vector.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for an elevation out of range,
    /// [`Error::NotAllowed`](crate::Error::NotAllowed) for an azimuth that is not finite.
    pub fn vector(&self) -> Result<Vec3> {
        check_range("view_elevation", self.elevation, (-90.0, 90.0), "degrees")?;
        Ok(direction(self.elevation, within_a_turn("view_azimuth", self.azimuth)?).as_vec3())
    }

    /// The direction of a pixel's centre in a plan's image, with an azimuth from 0 to 360. Columns count from the left,
    /// rows from the top. `None` outside the projection.
    pub fn of_pixel(plan: &Plan, column: u32, row: u32) -> Option<Self> {
        Self::of_view(pixel_view(&plan.uniform.camera, variant::projection(plan.variant), column, row))
    }

    /// The same for a pixel of a scene's image, without a plan of its sky.
    pub fn of_scene_pixel(scene: &ValidScene, column: u32, row: u32) -> Option<Self> {
        let projection = upload::projection(scene.camera.projection);
        Self::of_view(pixel_view(&upload::camera(scene), projection, column, row))
    }

    pub(crate) fn of_view(PixelView { direction, covered }: PixelView) -> Option<Self> {
        let [north, west, up] = direction.to_array().map(f64::from);
        let elevation = up.clamp(-1.0, 1.0).asin().to_degrees();
        let azimuth = (-west).atan2(north).to_degrees().rem_euclid(360.0);
        covered.then_some(Self { elevation, azimuth })
    }
}

impl Sky {
    /// The direction of the sun's centre without refraction.
    /// [`Scene::apparent_elevation`](crate::Scene::apparent_elevation) is the refracted elevation.
    pub fn sun(&self) -> Direction {
        Direction::new(self.scene().sun.elevation, self.scene().sun.azimuth)
    }
}
