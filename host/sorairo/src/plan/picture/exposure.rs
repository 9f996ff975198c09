//! Exposure: how a camera meters a sky.

use std::f64::consts::{FRAC_PI_4, GOLDEN_RATIO, PI};

use sorairo_shared::camera::Camera;
use sorairo_shared::display::grade::MIDDLE_GREY;
use sorairo_shared::glam::Vec3;
use sorairo_shared::math::{clamp, max, min};
use sorairo_shared::picture::below::{SkyView, sky_view, with_ground};
use sorairo_shared::uniform::{SunDisc, Uniform};
use sorairo_shared::variant::{self, PixelFormat};

use crate::plan::rays::quadrature::gauss_legendre;
use crate::plan::sky::SkyPlan;
use crate::scene::{Exposure, MOST_STOPS, Projection, Scene, stops_of_ev100};

/// Stops by which a picture is brighter than its meter says: a sky shown at middle grey looks like a storm, and
/// photographers open up for it.
const OPENED: f64 = 1.0 / 3.0;

/// The EV100 of a sunlit day, that of the rule by which a film of ISO 100 takes f/16 and 1/125 s.
const DAYLIGHT: f64 = 15.0;

/// The EV100 of the end of civil dusk, when the light on level ground is some 3 lx: a picture that is metered gets
/// darker from there on.
const DUSK: f64 = 0.0;

/// The part of a change of the light that a picture which adapts does not show.
const ADAPTATION: f64 = 0.62;

/// The exposure factor of the picture that a camera takes of a sky: what is asked for, or what a meter says; 1 for
/// texels, which no exposure concerns.
pub fn of(sky: &SkyPlan, scene: &Scene, uniform: &Uniform, variant: u32) -> f32 {
    let is_shown = [PixelFormat::Picture, PixelFormat::LinearRgb]
        .map(|format| format as u32)
        .contains(&variant::pixel_format(variant))
        && !sky.is_night;
    let metered = || if is_shown { metered(sky, scene.camera.projection, uniform, variant) } else { 0.0 };
    let daylight = stops_of_ev100(DAYLIGHT);
    let passes = uniform.polariser.passes.x;
    // Opened for what a polariser takes of natural light.
    let filter = if passes > 0.0 { -f64::from(passes).log2() } else { 0.0 };
    let stops = match scene.render.exposure_of_pictures() {
        Exposure::Stops(stops) => stops,
        Exposure::Auto => filter + until_dusk(metered()),
        Exposure::Adapt if sky.is_night => daylight,
        Exposure::Adapt => filter + daylight + ADAPTATION * (metered() - daylight),
    };
    stops.clamp(-MOST_STOPS, MOST_STOPS).exp2() as f32
}

/// What a meter says (stops), as far as dusk; of what is darker, as an eye adapts, so that a night is one.
fn until_dusk(metered: f64) -> f64 {
    let dusk = stops_of_ev100(DUSK);
    metered - (1.0 - ADAPTATION) * (metered - dusk).max(0.0)
}

/// The largest number that half floats hold.
pub const LARGEST_HALF: f32 = 65_504.0;

/// Stops by which half floats are exposed whose brightest value would be `brightest`: none where that is far from both
/// ends of their range, so that what is ten thousand times darker keeps its digits too; else as many as bring it near
/// the upper end. A black sky has none.
pub fn of_halves(brightest: f32) -> f32 {
    /// The brightest is known from some directions alone; others may be four times as bright.
    const ROOM: f32 = LARGEST_HALF / 4.0;
    let is_safe = brightest == 0.0 || (1.0..=ROOM).contains(&brightest);
    if is_safe { 0.0 } else { clamp((ROOM / brightest).log2().floor(), -MOST_STOPS as f32, MOST_STOPS as f32) }
}

