//! The light of a sky from 280 to 2500 nm, through the lines of its gases.
//!
//! Where lines absorb, no wavelength has one coefficient. But of the light that an observer sees from a direction some
//! part has crossed each amount `u` of an absorber, whatever its orders of scattering; if that part is `P(u)` at a
//! wavelength, light that is absorbed by a strength `k` is
//!
//! ```text
//! L(k) = ∫ P(u) exp(-k u) du,
//! ```
//!
//! which is linear in `exp(-k u)`. So the transmittance of a bin of wavelengths, in which lines have many strengths, is
//! written as a sum of exponentials of fixed strengths, `T(u) = Σ_j W_j exp(-K_j u)`, by least squares over the amounts
//! that light crosses; and the light of the bin is `Σ_j W_j L(K_j)` of the sky's light at those strengths. They are
//! eight for what lies as water vapour does and eight for what lies as dry air does, one of which is nothing. What both
//! leave is the product of what each leaves.
//!
//! Without lines light is smooth over the wavelength and is computed at [`Shortwave::smooth_wavelengths`]; what a
//! strength leaves of it is smoother still and is computed at [`OF_STRENGTHS`].

use std::sync::OnceLock;

use nalgebra::{SMatrix, SVector};
use sorairo_shared::glam::{Vec3, Vec4};
use sorairo_shared::medium::bands::Bands;

use crate::medium::gases::{CLASSES, DRY, OXYGEN_SQUARED, SELF, SkyGases, WET, parts_above};
use crate::plan::integral::RayIntegral;
use crate::plan::sky::{SkyPlan, optics_of};
use crate::scene::Scene;
use crate::spectra::optics::Optics;
use crate::spectra::range::RANGE_OF_BEAMS;

/// Strengths beside none: optical depths of the vertical column above the observer.
const STRENGTHS: [f64; 7] = [0.0107, 0.0322, 0.0972, 0.293, 0.882, 2.66, 8.0];

/// Wavelengths (nm) at which light is computed at every strength.
const OF_STRENGTHS: [f64; 9] = [560.0, 690.0, 762.0, 830.0, 940.0, 1130.0, 1380.0, 1880.0, 2500.0];

/// Below this wavelength (nm) no lines absorb.
const FIRST_LINE: f64 = 558.0;

/// What gases do are values of bins so wide (nm), of which longer means are made.
const LONGEST_PART: f64 = 1.0;

/// The least part of a gas above the observer for which strengths are made.
const LEAST_PART: f64 = 0.1;

/// The light of a sky at wavelengths from 280 to 2500 nm.
pub struct Shortwave {
    /// At the smooth wavelengths, without lines.
    smooth: RayIntegral,
    /// Of each wavelength of a sum the solar irradiance (W·m⁻²·nm⁻¹), the smooth wavelength below, and how far it is to
    /// the next.
    points: Vec<(f64, (usize, f64))>,
    lines: Lines,
    /// How many points are one wavelength.
    parts: usize,
}

/// The weights of strengths of water and of dry air in a bin, and where it lies among the wavelengths at which light is
/// computed at each.
type OfLines = ([[f64; STRENGTHS.len()]; 2], (usize, f64));

/// What lines leave of a sky's light at some wavelengths.
pub struct Lines {
    /// At the strengths; none where no lines absorb.
    integral: Option<RayIntegral>,
    strengths: Strengths,
}

/// Of which light at fixed strengths that of some wavelengths is made.
pub(crate) struct Strengths {
    /// At those of [`OF_STRENGTHS`] that the wavelengths need, each without lines, with those of water and with those
    /// of dry air; none where no lines absorb.
    at: Vec<AtStrengths>,
    /// At each wavelength; none where no lines absorb.
    points: Vec<Option<OfLines>>,
}

impl Lines {
    /// Of a sky at wavelengths (nm); none in air without gases.
    pub fn new(sky: &SkyPlan, wavelengths: &[f64]) -> Option<Self> {
        Self::by(sky, wavelengths, RayIntegral::with_spectral_light)
    }

