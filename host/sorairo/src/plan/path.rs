//! Whether an image integrates every pixel, or a sky lookup between whose directions its pixels are interpolated.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt;

use rayon::prelude::*;
use serde::Serialize;
use sorairo_shared::camera::EQUIRECTANGULAR;
use sorairo_shared::kernels::LOOKUP_WORKGROUP;
use sorairo_shared::lookup::{RUN, grid_view};
use sorairo_shared::phase::{ScatteringAngle, cornette_shanks_phase, rayleigh_phase};
use sorairo_shared::sky::{constituents, view_ray};
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant;

use super::Plan;
use crate::scene::{ColourPath, PathChoice, Projection, Scene};

/// How far the sky lookup's colours may lie from the integral's, relative to the luminance of the direction or a tenth of the
/// sky's mean, whichever is larger: about a third of what the fit leaves.
const TOLERANCE: f64 = 1e-3;

/// How far they may lie from it anywhere, relative to the brightest direction: as far as single precision lets an explicit solve
/// and a folded matrix differ.
const TOLERANCE_OF_BRIGHTEST: f64 = 1e-4;

/// The sky lookup may not be finer than this; a sky that needs more is integrated at every pixel.
const LARGEST: (u32, u32) = (512, 256);

/// Most entries of a sky lookup that has the rows of its image: those that every device fills in one dispatch, 65 535 workgroups. They take
/// 128 MiB, which every device takes as one buffer.
const MOST_ENTRIES: u64 = 65_535 * LOOKUP_WORKGROUP as u64;

/// The coarsest sky lookup, with which its error is measured.
const COARSEST: (u32, u32) = (48, 16);

/// The sky lookup may not have fewer columns than this: farther apart the error is no longer that of a second difference.
const FEWEST_AZIMUTHS: u32 = 8;

/// The sky lookup pays from this many pixels per entry: an entry costs one integral, and a pixel a small part of one.
const PIXELS_PER_ENTRY: u64 = 2;

/// The way that an image takes, and why.
#[derive(Clone, Debug, Serialize)]
pub struct Path {
    /// Size of the sky lookup; none if every pixel is integrated.
    #[serde(rename = "table")]
    pub lookup: Option<LookupSize>,
    /// Why.
    pub reason: String,
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let way = if self.lookup.is_some() { "sky lookup" } else { "direct" };
        write!(f, "{way} ({})", self.reason)
    }
}

/// Size of a sky lookup.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LookupSize {
    /// Rows above the horizon.
    pub above: u32,
    /// Rows below the horizon.
    pub below: u32,
    /// Columns.
    pub azimuths: u32,
}

impl LookupSize {
    /// Its entries.
    pub fn entries(self) -> u64 {
        u64::from(self.above + self.below) * u64::from(self.azimuths)
    }
}

/// Chooses the way for a plan that is otherwise complete. `pixels` are those that are not known to be black.
pub fn choose(scene: &Scene, plan: &Plan, pixels: u64) -> Path {
    let direct = |reason: String| Path { lookup: None, reason };
    match scene.render.path {
        PathChoice::Direct => return direct("asked for".into()),
        _ if plan.colour_path == ColourPath::Solve => return direct("an explicit solve is made at every pixel".into()),
        _ if scene.observer.altitude > scene.atmosphere.top_radius - scene.atmosphere.ground_radius => {
            return direct("from outside, the atmosphere is a thin ring that a sky lookup does not resolve".into());
        }
        _ if sized(scene, plan, COARSEST).azimuths < COARSEST.1 => {
            return direct("a sky lookup with as many rows as the image would be too large".into());
        }
        PathChoice::Auto if pixels < PIXELS_PER_ENTRY * grid(scene, COARSEST).entries() => {
            return direct(format!("{pixels} lit pixels are fewer than a sky lookup would need"));
        }
        PathChoice::Auto | PathChoice::Lookup => {}
    }
    let asked = scene.render.path == PathChoice::Lookup;
    match size_for(scene, plan) {
        Some(size) if asked || pixels >= PIXELS_PER_ENTRY * size.entries() => Path {
            lookup: Some(size),
            reason: format!("{} entries keep the sky lookup within {TOLERANCE:e} of the integral", size.entries()),
        },
        Some(size) => {
            direct(format!("{pixels} lit pixels are fewer than a sky lookup of {} entries pays for", size.entries()))
        }
        None if asked => Path {
            lookup: Some(sized(scene, plan, LARGEST)),
            reason: "asked for; the largest sky lookup, which does not reach the error bound here".into(),
        },
        None => direct("no sky lookup up to the largest resolves this sky within its error bound".into()),
    }
}

