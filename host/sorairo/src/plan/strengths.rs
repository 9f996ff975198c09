//! Light through the lines of gases, as sums of light at fixed strengths; see [`crate::plan::shortwave`].

use std::sync::OnceLock;

use nalgebra::{SMatrix, SVector};
use sorairo_shared::glam::Vec4;
use sorairo_shared::medium::bands::Bands;

use crate::medium::gases::{CLASSES, DRY, OXYGEN_SQUARED, SELF, SkyGases, WET, parts_above};
use crate::plan::integral::RayIntegral;
use crate::scene::Scene;
use crate::spectra::optics::Optics;

/// The least light of which a logarithm is taken, as in the kernels.
const DARKEST: f64 = sorairo_shared::fit::spectrum::DARKEST as f64;

/// Strengths beside none: optical depths of the vertical column above the observer.
pub(crate) const STRENGTHS: [f64; 7] = [0.0107, 0.0322, 0.0972, 0.293, 0.882, 2.66, 8.0];

/// Wavelengths (nm) at which light is computed at every strength.
///
/// Light scattered once and light of higher orders have crossed different amounts, and their mix varies between two of
/// these: without 620 nm, X of the horizon in twilight has an error of 0.5 %.
const OF_STRENGTHS: [f64; 10] = [560.0, 620.0, 690.0, 762.0, 830.0, 940.0, 1130.0, 1380.0, 1880.0, 2500.0];

/// Those of colours, which see little of the strongest lines and learn each constituent by itself: of seven pairs the
/// one with the least colour difference over suns from -10° to 60°.
const OF_COLOURS: [f64; 2] = [570.0, 640.0];

/// Which of [`STRENGTHS`] light of colours is computed at; what it has crossed at the others lies between.
const STRENGTHS_OF_COLOURS: [usize; 3] = [0, 3, 6];

/// Every one of [`STRENGTHS`].
const ALL_STRENGTHS: [usize; STRENGTHS.len()] = [0, 1, 2, 3, 4, 5, 6];

/// Below this wavelength (nm) no lines absorb.
pub(crate) const FIRST_LINE: f64 = 558.0;

/// The least parts of the columns of dry air and of water over the ground for which strengths are made.
///
/// From above most of a gas, rays to the horizon cross hundreds of times the column above the observer, and amounts
/// beyond [`AMOUNTS`] are not fitted: with parts of 0.1 the radiance at 630 nm from 12 km, 3° below the level under a
/// sun at -4°, has an error of 22 % of that without lines, with these 3 %. Whole columns would be more than the sky
/// above contains: an error of 11 % at 1390 nm, with these 5 %.
const LEAST_PARTS: [f64; 2] = [0.3, 0.2];

/// The weights of strengths of water and of dry air in a bin, and where it lies among the wavelengths at which light is
/// computed at each.
type OfLines = ([[f64; STRENGTHS.len()]; 2], (usize, f64));

/// Of which light at fixed strengths that of some wavelengths is made.
pub(crate) struct Strengths {
    /// At those of [`OF_STRENGTHS`] that the wavelengths need, each without lines, with those of water and with those
    /// of dry air; none where no lines absorb.
    pub(crate) at: Vec<AtStrengths>,
    /// Which of [`STRENGTHS`] these are.
    computed: &'static [usize],
    /// At each wavelength; none where no lines absorb.
    points: Vec<Option<OfLines>>,
}

/// Whether lines of gases absorb light of some wavelengths (nm).
pub(crate) fn has_lines(optics: &Optics, wavelengths: &[f64]) -> bool {
    optics.gases.is_some() && wavelengths.iter().any(|&nm| nm >= FIRST_LINE)
}

impl Strengths {
    /// Those of a scene's sky at wavelengths (nm), in means over what they stand for in its optics; none in air without
    /// gases.
    pub(crate) fn new(scene: &Scene, optics: &Optics, wavelengths: &[f64]) -> Option<Self> {
        Self::at_some(optics, wavelengths, lanes(scene), (&OF_STRENGTHS, &ALL_STRENGTHS))
    }

    /// Those of colours, for observers at every altitude: as many as light at wavelengths up to 830 nm needs where its
    /// lines are a part of what is seen.
    pub(crate) fn of_colours(optics: &Optics, wavelengths: &[f64]) -> Option<Self> {
        Self::at_some(optics, wavelengths, [1.0; 2], (&OF_COLOURS, &STRENGTHS_OF_COLOURS))
    }

