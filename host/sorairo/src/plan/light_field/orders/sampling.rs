//! Where a ray and a table have their samples in thick air: by the optical depth.

use std::borrow::Cow;

use sorairo_shared::glam::Vec2;
use sorairo_shared::path::pieces::PieceSamples;

use crate::medium::density::densities_at;
use crate::plan::light_field::resolution::Resolution;
use crate::plan::light_field::setting::Setting;
use crate::plan::light_field::wavelengths::Wavelengths;
use crate::plan::rays::quadrature::{gauss_legendre, nodes_and_weights};

/// How the pieces of a ray are sampled.
pub enum Sampling {
    /// By a rule that follows the density; see `path::samples` of the shared crate.
    Rule(Vec<Vec2>),
    /// By panels that are short beside the mean free path and the length over which the air changes, as far as light
    /// comes: so many nodes on each.
    ByDepth(u32),
}

/// The air at an altitude, at the wavelength at which it is thickest. Ozone is left out: where it absorbs nearly all
/// light, little is left to resolve.
#[derive(Clone, Copy)]
pub struct Thickness {
    /// Extinction coefficient of air and aerosol (km⁻¹).
    pub extinction: f64,
    /// The height over which it falls off (km).
    pub fall_off: f64,
}

impl Thickness {
    /// Air with less than a thousandth of an optical depth is crossed at once: the height (km) of a panel that rises
    /// through all that lies above.
    fn panel_of_rising(self) -> f64 {
        OF_FALL_OFF * (1.0 + self.thinness()) * self.fall_off
    }

    /// That of one that falls, through as much as has grown to a thousandth below.
    fn panel_of_falling(self) -> f64 {
        (OF_FALL_OFF + self.thinness().ln_1p()) * self.fall_off
    }

    fn thinness(self) -> f64 {
        1e-3 / (self.extinction * self.fall_off).max(f64::MIN_POSITIVE)
    }
}

/// Optical depth of a panel: the first ones have this, those behind a part of what lies before them.
const PANEL_DEPTH: f64 = 1.2;
const OF_DEPTH_BEFORE: f64 = 0.5;

/// Length of a panel, relative to that over which the air changes.
const OF_FALL_OFF: f64 = 1.2;

/// The optical depth at all wavelengths behind which nothing is seen.
const OPAQUE: f64 = 10.0;

impl Sampling {
    /// So many samples on each piece, or where a table is thick as many as that takes.
    pub fn new(resolution: &Resolution, samples: u32) -> Self {
        if resolution.thick { Self::ByDepth(resolution.panel_nodes) } else { Self::Rule(gauss_legendre(samples)) }
    }

    /// Samples that a piece has at least.
    pub fn fewest(&self) -> usize {
        match self {
            Self::Rule(rule) => rule.len(),
            Self::ByDepth(nodes) => 4 * *nodes as usize,
        }
    }

    /// The nodes of a piece. `depth` is the largest and the smallest optical depth before it, and becomes that behind
    /// it.
    pub fn of_piece<const N: usize>(
        &self,
        setting: &Setting,
        wavelengths: &Wavelengths<N>,
        piece: PieceSamples,
        depth: &mut [f64; 2],
    ) -> Cow<'_, [Vec2]> {
        match self {
            Self::Rule(rule) => Cow::Borrowed(rule),
            Self::ByDepth(nodes) => Cow::Owned(panels(setting, wavelengths, piece, *nodes, depth)),
        }
    }
}

/// The nodes of panels along a piece, as far as light comes from.
fn panels<const N: usize>(
    setting: &Setting,
    wavelengths: &Wavelengths<N>,
    piece: PieceSamples,
    of_panel: u32,
    depth: &mut [f64; 2],
) -> Vec<Vec2> {
    let length = f64::from(piece.length());
    let rule = nodes_and_weights(of_panel);
    let from_low = |along: f64| if piece.is_rising() { along } else { length - along };
    let altitude = |along: f64| f64::from(piece.altitude(setting.medium, from_low(along) as f32));
    let mut nodes = Vec::new();
    let mut along = 0.0;
    while along < length && depth[1] < OPAQUE {
        let here = altitude(along);
        let thickness = strongest(setting, wavelengths, here);
        let by_depth = (OF_DEPTH_BEFORE * depth[0]).max(PANEL_DEPTH) / thickness.extinction.max(f64::MIN_POSITIVE);
        let mut step = by_depth.min(length - along);
        let is_too_long = |step: f64| {
            // Where the ray is level, the altitude changes with the square of the distance.
            let there = altitude((along + step).min(length));
            // Below thin air may lie haze, which grows faster.
            let height = if piece.is_rising() {
                thickness.panel_of_rising()
            } else {
                thickness.panel_of_falling().min(strongest(setting, wavelengths, there).panel_of_falling())
            };
            (there - here).abs() > height
        };
        while is_too_long(step) {
            step *= 0.7;
        }
        if along + 1.3 * step > length {
            step = length - along;
        }
        for &(place, weight) in &rule {
            nodes.push(piece.node(from_low(along + place * step) as f32, (weight * step) as f32));
        }
        let middle = altitude(along + 0.5 * step);
        let [thickest, thinnest] = extremes(setting, wavelengths, middle);
        depth[0] += step * thickest;
        depth[1] += step * thinnest;
        along += step;
    }
    nodes
}

