//! How a scene's rays are sampled: as few samples as keep the radiance within its error, measured on the scene's own
//! rays.

use rayon::prelude::*;
use sorairo_shared::glam::{Vec2, Vec3, Vec4};
use sorairo_shared::medium::bands::Bands;
use sorairo_shared::medium::phase::ScatteringAngle;
use sorairo_shared::processor::kernels::light_of_directions;
use sorairo_shared::processor::lanes::BLOCK;
use sorairo_shared::sky::{ByConstituent, transfer_of_parts, view_ray};
use sorairo_shared::uniform::{Buffers, Uniform};
use sorairo_shared::variant;

use crate::error::Result;
use crate::medium::tables::Tables;
use crate::plan::light_field::LightFields;
use crate::plan::on_device::{PlanDevice, Views};
use crate::plan::rays::directions::{direction, horizon};
use crate::plan::rays::quadrature::gauss_legendre;
use crate::scene::Scene;
use crate::spectra::optics::Optics;

/// A radiance below this part of its scene's maximum is judged by its absolute error.
pub const FAINT: f64 = 1e-9;

/// The largest relative error that a radiance may have.
pub const BOUND: f64 = 1e-3;

/// A scene whose brightest transfer (sr⁻¹) is below this is black, and [`FAINT`] of this is nothing: it is where single
/// precision ends, the smallest exponential (1.6e-38) along the longest paths.
const BLACK: f64 = 1e-21;

/// The difference from twice as many samples at which more are taken: other rays are a little worse than the scene's
/// test rays.
const TOLERANCE: f64 = 0.25 * BOUND;

/// The same where column densities come from tables, which leave as much themselves: finer samples would follow the
/// straight lines between their entries.
const TOLERANCE_OF_TABLES: f64 = BOUND;

/// Samples that a guess is compared with, at least: two coarse rules can miss the same.
const FEWEST_OF_REFERENCE: u32 = 96;

/// What a smooth integrand takes, and one of measured profiles, whose levels leave kinks.
const SMOOTH: u32 = 12;
const SMOOTH_OF_TABLES: u32 = 24;

/// Most samples on a piece that are taken unasked.
const MOST: u32 = 3072;

/// The error of a radiance relative to itself or, where it is fainter than 1e-9 of the scene's maximum, to a millionth
/// of that: so that [`BOUND`] stands for 1e-3 of the one and 1e-9 of the other. In a black scene the larger of both
/// counts. Infinite for what is not a number.
pub fn error(value: f64, reference: f64, brightest: f64) -> f64 {
    let faint = FAINT / BOUND * brightest.max(BLACK);
    let scale = if brightest < BLACK {
        reference.max(faint)
    } else if reference > FAINT * brightest {
        reference
    } else {
        faint
    };
    let error = (value - reference).abs() / scale;
    if error.is_nan() { f64::INFINITY } else { error }
}

/// Samples per piece: the fewest that keep the radiance of the scene's test rays within [`BOUND`].
///
/// By day and from the ground of a planet like the Earth the integrand is smooth, and 12 samples do. With a low sun,
/// rays of sunlight graze the edges of the ozone tent, where its column density has a singularity of the power 3/2, and
/// 48 are needed. These are the first guess; more are taken until a rule of twice as many, and of 96 at least, agrees
/// on the test rays. What takes more than a smooth day is seldom worst on these: there a second set of rays, between
/// them, has to agree too.
///
/// `bands` are the plan's own. Where light fields have a device, the rays are integrated there.
pub fn per_piece(
    scene: &Scene,
    tables: Option<&Tables>,
    uniform: &Uniform,
    optics: &Optics,
    bands: &[Bands],
    integral: u32,
    light_fields: &LightFields,
) -> u32 {
    let columns = tables.map_or(&[][..], |tables| &tables.entries[..]);
    let sky = Sky { uniform, columns, bands: test_bands(scene, optics, bands, integral), integral, light_fields };
    let smooth = if tables.is_some() { SMOOTH_OF_TABLES } else { SMOOTH };
    let guess = if scene.sun.elevation >= 5.0 { smooth } else { 48 };
    let mut brightest = Vec::new();
    let first = sky.fewest(test_views(scene, &FIRST), &mut brightest, guess);
    if first == smooth {
        return smooth;
    }
    sky.fewest(test_views(scene, &SECOND), &mut brightest, first)
}

