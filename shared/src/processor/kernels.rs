//! The door to blocks: one function per kernel, for a row of pixels or for neighbouring entries.
//!
//! Each is compiled twice, for AVX2 and for any processor of its kind, and gives the same bits; `plain` is the second.

use multiversion::multiversion;

use super::colour::{constituents, light, with_phases_of_block};
use super::lanes::{BLOCK, Three, lanes};
use super::lookup::{entries_of_rows, sky_of_block};
use super::pixels::{Pixels, are_on_ground, blacken, put_ground, show, store_block, views};
use super::run::{AT_PIXELS, AT_PLACES, encode, runs, sky_of_runs, store_smooth};
use crate::glam::{UVec2, Vec3, Vec4};
use crate::kernels::{lookup_pixel, shown_in};
use crate::picture::below::{sky_view, with_ground};
use crate::picture::disc::is_beside_disc;
use crate::picture::formed_run::is_formed;
use crate::picture::lookup::{anchor_view, store_entry};
use crate::sky::{ByConstituent, Constituents};
use crate::uniform::{Buffers, Uniform};
use crate::variant;

/// Kernel `sky` for the row with which a dispatch begins, `output`, whose pixels hold colours alone, by any fit but the
/// solved cubic; see [`crate::kernels::sky_pixel`].
#[multiversion(targets("x86_64+avx+avx2"))]
pub fn sky_row<'a>(uniform: &Uniform, buffers: Buffers<'a>, output: &mut [u32], variant: u32) {
    plain::sky_row(uniform, buffers, output, variant);
}

/// Kernel `sky_lookup` for the row with which a dispatch begins, `output`; see [`crate::kernels::lookup_pixel`].
#[multiversion(targets("x86_64+avx+avx2"))]
pub fn lookup_row(uniform: &Uniform, colour: &[Vec4], entries: &[Vec4], output: &mut [u32], variant: u32) {
    plain::lookup_row(uniform, colour, entries, output, variant);
}

/// Kernel `anchors` for the anchors of these indices, [`BLOCK`] at most, stored in `anchors` one after the other; see
/// [`crate::kernels::anchor_light`].
#[multiversion(targets("x86_64+avx+avx2"))]
pub fn lookup_anchors<'a>(
    uniform: &Uniform,
    buffers: Buffers<'a>,
    indices: &[u32],
    anchors: &mut [Vec4],
    variant: u32,
) {
    plain::lookup_anchors(uniform, buffers, indices, anchors, variant);
}

/// Kernel `lookup` for some rows of entries; see [`entries_of_rows`].
#[multiversion(targets("x86_64+avx+avx2"))]
pub fn lookup_entries(
    uniform: &Uniform,
    anchors: &[Vec4],
    are_read: &[bool],
    entries: &mut [Vec4],
    first_row: u32,
    variant: u32,
) {
    plain::lookup_entries(uniform, anchors, are_read, entries, first_row, variant);
}

/// Light in some directions, [`BLOCK`] at most, by its constituents: that of the first at each group of bands, then of
/// the next; see [`crate::sky::light`].
#[multiversion(targets("x86_64+avx+avx2"))]
pub fn light_of_directions<'a>(
    uniform: &Uniform,
    buffers: Buffers<'a>,
    directions: &[Vec3],
    output: &mut [ByConstituent<Vec4>],
    variant: u32,
) {
    plain::light_of_directions(uniform, buffers, directions, output, variant);
}

/// Colours of the constituents in some directions, [`BLOCK`] at most, by any fit but the solved cubic; see
/// [`crate::sky::constituents`].
#[multiversion(targets("x86_64+avx+avx2"))]
pub fn constituents_of_directions<'a>(
    uniform: &Uniform,
    buffers: Buffers<'a>,
    directions: &[Vec3],
    output: &mut [Constituents],
    variant: u32,
) {
    plain::constituents_of_directions(uniform, buffers, directions, output, variant);
}

/// The same for any processor of its kind.
pub mod plain {
    use super::*;

    /// See [`super::sky_row`].
    #[inline(always)]
    pub fn sky_row(uniform: &Uniform, buffers: Buffers<'_>, output: &mut [u32], variant: u32) {
        for (pixels, output) in blocks(uniform, output) {
            let views = views(uniform, pixels, variant);
            let mut sky = Three::ZERO;
            if views.covered.contains(&true) {
                let count = pixels.count;
                if !are_on_ground(&views, count) {
                    let constituents = constituents(uniform, buffers, &views.sources, count, variant);
                    sky = with_phases_of_block(uniform, &constituents, &views.directions, count, variant);
                }
                put_ground(uniform, &views, count, &mut sky);
                show(uniform, buffers.colour, pixels, &mut sky, variant);
                blacken(&views, count, &mut sky);
            }
            store_block(uniform, output, pixels, &sky, variant);
        }
    }

