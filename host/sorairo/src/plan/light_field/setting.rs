//! What a light field depends on beside the wavelength.

use std::f64::consts::FRAC_PI_2;

use sorairo_shared::light_field::polarisation::Coupling;
use sorairo_shared::medium::atmosphere::Medium;
use sorairo_shared::medium::bands::{Bands, ByScatterer};
use sorairo_shared::variant;

use crate::medium::aerosol::Phase;
use crate::plan::light_field::suns::{Centre, sun_nodes};
use crate::plan::rays::directions::horizon;

/// The highest degree of a moment that a table may hold.
pub(crate) const HIGHEST_DEGREE: usize = 40;

/// What a light field depends on beside the wavelength.
#[derive(Clone, Debug)]
pub struct Setting<'a> {
    /// What fills the air.
    pub(crate) medium: Medium<'a>,
    /// What the integral must not skip for any ray of the table.
    pub(crate) variant: u32,
    /// Altitude of the observer (km).
    pub(crate) altitude: f64,
    /// For which the samples of a ray are placed.
    pub(crate) placed_for: Bands,
    /// Zenith angle of the sun (radians).
    pub(crate) sun: f64,
    /// The sun about which the table's stand.
    pub(crate) centre: Centre,
    /// Zenith angles of the table's suns (radians); see [`sun_nodes`].
    pub(crate) suns: Vec<f64>,
    /// `χ_2` of air.
    pub(crate) air: f32,
    /// `χ_l` of aerosol without its forward peak; empty without aerosol.
    pub(crate) aerosol: Vec<f32>,
    /// The forward peak: the part of the light scattered by aerosol that counts as not scattered.
    pub(crate) forward_peak: f64,
    /// How air and aerosol couple the moments of polarised light; none where light is taken as natural.
    pub(crate) couplings: Option<Couplings>,
}

/// How air and aerosol, without its forward peak, couple the moments of polarised light.
pub type Couplings = ByScatterer<Coupling>;

/// The phase function of aerosol as light scattered more than once takes it: moments of what is left without a forward
/// peak, which counts as no scattering (delta-M, Wiscombe 1977,
/// <https://doi.org/10.1175/1520-0469(1977)034%3C1408:TDMRYA%3E2.0.CO;2>). What such moments hold has no peak.
pub struct AerosolMoments {
    /// `χ_l = (χ_l' - f) / (1 - f)` of the whole phase function's `χ_l'`.
    pub chi: Vec<f64>,
    /// `f`, in [0, 1).
    pub peak: f64,
}

impl AerosolMoments {
    /// For an asymmetry in (-1, 1), or for a phase function that is tabulated.
    pub fn new(asymmetry: f32, phase: Option<&Phase>) -> Self {
        /// The degree up to which moments are kept where the phase function has a peak, and the asymmetry at which it
        /// begins to have one: what is left has as much in that degree as there.
        const DEGREE: usize = 20;
        const ASYMMETRY: f64 = 0.8;
        /// A peak of less of what aerosol scatters is none, and from five times as much on it is whole.
        const LEAST: f64 = 0.002;
        let known = phase.map(|phase| phase.moments(HIGHEST_DEGREE).to_vec());
        let whole = known.unwrap_or_else(|| cornette_shanks_moments(f64::from(asymmetry), HIGHEST_DEGREE));
        if phase.is_none() && f64::from(asymmetry) <= ASYMMETRY {
            return Self { chi: whole, peak: 0.0 };
        }
        let left = cornette_shanks_moments(ASYMMETRY, DEGREE)[DEGREE];
        let whole_peak = (whole[DEGREE] - left) / (1.0 - left);
        let peak = whole_peak.min(1.25 * (whole_peak - LEAST)).max(0.0);
        Self { chi: whole.into_iter().map(|chi| (chi - peak).max(0.0) / (1.0 - peak)).collect(), peak }
    }
}

