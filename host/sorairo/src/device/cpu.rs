//! The kernels on the CPU's cores.

use std::collections::VecDeque;
use std::ops::Range;
use std::time::Duration;

use rayon::prelude::*;
use sorairo_shared::glam::{UVec2, Vec4};
use sorairo_shared::kernels::{SENTINEL, sky_pixel};
use sorairo_shared::picture::lookup::{anchors, colours_per_entry, entries, is_anchor_read};
use sorairo_shared::processor::kernels::{lookup_anchors, lookup_entries, lookup_row, sky_row};
use sorairo_shared::processor::lanes::BLOCK;
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant::{self, is_solved_cubic};
use web_time::Instant;

use super::backend::{Backend, TakeRows, Times};
use super::chosen::{Device, DeviceKind};
use super::rows::words_per_row;
use crate::error::Result;
use crate::plan::{Kernel, Plan};

/// All cores, one row of the image at a time.
pub struct Cpu;

impl Device {
    /// The CPU as a device.
    pub fn cpu() -> Self {
        let cores = rayon::current_num_threads();
        Self {
            name: format!("CPU ({cores} threads)"),
            kind: DeviceKind::Cpu,
            backend: Box::new(Cpu),
            spares: VecDeque::new(),
        }
    }
}

impl Backend for Cpu {
    fn lit_rows(&self, plan: &Plan, kernel: Kernel, rows: Range<u32>, take: &mut TakeRows<'_>) -> Result<Times> {
        let row_words = words_per_row(plan);
        let at_once = rows_in_cache(plan).min(rows.len() as u32);
        let mut words = vec![0; row_words * at_once as usize];
        let start = Instant::now();
        let lookup = if kernel == Kernel::SkyLookup { sky_lookup(plan) } else { Vec::new() };
        let mut computing = start.elapsed();
        for first in rows.clone().step_by(at_once as usize) {
            let start = Instant::now();
            let words = &mut words[..row_words * at_once.min(rows.end - first) as usize];
            words.par_chunks_mut(row_words).zip(first as usize..rows.end as usize).for_each(|(words, row)| {
                // Each chunk is the output of a dispatch of one row.
                let uniform = Uniform { first_row: row as u32, rows: 1, ..plan.uniform };
                store_row(&uniform, plan, kernel, &lookup, words);
            });
            computing += start.elapsed();
            take(first, words)?;
        }
        Ok(Times { kernel: computing, readback: Duration::ZERO })
    }
}

/// Rows that are computed at once: enough for all cores, few enough to be in a cache still when they are taken.
fn rows_in_cache(plan: &Plan) -> u32 {
    const PIXELS: u32 = 1 << 17;
    (PIXELS / plan.width()).max(1)
}

/// Rows of entries of a sky lookup that a core computes at once: enough that most of them share what lies between
/// anchors.
const ROWS_OF_ENTRIES: usize = 16;

/// The sky lookup of a plan: its anchors, so far as they are read, and the entries between them.
fn sky_lookup(plan: &Plan) -> Vec<Vec4> {
    let (uniform, variant) = (&plan.uniform, Kernel::Lookup.variant(plan.variant));
    let colours = colours_per_entry(variant) as usize;
    let are_read: Vec<bool> =
        (0..anchors(uniform)).into_par_iter().map(|anchor| is_anchor_read(uniform, anchor, variant)).collect();
    let of_anchors = anchors_of(plan, &are_read);
    let mut lookup = vec![Vec4::ZERO; colours * entries(uniform) as usize];
    let words = ROWS_OF_ENTRIES * uniform.lookup_azimuths as usize * colours;
    lookup.par_chunks_mut(words).enumerate().for_each(|(chunk, entries)| {
        lookup_entries(uniform, &of_anchors, &are_read, entries, (ROWS_OF_ENTRIES * chunk) as u32, variant);
    });
    lookup
}

/// The anchors of a plan's sky lookup; black where they are not read.
fn anchors_of(plan: &Plan, are_read: &[bool]) -> Vec<Vec4> {
    let colours = colours_per_entry(plan.variant) as usize;
    let read: Vec<u32> = (0..).zip(are_read).filter(|&(_, &is_read)| is_read).map(|(anchor, _)| anchor).collect();
    let mut found = vec![Vec4::ZERO; colours * read.len()];
    found.par_chunks_mut(BLOCK * colours).zip(read.par_chunks(BLOCK)).for_each(|(anchors, indices)| {
        lookup_anchors(&plan.uniform, plan.buffers(), indices, anchors, Kernel::Anchors.variant(plan.variant));
    });
    let mut all = vec![Vec4::ZERO; colours * are_read.len()];
    for (anchor, found) in read.into_iter().zip(found.chunks_exact(colours)) {
        all[colours * anchor as usize..][..colours].copy_from_slice(found);
    }
    all
}