    /// See [`super::lookup_row`].
    #[inline(always)]
    pub fn lookup_row(uniform: &Uniform, colour: &[Vec4], entries: &[Vec4], output: &mut [u32], variant: u32) {
        if variant & variant::RUNS != 0 {
            return lookup_runs(uniform, colour, entries, output, variant);
        }
        if variant & variant::POLARISER != 0 {
            for column in 0..uniform.camera.width {
                lookup_pixel(uniform, colour, entries, output, UVec2::new(column, 0), variant);
            }
            return;
        }
        for (pixels, output) in blocks(uniform, output) {
            let views = views(uniform, pixels, variant);
            let mut sky = Three::ZERO;
            if views.covered.contains(&true) {
                sky = sky_of_block(uniform, entries, pixels, &views, variant);
                show(uniform, colour, pixels, &mut sky, variant);
                blacken(&views, pixels.count, &mut sky);
            }
            store_block(uniform, output, pixels, &sky, variant);
        }
    }

    /// [`lookup_row`] of a variant with runs.
    #[inline(always)]
    fn lookup_runs(uniform: &Uniform, colour: &[Vec4], entries: &[Vec4], output: &mut [u32], variant: u32) {
        // A page, where the processor stands in for a missing device, would be 40 KB larger.
        let may_form = !cfg!(target_arch = "wasm32");
        let is_formed = may_form && is_formed(variant) && is_beside_disc(uniform, uniform.first_row, variant);
        for (pixels, output) in blocks(uniform, output) {
            if sky_view(uniform, pixels.first, uniform.first_row, variant).ground >= 1.0 {
                let ground = shown_in(uniform, colour, with_ground(uniform, Vec3::ZERO, 1.0), variant);
                store_block(uniform, output, pixels, &Three::splat(ground), variant);
                continue;
            }
            let mut at_places = Three::ZERO;
            if is_formed {
                at_places = sky_of_runs::<AT_PLACES>(uniform, entries, pixels, variant);
                let count = AT_PLACES * runs(pixels);
                show(uniform, colour, Pixels { count, ..pixels }, &mut at_places, variant);
                encode(&mut at_places, count);
                if store_smooth(uniform, output, pixels, &at_places, variant) {
                    continue;
                }
            }
            let mut sky = sky_of_runs::<AT_PIXELS>(uniform, entries, pixels, variant);
            show(uniform, colour, pixels, &mut sky, variant);
            store_block(uniform, output, pixels, &sky, variant);
            if is_formed {
                store_smooth(uniform, output, pixels, &at_places, variant);
            }
        }
    }

    /// See [`super::lookup_anchors`].
    #[inline(always)]
    pub fn lookup_anchors(
        uniform: &Uniform,
        buffers: Buffers<'_>,
        indices: &[u32],
        anchors: &mut [Vec4],
        variant: u32,
    ) {
        let count = indices.len();
        let mut directions = Three::ZERO;
        for lane in lanes(count) {
            directions.set(lane, anchor_view(uniform, indices[lane]));
        }
        let colours = constituents(uniform, buffers, &directions, count, variant);
        for lane in lanes(count) {
            store_entry(anchors, lane as u32, colours.get(lane), variant);
        }
    }

    /// See [`super::lookup_entries`].
    #[inline(always)]
    pub fn lookup_entries(
        uniform: &Uniform,
        anchors: &[Vec4],
        are_read: &[bool],
        entries: &mut [Vec4],
        first_row: u32,
        variant: u32,
    ) {
        entries_of_rows(uniform, anchors, are_read, entries, first_row, variant);
    }

    /// See [`super::light_of_directions`].
    #[inline(always)]
    pub fn light_of_directions(
        uniform: &Uniform,
        buffers: Buffers<'_>,
        directions: &[Vec3],
        output: &mut [ByConstituent<Vec4>],
        variant: u32,
    ) {
        let (views, count, groups) = (block_of(directions), directions.len(), buffers.bands.len());
        for group in 0..groups {
            let ByConstituent { air, aerosol, multiple, ground } =
                &light(uniform, buffers, group, &views, count, variant);
            for lane in lanes(count) {
                output[lane * groups + group] = ByConstituent {
                    air: air.get(lane),
                    aerosol: aerosol.get(lane),
                    multiple: multiple.get(lane),
                    ground: ground.get(lane),
                };
            }
        }
    }

    /// See [`super::constituents_of_directions`].
    #[inline(always)]
    pub fn constituents_of_directions(
        uniform: &Uniform,
        buffers: Buffers<'_>,
        directions: &[Vec3],
        output: &mut [Constituents],
        variant: u32,
    ) {
        let (views, count) = (block_of(directions), directions.len());
        let colours = constituents(uniform, buffers, &views, count, variant);
        for lane in lanes(count) {
            output[lane] = colours.get(lane);
        }
    }
}

/// Directions as a block has them.
#[inline(always)]
fn block_of(directions: &[Vec3]) -> Three {
    let mut views = Three::ZERO;
    for lane in lanes(directions.len()) {
        views.set(lane, directions[lane]);
    }
    views
}

/// The blocks of a row, each with the words of its pixels.
#[inline(always)]
fn blocks<'a>(uniform: &Uniform, output: &'a mut [u32]) -> impl Iterator<Item = (Pixels, &'a mut [u32])> {
    let width = uniform.camera.width as usize;
    let words = output.len() / width;
    output
        .chunks_mut(BLOCK * words)
        .enumerate()
        .map(move |(index, output)| (Pixels { first: (index * BLOCK) as u32, count: output.len() / words }, output))
}
