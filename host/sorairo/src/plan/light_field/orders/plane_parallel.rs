//! The orders of scattering that remain, in a plane-parallel atmosphere.
//!
//! In thick air successive orders fall off slowly: their number grows with the square of the optical depth. What
//! remains after the orders that are computed is diffuse, and is solved for at once. With `A` one more scattering, and
//! `r` the light field of which all further orders are sought, `G = Σ_{k≥1} A^k r` solves `G = A (r + G)`: the transfer
//! equation with the source that `r` makes. For each sun of a table, azimuthal number `m` and wavelength it is, in the
//! optical depth `τ` from the top (Chandrasekhar 1960, *Radiative Transfer*, ch. VI; Stamnes et al. 1988,
//! <https://doi.org/10.1364/AO.27.002502>, Eqs. 1 and 6),
//!
//! ```text
//! μ dF/dτ = S - F,   S(μ) = Σ_l ϖ_l f_l(μ) (r_lm + Σ_k w_k f_l(μ_k) F(μ_k)),   f_l = √(π (1 + δ_m0)) N_lm P_l^m
//! ```
//!
//! with `F` the integral of the light against `cos(m φ)`, `μ` the cosine of the zenith angle of a view direction and
//! `ϖ_l` the moments of scattering relative to the extinction. Light comes from no sun: the air may be taken as plane
//! here, since what is left of `r` is spread by less than the planet bends. Each hemisphere has its own Gauss-Legendre
//! streams. The forward peak of aerosol that these do not resolve counts as no scattering (delta-M, Wiscombe 1977,
//! <https://doi.org/10.1175/1520-0469(1977)034%3C1408:TDMRYA%3E2.0.CO;2>).
//!
//! Layers are stepped by the diamond difference, which conserves light exactly and has the diffusion limit (Larsen,
//! Morel and Miller 1987, <https://doi.org/10.1016/0021-9991(87)90170-7>), and eliminated from the top down: the
//! reflection of all that lies above an interface takes the place of the interfaces above. No optical depth is too
//! large.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DMatrixView, DVector};
use rayon::prelude::*;
use sorairo_shared::light_field::moments::{Moments, Stencil};
use sorairo_shared::value::{Lanes, Value};

use crate::plan::light_field::grid::Grid;
use crate::plan::light_field::orders::sampling::{densities, strongest};
use crate::plan::light_field::orders::values::Values;
use crate::plan::light_field::setting::Setting;
use crate::plan::light_field::wavelengths::Wavelengths;
use crate::plan::rays::quadrature::nodes_and_weights;

/// Streams in each hemisphere.
const STREAMS: usize = 8;

/// The highest degree that the streams integrate exactly.
const DEGREE: usize = 2 * STREAMS - 1;

/// The layers into which a table's altitudes cut the atmosphere, from the top.
pub struct Layers {
    layers: Vec<Layer>,
    /// The interface at each altitude of the table.
    interfaces: Vec<usize>,
}

struct Layer {
    /// Column densities of (air, aerosol, ozone) from its bottom to its top (km), and amounts of gases.
    columns: [f64; 5],
    /// Its middle among the altitudes of the table.
    middle: Stencil,
}

/// What a layer does to light at a wavelength.
struct Optics {
    /// Optical depth; the forward peak is not in it.
    depth: f64,
    /// `ϖ_l` for what scatters from stream to stream, without the forward peak.
    between_streams: Vec<f64>,
    /// `ϖ_l` for what is scattered of `r`.
    of_source: Vec<f64>,
}

/// The streams of both hemispheres: those that look up, along which `τ` grows, then those that look down.
struct Streams {
    mu: Vec<f64>,
    weights: Vec<f64>,
    /// `f_l` of every stream, for the degrees from `m` on.
    functions: DMatrix<f64>,
    /// `√(π (1 + δ_m0))`.
    norm: f64,
}

/// What light at the lower interface of a layer makes of that at its upper one.
struct Step {
    /// Upward light at the upper interface, from that at the lower one.
    up: DMatrix<f64>,
    /// The same from sources, for each sun.
    up_of_sources: DMatrix<f64>,
    /// Reflection of all above the upper interface.
    reflection: DMatrix<f64>,
    /// Downward light there from sources, for each sun.
    down_of_sources: DMatrix<f64>,
}

