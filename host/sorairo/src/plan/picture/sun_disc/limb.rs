//! The sun is darker and redder toward its limb.

/// Radiance of the disc at a place on it, divided by that at its centre (1 at `limb_cosine` 1), for a wavelength in nm.
///
/// `limb_cosine` is the cosine of the angle to the normal of the sun's surface. Neckel 2005, *Analytical reference
/// functions F(λ) for the sun's limb darkening and its absolute continuum intensities*, Solar Physics 229, 13
/// (doi:10.1007/s11207-005-4081-z), for 385 to 1100 nm; below, as at 385 nm.
pub fn limb_darkening(wavelength: f64, limb_cosine: f64) -> f64 {
    let powers = limb_coefficients(wavelength);
    powers.iter().rev().fold(0.0, |sum, power| sum * limb_cosine + power)
}

fn limb_coefficients(wavelength: f64) -> [f64; 6] {
    let inverse = 1000.0 / wavelength.max(385.0);
    let fifth = inverse.powi(5);
    if wavelength < 422.57 {
        [
            0.09900 + 0.010643 * inverse,
            1.96884 - 0.010643 * inverse - 0.009166 * fifth,
            -2.80511 + 0.024873 * fifth,
            3.32780 - 0.029317 * fifth,
            -2.17878 + 0.018273 * fifth,
            0.58825 - 0.004663 * fifth,
        ]
    } else {
        [
            0.75267 - 0.265577 * inverse,
            0.93874 + 0.265577 * inverse - 0.004095 * fifth,
            -1.89287 + 0.012582 * fifth,
            2.42234 - 0.017117 * fifth,
            -1.71150 + 0.011977 * fifth,
            0.49062 - 0.003347 * fifth,
        ]
    }
}

/// The mean of [`limb_darkening`] over the disc: `∫ 2 μ F(μ) dμ`.
pub(super) fn mean_darkening(wavelength: f64) -> f64 {
    limb_coefficients(wavelength).iter().zip(2..).map(|(power, degree)| 2.0 * power / f64::from(degree)).sum()
}
