//! The choice between the integral at every pixel and interpolation from a sky lookup.

pub(crate) mod grid;

use std::f64::consts::PI;
use std::fmt;
use std::ops::Range;

use serde::Serialize;
use sorairo_shared::camera::{EQUIRECTANGULAR, PERSPECTIVE};
use sorairo_shared::glam::Vec4;
use sorairo_shared::kernels::LOOKUP_WORKGROUP;
use sorairo_shared::picture::run::{RUN, is_long};
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant;

use crate::plan::lookup::grid::{COARSEST, Entries, FEWEST_ANCHORS, GridKind, LARGEST, MOST, TOLERANCE};
use crate::plan::sky::SkyPlan;
use crate::scene::{ColourPath, PathChoice, Projection, Scene};

/// The maximum number of entries of a sky lookup with the rows of its image. With three colours they take 128 MiB,
/// which every Vulkan device supports as one buffer, and one dispatch fills them.
const MOST_ENTRIES: u64 = (1 << 27) / (3 * size_of::<Vec4>() as u64);
const _: () = assert!(MOST_ENTRIES <= 65_535 * LOOKUP_WORKGROUP as u64);

/// The sky lookup is faster from this number of pixels per anchor: an anchor costs one integral, a pixel a small
/// fraction of one.
const PIXELS_PER_ANCHOR: u64 = 2;

/// The number of entries of a sky lookup that cost as much as one anchor.
const ENTRIES_PER_INTEGRAL: u64 = 16;

/// The path of an image, and its reason.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Lookup {
    /// Size of the sky lookup; `None` if every pixel is integrated.
    #[serde(rename = "table")]
    pub size: Option<LookupSize>,
    /// Its anchors, the only integrated directions.
    pub anchors: Option<LookupSize>,
    /// The reason.
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

/// Chooses the path of an image of a scene's sky.
pub fn choose(scene: &Scene, sky: &SkyPlan, lit_rows: &Range<u32>) -> Lookup {
    let direct = |reason: String| Lookup { size: None, anchors: None, reason };
    let pixels = u64::from(scene.camera.size.width) * lit_rows.len() as u64;
    let fewest = grid(scene, FEWEST_ANCHORS).entries();
    // A polariser stands before pixels that are looked up alone.
    let is_asked = scene.render.path == PathChoice::Lookup || scene.camera.polariser.is_some();
    match scene.render.path {
        _ if sky.is_night => return direct("nothing is lit".into()),
        PathChoice::Direct => return direct("asked for".into()),
        _ if sky.colour_path == ColourPath::Solve => return direct("an explicit solve is made at every pixel".into()),
        _ if sized(scene, sky, lit_rows, COARSEST).azimuths < COARSEST.1 => {
            return direct("a sky lookup with as many rows as the image would be too large".into());
        }
        PathChoice::Auto if !is_asked && pixels < PIXELS_PER_ANCHOR * fewest => {
            return direct(format!("{pixels} lit pixels are fewer than a sky lookup would need"));
        }
        PathChoice::Auto | PathChoice::Lookup => {}
    }
    let has_its_rows = scene.camera.projection == Projection::Equirectangular;
    let enough = sky.lookup_grid(if has_its_rows { GridKind::Rows } else { GridKind::Own });
    let size = sized(scene, sky, lit_rows, enough);
    let anchors = grid(scene, sky.lookup_anchors());
    let integrals = anchors.entries() + size.entries() / ENTRIES_PER_INTEGRAL;
    if !is_asked && has_its_rows && size.azimuths < enough.1 {
        return direct("a sky lookup with as many rows as the image would be too large".into());
    }
    if !is_asked && pixels < PIXELS_PER_ANCHOR * integrals {
        let (anchors, entries) = (anchors.entries(), size.entries());
        return direct(format!(
            "{pixels} lit pixels are fewer than {anchors} anchors and {entries} entries of a sky lookup pay for"
        ));
    }
    // What lies between anchors is as near as a lookup of its own, which they are for.
    let own = sky.lookup_grid(GridKind::Own);
    let within = if own.0 < MOST.0 && own.1 < MOST.1 && enough.1 < LARGEST.1 {
        format!("keep it within {TOLERANCE:e} of the integral")
    } else {
        "make it as fine as it may be".into()
    };
    let reason = format!("{} entries between {} anchors {within}", size.entries(), anchors.entries());
    Lookup { size: Some(size), anchors: Some(anchors), reason }
}

/// A sky lookup of some rows on each side of the horizon, and columns.
pub fn grid(scene: &Scene, (rows, azimuths): Entries) -> LookupSize {
    LookupSize { above: rows, below: if scene.observer.altitude > 0.0 { rows } else { 0 }, azimuths }
}