impl Layers {
    /// For the wavelength at which the air is thickest: layers resolve its optical depth where light changes, about the
    /// ground and the top.
    pub fn new<const N: usize>(setting: &Setting, wavelengths: &Wavelengths<N>, grid: &Grid) -> Self {
        /// Optical depth of a layer, relative to that between it and the ground or the top, and the least for which
        /// that is asked.
        const RELATIVE_DEPTH: f64 = 0.3;
        const LEAST_DEPTH: f64 = 0.05;
        const MOST_PARTS: usize = 16;
        let extinction = |altitude: f64| strongest(setting, wavelengths, altitude).extinction;
        let between = |pair: &[f64]| 0.5 * (extinction(pair[0]) + extinction(pair[1])) * (pair[1] - pair[0]);
        let depths: Vec<f64> = grid.altitudes.windows(2).map(between).collect();
        let total: f64 = depths.iter().sum();
        let (mut layers, mut interfaces) = (Vec::new(), vec![0; grid.altitudes.len()]);
        let mut above = 0.0;
        for i in (0..depths.len()).rev() {
            let (low, high) = (grid.altitudes[i], grid.altitudes[i + 1]);
            let nearest_end = (above + 0.5 * depths[i]).min(total - above - 0.5 * depths[i]);
            let parts = (depths[i] / (RELATIVE_DEPTH * nearest_end).max(LEAST_DEPTH)).ceil().max(2.0) as usize;
            let parts = parts.min(MOST_PARTS);
            let height = (high - low) / parts as f64;
            layers.extend((0..parts).rev().map(|part| Layer::new(setting, grid, low + part as f64 * height, height)));
            interfaces[i] = layers.len();
            above += depths[i];
        }
        Self { layers, interfaces }
    }

    /// `G = Σ_{k≥1} A^k r` for the light field `r`: moments up to the degree that the streams hold and the irradiance
    /// of the ground.
    pub fn further_orders<const N: usize>(
        &self,
        setting: &Setting,
        wavelengths: &Wavelengths<N>,
        grid: &Grid,
        r: &Values<N>,
    ) -> Values<N> {
        let degree = r.of.degree.min(DEGREE);
        let of = Moments { degree, azimuthal: r.of.azimuthal.min(degree) };
        let suns = grid.suns.len();
        let parts: Vec<(usize, usize)> = (0..=of.azimuthal).flat_map(|m| (0..N).map(move |lane| (m, lane))).collect();
        let solved: Vec<Solution> = parts
            .into_par_iter()
            .map(|(m, lane)| self.solve(setting, wavelengths, (m, lane), degree, suns, r))
            .collect();
        let mut values = vec![Lanes::ZERO; grid.altitudes.len() * suns * of.count()];
        let mut irradiance = vec![Lanes::ZERO; suns];
        for solution in solved {
            let Solution { m, lane, moments, irradiance: of_ground } = solution;
            let of_node = values.chunks_exact_mut(of.count()).zip(moments.chunks_exact(degree + 1 - m));
            for (values, moments) in of_node {
                let values = &mut values[of.first(m)..];
                values.iter_mut().zip(moments).for_each(|(value, &moment)| value.0[lane] = moment as f32);
            }
            if m == 0 {
                irradiance.iter_mut().zip(of_ground).for_each(|(to, value)| to.0[lane] = value as f32);
            }
        }
        // What is scattered that often is natural: its polarisation is left to what is corrected.
        Values { of, values, polarised: vec![Lanes::ZERO; r.polarised.len()], irradiance }
    }

    fn solve<const N: usize>(
        &self,
        setting: &Setting,
        wavelengths: &Wavelengths<N>,
        (m, lane): (usize, usize),
        degree: usize,
        suns: usize,
        r: &Values<N>,
    ) -> Solution {
        let streams = Streams::new(degree, m);
        let albedo = if m == 0 { f64::from(wavelengths.albedo.0[lane]) } else { 0.0 };
        let mut reflection = DMatrix::zeros(STREAMS, STREAMS);
        let mut down_of_sources = DMatrix::zeros(STREAMS, suns);
        let mut steps = Vec::with_capacity(self.layers.len());
        for layer in &self.layers {
            let optics = Optics::new(setting, wavelengths, lane, layer.columns, degree, m);
            let sources = layer.sources(r, (m, lane), suns, &streams, &optics);
            let (step, next, next_of_sources) = streams.step(&optics, &sources, reflection, down_of_sources);
            steps.push(step);
            (reflection, down_of_sources) = (next, next_of_sources);
        }
        // The ground sends the same light to all streams: twice the albedo times the irradiance, of this light and of
        // `r`.
        let downward: Vec<f64> = (0..STREAMS).map(|k| streams.weights[k] * streams.mu[k]).collect();
        let downward = DVector::from_vec(downward);
        let from_ground = reflection.column_sum().dot(&downward);
        let of_sources = down_of_sources.tr_mul(&downward);
        let upward_at = |sun: usize| {
            let of_r = f64::from(r.irradiance[sun].0[lane]);
            2.0 * albedo * (of_sources[sun] + of_r) / (1.0 - 2.0 * albedo * from_ground)
        };
        let mut up = DMatrix::from_fn(STREAMS, suns, |_, sun| upward_at(sun));
        let mut down = &reflection * &up + &down_of_sources;
        let irradiance = down.tr_mul(&downward).iter().copied().collect();
        let of_node = degree + 1 - m;
        let mut moments = vec![0.0; self.interfaces.len() * suns * of_node];
        let mut at = self.layers.len();
        for (altitude, &interface) in self.interfaces.iter().enumerate() {
            while at > interface {
                at -= 1;
                let step = &steps[at];
                up = &step.up * &up + &step.up_of_sources;
                down = &step.reflection * &up + &step.down_of_sources;
            }
            let to = &mut moments[altitude * suns * of_node..][..suns * of_node];
            streams.take_moments(&down, &up, to);
        }
        Solution { m, lane, moments, irradiance }
    }
}

