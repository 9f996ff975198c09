//! The suns of a table of the light field.
//!
//! A light field is the same for every sun of the same air: what differs is the part of it that an observer sees. The
//! suns of a table stand about one of a fixed row of suns, the centre, so that all scenes whose sun is near it have the
//! very same table.

use std::f64::consts::FRAC_PI_2;

use sorairo_shared::medium::atmosphere::Atmosphere;

use crate::plan::rays::directions::horizon;

/// The zenith angle (radians) up to which a sun is one of day: beyond it light falls off fast.
pub const DAY: f64 = 78.0 * DEGREE;
/// The zenith angle (radians) above which the spectra of a sun change from place to place.
pub const LOW: f64 = 86.0 * DEGREE;
/// One degree (radians).
pub const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// How far behind the seen part of the planet the sun matters where it is lower: with 8° nothing comes nearer to a
/// finer light field.
const DARK_MARGIN: f64 = 5.0 * DEGREE;
/// The scale heights of an aerosol that lies high from where its horizon stands for [`DARK_MARGIN`]: the dust of Mars is
/// seen 12° far, and with 5° its sky under a sun at 14° has 0.7 % less red light, with 8° 0.3.
const DARK_SCALE_HEIGHTS: f64 = 7.0;
/// In twilight light comes from where the sun stands as high as this zenith angle.
const BRIGHT_ENOUGH: f64 = 84.0 * DEGREE;

/// Distance between two centres by day.
const CENTRES_BY_DAY: f64 = 5.0 * DEGREE;
/// Distance between two centres where the sun is low.
const CENTRES: f64 = 2.0 * DEGREE;
/// Distance between two centres about the horizon and below it, where light changes fastest.
const CENTRES_IN_TWILIGHT: f64 = DEGREE;

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
        if low.angle < LOW + 0.25 * DEGREE { low } else { nearest(CENTRES_IN_TWILIGHT) }
    }

    /// Elevations (degrees) of the suns about it: the lowest, its own, the highest.
    pub fn elevations(self) -> [f64; 3] {
        // Half way to the next centre, single precision would decide which is nearer.
        const WITHIN: f64 = 0.99;
        [WITHIN, 0.0, -WITHIN].map(|away| (FRAC_PI_2 - self.angle - away * self.reach).min(FRAC_PI_2).to_degrees())
    }
}

/// Zenith angles of the sun at the places from which light comes (radians): about a centre, as far as air is seen, and
/// in twilight to where the sun shines. They are some of one fixed row of whole degrees, so that the tables of
/// neighbouring centres have the same nodes but at their ends, and a sun that passes from one to the next sees no step.
/// The observer's altitude is in km.
pub fn sun_nodes(atmosphere: &Atmosphere, altitude: f64, sun: f64) -> Vec<f64> {
    let ground = f64::from(atmosphere.ground_radius);
    let seen = -horizon(ground, altitude);
    let top = -horizon(ground, f64::from(atmosphere.depth));
    let brightest = (sun - seen - top).clamp(0.0, BRIGHT_ENOUGH);
    // Where the sun stands as far below the horizon as twice the top of the atmosphere can see, and some more, nothing
    // is lit.
    let night = FRAC_PI_2 + 2.5 * top;
    let high_aerosol = -horizon(ground, DARK_SCALE_HEIGHTS * f64::from(atmosphere.aerosol.scale_height));
    let darkest = (sun + seen + top.min(DARK_MARGIN.max(high_aerosol))).min(night);
    const CLOSE: f64 = 0.3;
    let (centre, seen) = (sun / DEGREE, seen / DEGREE);
    let is_node = |degree: &u32| degree.is_multiple_of(step(*degree, (f64::from(*degree) - centre).abs() - seen));
    let first = (0..=(brightest / DEGREE + CLOSE) as u32).rev().find(is_node).unwrap_or(0);
    let mut suns = Vec::new();
    for degree in (first..).filter(is_node) {
        suns.push(f64::from(degree) * DEGREE);
        if suns.len() >= 4 && f64::from(degree) >= darkest / DEGREE - CLOSE {
            break;
        }
    }
    suns
}

/// Whole degrees between two suns of a table at a zenith angle (degrees), which is so far (degrees) beyond what is seen
/// of the planet under the centre: the fewer, the faster light falls off there and the more of it an observer sees.
/// Steps of 1° beside the horizon are as near to a finer light field as 0.5°.
fn step(angle: u32, beyond: f64) -> u32 {
    match angle {
        0..80 => 5,
        80..86 => 2,
        _ if beyond > 9.5 => 4,
        _ if beyond > 4.5 => 2,
        _ => 1,
    }
}