/// The exposure (stops) that shows what a camera sees a little above middle grey, in the mean of its logarithms, so
/// that the glow around the sun does not darken the rest. The sun's disc hardly counts but where it fills some of the
/// picture: it is white in every other. Where few directions alone are lit, more are looked at. A picture without any
/// light gets 0.
fn metered(sky: &SkyPlan, projection: Projection, uniform: &Uniform, variant: u32) -> f64 {
    let mean = [1, 8].into_iter().find_map(|finer| mean_logarithm(sky, projection, uniform, variant, finer));
    let disc = &uniform.disc;
    let part = part_of_disc(disc, &uniform.camera);
    // One that has set is in no picture.
    let with_disc =
        |mean: f64| mean + if part > 0.0 { part * (luminance_of_disc(sky, disc).log2() - mean).max(0.0) } else { 0.0 };
    mean.map_or(0.0, |mean| f64::from(MIDDLE_GREY).log2() + OPENED - with_disc(mean))
}

/// How much the sun's disc counts: wholly where it fills a twentieth of the picture.
fn part_of_disc(disc: &SunDisc, camera: &Camera) -> f64 {
    const WHOLLY: f64 = 0.05;
    let length = |from: f32, to: f32, end: u32| f64::from(min(to, end as f32) - max(from, 0.0)).max(0.0);
    let area = length(disc.left, disc.right, camera.width) * length(disc.top, disc.bottom, camera.height) * FRAC_PI_4;
    (area / f64::from(camera.width) / f64::from(camera.height) / WHOLLY).min(1.0)
}

/// The mean luminance of the sun's disc, in the unit of the sky's.
fn luminance_of_disc(sky: &SkyPlan, disc: &SunDisc) -> f64 {
    let light = sky.integral().uniform.rgb.luminance(sky.sun_irradiance().rgb.as_vec3());
    (f64::from(light) / (PI * f64::from(disc.sine_radius).powi(2))).max(f64::MIN_POSITIVE)
}

/// The mean of the logarithm (to base 2) of the luminance over the picture, by its weights; `None` if all of it is
/// black.
fn mean_logarithm(sky: &SkyPlan, projection: Projection, uniform: &Uniform, variant: u32, finer: u32) -> Option<f64> {
    /// What is so many times as bright as the brightest, seven stops below it, counts half: darker still is the black
    /// of space above the limb.
    const BLACK: f64 = 1.0 / 128.0;
    /// Samples on a piece of a ray from which an observer above the ground gets what a meter needs, of up to 128.
    const ENOUGH: u32 = 32;
    let closely = share_of_band(uniform);
    let looks = looks(uniform, variant, [12 * finer, 8 * finer], closely);
    let weights = looks.iter().map(|look| look.part * weight(projection, look.x - 0.5, look.y - 0.5));
    let views = looks.iter().map(|look| look.view);
    let (directions, sources): (Vec<Vec3>, Vec<Vec3>) = views.clone().map(|view| (view.direction, view.source)).unzip();
    let all = &sky.base.quadrature[..];
    let fewer = if closely > 0.0 && all.len() > ENOUGH as usize { &gauss_legendre(ENOUGH)[..] } else { all };
    let lit = views.zip(sky.radiances_of(&directions, &sources, fewer));
    let luminance =
        |(view, rgb): (SkyView, Vec3)| f64::from(uniform.rgb.luminance(with_ground(uniform, rgb, view.ground)));
    let luminances: Vec<f64> = lit.map(luminance).collect();
    let brightest = brightest(&looks, &luminances, weights.clone(), closely);
    let counted = |luminance: f64| luminance / (luminance + BLACK * brightest);
    let lit = luminances.into_iter().zip(weights).filter(|&(luminance, _)| luminance > 0.0);
    let lit = lit.map(|(luminance, weight)| (luminance, weight * counted(luminance)));
    let (sum, weight) =
        lit.fold((0.0, 0.0), |(sum, all), (luminance, weight)| (sum + weight * luminance.log2(), all + weight));
    (weight > 0.0).then(|| sum / weight)
}