/// A row of an image, that with which the uniform's dispatch begins.
fn store_row(uniform: &Uniform, plan: &Plan, kernel: Kernel, lookup: &[Vec4], words: &mut [u32]) {
    let (buffers, variant) = (plan.buffers(), plan.variant);
    let pixels = (0..plan.width()).map(|column| UVec2::new(column, 0));
    match kernel {
        Kernel::Fill => words.fill(SENTINEL),
        Kernel::SkyLookup => lookup_row(uniform, buffers.colour, lookup, words, variant),
        _ if plan.holds_light() => pixels.for_each(|pixel| sky_pixel(uniform, buffers, words, pixel, variant)),
        _ if is_solved_cubic(variant) => {
            // Known to the compiler, the fit is not chosen again at every pixel.
            let variant = variant & !(variant::FIT | variant::LIGHT) | variant::SOLVED;
            pixels.for_each(|pixel| sky_pixel(uniform, buffers, words, pixel, variant));
        }
        _ => sky_row(uniform, buffers, words, variant),
    }
}

#[cfg(test)]
mod tests {
    use sorairo_shared::glam::Vec3;
    use sorairo_shared::kernels::{
        ANCHOR_LANES, LOOKUP_WORKGROUP, anchor_light, keep_anchor_part, lookup_invocations, lookup_pixel,
    };
    use sorairo_shared::picture::lookup::{anchor_view, entry_between_anchors, store_entry};
    use sorairo_shared::processor::kernels::{constituents_of_directions, light_of_directions, plain};
    use sorairo_shared::sky::{ByConstituent, Constituents, constituents, light};
    use sorairo_shared::variant::PixelFormat;
    use strum::IntoEnumIterator;

    use super::*;
    use crate::plan::rays::directions::direction;
    use crate::scene::{ColourPath, Fit, PathChoice, Preset, Projection, Scene};

    /// Neither a multiple of a block nor of eight lanes.
    const SIZE: &str = "148x21";

    const FORMATS: [PixelFormat; 4] =
        [PixelFormat::LinearRgb, PixelFormat::Picture, PixelFormat::HalfRgb, PixelFormat::LinearRgba];

    /// The rows of a plan's image in its middle and at its ends, each by `row`.
    fn rows(plan: &Plan, row: impl Fn(&Uniform, &mut [u32])) -> Vec<u32> {
        let rows = [0, 7, plan.height() / 2, plan.height() - 1].into_iter().filter(|row| plan.lit_rows.contains(row));
        rows.flat_map(|first_row| {
            let mut words = vec![SENTINEL; words_per_row(plan)];
            row(&Uniform { first_row, rows: 1, ..plan.uniform }, &mut words);
            words
        })
        .collect()
    }

    /// The lookup of a plan, and rows of its image, by blocks as the device computes them, by blocks without AVX2, and
    /// pixel by pixel as a GPU does.
    fn ways(plan: &Plan) -> [(Vec<Vec4>, Vec<u32>); 3] {
        let plan = &Plan { uniform: Uniform { fills_whole_lookup: 1, ..plan.uniform }, ..plan.clone() };
        let (buffers, variant) = (plan.buffers(), plan.variant);
        if plan.kernel() != Kernel::SkyLookup {
            let by_blocks = rows(plan, |uniform, words| sky_row(uniform, buffers, words, variant));
            let by_plain_blocks = rows(plan, |uniform, words| plain::sky_row(uniform, buffers, words, variant));
            let by_pixels = rows(plan, |uniform, words| {
                (0..plan.width()).for_each(|column| sky_pixel(uniform, buffers, words, UVec2::new(column, 0), variant));
            });
            return [by_blocks, by_plain_blocks, by_pixels].map(|rows| (Vec::new(), rows));
        }
        let lookup = sky_lookup(plan);
        let colours = colours_per_entry(variant) as usize;
        let of_anchors = colours * anchors(&plan.uniform) as usize;
        let mut plain_anchors = vec![Vec4::ZERO; of_anchors];
        let indices: Vec<u32> = (0..anchors(&plan.uniform)).collect();
        for (indices, anchors) in indices.chunks(BLOCK).zip(plain_anchors.chunks_mut(BLOCK * colours)) {
            plain::lookup_anchors(&plan.uniform, buffers, indices, anchors, variant);
        }
        let mut plain_lookup = vec![Vec4::ZERO; lookup.len()];
        let are_read = vec![true; indices.len()];
        plain::lookup_entries(&plan.uniform, &plain_anchors, &are_read, &mut plain_lookup, 0, variant);
        // As on a device, the anchors lie behind the entries.
        let count = entries(&plan.uniform);
        let mut entry_by_entry = vec![Vec4::ZERO; lookup.len() + of_anchors];
        for anchor in 0..anchors(&plan.uniform) {
            let rgb = constituents(&plan.uniform, buffers, anchor_view(&plan.uniform, anchor), variant);
            store_entry(&mut entry_by_entry, count + anchor, rgb, variant);
        }
        for entry in 0..count {
            let rgb = entry_between_anchors(&plan.uniform, &entry_by_entry, count, entry, variant);
            store_entry(&mut entry_by_entry, entry, rgb, variant);
        }
        entry_by_entry.truncate(lookup.len());
        let colour = buffers.colour;
        let by_blocks = rows(plan, |uniform, words| lookup_row(uniform, colour, &lookup, words, variant));
        let by_plain_blocks = rows(plan, |uniform, words| plain::lookup_row(uniform, colour, &lookup, words, variant));
        let by_pixels = rows(plan, |uniform, words| {
            for column in 0..lookup_invocations(uniform, variant) {
                lookup_pixel(uniform, colour, &lookup, words, UVec2::new(column, 0), variant);
            }
        });
        [(lookup, by_blocks), (plain_lookup, by_plain_blocks), (entry_by_entry, by_pixels)]
    }

