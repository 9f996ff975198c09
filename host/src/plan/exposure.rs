//! Automatic exposure.

use super::{Plan, direction};
use crate::scene::keys::MOST_STOPS;

/// The linear value of a picture (of 1) at which the sky's mean luminance is shown.
const MIDDLE: f64 = 0.25;

/// The exposure factor that shows the sky's mean luminance at `MIDDLE`.
///
/// The mean is geometric, so that the glow around the sun does not darken the rest, over directions spread evenly on the
/// upper hemisphere; if all of that is black, over the lower hemisphere, or what the atmosphere fills of it (an observer in
/// space). It depends on the sky alone, not on the camera, so that the pictures of one scene match. A night without any light
/// gets 1. Skies that are darker or brighter than the exposures that may be asked for, [`MOST_STOPS`], are shown at the last of them.
pub fn automatic(plan: &Plan) -> f32 {
    let upper = (0.0, 1.0);
    let mean = mean_log_luminance(plan, upper).or_else(|| mean_log_luminance(plan, below(plan)));
    mean.map_or(1.0, |mean| (MIDDLE / mean.exp()).clamp((-MOST_STOPS).exp2(), MOST_STOPS.exp2()) as f32)
}

/// The lower hemisphere, and from outside the atmosphere the cone that it fills: sines of the elevation, and from -1.
fn below(plan: &Plan) -> (f64, f64) {
    let atmosphere = &plan.frame.atmosphere;
    let top = f64::from(atmosphere.ground_radius) + f64::from(atmosphere.depth);
    let sine = (top / (f64::from(atmosphere.ground_radius) + f64::from(plan.frame.altitude))).min(1.0);
    // 1 - cos without its cancellation.
    (-1.0, sine * sine / (1.0 + (1.0 - sine * sine).sqrt()))
}

/// Mean logarithm of the luminance over the directions whose sine of the elevation lies within `height` above `lowest`; `None`
/// if they are black.
fn mean_log_luminance(plan: &Plan, (lowest, height): (f64, f64)) -> Option<f64> {
    const ELEVATIONS: u32 = 8;
    const AZIMUTHS: u32 = 12;
    let mut sum = 0.0;
    let mut lit = 0;
    for i in 0..ELEVATIONS {
        // Equal steps of the sine are equal solid angles.
        let sine: f64 = lowest + height * (f64::from(i) + 0.5) / f64::from(ELEVATIONS);
        let elevation = sine.asin().to_degrees();
        for j in 0..AZIMUTHS {
            let azimuth = plan.sun_azimuth + (f64::from(j) + 0.5) * 360.0 / f64::from(AZIMUTHS);
            let view = direction(elevation, azimuth).as_vec3();
            let luminance = f64::from(plan.frame.rgb.luminance(plan.sky(view)));
            if luminance > 0.0 {
                sum += luminance.ln();
                lit += 1;
            }
        }
    }
    (lit > 0).then(|| sum / f64::from(lit))
}
