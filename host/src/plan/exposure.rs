//! Automatic exposure.

use super::{Plan, direction};

/// The linear value of a picture (of 1) at which the sky's mean luminance is shown.
const MIDDLE: f64 = 0.25;

/// The exposure factor that shows the sky's mean luminance at [`MIDDLE`].
///
/// The mean is geometric, so that the glow around the sun does not darken the rest, over directions spread evenly on the
/// upper hemisphere; if all of that is black, over the lower hemisphere (an observer in space). It depends on the
/// sky alone, not on the camera, so that the pictures of one scene match. A night without any light gets 1.
pub fn automatic(plan: &Plan) -> f32 {
    let mean = mean_log_luminance(plan, 1.0).or_else(|| mean_log_luminance(plan, -1.0));
    mean.map_or(1.0, |mean| (MIDDLE / mean.exp()) as f32)
}

fn mean_log_luminance(plan: &Plan, hemisphere: f64) -> Option<f64> {
    const ELEVATIONS: u32 = 8;
    const AZIMUTHS: u32 = 12;
    let mut sum = 0.0;
    let mut lit = 0;
    for i in 0..ELEVATIONS {
        // Equal steps of the sine are equal solid angles.
        let elevation = ((f64::from(i) + 0.5) / f64::from(ELEVATIONS)).asin().to_degrees() * hemisphere;
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
