//! The number of rows and columns with which a sky lookup stays within the tolerance of the integral. It depends on the
//! sky alone.

use sorairo_shared::glam::Vec3;
use sorairo_shared::interpolation::azimuth::cosine_at_place;
use sorairo_shared::interpolation::cubic::stencil;
use sorairo_shared::math::max;
use sorairo_shared::picture::lookup::grid_view;
use sorairo_shared::sky::Constituents;
use sorairo_shared::uniform::Uniform;

use crate::plan::integral::RayIntegral;

/// The tolerance of colours of the sky lookup, relative to the luminance of the direction or to a tenth of the sky's
/// mean, whichever is larger: about a third of the error of the fit.
pub const TOLERANCE: f64 = 1e-3;

/// The tolerance anywhere, relative to the brightest direction: the difference between an explicit solve and a folded
/// matrix in single precision.
const TOLERANCE_OF_BRIGHTEST: f64 = 1e-4;

/// The largest sky lookup. At an edge of the planet's shadow, or of a layer that a ray grazes, a sky may need more. The
/// error of linear interpolation decreases only with the spacing there, which is small enough here for the error bound
/// of a pixel.
pub const LARGEST: Entries = (512, 256);

/// The maximum number of entries of a sky lookup without the rows of its image. Its errors at edges are along
/// elevation, and more columns do not reduce them.
pub const MOST: Entries = (512, 192);

/// The coarsest sky lookup, on which the error is measured.
pub const COARSEST: Entries = (48, 16);

/// The minimum number of columns: with larger spacings the error is no longer that of a low-order difference.
const FEWEST_AZIMUTHS: u32 = 8;

/// Entries per anchor of the sky lookup. Where linear interpolation between entries with a spacing `h` has an error
/// below half of the tolerance, `h²/8L² < 5e-4` for a feature of the scale `L`, cubics between anchors have
/// `3/128 (3h/L)⁴ < 4e-5`. This is the ratio if rays have one piece; if they have several, and cost several times as
/// much, there are at least as many.
const ENTRIES_PER_ANCHOR: u32 = 3;

/// The minimum number of anchors: rows on a side of the horizon, and columns.
pub const FEWEST_ANCHORS: Entries = (24, 8);

/// The minimum number of columns of anchors if the planet's shadow is visible and each anchor has three entries. The
/// edge of the shadow is a kink, which the sample cells of the error may miss. With fewer columns a pixel had an error
/// of 3.2e-2, with these 2.4e-2.
const FEWEST_ACROSS_SHADOW: u32 = 48;

/// What a direction counts for at most when samples are judged, as a part of the brightest one: 1.5e-5 of that may be
/// off.
const PART_OF_BRIGHTEST: f32 = 0.03;

/// Powers of the spacing by which the errors of straight lines and of cubics fall.
const LINEAR: f64 = 2.0;
/// See [`LINEAR`].
const CUBIC: f64 = 4.0;

/// Rows on a side of the horizon, and columns.
pub type Entries = (u32, u32);

/// What a grid of directions is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridKind {
    /// Entries of a sky lookup of its own, with straight lines between them.
    Own,
    /// Entries of a sky lookup that has the rows of its image, with cubics along them.
    Rows,
    /// Anchors, with cubics between them in both directions.
    Anchors,
}

impl GridKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Own, Self::Rows, Self::Anchors];
}

/// A sky whose colours are known.
pub struct Seen<'a> {
    /// Its ray integral.
    pub integral: &'a RayIntegral,
    /// Linear RGB of each constituent in many directions.
    pub constituents: &'a dyn Fn(&[Vec3]) -> Vec<Constituents>,
}

/// For each kind of grid, the rows and columns that keep interpolation within the tolerance, at most [`LARGEST`]. They
/// follow from the error on the coarsest grid, and then on the grid derived from it.
///
/// Midway between two entries, linear interpolation of a smooth function has an error of an eighth of its second
/// difference, which decreases as the square of the spacing. A cubic has a fraction of its fourth difference, which
/// decreases as the fourth power. The error is measured there, on sample cells, along both axes, and determines the
/// number of entries. The second grid shows features that are narrower than the cells of the coarsest one.
pub fn enough(sky: &Seen, kinds: &[GridKind]) -> Vec<Entries> {
    let coarsest = sampled(sky, kinds.iter().map(|&kind| (COARSEST, kind)));
    let grids: Vec<Entries> = coarsest.iter().map(Sampled::enough).collect();
    let finer = sampled(sky, grids.iter().copied().zip(kinds.iter().copied()));
    let last = |(grid, finer): (Entries, &Sampled)| {
        let finer = finer.enough();
        (grid.0.max(finer.0), grid.1.max(finer.1))
    };
    grids.into_iter().zip(&finer).map(last).collect()
}

