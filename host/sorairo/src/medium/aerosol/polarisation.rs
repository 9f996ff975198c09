//! How aerosol polarises light.
//!
//! Of the scattering matrix a kind has `F11`, its phase function, and `F12` ([`Phase::degree`]). Spheres have `F22 =
//! F11`, and `F33` is taken as that of a dipole is relative to its `F11`: what goes ahead keeps its polarisation. An
//! aerosol that numbers describe, Cornette and Shanks' phase function, is Henyey and Greenstein's times the matrix of a
//! dipole, which polarises a part of what a dipole does.

use std::f64::consts::PI;

use sorairo_shared::light_field::polarisation::Coupling;

use super::phase::Phase;

/// The degree of polarisation of light that an aerosol without a table scatters by 90°: that of OPAC's continental
/// average at 550 nm (.399; Hess, Koepke and Schult 1998).
const ACROSS: f64 = 0.4;

/// `-F12/F11`, the degree of polarisation of natural light scattered once, at a scattering angle (radians) and a
/// wavelength (nm).
pub fn degree(phase: Option<&Phase>, angle: f64, wavelength: f64) -> f64 {
    let of_table = phase.and_then(|phase| phase.degree(angle, wavelength));
    of_table.unwrap_or_else(|| {
        let square = angle.cos().powi(2);
        ACROSS * (1.0 - square) / (1.0 + square)
    })
}

/// The coupling of the moments of polarised light at 550 nm, without a forward peak of a part `peak` of what is
/// scattered, which counts as no scattering. `phase` is the phase function (sr⁻¹) at an angle (radians).
///
/// ```text
/// 10/6 α = 5/12 ∫ ((F22 + F33) ((1 + c)/2)² + (F22 - F33) ((1 - c)/2)²) dc,   -10/√6 γ = -5/4 ∫ F12 (1 - c²) dc
/// ```
///
/// with the cosine `c` of the angle and `F11` of mean 1 over the sphere.
pub fn coupling(phase: impl Fn(f64) -> f64, degree: impl Fn(f64) -> f64, peak: f64) -> Coupling {
    // Angles crowd ahead, as in the moments of a phase function.
    const ANGLES: usize = 2000;
    let (mut whole, mut of_polarised, mut of_both) = (0.0, 0.0, 0.0);
    for i in 0..ANGLES {
        let root = (i as f64 + 0.5) / ANGLES as f64;
        let angle = PI * root * root;
        let (sine, cosine) = angle.sin_cos();
        let f11 = phase(angle) * sine * root;
        let f33 = f11 * 2.0 * cosine / (1.0 + cosine * cosine);
        let (ahead, behind) = (0.25 * (1.0 + cosine).powi(2), 0.25 * (1.0 - cosine).powi(2));
        whole += f11;
        of_polarised += (f11 + f33) * ahead + (f11 - f33) * behind;
        of_both += degree(angle) * f11 * sine * sine;
    }
    // The mean of F11 over the sphere is half its integral over the cosine.
    let scale = 2.0 / whole;
    let alpha = 0.6 * 5.0 / 12.0 * scale * of_polarised;
    let gamma = -0.1 * 6.0f64.sqrt() * 1.25 * scale * of_both;
    Coupling { gamma: (gamma / (1.0 - peak)) as f32, alpha: ((alpha - peak) / (1.0 - peak)) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dipoles_have_the_coupling_of_dipoles() {
        let rayleigh = |angle: f64| 1.0 + angle.cos().powi(2);
        let degree = |angle: f64| angle.sin().powi(2) / (1.0 + angle.cos().powi(2));
        let (found, expected) = (coupling(rayleigh, degree, 0.0), Coupling::of_dipoles(1.0));
        // Two thousand midpoints.
        assert!(
            (found.gamma - expected.gamma).abs() < 1e-5 && (found.alpha - expected.alpha).abs() < 1e-5,
            "{found:?}"
        );
    }

    /// What goes straight ahead keeps its polarisation, as light that was not scattered does.
    #[test]
    fn a_peak_ahead_is_no_scattering() {
        let peaked = |angle: f64| (-(angle / 0.02).powi(2)).exp();
        let found = coupling(peaked, |_| 0.0, 0.0);
        assert!((found.alpha - 1.0).abs() < 1e-3 && found.gamma == 0.0, "{found:?}");
    }
}
