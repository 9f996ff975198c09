//! Irradiance by sun and sky at any altitude and for any sun, as tables for a shader.
//!
//! The coordinates in a table depend on an altitude `h` up to the top, on the elevation `e` of the sun's centre
//! (without refraction) and on that of the horizon, `e_0 = -acos(R / (R + h))`, in degrees:
//!
//! ```text
//! v = ∛(h / top)
//! u = ½ + ½ √((e - e_0) / (90 - e_0))     where e ≥ e_0
//! u = ½ - ½ √((e_0 - e) / 20)             where e < e_0
//! ```
//!
//! In a table of `c × r` texels the position is `(u (c - 1) + ½, v (r - 1) + ½)`, with linear interpolation. Texels are
//! densest at sunrise and sunset; 20° below the horizon is night.
//!
//! Skies are planned for fewer altitudes and suns. Between them, cubics interpolate the logarithm of the light, and
//! harmonics relative to the first one.

use rayon::prelude::*;
use sorairo_shared::glam::DVec3;
use sorairo_shared::interpolation::cubic::{Stencil, stencil};

use crate::error::{Error, Result, check_range};
use crate::measure::irradiance::{Harmonics, rgb_of_sky};
use crate::plan::picture::sun_disc::Sun;
use crate::plan::rays::directions::horizon;
use crate::plan::{LightFields, SkyPlan};
use crate::scene::{ColourPath, Rgb, ValidScene};

/// Altitudes, and suns on either side of the horizon, for which skies are planned.
const ALTITUDES: u32 = 10;
const SUNS: u32 = 21;

/// A sun this far below the horizon (degrees) means night.
const NIGHT: f64 = 20.0;

/// The sun's disc is hidden if its centre is this far below the horizon (degrees). Refraction raises it by at most
/// 1.3°, for an observer above the air, and its diameter is half a degree.
const HIDDEN: f64 = 2.0;

/// Irradiance below this (W·m⁻²) counts as zero.
const NOTHING: f64 = 1e-12;

/// The coefficients of [`Harmonics`] that do not vanish if x points to the sun's azimuth.
const KEPT: [usize; 6] = [0, 2, 3, 6, 7, 8];

/// Irradiance by sun and sky over altitudes and suns, in linear RGB (W·m⁻², weighted by the observer), to light
/// terrain, aircraft and clouds consistently. The sun's elevation and the altitude are those at each coordinate of the
/// table; see [`Self::place`].
#[derive(Debug)]
pub struct LightTable {
    top: f64,
    ground_radius: f64,
    /// Row by row from the ground, in each from night to the zenith.
    texels: Vec<LightAt>,
}

/// Irradiance of surfaces at an altitude for a sun: linear RGB (W·m⁻², weighted by the observer).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightAt {
    /// By the visible part of the sun's disc, on a surface that faces it.
    pub direct: [f64; 3],
    /// By the sky, without the sun, on a level surface that faces up.
    pub diffuse: [f64; 3],
    /// By the sky and the ground, without the sun, on a surface of any orientation: the coefficients
    /// `Y_00, Y_10, Y_11, Y_20, Y_21, Y_22` of [`Harmonics`], with x towards the sun's azimuth, y to its left and z up.
    /// The other three are 0.
    pub harmonics: [[f64; 3]; 6],
}

impl LightAt {
    /// All nine coefficients, in the order of [`Harmonics`].
    pub fn nine_harmonics(&self) -> Harmonics {
        let mut coefficients = [[0.0; 3]; 9];
        KEPT.into_iter().zip(self.harmonics).for_each(|(at, coefficient)| coefficients[at] = coefficient);
        Harmonics { coefficients }
    }

