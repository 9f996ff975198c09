//! Light gathered along rays from the sources of a table, a tile of suns and wavelengths at a time.

use core::ops::Range;

use crate::light_field::moments::{Moments, Stencil};
use crate::light_field::polarisation::SpinFunctions;
use crate::light_field::rays::{SunPlace, between_logarithms, functions_of_air};
use crate::light_field::source::{NodeMoments, polarised_source, size, source};
use crate::light_field::table::{MomentTable, RayNode, TILE, TableRay, suns_of_tile, wavelengths_of_tile};
use crate::math::{exp_lanes, ln_lanes, safe_sqrt};
use crate::medium::bands::ByScatterer;
use crate::value::{Lanes, Value};

/// Room for the sources of a node.
pub struct Scratch<'a> {
    /// For the suns of each tile and each azimuthal number the source towards the observer, at the wavelengths of a
    /// tile; then those of polarised light.
    pub sums: &'a mut [f32],
    /// The same for each sun, relative to its size; its azimuthal numbers fill tiles.
    pub sources: &'a mut [f32],
    /// For each sun and each wavelength of a tile the logarithm of the size of its sources.
    pub logarithms: &'a mut [f32],
    /// For each sight and each wavelength of a tile the size between those of four suns.
    pub scales: &'a mut [f32],
    /// For each sight and each wavelength of a tile the light and, where it is polarised, `Q` and `U`, apart for the
    /// azimuthal numbers that share a tile.
    pub light: &'a mut [f32],
}

/// Numbers of a source and of light, which [`Scratch`] has room for.
#[derive(Clone, Copy)]
struct Numbers {
    /// Azimuthal numbers of radiance.
    radiance: usize,
    /// Those of polarised light; none of a table without.
    polarised: usize,
}

impl Numbers {
    const fn new(of: Moments, polarised: usize) -> Self {
        Self { radiance: of.azimuthal + 1, polarised }
    }

    /// Of both.
    const fn all(self) -> usize {
        self.radiance + self.polarised
    }

    /// Values of the sources of a sun at so many wavelengths: radiance fills tiles, and so does polarised light.
    const fn of_sun(self, wavelengths: usize) -> usize {
        self.of_radiance(wavelengths) + (self.polarised * wavelengths).next_multiple_of(TILE)
    }

    /// The same of radiance alone.
    const fn of_radiance(self, wavelengths: usize) -> usize {
        (self.radiance * wavelengths).next_multiple_of(TILE)
    }

    /// Tiles of a sight's light.
    const fn of_light(self) -> usize {
        if self.polarised > 0 { 3 } else { 1 }
    }
}

/// Values of each of the [`Scratch`], in its order, for so many suns, the moments of a table of `N` wavelengths, those
/// of polarised light and so many sights.
pub const fn scratch_sizes<const N: usize>(suns: usize, of: Moments, polarised: usize, sights: usize) -> [usize; 5] {
    let (wavelengths, together) = (wavelengths_of_tile::<N>(), suns_of_tile::<N>());
    let numbers = Numbers::new(of, polarised);
    let suns = suns.next_multiple_of(together);
    let sums = suns / together * numbers.all() * TILE;
    let light = sights * numbers.of_light() * TILE;
    [sums, suns * numbers.of_sun(wavelengths), suns * wavelengths, sights * wavelengths, light]
}

/// The lanes of a tile that begin at an index.
#[inline(always)]
fn tile_at<const T: usize>(values: &[f32], index: usize) -> &[f32; T] {
    let lanes = &values[index * T..(index + 1) * T];
    match lanes.try_into() {
        Ok(lanes) => lanes,
        Err(_) => &[0.0; T],
    }
}

/// The same, of a whole tile.
#[inline(always)]
fn lanes_at(values: &[f32], index: usize) -> Lanes<TILE> {
    Lanes(*tile_at(values, index))
}

/// Four parts of a table, of a length each, a step apart.
#[inline(always)]
fn four_parts(values: &[f32], first: usize, step: usize, length: usize) -> [&[f32]; 4] {
    let part = |i: usize| &values[first + i * step..][..length];
    [part(0), part(1), part(2), part(3)]
}

/// Values at the wavelengths of a tile, the same for each of its suns.
#[inline(always)]
fn for_each_sun<const T: usize>(values: &[f32; T]) -> Lanes<TILE> {
    let mut lanes = Lanes::ZERO;
    for i in 0..TILE {
        lanes.0[i] = values[i % T];
    }
    lanes
}

