//! The downwelling irradiance of the sky, and the irradiance of its sun.

use std::f64::consts::PI;

use rayon::prelude::*;
use serde::Serialize;
use sorairo_shared::glam::DVec3;

use crate::plan::quadrature::gauss_legendre;
use crate::plan::sun_disc::Sun;
use crate::plan::{SkyPlan, direction};
use crate::spectra::observer;
use crate::spectrum::FittedSpectrum;

/// Luminous efficacy of radiation of luminance 1 to the observer (lm/W; the SI's constant K_cd).
pub const LUMENS_PER_WATT: f64 = 683.0;

/// Nodes between the horizon and the sun's elevation, and as many from there to the zenith.
const ELEVATIONS: u32 = 16;

/// Nodes over half of the azimuths, which mirror the other half.
const AZIMUTHS: u32 = 24;

/// What falls from the sky, from its sun and from the ground on a level surface at the observer, and the brightness of the zenith.
///
/// With the flat sun, which is 1 at every wavelength, all values are relative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SkyLight {
    /// Diffuse irradiance, that of the sky without the sun itself, between 380 and 780 nm (W·m⁻²).
    pub irradiance_w_m2: f64,
    /// Integral of the linear RGB of an EXR file times the cosine over the upper hemisphere (W·m⁻², weighted by the observer).
    pub irradiance_rgb: [f64; 3],
    /// Illuminance (lx): the irradiance weighted by the observer's ȳ, times [`LUMENS_PER_WATT`].
    pub illuminance_lux: f64,
    /// Direct irradiance, that of the sun itself, on the same level surface between 380 and 780 nm (W·m⁻²).
    pub direct_irradiance_w_m2: f64,
    /// What comes from below, from the ground and from the air before it, on a level surface that faces down, between 380 and 780 nm (W·m⁻²).
    pub ground_irradiance_w_m2: f64,
    /// The same as linear RGB of an EXR file (W·m⁻², weighted by the observer).
    pub ground_irradiance_rgb: [f64; 3],
    /// Irradiance of the sun itself on a surface that faces it, between 380 and 780 nm, through the air (W·m⁻²).
    pub sun_irradiance_w_m2: f64,
    /// The same as linear RGB of an EXR file (W·m⁻², weighted by the observer).
    pub sun_irradiance_rgb: [f64; 3],
    /// Luminance of the zenith (cd·m⁻²).
    pub luminance_zenith_cd_m2: f64,
    /// What falls from the sky and the ground, without the sun itself, on a surface of any direction.
    pub irradiance_harmonics_rgb: Harmonics,
}

/// Irradiance of a surface by its direction, as coefficients of the nine spherical harmonics up to the second degree: linear RGB of an EXR
/// file (W·m⁻², weighted by the observer), of the light of a whole sphere without the sun's disc.
///
/// The order is `Y_00, Y_1-1, Y_10, Y_11, Y_2-2, Y_2-1, Y_20, Y_21, Y_22`; x is north, y west and z up. Irradiance holds hardly any more than
/// these (Ramamoorthi and Hanrahan 2001, *An efficient representation for irradiance environment maps*, DOI 10.1145/383259.383317, Eq. 7 and 8).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Harmonics {
    /// The coefficients.
    pub coefficients: [[f64; 3]; 9],
}

impl Harmonics {
    /// From radiances in directions and their solid angles (sr).
    fn of(radiances: impl Iterator<Item = (DVec3, f64, DVec3)>) -> Self {
        /// What a cosine leaves of each harmonic's degree.
        const COSINE: [f64; 9] = {
            let (first, second) = (2.0 * PI / 3.0, PI / 4.0);
            [PI, first, first, first, second, second, second, second, second]
        };
        let mut sums = [DVec3::ZERO; 9];
        for (direction, solid_angle, radiance) in radiances {
            for (sum, harmonic) in sums.iter_mut().zip(harmonics(direction)) {
                *sum += radiance * (solid_angle * harmonic);
            }
        }
        Self { coefficients: std::array::from_fn(|i| (sums[i] * COSINE[i]).to_array()) }
    }

    /// The irradiance of a surface that faces a direction (a unit vector).
    pub fn towards(&self, normal: DVec3) -> [f64; 3] {
        let terms = self.coefficients.iter().zip(harmonics(normal));
        terms.map(|(&coefficient, harmonic)| DVec3::from_array(coefficient) * harmonic).sum::<DVec3>().to_array()
    }
}