/// The light at one wavelength with one azimuthal number.
struct Solution {
    m: usize,
    lane: usize,
    /// Moments from the degree `m` on, for every altitude and sun.
    moments: Vec<f64>,
    /// Irradiance of the ground for every sun.
    irradiance: Vec<f64>,
}

impl Layer {
    /// From an altitude (km) on, so high (km).
    fn new(setting: &Setting, grid: &Grid, altitude: f64, height: f64) -> Self {
        let columns = nodes_and_weights(3).into_iter().fold([0.0; 5], |sum: [f64; 5], (place, weight)| {
            let density = densities(setting, altitude + place * height);
            std::array::from_fn(|i| sum[i] + density[i] * weight * height)
        });
        let place = grid.place_of(setting, (altitude + 0.5 * height) as f32);
        Self { columns, middle: grid.places.axis().stencil(place, 0) }
    }

    /// The part of a layer's sources that `r` makes, at each stream and for each sun.
    fn sources<const N: usize>(
        &self,
        r: &Values<N>,
        (m, lane): (usize, usize),
        suns: usize,
        streams: &Streams,
        optics: &Optics,
    ) -> DMatrix<f64> {
        let moments = r.of.count();
        let of_sun = |sun: usize, l: usize| -> f64 {
            let at = |i: usize| ((self.middle.first + i) * suns + sun) * moments + r.of.first(m) + l;
            (0..4).map(|i| f64::from(self.middle.weights[i]) * f64::from(r.values[at(i)].0[lane])).sum()
        };
        let weighted = DMatrix::from_fn(streams.functions.ncols(), suns, |l, sun| {
            optics.of_source[l] * of_sun(sun, l) * streams.norm
        });
        &streams.functions * weighted
    }
}

impl Optics {
    fn new<const N: usize>(
        setting: &Setting,
        wavelengths: &Wavelengths<N>,
        lane: usize,
        columns: [f64; 5],
        degree: usize,
        m: usize,
    ) -> Self {
        let air = &wavelengths.air;
        let of = |lanes: &Lanes<N>| f64::from(lanes.0[lane]);
        let scattered_by_air = of(&air.air_scattering) * columns[0];
        let scattered_by_aerosol = of(&air.aerosol_scattering) * columns[1];
        let of_aerosol = |l: usize| setting.aerosol.get(l).map_or(0.0, |&chi| f64::from(chi));
        let peak = setting.aerosol.get(DEGREE + 1).map_or(0.0, |&chi| f64::from(chi)).min(of_aerosol(DEGREE)).max(0.0);
        let lost = [&air.aerosol_extinction, &air.ozone_absorption, &air.pair_absorption, &air.water_absorption];
        let lost: f64 = lost.into_iter().zip(&columns[1..]).map(|(coefficient, column)| of(coefficient) * column).sum();
        let extinction = scattered_by_air + lost;
        let depth = extinction - peak * scattered_by_aerosol;
        let of_air = |l: usize| match l {
            0 => scattered_by_air,
            2 => f64::from(setting.air) * scattered_by_air,
            _ => 0.0,
        };
        let moment = |l: usize, peak: f64| (of_air(l) + (of_aerosol(l) - peak) * scattered_by_aerosol) / depth;
        Self {
            depth,
            between_streams: (m..=degree).map(|l| moment(l, peak)).collect(),
            of_source: (m..=degree).map(|l| moment(l, 0.0)).collect(),
        }
    }
}

