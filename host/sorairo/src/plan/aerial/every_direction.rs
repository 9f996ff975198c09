//! The air in front of an observer in every direction, from which the volumes of all cameras are filled.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use rayon::prelude::*;
use sorairo_shared::camera::is_within;
use sorairo_shared::glam::{Vec3, Vec4};
use sorairo_shared::interpolation::azimuth::cosine_at_place;
use sorairo_shared::light_field::multiple_lookup::MultipleLookup;
use sorairo_shared::picture::air::Before;
use sorairo_shared::picture::lookup::towards;
use sorairo_shared::sky::Constituents;
use sorairo_shared::uniform::Uniform;

use crate::error::{Error, Result, check_range};
use crate::plan::aerial::colours::AirColours;
use crate::plan::aerial::light::SlicedAir;
use crate::plan::held::Sky;
use crate::plan::sky::SkyPlan;
use crate::scene::{ColourPath, Scene};

/// Rows above and below the horizon, and columns from the sun's azimuth to the opposite one. From 20 km rays that graze
/// the lit air above the limb turn within half a degree from red to dark: with 32 rows above, volumes are off by 16 %
/// of the brightest there with the sun at -4°, with 64 by 2.4 %. From there down, 24 rows below leave 1.8 % by day, 36
/// leave 0.7 %. With 20 columns nothing changes by more than 1e-4.
const ABOVE: u32 = 64;
const BELOW: u32 = 36;
const AZIMUTHS: u32 = 14;

/// In-scattered light and transmittance in every direction from the observer of a sky, up to distances from 0 to
/// infinity. The volumes of cameras on a device are filled from it; see `ResidentRenderer::encode_volume`.
///
/// The distances of `n` slices are
///
/// ```text
/// d_k = m w² / (1 - w²)     w = k / (n - 1)
/// ```
///
/// with the middle distance `m`. Below the ground the air continues as it is at the ground, so that objects below the
/// horizon have air in front of them at any distance. The CPU computes the table on all cores. It depends on the sky
/// alone: compute it together with the sky.
#[derive(Debug)]
pub struct AirPlan {
    sky: Sky,
    middle: f64,
    directions: MultipleLookup,
    nodes: Arc<[Vec4]>,
}

impl AirPlan {
    /// The middle of the distances (km) for a sky: by day on the ground 25, where of 32 slices the first ends at 26 m
    /// and the last but one at 370 km. From higher up, the air near the ground lies farther away; in twilight, the
    /// planet's shadow ends there.
    pub fn middle_of(sky: &Sky) -> f64 {
        let Scene { observer, sun, .. } = &**sky.scene();
        25.0 + 10.0 * observer.altitude.clamp(0.0, 100.0) + 15.0 * (-sun.elevation).clamp(0.0, 4.0)
    }

