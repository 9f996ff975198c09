//! Where the disc lies in an image.

use std::f64::consts::{FRAC_PI_2, PI};

use sorairo_shared::camera::Camera;
use sorairo_shared::glam::{DVec2, DVec3};
use sorairo_shared::uniform::SunDisc;

use super::disc::Sun;
use crate::scene::Projection;

/// Samples across the disc, at least, of the sum over a pixel's part of it.
const SAMPLES_ACROSS: f64 = 48.0;

/// Most samples along a side of a pixel.
const MOST_SAMPLES: f64 = 64.0;

impl Sun<'_> {
    /// The disc for the kernels, at any wavelengths; the place of its grid is not known yet.
    pub fn for_kernels(&self, projection: Projection, camera: &Camera) -> SunDisc {
        let (lowest, highest) = self.heights();
        let [left, top, right, bottom] = self.bounds(projection, camera).map(|edge| edge as f32);
        let across = f64::from(right - left).min(f64::from(bottom - top)).max(1e-3);
        SunDisc {
            left,
            top,
            right,
            bottom,
            sine_radius: self.radius.sin() as f32,
            lowest: lowest as f32,
            highest: highest as f32,
            horizon: self.horizon.sin() as f32,
            centre: {
                let (elevation, flattening) = self.centre;
                let bearing = self.sky.base.source.bearing();
                (bearing * elevation.cos() + DVec3::Z * elevation.sin()).as_vec3().extend(flattening as f32)
            },
            first_entry: 0,
            samples: (SAMPLES_ACROSS / across).ceil().clamp(2.0, MOST_SAMPLES) as u32,
            padding0: 0,
            padding1: 0,
        }
    }

    /// Left, top, right and bottom of the disc in the image (pixels from its top left corner); an empty box where it is
    /// not seen.
    fn bounds(&self, projection: Projection, camera: &Camera) -> [f64; 4] {
        let [width, height] = [camera.width, camera.height].map(f64::from);
        if projection == Projection::Equirectangular {
            return self.equirectangular_bounds(camera, width, height);
        }
        let rim: Vec<_> = self.rim().map(|view| self.project(projection, camera, view)).collect();
        if rim.iter().all(Option::is_none) {
            return [0.0; 4];
        }
        let Some(rim) = rim.into_iter().collect::<Option<Vec<_>>>() else { return [0.0, 0.0, width, height] };
        let low = rim.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = rim.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        // The rim is a polygon here.
        let margin = (high - low) * 0.01;
        let (low, high) = (low - margin, high + margin);
        [low.x, low.y, high.x, high.y]
    }

    fn equirectangular_bounds(&self, camera: &Camera, width: f64, height: f64) -> [f64; 4] {
        let row = |elevation: f64| (0.5 - elevation / PI) * height;
        let (elevation, flattening) = self.centre;
        let (up, down) = (elevation + self.radius * flattening, elevation - self.radius * flattening);
        let (top, bottom) = (row(up).max(0.0), row(down).min(height));
        let over_zenith = elevation.abs() + self.radius >= FRAC_PI_2;
        let half = if over_zenith { PI } else { (self.radius.sin() / elevation.cos()).asin() };
        let half = half / (2.0 * PI) * width;
        if half > (0.5 * width - 1.0).max(0.25 * width) {
            return [0.0, top, width, bottom];
        }
        let bearing =
            self.sky.base.uniform.bearing.dot(camera.right).atan2(self.sky.base.uniform.bearing.dot(camera.forward));
        let centre = (0.5 + f64::from(bearing) / (2.0 * PI)) * width;
        [centre - half, top, centre + half, bottom]
    }

    /// Directions around the disc's edge.
    fn rim(&self) -> impl Iterator<Item = DVec3> {
        const PLACES: u32 = 64;
        // That of a disc that is not flattened, which has it in it.
        let (elevation, _) = self.centre;
        let sun = self.sky.base.source.bearing() * elevation.cos() + DVec3::Z * elevation.sin();
        let (side, other) = sun.any_orthonormal_pair();
        let (sine, cosine) = self.radius.sin_cos();
        (0..PLACES).map(move |place| {
            let (s, c) = (f64::from(place) * 2.0 * PI / f64::from(PLACES)).sin_cos();
            sun * cosine + (side * c + other * s) * sine
        })
    }

    /// Where an image other than an equirectangular one shows a direction (pixels from the image's top left corner), if
    /// it can.
    fn project(&self, projection: Projection, camera: &Camera, view: DVec3) -> Option<DVec2> {
        let [right, up, forward] =
            [camera.right, camera.up, camera.forward].map(|axis| view.dot(axis.as_dvec4().truncate()));
        let [width, height, half_field] = [camera.width as f32, camera.height as f32, camera.half_field].map(f64::from);
        if projection == Projection::Octahedral {
            let [x, y, z] = [right, forward, up].map(|part| part / (right.abs() + up.abs() + forward.abs()));
            let folded = if z < 0.0 { -z } else { 0.0 };
            let place = DVec2::new(x + folded.copysign(x), y + folded.copysign(y));
            return Some(DVec2::new(0.5 * width * (1.0 + place.x), 0.5 * height * (1.0 - place.y)));
        }
        let (across, from_centre) = if projection == Projection::Fisheye {
            let angle = forward.clamp(-1.0, 1.0).acos();
            // Beside the direction behind the camera the edge may go around it.
            if angle > PI - 2.0 * self.radius {
                return None;
            }
            let outwards = DVec2::new(right, up).normalize_or_zero();
            (width.min(height), outwards * (angle / half_field))
        } else if forward > 1e-3 {
            let middle = DVec2::new(camera.right.w.into(), camera.up.w.into());
            (width, DVec2::new(right, up) / (forward * half_field) - middle / half_field)
        } else {
            return None;
        };
        Some(DVec2::new(0.5 * width + 0.5 * across * from_centre.x, 0.5 * height - 0.5 * across * from_centre.y))
    }
}