/// A sky lookup of some rows on each side of the horizon, and columns.
fn grid(scene: &Scene, (rows, azimuths): (u32, u32)) -> LookupSize {
    LookupSize { above: rows, below: if scene.observer.altitude > 0.0 { rows } else { 0 }, azimuths }
}

/// The sky lookup that stands for such a grid: an equirectangular image has its own rows, and as many columns as fit.
fn sized(scene: &Scene, plan: &Plan, (rows, azimuths): (u32, u32)) -> LookupSize {
    if scene.camera.projection != Projection::Equirectangular {
        return grid(scene, (rows, azimuths));
    }
    let lit = plan.lit_rows.end - plan.lit_rows.start;
    let from_top = (0.5 - f64::from(plan.uniform.horizon) / PI) * f64::from(plan.height());
    let above = ((from_top + 0.5) as u32).min(lit);
    LookupSize { above, below: lit - above, azimuths: azimuths.min((MOST_ENTRIES / u64::from(lit)) as u32) }
}

/// The size that keeps linear interpolation within the tolerance, from its error on the coarsest grid.
///
/// Midway between two entries, linear interpolation of a smooth function is off by an eighth of its second difference, which falls as the
/// square of the spacing. The error is measured there, on sample cells of the coarsest grid, in both
/// directions; the number of entries follows from it.
fn size_for(scene: &Scene, plan: &Plan) -> Option<LookupSize> {
    let sides: &[bool] = if scene.observer.altitude > 0.0 { &[true, false] } else { &[true] };
    let rows = f64::from(COARSEST.0 - 1);
    let columns = f64::from(COARSEST.1 - 1);
    let mut cells = Vec::new();
    for &above in sides {
        for i in (0..COARSEST.0 - 1).step_by(2) {
            for j in (0..COARSEST.1 - 1).step_by(3) {
                cells.push((above, (f64::from(i) + 0.5) / rows, 1.0 - 2.0 * (f64::from(j) + 0.5) / columns));
            }
        }
    }
    let measured: Vec<Cell> =
        cells.into_par_iter().map(|(above, x, c)| measure(plan, above, x, c, 0.5 / rows, 1.0 / columns)).collect();
    let mean = measured.iter().map(|cell| cell.luminance).sum::<f64>() / measured.len() as f64;
    if mean <= 0.0 {
        return Some(sized(scene, plan, COARSEST));
    }
    let brightest = measured.iter().map(|cell| cell.luminance).fold(0.0, f64::max);
    let allowed = |cell: &Cell| (TOLERANCE * cell.luminance.max(0.1 * mean)).min(TOLERANCE_OF_BRIGHTEST * brightest);
    let worst = |error: fn(&Cell) -> f64| measured.iter().map(|cell| error(cell) / allowed(cell)).fold(0.0, f64::max);
    let has_its_rows = scene.camera.projection == Projection::Equirectangular;
    // Each direction that is interpolated may take its part of the tolerance.
    let parts = if has_its_rows { 1.0 } else { 2.0 };
    let entries = |cells: f64, error: f64| 1 + (cells * (parts * error).sqrt()).ceil() as u32;
    let above = entries(rows, worst(|cell| cell.error_along_elevation)).max(COARSEST.0);
    let azimuths = entries(columns, worst(|cell| cell.error_along_azimuth)).max(FEWEST_AZIMUTHS);
    let size = sized(scene, plan, (above, azimuths));
    ((has_its_rows || above <= LARGEST.0) && azimuths <= LARGEST.1 && size.azimuths == azimuths).then_some(size)
}