/// What scatters at a node, at the wavelengths of a tile for each of its suns.
#[inline(always)]
fn scatterers_of_tile<const N: usize, const T: usize>(node: &RayNode<N>, tile: usize) -> ByScatterer<Lanes<TILE>> {
    ByScatterer {
        air: for_each_sun(tile_at::<T>(&node.scatterers.air.0, tile)),
        aerosol: for_each_sun(tile_at::<T>(&node.scatterers.aerosol.0, tile)),
    }
}

/// The moments of a group of suns between four altitudes, and the functions of a node.
struct TileMoments<'a> {
    /// Of the four altitudes.
    four: [&'a [f32]; 4],
    weights: [f32; 4],
    functions: &'a [f32],
    of_functions: Moments,
}

impl NodeMoments<Lanes<TILE>> for TileMoments<'_> {
    #[inline(always)]
    fn moment(&self, number: usize) -> Lanes<TILE> {
        let [a, b, c, d] = self.four;
        Lanes::weighted(
            lanes_at(a, number),
            lanes_at(b, number),
            lanes_at(c, number),
            lanes_at(d, number),
            self.weights,
        )
    }

    #[inline(always)]
    fn function(&self, m: usize, behind: usize) -> f32 {
        self.functions[self.of_functions.first(m) + behind]
    }
}

/// The source at a node of a ray towards its origin at the wavelengths of a tile, for some tiles of suns and each
/// azimuthal number: `Σ_l χ_l L_lm N_lm P_l^m`. `sums` begin with those of the first sun of the table.
#[inline(always)]
fn take_sums<const N: usize, const T: usize>(
    table: MomentTable,
    ray: TableRay<N>,
    index: usize,
    tile: usize,
    tiles_of_suns: Range<usize>,
    sums: &mut [f32],
) {
    let node = &ray.nodes[index];
    let (moments, groups) = (table.moments, table.suns.count.div_ceil(TILE / T));
    let numbers = Numbers::new(moments, table.polarised()).all();
    let of_group = (moments.count() + table.polarised()) * TILE;
    let has_aerosol = !ray.functions.is_empty();
    let functions = if has_aerosol { &ray.functions[index * ray.of.count()..] } else { &[] };
    let weights = node.altitudes.weights;
    let scatterers = scatterers_of_tile::<N, T>(node, tile);
    let first_altitude = tile * table.altitudes + node.altitudes.first;
    for group in tiles_of_suns {
        let first = (first_altitude * groups + group) * of_group;
        let four = four_parts(table.values, first, groups * of_group, of_group);
        let of_node = TileMoments { four, weights, functions, of_functions: ray.of };
        let sums = &mut sums[group * numbers * TILE..][..numbers * TILE];
        let (radiance, polarised) = sums.split_at_mut((moments.azimuthal + 1) * TILE);
        for (m, to) in radiance.chunks_exact_mut(TILE).enumerate() {
            let of = (moments.degree, m);
            to.copy_from_slice(&source(&of_node, moments, of, node.air_functions, &scatterers, has_aerosol).0);
        }
        if let Some(couplings) = table.couplings {
            let second = functions_of_air(1.0, node.place.mu, node.place.sine);
            for (m, function) in [second.y, second.z, second.w].into_iter().enumerate() {
                let [added, made] =
                    polarised_source(&of_node, moments, (m, function), &scatterers, couplings, has_aerosol);
                add_to(&mut radiance[m * TILE..][..TILE], &added);
                polarised[m * TILE..][..TILE].copy_from_slice(&made.0);
            }
        }
    }
}

#[inline(always)]
fn add_to(lanes: &mut [f32], other: &Lanes<TILE>) {
    for (lane, other) in lanes.iter_mut().zip(&other.0) {
        *lane += other;
    }
}

/// Divides the sources of some tiles of suns by their size at each wavelength, and keeps its logarithm. What is
/// [`SMALLEST`] of what scatters is nothing.
#[inline(always)]
fn take_sizes<const N: usize, const T: usize>(
    node: &RayNode<N>,
    tile: usize,
    numbers: Numbers,
    tiles_of_suns: Range<usize>,
    scratch: &mut Scratch,
) {
    let of_group = numbers.all() * TILE;
    let sums = &mut scratch.sums[tiles_of_suns.start * of_group..tiles_of_suns.end * of_group];
    let logarithms = &mut scratch.logarithms[tiles_of_suns.start * TILE..tiles_of_suns.end * TILE];
    let scatterers = scatterers_of_tile::<N, T>(node, tile);
    for (sums, sizes) in sums.chunks_exact_mut(of_group).zip(logarithms.chunks_exact_mut(TILE)) {
        let mut magnitudes = Lanes::ZERO;
        for number in 0..numbers.radiance {
            magnitudes.add_scaled(&lanes_at(sums, number).magnitude(), 1.0);
        }
        let size = size(&magnitudes, &scatterers);
        let inverse = size.inverse();
        sizes.copy_from_slice(&size.0);
        for lanes in sums.chunks_exact_mut(TILE) {
            for (lane, inverse) in lanes.iter_mut().zip(&inverse.0) {
                *lane *= inverse;
            }
        }
    }
    ln_lanes(logarithms);
}

