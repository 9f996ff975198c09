//! The exposure of an image's linear values.

use std::f32::consts::FRAC_PI_4;

use sorairo_shared::fit::spectrum::rows_per_node;
use sorairo_shared::glam::{Vec3, Vec4};
use sorairo_shared::math::{max, min};
use sorairo_shared::variant;

use crate::plan::picture::exposure;
use crate::plan::picture::image::Plan;
use crate::plan::rays::directions;
use crate::scene::{Exposure, ExrDepth};

impl Plan {
    /// The exposure of linear values (stops) for a file or a target: that of the scene, or else the one that half
    /// floats need to hold them (see `exposure::of_halves`), or 0.
    pub fn linear_exposure(&self, depth: ExrDepth) -> f32 {
        match (self.sky.scene().render.exr_exposure, depth) {
            (Exposure::Stops(stops), _) => stops as f32,
            (_, ExrDepth::Full) => 0.0,
            (_, ExrDepth::Half) => exposure::of_halves(self.brightest()),
        }
    }

    /// The same plan with linear RGB exposed by so many stops, and a picture as before.
    pub fn exposed(mut self, stops: f32) -> Self {
        if stops == 0.0 {
            return self;
        }
        let factor = stops.exp2();
        // Of a regression's rows the last of a node alone is a colour; its first number is not.
        if self.variant & variant::REGRESSION != 0 {
            let rows = rows_per_node(self.variant) as usize;
            let colours = self.uniform.node_rows.iter_mut().skip(rows - 1).step_by(rows);
            colours.for_each(|row| *row *= Vec4::new(1.0, factor, factor, factor));
        }
        // The last number of a row by which a cubic is observed is a wavelength.
        let last = if variant::is_solved_cubic(self.variant) { 1.0 } else { factor };
        let tables = if self.variant & variant::ACES == 0 { 0..0 } else { self.tables() };
        let degrees = self.degrees();
        let rows = self.colour.iter_mut().enumerate();
        let rows = rows.filter(|(at, _)| !tables.contains(at) && !degrees.contains(at));
        rows.for_each(|(_, row)| *row *= Vec4::new(factor, factor, factor, last));
        self.uniform.ground = (self.uniform.ground.truncate() * factor).extend(self.uniform.ground.w);
        self.uniform.exposure /= factor;
        let eye = &mut self.uniform.eye;
        [&mut eye.red, &mut eye.green, &mut eye.blue].into_iter().for_each(|column| *column /= factor);
        eye.red.w *= factor * factor;
        self
    }

    /// The fraction of the disc's light that half floats clip in its pixels, and the exposure (stops) that would keep
    /// it; `None` if they hold it.
    pub fn cut_of_disc(&self) -> Option<(f32, f32)> {
        if self.variant & variant::SUN_DISC == 0 {
            return None;
        }
        let disc = &self.uniform.disc;
        // The box about the disc, of which a circle covers π/4; where that is less than a pixel, the mean over it is
        // less than the disc.
        let pixels = (disc.right - disc.left) * (disc.bottom - disc.top) * FRAC_PI_4;
        let grid = self.colour[disc.first_entry as usize..].iter().map(|rgb| rgb.truncate().max_element());
        let peak = grid.fold(0.0, max) * min(pixels, 1.0);
        (peak > exposure::LARGEST_HALF).then(|| {
            let ratio = exposure::LARGEST_HALF / peak;
            // A stop more than that, for the sky that stands behind.
            (1.0 - ratio, ratio.log2().floor() - 1.0)
        })
    }

    /// The largest of linear RGB in directions over the whole sphere, close to each other about the sun and above the
    /// horizon beneath it; and of the sun's disc before them, where it is shown.
    fn brightest(&self) -> f32 {
        let plan = self.sky.plan();
        let uniform = &plan.base.uniform;
        let (sun, horizon) = (plan.base.source.elevation, f64::from(uniform.horizon).to_degrees());
        let elevations = [-75.0, -45.0, -15.0, 15.0, 45.0, 75.0].into_iter();
        let elevations = elevations.chain([0.1, 0.5, 2.0, 5.0].map(|above| horizon + above));
        let elevations = elevations.chain([-3.0, -0.3, 0.0, 0.3, 3.0].map(|off| (sun + off).clamp(-90.0, 90.0)));
        let azimuths = [0.0, 3.0, 30.0, 90.0, 180.0].map(|off| plan.base.source.azimuth + off);
        let view = |elevation| azimuths.map(|azimuth| directions::direction(elevation, azimuth).as_vec3());
        let views: Vec<Vec3> = elevations.flat_map(view).collect();
        let largest = |colours: &[Vec3]| colours.iter().map(|rgb| rgb.max_element()).fold(0.0, max);
        let sky = largest(&plan.radiances(&views));
        if self.variant & variant::SUN_DISC == 0 {
            return sky;
        }
        let grid = self.colour[self.uniform.disc.first_entry as usize..].iter().map(|rgb| rgb.truncate());
        sky + largest(&grid.collect::<Vec<_>>())
    }
}