/// Pixels between two entries of a row, from which runs share them: a run then reaches a tenth of the way beyond an entry at most, where
/// the error of a straight line, d (1 + d) / 2 of a second difference, is still less than the eighth midway between two.
const PIXELS_BETWEEN_ENTRIES: f64 = 16.0;

/// Whether the pixels of an image can be looked up in [`variant::RUNS`].
///
/// Entries are equidistant in the cosine of the azimuth, and closest together across the sun's direction.
pub fn pixels_run(uniform: &Uniform, variant: u32) -> bool {
    let width = uniform.camera.width;
    let closest = f64::from(width) / (PI * f64::from(uniform.lookup_azimuths - 1));
    variant::projection(variant) == EQUIRECTANGULAR && width.is_multiple_of(RUN) && closest >= PIXELS_BETWEEN_ENTRIES
}

/// What linear interpolation does to one cell.
struct Cell {
    luminance: f64,
    error_along_elevation: f64,
    error_along_azimuth: f64,
}

fn measure(plan: &Plan, above: bool, x: f64, c: f64, half_x: f64, half_c: f64) -> Cell {
    let centre = grid_view(&plan.uniform, above, x as f32, c as f32);
    let angle = ScatteringAngle::of_ray(view_ray(&plan.uniform, centre));
    let phases =
        (rayleigh_phase(angle.cosine), cornette_shanks_phase(angle, plan.uniform.atmosphere.aerosol_asymmetry));
    let luminance = |x: f64, c: f64| {
        let ray = view_ray(&plan.uniform, grid_view(&plan.uniform, above, x as f32, c as f32));
        let rgb = constituents(&plan.uniform, plan.buffers(), ray, plan.fit_kind(), plan.variant);
        f64::from(plan.uniform.rgb.luminance(rgb.air * phases.0 + rgb.aerosol * phases.1))
    };
    let middle = luminance(x, c);
    let between = |a: f64, b: f64| (0.5 * (a + b) - middle).abs();
    Cell {
        luminance: middle.abs(),
        error_along_elevation: between(luminance(x - half_x, c), luminance(x + half_x, c)),
        error_along_azimuth: between(luminance(x, c - half_c), luminance(x, c + half_c)),
    }
}

/// Elevation (radians) of the horizon from an altitude above a sphere (km): `-acos(R / (R + h))`, without its cancellation.
pub fn horizon(ground_radius: f64, altitude: f64) -> f64 {
    let tangent = (altitude * (2.0 * ground_radius + altitude)).sqrt();
    -(tangent / ground_radius).atan().min(FRAC_PI_2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PixelFormat;
    use crate::scene::Size;

    fn path(change: impl FnOnce(&mut Scene)) -> Path {
        let mut scene = Scene::default();
        change(&mut scene);
        Plan::new(&scene, PixelFormat::LinearRgb).unwrap().path
    }

    #[test]
    fn an_equirectangular_image_shares_its_rows_with_its_lookup() {
        let size = path(|_| {}).lookup.expect("a sky lookup");
        assert_eq!((size.above, size.below), (256, 0));
        let from_12_km = path(|scene| scene.observer.altitude = 12.0).lookup.expect("a sky lookup");
        // 3.5° of 180° lie between level and the horizon.
        assert_eq!((from_12_km.above, from_12_km.below), (266, 246));
    }

    #[test]
    fn other_images_have_a_lookup_of_their_own() {
        let size = path(|scene| scene.camera.projection = Projection::Fisheye).lookup.expect("a sky lookup");
        assert!((COARSEST.0..=LARGEST.0).contains(&size.above), "{size:?}");
    }

    #[test]
    fn a_lookup_fits_into_a_buffer() {
        let tall = |height, choice| {
            path(|scene| (scene.camera.size, scene.render.path) = (Size { width: 1, height }, choice)).lookup
        };
        assert!(tall(400_000, PathChoice::Lookup).is_some_and(|size| size.entries() <= MOST_ENTRIES));
        assert!(tall(8_388_608, PathChoice::Lookup).is_none());
    }
}
