//! Automatic exposure.

use std::f64::consts::PI;

use sorairo_shared::glam::Vec3;
use sorairo_shared::math::clamp;

use super::directions::direction;
use super::integral::RayIntegral;
use crate::scene::{Exposure, MOST_STOPS};

/// The linear value of a picture (of 1) at which the sky's mean luminance is shown.
const MIDDLE: f64 = 0.25;

/// The exposure factor that is asked for, of a sky by its ray integral and its linear RGB in directions.
pub fn of(exposure: Exposure, integral: &RayIntegral, radiances: impl Fn(&[Vec3]) -> Vec<Vec3>) -> f32 {
    let luminance = |rgb| f64::from(integral.uniform.rgb.luminance(rgb));
    match exposure {
        Exposure::Stops(stops) => stops.exp2() as f32,
        Exposure::Auto => automatic(integral, &|views| radiances(views).into_iter().map(luminance).collect()),
    }
}

/// An automatic exposure factor where the image shows the sun's disc too, which sends so much light on a surface that faces it (luminance
/// times solid angle): as if its light came from the whole hemisphere.
pub fn with_disc(factor: f32, light: f64) -> f32 {
    let mean = MIDDLE / f64::from(factor) + light / (2.0 * PI);
    (MIDDLE / mean).max((-MOST_STOPS).exp2()) as f32
}

/// The largest number that half floats hold.
pub const LARGEST_HALF: f32 = 65_504.0;

/// Stops by which half floats are exposed whose brightest value would be `brightest`: none where that is far from both ends of their range, so
/// that what is ten thousand times darker keeps its digits too; else as many as bring it near the upper end. A black sky has none.
pub fn of_halves(brightest: f32) -> f32 {
    /// The brightest is known from some directions alone; others may be four times as bright.
    const ROOM: f32 = LARGEST_HALF / 4.0;
    let is_safe = brightest == 0.0 || (1.0..=ROOM).contains(&brightest);
    if is_safe { 0.0 } else { clamp((ROOM / brightest).log2().floor(), -MOST_STOPS as f32, MOST_STOPS as f32) }
}

/// The luminance in some directions.
type Luminances<'a> = dyn Fn(&[Vec3]) -> Vec<f64> + 'a;

/// The exposure factor that shows the sky's mean luminance at `MIDDLE`.
///
/// The mean is geometric, so that the glow around the sun does not darken the rest, over directions spread evenly on the
/// upper hemisphere; if all of that is black, over the lower hemisphere, or what the atmosphere fills of it (an observer in
/// space). It depends on the sky alone, not on the camera, so that the pictures of one scene match. Where few directions alone are lit, more
/// are looked at. A night without any light gets 1. Skies that are darker or brighter than the exposures that may be asked for,
/// [`MOST_STOPS`], are shown at the last of them.
fn automatic(integral: &RayIntegral, luminances: &Luminances<'_>) -> f32 {
    let sun = integral.sun_azimuth;
    let (upper, lower) = ((0.0, 1.0), below(integral));
    let mean = [1, 8].into_iter().find_map(|finer| {
        mean_log_luminance(luminances, sun, upper, finer).or_else(|| mean_log_luminance(luminances, sun, lower, finer))
    });
    mean.map_or(1.0, |mean| (MIDDLE / mean.exp()).clamp((-MOST_STOPS).exp2(), MOST_STOPS.exp2()) as f32)
}

/// The lower hemisphere, and from outside the atmosphere the cone that it fills: sines of the elevation, and from -1.
fn below(integral: &RayIntegral) -> (f64, f64) {
    let atmosphere = &integral.uniform.atmosphere;
    let top = f64::from(atmosphere.ground_radius) + f64::from(atmosphere.depth);
    let sine = (top / (f64::from(atmosphere.ground_radius) + f64::from(integral.uniform.altitude))).min(1.0);
    // 1 - cos without its cancellation.
    (-1.0, sine * sine / (1.0 + (1.0 - sine * sine).sqrt()))
}