/// Puts the sources of each sun of some tiles together.
#[inline(always)]
fn take_sources<const T: usize>(numbers: Numbers, tiles_of_suns: Range<usize>, scratch: &mut Scratch) {
    let (together, of_sun) = (TILE / T, numbers.of_sun(T));
    for group in tiles_of_suns {
        let sums = &scratch.sums[group * numbers.all() * TILE..][..numbers.all() * TILE];
        let sources = &mut scratch.sources[group * together * of_sun..][..together * of_sun];
        for (sun, sources) in sources.chunks_exact_mut(of_sun).enumerate() {
            let (radiance, polarised) = sources.split_at_mut(numbers.of_radiance(T));
            let radiance = radiance.chunks_exact_mut(T).take(numbers.radiance);
            let polarised = polarised.chunks_exact_mut(T).take(numbers.polarised);
            for (number, source) in radiance.chain(polarised).enumerate() {
                source.copy_from_slice(tile_at::<T>(sums, number * together + sun));
            }
        }
    }
}

/// The sizes that a source has at each place of a sun, between the logarithms of four.
#[inline(always)]
fn take_scales<const T: usize>(places: &[SunPlace], scratch: &mut Scratch) {
    for (place, scales) in places.iter().zip(scratch.scales.chunks_exact_mut(T)) {
        let Stencil { first, weights } = place.suns;
        let of_sun = |i: usize| tile_at::<T>(scratch.logarithms, first + i);
        let [a, b, c, d] = [of_sun(0), of_sun(1), of_sun(2), of_sun(3)];
        let mut between = [0.0; T];
        for i in 0..T {
            between[i] = between_logarithms([a[i], b[i], c[i], d[i]], weights);
        }
        scales.copy_from_slice(&between);
    }
    exp_lanes(scratch.scales);
}

/// The suns of a table between which places stand: a ray of an observer meets few of them.
#[inline(always)]
fn suns_of(places: &[SunPlace]) -> Range<usize> {
    let (mut start, mut end) = (usize::MAX, 0);
    for place in places {
        start = start.min(place.suns.first);
        end = end.max(place.suns.first + 4);
    }
    start.min(end)..end
}

/// Light gathered along a ray from the sources of a table, added to `light` for each sight, and `Q` and `U` to
/// `polarised` where it is not empty; without that of the ground. `places` are the suns of all sights at the first
/// node, then at the next; see [`crate::light_field::table::suns_along`].
#[cfg_attr(
    not(target_arch = "spirv"),
    multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))
)]
pub fn gather<const N: usize>(
    table: MomentTable,
    ray: TableRay<N>,
    places: &[SunPlace],
    scratch: &mut Scratch,
    light: &mut [Lanes<N>],
    polarised: &mut [[Lanes<N>; 2]],
) {
    if N < TILE {
        gather_tiles::<N, N>(table, ray, places, scratch, light, polarised);
    } else {
        gather_tiles::<N, TILE>(table, ray, places, scratch, light, polarised);
    }
}

#[inline(always)]
fn gather_tiles<const N: usize, const T: usize>(
    table: MomentTable,
    ray: TableRay<N>,
    places: &[SunPlace],
    scratch: &mut Scratch,
    light: &mut [Lanes<N>],
    polarised: &mut [[Lanes<N>; 2]],
) {
    let numbers = Numbers::new(table.moments, table.polarised());
    let of_light = numbers.of_light() * TILE;
    for tile in 0..N / T {
        scratch.light.fill(0.0);
        for (index, places) in places.chunks_exact(light.len()).enumerate() {
            let suns = suns_of(places);
            let tiles_of_suns = suns.start * T / TILE..(suns.end * T).div_ceil(TILE);
            take_sums::<N, T>(table, ray, index, tile, tiles_of_suns.clone(), scratch.sums);
            if table.logarithmic {
                take_sizes::<N, T>(&ray.nodes[index], tile, numbers, tiles_of_suns.clone(), scratch);
                take_scales::<T>(places, scratch);
            }
            take_sources::<T>(numbers, tiles_of_suns, scratch);
            let there = ray.nodes[index].place;
            let spin = SpinFunctions::new(there.mu, there.sine);
            for (at, (place, light)) in places.iter().zip(scratch.light.chunks_exact_mut(of_light)).enumerate() {
                let scales = match table.logarithmic {
                    true => for_each_sun(tile_at::<T>(scratch.scales, at)),
                    false => Lanes([1.0; TILE]),
                };
                let sum = light_of_place::<T>(place, scratch.sources, numbers);
                add_product(&mut light[..TILE], &sum, &scales);
                if !polarised.is_empty() {
                    let [q, u] = polarised_of_place::<T>(place, scratch.sources, numbers, spin);
                    add_product(&mut light[TILE..2 * TILE], &q, &scales);
                    add_product(&mut light[2 * TILE..], &u, &scales);
                }
            }
        }
        for (light, lanes) in light.iter_mut().zip(scratch.light.chunks_exact(of_light)) {
            add_tile::<N, T>(light, tile, &lanes[..TILE]);
        }
        for ([q, u], lanes) in polarised.iter_mut().zip(scratch.light.chunks_exact(of_light)) {
            add_tile::<N, T>(q, tile, &lanes[TILE..2 * TILE]);
            add_tile::<N, T>(u, tile, &lanes[2 * TILE..]);
        }
    }
}

