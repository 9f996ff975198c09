//! The suns of a table of the light field.
//!
//! A light field is the same for every sun of the same air: what differs is the part of it that an observer sees. The suns of a table stand
//! about one of a fixed row of suns, the centre, so that all scenes whose sun is near it have the very same table.

use std::f64::consts::FRAC_PI_2;

use sorairo_shared::profile::Atmosphere;

use crate::plan::directions::horizon;

/// The zenith angle (radians) up to which a sun is one of day: beyond it light falls off fast.
pub const DAY: f64 = 78.0 * DEGREE;
/// The zenith angle (radians) above which the spectra of a sun change from place to place.
pub const LOW: f64 = 86.0 * DEGREE;
/// One degree (radians).
pub const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// Step between the suns of a day.
const STEP_BY_DAY: f64 = 5.0 * DEGREE;
/// Step between low suns over the part of the planet that is seen.
const STEP_SEEN: f64 = 2.0 * DEGREE;
/// Unit of the steps beyond it, which grow: 1, 3, 5 and so on.
const STEP_BEYOND: f64 = 0.5 * DEGREE;
/// The part of a low sun's elevation that a step takes at least: light falls off the faster, the nearer the sun is to the horizon. With two fifths no light
/// field is farther from a finer one than with steps of half a degree.
const STEP_OF_ELEVATION: f64 = 1.0 / 3.0;
/// How far behind the seen part of the planet the sun matters where it is lower: with 8° nothing comes nearer to a finer light field.
const DARK_MARGIN: f64 = 5.0 * DEGREE;
/// In twilight light comes from where the sun stands as high as this zenith angle.
const BRIGHT_ENOUGH: f64 = 84.0 * DEGREE;

/// Distance between two centres by day: that of the nodes.
const CENTRES_BY_DAY: f64 = STEP_BY_DAY;
/// Distance between two centres where the sun is low.
const CENTRES: f64 = 4.0 * STEP_BEYOND;
/// Distance between two centres about the horizon and below it, where light changes fastest: half of it reaches as far as the shortest step.
const CENTRES_IN_TWILIGHT: f64 = 2.0 * STEP_BEYOND;

/// A sun of the fixed row.
#[derive(Clone, Copy, Debug)]
pub struct Centre {
    /// Its zenith angle (radians).
    pub angle: f64,
    /// How far from it a sun is at most to which no other is nearer (radians).
    pub reach: f64,
}

impl Centre {
    /// The one that is nearest to a sun's zenith angle (radians). The observer's altitude is in km.
    pub fn nearest(atmosphere: &Atmosphere, altitude: f64, sun: f64) -> Self {
        let ground = f64::from(atmosphere.ground_radius);
        let farthest = -horizon(ground, altitude) - horizon(ground, f64::from(atmosphere.depth));
        let nearest = |distance: f64| Self { angle: (sun / distance).round() * distance, reach: 0.5 * distance };
        if sun + farthest < DAY {
            return nearest(CENTRES_BY_DAY);
        }
        let low = nearest(CENTRES);
        // Whole degrees, rounded: a half step decides as none would.
        if low.angle < LOW + 0.5 * STEP_BEYOND { low } else { nearest(CENTRES_IN_TWILIGHT) }
    }

    /// Elevations (degrees) of the suns about it: the lowest, its own, the highest.
    pub fn elevations(self) -> [f64; 3] {
        // Half way to the next centre, single precision would decide which is nearer.
        const WITHIN: f64 = 0.99;
        [WITHIN, 0.0, -WITHIN].map(|away| (FRAC_PI_2 - self.angle - away * self.reach).min(FRAC_PI_2).to_degrees())
    }
}

/// Zenith angles of the sun at the places from which light comes (radians): about a centre, as far as air is seen, and in twilight
/// to where the sun shines. The centre, `sun`, is one of them. The observer's altitude is in km.
pub fn sun_nodes(atmosphere: &Atmosphere, altitude: f64, sun: f64) -> Vec<f64> {
    let ground = f64::from(atmosphere.ground_radius);
    let seen = -horizon(ground, altitude);
    let top = -horizon(ground, f64::from(atmosphere.depth));
    let brightest = (sun - seen - top).clamp(0.0, BRIGHT_ENOUGH);
    // Where the sun stands as far below the horizon as twice the top of the atmosphere can see, and some more, nothing is lit.
    let night = FRAC_PI_2 + 2.5 * top;
    let darkest = (sun + seen + top.min(DARK_MARGIN)).min(night);
    let step = |angle: f64| {
        let away = (angle - sun).abs();
        let from_seen =
            if away < seen { STEP_SEEN } else { STEP_BEYOND * (2.0 * ((away - seen) / STEP_BEYOND).sqrt() + 1.0) };
        let from_horizon = STEP_OF_ELEVATION * (FRAC_PI_2 - angle);
        if angle < DAY { STEP_BY_DAY } else { from_seen.max(from_horizon).min(STEP_BY_DAY) }
    };
    // A step may not be much longer than the one behind it.
    let stepped = |angle: f64, sign: f64| {
        let first = step(angle);
        angle + sign * first.min(step(angle + sign * first).max(0.5 * first))
    };
    const CLOSE: f64 = 0.3 * DEGREE;
    let mut brighter = Vec::new();
    let mut angle = sun;
    while angle > brightest + CLOSE {
        angle = stepped(angle, -1.0).max(0.0);
        brighter.push(angle);
    }
    let mut suns: Vec<f64> = brighter.into_iter().rev().chain([sun]).collect();
    angle = sun;
    while angle < darkest - CLOSE || suns.len() < 4 {
        angle = stepped(angle, 1.0);
        suns.push(angle);
    }
    suns
}