    /// The same, light of higher orders by a light field of some resolution.
    fn by(sky: &SkyPlan, wavelengths: &[f64], lit: fn(RayIntegral) -> RayIntegral) -> Option<Self> {
        let optics = optics_of(&sky.scene);
        let strengths = Strengths::new(&sky.scene, &optics, wavelengths)?;
        let integral = (!strengths.at.is_empty()).then(|| lit(integral(&sky.base, &optics, &strengths.at)));
        Some(Self { integral, strengths })
    }

    /// The part of light that they leave in a direction at each wavelength.
    pub fn left(&self, view: Vec3) -> Vec<f64> {
        self.strengths.left(&self.integral.as_ref().map_or_else(Vec::new, |integral| integral.transfer(view)))
    }
}

/// Whether lines of gases absorb light of some wavelengths (nm).
pub(crate) fn has_lines(optics: &Optics, wavelengths: &[f64]) -> bool {
    optics.gases.is_some() && wavelengths.iter().any(|&nm| nm >= FIRST_LINE)
}

impl Strengths {
    /// Those of a scene's sky at wavelengths (nm), in means over what they stand for in its optics; none in air without
    /// gases.
    pub(crate) fn new(scene: &Scene, optics: &Optics, wavelengths: &[f64]) -> Option<Self> {
        let gases = optics.gases.as_ref()?;
        let lanes = lanes(scene);
        let absorbed = || wavelengths.iter().filter(|&&nm| nm >= FIRST_LINE);
        let (first, last) = absorbed().fold((f64::INFINITY, 0.0f64), |(low, high), &nm| (low.min(nm), high.max(nm)));
        let low = OF_STRENGTHS.partition_point(|&nm| nm <= first).clamp(1, OF_STRENGTHS.len() - 1) - 1;
        let high = OF_STRENGTHS.partition_point(|&nm| nm < last).clamp(low + 1, OF_STRENGTHS.len() - 1);
        let nodes = &OF_STRENGTHS[low..=high];
        let point = |&nm: &f64| (nm >= FIRST_LINE).then(|| (weights(gases, lanes, nm), place(nodes, nm)));
        let all = nodes.iter().flat_map(|&nm| at_strengths(nm, lanes)).collect();
        let at = if absorbed().next().is_some() { all } else { Vec::new() };
        Some(Self { at, points: wavelengths.iter().map(point).collect() })
    }

    /// The integral at the strengths, of a sky of these optics; without light that was scattered more than once.
    pub(crate) fn integral(&self, sky: &RayIntegral) -> RayIntegral {
        integral(sky, &sky.optics, &self.at)
    }

    /// The part of light that lines leave at each wavelength, by light at the strengths.
    pub(crate) fn left(&self, light: &[f64]) -> Vec<f64> {
        let nodes: Vec<Vec<f64>> = light
            .chunks_exact(1 + 2 * STRENGTHS.len())
            .map(|at| at[1..].iter().map(|light| if at[0] > 0.0 { light / at[0] } else { 0.0 }).collect())
            .collect();
        let of_point = |(weights, (below, part)): &OfLines| -> f64 {
            let (low, high) = (&nodes[*below], &nodes[below + 1]);
            let of_class = |class: usize| {
                // The weights of all strengths, none included, sum to 1.
                let of = |(j, weight): (usize, &f64)| {
                    let at = class * STRENGTHS.len() + j;
                    weight * (low[at] + part * (high[at] - low[at]) - 1.0)
                };
                (1.0 + weights[class].iter().enumerate().map(of).sum::<f64>()).clamp(0.0, 1.0)
            };
            of_class(0) * of_class(1)
        };
        self.points.iter().map(|point| point.as_ref().map_or(1.0, of_point)).collect()
    }
}

