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
//! strength leaves of it is smoother still and is computed at [`crate::plan::strengths`].

use sorairo_shared::glam::Vec3;

use crate::plan::integral::RayIntegral;
use crate::plan::sky::{SkyPlan, optics_of};
use crate::plan::strengths::{Strengths, place, through_strengths, without_lines};
use crate::spectra::observer;
use crate::spectra::optics::Optics;
use crate::spectra::range::RANGE_OF_BEAMS;

/// What gases do are values of bins so wide (nm), of which longer means are made.
const LONGEST_PART: f64 = 1.0;

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

/// What lines leave of a sky's light at some wavelengths.
pub struct Lines {
    /// At the strengths; none where no lines absorb.
    integral: Option<RayIntegral>,
    strengths: Strengths,
}

impl Lines {
    /// Of a sky at wavelengths (nm); none in air without gases.
    pub fn new(sky: &SkyPlan, wavelengths: &[f64]) -> Option<Self> {
        Self::by(sky, &optics_of(&sky.scene), wavelengths, RayIntegral::with_spectral_light)
    }

    /// The same at the nodes of the observer, in means over what they stand for.
    pub fn over_steps(sky: &SkyPlan) -> Option<Self> {
        Self::by(sky, &sky.base.optics, &observer::wavelengths(), RayIntegral::with_spectral_light)
    }

    /// Those of a sky of these optics, light of higher orders by a light field of some resolution.
    fn by(sky: &SkyPlan, optics: &Optics, wavelengths: &[f64], lit: fn(RayIntegral) -> RayIntegral) -> Option<Self> {
        let strengths = Strengths::new(&sky.scene, optics, wavelengths)?;
        let integral = (!strengths.at.is_empty()).then(|| lit(through_strengths(&sky.base, optics, &strengths.at)));
        Some(Self { integral, strengths })
    }

    /// The part of light that they leave in a direction at each wavelength.
    pub fn left(&self, view: Vec3) -> Vec<f64> {
        self.strengths.left(&self.integral.as_ref().map_or_else(Vec::new, |integral| integral.transfer(view)))
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
        let lines = Lines::by(sky, &optics, &finely, lit)?;
        let points = finely.iter().map(|&nm| (optics.solar_irradiance(nm), place(&smooth, nm))).collect();
        let bands = without_lines(&optics, &smooth);
        let smooth = RayIntegral { wavelengths: smooth, bands, optics, ..sky.base.clone() };
        Some(Self { smooth: lit(smooth), points, lines, parts })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::spectrum::DenseSpectrum;
    use crate::medium::gases::{Absorption, DRY, OXYGEN_SQUARED, SELF, WET};
    use crate::plan::direction;
    use crate::plan::strengths::{AtStrengths, STRENGTHS, weights};
    use crate::scene::{Preset, Rgb, Scene};

    fn sky(sun: f64, change: impl FnOnce(&mut Scene)) -> SkyPlan {
        let mut scene = Scene::preset(Preset::Standard);
        scene.sun.elevation = sun;
        change(&mut scene);
        SkyPlan::new(&scene.validated().unwrap(), Rgb::Srgb)
    }

    const VIEWS: [(f64, f64); 6] = [(2.0, 15.0), (10.0, 120.0), (35.0, 60.0), (80.0, 0.0), (-20.0, 90.0), (-3.0, 0.0)];

    fn views() -> [Vec3; 6] {
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
        let from_below = [(60.0, 0.0), (5.0, 0.0), (-4.0, 0.0), (30.0, 2.0)].map(|place| (place, &wavelengths, 0.025));
        // From an aircraft, amounts have a wider range than is fitted. The error is largest for weak lines on the
        // longest paths, 3.2 % at 629 nm, and for strong water on the shortest, 5.3 % at 1390 nm.
        let seen_from_above = [592.5, 629.5, 762.5, 1132.5, 1390.5];
        let from_above = [(0.0, 12.0), (-4.0, 12.0), (-4.0, 4.0)].map(|place| (place, &seen_from_above, 0.055));
        for ((sun, altitude), wavelengths, bound) in from_below.into_iter().chain(from_above) {
            let sky = sky(sun, |scene| scene.observer.altitude = altitude);
            let optics = optics_of(&sky.scene);
            let gases = optics.gases.clone().unwrap();
            let shortwave = Shortwave::new(&sky, wavelengths, None).unwrap();
            for (i, &nm) in wavelengths.iter().enumerate() {
                let terms = Absorption::at(nm, gases.temperature()).every_line(&gases.vertical());
                let all: Vec<AtStrengths> =
                    [(nm, [0.0; 2])].into_iter().chain(terms.iter().map(|(_, strengths)| (nm, *strengths))).collect();
                let every = through_strengths(&sky.base, &optics, &all).with_spectral_light();
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
                    assert!(error.abs() < bound, "sun {sun}, {altitude} km, {nm} nm, {angles:?}: {error}");
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
