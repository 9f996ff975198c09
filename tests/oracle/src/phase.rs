//! Phase functions: the part of scattered light that goes each way, sr⁻¹; over all directions they are 1.

use std::f64::consts::PI;

/// Rayleigh phase function of air, sr⁻¹, with ν the cosine of the scattering angle:
/// 3/(16π) 2/(2 + ρ) (1 + ρ + (1 − ρ) ν²), for a depolarisation ρ of natural light (Chandrasekhar 1960, *Radiative Transfer*,
/// Sec. 18; Bucholtz 1995, Eqs. 12-13, DOI 10.1364/AO.34.002765). With ρ = 0 it is 3/(16π) (1 + ν²).
pub fn air_phase(depolarisation: f64, nu: f64) -> f64 {
    let rho = depolarisation;
    3.0 / (16.0 * PI) * 2.0 / (2.0 + rho) * (1.0 + rho + (1.0 - rho) * nu * nu)
}

/// Cornette-Shanks phase function of aerosol, sr⁻¹:
/// 3/(8π) (1 − g²)(1 + ν²) / ((2 + g²)(1 + g² − 2gν)^(3/2)).
pub fn aerosol_phase(asymmetry: f64, nu: f64) -> f64 {
    let g2 = asymmetry * asymmetry;
    let spread = 1.0 + g2 - 2.0 * asymmetry * nu;
    3.0 / (8.0 * PI) * (1.0 - g2) * (1.0 + nu * nu) / ((2.0 + g2) * spread * spread.sqrt())
}