    /// The air of a sky for a number of slices (4 to 256), with the middle of their distances (0.001 to 10000 km).
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] for the slices or the middle; [`Error::NotAllowed`] for a sky whose colours are solved at
    /// every pixel (`render.color`).
    pub fn new(sky: &Sky, slices: u32, middle: f64) -> Result<Self> {
        check_range("slices", f64::from(slices), (4.0, 256.0), "")?;
        check_range("middle", middle, (1e-3, 1e4), "km")?;
        let plan = sky.plan();
        if plan.colour_path == ColourPath::Solve {
            return Err(Error::not_allowed(
                "render.color",
                "is solve, of whole rays; air up to a distance takes folded",
            ));
        }
        let directions = directions(plan, slices);
        let air = InEveryDirection {
            sky: plan,
            directions,
            air: SlicedAir::new(plan.integral()),
            colours: AirColours::new(plan),
        };
        let nodes = air.nodes(&distances(slices, middle)).into();
        Ok(Self { sky: sky.clone(), middle, directions, nodes })
    }

    /// The sky.
    pub fn sky(&self) -> &Sky {
        &self.sky
    }

    /// The distances of the slices.
    pub fn slices(&self) -> u32 {
        self.directions.groups
    }

    /// The middle distance (km): a volume is sampled for the distance `d` at the fraction `√(d / (d + middle))` from
    /// its first slice to its last.
    pub fn middle(&self) -> f64 {
        self.middle
    }

    /// The directions of the table; its groups are the slices.
    pub fn directions(&self) -> MultipleLookup {
        self.directions
    }

    /// The table in the layout of the kernel: the slices of a direction, the directions of a row, and the rows from the
    /// horizon, first those above it. A node is [`sorairo_shared::picture::air::NODE`] times four numbers.
    pub fn nodes(&self) -> &Arc<[Vec4]> {
        &self.nodes
    }

    /// [`Froxels::near_sun`](sorairo_shared::picture::air::Froxels::near_sun) of a volume with so many columns and rows
    /// of an image; 0 without aerosol, and where the image shows nothing so near the sun.
    pub fn near_sun(&self, uniform: &Uniform, [columns, rows]: [u32; 2]) -> f32 {
        /// Froxels between the sun and where straight lines between them do. An aureole falls with about `θ^-1.5`,
        /// from which a chord over an angle `h` is off by `15/32 (h/θ)²` at most: 2 % of the aureole there at 5 `h`.
        const FROXELS: f64 = 5.0;
        let camera = &uniform.camera;
        let across = f64::from(camera.half_field) * 2.0;
        let down = across * f64::from(camera.height) / f64::from(camera.width);
        let froxel = (across / f64::from(columns - 1)).max(down / f64::from(rows - 1));
        let angle = (FROXELS * froxel).min(FRAC_PI_2);
        let is_seen = is_within(camera, uniform.sun.truncate(), angle as f32);
        if self.sky.plan().integral().has_aerosol() && is_seen { (1.0 - angle.cos()) as f32 } else { 0.0 }
    }
}

/// The distances of slices (km).
fn distances(slices: u32, middle: f64) -> Vec<f64> {
    let distance = |k: u32| {
        let w = f64::from(k) / f64::from(slices - 1);
        middle * w * w / (1.0 - w * w)
    };
    (0..slices).map(distance).collect()
}

fn directions(sky: &SkyPlan, slices: u32) -> MultipleLookup {
    let uniform = &sky.base.uniform;
    MultipleLookup {
        above: ABOVE,
        below: BELOW,
        azimuths: AZIMUTHS,
        groups: slices,
        horizon: uniform.horizon,
        span_above: uniform.lookup_span,
        span_below: FRAC_PI_2 as f32 + uniform.horizon,
        padding: 0,
    }
}

struct InEveryDirection<'a> {
    sky: &'a SkyPlan,
    directions: MultipleLookup,
    air: SlicedAir<'a>,
    colours: AirColours<'a>,
}

impl InEveryDirection<'_> {
    fn nodes(&self, distances: &[f64]) -> Vec<Vec4> {
        let MultipleLookup { above, below, azimuths, .. } = self.directions;
        let of_direction = |number: u32| {
            let view = self.view(number / azimuths, number % azimuths);
            self.air.along(view, distances).into_iter().flat_map(|before| {
                let light = if self.sky.is_night { Constituents::DARK } else { self.colours.constituents(&before) };
                Before { light, transmittance: self.colours.transmittance(before.columns) }.node()
            })
        };
        (0..(above + below) * azimuths).into_par_iter().flat_map_iter(of_direction).collect()
    }

    /// The direction of a row and a column; the inverse of
    /// [`place_at`](sorairo_shared::light_field::multiple_lookup::place_at).
    fn view(&self, row: u32, column: u32) -> Vec3 {
        let MultipleLookup { above, below, azimuths, horizon, span_above, span_below, .. } = self.directions;
        let squared = |row: u32, rows: u32| (f64::from(row) / f64::from(rows - 1)).powi(2);
        let from_horizon = if row < above {
            squared(row, above) * f64::from(span_above)
        } else {
            -squared(row - above, below) * f64::from(span_below)
        };
        let (sine, cosine) = (f64::from(horizon) + from_horizon).sin_cos();
        let c = cosine_at_place(column as f32 / (azimuths - 1) as f32);
        towards(&self.sky.base.uniform, sine as f32, cosine as f32, c)
    }
}