impl Shortwave {
    /// That of a sky at wavelengths (nm), in means over a resolution (nm) about each or in the gases' bins about it.
    /// None in air without gases.
    pub fn new(sky: &SkyPlan, wavelengths: &[f64], resolution: Option<f64>) -> Option<Self> {
        Self::with_steps(sky, wavelengths, resolution, 1.0, RayIntegral::with_spectral_light)
    }

    /// The same for sums over all wavelengths, by half as many at which light is computed, and that as for colours.
    pub fn for_sums(sky: &SkyPlan, wavelengths: &[f64]) -> Option<Self> {
        Self::with_steps(sky, wavelengths, None, 2.0, RayIntegral::with_multiple_light)
    }

    fn with_steps(
        sky: &SkyPlan,
        wavelengths: &[f64],
        resolution: Option<f64>,
        steps: f64,
        lit: fn(RayIntegral) -> RayIntegral,
    ) -> Option<Self> {
        let optics = optics_of(&sky.scene);
        let parts = resolution.map_or(1, |width| (width / LONGEST_PART).ceil().max(1.0) as usize);
        let width = resolution.unwrap_or(0.0);
        let part = |nm: f64, i: usize| nm + width * ((i as f64 + 0.5) / parts as f64 - 0.5);
        let finely: Vec<f64> = wavelengths.iter().flat_map(|&nm| (0..parts).map(move |i| part(nm, i))).collect();
        let ends = finely.iter().fold((f64::INFINITY, 0.0f64), |(low, high), &nm| (low.min(nm), high.max(nm)));
        let smooth = Self::smooth_wavelengths(ends, steps);
        let lines = Lines::by(sky, &finely, lit)?;
        let points = finely.iter().map(|&nm| (optics.solar_irradiance(nm), place(&smooth, nm))).collect();
        let without: Vec<AtStrengths> = smooth.iter().map(|&nm| (nm, [0.0; 2])).collect();
        Some(Self { smooth: lit(integral(&sky.base, &optics, &without)), points, lines, parts })
    }

    /// The wavelengths (nm) at which light without lines is integrated.
    pub fn bands(&self) -> &[f64] {
        &self.smooth.wavelengths
    }

    /// The wavelengths (nm) at which light without lines is computed between two: close where ozone's bands are narrow.
    fn smooth_wavelengths((first, last): (f64, f64), coarser: f64) -> Vec<f64> {
        // Ozone is known in the middles of nanometres.
        let steps = [(280.5, 360.5, 1.0), (365.0, 560.0, 5.0), (560.0, 1000.0, 10.0), (1000.0, 2500.0, 50.0)];
        let of = |(from, to, step): (f64, f64, f64)| {
            let step = coarser * step;
            (0..((to - from) / step).round() as u32).map(move |i| from + step * f64::from(i))
        };
        let (shortest, longest) = RANGE_OF_BEAMS;
        let all: Vec<f64> = [shortest].into_iter().chain(steps.into_iter().flat_map(of)).chain([longest]).collect();
        let low = all.partition_point(|&nm| nm <= first).saturating_sub(1);
        let high = all.partition_point(|&nm| nm < last).max(low + 1).min(all.len() - 1);
        all[low.min(high - 1)..=high].to_vec()
    }

    /// Radiance at each wavelength in a direction (W·m⁻²·sr⁻¹·nm⁻¹).
    pub fn radiance(&self, view: Vec3) -> Vec<f64> {
        let smooth = self.smooth.transfer(view);
        let of_point = |(&(sun, (below, part)), left): (&(f64, (usize, f64)), f64)| {
            // Between light of two wavelengths logarithms are straight; darkness has none.
            let (low, high) = (smooth[below].max(0.0), smooth[below + 1].max(0.0));
            let light = if low > 0.0 && high > 0.0 {
                low.powf(1.0 - part) * high.powf(part)
            } else {
                low + part * (high - low)
            };
            sun * light * left
        };
        let of_points: Vec<f64> = self.points.iter().zip(self.lines.left(view)).map(of_point).collect();
        of_points.chunks(self.parts).map(|parts| parts.iter().sum::<f64>() / self.parts as f64).collect()
    }
}