    fn at_some(
        optics: &Optics,
        wavelengths: &[f64],
        lanes: [f64; 2],
        (of_strengths, computed): (&[f64], &'static [usize]),
    ) -> Option<Self> {
        let gases = optics.gases.as_ref()?;
        let absorbed = || wavelengths.iter().filter(|&&nm| nm >= FIRST_LINE);
        let (first, last) = absorbed().fold((f64::INFINITY, 0.0f64), |(low, high), &nm| (low.min(nm), high.max(nm)));
        let low = of_strengths.partition_point(|&nm| nm <= first).clamp(1, of_strengths.len() - 1) - 1;
        let high = of_strengths.partition_point(|&nm| nm < last).clamp(low + 1, of_strengths.len() - 1);
        let nodes = &of_strengths[low..=high];
        let point = |&nm: &f64| (nm >= FIRST_LINE).then(|| (weights(gases, lanes, nm), place(nodes, nm)));
        let all = nodes.iter().flat_map(|&nm| at_strengths(nm, lanes, computed)).collect();
        let at = if absorbed().next().is_some() { all } else { Vec::new() };
        Some(Self { at, computed, points: wavelengths.iter().map(point).collect() })
    }

    /// The integral at the strengths, of a sky of these optics; without light that was scattered more than once.
    pub(crate) fn integral(&self, sky: &RayIntegral) -> RayIntegral {
        through_strengths(sky, &sky.optics, &self.at)
    }

    /// Wavelengths (nm) without lines, and behind them the strengths.
    pub(crate) fn behind(&self, wavelengths: &[f64]) -> Vec<AtStrengths> {
        wavelengths.iter().map(|&nm| (nm, [0.0; 2])).chain(self.at.iter().copied()).collect()
    }

    /// Light through the lines, by light without them and behind it that at the strengths.
    pub(crate) fn through(&self, mut light: Vec<f64>) -> Vec<f64> {
        let at_strengths = light.split_off(light.len() - self.at.len());
        light.iter_mut().zip(self.left(&at_strengths)).for_each(|(light, left)| *light *= left);
        light
    }

    /// The part of light that lines leave at each wavelength, by light at the strengths.
    pub(crate) fn left(&self, light: &[f64]) -> Vec<f64> {
        let part = |at: &[f64]| -> Vec<f64> {
            let parts: Vec<f64> = at[1..].iter().map(|light| if at[0] > 0.0 { light / at[0] } else { 0.0 }).collect();
            parts.chunks_exact(self.computed.len()).flat_map(|parts| self.at_every_strength(parts)).collect()
        };
        let nodes: Vec<Vec<f64>> = light.chunks_exact(1 + 2 * self.computed.len()).map(part).collect();
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

    /// The part of light that every strength of a gas leaves, by those of some: the amount that light seems to have
    /// crossed, `-ln(L(K)/L(0))/K`, falls with the strength, since the strong see what has crossed little. Its
    /// logarithm is interpolated over that of the strength.
    fn at_every_strength(&self, parts: &[f64]) -> [f64; STRENGTHS.len()] {
        if let Ok(all) = parts.try_into() {
            return all;
        }
        let amount = |(&j, part): (&usize, &f64)| (-part.clamp(DARKEST, 1.0).ln() / STRENGTHS[j]).max(DARKEST).ln();
        let amounts: Vec<f64> = self.computed.iter().zip(parts).map(amount).collect();
        std::array::from_fn(|j| {
            let weight = |&at: &usize| {
                let others = self.computed.iter().filter(|&&other| other != at);
                others.map(|&other| (j as f64 - other as f64) / (at as f64 - other as f64)).product::<f64>()
            };
            let amount: f64 =
                self.computed.iter().map(weight).zip(&amounts).map(|(weight, amount)| weight * amount).sum();
            (-STRENGTHS[j] * amount.exp()).exp()
        })
    }
}

/// The parts of dry air's lane and of water's above the observer, which the vertical column of a strength is.
fn lanes(scene: &Scene) -> [f64; 2] {
    let parts = parts_above(&scene.atmosphere.profile, scene.site.altitude, scene.observer.altitude);
    let parts = parts.unwrap_or([0.0; 2]);
    std::array::from_fn(|gas| parts[gas].clamp(LEAST_PARTS[gas], 1.0))
}

/// Where a wavelength lies between others.
pub(crate) fn place(nodes: &[f64], nm: f64) -> (usize, f64) {
    let below = nodes.partition_point(|&node| node <= nm).clamp(1, nodes.len() - 1) - 1;
    (below, ((nm - nodes[below]) / (nodes[below + 1] - nodes[below])).clamp(0.0, 1.0))
}

/// The weights of the strengths of water and of dry air in the bin of a wavelength.
pub(crate) fn weights(gases: &SkyGases, [pairs, water]: [f64; 2], nm: f64) -> [[f64; STRENGTHS.len()]; 2] {
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
fn at_strengths(nm: f64, [pairs, water]: [f64; 2], strengths: &[usize]) -> impl Iterator<Item = AtStrengths> {
    let wet = strengths.iter().map(move |&j| (nm, [0.0, STRENGTHS[j] / water]));
    let dry = strengths.iter().map(move |&j| (nm, [STRENGTHS[j] / pairs, 0.0]));
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
    let all: Vec<AtStrengths> = wavelengths.iter().map(|&nm| (nm, [0.0; 2])).collect();
    bands_through(optics, &all)
}

/// Bands at wavelengths and strengths.
pub(crate) fn bands_through(optics: &Optics, all: &[AtStrengths]) -> Vec<Bands> {
    let group = |group: &[AtStrengths]| {
        let of = |i: usize| group[i.min(group.len() - 1)];
        let lane = |lane: usize| std::array::from_fn(|i| of(i).1[lane]);
        through(optics.bands(std::array::from_fn(|i| of(i).0)), std::array::from_fn(|i| of(i).0), [lane(0), lane(1)])
    };
    all.chunks(4).map(group).collect()
}

/// The integral of a sky at wavelengths and strengths; without light that was scattered more than once.
pub(crate) fn through_strengths(sky: &RayIntegral, optics: &Optics, all: &[AtStrengths]) -> RayIntegral {
    RayIntegral {
        wavelengths: all.iter().map(|&(nm, _)| nm).collect(),
        bands: bands_through(optics, all),
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
    use crate::plan::{SkyPlan, direction, optics_of};
    use crate::scene::{Preset, Rgb};
    use crate::spectra::mean::Window;
    use crate::spectra::observer;

    /// Of colours, weighted by what the eye sees of each wavelength.
    #[test]
    fn three_strengths_at_two_wavelengths_tell_what_all_leave_of_colours() {
        for sun in [60.0, 5.0, -4.0] {
            let mut scene = Scene::preset(Preset::Standard);
            scene.sun.elevation = sun;
            let sky = SkyPlan::new(&scene.validated().unwrap(), Rgb::Srgb);
            let optics = optics_of(&sky.scene).over(Window::STEP);
            let at = observer::wavelengths();
            let left = |strengths: &Strengths, view| {
                let light = strengths.integral(&sky.base).with_spectral_light().transfer(view);
                strengths.left(&light)
            };
            let (all, few) =
                (Strengths::new(&sky.scene, &optics, &at).unwrap(), Strengths::of_colours(&optics, &at).unwrap());
            for (elevation, azimuth) in [(1.0, 20.0), (30.0, 90.0), (90.0, 0.0)] {
                let view = direction(elevation, azimuth).as_vec3();
                let sum = |left: Vec<f64>| {
                    let lost =
                        left.iter().zip(&at).map(|(left, &nm)| observer::weights(sky.observer, nm) * (1.0 - left));
                    lost.sum::<sorairo_shared::glam::DVec3>()
                };
                let (truth, found) = (sum(left(&all, view)), sum(left(&few, view)));
                println!("sun {sun}, {elevation}: lost {truth:.2}, error {:+.3}", found / truth - 1.0);
                // A twentieth of what is lost, which is a tenth at most, is less than a just visible difference.
                assert!(
                    truth.y > 0.5 && (found.y / truth.y - 1.0).abs() < 0.05,
                    "sun {sun}, {elevation}: {found}, {truth}"
                );
                assert!((found.x / truth.x - 1.0).abs() < 0.05, "sun {sun}, {elevation}: {found}, {truth}");
            }
        }
    }
}
