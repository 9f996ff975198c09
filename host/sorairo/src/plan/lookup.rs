//! Whether an image integrates every pixel, or a sky lookup between whose directions its pixels are interpolated.

use std::f64::consts::PI;
use std::fmt;
use std::ops::Range;

use serde::Serialize;
use sorairo_shared::azimuth::cosine_at_place;
use sorairo_shared::camera::EQUIRECTANGULAR;
use sorairo_shared::cubic::stencil;
use sorairo_shared::glam::{Vec3, Vec4};
use sorairo_shared::kernels::LOOKUP_WORKGROUP;
use sorairo_shared::lookup::grid_view;
use sorairo_shared::run::RUN;
use sorairo_shared::sky::Constituents;
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant;

use super::sky::{SkyPlan, found_once};
use crate::scene::{ColourPath, PathChoice, Projection, Scene};

/// How far the sky lookup's colours may lie from the integral's, relative to the luminance of the direction or a tenth of the
/// sky's mean, whichever is larger: about a third of what the fit leaves.
const TOLERANCE: f64 = 1e-3;

/// How far they may lie from it anywhere, relative to the brightest direction: as far as single precision lets an explicit solve
/// and a folded matrix differ.
const TOLERANCE_OF_BRIGHTEST: f64 = 1e-4;

/// The sky lookup may not be finer than this; a sky that needs more is integrated at every pixel.
const LARGEST: (u32, u32) = (512, 256);

/// Most entries of a sky lookup that has the rows of its image: of three colours they take 128 MiB, which every Vulkan device takes as one
/// buffer, and one dispatch fills them.
const MOST_ENTRIES: u64 = (1 << 27) / (3 * size_of::<Vec4>() as u64);
const _: () = assert!(MOST_ENTRIES <= 65_535 * LOOKUP_WORKGROUP as u64);

/// The coarsest sky lookup, with which its error is measured.
const COARSEST: (u32, u32) = (48, 16);

/// The sky lookup may not have fewer columns than this: farther apart the error is no longer that of a low difference.
const FEWEST_AZIMUTHS: u32 = 8;

/// The sky lookup pays from this many pixels per entry: an entry costs one integral, and a pixel a small part of one.
const PIXELS_PER_ENTRY: u64 = 2;

/// The way that an image takes, and why.
#[derive(Clone, Debug, Serialize)]
pub struct Lookup {
    /// Size of the sky lookup; none if every pixel is integrated.
    #[serde(rename = "table")]
    pub size: Option<LookupSize>,
    /// Why.
    pub reason: String,
}

impl fmt::Display for Lookup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let way = if self.size.is_some() { "sky lookup" } else { "direct" };
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

/// Chooses the way for an image of a scene's sky.
pub fn choose(scene: &Scene, sky: &SkyPlan, lit_rows: &Range<u32>) -> Lookup {
    let direct = |reason: String| Lookup { size: None, reason };
    let sized = |grid| sized(scene, sky, lit_rows, grid);
    let pixels = u64::from(scene.camera.size.width) * lit_rows.len() as u64;
    match scene.render.path {
        _ if sky.is_night => return direct("nothing is lit".into()),
        PathChoice::Direct => return direct("asked for".into()),
        _ if sky.colour_path == ColourPath::Solve => return direct("an explicit solve is made at every pixel".into()),
        _ if scene.observer.altitude > scene.atmosphere.top_radius - scene.atmosphere.ground_radius => {
            return direct("from outside, the atmosphere is a thin ring that a sky lookup does not resolve".into());
        }
        _ if sized(COARSEST).azimuths < COARSEST.1 => {
            return direct("a sky lookup with as many rows as the image would be too large".into());
        }
        PathChoice::Auto if pixels < PIXELS_PER_ENTRY * grid(scene, COARSEST).entries() => {
            return direct(format!("{pixels} lit pixels are fewer than a sky lookup would need"));
        }
        PathChoice::Auto | PathChoice::Lookup => {}
    }
    let asked = scene.render.path == PathChoice::Lookup;
    match size_for(scene, sky, sized) {
        Some(size) if asked || pixels >= PIXELS_PER_ENTRY * size.entries() => Lookup {
            size: Some(size),
            reason: format!("{} entries keep the sky lookup within {TOLERANCE:e} of the integral", size.entries()),
        },
        Some(size) => {
            direct(format!("{pixels} lit pixels are fewer than a sky lookup of {} entries pays for", size.entries()))
        }
        None if asked => Lookup {
            size: Some(sized(LARGEST)),
            reason: "asked for; the largest sky lookup, which does not reach the error bound here".into(),
        },
        None => direct("no sky lookup up to the largest resolves this sky within its error bound".into()),
    }
}