/// The luminance that counts as the brightest: of the middles of cells the largest. Of many places in a thin band that
/// would follow from where they lie; as far as they count, it is the mean by light.
fn brightest(looks: &[Look], luminances: &[f64], weights: impl Iterator<Item = f64>, share: f64) -> f64 {
    let middles = luminances.iter().zip(looks).filter(|(_, look)| look.is_middle).map(|(luminance, _)| *luminance);
    let (light, square) = luminances.iter().zip(weights).fold((0.0, 0.0), |(light, square), (luminance, weight)| {
        (light + weight * luminance, square + weight * luminance * luminance)
    });
    let by_light = if light > 0.0 { square / light } else { 0.0 };
    (1.0 - share) * middles.fold(0.0, f64::max) + share * by_light
}

/// A place where a meter looks, in parts of the picture's sides, and the part of a cell that it stands for.
struct Look {
    x: f64,
    y: f64,
    view: SkyView,
    part: f64,
    /// Whether it is the middle of a cell.
    is_middle: bool,
}

impl Look {
    /// The elevation (radians) in which it looks.
    fn elevation(&self) -> f64 {
        f64::from(clamp(self.view.direction.z, -1.0, 1.0)).asin()
    }
}

/// How much a band about the horizon counts in a meter: not at all for an observer near the ground, to whom no light
/// lies in one; wholly from where the horizon is two degrees below the level.
fn share_of_band(uniform: &Uniform) -> f64 {
    (f64::from(-uniform.horizon).to_degrees() - 1.0).clamp(0.0, 1.0)
}

/// Where a meter looks: at the middle of each of so many columns and rows of cells. An observer above the ground sees
/// much of the light in a band about the horizon that is thinner than a cell; there it looks more closely, or what it
/// says would follow from which cell the band fills. The band counts in a share.
fn looks(uniform: &Uniform, variant: u32, [columns, rows]: [u32; 2], share: f64) -> Vec<Look> {
    let camera = &uniform.camera;
    // In one allocation: a frame has few.
    let mut looks = Vec::with_capacity((columns * rows) as usize);
    for cell in 0..columns * rows {
        let (column, row) = (f64::from(cell % columns), f64::from(cell / columns));
        let within = |x: f64, y: f64, part: f64| {
            let (x, y) = ((column + x) / f64::from(columns), (row + y) / f64::from(rows));
            let place = |part: f64, count: u32| ((part * f64::from(count)) as u32).min(count - 1);
            let view = sky_view(uniform, place(x, camera.width), place(y, camera.height), variant);
            Look { x, y, view, part, is_middle: false }
        };
        let middle = Look { is_middle: true, ..within(0.5, 0.5, 1.0) };
        let closely = if share > 0.0 { across_the_band(uniform, cell, &middle, within) } else { Vec::new() };
        if closely.is_empty() {
            looks.push(middle);
            continue;
        }
        looks.extend((share < 1.0).then_some(Look { part: 1.0 - share, ..middle }));
        looks.extend(closely.into_iter().map(|look| Look { part: share * look.part, ..look }));
    }
    looks.retain(|look| look.view.covered);
    looks
}

/// Places of a cell in which the band about the horizon lies, each with its part; none in any other. The band reaches
/// from the horizon to the level, or from outside the atmosphere to its edge, and half as far below.
fn across_the_band(uniform: &Uniform, cell: u32, middle: &Look, within: impl Fn(f64, f64, f64) -> Look) -> Vec<Look> {
    /// The angle between places across the band, in its width, and the most places of a cell.
    const BETWEEN: f64 = 1.0 / 16.0;
    const MOST: f64 = 64.0;
    /// Of the places beside the band one in so many stands for them.
    const BESIDE: usize = 8;
    let width = f64::from(min(-uniform.horizon, uniform.lookup_span));
    let lowest = f64::from(uniform.horizon) - 0.5 * width;
    let band = lowest..lowest + 1.5 * width;
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]].map(|[x, y]| within(x, y, 0.0).elevation());
    let (low, high) = corners.into_iter().fold((middle.elevation(), middle.elevation()), |(low, high), elevation| {
        (low.min(elevation), high.max(elevation))
    });
    let places = ((high - low) / (BETWEEN * width)).min(MOST) as u32;
    if low >= band.end || high <= band.start || places < 2 {
        return Vec::new();
    }
    let part = 1.0 / f64::from(places);
    let all = (0..places).map(|place| {
        // Hammersley's points: each in a row and in a column of its own, in every cell in other rows.
        let x = f64::from(place.reverse_bits()) / 2f64.powi(32);
        let y = f64::from(place) + (f64::from(cell) * GOLDEN_RATIO).fract();
        within(x, y * part, part)
    });
    let (mut looks, beside): (Vec<_>, Vec<_>) = all.partition(|look| band.contains(&look.elevation()));
    let of_each = beside.len() as f64 * part / beside.len().div_ceil(BESIDE) as f64;
    looks.extend(beside.into_iter().step_by(BESIDE).map(|look| Look { part: of_each, ..look }));
    looks
}