impl Streams {
    fn new(degree: usize, m: usize) -> Self {
        let rule = nodes_and_weights(STREAMS as u32);
        let both = |sign: f64| rule.iter().map(move |&(mu, _)| sign * mu);
        let mu: Vec<f64> = both(1.0).chain(both(-1.0)).collect();
        let weights: Vec<f64> = rule.iter().chain(&rule).map(|&(_, weight)| weight).collect();
        let rows: Vec<Vec<f64>> = mu.iter().map(|&mu| functions(degree, m, mu)).collect();
        let functions = DMatrix::from_fn(2 * STREAMS, degree + 1 - m, |k, l| rows[k][l]);
        let norm = if m == 0 { (2.0 * PI).sqrt() } else { PI.sqrt() };
        Self { mu, weights, functions, norm }
    }

    /// Goes down through a layer: the reflection of all above its lower interface, the downward light there from
    /// sources, and how to come back.
    fn step(
        &self,
        optics: &Optics,
        sources: &DMatrix<f64>,
        reflection: DMatrix<f64>,
        down_of_sources: DMatrix<f64>,
    ) -> (Step, DMatrix<f64>, DMatrix<f64>) {
        const S: usize = STREAMS;
        let scaled =
            DMatrix::from_fn(2 * S, self.functions.ncols(), |k, l| self.functions[(k, l)] * optics.between_streams[l]);
        // Half of extinction less scattering, between streams.
        let mut half = scaled * self.functions.transpose();
        for k in 0..2 * S {
            for j in 0..2 * S {
                half[(k, j)] = 0.5 * (f64::from(u8::from(k == j)) - half[(k, j)] * self.weights[j]);
            }
        }
        let mut lower = half.clone();
        for k in 0..2 * S {
            half[(k, k)] -= self.mu[k] / optics.depth;
            lower[(k, k)] += self.mu[k] / optics.depth;
        }
        // (half) F_upper + (lower) F_lower = sources, with F = (down, up) and down_upper = reflection up_upper +
        // down_of_sources.
        let upper_down = half.columns(0, S);
        let mut system = DMatrix::zeros(2 * S, 2 * S);
        system.columns_mut(0, S).copy_from(&(upper_down * &reflection + half.columns(S, S)));
        system.columns_mut(S, S).copy_from(&lower.columns(0, S));
        let mut right = DMatrix::zeros(2 * S, S + sources.ncols());
        right.columns_mut(0, S).copy_from(&(-lower.columns(S, S)));
        right.columns_mut(S, sources.ncols()).copy_from(&(sources - upper_down * &down_of_sources));
        let is_solved = system.lu().solve_mut(&mut right);
        debug_assert!(is_solved, "a layer that neither lets light through nor absorbs it");
        let part = |row: usize, column: usize, count: usize| -> DMatrix<f64> {
            let view: DMatrixView<f64> = right.view((row, column), (S, count));
            view.into_owned()
        };
        let suns = sources.ncols();
        let step = Step { up: part(0, 0, S), up_of_sources: part(0, S, suns), reflection, down_of_sources };
        (step, part(S, 0, S), part(S, S, suns))
    }

    /// The moments of light, from the degree `m` on, for every sun.
    fn take_moments(&self, down: &DMatrix<f64>, up: &DMatrix<f64>, moments: &mut [f64]) {
        let degrees = self.functions.ncols();
        for (sun, moments) in moments.chunks_exact_mut(degrees).enumerate() {
            for (l, moment) in moments.iter_mut().enumerate() {
                let of = |k: usize| self.weights[k] * self.functions[(k, l)];
                *moment = (0..STREAMS).map(|k| of(k) * down[(k, sun)] + of(k + STREAMS) * up[(k, sun)]).sum::<f64>()
                    / self.norm;
            }
        }
    }
}

/// `f_l(μ)` for the degrees from `m` on: associated Legendre functions whose squares have the integral 1 over `μ`, by
/// the recursion of [`sorairo_shared::light_field::moments::legendre`].
fn functions(degree: usize, m: usize, mu: f64) -> Vec<f64> {
    let sine = (1.0 - mu * mu).sqrt();
    let diagonal = (1..=m).fold(0.5f64.sqrt(), |value, m| value * sine * ((2 * m + 1) as f64 / (2 * m) as f64).sqrt());
    let (mut before, mut value, mut inverse_slope) = (0.0, diagonal, 0.0);
    let next = |l: usize| {
        let found = value;
        let (l2, m2) = (((l + 1) * (l + 1)) as f64, (m * m) as f64);
        let slope = ((4.0 * l2 - 1.0) / (l2 - m2)).sqrt();
        (before, value) = (value, slope * (mu * value - inverse_slope * before));
        inverse_slope = 1.0 / slope;
        found
    };
    (m..=degree).map(next).collect()
}
