//! How many rows and columns of a sky lookup keep what is interpolated near to the integral: a question of the sky alone, whoever looks at it.

use sorairo_shared::glam::Vec3;
use sorairo_shared::interpolation::azimuth::cosine_at_place;
use sorairo_shared::interpolation::cubic::stencil;
use sorairo_shared::picture::lookup::grid_view;
use sorairo_shared::sky::Constituents;
use sorairo_shared::uniform::Uniform;

use crate::plan::rays::integral::RayIntegral;

/// How far the sky lookup's colours may lie from the integral's, relative to the luminance of the direction or a tenth of the
/// sky's mean, whichever is larger: about a third of what the fit leaves.
pub const TOLERANCE: f64 = 1e-3;

/// How far they may lie from it anywhere, relative to the brightest direction: as far as single precision lets an explicit solve
/// and a folded matrix differ.
const TOLERANCE_OF_BRIGHTEST: f64 = 1e-4;

/// The sky lookup may not be finer than this. Where a sky would need more, at an edge of the planet's shadow or of a layer that a ray grazes, the error of straight lines falls with
/// their length alone, and these are short enough for what a pixel may be off by.
pub const LARGEST: Entries = (512, 256);

/// The most entries of a sky lookup of its own: three to an anchor where a sky asks for the [`LARGEST`].
pub const MOST: Entries = (384, 192);

/// The coarsest sky lookup, with which its error is measured.
pub const COARSEST: Entries = (48, 16);

/// The sky lookup may not have fewer columns than this: farther apart the error is no longer that of a low difference.
const FEWEST_AZIMUTHS: u32 = 8;

/// Entries from one anchor of the sky lookup to the next, where rays are of one piece. Where straight lines between
/// entries, `h` apart, are off by less than half of the tolerance, `h²/8L² < 5e-4` for what changes over `L`, and
/// cubics between anchors by `3/128 (3h/L)⁴ < 4e-5`.
const ENTRIES_PER_ANCHOR: f64 = 3.0;

/// The same where rays are of several pieces, and cost as much more: `3/128 (5h/L)⁴ < 3e-4`.
const ENTRIES_PER_COSTLY_ANCHOR: f64 = 5.0;

/// The same of the largest lookup, along rows and along columns. A sky that asks for it has edges, on which cubics are
/// no better than straight lines.
const ENTRIES_PER_ANCHOR_AT_EDGES: (f64, f64) = (4.0, 3.0);

/// The part of the largest lookup from which on anchors grow to those at edges: a climbing camera meets no jump.
const EDGES_FROM: f64 = 0.6;

/// Costly anchors are not fewer than these where a third of the entries is more: beside a sun on the horizon the sky
/// changes within a cell.
const FEWEST_COSTLY_ANCHORS: (f64, f64) = (60.0, 36.0);

/// The sky lookup may not have fewer anchors than these, rows on a side of the horizon and columns.
pub const FEWEST_ANCHORS: Entries = (24, 8);

/// Powers of the spacing by which the errors of straight lines and of cubics fall.
const LINEAR: f64 = 2.0;
/// See [`LINEAR`].
const CUBIC: f64 = 4.0;

/// Rows on a side of the horizon, and columns.
pub type Entries = (u32, u32);

/// A sky whose colours are known.
pub struct Seen<'a> {
    /// Its ray integral.
    pub integral: &'a RayIntegral,
    /// Linear RGB of each constituent in many directions.
    pub constituents: &'a dyn Fn(&[Vec3]) -> Vec<Constituents>,
}

/// For each kind of lookup, whether it has the rows of its image, rows and columns that keep interpolation within the tolerance, from its error on the coarsest grid, and then on the grid that follows from it; never
/// more than [`LARGEST`].
///
/// Midway between two entries, linear interpolation of a smooth function is off by an eighth of its second difference, which falls as the
/// square of the spacing, and a cubic by a part of its fourth difference, which falls as the fourth power. The error is measured there, on
/// sample cells, in both directions; the number of entries follows from it. Where the coarsest grid skips what is narrower than its cells, the
/// second one shows it.
pub fn enough(sky: &Seen, kinds: &[bool]) -> Vec<Entries> {
    let coarsest = sampled(sky, kinds.iter().map(|&has_its_rows| (COARSEST, has_its_rows)));
    let grids: Vec<Entries> = coarsest.iter().map(Sampled::enough).collect();
    let finer = sampled(sky, grids.iter().copied().zip(kinds.iter().copied()));
    let last = |(grid, finer): (Entries, &Sampled)| {
        let finer = finer.enough();
        (grid.0.max(finer.0), grid.1.max(finer.1))
    };
    grids.into_iter().zip(&finer).map(last).collect()
}