/// The next number of samples to try: 12, 16, 24, 32, 48, 64 and so on.
fn more(samples: u32) -> u32 {
    if samples.is_multiple_of(3) { samples / 3 * 4 } else { samples / 2 * 3 }
}

/// Numbers of samples that are tried before so many.
pub fn fewer_than(samples: u32) -> impl Iterator<Item = u32> {
    std::iter::successors(Some(SMOOTH), |&samples| Some(more(samples))).take_while(move |&fewer| fewer < samples)
}

/// The scene's sky at the test wavelengths.
struct Sky<'a> {
    uniform: &'a Uniform,
    columns: &'a [Vec4],
    bands: Vec<Bands>,
    integral: u32,
    light_fields: &'a LightFields,
}

impl Sky<'_> {
    /// The transfer at the test wavelengths along each view, by rules of so many samples.
    fn transfers(&self, views: &[Vec3], samples: &[u32]) -> Vec<Vec<Vec<f64>>> {
        let on_device = self.light_fields.ask_device(|device| self.transfers_on(device, views, samples));
        on_device.unwrap_or_else(|| samples.iter().map(|&samples| self.transfer(views, samples)).collect())
    }

    /// The same on a device.
    fn transfers_on(&self, device: &dyn PlanDevice, views: &[Vec3], samples: &[u32]) -> Result<Vec<Vec<Vec<f64>>>> {
        let rules: Vec<_> = samples.iter().copied().map(gauss_legendre).collect();
        let look = |quadrature| {
            let buffers = Buffers { bands: &self.bands, quadrature, colour: &[], multiple: &[], columns: self.columns };
            Views { uniform: self.uniform, buffers, variant: self.variant(), views }
        };
        let looks: Vec<_> = rules.iter().map(|rule| look(rule)).collect();
        Ok(device.light_of_views(&looks)?.iter().map(|light| self.of_views(views, light)).collect())
    }

    fn variant(&self) -> u32 {
        self.integral & !variant::REST
    }

    /// The transfer along each view, from the light at each group of bands.
    fn of_views(&self, views: &[Vec3], light: &[ByConstituent<Vec4>]) -> Vec<Vec<f64>> {
        let transfer = |(&view, light): (&Vec3, &[ByConstituent<Vec4>])| {
            let angle = ScatteringAngle::of_ray(view_ray(self.uniform, view));
            let four = |(&parts, bands): (&ByConstituent<Vec4>, &Bands)| {
                transfer_of_parts(self.uniform, parts, (Vec4::ZERO, bands.abscissae), angle, self.variant()).to_array()
            };
            light.iter().zip(&self.bands).flat_map(four).map(f64::from).collect()
        };
        views.iter().zip(light.chunks_exact(self.bands.len())).map(transfer).collect()
    }

    /// The transfer at the test wavelengths along each view.
    fn transfer(&self, views: &[Vec3], samples: u32) -> Vec<Vec<f64>> {
        let quadrature: &[Vec2] = &gauss_legendre(samples);
        let buffers = Buffers { bands: &self.bands, quadrature, colour: &[], multiple: &[], columns: self.columns };
        let of_block = |views: &[Vec3]| {
            let mut light = vec![ByConstituent::default(); views.len() * self.bands.len()];
            light_of_directions(self.uniform, buffers, views, &mut light, self.variant());
            self.of_views(views, &light)
        };
        views.par_chunks(BLOCK).flat_map_iter(of_block).collect()
    }

    /// The fewest samples, from a guess on, that keep the radiance along each view within the tolerance. `brightest` is
    /// the largest value of the views before at each wavelength.
    fn fewest(&self, mut views: Vec<Vec3>, brightest: &mut Vec<f64>, guess: u32) -> u32 {
        let has_tables = self.integral & variant::TABLES != 0;
        let tolerance = if has_tables { TOLERANCE_OF_TABLES } else { TOLERANCE };
        let mut samples = guess;
        // What is known of the views that are left, by the samples of the rule.
        let mut known: Vec<(u32, Vec<Vec<f64>>)> = Vec::new();
        while samples < MOST {
            let rules = [samples, (2 * samples).max(FEWEST_OF_REFERENCE)];
            let unknown: Vec<u32> = rules.into_iter().filter(|rule| known.iter().all(|(of, _)| of != rule)).collect();
            known.extend(unknown.iter().copied().zip(self.transfers(&views, &unknown)));
            let of = |rule| &known.iter().find(|(of, _)| *of == rule).expect("both rules are known").1;
            let (values, references) = (of(rules[0]), of(rules[1]));
            *brightest = largest(brightest, references);
            let errors = values.iter().zip(references).map(|(value, reference)| worst(value, reference, brightest));
            let errors: Vec<f64> = errors.collect();
            let largest = errors.iter().copied().fold(0.0, f64::max);
            if largest <= tolerance {
                return samples;
            }
            // What is far within the bound will not leave it with more samples.
            let is_left: Vec<bool> = errors.iter().map(|&error| error > tolerance / 16.0).collect();
            retain(&mut views, &is_left);
            known.iter_mut().for_each(|(_, of_views)| retain(of_views, &is_left));
            // Where light grazes a kink of the ozone the error falls by the power 2.5 of the samples: twice as many are
            // not too many there.
            samples = if largest > 8.0 * tolerance { 2 * samples } else { more(samples) };
        }
        MOST
    }
}

