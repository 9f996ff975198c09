//! The colour observer: samples of the colour-matching functions over the visible range.

use serde::{Deserialize, Serialize};
use sorairo_shared::fit::observer::OBSERVER_NODES;
use sorairo_shared::glam::DVec3;
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

use super::measured;
pub use super::range::{END, START, STEP};

/// A colour observer.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum ColourObserver {
    /// The CIE 1931 2° standard observer, the basis of displays.
    #[default]
    Cie1931,
    /// The CIE 2015 2° observer, from the measured sensitivities of the cones.
    Cie2015,
}

impl ColourObserver {
    /// The name by which documents call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cie1931 => "CIE 1931 2° observer",
            Self::Cie2015 => "CIE 2015 2° observer",
        }
    }
}

/// Luminous efficacy of radiation of luminance 1 to the observer (lm/W; the SI's constant K_cd).
pub const LUMENS_PER_WATT: f64 = 683.0;

/// Wavelengths of the observer nodes (nm).
pub fn wavelengths() -> Vec<f64> {
    (0..OBSERVER_NODES).map(|i| START + STEP * f64::from(i)).collect()
}

/// The width (nm) of the interval that belongs to a node, by the trapezoidal rule: half of one to each end of the
/// range.
pub fn width(wavelength: f64) -> f64 {
    if wavelength == START || wavelength == END { 0.5 * STEP } else { STEP }
}

/// The weights (x̄ Δλ, ȳ Δλ, z̄ Δλ) of the sample at a wavelength (nm), in nm; zero where the observer's table does not
/// reach.
pub fn weights(observer: ColourObserver, wavelength: f64) -> DVec3 {
    let table = match observer {
        ColourObserver::Cie1931 => measured::cie1931(),
        ColourObserver::Cie2015 => measured::cie2015(),
    };
    if table.covers(wavelength) { DVec3::from_array(table.at(wavelength)) * STEP } else { DVec3::ZERO }
}

/// XYZ of a spectrum: its sum over the observer nodes, in the spectrum's unit times nm.
pub fn xyz(observer: ColourObserver, spectrum: impl Fn(f64) -> f64) -> DVec3 {
    wavelengths().into_iter().map(|wavelength| weights(observer, wavelength) * spectrum(wavelength)).sum()
}

/// XYZ of a spectrum whose values at the observer nodes are given, in its unit times nm.
pub fn xyz_of_samples(observer: ColourObserver, spectrum: &[f64]) -> DVec3 {
    wavelengths().into_iter().zip(spectrum).map(|(wavelength, &value)| weights(observer, wavelength) * value).sum()
}

/// Maps the observer's range to [-1, 1]. At the paper's bands the Vandermonde matrix in nm has a condition number of
/// 1.1e11 in the maximum norm, on these of 40.
pub fn normalised(wavelength: f64) -> f64 {
    (wavelength - (START + END) / 2.0) / ((END - START) / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_energy_is_white_to_either_observer() {
        for observer in [ColourObserver::Cie1931, ColourObserver::Cie2015] {
            let white = xyz(observer, |_| 1.0);
            // The functions of each have the same area: CIE 15:2018 to 1e-4 with its 1 nm table, and the ends of the
            // range that the 5 nm sum leaves out, and what CIE 2015 lacks below 390 nm.
            assert!((white / white.y - DVec3::ONE).abs().max_element() < 1e-3, "{observer:?}: {white}");
        }
    }

    #[test]
    fn an_observer_sees_nothing_beyond_its_table() {
        assert_eq!(weights(ColourObserver::Cie2015, 385.0), DVec3::ZERO);
        assert!(weights(ColourObserver::Cie2015, 390.0).min_element() > 0.0);
        assert!(weights(ColourObserver::Cie1931, 385.0).min_element() > 0.0);
    }
}
