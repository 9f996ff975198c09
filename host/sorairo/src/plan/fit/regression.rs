//! The regression fit: the spectrum between the bands, by a regression on the scene's own rays.
//!
//! Light that has crossed an atmosphere is a product of exponentials of extinction spectra, so the logarithm of a
//! constituent's integral `X(λ)` is nearly an affine function of its logarithms at a few bands. For one sun and one
//! atmosphere the rays of a sky form a family of two parameters, and the affine function that is best for that family
//! is far better than any that is fixed beforehand. It is found from some hundred rays, integrated at every wavelength,
//! each time a plan is made.

use std::ops::Range;

use sorairo_shared::glam::{DVec3, Vec4};

use crate::plan::fit::training::{DARKEST, scattering_of, training_spectra};
use crate::plan::integral::{Constituent, RayIntegral};
use crate::plan::picture::colour_space::ColourSpace;
use crate::scene::ColourObserver;
use crate::spectra::observer;
use crate::spectra::optics::{Coefficients, Optics, vec4};

/// Regularisation of the regression, relative to the mean variance of the bands' logarithms: they are nearly dependent.
const RIDGE: f64 = 1e-8;

/// A ray counts as lit if it is at least this part of the brightest one.
pub const LIT: f64 = 1e-11;

/// A variance of the bands' logarithms that says nothing, where light is as exact as the training's: enough to keep the
/// system solvable.
pub const NO_NOISE: f64 = 1.491_668_146_240_041_3e-154;

/// With fewer lit rays than this the regression leans on synthetic spectra.
const FEW_RAYS: usize = 10;

/// Wavelengths (nm) at which the fitted spectrum is weighed for the observer and the sun: best found for the bands, in
/// air without gases or with them.
pub fn node_wavelengths(bands: usize, has_gases: bool) -> Vec<f64> {
    match bands {
        0..=5 if has_gases => vec![430.0, 465.0, 520.0, 530.0, 600.0, 660.0],
        0..=5 => vec![429.0, 464.0, 499.0, 551.0, 593.0, 650.0],
        _ => (0..16).map(|i| 395.0 + 20.0 * f64::from(i)).collect(),
    }
}

/// Spectra of one constituent's integral on which a regression is made.
pub struct Examples {
    /// ln X at the bands, for each ray.
    pub bands: Vec<Vec<f64>>,
    /// X at the other wavelengths, for each ray.
    pub values: Vec<Vec<f64>>,
    /// How much each ray counts.
    pub weights: Vec<f64>,
}

/// `ln X(λ) = intercept + slopes · ln X(bands)`.
#[derive(Clone, Debug)]
pub struct Regression {
    /// The value where every band's logarithm is zero.
    pub intercept: f64,
    /// The share of each band.
    pub slopes: Vec<f64>,
}

impl Regression {
    /// What lies a part of the way from this to another.
    pub fn towards(&self, other: &Self, part: f64) -> Self {
        let mix = |from: f64, to: f64| from + part * (to - from);
        let slopes = self.slopes.iter().zip(&other.slopes).map(|(&from, &to)| mix(from, to)).collect();
        Self { intercept: mix(self.intercept, other.intercept), slopes }
    }

    /// That of the product of this and another.
    pub fn times(mut self, other: &Self) -> Self {
        self.intercept += other.intercept;
        self.slopes.iter_mut().zip(&other.slopes).for_each(|(slope, other)| *slope += other);
        self
    }

    /// X at the regression's wavelength from ln X at the bands.
    pub fn value(&self, logarithms: &[f64]) -> f64 {
        (self.intercept + self.slopes.iter().zip(logarithms).map(|(a, b)| a * b).sum::<f64>()).exp()
    }
}

/// The colour rows of an observer node: the slopes of each group of four bands, filled up with zeros, then the last
/// row.
fn node_rows(slopes: &[f64], last: [f64; 4]) -> Vec<Vec4> {
    let four = |group: &[f64]| vec4(std::array::from_fn(|i| group.get(i).copied().unwrap_or(0.0)));
    slopes.chunks(4).map(four).chain([vec4(last)]).collect()
}

/// The rows of observer nodes through some groups of bands, to be read beside those through more: the others weigh
/// nothing.
pub fn beside_more_bands(rows: &[Vec4], groups: usize, more: usize) -> Vec<Vec4> {
    let wider = |node: &[Vec4]| [&node[..groups], &vec![Vec4::ZERO; more - groups], &node[groups..]].concat();
    rows.chunks(groups + 1).flat_map(wider).collect()
}