/// The sky lookup that stands for such a grid: an equirectangular image has its own rows, and as many columns as fit.
fn sized(scene: &Scene, sky: &SkyPlan, lit_rows: &Range<u32>, (rows, azimuths): Entries) -> LookupSize {
    if scene.camera.projection != Projection::Equirectangular {
        return grid(scene, (rows.min(MOST.0), azimuths.min(MOST.1)));
    }
    let lit = lit_rows.end - lit_rows.start;
    let from_top = (0.5 - f64::from(sky.integral().uniform.horizon) / PI) * f64::from(scene.camera.size.height);
    let above = ((from_top + 0.5) as u32).min(lit);
    // On the ground itself what lies below is one colour.
    let below = if scene.observer.altitude > 0.0 { lit - above } else { 0 };
    LookupSize { above, below, azimuths: azimuths.min((MOST_ENTRIES / u64::from(above + below)) as u32) }
}

/// The most samples along a side of a pixel of the sun's disc with which pixels run: an invocation computes those of a
/// run one after the other.
const MOST_SAMPLES_IN_RUNS: u32 = 32;

/// Cells over which a run of a perspective may reach where they are narrowest: a cubic along it is then off by less
/// than a hundredth of what straight lines leave between entries. With the scale `L` of the sky's features the lines
/// leave `h²/8L²` at the spacing `h`, which the tolerance keeps below `L/15`, and the cubic `(4h/3)⁴/24L⁴`.
const CELLS_OF_PERSPECTIVE: f64 = 4.0;

/// The same of a long run of an equirectangular image. Where more columns are needed, from orbit in twilight, they
/// stand for an edge of the planet's shadow: runs over six cells left single pixels there off by .7 of themselves.
const CELLS_OF_ROW: f64 = 4.0;

/// The longest of these (radians): that of an image of 1024 columns.
const LONGEST_RUN: f64 = 0.1;

/// Whether a run through four places, of this angle, reaches over so many cells at most where they are narrowest, at
/// the sun's azimuth.
fn reaches_over(run: f64, cells: f64, azimuths: u32) -> bool {
    run <= cells * 2.0 / f64::from(azimuths - 1)
}

/// Whether the pixels of an image can be looked up in [`variant::RUNS`] in a sky lookup of this size.
///
/// Entries are closest together at the sun's azimuth; see [`sorairo_shared::interpolation::azimuth`]. In an
/// equirectangular image aerosol whose phase function has its peak behind has no runs, see
/// [`sorairo_shared::picture::run`]; in a perspective a camera that does not stand upright has none, whose rows cross
/// the horizon.
pub fn pixels_run(uniform: &Uniform, variant: u32, size: LookupSize) -> bool {
    let width = uniform.camera.width;
    let has_fine_disc = variant & variant::SUN_DISC != 0 && uniform.disc.samples > MOST_SAMPLES_IN_RUNS;
    let scatters_back = variant & variant::AEROSOL != 0 && uniform.atmosphere.aerosol_asymmetry < 0.0;
    let crosses_horizon = uniform.camera.right.z != 0.0;
    let rays_have_pieces = variant & (variant::SHADOW | variant::DESCENT) != 0;
    let has_short_runs = match variant::projection(variant) {
        // By day on the ground there is no need of long runs.
        EQUIRECTANGULAR => {
            let are_short = !is_long(width, size.azimuths);
            let turn = f64::from(RUN) * 2.0 * PI / f64::from(width);
            !scatters_back
                && (are_short
                    || rays_have_pieces && turn <= LONGEST_RUN && reaches_over(turn, CELLS_OF_ROW, size.azimuths))
        }
        // What stands for directions below the horizon lies on no great circle.
        PERSPECTIVE if variant & variant::BELOW != 0 => false,
        PERSPECTIVE => {
            // As wide as it is seen in the middle.
            let run = f64::from(RUN) * 2.0 * f64::from(uniform.camera.half_field) / f64::from(width);
            !crosses_horizon && reaches_over(run, CELLS_OF_PERSPECTIVE, size.azimuths)
        }
        _ => false,
    };
    width.is_multiple_of(RUN) && !has_fine_disc && has_short_runs
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
    fn pixels_run_where_aerosol_scatters_forward() {
        let runs = |asymmetry| {
            let mut scene = Scene::preset(Preset::Earth).first_order();
            (scene.atmosphere.aerosol.asymmetry, scene.camera.size) = (asymmetry, Size { width: 1920, height: 960 });
            Plan::new(&scene.validated().unwrap(), PixelFormat::LinearRgb).variant & variant::RUNS != 0
        };
        assert!(runs(0.7) && runs(0.0) && !runs(-0.2));
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
        // A tenth of the pixels: by equal distances of the cosine of the azimuth no lookup up to the largest was
        // enough.
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