/// The parts of dry air's lane and of water's above the observer, which the vertical column of a strength is.
fn lanes(scene: &Scene) -> [f64; 2] {
    let parts = parts_above(&scene.atmosphere.profile, scene.site.altitude, scene.observer.altitude);
    parts.unwrap_or([0.0; 2]).map(|part| part.clamp(LEAST_PART, 1.0))
}

/// Where a wavelength lies between others.
fn place(nodes: &[f64], nm: f64) -> (usize, f64) {
    let below = nodes.partition_point(|&node| node <= nm).clamp(1, nodes.len() - 1) - 1;
    (below, ((nm - nodes[below]) / (nodes[below + 1] - nodes[below])).clamp(0.0, 1.0))
}

/// The weights of the strengths of water and of dry air in the bin of a wavelength.
fn weights(gases: &SkyGases, [pairs, water]: [f64; 2], nm: f64) -> [[f64; STRENGTHS.len()]; 2] {
    let absorption = gases.absorption(nm);
    let vertical = gases.vertical();
    let of = |classes: [usize; 2], part: f64| {
        let amounts = |u: f64| -> [f64; CLASSES] {
            std::array::from_fn(|class| if classes.contains(&class) { u * part * vertical[class] } else { 0.0 })
        };
        fitted(|u| absorption.transmittance(&amounts(u)))
    };
    [of([WET, SELF], water), of([DRY, OXYGEN_SQUARED], pairs)]
}

/// Amounts of a gas for which weights are fitted, in columns above the observer: from the zenith's to more than three
/// horizons'.
const AMOUNTS: usize = 120;

fn amount(i: usize) -> f64 {
    120f64.powf(i as f64 / (AMOUNTS - 1) as f64)
}

/// The weights with which exponentials of [`STRENGTHS`] and a constant, together 1, come nearest to a transmittance by
/// amount.
fn fitted(transmittance: impl Fn(f64) -> f64) -> [f64; STRENGTHS.len()] {
    const N: usize = STRENGTHS.len();
    static SOLVE: OnceLock<SMatrix<f64, N, AMOUNTS>> = OnceLock::new();
    let solve = SOLVE.get_or_init(|| {
        /// Keeps weights small, which multiply what light is off by.
        const RIDGE: f64 = 1e-4;
        let rows = SMatrix::<f64, N, AMOUNTS>::from_fn(|j, i| (-STRENGTHS[j] * amount(i)).exp() - 1.0);
        let normal = rows * rows.transpose() / AMOUNTS as f64 + SMatrix::identity() * (RIDGE * RIDGE);
        normal.cholesky().expect("a ridge makes it positive").solve(&rows) / AMOUNTS as f64
    });
    let lost = SVector::<f64, AMOUNTS>::from_fn(|i, _| transmittance(amount(i)) - 1.0);
    (solve * lost).into()
}

/// A wavelength (nm), and the optical depths of the lanes of dry air and of water from the ground to the zenith.
pub(crate) type AtStrengths = (f64, [f64; 2]);

/// A wavelength (nm) without lines, with those of water and with those of dry air at every strength.
fn at_strengths(nm: f64, [pairs, water]: [f64; 2]) -> impl Iterator<Item = AtStrengths> {
    let wet = STRENGTHS.map(|strength| (nm, [0.0, strength / water]));
    let dry = STRENGTHS.map(|strength| (nm, [strength / pairs, 0.0]));
    [(nm, [0.0; 2])].into_iter().chain(wet).chain(dry)
}

/// Bands at wavelengths (nm) whose lines are those of strengths of dry air and of water. Pairs of oxygen absorb
/// smoothly below the first line.
fn through(bands: Bands, wavelengths: [f64; 4], strengths: [[f64; 4]; 2]) -> Bands {
    let [mut pairs, mut water] = [bands.pair_absorption.to_array(), bands.water_absorption.to_array()];
    for (i, _) in wavelengths.iter().enumerate().filter(|(_, nm)| **nm >= FIRST_LINE) {
        [pairs[i], water[i]] = strengths.map(|strengths| strengths[i] as f32);
    }
    Bands { pair_absorption: Vec4::from_array(pairs), water_absorption: Vec4::from_array(water), ..bands }
}