/// Altitudes of a table (km), from the ground to the top of the atmosphere: close where a mean free path is short,
/// about the ground, and wherever the air changes.
pub fn altitudes_by_depth<const N: usize>(setting: &Setting, wavelengths: &Wavelengths<N>) -> Vec<f64> {
    /// Altitudes at most, which bounds memory and time. Thicker air has longer steps.
    const MOST: usize = 160;
    let with_steps = |scale: &f64| altitudes(setting, wavelengths, *scale);
    let mut scales = std::iter::successors(Some(1.0), |scale| Some(1.3 * scale));
    scales
        .find_map(|scale| Some(with_steps(&scale)).filter(|found| found.len() <= MOST))
        .expect("steps as long as the atmosphere is deep")
}

/// Those with steps longer by a factor.
fn altitudes<const N: usize>(setting: &Setting, wavelengths: &Wavelengths<N>, scale: f64) -> Vec<f64> {
    /// Optical depth between the ground and the first altitude, and that of a step relative to what lies below. On a
    /// planet without curvature thick air then keeps to the laws of thick layers within 0.3 %, over black and over
    /// white ground, up to an optical depth of 300.
    const FIRST_DEPTH: f64 = 0.15;
    const OF_DEPTH_BELOW: f64 = 0.14;
    /// A step, relative to the height over which the air falls off; where it is thin it grows.
    const STEP: f64 = 0.25;
    const THIN: f64 = 0.03;
    let top = f64::from(setting.medium.atmosphere.depth);
    let (mut altitudes, mut below) = (vec![0.0], 0.0);
    let mut altitude = 0.0;
    loop {
        let Thickness { extinction, fall_off } = strongest(setting, wavelengths, altitude);
        let by_depth = (OF_DEPTH_BELOW * below).max(FIRST_DEPTH) / extinction.max(f64::MIN_POSITIVE);
        let above = extinction * fall_off;
        let step = scale * by_depth.min(STEP * fall_off * (THIN / above).sqrt().max(1.0));
        below += step * strongest(setting, wavelengths, altitude + 0.5 * step).extinction;
        altitude += step;
        if altitude + 0.5 * step >= top {
            break;
        }
        altitudes.push(altitude);
    }
    altitudes.push(top);
    altitudes
}

/// The [`densities_at`] an altitude (km).
pub fn densities(setting: &Setting, altitude: f64) -> [f64; 5] {
    densities_at(setting.medium, altitude, setting.variant)
}

/// The air at an altitude (km) at the wavelength at which it is thickest.
pub fn strongest<const N: usize>(setting: &Setting, wavelengths: &Wavelengths<N>, altitude: f64) -> Thickness {
    let [air, aerosol, ..] = densities(setting, altitude);
    let of = &wavelengths.air;
    let at = |i: usize| {
        let of_air = f64::from(of.air_scattering.0[i]) * air;
        let of_aerosol = f64::from(of.aerosol_extinction.0[i]) * aerosol;
        let atmosphere = setting.medium.atmosphere;
        let falls =
            of_air / f64::from(atmosphere.air.scale_height) + of_aerosol / f64::from(atmosphere.aerosol.scale_height);
        let extinction = of_air + of_aerosol;
        Thickness { extinction, fall_off: extinction / falls.max(f64::MIN_POSITIVE) }
    };
    (1..N).map(at).fold(at(0), |most, other| if other.extinction > most.extinction { other } else { most })
}

/// The largest and the smallest extinction at an altitude (km⁻¹).
fn extremes<const N: usize>(setting: &Setting, wavelengths: &Wavelengths<N>, altitude: f64) -> [f64; 2] {
    let [air, aerosol, ozone, ..] = densities(setting, altitude);
    let of = &wavelengths.air;
    let at = |i: usize| {
        f64::from(of.air_scattering.0[i]) * air
            + f64::from(of.aerosol_extinction.0[i]) * aerosol
            + f64::from(of.ozone_absorption.0[i]) * ozone
    };
    (0..N).map(at).fold([0.0, f64::INFINITY], |[most, least], value| [value.max(most), value.min(least)])
}