impl<'a> Setting<'a> {
    /// For what fills the air, the bands for which samples are placed, what the integral of its light scattered once
    /// must not skip (see [`variant`]), an observer's altitude (km) and the sun's elevation (radians).
    pub fn new(
        medium: Medium<'a>,
        (placed_for, phase): (Bands, Option<&Phase>),
        integral: u32,
        altitude: f64,
        sun_elevation: f64,
    ) -> Self {
        let atmosphere = medium.atmosphere;
        let AerosolMoments { chi, peak } = AerosolMoments::new(atmosphere.aerosol_asymmetry, phase);
        let (aerosol, forward_peak) = if integral & variant::AEROSOL == 0 {
            (Vec::new(), 0.0)
        } else {
            (chi.into_iter().map(|moment| moment as f32).collect(), peak)
        };
        let sun = FRAC_PI_2 - sun_elevation;
        let centre = Centre::nearest(atmosphere, altitude, sun);
        let suns = sun_nodes(atmosphere, altitude, centre.angle);
        let top = -horizon(f64::from(atmosphere.ground_radius), f64::from(atmosphere.depth));
        // A ray of the table crosses at most twice what the top of the atmosphere sees to its horizon.
        let meets_low_suns = suns.last().is_some_and(|darkest| darkest + 2.0 * top >= FRAC_PI_2);
        const LOW: u32 = variant::SHADOW | variant::LOW_SUN;
        Self {
            medium,
            variant: integral & !LOW | variant::DESCENT | if meets_low_suns { LOW } else { 0 },
            altitude,
            placed_for,
            sun,
            centre,
            suns,
            air: 0.1 * atmosphere.air_anisotropy,
            aerosol,
            forward_peak,
            couplings: None,
        }
    }

    /// The same of polarised light, which aerosol without its forward peak couples so.
    pub fn polarised(self, aerosol: Coupling) -> Self {
        let air = Coupling::of_dipoles(self.medium.atmosphere.air_anisotropy);
        Self { couplings: Some(ByScatterer { air, aerosol }), ..self }
    }

    /// Bands whose scattering by aerosol is without the forward peak, as their extinction is.
    pub(crate) fn without_peak(&self, bands: &[Bands]) -> Vec<Bands> {
        let left = 1.0 - self.forward_peak as f32;
        bands.iter().map(|&bands| Bands { aerosol_scattering: bands.aerosol_scattering * left, ..bands }).collect()
    }

    /// Elevations (degrees) of the suns that have the same light field: the lowest, the middle, the highest.
    pub fn suns_of_light_field(&self) -> [f64; 3] {
        self.centre.elevations()
    }
}

/// Legendre moments `χ_l` of the phase function of Cornette and Shanks (1992) with an asymmetry, up to a degree: those
/// of Henyey and Greenstein, `g^l`, times `1 + ν²`.
///
/// With `a_l = (l + 1)/(2l + 1)` and `b_l = l/(2l + 1)`:
/// `χ_l = 3/(2(2 + g²)) [g^l (1 + a_l b_{l+1} + b_l a_{l-1}) + a_l a_{l+1} g^{l+2} + b_l b_{l-1} g^{l-2}]`.
fn cornette_shanks_moments(g: f64, degree: usize) -> Vec<f64> {
    let a = |l: f64| (l + 1.0) / (2.0 * l + 1.0);
    let b = |l: f64| l / (2.0 * l + 1.0);
    let power = |l: i32| g.powi(l);
    let moment = |l: usize| {
        let (n, f) = (l as i32, l as f64);
        let same = power(n) * (1.0 + a(f) * b(f + 1.0) + if l > 0 { b(f) * a(f - 1.0) } else { 0.0 });
        let above = a(f) * a(f + 1.0) * power(n + 2);
        let below = if l > 1 { b(f) * b(f - 1.0) * power(n - 2) } else { 0.0 };
        1.5 / (2.0 + g * g) * (same + above + below)
    };
    (0..=degree).map(moment).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::rays::quadrature::gauss_legendre;

    #[test]
    fn moments_of_a_phase_function_are_its_integrals() {
        for g in [-0.6f64, 0.0, 0.3, 0.8] {
            let moments = cornette_shanks_moments(g, 8);
            let phase = |nu: f64| {
                1.5 * (1.0 - g * g) * (1.0 + nu * nu) / ((2.0 + g * g) * (1.0 + g * g - 2.0 * g * nu).powf(1.5)) * 0.5
            };
            for (l, moment) in moments.iter().enumerate() {
                let integral: f64 = gauss_legendre(64)
                    .iter()
                    .map(|node| {
                        let nu = 2.0 * f64::from(node.x) - 1.0;
                        let (mut before, mut value) = (0.0, 1.0);
                        for k in 0..l {
                            let k = k as f64;
                            (before, value) = (value, ((2.0 * k + 1.0) * nu * value - k * before) / (k + 1.0));
                        }
                        2.0 * f64::from(node.y) * phase(nu) * value
                    })
                    .sum();
                // Nodes and weights are rounded to single precision, where the peak is steep.
                assert!((integral - moment).abs() < 2e-5, "g = {g}, l = {l}: {integral}, not {moment}");
            }
        }
    }
}