/// Bands at wavelengths (nm) without lines.
pub(crate) fn without_lines(optics: &Optics, wavelengths: &[f64]) -> Vec<Bands> {
    let four = |group: &[f64]| std::array::from_fn(|i| group[i.min(group.len() - 1)]);
    wavelengths.chunks(4).map(|group| through(optics.bands(four(group)), four(group), [[0.0; 4]; 2])).collect()
}

/// The integral of a sky at wavelengths and strengths; without light that was scattered more than once.
fn integral(sky: &RayIntegral, optics: &Optics, all: &[AtStrengths]) -> RayIntegral {
    let group = |group: &[AtStrengths]| {
        let of = |i: usize| group[i.min(group.len() - 1)];
        let lane = |lane: usize| std::array::from_fn(|i| of(i).1[lane]);
        through(optics.bands(std::array::from_fn(|i| of(i).0)), std::array::from_fn(|i| of(i).0), [lane(0), lane(1)])
    };
    RayIntegral {
        wavelengths: all.iter().map(|&(nm, _)| nm).collect(),
        bands: all.chunks(4).map(group).collect(),
        optics: optics.clone(),
        ..sky.clone()
    }
}

/// Bands (nm) at which a spectrum in air with gases sees what their lines leave, with the strengths of dry air and of
/// water there (optical depths of the vertical column above the ground): best of five such choices.
pub(crate) const LINE_BANDS: [AtStrengths; 3] = [(720.0, [0.0, 0.882]), (762.0, [0.0972, 0.0]), (762.0, [0.882, 0.0])];