/// The anchors of a sky lookup of its own of so many entries, where each costs a ray of one piece, or of several.
pub fn anchors((rows, azimuths): Entries, are_costly: bool) -> Entries {
    let of = |entries: u32, most: u32, at_edges: f64, fewest: f64| {
        let cells = |per_anchor: f64| f64::from(entries - 1) / per_anchor;
        let edges = ((f64::from(entries) / f64::from(most) - EDGES_FROM) / (1.0 - EDGES_FROM)).max(0.0);
        let at_edges = cells(at_edges) - cells(ENTRIES_PER_COSTLY_ANCHOR);
        let costly = (cells(ENTRIES_PER_COSTLY_ANCHOR) + edges * at_edges).max(fewest).min(cells(ENTRIES_PER_ANCHOR));
        1 + if are_costly { costly } else { cells(ENTRIES_PER_ANCHOR) }.ceil() as u32
    };
    let ((of_rows, of_azimuths), fewest) = (ENTRIES_PER_ANCHOR_AT_EDGES, FEWEST_COSTLY_ANCHORS);
    let rows = of(rows, LARGEST.0, of_rows, fewest.0);
    let azimuths = of(azimuths, LARGEST.1, of_azimuths, fewest.1);
    (rows.max(FEWEST_ANCHORS.0), azimuths.max(FEWEST_ANCHORS.1))
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

/// Whether colours are within half of the tolerance of others, each relative to itself or a tenth of their mean.
pub fn are_near(colours: &[Vec3], truth: &[Vec3]) -> bool {
    let tenth = 0.1 * truth.iter().map(|rgb| rgb.element_sum()).sum::<f32>() / (3 * truth.len()) as f32;
    let worst = |(rgb, truth): (&Vec3, &Vec3)| ((*rgb - *truth).abs() / truth.max(Vec3::splat(tenth))).max_element();
    colours.iter().zip(truth).map(worst).all(|error| f64::from(error) <= 0.5 * TOLERANCE)
}

/// What interpolation does to sample cells of some grids, all looked at together: a device is asked once.
fn sampled(sky: &Seen, grids: impl Iterator<Item = (Entries, bool)>) -> Vec<Sampled> {
    let uniform = &sky.integral.uniform;
    let chosen: Vec<Chosen> = grids.map(|(grid, has_its_rows)| Chosen::new(uniform, grid, has_its_rows)).collect();
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
    has_its_rows: bool,
    /// Their middles.
    middles: Vec<Place>,
    /// These, and what is interpolated for them, in order: neighbours share most of what lies between them.
    places: Vec<Place>,
}

impl Chosen {
    /// Of a grid of rows and columns; an image that has its rows goes through columns by cubics.
    fn new(uniform: &Uniform, grid: Entries, has_its_rows: bool) -> Self {
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
        let around = |&middle: &Place| std::iter::once(middle).chain(middle.neighbours(grid, has_its_rows));
        let mut places: Vec<Place> = middles.iter().flat_map(around).collect();
        places.sort_unstable();
        places.dedup();
        Self { grid, has_its_rows, middles, places }
    }

    /// What interpolation does to them, from linear RGB of each constituent at all places.
    fn sampled(self, integral: &RayIntegral, constituents: &[Constituents]) -> Sampled {
        let Self { grid, has_its_rows, .. } = self;
        let uniform = &integral.uniform;
        let at = |place: Place| {
            constituents[self.places.binary_search(&place).expect("every neighbour is among the places")]
        };
        let cell = |&place: &Place| {
            let phases = integral.phases(place.view(uniform, grid));
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
        let cells: Vec<Cell> = self.middles.iter().map(cell).collect();
        let mean = cells.iter().map(|cell| cell.luminance).sum::<f64>() / cells.len() as f64;
        Sampled { grid, has_its_rows, cells, mean }
    }
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
        let (parts, power) = if self.has_its_rows { (1.0, CUBIC) } else { (2.0, LINEAR) };
        let entries = |entries: u32, error: f64, power: f64| {
            1 + (f64::from(entries - 1) * (parts * error).powf(1.0 / power)).ceil().min(f64::from(LARGEST.0)) as u32
        };
        let rows = entries(self.grid.0, worst(|cell| cell.error_along_elevation), LINEAR);
        let azimuths = entries(self.grid.1, worst(|cell| cell.error_along_azimuth), power);
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
