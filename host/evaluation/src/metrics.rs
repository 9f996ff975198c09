//! How far one colour or radiance is from another.

use palette::color_difference::Ciede2000;
use palette::white_point::D65;
use serde::Serialize;
use sorairo_shared::glam::{DVec2, DVec3};

/// XYZ of D65 for the 2° observer, relative to Y = 1 (CIE 15:2004, Table 11.3).
pub const WHITE: DVec3 = DVec3::new(0.950_47, 1.0, 1.088_83);

/// The luminance, of a white of 1, at which two colours are compared: every pixel is brought there, so that dark
/// twilight counts as much as noon.
const SHOWN_AT: f64 = 0.5;

/// CIE 1976 L*, a*, b* of XYZ relative to [`WHITE`] (CIE 15:2004, 8.2.1.1).
pub fn lab(xyz: DVec3) -> [f64; 3] {
    const EDGE: f64 = 6.0 / 29.0;
    let f = |t: f64| if t > EDGE * EDGE * EDGE { t.cbrt() } else { t / (3.0 * EDGE * EDGE) + 4.0 / 29.0 };
    let [x, y, z] = (xyz / WHITE).to_array().map(f);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The CIEDE2000 difference of two colours in L*, a*, b* (CIE 142:2001), with all parametric factors 1.
pub fn ciede2000(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [a, b] = [a, b].map(|[l, a, b]| palette::Lab::<D65, f64>::new(l, a, b));
    a.difference(b)
}

/// CIE 1976 chromaticity (u', v') of XYZ (CIE 15:2004, 8.1).
pub fn chromaticity(xyz: DVec3) -> DVec2 {
    DVec2::new(4.0 * xyz.x, 9.0 * xyz.y) / (xyz.x + 15.0 * xyz.y + 3.0 * xyz.z)
}

/// The error of one colour.
#[derive(Clone, Copy, Debug)]
pub struct ColourError {
    /// CIEDE2000, both colours scaled by the factor that brings the reference to Y = 50: an error of luminance enters.
    pub delta_e: f64,
    /// Relative error of the luminance.
    pub luminance: f64,
    /// Distance in the (u', v') plane.
    pub chromaticity: f64,
}

impl ColourError {
    /// The error of an XYZ against a reference of positive luminance, in the same unit.
    pub fn new(xyz: DVec3, reference: DVec3) -> Self {
        let scale = SHOWN_AT / reference.y;
        Self {
            delta_e: ciede2000(lab(xyz * scale), lab(reference * scale)),
            luminance: (xyz.y / reference.y - 1.0).abs(),
            chromaticity: chromaticity(xyz).distance(chromaticity(reference)),
        }
    }
}

/// The errors of many colours. A NaN among them makes the figure it belongs to a NaN.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Errors {
    /// Largest CIEDE2000 difference.
    pub delta_e_max: f64,
    /// Mean CIEDE2000 difference.
    pub delta_e_mean: f64,
    /// Largest relative error of the luminance.
    pub luminance_max: f64,
    /// Largest distance in the (u', v') plane.
    pub chromaticity_max: f64,
    /// Root of the mean squared relative error of XYZ: `|ΔXYZ| / |XYZ|` of each colour.
    pub relative_rmse: f64,
    /// How many colours were compared.
    pub compared: usize,
}

impl Errors {
    /// The errors of colours, each against its reference. Pairs whose reference has no luminance are left out.
    pub fn of(pairs: impl IntoIterator<Item = (DVec3, DVec3)>) -> Self {
        let mut sum = Self::default();
        for (xyz, reference) in pairs.into_iter().filter(|(_, reference)| reference.y > 0.0) {
            let error = ColourError::new(xyz, reference);
            let squared = (xyz - reference).length_squared() / reference.length_squared();
            sum = sum.and(&Self {
                delta_e_max: error.delta_e,
                delta_e_mean: error.delta_e,
                luminance_max: error.luminance,
                chromaticity_max: error.chromaticity,
                relative_rmse: squared.sqrt(),
                compared: 1,
            });
        }
        sum
    }

    /// The errors of both sets of colours together.
    pub fn and(&self, other: &Self) -> Self {
        let compared = self.compared + other.compared;
        let share = |part: &Self| if compared == 0 { 0.0 } else { part.compared as f64 / compared as f64 };
        let mean = |a: f64, b: f64| a * share(self) + b * share(other);
        Self {
            delta_e_max: worse(self.delta_e_max, other.delta_e_max),
            delta_e_mean: mean(self.delta_e_mean, other.delta_e_mean),
            luminance_max: worse(self.luminance_max, other.luminance_max),
            chromaticity_max: worse(self.chromaticity_max, other.chromaticity_max),
            relative_rmse: mean(self.relative_rmse.powi(2), other.relative_rmse.powi(2)).sqrt(),
            compared,
        }
    }
}

