//! The downwelling irradiance of the sky, and the irradiance of its sun.

use std::f64::consts::PI;

use rayon::prelude::*;
use serde::Serialize;
use sorairo_shared::glam::{DVec3, Vec3};
use sorairo_shared::light_field::moments::{Moments, legendre};

use crate::plan::hemisphere::{Node, nodes, nodes_below};
use crate::plan::picture::sun_disc::Sun;
use crate::plan::{Sky, SkyPlan, SpectralPlan};
use crate::spectra::observer;

pub use crate::spectra::observer::LUMENS_PER_WATT;

/// Irradiance of a level surface at the observer by the sky, the sun and the ground, and the luminance of the zenith.
///
/// With the flat sun, whose irradiance is 1 at every wavelength, all values are relative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SkyLight {
    /// Diffuse irradiance, from the sky without the sun, between 380 and 780 nm (W·m⁻²).
    pub irradiance_w_m2: f64,
    /// Integral of the linear RGB of an EXR file times the cosine over the upper hemisphere (W·m⁻², weighted by the
    /// observer).
    pub irradiance_rgb: [f64; 3],
    /// Illuminance (lx): the irradiance weighted by the observer's ȳ, times [`LUMENS_PER_WATT`].
    pub illuminance_lux: f64,
    /// Direct irradiance, from the sun, on the same level surface between 380 and 780 nm (W·m⁻²).
    pub direct_irradiance_w_m2: f64,
    /// Irradiance of a level surface that faces down, by the ground and the air in front of it, between 380 and 780 nm
    /// (W·m⁻²).
    pub ground_irradiance_w_m2: f64,
    /// The same as linear RGB of an EXR file (W·m⁻², weighted by the observer).
    pub ground_irradiance_rgb: [f64; 3],
    /// Irradiance of a surface that faces the sun by the attenuated sun, between 380 and 780 nm (W·m⁻²).
    pub sun_irradiance_w_m2: f64,
    /// The same as linear RGB of an EXR file (W·m⁻², weighted by the observer).
    pub sun_irradiance_rgb: [f64; 3],
    /// Luminance of the zenith (cd·m⁻²).
    pub luminance_zenith_cd_m2: f64,
    /// Irradiance of a surface of any orientation by the sky and the ground, without the sun.
    pub irradiance_harmonics_rgb: Harmonics,
}

/// Irradiance of a surface by its orientation, as coefficients of the nine spherical harmonics up to degree 2. Values
/// are linear RGB of an EXR file (W·m⁻², weighted by the observer), from the whole sphere without the sun's disc.
///
/// The order is `Y_00, Y_1-1, Y_10, Y_11, Y_2-2, Y_2-1, Y_20, Y_21, Y_22`; x is north, y west and z up. Higher degrees
/// contribute little to irradiance (Ramamoorthi and Hanrahan 2001, *An efficient representation for irradiance
/// environment maps*, DOI 10.1145/383259.383317, Eq. 7 and 8).
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

/// The harmonics up to the second degree.
const SECOND_DEGREE: Moments = Moments { degree: 2, azimuthal: 2 };

/// The real spherical harmonics up to the second degree in a direction; see [`sorairo_shared::light_field::moments`].
fn harmonics(DVec3 { x, y, z }: DVec3) -> [f64; 9] {
    let level = x.hypot(y);
    let mut functions = [0.0; 6];
    legendre(SECOND_DEGREE, z as f32, level as f32, &mut functions, 0);
    let [zeroth, first_0, second_0, first_1, second_1, second_2] = functions.map(f64::from);
    let (cosine, sine) = if level > 0.0 { (x / level, y / level) } else { (1.0, 0.0) };
    let (cosine_2, sine_2) = (cosine * cosine - sine * sine, 2.0 * sine * cosine);
    [
        zeroth,
        first_1 * sine,
        first_0,
        first_1 * cosine,
        second_2 * sine_2,
        second_1 * sine,
        second_0,
        second_1 * cosine,
        second_2 * cosine_2,
    ]
}

impl Sky {
    /// Irradiance of level surfaces by the sky, the sun and the ground, summed over visible light.
    pub fn light(&self) -> SkyLight {
        SkyLight::new(self.plan())
    }
}