/// Keeps those that are left.
fn retain<T>(all: &mut Vec<T>, is_left: &[bool]) {
    let mut is_left = is_left.iter();
    all.retain(|_| is_left.next() == Some(&true));
}

/// The largest value of rays at each wavelength, and of those `before`.
fn largest(before: &[f64], rays: &[Vec<f64>]) -> Vec<f64> {
    let count = rays.first().map_or(0, Vec::len);
    let before = |band| before.get(band).copied().unwrap_or(0.0);
    (0..count).map(|band| rays.iter().map(|ray| ray[band]).fold(before(band), f64::max)).collect()
}

/// The largest [`error`] of a ray at any wavelength. Other rays and other wavelengths may be fainter here and not
/// there: what counts as faint is fainter still.
fn worst(value: &[f64], reference: &[f64], brightest: &[f64]) -> f64 {
    (0..value.len()).map(|band| error(value[band], reference[band], 0.01 * brightest[band])).fold(0.0, f64::max)
}

/// The ends of the range of bands, and where air and ozone weigh differently between them (nm).
const TEST_WAVELENGTHS: [f64; 4] = [360.0, 440.0, 590.0, 830.0];

/// Wavelengths between those (nm), for scenes that are black at some of them: where they just are not, the error is
/// largest.
const BETWEEN: [f64; 4] = [480.0, 530.0, 650.0, 700.0];

/// A column density of ozone (DU) that can make the sky black in the middle of its band: three times the Earth's.
const MUCH_OZONE: f64 = 1000.0;

/// Whether a scene's samples depend on the bands: elsewhere those for one plan of its sky are those for any.
pub fn depends_on_bands(scene: &Scene, integral: u32) -> bool {
    integral & variant::OPAQUE != 0 || scene.atmosphere.ozone.column > MUCH_OZONE
}

/// The wavelengths at which a scene's error is measured. A scene that is black somewhere is tried with the plan's own
/// bands too: samples are placed for the most opaque of four, and not all of the others need be at their best.
fn test_bands(scene: &Scene, optics: &Optics, bands: &[Bands], integral: u32) -> Vec<Bands> {
    let mut tested = vec![optics.bands(TEST_WAVELENGTHS)];
    if depends_on_bands(scene, integral) {
        tested.push(optics.bands(BETWEEN));
        tested.extend(bands.first());
        tested.extend(bands.get(1..).and_then(<[Bands]>::last));
    }
    tested
}

/// Where test rays go.
struct TestRays {
    /// Azimuths from the sun (degrees).
    azimuths: &'static [f64],
    /// Elevations above the horizon (degrees).
    above_horizon: &'static [f64],
    /// Elevations below the horizon (degrees), of an observer above the ground.
    below_horizon: &'static [f64],
    /// Lowest points of rays behind the limb, as parts of the observer's altitude or of the atmosphere's depth if that
    /// is less.
    limb: &'static [f64],
    /// Lowest points of rays behind the limb, as parts of the heights of the ozone tent's corners.
    below_ozone: f64,
    /// Elevations of the sun (degrees) at places on the ground.
    low_suns: &'static [f64],
    /// Elevations of the sun at the lowest points behind the limb, as parts of the angle by which the horizon lies
    /// lower at the top of the atmosphere than on the ground.
    suns_of_limb: &'static [f64],
}

