//! Functions of the azimuth as sums of cos(m φ): light that is gathered, and phase functions.

use sorairo_shared::light_field::moments::Moments;
use sorairo_shared::light_field::polarisation::{self, Coupling, SpinFunctions};
use sorairo_shared::medium::bands::ByScatterer;
use sorairo_shared::value::{Lanes, Value};

use crate::plan::light_field::setting::Setting;

/// Azimuths from the sun in the middles of equal parts of the half circle: cosines of as many multiples are orthogonal
/// there.
pub(crate) struct Azimuths {
    pub(crate) cosines: Vec<f32>,
    /// For each multiple `j` and each azimuth, what the value there adds to the amplitude of `cos(j φ)`.
    amplitudes: Vec<f32>,
}

impl Azimuths {
    pub(crate) fn new(count: usize) -> Self {
        let azimuth = |a: usize| std::f64::consts::PI * (a as f64 + 0.5) / count as f64;
        let amplitude = |j: usize, a: usize| {
            let norm = if j == 0 { 1.0 } else { 2.0 };
            (norm / count as f64 * (j as f64 * azimuth(a)).cos()) as f32
        };
        Self {
            cosines: (0..count).map(|a| azimuth(a).cos() as f32).collect(),
            amplitudes: (0..count).flat_map(|j| (0..count).map(move |a| amplitude(j, a))).collect(),
        }
    }

    /// The cosines, then the amplitudes.
    pub(crate) fn list(self) -> impl Iterator<Item = f32> {
        self.cosines.into_iter().chain(self.amplitudes)
    }

    /// What the values add to the amplitude of `cos(j φ)`.
    pub(crate) fn amplitudes(&self, j: usize) -> &[f32] {
        let count = self.cosines.len();
        &self.amplitudes[j * count..(j + 1) * count]
    }

    /// Adds to `fourier` the integrals of a function that is even in the azimuth against `cos(m φ)` over the whole
    /// circle, one for each `m`.
    pub(crate) fn add_fourier<const N: usize>(&self, values: &[Lanes<N>], fourier: &mut [Lanes<N>]) {
        for (m, integral) in fourier.iter_mut().enumerate() {
            let around = if m == 0 { 2.0 } else { 1.0 } * std::f32::consts::PI;
            for (value, amplitude) in values.iter().zip(self.amplitudes(m)) {
                integral.add_scaled(value, around * amplitude);
            }
        }
    }

    /// What `Q` and `U` at the azimuths add to the moments of polarised light in a direction.
    pub(crate) fn polarised<const N: usize>(
        &self,
        spin: SpinFunctions,
        stokes: &[[Lanes<N>; 2]],
    ) -> [Lanes<N>; polarisation::MOMENTS] {
        let part = 2.0 * std::f32::consts::PI / self.cosines.len() as f32;
        let mut moments = [Lanes::ZERO; polarisation::MOMENTS];
        for (&cosine, [q, u]) in self.cosines.iter().zip(stokes) {
            let sine = (1.0 - cosine * cosine).sqrt();
            let [of_q, of_u] = spin.at_azimuth(cosine, sine);
            for (m, moment) in moments.iter_mut().enumerate() {
                moment.add_scaled(q, part * of_q[m]);
                moment.add_scaled(u, part * of_u[m]);
            }
        }
        moments
    }
}

/// The phase functions of air and aerosol between a direction and a sun as coefficients of `cos(m φ)` in the azimuth
/// between them, by the addition theorem.
pub(crate) struct AzimuthalPhases {
    pub(crate) air: Vec<f32>,
    pub(crate) aerosol: Vec<f32>,
    /// Of polarised light `γ Y_2m` of the sun, by which both make `E_2m`; none where light is taken as natural.
    pub(crate) polarised: Option<ByScatterer<[f32; polarisation::MOMENTS]>>,
}

impl AzimuthalPhases {
    pub(crate) fn new(setting: &Setting, of: Moments, ray: &[f32], sun: &[f32]) -> Self {
        let coefficient = |m: usize, chi: &dyn Fn(usize) -> f32| {
            (of.first(m)..of.first(m + 1)).map(|at| chi(at - of.first(m) + m) * ray[at] * sun[at]).sum::<f32>()
        };
        let air = |l: usize| match l {
            0 => 1.0,
            2 => setting.air,
            _ => 0.0,
        };
        let aerosol = |l: usize| setting.aerosol.get(l).copied().unwrap_or(0.0);
        let of_sun = |Coupling { gamma, .. }: Coupling| std::array::from_fn(|m| gamma * sun[of.first(m) + 2 - m]);
        let polarised = setting.couplings;
        Self {
            polarised: polarised
                .map(|ByScatterer { air, aerosol }| ByScatterer { air: of_sun(air), aerosol: of_sun(aerosol) }),
            air: (0..=of.azimuthal.min(2)).map(|m| coefficient(m, &air)).collect(),
            aerosol: (0..=of.azimuthal).map(|m| coefficient(m, &aerosol)).collect(),
        }
    }
}

/// The integral over the circle of `Σ_m p_m cos(m φ)` times `cos(j φ) cos(n φ)`.
pub(crate) fn product(p: &[f32], n: usize, j: usize) -> f32 {
    let both = |k: usize| if k == 0 { 2.0 * p[0] } else { p.get(k).copied().unwrap_or(0.0) };
    0.5 * std::f32::consts::PI * (both(n.abs_diff(j)) + both(n + j))
}