impl SkyLight {
    /// That of a sky: the integral of its fitted spectrum and of its RGB over the upper hemisphere, by Gauss-Legendre
    /// quadrature with nodes denser around the sun.
    pub(crate) fn new(sky: &SkyPlan) -> Self {
        if sky.is_night {
            return Self::default();
        }
        let wavelengths = observer::wavelengths();
        let spectrum = SpectralPlan::over_steps(sky);
        let measured = |view: DVec3| power_and_luminance(sky, &wavelengths, &spectrum.radiance(view.as_vec3()));
        let irradiance = |nodes: Vec<Node>| -> DVec3 {
            let of_node = |node: Node| measured(node.direction(sky)) * node.level();
            nodes.into_par_iter().map(of_node).collect::<Vec<_>>().into_iter().sum()
        };
        let (measures, ground) = (irradiance(nodes(sky, 1)), irradiance(nodes_below(sky)));
        let ([rgb, ground_rgb], harmonics) = rgb_of_sky(sky, SkyPlan::radiances_here);
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
            luminance_zenith_cd_m2: LUMENS_PER_WATT * measured(DVec3::Z).y,
            irradiance_harmonics_rgb: harmonics,
        }
    }
}

/// The linear RGB of [`SkyLight`], by radiances in many directions: irradiance of level surfaces that face up and down,
/// and of one with any orientation.
pub(crate) fn rgb_of_sky(sky: &SkyPlan, radiances: impl Fn(&SkyPlan, &[Vec3]) -> Vec<Vec3>) -> ([DVec3; 2], Harmonics) {
    if sky.is_night {
        return Default::default();
    }
    let (above, below) = (nodes(sky, 1), nodes_below(sky));
    let all: Vec<Node> = above.iter().chain(&below).copied().collect();
    let views: Vec<Vec3> = all.iter().map(|node| node.direction(sky).as_vec3()).collect();
    let radiances: Vec<DVec3> = radiances(sky, &views).into_iter().map(Vec3::as_dvec3).collect();
    let irradiance = |nodes: &[Node], of: &[DVec3]| nodes.iter().zip(of).map(|(node, &rgb)| rgb * node.level()).sum();
    let (of_above, of_below) = radiances.split_at(above.len());
    let level = [irradiance(&above, of_above), irradiance(&below, of_below)];
    let both_sides = all.iter().zip(&radiances).flat_map(|(node, &rgb)| {
        [*node, node.mirrored()].map(|node| (node.direction(sky), 0.5 * node.solid_angle, rgb))
    });
    (level, Harmonics::of(both_sides))
}

/// The radiance (W·m⁻²·sr⁻¹) and the luminance (the same, weighted by ȳ) of a spectrum at the observer's wavelengths,
/// in `x` and `y`.
fn power_and_luminance(sky: &SkyPlan, wavelengths: &[f64], spectrum: &[f64]) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (&nm, radiance) in wavelengths.iter().zip(spectrum) {
        sum += DVec3::new(observer::width(nm), observer::weights(sky.observer, nm).y, 0.0) * radiance.max(0.0);
    }
    sum
}

/// A direction, its mirror image by the vertical plane through the sun, where the sky is the same, and the solid angle
/// of both (sr).
pub(crate) type Pair = (DVec3, DVec3, f64);