/// The test rays of every scene.
const FIRST: TestRays = TestRays {
    azimuths: &[2.0, 25.0, 50.0, 75.0, 100.0, 125.0, 150.0, 178.0],
    above_horizon: &[BESIDE, 0.1, 0.5, 2.0, 8.0, 20.0, 45.0],
    below_horizon: &[BESIDE, 0.1, 1.0, 5.0, 30.0],
    limb: &[0.1, 0.3, 0.5, 0.7, 0.9],
    below_ozone: 0.97,
    low_suns: &[-4.0, -2.0, -1.0, -0.3, 0.0, 1.0, 3.0, 5.0, 8.0],
    suns_of_limb: &[-0.1, -0.5],
};

/// Test rays between the [`FIRST`].
const SECOND: TestRays = TestRays {
    azimuths: &[13.0, 38.0, 62.0, 90.0, 112.0, 138.0, 165.0],
    above_horizon: &[0.02, 0.25, 1.0, 4.0, 13.0, 31.0, 66.0],
    below_horizon: &[0.02, 0.4, 2.0, 12.0, 60.0],
    limb: &[0.05, 0.15, 0.2, 0.25, 0.35, 0.4, 0.45, 0.55, 0.6, 0.65, 0.75, 0.8, 0.85, 0.95],
    below_ozone: 0.9,
    low_suns: &[-3.0, -1.5, -0.6, -0.15, 0.1, 0.5, 2.0, 4.0, 6.5],
    suns_of_limb: &[0.04, -0.02, -0.06, -0.15, -0.22, -0.3, -0.4, -0.7],
};

/// Directions that meet every kind of ray: towards the sun, across and away from it; the zenith, the horizon and close
/// above it; to where the sun sets at the top of the atmosphere; from above the ground also level, down, through the
/// air behind the limb at several heights, to the ground where the sun is low, and behind the limb where it is.
fn test_views(scene: &Scene, rays: &TestRays) -> Vec<Vec3> {
    let a = &scene.atmosphere;
    let (ground, altitude) = (a.ground_radius, scene.observer.altitude);
    let level_horizon = horizon(ground, altitude).to_degrees();
    let mut elevations: Vec<f64> = rays.above_horizon.iter().map(|above| level_horizon + above).collect();
    elevations.push(90.0);
    let lowest_points = if altitude > 0.0 { lowest_points(scene, rays) } else { Vec::new() };
    if altitude > 0.0 {
        elevations.extend(rays.below_horizon.iter().map(|below| level_horizon - below));
        elevations.extend([0.0, -90.0]);
        elevations.extend(lowest_points.iter().map(|&lowest| limb(scene, lowest).to_degrees()));
    }
    let top = a.top_radius - ground;
    let views = |&from_sun: &f64| {
        let on_ground = rays.low_suns.iter().flat_map(move |&low| views_of_low_sun(scene, from_sun, low, 0.0));
        let low_sun = on_ground.chain(views_of_low_sun(scene, from_sun, 0.0, top));
        let all = elevations.clone().into_iter().chain(low_sun);
        all.map(move |elevation| toward(scene, elevation, from_sun))
    };
    let dip = -horizon(ground, top).to_degrees();
    let low_sun_of_limb = lowest_points.iter().flat_map(|&lowest| {
        rays.suns_of_limb.iter().filter_map(move |&part| limb_of_low_sun(scene, lowest, part * dip))
    });
    let sun = toward(scene, scene.sun.elevation, 0.0);
    rays.azimuths.iter().flat_map(views).chain(low_sun_of_limb).chain([sun, -sun]).collect()
}

/// A direction by its elevation and its azimuth from the sun (degrees).
fn toward(scene: &Scene, elevation: f64, from_sun: f64) -> Vec3 {
    direction(elevation.clamp(-90.0, 90.0), scene.sun.azimuth + from_sun).as_vec3()
}

/// Lowest points (km) of the rays behind the limb.
fn lowest_points(scene: &Scene, rays: &TestRays) -> Vec<f64> {
    let a = &scene.atmosphere;
    let highest = scene.observer.altitude.min(a.top_radius - a.ground_radius);
    let thinner = a.air.scale_height.min(a.aerosol.mixture(&a.profile).lane.scale_height);
    let ozone = [a.ozone.bottom, 0.5 * (a.ozone.bottom + a.ozone.peak), a.ozone.peak, a.ozone.top];
    let of_air = [0.5 * thinner, 1.5 * thinner, 4.0 * a.air.scale_height].into_iter();
    let all = of_air.chain(rays.limb.iter().map(|part| part * highest)).chain(ozone.map(|h| rays.below_ozone * h));
    all.map(|h| h.min(highest)).collect()
}