/// Mean logarithm of the luminance over the directions whose sine of the elevation lies within `height` above `lowest`, `finer` times as
/// many in elevation and azimuth as will do for most skies; `None` if they are black. `sun` is its azimuth (degrees).
fn mean_log_luminance(luminances: &Luminances<'_>, sun: f64, (lowest, height): (f64, f64), finer: u32) -> Option<f64> {
    let (elevations, azimuths) = (8 * finer, 12 * finer);
    let view = |place: u32| {
        let (i, j) = (place / azimuths, place % azimuths);
        // Equal steps of the sine are equal solid angles.
        let sine: f64 = lowest + height * (f64::from(i) + 0.5) / f64::from(elevations);
        let azimuth = sun + (f64::from(j) + 0.5) * 360.0 / f64::from(azimuths);
        direction(sine.asin().to_degrees(), azimuth).as_vec3()
    };
    let views: Vec<Vec3> = (0..elevations * azimuths).map(view).collect();
    let lit: Vec<f64> = luminances(&views).into_iter().filter(|&luminance| luminance > 0.0).map(f64::ln).collect();
    (!lit.is_empty()).then(|| lit.iter().sum::<f64>() / lit.len() as f64)
}

#[cfg(test)]
mod tests {
    use crate::PixelFormat;
    use crate::plan::Plan;
    use crate::scene::Scene;

    /// A case of the random scenes.
    const SPOT: &str = r#"{"preset": "paper", "sun": {"elevation": -5.354264364480926, "azimuth": -338.7779749287318, "spectrum":
        "astm-g173", "distance": 749.8829037034282, "disc": false}, "observer": {"altitude": 0.3758598398378933},
        "atmosphere": {"ground_radius": 6360.0, "top_radius": 6460.0, "air": {"scattering": 0.00124062,
        "scale_height": 15.992244638719209}, "aerosol": {"optical_depth": 0.005328, "angstrom_exponent":
        -4.708961064794607, "scale_height": 1.2, "single_scattering_albedo": 0.9417993150638095,
        "single_scattering_albedo_spectrum": "mars-dust", "asymmetry": 0.8516056677798365}, "ozone": {"column":
        1.8543082112841622, "bottom": 48.3593974209002, "peak": 78.22972330445756, "top": 79.2345361812681,
        "cross_section": "233k"}}, "camera": {"projection": "equirectangular", "size": "33x17", "fov":
        18.130440850552084, "look_azimuth": 0.0, "look_elevation": -90.0}, "render": {"fit": "cubic", "bands":
        [555.2190765158207, 553.2064932090339, 560.5704240441789, 664.38256683192], "color": "solve", "steps": null,
        "path": "direct", "exposure": "auto", "exr": "f32", "rgb": "rec2020", "observer": "cie1931", "white_balance":
        "none"}}"#;

    #[test]
    fn halves_are_exposed_where_they_would_lose_either_end() {
        use super::{LARGEST_HALF, of_halves};
        for brightest in [0.0, 1.0, 250.0, 16_000.0] {
            assert_eq!(of_halves(brightest), 0.0);
        }
        for brightest in [1e-11, 3e-5, 0.99, 17_000.0, 2.9e6, 1e10] {
            let exposed = brightest * of_halves(brightest).exp2();
            assert!((LARGEST_HALF / 8.0..=LARGEST_HALF / 4.0).contains(&exposed), "{brightest}: {exposed}");
        }
        // An exposure that may be asked for.
        assert_eq!(of_halves(1e-30), 50.0);
    }

    /// Bands that lie close together leave a colour to a spot of this twilight, between the directions that the exposure was taken from.
    #[test]
    fn a_sky_that_is_lit_in_few_directions_is_exposed_for_them() {
        let scene = serde_json::from_str::<Scene>(SPOT).unwrap().first_order();
        let exposure = Plan::new(&scene.validated().unwrap(), PixelFormat::LinearRgb).uniform.exposure;
        assert!(exposure > 1e6, "{exposure:e}");
    }
}
