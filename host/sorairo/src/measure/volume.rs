//! The air in front of a camera as a volume of froxels: in-scattered light and transmittance at a grid of directions
//! and distances, with interpolation between them.
//!
//! The grid has a ray at each of its points on the image; its first and last rows and columns are the edges of the
//! image. The distances along a ray are
//!
//! ```text
//! d_i = far (i / (slices - 1))²
//! ```
//!
//! The first is 0, with no in-scattered light and a transmittance of 1. Light is stored by constituent, and phase
//! functions are evaluated at the requested direction, so the aureole stays sharp. Cubics through four froxels
//! interpolate along each axis.

use rayon::prelude::*;
use sorairo_shared::camera::{Camera, PERSPECTIVE, position_view};
use sorairo_shared::glam::{Vec2, Vec3};
use sorairo_shared::interpolation::cubic::{Stencil, stencil};
use sorairo_shared::sky::Constituents;

use crate::error::{Error, Result, check_range};
use crate::input::shown;
use crate::measure::between_rgb::BetweenRgb;
use crate::plan::aerial::{AirColours, SlicedAir};
use crate::plan::{Sky, SkyPlan, upload};
use crate::scene::{CameraScene, ColourPath, Projection, Scene};
use crate::words::word;

/// The size of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeSize {
    /// Rays across the image (4 to 1024).
    pub columns: u32,
    /// Rays from its top to its bottom (4 to 1024).
    pub rows: u32,
    /// Distances along each (4 to 1024), the first of them 0.
    pub slices: u32,
    /// The last distance (km, up to 1e6).
    pub far: f64,
}

impl Default for VolumeSize {
    fn default() -> Self {
        Self { columns: 32, rows: 32, slices: 32, far: 100.0 }
    }
}

impl VolumeSize {
    /// Its distances (km), increasing from 0.
    pub fn distances(&self) -> Vec<f64> {
        let distance = |i: u32| self.far * (f64::from(i) / f64::from(self.slices - 1)).powi(2);
        (0..self.slices).map(distance).collect()
    }

    fn check(&self) -> Result<()> {
        let Self { columns, rows, slices, far } = *self;
        for (key, count) in [("columns", columns), ("rows", rows), ("slices", slices)] {
            check_range(key, f64::from(count), (4.0, 1024.0), "")?;
        }
        if far > 0.0 && far <= 1e6 {
            return Ok(());
        }
        Err(Error::not_allowed("far", format!("is {} km; it must be more than 0 and at most 1000000 km", shown(far))))
    }
}

/// In-scattered light and transmittance up to a point of a volume.
#[derive(Clone, Copy)]
struct Froxel {
    light: Constituents,
    transmittance: Vec3,
}

/// The air in front of a camera.
pub struct AirVolume<'a> {
    size: VolumeSize,
    camera: Camera,
    colours: AirColours<'a>,
    /// Slice by slice of a ray, ray by ray of a row from the left, row by row from the top.
    froxels: Vec<Froxel>,
}

impl Sky {
    /// The air in front of a camera as a volume. Each ray is marched once, on all cores, with the light field and the
    /// fit of the sky.
    ///
    /// # Errors
    ///
    /// Those of [`crate::Scene::validated`] for the camera; [`Error::NotAllowed`] for a camera without the perspective
    /// projection and for an explicit solve at every pixel (`render.color`); [`Error::OutOfRange`] for the size.
    pub fn air_volume(&self, camera: &CameraScene, size: VolumeSize) -> Result<AirVolume<'_>> {
        AirVolume::new(self.plan(), camera, size)
    }
}

