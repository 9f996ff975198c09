//! Whether a frame integrates every pixel, or a table of directions that its pixels look up.

use std::f64::consts::FRAC_PI_2;
use std::fmt;

use rayon::prelude::*;
use serde::Serialize;
use sorairo_shared::atmosphere::{cornette_shanks_phase, rayleigh_phase};
use sorairo_shared::sky::{constituents, view_ray};
use sorairo_shared::sky_table::grid_view;

use super::Plan;
use crate::scene::{ColorPath, PathChoice, Scene};

/// How far the table's colours may lie from the integral's, relative to the luminance of the direction or a tenth of the
/// sky's mean, whichever is larger: about a third of what the fit leaves.
const TOLERANCE: f64 = 1e-3;

/// How far they may lie from it anywhere, relative to the brightest direction: as far as single precision lets an explicit solve
/// and a folded matrix differ.
const TOLERANCE_OF_BRIGHTEST: f64 = 1e-4;

/// The table may not be finer than this; a sky that needs more is integrated at every pixel.
const LARGEST: (u32, u32) = (512, 256);

/// The coarsest table, with which its error is measured.
const COARSEST: (u32, u32) = (48, 16);

/// The table pays from this many pixels per entry: an entry costs one integral, and a pixel's lookup a small part of one.
const PIXELS_PER_ENTRY: u64 = 2;

/// The way that a frame takes, and why.
#[derive(Clone, Debug, Serialize)]
pub struct Path {
    /// Size of the sky table; none if every pixel is integrated.
    pub table: Option<TableSize>,
    /// Why.
    pub reason: String,
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let way = if self.table.is_some() { "sky table" } else { "direct" };
        write!(f, "{way} ({})", self.reason)
    }
}

/// Size of a sky table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct TableSize {
    /// Rows above the horizon.
    pub above: u32,
    /// Rows below the horizon.
    pub below: u32,
    /// Columns.
    pub azimuths: u32,
}

impl TableSize {
    /// Entries of the table.
    pub fn entries(self) -> u32 {
        (self.above + self.below) * self.azimuths
    }
}

/// Chooses the way for a plan that is otherwise complete. `pixels` are those that are not known to be black.
pub fn choose(scene: &Scene, plan: &Plan, pixels: u64) -> Path {
    let direct = |reason: String| Path { table: None, reason };
    match scene.render.path {
        PathChoice::Direct => return direct("asked for".into()),
        _ if plan.color == ColorPath::Solve => return direct("an explicit solve is made at every pixel".into()),
        _ if scene.observer.altitude > scene.atmosphere.top_radius - scene.atmosphere.ground_radius => {
            return direct("from outside, the atmosphere is a thin ring that a table does not resolve".into());
        }
        PathChoice::Auto if pixels < PIXELS_PER_ENTRY * u64::from(coarsest(scene).entries()) => {
            return direct(format!("{pixels} lit pixels are fewer than a table would need"));
        }
        PathChoice::Auto | PathChoice::Table => {}
    }
    let asked = scene.render.path == PathChoice::Table;
    match size_for(scene, plan) {
        Some(size) if asked || pixels >= PIXELS_PER_ENTRY * u64::from(size.entries()) => Path {
            table: Some(size),
            reason: format!("{} entries keep the table within {TOLERANCE:e} of the integral", size.entries()),
        },
        Some(size) => {
            direct(format!("{pixels} lit pixels are fewer than a table of {} entries pays for", size.entries()))
        }
        None if asked => Path {
            table: Some(limited(scene, LARGEST.0, LARGEST.1)),
            reason: "asked for; the largest table, which does not reach the error bound here".into(),
        },
        None => direct("no table up to the largest resolves this sky within its error bound".into()),
    }
}

fn limited(scene: &Scene, rows: u32, azimuths: u32) -> TableSize {
    TableSize { above: rows, below: if scene.observer.altitude > 0.0 { rows } else { 0 }, azimuths }
}

fn coarsest(scene: &Scene) -> TableSize {
    limited(scene, COARSEST.0, COARSEST.1)
}

/// The size that keeps linear interpolation within the tolerance, from its error on the coarsest grid.
///
/// Midway between two entries, linear interpolation of a smooth function is off by an eighth of its second difference, which falls as the
/// square of the spacing. The error is measured there, on sample cells of the coarsest grid, in both
/// directions; the number of entries follows from it.
fn size_for(scene: &Scene, plan: &Plan) -> Option<TableSize> {
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
        return Some(coarsest(scene));
    }
    let brightest = measured.iter().map(|cell| cell.luminance).fold(0.0, f64::max);
    let allowed = |cell: &Cell| (TOLERANCE * cell.luminance.max(0.1 * mean)).min(TOLERANCE_OF_BRIGHTEST * brightest);
    let worst = |error: fn(&Cell) -> f64| measured.iter().map(|cell| error(cell) / allowed(cell)).fold(0.0, f64::max);
    // Each direction may take half of the tolerance.
    let finer = |error: f64| (2.0 * error).sqrt().max(1.0);
    let above = 1 + (rows * finer(worst(|cell| cell.error_along_elevation))).ceil() as u32;
    let azimuths = 1 + (columns * finer(worst(|cell| cell.error_along_azimuth))).ceil() as u32;
    (above <= LARGEST.0 && azimuths <= LARGEST.1).then(|| limited(scene, above, azimuths))
}

/// What linear interpolation does to one cell.
struct Cell {
    luminance: f64,
    error_along_elevation: f64,
    error_along_azimuth: f64,
}

fn measure(plan: &Plan, above: bool, x: f64, c: f64, half_x: f64, half_c: f64) -> Cell {
    let centre = grid_view(&plan.frame, above, x as f32, c as f32);
    let angle = view_ray(&plan.frame, centre).scattering_angle();
    let phases = (rayleigh_phase(angle.cosine), cornette_shanks_phase(angle, plan.frame.atmosphere.aerosol_asymmetry));
    let luminance = |x: f64, c: f64| {
        let ray = view_ray(&plan.frame, grid_view(&plan.frame, above, x as f32, c as f32));
        let Plan { frame, bands, quadrature, colour, .. } = plan;
        let rgb = constituents(frame, bands, quadrature, colour, ray, plan.fit_kind(), plan.variant);
        f64::from(plan.frame.rgb.luminance(rgb.air * phases.0 + rgb.aerosol * phases.1))
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