/// Elevation (radians) of the ray that comes down to a lowest point (km).
fn limb(scene: &Scene, lowest: f64) -> f64 {
    horizon(scene.atmosphere.ground_radius + lowest, scene.observer.altitude - lowest)
}

/// The direction to the lowest point (km) of a ray behind the limb where the sun stands at an elevation (degrees), if
/// there is one; see [`views_of_low_sun`].
fn limb_of_low_sun(scene: &Scene, lowest: f64, low: f64) -> Option<Vec3> {
    let elevation = limb(scene, lowest);
    let (up, level) = scene.sun.elevation.to_radians().sin_cos();
    let across = (low.to_radians().sin() - up * elevation.cos()) / (level * -elevation.sin());
    (across.abs() <= 1.0).then(|| toward(scene, elevation.to_degrees(), across.acos().to_degrees()))
}

/// An angle (degrees) that parts a ray from the horizon, where rounding would choose whether it meets the ground.
const BESIDE: f64 = 1e-4;

/// The elevations (degrees) at which an observer sees places of a height (km) where the sun stands at an elevation
/// (degrees), in the direction of an azimuth (degrees) from the sun: none, one or two.
///
/// At the angle `θ` from the observer, at the planet's centre, the sun's elevation `e` has
/// `sin e = sin ε cos θ + cos ε cos φ sin θ`, with `ε` the sun's elevation at the observer.
fn views_of_low_sun(scene: &Scene, from_sun: f64, low: f64, height: f64) -> impl Iterator<Item = f64> {
    let (ground, altitude) = (scene.atmosphere.ground_radius, scene.observer.altitude);
    let (up, across) = scene.sun.elevation.to_radians().sin_cos();
    let across = across * from_sun.to_radians().cos();
    let middle = across.atan2(up);
    let half = (low.to_radians().sin() / up.hypot(across)).acos();
    let farthest = -horizon(ground, altitude) - horizon(ground, height);
    [middle - half, middle + half].into_iter().filter(move |&angle| angle > 0.0 && angle < farthest).map(move |angle| {
        let (sine, cosine) = angle.sin_cos();
        ((ground + height) * cosine - ground - altitude).atan2((ground + height) * sine).to_degrees()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::SkyPlan;
    use crate::scene::{Preset, Rgb};

    fn samples(change: impl FnOnce(&mut Scene)) -> u32 {
        let mut scene = Scene::preset(Preset::Earth).first_order();
        change(&mut scene);
        SkyPlan::new(&scene.validated().unwrap(), Rgb::Srgb).base.quadrature.len() as u32
    }

    #[test]
    fn the_earth_from_its_ground_takes_few_samples() {
        for (sun, expected) in [(90.0, 12), (30.0, 12), (5.0, 12), (4.0, 48), (0.0, 48), (-4.0, 64)] {
            assert_eq!(samples(|scene| scene.sun.elevation = sun), expected, "sun at {sun}");
        }
    }

    #[test]
    fn thick_air_takes_more_samples() {
        assert!(samples(|scene| scene.atmosphere.air.scattering *= 100.0) > 12);
    }

    #[test]
    fn what_is_not_a_number_is_an_infinite_error() {
        assert_eq!(error(f64::NAN, 1.0, 1.0), f64::INFINITY);
        assert_eq!(error(1.001, 1.0, 1.0).to_bits(), (1.001_f64 - 1.0).to_bits());
        // 1e-9 of the maximum counts as much as 1e-3 of what is brighter.
        assert!((error(1e-9, 0.0, 1.0) - BOUND).abs() < 1e-12);
    }

    #[test]
    fn a_sky_below_what_single_precision_holds_is_black() {
        assert!(error(0.0, 1e-3 * FAINT * BLACK, 1e-3 * BLACK) < BOUND);
        assert!(error(2.99 * FAINT * BLACK, 3.0 * FAINT * BLACK, 1e-6 * BLACK) < BOUND);
        assert!(error(1.002 * BLACK, BLACK, BLACK) > BOUND && error(0.0, 1e-6 * BLACK, 1e-6 * BLACK) > BOUND);
        assert!(error(0.0, 10.0 * FAINT * BLACK, BLACK) > BOUND);
    }
}