/// A sky lookup of some rows on each side of the horizon, and columns.
fn grid(scene: &Scene, (rows, azimuths): Entries) -> LookupSize {
    LookupSize { above: rows, below: if scene.observer.altitude > 0.0 { rows } else { 0 }, azimuths }
}

/// The sky lookup that stands for such a grid: an equirectangular image has its own rows, and as many columns as fit.
fn sized(scene: &Scene, sky: &SkyPlan, lit_rows: &Range<u32>, (rows, azimuths): Entries) -> LookupSize {
    if scene.camera.projection != Projection::Equirectangular {
        return grid(scene, (rows, azimuths));
    }
    let lit = lit_rows.end - lit_rows.start;
    let from_top = (0.5 - f64::from(sky.integral().uniform.horizon) / PI) * f64::from(scene.camera.size.height);
    let above = ((from_top + 0.5) as u32).min(lit);
    // On the ground itself what lies below is one colour.
    let below = if scene.observer.altitude > 0.0 { lit - above } else { 0 };
    LookupSize { above, below, azimuths: azimuths.min((MOST_ENTRIES / u64::from(above + below)) as u32) }
}

/// Powers of the spacing by which the errors of straight lines and of cubics fall.
const LINEAR: f64 = 2.0;
/// See [`LINEAR`].
const CUBIC: f64 = 4.0;

/// Rows on a side of the horizon, and columns.
type Entries = (u32, u32);

/// The size that keeps interpolation within the tolerance; `sized` makes a sky lookup of rows and columns.
fn size_for(scene: &Scene, sky: &SkyPlan, sized: impl Fn(Entries) -> LookupSize) -> Option<LookupSize> {
    let has_its_rows = scene.camera.projection == Projection::Equirectangular;
    let grid = (*found_once(&sky.lookup_grids[usize::from(has_its_rows)], || enough(sky, has_its_rows)))?;
    let size = sized(grid);
    (size.azimuths == grid.1).then_some(size)
}

/// Rows and columns that keep interpolation within the tolerance, from its error on the coarsest grid, and then on the grid that follows from it; none
/// where they are too many.
///
/// Midway between two entries, linear interpolation of a smooth function is off by an eighth of its second difference, which falls as the
/// square of the spacing, and a cubic by a part of its fourth difference, which falls as the fourth power. The error is measured there, on
/// sample cells, in both directions; the number of entries follows from it. Where the coarsest grid skips what is narrower than its cells, the
/// second one shows it.
fn enough(sky: &SkyPlan, has_its_rows: bool) -> Option<Entries> {
    let allowed = |(rows, azimuths): Entries| (has_its_rows || rows <= LARGEST.0) && azimuths <= LARGEST.1;
    let sampled = |grid| Sampled::new(sky, grid, has_its_rows);
    let coarsest = sampled(COARSEST);
    if coarsest.mean <= 0.0 {
        return Some(COARSEST);
    }
    let grid = coarsest.enough();
    if !allowed(grid) {
        return None;
    }
    let finer = sampled(grid).enough();
    let grid = (grid.0.max(finer.0), grid.1.max(finer.1));
    allowed(grid).then_some(grid)
}

/// What interpolation does to sample cells of a grid.
struct Sampled {
    grid: Entries,
    has_its_rows: bool,
    cells: Vec<Cell>,
    /// The mean luminance.
    mean: f64,
}

