//! The α-opic quantities of CIE S 026:2018, *System for metrology of optical radiation for ipRGC-influenced responses
//! to light* (DOI 10.25039/S026.2018): light as each of the five kinds of photoreceptors in the eye weights it.

use strum::IntoStaticStr;

use super::measured;

/// Wavelengths over which the standard sums (nm), by 1 nm.
const RANGE: (u32, u32) = (380, 780);

/// An α-opic quantity, by photoreceptor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[non_exhaustive]
pub enum AlphaOpic {
    /// Of the S-cones.
    SConeOpic,
    /// Of the M-cones.
    MConeOpic,
    /// Of the L-cones.
    LConeOpic,
    /// Of the rods.
    Rhodopic,
    /// Of the ganglion cells that hold melanopsin.
    Melanopic,
}

impl AlphaOpic {
    /// All five, in the order of the standard's table.
    pub const fn all() -> [Self; 5] {
        [Self::SConeOpic, Self::MConeOpic, Self::LConeOpic, Self::Rhodopic, Self::Melanopic]
    }

    /// Its name, such as `melanopic`.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// The α-opic irradiance (W·m⁻²) of a spectrum whose values at [`wavelengths`] are given (W·m⁻²·nm⁻¹):
    /// `E = Σ E_λ(λ) s_α(λ) Δλ`.
    pub fn of_samples(self, spectrum: &[f64]) -> f64 {
        wavelengths()
            .iter()
            .zip(spectrum)
            .map(|(&nm, value)| measured::alpha_opic().at(nm)[self as usize] * value)
            .sum()
    }

    /// The α-opic equivalent daylight illuminance, EDI (lx), of an α-opic irradiance (W·m⁻²): that of daylight D65
    /// which has the same.
    pub fn equivalent_daylight(self, irradiance: f64) -> f64 {
        irradiance / self.efficacy_of_daylight()
    }

    /// The α-opic efficacy of luminous radiation of daylight D65 (W·lm⁻¹), as the standard states it.
    pub fn efficacy_of_daylight(self) -> f64 {
        1e-3 * match self {
            Self::SConeOpic => 0.8173,
            Self::MConeOpic => 1.4558,
            Self::LConeOpic => 1.6289,
            Self::Rhodopic => 1.4497,
            Self::Melanopic => 1.3262,
        }
    }
}

/// The wavelengths of the standard's sums (nm).
pub fn wavelengths() -> Vec<f64> {
    (RANGE.0..=RANGE.1).map(f64::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_action_spectrum_is_1_at_the_peak_that_the_standard_has() {
        for (i, peak) in [448.0, 541.0, 569.0, 507.0, 490.0].into_iter().enumerate() {
            let highest = measured::alpha_opic().rows().map(|(_, values)| values[i]).fold(0.0, f64::max);
            // The peak may lie between two rows.
            let found = measured::alpha_opic().at(peak)[i];
            assert!(found == highest && (found - 1.0).abs() < 1e-4, "{:?}: {found}, {highest}", AlphaOpic::all()[i]);
        }
    }

    #[test]
    fn a_quantity_has_the_name_of_the_standard() {
        let names = AlphaOpic::all().map(AlphaOpic::name);
        assert_eq!(names, ["s_cone_opic", "m_cone_opic", "l_cone_opic", "rhodopic", "melanopic"]);
    }
}