/// The rows of a spectral image: for each wavelength (nm) those of each constituent's regression; see
/// [`sorairo_shared::fit::spectrum::regression_value`].
pub fn spectrum_rows(
    optics: &Optics,
    wavelengths: &[f64],
    regressions: &[(Constituent, Vec<Regression>)],
) -> Vec<Vec4> {
    let rows = |(i, &wavelength): (usize, &f64)| {
        let irradiance = optics.solar_irradiance(wavelength);
        let of = move |(constituent, regressions): &(Constituent, Vec<Regression>)| {
            let Regression { intercept, slopes } = &regressions[i];
            node_rows(slopes, [*intercept, irradiance * constituent.albedo(optics, wavelength), 0.0, 0.0])
        };
        regressions.iter().flat_map(of).collect::<Vec<_>>()
    };
    wavelengths.iter().enumerate().flat_map(rows).collect()
}

/// What a regression fit is made on.
pub struct Training<'a> {
    /// The ray integral at the bands.
    pub integral: &'a RayIntegral,
    /// The colour observer.
    pub observer: ColourObserver,
    /// The space of linear RGB.
    pub space: &'a ColourSpace,
}

impl Training<'_> {
    /// The constituents that there are.
    pub fn constituents(&self) -> impl Iterator<Item = Constituent> + use<> {
        let variant = self.integral.variant;
        Constituent::ALL.into_iter().filter(move |constituent| constituent.is_in(variant))
    }

    /// The regressions of every constituent at some wavelengths (nm).
    pub fn regressions(&self, at: &[f64]) -> Vec<(Constituent, Vec<Regression>)> {
        let regressions = |examples: &Examples| regress(examples, 0..at.len(), NO_NOISE);
        self.examples(at).iter().map(|(constituent, examples)| (*constituent, regressions(examples))).collect()
    }

    /// The observer nodes of every constituent's regression fit as the kernels take them; see
    /// [`sorairo_shared::fit::spectrum::regression_rgb`]. With `solve` the rows are for the Newton coefficients of four
    /// bands.
    pub fn nodes(&self, solve: bool) -> Vec<Vec4> {
        let nodes = node_wavelengths(self.integral.wavelengths.len(), self.integral.optics.gases.is_some());
        let samples = observer::wavelengths();
        let at: Vec<f64> = nodes.iter().chain(&samples).copied().collect();
        let mut rows = Vec::new();
        for (constituent, examples) in self.examples(&at) {
            let regressions = regress(&examples, 0..nodes.len(), NO_NOISE);
            let weights = self.node_weights(constituent, &examples, &regressions, &samples);
            for (regression, rgb) in regressions.iter().zip(weights) {
                let slopes =
                    if solve { self.for_newton_coefficients(&regression.slopes) } else { regression.slopes.clone() };
                rows.extend(node_rows(&slopes, [regression.intercept, rgb.x, rgb.y, rgb.z]));
            }
        }
        rows
    }

    /// Slopes on the values at four bands, as slopes on the Newton coefficients through them: their product with
    /// Newton's basis at the bands, a lower triangular matrix.
    fn for_newton_coefficients(&self, slopes: &[f64]) -> Vec<f64> {
        let x: Vec<f64> =
            self.integral.wavelengths.iter().map(|&wavelength| observer::normalised(wavelength)).collect();
        let coefficient = |k: usize| {
            let basis = |i: usize| (0..k).map(|j| x[i] - x[j]).product::<f64>();
            (k..4).map(|i| slopes[i] * basis(i)).sum()
        };
        (0..4).map(coefficient).collect()
    }

    /// The colour of each node (linear RGB): least squares of the observer's own sum over the examples.
    ///
    /// Each example counts by its relative error; a component that is a thousandth of the others counts as that.
    pub fn node_weights(
        &self,
        constituent: Constituent,
        examples: &Examples,
        regressions: &[Regression],
        samples: &[f64],
    ) -> Vec<DVec3> {
        let optics = &self.integral.optics;
        let brightness = |wavelength: f64| optics.solar_irradiance(wavelength) * constituent.albedo(optics, wavelength);
        let observer: Vec<DVec3> = samples
            .iter()
            .map(|&wavelength| observer::weights(self.observer, wavelength) * brightness(wavelength))
            .collect();
        let features: Vec<Vec<f64>> =
            examples.bands.iter().map(|bands| regressions.iter().map(|node| node.value(bands)).collect()).collect();
        let targets: Vec<DVec3> = examples
            .values
            .iter()
            .map(|values| values[regressions.len()..].iter().zip(&observer).map(|(&value, &xyz)| xyz * value).sum())
            .collect();
        let mut weights = vec![DVec3::ZERO; regressions.len()];
        for channel in 0..3 {
            let scale = |target: &DVec3| target[channel].max(1e-3 * target.element_sum()).recip();
            let rows: Vec<Vec<f64>> = features
                .iter()
                .zip(&targets)
                .zip(&examples.weights)
                .map(|((row, target), weight)| row.iter().map(|x| x * scale(target) * weight.sqrt()).collect())
                .collect();
            let right: Vec<f64> = targets
                .iter()
                .zip(&examples.weights)
                .map(|(target, weight)| target[channel] * scale(target) * weight.sqrt())
                .collect();
            for (weight, solved) in weights.iter_mut().zip(least_squares(&rows, &right)) {
                weight[channel] = solved;
            }
        }
        weights.into_iter().map(|xyz| self.space.from_xyz * xyz).collect()
    }

    /// Examples of every constituent at the bands and at the wavelengths `at` (nm).
    fn examples(&self, at: &[f64]) -> Vec<(Constituent, Examples)> {
        let all: Vec<f64> = self.integral.wavelengths.iter().chain(at).copied().collect();
        let mut spectra = training_spectra(self.integral, &all);
        let mut of = |constituent| self.chosen(constituent, std::mem::take(constituent.of_mut(&mut spectra)), &all);
        self.constituents().map(|constituent| (constituent, of(constituent))).collect()
    }

    /// The examples of a constituent among its spectra at the bands and at other wavelengths, `all` (nm).
    pub fn chosen(&self, constituent: Constituent, spectra: Vec<Vec<f64>>, all: &[f64]) -> Examples {
        let values = all.len() - self.integral.wavelengths.len();
        let reference = self.integral.wavelengths.len() / 2;
        let brightest = spectra.iter().map(|spectrum| spectrum[reference]).fold(0.0, f64::max);
        let mut examples = Examples { bands: Vec::new(), values: Vec::new(), weights: Vec::new() };
        for spectrum in spectra.iter().filter(|spectrum| spectrum[reference] > LIT * brightest) {
            self.add(&mut examples, spectrum, values, 1.0);
        }
        if examples.weights.len() < FEW_RAYS {
            for spectrum in self.synthetic(constituent, all) {
                self.add(&mut examples, &spectrum, values, 1e-4);
            }
        }
        examples
    }

    fn add(&self, examples: &mut Examples, spectrum: &[f64], values: usize, weight: f64) {
        let count = self.integral.wavelengths.len();
        examples.bands.push(spectrum[..count].iter().map(|value| value.max(DARKEST).ln()).collect());
        examples.values.push(spectrum[count..count + values].iter().map(|value| value.max(DARKEST)).collect());
        examples.weights.push(weight);
    }

    /// Spectra `β e^(-β n - κ m)` for column densities of air up to 400 km and of ozone up to 450 km: what light
    /// through any atmosphere of these constituents is made of.
    fn synthetic(&self, constituent: Constituent, wavelengths: &[f64]) -> Vec<Vec<f64>> {
        let of = |c: &Coefficients, n: f64, m: f64| {
            scattering_of(constituent, *c) * (-c.air_scattering * n - c.ozone_absorption * m).exp()
        };
        let at: Vec<Coefficients> = wavelengths.iter().map(|&wavelength| self.integral.optics.at(wavelength)).collect();
        let densities = (0..9).flat_map(|i| (0..5).map(move |j| (50.0 * f64::from(i), 112.5 * f64::from(j))));
        densities.map(|(n, m)| at.iter().map(|c| of(c, n, m)).collect()).collect()
    }
}