impl<'a> AirVolume<'a> {
    pub(crate) fn new(sky: &'a SkyPlan, camera: &CameraScene, size: VolumeSize) -> Result<Self> {
        size.check()?;
        let seen = sky.scene.seen_by(camera)?;
        check(&seen)?;
        let camera = upload::camera(&seen);
        let (colours, air, distances) = (AirColours::new(sky), SlicedAir::new(sky.integral()), size.distances());
        let of_ray = |number: u32| {
            let place = [number % size.columns, number / size.columns];
            let fraction = |i: u32, of: u32| i as f32 / (of - 1) as f32;
            let view = view(&camera, Vec2::new(fraction(place[0], size.columns), fraction(place[1], size.rows)));
            let froxel = |before| Froxel {
                light: if sky.is_night { Constituents::DARK } else { colours.constituents(&before) },
                transmittance: colours.transmittance(before.columns),
            };
            air.along(view, &distances).into_iter().map(froxel).collect::<Vec<_>>()
        };
        let froxels = (0..size.columns * size.rows).into_par_iter().flat_map_iter(of_ray).collect();
        Ok(Self { size, camera, colours, froxels })
    }

    /// Its size.
    pub fn size(&self) -> VolumeSize {
        self.size
    }

    /// In-scattered light and transmittance at a point of the image (fractions of its width from the left and of its
    /// height from the top, 0 to 1), up to a distance along its ray (km). Distances beyond the last one are clamped;
    /// below the ground the air continues.
    pub fn at(&self, place: [f64; 2], distance: f64) -> BetweenRgb {
        if distance <= 0.0 {
            return BetweenRgb { transmittance: [1.0; 3], radiance: [0.0; 3] };
        }
        let [x, y] = place.map(|part| part.clamp(0.0, 1.0) as f32);
        let Froxel { light, transmittance } = self.between(x, y, (distance / self.size.far).min(1.0).sqrt() as f32);
        let radiance = self.colours.seen(light, view(&self.camera, Vec2::new(x, y)));
        let array = |rgb: Vec3| rgb.max(Vec3::ZERO).as_dvec3().to_array();
        BetweenRgb { transmittance: array(transmittance), radiance: array(radiance) }
    }

    /// Between four times four times four froxels, by parts of the columns, the rows and the slices.
    fn between(&self, x: f32, y: f32, z: f32) -> Froxel {
        let VolumeSize { columns, rows, slices, .. } = self.size;
        let of = |part: f32, count: u32| stencil(part * (count - 1) as f32, count);
        let [across, down, deep] = [of(x, columns), of(y, rows), of(z, slices)];
        let mut sum = Froxel { light: Constituents::DARK, transmittance: Vec3::ZERO };
        for row in 0..4 {
            for column in 0..4 {
                let ray = (down.first + row) * columns + across.first + column;
                let weight = down.weights[row as usize] * across.weights[column as usize];
                self.add_along(ray * slices, &deep, weight, &mut sum);
            }
        }
        sum
    }

    fn add_along(&self, first: u32, deep: &Stencil, weight: f32, sum: &mut Froxel) {
        let first = (first + deep.first) as usize;
        for (froxel, along) in self.froxels[first..first + 4].iter().zip(deep.weights.to_array()) {
            let weight = weight * along;
            sum.light.air += froxel.light.air * weight;
            sum.light.aerosol += froxel.light.aerosol * weight;
            sum.light.rest += froxel.light.rest * weight;
            sum.transmittance += froxel.transmittance * weight;
        }
    }
}

/// Checks that the air before the camera of a scene can be told.
///
/// # Errors
///
/// [`Error::NotAllowed`] for a camera without the perspective projection, and for an explicit solve at every pixel.
pub(crate) fn check(scene: &Scene) -> Result<()> {
    if scene.camera.projection != Projection::Perspective {
        let complaint = format!("is {}; the air before a camera takes perspective", word(scene.camera.projection));
        return Err(Error::not_allowed("camera.projection", complaint));
    }
    if scene.camera.polariser.is_some() {
        let complaint = "stands before images of the sky; the air before a camera is told without it";
        return Err(Error::not_allowed("camera.polariser", complaint));
    }
    if scene.render.color == ColourPath::Solve {
        return Err(Error::not_allowed("render.color", "is solve, of whole rays; air up to a distance takes folded"));
    }
    Ok(())
}

/// The direction at a place of the image.
fn view(camera: &Camera, place: Vec2) -> Vec3 {
    let position = place * Vec2::new(camera.width as f32, camera.height as f32);
    position_view(camera, PERSPECTIVE, position).direction
}