impl Sampled {
    /// Of a grid of rows and columns; an image that has its rows goes through columns by cubics.
    fn new(sky: &SkyPlan, grid: Entries, has_its_rows: bool) -> Self {
        let sides: &[bool] = if sky.scene.observer.altitude > 0.0 { &[true, false] } else { &[true] };
        // Spread as on the coarsest grid, each in the middle of a cell.
        let places = |cells: u32, step: usize, of: u32| {
            (0..cells).step_by(step).map(move |i| 2 * (f64::from(i) / f64::from(cells) * f64::from(of)) as u32 + 1)
        };
        // A finer grid's cells are more alike from row to row.
        let row_step = if grid == COARSEST { 2 } else { 4 };
        let rows = |&above| places(COARSEST.0 - 1, row_step, grid.0 - 1).map(move |row| (above, row));
        let of_row =
            |(above, row)| places(COARSEST.1 - 1, 2, grid.1 - 1).map(move |column| Place { above, row, column });
        let middles: Vec<Place> = sides.iter().flat_map(rows).flat_map(of_row).collect();
        let cells = measure(sky, grid, &middles, has_its_rows);
        let mean = cells.iter().map(|cell| cell.luminance).sum::<f64>() / cells.len() as f64;
        Self { grid, has_its_rows, cells, mean }
    }

    /// Rows and columns that are enough.
    fn enough(&self) -> (u32, u32) {
        let brightest = self.cells.iter().map(|cell| cell.luminance).fold(0.0, f64::max);
        let allowed =
            |cell: &Cell| (TOLERANCE * cell.luminance.max(0.1 * self.mean)).min(TOLERANCE_OF_BRIGHTEST * brightest);
        let worst =
            |error: fn(&Cell) -> f64| self.cells.iter().map(|cell| error(cell) / allowed(cell)).fold(0.0, f64::max);
        // Each direction that is interpolated may take its part of the tolerance.
        let (parts, power) = if self.has_its_rows { (1.0, CUBIC) } else { (2.0, LINEAR) };
        let entries = |entries: u32, error: f64, power: f64| {
            1 + (f64::from(entries - 1) * (parts * error).powf(1.0 / power)).ceil() as u32
        };
        let above = entries(self.grid.0, worst(|cell| cell.error_along_elevation), LINEAR).max(COARSEST.0);
        let azimuths = entries(self.grid.1, worst(|cell| cell.error_along_azimuth), power).max(FEWEST_AZIMUTHS);
        (above, azimuths)
    }
}

/// Whether runs of pixels, of which the one in the middle says between which entries all are, reach no farther than half way into the next cell: there
/// the cubic of the cell beside it is off by as much as in the middle of its own.
fn runs_are_short(width: u32, azimuths: u32) -> bool {
    let closest_entries = f64::from(width) / (PI * f64::from(azimuths - 1));
    f64::from(RUN) <= closest_entries
}

/// The most samples along a side of a pixel of the sun's disc with which pixels run: an invocation computes those of a run one after the other.
const MOST_SAMPLES_IN_RUNS: u32 = 32;

/// Whether the pixels of an image can be looked up in [`variant::RUNS`] in a sky lookup of this size.
///
/// Entries are closest together at the sun's azimuth; see [`sorairo_shared::azimuth`].
pub fn pixels_run(uniform: &Uniform, variant: u32, size: LookupSize) -> bool {
    let width = uniform.camera.width;
    let has_fine_disc = variant & variant::SUN_DISC != 0 && uniform.disc.samples > MOST_SAMPLES_IN_RUNS;
    let is_level = variant::projection(variant) == EQUIRECTANGULAR;
    is_level && width.is_multiple_of(RUN) && runs_are_short(width, size.azimuths) && !has_fine_disc
}

/// What interpolation does to one cell.
struct Cell {
    luminance: f64,
    error_along_elevation: f64,
    error_along_azimuth: f64,
}

/// A place between the entries of a grid, in halves of the distance from one to the next.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    above: bool,
    row: u32,
    column: u32,
}

impl Place {
    /// Its direction.
    fn view(self, uniform: &Uniform, grid: Entries) -> Vec3 {
        let part = |halves: u32, entries: u32| f64::from(halves) / f64::from(2 * (entries - 1));
        let (x, across) = (part(self.row, grid.0), part(self.column, grid.1));
        grid_view(uniform, self.above, x as f32, cosine_at_place(across as f32))
    }

    /// The column of entries, from the first.
    fn column(self) -> f32 {
        0.5 * self.column as f32
    }