/// The anchors of a sky lookup that would have so many entries of its own: three entries to each, or fewer that are
/// enough.
pub fn anchors((rows, azimuths): Entries, enough: Option<Entries>, has_shadow: bool) -> Entries {
    let most = |entries: u32| 1 + (entries - 1).div_ceil(ENTRIES_PER_ANCHOR);
    let most = (most(rows), most(azimuths));
    let across_shadow = if has_shadow { FEWEST_ACROSS_SHADOW } else { 0 };
    let (rows, azimuths) = enough.map_or(most, |(rows, azimuths)| (rows, azimuths.max(across_shadow)));
    (rows.min(most.0).max(FEWEST_ANCHORS.0), azimuths.min(most.1).max(FEWEST_ANCHORS.1))
}

/// Directions of a sky lookup in which its samples are tried.
pub fn tried_views(uniform: &Uniform) -> Vec<Vec3> {
    const ROWS: u32 = 12;
    const COLUMNS: u32 = 8;
    let sides: &[bool] = if uniform.altitude > 0.0 { &[true, false] } else { &[true] };
    let middle = |place: u32, places: u32| (place as f32 + 0.5) / places as f32;
    let in_row = |(above, row)| {
        (0..COLUMNS)
            .map(move |column| grid_view(uniform, above, middle(row, ROWS), cosine_at_place(middle(column, COLUMNS))))
    };
    sides.iter().flat_map(|&above| (0..ROWS).map(move |row| (above, row))).flat_map(in_row).collect()
}

/// Whether colours are within half of the tolerance of others, each relative to itself or a tenth of their mean, and
/// nearer where those are brightest: in twilight all light of a picture may come from a hundredth of it.
pub fn are_near(colours: &[Vec3], truth: &[Vec3]) -> bool {
    let tenth = 0.1 * truth.iter().map(|rgb| rgb.element_sum()).sum::<f32>() / (3 * truth.len()) as f32;
    let brightest = truth.iter().map(|rgb| rgb.max_element()).fold(0.0, max);
    let relative_to = |truth: &Vec3| truth.min(Vec3::splat(PART_OF_BRIGHTEST * brightest)).max(Vec3::splat(tenth));
    let worst = |(rgb, truth): (&Vec3, &Vec3)| ((*rgb - *truth).abs() / relative_to(truth)).max_element();
    colours.iter().zip(truth).map(worst).all(|error| f64::from(error) <= 0.5 * TOLERANCE)
}

/// What interpolation does to sample cells of some grids, all looked at together: a device is asked once.
fn sampled(sky: &Seen, grids: impl Iterator<Item = (Entries, GridKind)>) -> Vec<Sampled> {
    let uniform = &sky.integral.uniform;
    let chosen: Vec<Chosen> = grids.map(|(grid, kind)| Chosen::new(uniform, grid, kind)).collect();
    let views: Vec<Vec3> =
        chosen.iter().flat_map(|of| of.places.iter().map(|place| place.view(uniform, of.grid))).collect();
    if views.is_empty() {
        return Vec::new();
    }
    let constituents = (sky.constituents)(&views);
    let mut rest = &constituents[..];
    let of_chosen = |of: Chosen| {
        let (found, others) = rest.split_at(of.places.len());
        rest = others;
        of.sampled(sky.integral, found)
    };
    chosen.into_iter().map(of_chosen).collect()
}

/// Sample cells of a grid.
struct Chosen {
    grid: Entries,
    kind: GridKind,
    /// Their middles.
    middles: Vec<Place>,
    /// These, and what is interpolated for them, in order: neighbours share most of what lies between them.
    places: Vec<Place>,
}

impl Chosen {
    /// Of a grid of rows and columns.
    fn new(uniform: &Uniform, grid: Entries, kind: GridKind) -> Self {
        let sides: &[bool] = if uniform.altitude > 0.0 { &[true, false] } else { &[true] };
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
        let around = |&middle: &Place| std::iter::once(middle).chain(middle.neighbours(grid, kind));
        let mut places: Vec<Place> = middles.iter().flat_map(around).collect();
        places.sort_unstable();
        places.dedup();
        Self { grid, kind, middles, places }
    }