/// Bands from the second group on at wavelengths (nm), the last of which are [`LINE_BANDS`] and the others without
/// lines.
pub(crate) fn beside_lines(wavelengths: &[f64], bands: &mut [Bands]) {
    let first_line = wavelengths.len() - LINE_BANDS.len();
    for (group, bands) in bands.iter_mut().enumerate().skip(1) {
        let at = |i: usize| (4 * group + i).min(wavelengths.len() - 1);
        let strengths = |i: usize| match at(i).checked_sub(first_line) {
            Some(line) => LINE_BANDS[line].1,
            None => [0.0; 2],
        };
        let lane = |lane: usize| std::array::from_fn(|i| strengths(i)[lane]);
        *bands = through(*bands, std::array::from_fn(|i| wavelengths[at(i)]), [lane(0), lane(1)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::spectrum::DenseSpectrum;
    use crate::medium::gases::Absorption;
    use crate::plan::direction;
    use crate::scene::{Preset, Rgb};

    fn sky(sun: f64, change: impl FnOnce(&mut Scene)) -> SkyPlan {
        let mut scene = Scene::preset(Preset::Standard);
        scene.sun.elevation = sun;
        change(&mut scene);
        SkyPlan::new(&scene.validated().unwrap(), Rgb::Srgb)
    }

    const VIEWS: [(f64, f64); 5] = [(2.0, 15.0), (10.0, 120.0), (35.0, 60.0), (80.0, 0.0), (-20.0, 90.0)];

    fn views() -> [Vec3; 5] {
        VIEWS.map(|(elevation, azimuth)| direction(elevation, azimuth).as_vec3())
    }

    #[test]
    fn strengths_stand_for_the_transmittance_of_every_bin() {
        let sky = sky(40.0, |_| {});
        let gases = optics_of(&sky.scene).gases.unwrap();
        let (mut square, mut count, mut largest) = (0.0, 0.0, 0.0f64);
        for nm in (560..2500).map(|nm| f64::from(nm) + 0.5) {
            let absorption = Absorption::at(nm, gases.temperature());
            let weights = weights(&gases, [1.0; 2], nm);
            for u in [1.0, 1.7, 3.0, 6.0, 11.0, 23.0, 38.0] {
                for (class, classes) in [[WET, SELF], [DRY, OXYGEN_SQUARED]].into_iter().enumerate() {
                    let amount = |i: usize| if classes.contains(&i) { u * gases.vertical()[i] } else { 0.0 };
                    let truth = absorption.transmittance(&std::array::from_fn(amount));
                    let of = |(strength, weight): (f64, &f64)| weight * ((-strength * u).exp() - 1.0);
                    let found = 1.0 + STRENGTHS.into_iter().zip(&weights[class]).map(of).sum::<f64>();
                    let error = (found - truth).abs();
                    (square, count, largest) = (square + error * error, count + 1.0, largest.max(error));
                }
            }
        }
        let rms = (square / count).sqrt();
        println!("rms {rms:.1e}, largest {largest:.1e}");
        // A study in double precision found 4e-4 and 1.1e-3 of bins of five nanometres; lines of one have one strength
        // or two.
        assert!(rms < 1e-3 && largest < 8e-3, "{rms:e}, {largest:e}");
    }

    /// Every line of a bin by itself, in light of all orders.
    #[test]
    fn light_through_strengths_is_that_through_every_line() {
        // Water, oxygen, water in two bands, and where carbon dioxide lies over water.
        let wavelengths = [720.5, 762.5, 940.5, 1132.5, 2012.5];
        for (sun, altitude) in [(60.0, 0.0), (5.0, 0.0), (-4.0, 0.0), (30.0, 2.0)] {
            let sky = sky(sun, |scene| scene.observer.altitude = altitude);
            let optics = optics_of(&sky.scene);
            let gases = optics.gases.clone().unwrap();
            let shortwave = Shortwave::new(&sky, &wavelengths, None).unwrap();
            for (i, &nm) in wavelengths.iter().enumerate() {
                let terms = Absorption::at(nm, gases.temperature()).every_line(&gases.vertical());
                let all: Vec<AtStrengths> =
                    [(nm, [0.0; 2])].into_iter().chain(terms.iter().map(|(_, strengths)| (nm, *strengths))).collect();
                let every = integral(&sky.base, &optics, &all).with_spectral_light();
                let sun_above = optics.solar_irradiance(nm);
                for (view, angles) in views().into_iter().zip(VIEWS) {
                    let light = every.transfer(view);
                    let truth: f64 = terms.iter().zip(&light[1..]).map(|((weight, _), light)| weight * light).sum();
                    let error = (shortwave.radiance(view)[i] / sun_above - truth) / light[0];
                    println!(
                        "sun {sun}, {altitude} km, {nm} nm, {angles:?}: {truth:.2e} of {:.2e}, {error:+.1e}",
                        light[0]
                    );
                    // What strengths leave, of lines whose parts are not alike between two wavelengths, and the product
                    // of two gases.
                    assert!(error.abs() < 0.025, "sun {sun}, {altitude} km, {nm} nm, {angles:?}: {error}");
                }
            }
        }
    }

    #[test]
    fn light_without_lines_is_that_of_each_wavelength() {
        let wavelengths = [305.5, 318.3, 336.7, 352.5, 402.5, 447.0, 487.5, 533.0];
        for sun in [60.0, 5.0, -4.0] {
            let sky = sky(sun, |_| {});
            let (shortwave, dense) =
                (Shortwave::new(&sky, &wavelengths, None).unwrap(), DenseSpectrum::new(&sky, &wavelengths));
            for (view, angles) in views().into_iter().zip(VIEWS) {
                for ((&nm, found), truth) in wavelengths.iter().zip(shortwave.radiance(view)).zip(dense.radiance(view))
                {
                    let error = found / truth - 1.0;
                    println!("sun {sun}, {nm} nm, {angles:?}: {error:+.1e}");
                    // Logarithms are straight over 5 nm, on the long ways of dusk.
                    assert!(error.abs() < 0.01, "sun {sun}, {nm} nm, {angles:?}: {error}");
                }
            }
        }
    }
}