    /// Holds the ways of a scene's plan to each other.
    fn check(scene: &Scene, format: PixelFormat) -> Plan {
        let plan = Plan::new(&scene.validated().unwrap(), format);
        let camera = &scene.camera;
        let (projection, sun, altitude) = (camera.projection, scene.sun.elevation, scene.observer.altitude);
        let what = format!("{projection:?}, {format:?}, {sun}°, {altitude} km, {:?}", plan.kernel());
        let [blocks, plain, pixels] = ways(&plan);
        assert!(blocks.1.len() > 100 && blocks.1.windows(13).any(|words| words[0] != words[12]), "{what}");
        assert!(!blocks.1.contains(&SENTINEL), "{what}: a pixel is missing");
        let bits = |lookup: &[Vec4]| lookup.iter().flat_map(|colour| colour.to_array().map(f32::to_bits)).collect();
        let [blocks, plain, pixels] = [blocks, plain, pixels].map(|(lookup, rows)| [bits(&lookup), rows]);
        // Every bit: on no way is a product fused with a sum, or a sum taken in another order.
        assert!(blocks == plain, "{what}: with and without AVX2");
        assert!(blocks == pixels, "{what}: in blocks and alone");
        plan
    }

    fn scene(preset: Preset, sun: f64, projection: Projection) -> Scene {
        let mut scene = Scene::preset(preset);
        (scene.sun.elevation, scene.sun.azimuth, scene.sun.disc) = (sun, 40.0, true);
        (scene.camera.projection, scene.camera.size) = (projection, SIZE.parse().unwrap());
        if projection == Projection::Perspective {
            scene.camera.look_elevation = Some(10.0);
        }
        scene
    }

    #[test]
    fn pixels_have_the_same_bits_in_blocks_and_alone_with_and_without_avx2() {
        let presets = [Preset::Standard, Preset::Paper, Preset::Hazy, Preset::Mountain, Preset::Mars];
        let mut formats = FORMATS.into_iter().cycle();
        for preset in presets {
            for sun in [30.0, 3.0, -4.0] {
                for projection in Projection::iter() {
                    let mut scene = scene(preset, sun, projection);
                    for path in [PathChoice::Direct, PathChoice::Lookup] {
                        scene.render.path = path;
                        check(&scene, formats.next().unwrap());
                    }
                    // Else a path would never meet every other format.
                    formats.next();
                }
            }
        }
    }

    #[test]
    fn lanes_that_share_an_anchor_find_the_light_in_its_direction() {
        for sun in [30.0, 0.0, -4.0] {
            let scene = scene(Preset::Standard, sun, Projection::Equirectangular);
            let plan = Plan::new(&scene.validated().unwrap(), PixelFormat::LinearRgb);
            let (uniform, buffers) = (&plan.uniform, plan.buffers());
            for anchor in (0..anchors(uniform)).step_by(37) {
                // A workgroup whose second anchor it is.
                let mut kept = [Vec4::NAN; 2 * LOOKUP_WORKGROUP as usize];
                let (first, view) = (ANCHOR_LANES, anchor_view(uniform, anchor));
                for lane in first..2 * ANCHOR_LANES {
                    keep_anchor_part(uniform, buffers, (view, 0), lane, &mut kept, plan.variant);
                }
                let found = anchor_light(uniform, buffers, (view, 0), first, &kept, plan.variant);
                let alone = light(uniform, buffers, 0, view, plan.variant);
                for (found, alone) in [(found.air, alone.air), (found.aerosol, alone.aerosol)] {
                    // Sums of up to some hundred terms in another order.
                    assert!((found - alone).abs().cmple(alone * 1e-5).all(), "{sun}°, {anchor}: {found}, not {alone}");
                }
                assert_eq!((found.multiple, found.ground), (alone.multiple, alone.ground));
            }
        }
    }