    /// The sum of some, each with a weight.
    fn weighted(parts: impl Iterator<Item = (Self, f64)>) -> Self {
        let mut sum = Self::default();
        let add = |sum: &mut [f64; 3], value: [f64; 3], weight: f64| {
            sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += value * weight);
        };
        for (part, weight) in parts {
            add(&mut sum.direct, part.direct, weight);
            add(&mut sum.diffuse, part.diffuse, weight);
            sum.harmonics.iter_mut().zip(part.harmonics).for_each(|(sum, value)| add(sum, value, weight));
        }
        sum
    }

    /// What is interpolated by cubics: logarithms of what is positive, and the other harmonics relative to the first.
    fn smooth(self) -> Self {
        let logarithm = |rgb: [f64; 3]| rgb.map(|value| value.max(NOTHING).ln());
        let [mean, others @ ..] = self.harmonics;
        let relative = |rgb: [f64; 3]| std::array::from_fn(|i| rgb[i] / mean[i].max(NOTHING));
        let [a, b, c, d, e] = others.map(relative);
        Self {
            direct: logarithm(self.direct),
            diffuse: logarithm(self.diffuse),
            harmonics: [logarithm(mean), a, b, c, d, e],
        }
    }

    /// The inverse of [`Self::smooth`].
    fn exponentials(self) -> Self {
        let light =
            |rgb: [f64; 3]| rgb.map(|value| Some(value.exp()).filter(|light| *light > 2.0 * NOTHING).unwrap_or(0.0));
        let [mean, others @ ..] = self.harmonics;
        let mean = light(mean);
        let [a, b, c, d, e] = others.map(|rgb| std::array::from_fn(|i| rgb[i] * mean[i]));
        Self { direct: light(self.direct), diffuse: light(self.diffuse), harmonics: [mean, a, b, c, d, e] }
    }
}

impl LightTable {
    /// Texels from night to the zenith, and from the ground to the top.
    pub const COLUMNS: u32 = 256;
    /// See [`Self::COLUMNS`].
    pub const ROWS: u32 = 64;

    /// The table for the atmosphere of a scene up to an altitude (km, 0.01 to 1000), in a space of linear RGB. The
    /// scene's sun and observer have no effect. Some four hundred skies are planned, on all cores, in seconds to half a
    /// minute. One table serves all suns of an atmosphere.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] for the altitude; [`Error::NotAllowed`] for an explicit solve at every pixel
    /// (`render.color`), or an altitude outside the scene's atmosphere.
    pub fn new(scene: &ValidScene, rgb: Rgb, top: f64, light_fields: &LightFields) -> Result<Self> {
        check_range("top", top, (0.01, 1000.0), "km")?;
        if scene.render.color == ColourPath::Solve {
            return Err(Error::not_allowed("render.color", "is solve, of whole rays; a table of light takes folded"));
        }
        let ground_radius = scene.atmosphere.ground_radius;
        let table = Self { top, ground_radius, texels: Vec::new() };
        let under = |row: u32, u: f64| -> Result<SkyPlan> {
            let altitude = top * (f64::from(row) / f64::from(ALTITUDES - 1)).powi(3);
            let mut scene = (**scene).clone();
            (scene.observer.altitude, scene.sun.elevation, scene.sun.azimuth) = (altitude, table.sun(altitude, u), 0.0);
            Ok(SkyPlan::with_light_fields(&scene.validated()?, rgb, light_fields))
        };
        let nodes: Vec<LightAt> = places(ALTITUDES, 2 * SUNS - 1)
            .into_par_iter()
            .map(|(row, u)| Ok(of_sky(&under(row, u)?).smooth()))
            .collect::<Result<_>>()?;
        let direct: Vec<LightAt> = places(ALTITUDES, Self::COLUMNS)
            .into_par_iter()
            .map(|(row, u)| Ok(LightAt { direct: direct(&under(row, u)?), ..LightAt::default() }.smooth()))
            .collect::<Result<_>>()?;
        let texels = places(Self::ROWS, Self::COLUMNS).into_iter().enumerate().map(|(at, (row, u))| {
            let column = at as u32 % Self::COLUMNS;
            let down = stencil((row * (ALTITUDES - 1)) as f32 / (Self::ROWS - 1) as f32, ALTITUDES);
            let across = across(u);
            let sky = between(&nodes, 2 * SUNS - 1, down, across);
            let sun = along(&direct, Self::COLUMNS, down, column);
            LightAt { direct: sun.direct, ..sky }.exponentials()
        });
        Ok(Self { texels: texels.collect(), ..table })
    }

    /// The elevation (degrees) of the sun at a place `u` of an altitude (km).
    fn sun(&self, altitude: f64, u: f64) -> f64 {
        let horizon = horizon(self.ground_radius, altitude).to_degrees();
        let part = (2.0 * u - 1.0).powi(2);
        if u >= 0.5 { horizon + part * (90.0 - horizon) } else { horizon - part * NIGHT }
    }