/// The real spherical harmonics up to the second degree in a direction.
fn harmonics(DVec3 { x, y, z }: DVec3) -> [f64; 9] {
    let (zeroth, first, second) = (0.5 * (1.0 / PI).sqrt(), (0.75 / PI).sqrt(), 0.5 * (15.0 / PI).sqrt());
    [
        zeroth,
        first * y,
        first * z,
        first * x,
        second * x * y,
        second * y * z,
        0.25 * (5.0 / PI).sqrt() * (3.0 * z * z - 1.0),
        second * x * z,
        0.5 * second * (x * x - y * y),
    ]
}

impl SkyLight {
    /// That of a sky: the integral of the fit's radiance and of its RGB over the upper hemisphere, by Gauss-Legendre quadrature
    /// with nodes crowded around the sun.
    pub fn new(sky: &SkyPlan) -> Self {
        if sky.is_night {
            return Self::default();
        }
        let wavelengths = observer::wavelengths();
        let spectrum = FittedSpectrum::new(sky, &wavelengths);
        let radiance = |elevation: f64, azimuth: f64| {
            let view = direction(elevation, sky.integral.sun_azimuth + azimuth).as_vec3();
            (sky.radiance(view).as_dvec3(), power_and_luminance(sky, &wavelengths, &spectrum.radiance(view)))
        };
        let irradiance = |nodes: Vec<(f64, f64, f64)>| {
            let of_node = |(elevation, azimuth, weight)| {
                let (rgb, measures) = radiance(elevation, azimuth);
                (rgb * weight, measures * weight)
            };
            nodes.into_par_iter().map(of_node).reduce(Default::default, |a, b| (a.0 + b.0, a.1 + b.1))
        };
        let (rgb, measures) = irradiance(nodes(sky, ELEVATIONS, AZIMUTHS));
        let (ground_rgb, ground) = irradiance(nodes_below(sky, ELEVATIONS, AZIMUTHS));
        let sun = Sun::new(sky).irradiance();
        Self {
            irradiance_w_m2: measures.x,
            irradiance_rgb: rgb.to_array(),
            illuminance_lux: LUMENS_PER_WATT * measures.y,
            direct_irradiance_w_m2: sun.level,
            ground_irradiance_w_m2: ground.x,
            ground_irradiance_rgb: ground_rgb.to_array(),
            sun_irradiance_w_m2: sun.facing,
            sun_irradiance_rgb: sun.rgb.to_array(),
            luminance_zenith_cd_m2: LUMENS_PER_WATT * radiance(90.0, 0.0).1.y,
            irradiance_harmonics_rgb: harmonics_of(sky),
        }
    }
}

/// The irradiance that a sky throws on surfaces.
fn harmonics_of(sky: &SkyPlan) -> Harmonics {
    let mut nodes = nodes(sky, ELEVATIONS, AZIMUTHS);
    nodes.extend(nodes_below(sky, ELEVATIONS, AZIMUTHS));
    let both_sides = |(elevation, azimuth, weight): (f64, f64, f64)| {
        // Nodes have the cosine from the vertical in their weights, and stand for their mirror images.
        let solid_angle = 0.5 * weight / elevation.to_radians().sin().abs();
        [azimuth, -azimuth].map(|azimuth| {
            let view = direction(elevation, sky.integral.sun_azimuth + azimuth);
            (view, solid_angle, sky.radiance(view.as_vec3()).as_dvec3())
        })
    };
    let radiances: Vec<_> = nodes.into_par_iter().flat_map_iter(both_sides).collect();
    Harmonics::of(radiances.into_iter())
}

/// The radiance (W·m⁻²·sr⁻¹) and the luminance (the same, weighted by ȳ) of a spectrum at the observer's wavelengths, in `x` and `y`.
fn power_and_luminance(sky: &SkyPlan, wavelengths: &[f64], spectrum: &[f64]) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (&nm, radiance) in wavelengths.iter().zip(spectrum) {
        sum += DVec3::new(observer::width(nm), observer::weights(sky.observer, nm).y, 0.0) * radiance.max(0.0);
    }
    sum
}

/// Directions (degrees: elevation, azimuth from the sun) and weights (sr, times the cosine from the zenith) of the hemisphere.
fn nodes(sky: &SkyPlan, elevations: u32, azimuths: u32) -> Vec<(f64, f64, f64)> {
    let sun = f64::from(sky.integral.uniform.sun.z).asin().to_degrees().max(0.0);
    nodes_between(&[(sun, 0.0), (sun, 90.0)], elevations, azimuths)
}