    #[test]
    fn pixels_in_runs_have_the_same_bits_in_blocks_and_alone_with_and_without_avx2() {
        for (preset, format) in [(Preset::Earth, PixelFormat::LinearRgb), (Preset::Standard, PixelFormat::Picture)] {
            let mut scene = scene(preset, 30.0, Projection::Equirectangular);
            // Wide enough for runs, with a block of a few pixels at the end, and high enough for a disc of few samples
            // in a pixel.
            scene.camera.size = "1616x640".parse().unwrap();
            scene.render.path = PathChoice::Lookup;
            let plan = check(&scene, format);
            assert!(plan.variant & sorairo_shared::variant::RUNS != 0, "{}", plan.lookup);
        }
    }

    #[test]
    fn directions_have_the_same_bits_in_blocks_and_alone_with_and_without_avx2() {
        for sun in [30.0, -4.0] {
            let scene = scene(Preset::Standard, sun, Projection::Equirectangular);
            let plan = Plan::new(&scene.validated().unwrap(), PixelFormat::LinearRgb);
            let (uniform, buffers, variant) = (&plan.uniform, plan.buffers(), plan.variant);
            let (groups, azimuths) = (buffers.bands.len(), [0.0, 40.0, 130.0, 220.0]);
            let views: Vec<Vec3> =
                (0..13).map(|i| direction(1.0 + 7.0 * f64::from(i), azimuths[i as usize % 4]).as_vec3()).collect();
            let rgb = |colours: &[Constituents]| -> Vec<[Vec3; 3]> {
                colours.iter().map(|&Constituents { air, aerosol, rest }| [air, aerosol, rest]).collect()
            };
            let [mut blocks, mut plain] = [const { [Constituents::DARK; 13] }; 2];
            constituents_of_directions(uniform, buffers, &views, &mut blocks, variant);
            plain::constituents_of_directions(uniform, buffers, &views, &mut plain, variant);
            let alone: Vec<_> = views.iter().map(|&view| constituents(uniform, buffers, view, variant)).collect();
            assert!(rgb(&blocks).iter().flatten().all(|colour| colour.max_element() > 0.0), "{sun}°");
            assert!(rgb(&blocks) == rgb(&plain) && rgb(&blocks) == rgb(&alone), "{sun}°");

            let of_light = |light: &[ByConstituent<Vec4>]| -> Vec<[Vec4; 4]> {
                light
                    .iter()
                    .map(|&ByConstituent { air, aerosol, multiple, ground }| [air, aerosol, multiple, ground])
                    .collect()
            };
            let [mut blocks, mut plain] =
                [vec![ByConstituent::default(); 13 * groups], vec![ByConstituent::default(); 13 * groups]];
            light_of_directions(uniform, buffers, &views, &mut blocks, variant);
            plain::light_of_directions(uniform, buffers, &views, &mut plain, variant);
            let all = |&view: &Vec3| (0..groups).map(move |group| light(uniform, buffers, group, view, variant));
            let alone: Vec<_> = views.iter().flat_map(all).collect();
            assert!(of_light(&blocks).iter().all(|parts| parts[0].max_element() > 0.0), "{sun}°");
            assert!(of_light(&blocks) == of_light(&plain) && of_light(&blocks) == of_light(&alone), "{sun}°");
        }
    }

    #[test]
    fn every_fit_has_the_same_bits_in_blocks_and_alone_with_and_without_avx2() {
        let six = Some(vec![435.0, 475.0, 506.0, 555.0, 608.0, 659.0]);
        for (fit, color, bands) in [
            (Fit::Cubic, ColourPath::Folded, None),
            (Fit::Transfer, ColourPath::Folded, six.clone()),
            (Fit::Regression, ColourPath::Solve, None),
            (Fit::Regression, ColourPath::Folded, six),
            (Fit::Dense, ColourPath::Folded, None),
        ] {
            let mut scene = scene(Preset::Standard, 20.0, Projection::Equirectangular);
            (scene.render.fit, scene.render.color, scene.render.bands) = (fit, color, bands);
            for path in [PathChoice::Direct, PathChoice::Lookup] {
                scene.render.path = path;
                check(&scene, PixelFormat::LinearRgb);
            }
        }
    }
}