/// How much a place of the picture counts, from its middle in parts of its sides: most in the middle, as cameras meter.
/// A map of the whole sphere has no middle but the low sky, which counts by its solid angle.
fn weight(projection: Projection, x: f64, y: f64) -> f64 {
    /// Where a weight is e^(-1/2) of that in the middle.
    const WIDTH: f64 = 0.3;
    /// The middle of a map, above that of its sides: 22° above the horizon.
    const LOW_SKY: f64 = 0.125;
    let fall = |square: f64| (-0.5 * square / (WIDTH * WIDTH)).exp();
    match projection {
        Projection::Equirectangular => fall(4.0 * (y + LOW_SKY) * (y + LOW_SKY)) * (y * PI).cos(),
        Projection::Fisheye | Projection::Perspective => fall(x * x + y * y),
        Projection::Octahedral => {
            let (x, y) = (2.0 * x.abs(), 2.0 * y.abs());
            let up = 1.0 - x - y;
            let folded = (-up).max(0.0);
            let across = (x - folded).hypot(y - folded);
            let down = -up.atan2(across) / PI;
            fall(4.0 * (down + LOW_SKY) * (down + LOW_SKY)) / up.hypot(across).powi(3)
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::PixelFormat;
    use crate::plan::{LightFields, Plan};
    use crate::scene::{Preset, Projection, Scene, Size};

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

    /// Bands that lie close together leave a colour to a spot of this twilight, between the directions that the
    /// exposure was taken from.
    #[test]
    fn a_sky_that_is_lit_in_few_directions_is_exposed_for_them() {
        let scene = serde_json::from_str::<Scene>(SPOT).unwrap().first_order();
        let exposure = Plan::new(&scene.validated().unwrap(), PixelFormat::LinearRgb).uniform.exposure;
        // By a meter alone it would be 1e7; from dusk on a picture gets darker.
        assert!(exposure > 1e5, "{exposure:e}");
    }

    /// Exposures (stops) of a camera in orbit that tilts by a degree at a time, under a sun.
    fn of_orbit(projection: Projection, sun: impl Fn(f64) -> f64) -> Vec<f32> {
        let mut scene = Scene::preset(Preset::Standard).first_order();
        scene.observer.altitude = 400.0;
        (scene.camera.projection, scene.camera.size) = (projection, Size { width: 960, height: 480 });
        let light_fields = LightFields::default();
        let exposure = |step: i32| {
            scene.sun.elevation = sun(f64::from(step));
            scene.camera.look_elevation = Some(f64::from(step - 26));
            let plan = Plan::with_light_fields(&scene.validated().unwrap(), PixelFormat::Picture, &light_fields);
            plan.exposure()
        };
        (0..=12).map(exposure).collect()
    }

    #[test]
    fn in_orbit_no_exposure_follows_from_where_the_limb_lies_between_the_places_of_a_meter() {
        for (projection, sun) in [
            (Projection::Perspective, (|_| -19.0) as fn(f64) -> f64),
            (Projection::Equirectangular, |step| -19.5 + 0.1 * step),
        ] {
            let exposures = of_orbit(projection, sun);
            // By cells alone they would jump by ten stops.
            let largest = exposures.windows(2).map(|two| (two[1] - two[0]).abs()).fold(0.0, super::max);
            assert!(largest > 0.0 && largest < 0.5, "{projection:?} {exposures:?}");
        }
    }
}