    /// The coordinates `(u, v)` of an altitude (km) and a sun (degrees), in [0, 1]. Night and altitudes above the top
    /// are clamped to the edges.
    pub fn place(&self, altitude: f64, sun_elevation: f64) -> [f64; 2] {
        let altitude = altitude.clamp(0.0, self.top);
        let horizon = horizon(self.ground_radius, altitude).to_degrees();
        let above = sun_elevation.min(90.0) - horizon;
        let u = if above >= 0.0 {
            0.5 + 0.5 * (above / (90.0 - horizon)).sqrt()
        } else {
            0.5 - 0.5 * (-above / NIGHT).min(1.0).sqrt()
        };
        [u, (altitude / self.top).cbrt()]
    }

    /// Irradiance of surfaces at an altitude (km) for a sun (degrees), as a device interpolates it.
    pub fn at(&self, altitude: f64, sun_elevation: f64) -> LightAt {
        let [u, v] = self.place(altitude, sun_elevation);
        let pair = |part: f64, count: u32| {
            let position = part * f64::from(count - 1);
            let first = position.floor().min(f64::from(count - 2));
            (first as usize, position - first)
        };
        let ((column, x), (row, y)) = (pair(u, Self::COLUMNS), pair(v, Self::ROWS));
        let corners = [(0, 0, (1.0 - x) * (1.0 - y)), (1, 0, x * (1.0 - y)), (0, 1, (1.0 - x) * y), (1, 1, x * y)];
        let of = |(right, up, weight): (usize, usize, f64)| {
            (self.texels[(row + up) * Self::COLUMNS as usize + column + right], weight)
        };
        LightAt::weighted(corners.into_iter().map(of))
    }

    /// The top altitude (km).
    pub fn top(&self) -> f64 {
        self.top
    }

    /// The texels: row by row from the ground, in each from night to the zenith.
    pub fn texels(&self) -> &[LightAt] {
        &self.texels
    }
}

/// Rows, and the places of their columns.
fn places(rows: u32, columns: u32) -> Vec<(u32, f64)> {
    let u = |column: u32| f64::from(column) / f64::from(columns - 1);
    (0..rows).flat_map(|row| (0..columns).map(move |column| (row, u(column)))).collect()
}

/// The four suns about a place on its side of the horizon, where what falls has an edge.
fn across(u: f64) -> Stencil {
    let from_horizon = ((2.0 * u - 1.0).abs() * f64::from(SUNS - 1)) as f32;
    let Stencil { first, weights, slopes, bends } = stencil(from_horizon, SUNS);
    if u >= 0.5 {
        return Stencil { first: first + SUNS - 1, weights, slopes, bends };
    }
    // The other way round.
    let [a, b, c, d] = weights.to_array();
    Stencil { first: SUNS - 4 - first, weights: [d, c, b, a].into(), slopes, bends }
}

/// Between four times four of a table of so many columns.
fn between(table: &[LightAt], columns: u32, down: Stencil, across: Stencil) -> LightAt {
    let part = |i: u32| (along(table, columns, down, across.first + i), f64::from(across.weights[i as usize]));
    LightAt::weighted((0..4).map(part))
}

/// Between four of a column.
fn along(table: &[LightAt], columns: u32, down: Stencil, column: u32) -> LightAt {
    let part = |i: u32| (table[((down.first + i) * columns + column) as usize], f64::from(down.weights[i as usize]));
    LightAt::weighted((0..4).map(part))
}

/// What falls from a sky.
fn of_sky(sky: &SkyPlan) -> LightAt {
    let ([diffuse, _], harmonics) = rgb_of_sky(sky, SkyPlan::radiances);
    LightAt { direct: [0.0; 3], diffuse: diffuse.to_array(), harmonics: KEPT.map(|at| harmonics.coefficients[at]) }
}

/// What falls from its sun.
fn direct(sky: &SkyPlan) -> [f64; 3] {
    let beneath = f64::from(sky.base.uniform.horizon).to_degrees() - sky.base.source.elevation;
    if beneath > HIDDEN { [0.0; 3] } else { Sun::new(sky).irradiance().rgb.max(DVec3::ZERO).to_array() }
}
