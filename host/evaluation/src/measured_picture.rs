//! The picture of `reproduce --measured`: the measured skies and ours, direction by direction.

use std::path::Path;

use sorairo::files::png;
use sorairo::low_level::plan::direction;
use sorairo::low_level::plan::picture::colour_space::ColourSpace;
use sorairo::low_level::spectra::observer;
use sorairo::scene::{ColourObserver, Preset, Rgb, Scene, WhiteBalance};
use sorairo_shared::display::tone::{NEAREST, srgb8};
use sorairo_shared::glam::{DMat3, DVec3};

use super::comparison::{Comparison, WIDTH};
use crate::problem::Result;

/// Side of a sky (pixels).
const SIDE: usize = 300;
/// Room around each.
const GAP: usize = 12;
/// What the mean luminance of the first sky becomes.
const GREY: f64 = 0.35;

/// A direction of a sky, and its colour (XYZ).
type Patch = (DVec3, DVec3);

/// Writes `measured.png`: a row for each scan, as measured and then under each atmosphere; the zenith in the middle,
/// north on top, east on the left. All are exposed alike. Directions that are not compared stay white.
///
/// # Errors
///
/// [`crate::Error::Sky`] for a file that cannot be written.
pub fn draw(folder: &Path, scans: &[&str], atmospheres: &[&[Comparison]]) -> Result<()> {
    let columns = 1 + atmospheres.len();
    let (width, height) = (columns * (SIDE + GAP) + GAP, scans.len() * (SIDE + GAP) + GAP);
    let mut rgb = vec![255; 3 * width * height];
    let skies: Vec<Vec<Vec<Patch>>> = scans.iter().map(|scan| skies(scan, atmospheres)).collect();
    let optics = Scene::preset(Preset::Standard).optics();
    let to_srgb = ColourSpace::new(Rgb::Srgb, WhiteBalance::None, ColourObserver::Cie1931, &optics).from_xyz;
    let first = &skies[0][0];
    let exposure = GREY * first.len() as f64 / first.iter().map(|(_, xyz)| xyz.y).sum::<f64>();
    for (row, skies) in skies.iter().enumerate() {
        for (column, sky) in skies.iter().enumerate() {
            let corner = (GAP + column * (SIDE + GAP), GAP + row * (SIDE + GAP));
            for (x, y, colour) in pixels(sky, to_srgb, exposure as f32) {
                let at = 3 * ((corner.1 + y) * width + corner.0 + x);
                rgb[at..at + 3].copy_from_slice(&colour);
            }
        }
    }
    Ok(png::write(&folder.join("measured.png"), width as u32, height as u32, &rgb)?.commit()?)
}

/// A scan's sky as measured, and under each atmosphere.
fn skies(scan: &str, atmospheres: &[&[Comparison]]) -> Vec<Vec<Patch>> {
    let measured = patches(scan, atmospheres[0], |c| c.measured);
    std::iter::once(measured).chain(atmospheres.iter().map(|sky| patches(scan, sky, |c| c.ours))).collect()
}

fn patches(scan: &str, comparisons: &[Comparison], radiance: fn(&Comparison) -> f64) -> Vec<Patch> {
    let same = |a: &&Comparison, b: &&Comparison| (a.elevation, a.azimuth) == (b.elevation, b.azimuth);
    let of_scan: Vec<&Comparison> = comparisons.iter().filter(|c| c.scan == scan).collect();
    let patch = |bands: &[&Comparison]| {
        let weight =
            |c: &Comparison| observer::weights(ColourObserver::Cie1931, c.wavelength) * (WIDTH / observer::STEP);
        let xyz = bands.iter().map(|c| weight(c) * radiance(c)).sum();
        (direction(bands[0].elevation, bands[0].azimuth), xyz)
    };
    of_scan.chunk_by(same).map(patch).collect()
}

/// The pixels of a sky: each shows the nearest direction, where one is near.
fn pixels(sky: &[Patch], to_srgb: DMat3, exposure: f32) -> impl Iterator<Item = (usize, usize, [u8; 3])> {
    /// Half the distance between directions, and some more (degrees).
    const NEAR: f64 = 14.0;
    let place = |i: usize| 2.0 * (i as f64 + 0.5) / SIDE as f64 - 1.0;
    (0..SIDE * SIDE).filter_map(move |i| {
        let (x, y) = (i % SIDE, i / SIDE);
        let from_zenith = place(x).hypot(place(y));
        let view = direction(90.0 - 90.0 * from_zenith, (-place(x)).atan2(-place(y)).to_degrees());
        let (toward, xyz) = sky.iter().max_by(|a, b| a.0.dot(view).total_cmp(&b.0.dot(view)))?;
        let is_near = from_zenith <= 1.0 && toward.dot(view) >= NEAR.to_radians().cos();
        let rgb = (to_srgb * *xyz).max(DVec3::ZERO).as_vec3();
        let [red, green, blue, _] = srgb8(rgb, exposure, NEAREST).to_le_bytes();
        is_near.then_some((x, y, [red, green, blue]))
    })
}