/// The directions above and below the horizontal plane in which [`SkyLight`] takes the light.
pub(crate) fn pairs(sky: &SkyPlan) -> [Vec<Pair>; 2] {
    let pair = |node: Node| (node.direction(sky), node.mirrored().direction(sky), node.solid_angle);
    [nodes(sky, 1), nodes_below(sky)].map(|nodes| nodes.into_iter().map(pair).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Fit, GroundAlbedo, Orders, Preset, Scene, SunSpectrum};
    use crate::spectra::table::Table;
    use crate::spectra::table_file::TableFile;

    fn sky(sun: f64, change: impl FnOnce(&mut Scene)) -> Sky {
        let mut scene = Scene::preset(Preset::Earth).first_order();
        scene.sun.elevation = sun;
        change(&mut scene);
        Sky::new(&scene).unwrap()
    }

    #[test]
    fn the_hemisphere_has_a_projected_solid_angle_of_pi() {
        for sun in [-4.0, 0.0, 37.0, 90.0] {
            let sum: f64 = nodes(sky(sun, |_| {}).plan(), 1).iter().map(|node| node.level()).sum();
            // The nodes are rounded to single precision.
            assert!((sum / PI - 1.0).abs() < 1e-6, "{sun}: {sum}");
        }
    }

    #[test]
    fn what_falls_from_the_sky_fades_with_its_colour_through_deep_twilight() {
        let mut before: Option<SkyLight> = None;
        for step in 0..14 {
            let sun = -12.0 - 0.5 * f64::from(step);
            let mut scene = Scene::preset(Preset::Standard);
            scene.sun.elevation = sun;
            let sky = Sky::new(&scene).unwrap();
            let light = sky.light();
            let luminance = sky.plan().base.uniform.rgb.luminance(DVec3::from_array(light.irradiance_rgb).as_vec3());
            let by_colour = LUMENS_PER_WATT * f64::from(luminance) / light.illuminance_lux;
            println!("sun at {sun}: {:.2e} W/m², {by_colour:.3}", light.irradiance_w_m2);
            // Two ways through the fit: the nodes of colour and the sum over wavelengths. What they learn from at -18°
            // is a thousandth of a millionth of the day's light, beyond what cubics between the nodes of a light field
            // resolve: they differ by 1.4 % to -15°, 10 % to -17° and 18 % at -18°.
            let bound = if sun >= -15.0 {
                0.02
            } else if sun >= -17.0 {
                0.12
            } else {
                0.2
            };
            assert!((by_colour - 1.0).abs() < bound, "sun at {sun}: {by_colour}");
            if let Some(before) = before {
                let faded = light.irradiance_w_m2 / before.irradiance_w_m2;
                // Half a degree takes a third of the light or more; it was 300 times as much once.
                assert!(faded < 1.0 && faded > 0.3, "sun at {sun}: {faded}");
            }
            before = Some(light);
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
            let light = sky.light();
            let fine: DVec3 = nodes(sky.plan(), 8)
                .into_par_iter()
                .map(|node| sky.plan().rgb_towards(node.direction(sky.plan()).as_vec3()).as_dvec3() * node.level())
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
        let light = sky.light();
        let luminance = LUMENS_PER_WATT * sky.plan().space.luminance.dot(DVec3::from_array(light.irradiance_rgb));
        // The observer nodes of the fit stand for 81; a luminance of Rec. 709 is rounded to four digits.
        assert!((light.illuminance_lux / luminance - 1.0).abs() < 1e-3, "{} {luminance}", light.illuminance_lux);
        // A sky without its sun: some ten thousand lux by day (single scattering gives the larger part of it).
        assert!((2e3..2e4).contains(&light.illuminance_lux), "{light:?}");
        assert!((500.0..1e4).contains(&light.luminance_zenith_cd_m2), "{light:?}");
        assert!((10.0..200.0).contains(&light.irradiance_w_m2), "{light:?}");
    }

    /// A table of a nanometre a row that has all of it in every fifth, shifted by some.
    fn lines(shift: u32, height: f64) -> TableFile {
        let value = |nm: u32| if (nm + shift).is_multiple_of(5) { height } else { 0.0 };
        TableFile::holding("lines.csv", Table::of((360..=830).map(|nm| (f64::from(nm), [value(nm)]))))
    }

    /// What sums over the observer's nodes say of a sky.
    fn sums(sky: &Sky) -> Vec<f64> {
        let light = sky.light();
        let rgb = [light.irradiance_rgb, light.ground_irradiance_rgb, light.sun_irradiance_rgb].concat();
        let surface = sky.illuminance(&[crate::Surface::default()]).unwrap()[0];
        let measured = [light.irradiance_w_m2, light.sun_irradiance_w_m2, light.illuminance_lux, surface.global];
        let zenith = sky.xyz(&[crate::Direction::new(90.0, 0.0)]).unwrap().concat();
        [&rgb[..], &measured, &zenith, &[light.luminance_zenith_cd_m2]].concat()
    }

    fn assert_alike(found: &[f64], expected: &[f64], what: &str) {
        let errors = found.iter().zip(expected).map(|(found, expected)| (found / expected - 1.0).abs());
        let worst = errors.fold(0.0, |worst: f64, error| if error <= worst { worst } else { error });
        println!("{what}: {worst:.1e}");
        // What a fit that learnt from other numbers in the last digit leaves.
        assert!(found.len() == expected.len() && worst < 1e-3, "{what}: {worst}");
    }

    #[test]
    fn spectral_lines_give_sums_the_light_of_their_mean_wherever_they_lie() {
        for fit in [Fit::Regression, Fit::Dense, Fit::Transfer] {
            let of = |spectrum: SunSpectrum, albedo: GroundAlbedo| {
                sums(&sky(30.0, |scene| {
                    (scene.sun.spectrum, scene.ground.albedo, scene.render.fit) =
                        (spectrum.clone(), albedo.clone(), fit);
                    scene.render.orders = Orders::UpTo(2);
                }))
            };
            let grey = of(SunSpectrum::Flat, GroundAlbedo::Grey(0.2));
            for shift in [0, 1, 2] {
                let sun = of(SunSpectrum::File(lines(shift, 5.0)), GroundAlbedo::Grey(0.2));
                assert_alike(&sun, &grey, &format!("{fit:?}, sun, {shift} nm"));
                let ground = of(SunSpectrum::Flat, GroundAlbedo::File(lines(shift, 1.0)));
                assert_alike(&ground, &grey, &format!("{fit:?}, ground, {shift} nm"));
            }
        }
    }

    #[test]
    fn ground_that_reflects_where_the_sun_shines_is_as_bright_as_both_say() {
        let of = |spectrum: SunSpectrum, albedo: GroundAlbedo| {
            let sky = sky(30.0, |scene| (scene.sun.spectrum, scene.ground.albedo) = (spectrum.clone(), albedo.clone()));
            sky.light().ground_irradiance_rgb[1]
        };
        let (sun, white) = (SunSpectrum::File(lines(0, 5.0)), of(SunSpectrum::Flat, GroundAlbedo::Grey(0.9)));
        let [air, with, beside] = [
            of(SunSpectrum::Flat, GroundAlbedo::Grey(0.0)),
            of(sun.clone(), GroundAlbedo::File(lines(0, 0.9))),
            of(sun, GroundAlbedo::File(lines(2, 0.9))),
        ];
        // Of lines that are triangles two thirds of the product are left of what is lit; beside them nothing reflects.
        assert!(((with - air) / (white - air) - 2.0 / 3.0).abs() < 0.01, "{with} of {white}");
        assert!((beside - air).abs() < 1e-3 * white, "{beside}, not {air}");
    }

    #[test]
    fn a_spectrum_says_what_a_table_holds_at_its_wavelengths() {
        let sun = sky(30.0, |scene| scene.sun.spectrum = SunSpectrum::File(lines(0, 5.0)));
        let flat = sky(30.0, |scene| scene.sun.spectrum = SunSpectrum::Flat);
        let at = |sky: &SkyPlan| SpectralPlan::new(sky, &[500.0, 502.0]).radiance(DVec3::Z.as_vec3());
        let (lines, flat) = (at(sun.plan()), at(flat.plan()));
        assert!((lines[0] / flat[0] - 5.0).abs() < 1e-6 && lines[1] == 0.0, "{lines:?}, {flat:?}");
    }

    #[test]
    fn a_band_has_the_light_of_its_lines_wherever_they_lie() {
        let bands: Vec<f64> = (0..20).map(|i| 390.0 + 20.0 * f64::from(i)).collect();
        let of = |spectrum: SunSpectrum, albedo: GroundAlbedo| {
            let sky = sky(30.0, |scene| (scene.sun.spectrum, scene.ground.albedo) = (spectrum.clone(), albedo.clone()));
            let sun = Sun::over_bands(sky.plan(), &bands, 20.0).spectral_irradiance(|_| 1.0);
            let plan = SpectralPlan::over_bands(sky.plan(), &bands, 20.0);
            let [up, down] = [1.0, -1.0].map(|z| plan.radiance(DVec3::new(0.1, 0.0, z).normalize().as_vec3()));
            [sun, up, down].concat()
        };
        let grey = of(SunSpectrum::Flat, GroundAlbedo::Grey(0.2));
        for shift in [0, 1, 2] {
            let sun = of(SunSpectrum::File(lines(shift, 5.0)), GroundAlbedo::Grey(0.2));
            // A band ends in the middle of a line.
            assert_alike(&sun, &grey, &format!("sun, {shift} nm"));
            let ground = of(SunSpectrum::Flat, GroundAlbedo::File(lines(shift, 1.0)));
            assert_alike(&ground, &grey, &format!("ground, {shift} nm"));
        }
    }

    #[test]
    fn the_ground_sends_back_its_albedo_of_what_falls_on_it() {
        for sun in [40.0, 8.0] {
            let sky = sky(sun, |scene| {
                scene.ground.albedo = GroundAlbedo::Grey(0.3);
                scene.render.orders = Orders::All;
            });
            let SkyLight { irradiance_w_m2, direct_irradiance_w_m2, ground_irradiance_w_m2, .. } = sky.light();
            let expected = 0.3 * (irradiance_w_m2 + direct_irradiance_w_m2);
            println!("sun at {sun}: {ground_irradiance_w_m2} of {expected}");
            // The ground is lit by moments of the light field and by a point, and the observer by nodes of the sky and
            // by a disc.
            assert!((ground_irradiance_w_m2 / expected - 1.0).abs() < 2e-3, "sun at {sun}");
            assert!((direct_irradiance_w_m2 / sky.light().sun_irradiance_w_m2 - sun.to_radians().sin()).abs() < 1e-3);
        }
        assert_eq!(sky(40.0, |_| {}).light().ground_irradiance_w_m2, 0.0);
    }

    #[test]
    fn harmonics_hold_the_irradiance_of_surfaces_that_face_any_way() {
        let sky = sky(35.0, |scene| {
            scene.ground.albedo = GroundAlbedo::Grey(0.3);
            scene.render.orders = Orders::All;
        });
        let light = sky.light();
        let brightest = light.irradiance_rgb[1].max(light.ground_irradiance_rgb[1]);
        // Nine harmonics leave some hundredths of the largest irradiance, where light has an edge at the horizon and a
        // glow around the sun.
        let is_near = |found: [f64; 3], expected: f64| (found[1] - expected).abs() < 0.03 * brightest;
        let up = light.irradiance_harmonics_rgb.towards(DVec3::Z);
        let down = light.irradiance_harmonics_rgb.towards(-DVec3::Z);
        assert!(is_near(up, light.irradiance_rgb[1]), "{up:?} {light:?}");
        assert!(is_near(down, light.ground_irradiance_rgb[1]), "{down:?} {light:?}");
        // A wall that faces the sun, and one that turns its back.
        for azimuth in [0.0, 180.0] {
            let normal = crate::plan::direction(0.0, sky.plan().base.source.azimuth + azimuth);
            let mut nodes = nodes(sky.plan(), 1);
            nodes.extend(nodes_below(sky.plan()));
            let fallen = |node: Node| {
                let view = node.direction(sky.plan());
                f64::from(sky.plan().rgb_towards(view.as_vec3()).y) * node.solid_angle * view.dot(normal).max(0.0)
            };
            let expected: f64 = nodes.into_iter().map(fallen).sum();
            let found = light.irradiance_harmonics_rgb.towards(normal);
            assert!(is_near(found, expected), "{azimuth}: {found:?}, {expected}");
        }
    }

    #[test]
    fn light_that_is_the_same_from_everywhere_falls_alike_on_every_surface() {
        let sky = sky(30.0, |_| {});
        let mut nodes = nodes(sky.plan(), 1);
        nodes.extend(nodes_below(sky.plan()));
        let radiances = nodes.into_iter().flat_map(|node| {
            [node, node.mirrored()].map(|node| (node.direction(sky.plan()), 0.5 * node.solid_angle, DVec3::ONE))
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
        assert_eq!(sky(-30.0, |_| {}).light().illuminance_lux, 0.0);
    }
}
