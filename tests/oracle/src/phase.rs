//! Phase functions: the part of scattered light that goes each way, sr⁻¹; over all directions they are 1.

use std::f64::consts::PI;

/// Rayleigh phase function of air, sr⁻¹, with ν the cosine of the scattering angle: 3/(16π) 2/(2 + ρ) (1 + ρ + (1 − ρ)
/// ν²), for a depolarisation ρ of natural light (Chandrasekhar 1960, *Radiative Transfer*, Sec. 18; Bucholtz 1995, Eqs.
/// 12-13, DOI 10.1364/AO.34.002765). With ρ = 0 it is 3/(16π) (1 + ν²).
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

/// A phase function that is given at some angles.
#[derive(Debug, PartialEq)]
pub struct PhaseRows {
    /// Angles (radians), increasing, and the logarithms of the phase function (sr⁻¹).
    rows: Vec<(f64, f64)>,
    /// Cosines of angles from 0 to π, and the part of scattered light up to each.
    parts: Vec<(f64, f64)>,
}

impl PhaseRows {
    /// That of rows of an angle (radians, from 0 to π) and a value, of whatever mean.
    pub fn new(rows: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let rows = rows.into_iter().map(|(angle, value)| (angle, value.ln())).collect();
        let mut phase = Self { rows, parts: vec![(1.0, 0.0)] };
        const STEPS: u32 = 6000;
        let angle = |i: u32| PI * (f64::from(i) / f64::from(STEPS)).powi(2);
        for i in 0..STEPS {
            let (from, to) = (angle(i), angle(i + 1));
            // Simpson's rule in the angle.
            let at = |theta: f64| phase.at_angle(theta) * theta.sin();
            let part = 2.0 * PI * (to - from) / 6.0 * (at(from) + 4.0 * at(0.5 * (from + to)) + at(to));
            let before = phase.parts[phase.parts.len() - 1].1;
            phase.parts.push((to.cos(), before + part));
        }
        let whole = phase.parts[phase.parts.len() - 1].1;
        phase.parts.iter_mut().for_each(|part| part.1 /= whole);
        phase.rows.iter_mut().for_each(|row| row.1 -= whole.ln());
        phase
    }

    fn at_angle(&self, angle: f64) -> f64 {
        let after = self.rows.partition_point(|row| row.0 <= angle).clamp(1, self.rows.len() - 1);
        let ((low, below), (high, above)) = (self.rows[after - 1], self.rows[after]);
        (below + (above - below) * (angle - low) / (high - low)).exp()
    }

    /// At an angle with the cosine ν, sr⁻¹.
    pub fn at(&self, nu: f64) -> f64 {
        self.at_angle(nu.clamp(-1.0, 1.0).acos())
    }

    /// The cosine up to whose angle a part of the scattered light goes.
    pub(crate) fn cosine_of_part(&self, part: f64) -> f64 {
        let after = self.parts.partition_point(|known| known.1 < part).clamp(1, self.parts.len() - 1);
        let ((nearer, below), (farther, above)) = (self.parts[after - 1], self.parts[after]);
        nearer + (farther - nearer) * (part - below) / (above - below)
    }
}