    /// What its value is interpolated from: the entries of a cubic along the row, or the edges of its cell before and behind it, above and below.
    fn neighbours(self, grid: Entries, has_its_rows: bool) -> [Self; 4] {
        let Self { row, column, .. } = self;
        if has_its_rows {
            let first = 2 * stencil(self.column(), grid.1).first;
            return [0, 2, 4, 6].map(|halves| Self { column: first + halves, ..self });
        }
        let along = [column - 1, column + 1].map(|column| Self { column, ..self });
        let across = [row - 1, row + 1].map(|row| Self { row, ..self });
        [along[0], along[1], across[0], across[1]]
    }
}

/// The cells about some places of a grid; an image that has its rows goes through columns by cubics.
fn measure(sky: &SkyPlan, grid: Entries, middles: &[Place], has_its_rows: bool) -> Vec<Cell> {
    let uniform = &sky.integral().uniform;
    // Neighbours share most of what lies between them.
    let around = |&middle: &Place| std::iter::once(middle).chain(middle.neighbours(grid, has_its_rows));
    let mut places: Vec<Place> = middles.iter().flat_map(around).collect();
    places.sort_unstable();
    places.dedup();
    let views: Vec<Vec3> = places.iter().map(|place| place.view(uniform, grid)).collect();
    let constituents = sky.constituents(&views);
    let at = |place: Place| constituents[places.binary_search(&place).expect("every neighbour is among the places")];
    let cell = |&place: &Place| {
        let phases = sky.integral().phases(place.view(uniform, grid));
        let luminance = |Constituents { air, aerosol, rest }: Constituents| {
            f64::from(uniform.rgb.luminance(air * phases.air + aerosol * phases.aerosol + rest))
        };
        let middle = luminance(at(place));
        let neighbours = place.neighbours(grid, has_its_rows).map(|neighbour| luminance(at(neighbour)));
        let (error_along_elevation, error_along_azimuth) = if has_its_rows {
            let weights = stencil(place.column(), grid.1).weights.to_array().map(f64::from);
            let cubic: f64 = weights.into_iter().zip(neighbours).map(|(weight, value)| weight * value).sum();
            (0.0, (cubic - middle).abs())
        } else {
            let [before, behind, above, below] = neighbours;
            ((0.5 * (above + below) - middle).abs(), (0.5 * (before + behind) - middle).abs())
        };
        Cell { luminance: middle.abs(), error_along_elevation, error_along_azimuth }
    };
    middles.iter().map(cell).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PixelFormat;
    use crate::plan::Plan;
    use crate::scene::{Preset, Size};

    fn lookup(change: impl FnOnce(&mut Scene)) -> Lookup {
        let mut scene = Scene::preset(Preset::Earth).first_order();
        change(&mut scene);
        Plan::new(&scene.validated().unwrap(), PixelFormat::LinearRgb).lookup
    }

    #[test]
    fn an_equirectangular_image_shares_its_rows_with_its_lookup() {
        let size = lookup(|_| {}).size.expect("a sky lookup");
        assert_eq!((size.above, size.below), (256, 0));
        let from_12_km = lookup(|scene| scene.observer.altitude = 12.0).size.expect("a sky lookup");
        // 3.5° of 180° lie between level and the horizon.
        assert_eq!((from_12_km.above, from_12_km.below), (266, 246));
    }

    #[test]
    fn other_images_have_a_lookup_of_their_own() {
        let size = lookup(|scene| scene.camera.projection = Projection::Fisheye).size.expect("a sky lookup");
        assert!((COARSEST.0..=LARGEST.0).contains(&size.above), "{size:?}");
    }

    #[test]
    fn haze_around_a_low_sun_is_looked_up() {
        let lookup = lookup(|scene| {
            *scene = Scene::preset(Preset::Hazy);
            (scene.sun.elevation, scene.camera.projection) = (2.0, Projection::Perspective);
            scene.camera.size = Size { width: 960, height: 540 };
        });
        // A tenth of the pixels: by equal distances of the cosine of the azimuth no lookup up to the largest was enough.
        assert!(lookup.size.is_some_and(|size| size.entries() < 960 * 54), "{lookup}");
    }

    #[test]
    fn a_lookup_fits_into_a_buffer() {
        let tall = |height, choice| {
            lookup(|scene| (scene.camera.size, scene.render.path) = (Size { width: 1, height }, choice)).size
        };
        assert!(tall(300_000, PathChoice::Lookup).is_some_and(|size| size.entries() <= MOST_ENTRIES));
        assert!(tall(8_388_608, PathChoice::Lookup).is_none());
    }
}