/// Regressions of ln X at some of the other wavelengths on ln X at the bands, by ridge regression around the mean.
/// Every slope is taken relative to 1/n, so that what the ridge pulls towards is a grey change of all bands. `noise` is
/// the variance of a band's logarithm that says nothing; see [`NO_NOISE`].
pub fn regress(examples: &Examples, values: Range<usize>, noise: f64) -> Vec<Regression> {
    let count = examples.bands.first().map_or(0, Vec::len);
    let total: f64 = examples.weights.iter().sum();
    let share = 1.0 / count as f64;
    let mean = |value: &dyn Fn(usize) -> f64| {
        examples.weights.iter().enumerate().map(|(ray, weight)| weight * value(ray)).sum::<f64>() / total
    };
    let band_means: Vec<f64> = (0..count).map(|b| mean(&|ray| examples.bands[ray][b])).collect();
    let deviation = |bands: &Vec<f64>| bands.iter().zip(&band_means).map(|(band, mean)| band - mean).collect();
    let deviations: Vec<Vec<f64>> = examples.bands.iter().map(deviation).collect();
    let grey: Vec<f64> = examples.bands.iter().map(|bands| bands.iter().sum::<f64>() * share).collect();
    let covariance = |a: usize, b: usize| mean(&|ray| deviations[ray][a] * deviations[ray][b]);
    let mut matrix: Vec<Vec<f64>> = (0..count).map(|a| (0..=a).map(|b| covariance(a, b)).collect()).collect();
    let trace: f64 = (0..count).map(|b| matrix[b][b]).sum();
    for (b, row) in matrix.iter_mut().enumerate() {
        row[b] += RIDGE * share * trace + noise;
    }
    let decomposed = decomposed(matrix);
    let regression = |i: usize| {
        let residuals: Vec<f64> =
            examples.values.iter().zip(&grey).map(|(values, grey)| values[i].ln() - grey).collect();
        let residual_mean = mean(&|ray| residuals[ray]);
        let right = (0..count).map(|a| mean(&|ray| deviations[ray][a] * (residuals[ray] - residual_mean))).collect();
        let slopes = solved(&decomposed, right);
        let intercept = residual_mean - slopes.iter().zip(&band_means).map(|(a, b)| a * b).sum::<f64>();
        Regression { intercept, slopes: slopes.into_iter().map(|slope| slope + share).collect() }
    };
    values.map(regression).collect()
}