/// The larger of two errors, or a NaN if one of them is.
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Differences of radiances from a reference, over many directions and wavelengths.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct RadianceError {
    /// Root of the mean squared difference, in the unit of the radiance.
    pub rmse: f64,
    /// The same, divided by the mean of the reference.
    pub over_mean: f64,
    /// The same, divided by the largest value of the reference.
    pub over_max: f64,
}

impl RadianceError {
    /// The error of radiances, each against its reference.
    pub fn of(pairs: &[(f64, f64)]) -> Self {
        let count = pairs.len() as f64;
        let rmse = (pairs.iter().map(|(value, reference)| (value - reference).powi(2)).sum::<f64>() / count).sqrt();
        let mean = pairs.iter().map(|pair| pair.1).sum::<f64>() / count;
        let max = pairs.iter().map(|pair| pair.1).fold(0.0, f64::max);
        Self { rmse, over_mean: rmse / mean, over_max: rmse / max }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ciede2000_reproduces_the_published_pairs() {
        let rows = include_str!("../../../tests/data/ciede2000_Sharma2005.csv").lines();
        let mut compared = 0;
        for row in rows.filter(|row| !row.starts_with('#')) {
            let numbers: Vec<f64> = row.split(',').map(|field| field.parse().unwrap()).collect();
            let [l1, a1, b1, l2, a2, b2, expected] = numbers[..] else { panic!("{row}") };
            for difference in [ciede2000([l1, a1, b1], [l2, a2, b2]), ciede2000([l2, a2, b2], [l1, a1, b1])] {
                // The table is printed with four decimals.
                assert!((difference - expected).abs() < 5.1e-5, "{row}: {difference}");
            }
            compared += 1;
        }
        assert_eq!(compared, 34);
    }

    #[test]
    fn lab_has_the_values_of_its_definition() {
        assert_eq!(lab(WHITE), [100.0, 0.0, 0.0]);
        // L* of 18 % grey, and the slope 903.3 of the linear part.
        assert!((lab(WHITE * 0.18)[0] - 49.496).abs() < 1e-3);
        assert!((lab(WHITE * 1e-3)[0] - 0.903_3).abs() < 1e-4);
        // The reference shown at Y = 50 has L* = 76.07.
        assert!((lab(WHITE * SHOWN_AT)[0] - 76.069).abs() < 1e-3);
    }

    #[test]
    fn d65_has_its_published_chromaticity() {
        assert!(chromaticity(WHITE).distance(DVec2::new(0.1978, 0.4683)) < 1e-4);
    }

    #[test]
    fn an_error_of_luminance_alone_is_seen_whatever_the_scale() {
        for scale in [1e-9, 1.0, 1e9] {
            let error = ColourError::new(WHITE * scale * 1.01, WHITE * scale);
            assert!((error.luminance - 0.01).abs() < 1e-9 && error.chromaticity < 1e-9);
            // One per cent of Y at L* = 76 is 0.306 of L*, over CIEDE2000's S_L of 1.39.
            assert!((error.delta_e - 0.2204).abs() < 1e-3, "{}", error.delta_e);
        }
    }

    #[test]
    fn errors_are_gathered_and_a_nan_is_kept() {
        let pairs = [(WHITE, WHITE), (WHITE * 1.02, WHITE), (WHITE, DVec3::ZERO)];
        let errors = Errors::of(pairs);
        assert_eq!(errors.compared, 2);
        assert!((errors.luminance_max - 0.02).abs() < 1e-12);
        assert!((errors.relative_rmse - 0.02 / 2f64.sqrt()).abs() < 1e-12);
        assert!((errors.delta_e_mean - errors.delta_e_max / 2.0).abs() < 1e-12);
        let spoilt = Errors::of([(WHITE * 2.0, WHITE), (DVec3::NAN, WHITE), (WHITE, WHITE)]);
        assert!(spoilt.delta_e_max.is_nan() && spoilt.delta_e_mean.is_nan() && spoilt.luminance_max.is_nan());
    }

    #[test]
    fn the_rmse_of_radiances_has_all_three_scales() {
        let error = RadianceError::of(&[(1.0, 2.0), (5.0, 4.0)]);
        assert_eq!((error.rmse, error.over_mean, error.over_max), (1.0, 1.0 / 3.0, 0.25));
    }
}