    /// What interpolation does to them, from linear RGB of each constituent at all places.
    fn sampled(self, integral: &RayIntegral, constituents: &[Constituents]) -> Sampled {
        let Self { grid, kind, .. } = self;
        let uniform = &integral.uniform;
        let at = |place: Place| {
            constituents[self.places.binary_search(&place).expect("every neighbour is among the places")]
        };
        let cell = |&place: &Place| {
            let view = place.view(uniform, grid);
            let luminance = |of: Constituents| f64::from(uniform.rgb.luminance(integral.rgb(view, of)));
            let middle = luminance(at(place));
            let error = |between: &[(Place, f64)]| {
                let sum: f64 = between.iter().map(|&(place, weight)| weight * luminance(at(place))).sum();
                if between.is_empty() { 0.0 } else { (sum - middle).abs() }
            };
            let [along, across] = place.between(grid, kind);
            let (error_along_elevation, error_along_azimuth) = (error(&across), error(&along));
            Cell { luminance: middle.abs(), error_along_elevation, error_along_azimuth }
        };
        let cells: Vec<Cell> = self.middles.iter().map(cell).collect();
        let mean = cells.iter().map(|cell| cell.luminance).sum::<f64>() / cells.len() as f64;
        Sampled { grid, kind, cells, mean }
    }
}

/// What interpolation does to sample cells of a grid.
struct Sampled {
    grid: Entries,
    kind: GridKind,
    cells: Vec<Cell>,
    /// The mean luminance.
    mean: f64,
}

impl Sampled {
    /// Rows and columns that are enough, or the largest that may be.
    fn enough(&self) -> Entries {
        if self.mean <= 0.0 {
            return COARSEST;
        }
        let brightest = self.cells.iter().map(|cell| cell.luminance).fold(0.0, f64::max);
        let allowed =
            |cell: &Cell| (TOLERANCE * cell.luminance.max(0.1 * self.mean)).min(TOLERANCE_OF_BRIGHTEST * brightest);
        let worst =
            |error: fn(&Cell) -> f64| self.cells.iter().map(|cell| error(cell) / allowed(cell)).fold(0.0, f64::max);
        // Each direction that is interpolated may take its part of the tolerance.
        let parts = if self.kind == GridKind::Rows { 1.0 } else { 2.0 };
        let power = if self.kind == GridKind::Own { LINEAR } else { CUBIC };
        let entries = |entries: u32, error: f64| {
            1 + (f64::from(entries - 1) * (parts * error).powf(1.0 / power)).ceil().min(f64::from(LARGEST.0)) as u32
        };
        let rows = entries(self.grid.0, worst(|cell| cell.error_along_elevation));
        let azimuths = entries(self.grid.1, worst(|cell| cell.error_along_azimuth));
        (rows.clamp(COARSEST.0, LARGEST.0), azimuths.clamp(FEWEST_AZIMUTHS, LARGEST.1))
    }
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

    /// All that its value is interpolated from.
    fn neighbours(self, grid: Entries, kind: GridKind) -> impl Iterator<Item = Self> {
        self.between(grid, kind).into_iter().flatten().map(|(place, _)| place)
    }

    /// What its value is interpolated from along the row, and across rows, each with its weight.
    fn between(self, grid: Entries, kind: GridKind) -> [Vec<(Self, f64)>; 2] {
        let Self { row, column, .. } = self;
        let along = nodes(column, grid.1, kind).map(|(column, weight)| (Self { column, ..self }, weight)).collect();
        let across = nodes(row, grid.0, kind).map(|(row, weight)| (Self { row, ..self }, weight));
        [along, across.filter(|_| kind != GridKind::Rows).collect()]
    }
}

/// The nodes of straight lines or cubics in the middle of a cell, with their weights.
fn nodes(middle: u32, count: u32, kind: GridKind) -> impl Iterator<Item = (u32, f64)> {
    let near = stencil(0.5 * middle as f32, count);
    let cubic = (2 * near.first, near.weights.to_array());
    let (first, weights) = if kind == GridKind::Own { (middle - 1, [0.5, 0.5, 0.0, 0.0]) } else { cubic };
    let node = move |(index, weight): (u32, f32)| (first + 2 * index, f64::from(weight));
    (0..).zip(weights).map(node).filter(|&(_, weight)| weight != 0.0)
}