/// The same of what is a part of light, such as that which lines leave: it does not follow a grey change of all bands.
pub fn regress_parts(examples: &Examples, noise: f64) -> Vec<Regression> {
    let count = examples.bands.first().map_or(0, Vec::len);
    let share = 1.0 / count as f64;
    let of_grey = |(values, bands): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
        let grey = (bands.iter().sum::<f64>() * share).exp();
        values.iter().map(|value| value * grey).collect()
    };
    let values: Vec<Vec<f64>> = examples.values.iter().zip(&examples.bands).map(of_grey).collect();
    let wavelengths = values.first().map_or(0, Vec::len);
    let examples = Examples { values, bands: examples.bands.clone(), weights: examples.weights.clone() };
    let mut found = regress(&examples, 0..wavelengths, noise);
    found.iter_mut().flat_map(|regression| &mut regression.slopes).for_each(|slope| *slope -= share);
    found
}

/// Least squares with columns scaled to unit size and a small ridge.
fn least_squares(rows: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let columns = rows.first().map_or(0, Vec::len);
    let count = rows.len() as f64;
    let size: Vec<f64> = (0..columns)
        .map(|c| (rows.iter().map(|row| row[c] * row[c]).sum::<f64>() / count).sqrt().max(f64::MIN_POSITIVE.sqrt()))
        .collect();
    let mut matrix = vec![vec![0.0; columns]; columns];
    let mut target = vec![0.0; columns];
    for (row, value) in rows.iter().zip(right) {
        let scaled: Vec<f64> = row.iter().zip(&size).map(|(x, size)| x / size).collect();
        for a in 0..columns {
            for b in 0..columns {
                matrix[a][b] += scaled[a] * scaled[b] / count;
            }
            target[a] += scaled[a] * value / count;
        }
    }
    for (c, row) in matrix.iter_mut().enumerate() {
        row[c] += RIDGE;
    }
    solved(&decomposed(matrix), target).into_iter().zip(size).map(|(value, size)| value / size).collect()
}

/// Cholesky's decomposition of a symmetric, positive definite matrix, of which the lower triangle is read.
fn decomposed(mut matrix: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    for i in 0..matrix.len() {
        for j in 0..=i {
            let sum: f64 = matrix[i][j] - (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum::<f64>();
            matrix[i][j] = if i == j { sum.max(f64::MIN_POSITIVE).sqrt() } else { sum / matrix[j][j] };
        }
    }
    matrix
}

/// Solves a system by the decomposition of its matrix.
fn solved(decomposed: &[Vec<f64>], mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    for i in 0..n {
        right[i] = (right[i] - (0..i).map(|k| decomposed[i][k] * right[k]).sum::<f64>()) / decomposed[i][i];
    }
    for i in (0..n).rev() {
        right[i] = (right[i] - (i + 1..n).map(|k| decomposed[k][i] * right[k]).sum::<f64>()) / decomposed[i][i];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_symmetric_system_is_solved() {
        let matrix = vec![vec![4.0, 1.0, 0.5], vec![1.0, 3.0, 0.2], vec![0.5, 0.2, 2.0]];
        let truth = [1.0, -2.0, 0.25];
        let right = matrix.iter().map(|row| row.iter().zip(truth).map(|(a, b)| a * b).sum()).collect();
        for (value, expected) in solved(&decomposed(matrix), right).iter().zip(truth) {
            assert!((value - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn an_affine_law_is_found_exactly() {
        let law = |bands: &[f64]| 0.3 + 0.6 * bands[0] + 0.5 * bands[1];
        let bands: Vec<Vec<f64>> = (0..30).map(|i| vec![-f64::from(i) * 0.1, (f64::from(i) * 0.7).sin()]).collect();
        let values = bands.iter().map(|bands| vec![law(bands).exp()]).collect();
        let regression = &regress(&Examples { weights: vec![1.0; 30], bands, values }, 0..1, NO_NOISE)[0];
        let bands = [-0.7, 0.2];
        // The ridge leaves a part of 1e-8.
        assert!((regression.value(&bands) / law(&bands).exp() - 1.0).abs() < 1e-6);
    }
}