/// The same of the hemisphere below, with the cosine from the nadir: crowded around the horizon.
fn nodes_below(sky: &SkyPlan, elevations: u32, azimuths: u32) -> Vec<(f64, f64, f64)> {
    let horizon = f64::from(sky.integral.uniform.horizon).to_degrees();
    nodes_between(&[(horizon, 0.0), (horizon, -90.0)], elevations, azimuths)
}

fn nodes_between(ranges: &[(f64, f64); 2], elevations: u32, azimuths: u32) -> Vec<(f64, f64, f64)> {
    let azimuths = crowded(azimuths, 0.0, 180.0);
    let row = |(elevation, weight): (f64, f64)| {
        let (sine, cosine) = elevation.to_radians().sin_cos();
        azimuths.iter().map(move |&(azimuth, across)| (elevation, azimuth, 2.0 * sine.abs() * cosine * weight * across))
    };
    // From the ground itself nothing lies between the horizon and the level.
    let ranges = ranges.iter().filter(|(from, to)| from != to);
    ranges.flat_map(|&(from, to)| crowded(elevations, from, to)).flat_map(row).collect()
}

/// Nodes (degrees) and weights (radians) of a rule that crowds towards `from` as a cube.
fn crowded(n: u32, from: f64, to: f64) -> Vec<(f64, f64)> {
    let node = |p: sorairo_shared::glam::Vec2| {
        let (u, weight) = (f64::from(p.x), f64::from(p.y));
        (from + (to - from) * u * u * u, 3.0 * u * u * weight * (to - from).abs() * PI / 180.0)
    };
    gauss_legendre(n).into_iter().map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Preset;
    use crate::scene::{GroundAlbedo, Orders, Rgb, Scene};

    fn sky(sun: f64, change: impl FnOnce(&mut Scene)) -> SkyPlan {
        let mut scene = Scene::preset(Preset::Earth).first_order();
        scene.sun.elevation = sun;
        change(&mut scene);
        SkyPlan::new(&scene.validated().unwrap(), Rgb::Srgb)
    }

    #[test]
    fn the_hemisphere_has_a_projected_solid_angle_of_pi() {
        for sun in [-4.0, 0.0, 37.0, 90.0] {
            let sum: f64 = nodes(&sky(sun, |_| {}), ELEVATIONS, AZIMUTHS).iter().map(|node| node.2).sum();
            // The nodes are rounded to single precision.
            assert!((sum / PI - 1.0).abs() < 1e-6, "{sun}: {sum}");
        }
    }

    #[test]
    fn irradiance_is_the_sum_over_a_fine_grid() {
        for (sun, asymmetry, optical_depth) in
            [(-4.0, 0.8, 0.005), (5.0, 0.8, 0.3), (30.0, 0.95, 0.3), (90.0, 0.9, 0.1)]
        {
            let sky = sky(sun, |scene| {
                scene.atmosphere.aerosol.asymmetry = asymmetry;
                scene.atmosphere.aerosol.optical_depth = optical_depth;
            });
            let light = SkyLight::new(&sky);
            let fine: DVec3 = nodes(&sky, 8 * ELEVATIONS, 8 * AZIMUTHS)
                .into_par_iter()
                .map(|(elevation, azimuth, weight)| {
                    sky.radiance(direction(elevation, sky.integral.sun_azimuth + azimuth).as_vec3()).as_dvec3() * weight
                })
                .sum();
            let error = (DVec3::from_array(light.irradiance_rgb) / fine - 1.0).abs().max_element();
            println!("sun at {sun}: {error:.1e}");
            // A tenth of the one per cent to which renderers agree on it.
            assert!(error <= 1e-3, "sun at {sun}: {error:e}");
        }
    }

    #[test]
    fn illuminance_is_the_luminance_of_the_rgb() {
        let sky = sky(30.0, |_| {});
        let light = SkyLight::new(&sky);
        let luminance = LUMENS_PER_WATT * sky.space.luminance.dot(DVec3::from_array(light.irradiance_rgb));
        // The observer nodes of the fit stand for 81; a luminance of Rec. 709 is rounded to four digits.
        assert!((light.illuminance_lux / luminance - 1.0).abs() < 1e-3, "{} {luminance}", light.illuminance_lux);
        // A sky without its sun: some ten thousand lux by day (single scattering gives the larger part of it).
        assert!((2e3..2e4).contains(&light.illuminance_lux), "{light:?}");
        assert!((500.0..1e4).contains(&light.luminance_zenith_cd_m2), "{light:?}");
        assert!((10.0..200.0).contains(&light.irradiance_w_m2), "{light:?}");
    }

    #[test]
    fn the_ground_sends_back_its_albedo_of_what_falls_on_it() {
        for sun in [40.0, 8.0] {
            let sky = sky(sun, |scene| {
                scene.ground.albedo = GroundAlbedo::Grey(0.3);
                scene.render.orders = Orders::All;
            });
            let SkyLight { irradiance_w_m2, direct_irradiance_w_m2, ground_irradiance_w_m2, .. } = SkyLight::new(&sky);
            let expected = 0.3 * (irradiance_w_m2 + direct_irradiance_w_m2);
            println!("sun at {sun}: {ground_irradiance_w_m2} of {expected}");
            // The ground is lit by moments of the light field and by a point, and the observer by nodes of the sky and by a disc.
            assert!((ground_irradiance_w_m2 / expected - 1.0).abs() < 2e-3, "sun at {sun}");
            assert!(
                (direct_irradiance_w_m2 / SkyLight::new(&sky).sun_irradiance_w_m2 - sun.to_radians().sin()).abs()
                    < 1e-3
            );
        }
        assert_eq!(SkyLight::new(&sky(40.0, |_| {})).ground_irradiance_w_m2, 0.0);
    }

    #[test]
    fn harmonics_hold_the_irradiance_of_surfaces_that_face_any_way() {
        let sky = sky(35.0, |scene| {
            scene.ground.albedo = GroundAlbedo::Grey(0.3);
            scene.render.orders = Orders::All;
        });
        let light = SkyLight::new(&sky);
        let brightest = light.irradiance_rgb[1].max(light.ground_irradiance_rgb[1]);
        // Nine harmonics leave some hundredths of the largest irradiance, where light has an edge at the horizon and a glow around the sun.
        let is_near = |found: [f64; 3], expected: f64| (found[1] - expected).abs() < 0.03 * brightest;
        let up = light.irradiance_harmonics_rgb.towards(DVec3::Z);
        let down = light.irradiance_harmonics_rgb.towards(-DVec3::Z);
        assert!(is_near(up, light.irradiance_rgb[1]), "{up:?} {light:?}");
        assert!(is_near(down, light.ground_irradiance_rgb[1]), "{down:?} {light:?}");
        // A wall that faces the sun, and one that turns its back.
        for azimuth in [0.0, 180.0] {
            let normal = direction(0.0, sky.integral.sun_azimuth + azimuth);
            let mut nodes = nodes(&sky, ELEVATIONS, AZIMUTHS);
            nodes.extend(nodes_below(&sky, ELEVATIONS, AZIMUTHS));
            let fallen = |(elevation, azimuth, weight): (f64, f64, f64)| {
                let view = direction(elevation, sky.integral.sun_azimuth + azimuth);
                let green = f64::from(sky.radiance(view.as_vec3()).y);
                green * weight / elevation.to_radians().sin().abs() * view.dot(normal).max(0.0)
            };
            let expected: f64 = nodes.into_iter().map(fallen).sum();
            let found = light.irradiance_harmonics_rgb.towards(normal);
            assert!(is_near(found, expected), "{azimuth}: {found:?}, {expected}");
        }
    }

    #[test]
    fn light_that_is_the_same_from_everywhere_falls_alike_on_every_surface() {
        let sky = sky(30.0, |_| {});
        let mut nodes = nodes(&sky, ELEVATIONS, AZIMUTHS);
        nodes.extend(nodes_below(&sky, ELEVATIONS, AZIMUTHS));
        let radiances = nodes.into_iter().flat_map(|(elevation, azimuth, weight)| {
            let solid_angle = 0.5 * weight / elevation.to_radians().sin().abs();
            [azimuth, -azimuth].map(|azimuth| (direction(elevation, azimuth), solid_angle, DVec3::ONE))
        });
        let harmonics = Harmonics::of(radiances);
        for normal in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z, DVec3::new(0.6, 0.0, -0.8), DVec3::new(0.48, 0.6, 0.64)]
        {
            let [red, ..] = harmonics.towards(normal);
            // Nodes are rounded to single precision.
            assert!((red / PI - 1.0).abs() < 1e-5, "{normal}: {red}");
        }
    }

    #[test]
    fn a_night_throws_no_light() {
        assert_eq!(SkyLight::new(&sky(-30.0, |_| {})).illuminance_lux, 0.0);
    }
}