/// Adds the lanes of a tile to the wavelengths that they are of.
#[inline(always)]
fn add_tile<const N: usize, const T: usize>(light: &mut Lanes<N>, tile: usize, lanes: &[f32]) {
    for (i, &lane) in lanes.iter().enumerate() {
        light.0[tile * T + i % T] += lane;
    }
}

#[inline(always)]
fn add_product(light: &mut [f32], sum: &[f32; TILE], scales: &Lanes<TILE>) {
    for i in 0..TILE {
        light[i] += sum[i] * scales.0[i];
    }
}

/// A tile of sources between four suns.
#[inline(always)]
fn between_suns(four: [&[f32]; 4], [wa, wb, wc, wd]: [f32; 4], at: usize) -> [f32; TILE] {
    let [a, b, c, d]: [&[f32; TILE]; 4] =
        [tile_at(four[0], at), tile_at(four[1], at), tile_at(four[2], at), tile_at(four[3], at)];
    let mut between = [0.0; TILE];
    for i in 0..TILE {
        between[i] = a[i] * wa + b[i] * wb + c[i] * wc + d[i] * wd;
    }
    between
}

/// The light that the sources of four suns send under a sun between them: `Σ_m S_m cos(m φ)`, apart for the azimuthal
/// numbers that share a tile.
#[inline(always)]
fn light_of_place<const T: usize>(place: &SunPlace, sources: &[f32], numbers: Numbers) -> [f32; TILE] {
    let of_sun = numbers.of_sun(T);
    let four = four_parts(sources, place.suns.first * of_sun, of_sun, of_sun);
    let mut sum = [0.0; TILE];
    // cos((m + 1) φ) = 2 cos φ cos(m φ) - cos((m - 1) φ)
    let (mut before, mut value) = (place.cosine, 1.0);
    for at in 0..numbers.of_radiance(T) / TILE {
        let mut multiples = [0.0; TILE];
        for lanes in multiples.chunks_exact_mut(T) {
            lanes.fill(value);
            (before, value) = (value, 2.0 * place.cosine * value - before);
        }
        let between = between_suns(four, place.suns.weights, at);
        for i in 0..TILE {
            sum[i] += between[i] * multiples[i];
        }
    }
    sum
}

/// `Q` and `U` likewise: `Σ_m W_m P_m cos(m φ)` and `Σ_m X_m P_m sin(m φ)`.
#[inline(always)]
fn polarised_of_place<const T: usize>(
    place: &SunPlace,
    sources: &[f32],
    numbers: Numbers,
    spin: SpinFunctions,
) -> [[f32; TILE]; 2] {
    let of_sun = numbers.of_sun(T);
    let four = four_parts(sources, place.suns.first * of_sun, of_sun, of_sun);
    let first = numbers.of_radiance(T) / TILE;
    let cosine = place.cosine;
    let sine = safe_sqrt(1.0 - cosine * cosine);
    let [of_q, of_u] = spin.at_azimuth(cosine, sine);
    let mut sums = [[0.0; TILE]; 2];
    for at in 0..(numbers.polarised * T).div_ceil(TILE) {
        let mut multiples = [[0.0; TILE]; 2];
        for (to, of) in multiples.iter_mut().zip([&of_q, &of_u]) {
            for (lanes, value) in to.chunks_exact_mut(T).zip(&of[at * (TILE / T)..]) {
                lanes.fill(*value);
            }
        }
        let between = between_suns(four, place.suns.weights, first + at);
        for i in 0..TILE {
            sums[0][i] += between[i] * multiples[0][i];
            sums[1][i] += between[i] * multiples[1][i];
        }
    }
    sums
}
