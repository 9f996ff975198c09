//! Linear polarisation of a light field: its second moments, and how scattering couples them with those of radiance.
//!
//! The Stokes vector of light seen in a direction `v` is `(I, Q, U)`: `Q > 0` where its electric vector lies in the
//! vertical plane through `v`, `U > 0` where it lies 45° counterclockwise of it as the observer sees it. Along a
//! straight ray that plane is the same everywhere, so that `I`, `Q` and `U` add up without a rotation.
//!
//! A dipole keeps of the light around it the coherency tensor, which is the moments `L_00` and `L_2m` of `I` and three
//! moments more by the symmetry about the plane through the sun:
//!
//! ```text
//! E_2m = ∫ (Q W_m cos(m φ) + U X_m sin(m φ)) dv,   m = 0, 1, 2
//! W = c (√3 s²/√2, -√2 μ s, (1 + μ²)/√2),   X = c (0, -√2 s, √2 μ),   c = √(5/(16π))
//! ```
//!
//! with `μ` and `s` the cosine and the sine of the zenith angle: harmonics of spin 2 and of even parity (Zaldarriaga
//! and Seljak 1997, <https://doi.org/10.1103/PhysRevD.55.1830>, Eqs. 6-10, where the other signs are a matter of
//! frames). What is scattered is again a sum of these functions, with the coefficients
//!
//! ```text
//! I_lm: χ_l L_lm + δ_l2 γ E_2m,   E_2m: γ L_2m + α E_2m
//! ```
//!
//! `χ_2`, `γ` and `α` are a fifth of the Greek constants `β_2`, `γ_2` and `α_2` (Siewert 1982, Astron. Astrophys. 109,
//! 195; Hovenier and van der Mee 1983, Astron. Astrophys. 128, 1). Of molecules that is all there is, exactly; of
//! aerosol the degrees above 2 of `Q` and `U` are left out.

use crate::math::{PI, sqrt};

/// Moments `E_2m` of a light field.
pub const MOMENTS: usize = 3;

/// How a scatterer couples the second moments of polarised light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coupling {
    /// Of `L_2m` with `E_2m`, both ways.
    pub gamma: f32,
    /// Of `E_2m` with itself.
    pub alpha: f32,
}

impl Coupling {
    /// That of molecules with an anisotropy; see [`crate::medium::phase::AirPhase`].
    pub fn of_dipoles(anisotropy: f32) -> Self {
        Self { gamma: -0.1 * sqrt(6.0) * anisotropy, alpha: 0.6 * anisotropy }
    }
}

/// `W_m` and `X_m` of a direction.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpinFunctions {
    /// `W_m`, of `Q`.
    pub w: [f32; MOMENTS],
    /// `X_m`, of `U`.
    pub x: [f32; MOMENTS],
}

impl SpinFunctions {
    /// Of the cosine and the sine of a zenith angle.
    #[inline(always)]
    pub fn new(mu: f32, sine: f32) -> Self {
        let scale = sqrt(5.0 / (16.0 * PI));
        let (root2, root3) = (sqrt(2.0) * scale, sqrt(1.5) * scale);
        Self {
            w: [root3 * sine * sine, -root2 * mu * sine, 0.5 * root2 * (1.0 + mu * mu)],
            x: [0.0, -root2 * sine, root2 * mu],
        }
    }

    /// `W_m cos(m φ)` and `X_m sin(m φ)` in an azimuth from the sun: what each coefficient adds to `Q` and to `U`.
    #[inline(always)]
    pub fn at_azimuth(&self, cosine: f32, sine: f32) -> [[f32; MOMENTS]; 2] {
        let ([w0, w1, w2], [_, x1, x2]) = (self.w, self.x);
        let (cosine_2, sine_2) = (2.0 * cosine * cosine - 1.0, 2.0 * sine * cosine);
        [[w0, w1 * cosine, w2 * cosine_2], [0.0, x1 * sine, x2 * sine_2]]
    }

    /// What light with the coefficients `p`, times `cos(j φ)`, adds to the moment `E_2n` in this direction: the
    /// integral over the circle of its `Q W_n cos(n φ) + U X_n sin(n φ)`.
    #[inline(always)]
    pub fn moment(&self, p: [f32; MOMENTS], n: usize, j: usize) -> f32 {
        let ([w0, w1, w2], [_, x1, x2]) = (self.w, self.x);
        let of_q = [w0 * p[0], w1 * p[1], w2 * p[2]];
        let of_u = [0.0, x1 * p[1], x2 * p[2]];
        number(self.w, n) * of_cosines(of_q, n, j) + number(self.x, n) * of_sines(of_u, n, j)
    }
}

/// One of three numbers, 0 behind them. SPIR-V has no choice between places in memory.
#[inline(always)]
pub(crate) fn number(of: [f32; MOMENTS], m: usize) -> f32 {
    if m == 0 {
        of[0]
    } else if m == 1 {
        of[1]
    } else if m == 2 {
        of[2]
    } else {
        0.0
    }
}

/// The integral over the circle of `Σ_m p_m cos(m φ)` times `cos(n φ) cos(j φ)`.
#[inline(always)]
fn of_cosines(p: [f32; MOMENTS], n: usize, j: usize) -> f32 {
    let difference = n.abs_diff(j);
    let mut both = number(p, difference) + number(p, n + j);
    if difference == 0 {
        both += p[0];
    }
    if n + j == 0 {
        both += p[0];
    }
    0.5 * PI * both
}

/// The integral over the circle of `Σ_m p_m sin(m φ)` times `sin(n φ) cos(j φ)`.
#[inline(always)]
fn of_sines(p: [f32; MOMENTS], n: usize, j: usize) -> f32 {
    // sin(m φ) sin(n φ) = (cos((m - n) φ) - cos((m + n) φ)) / 2
    let around = if j == 0 { PI } else { 0.5 * PI };
    let mut sum = 0.0;
    let mut m = 1;
    while m < MOMENTS {
        if m.abs_diff(n) == j {
            sum += number(p, m);
        }
        if m + n == j {
            sum -= number(p, m);
        }
        m += 1;
    }
    around * sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light_field::rays::functions_of_air;

    fn directions(count: usize) -> impl Iterator<Item = (f64, f64)> {
        let at = move |i: usize, from: f64, to: f64| from + (to - from) * (i as f64 + 0.5) / count as f64;
        (0..count)
            .flat_map(move |i| (0..count).map(move |j| (at(i, -1.0, 1.0), at(j, 0.0, 2.0 * std::f64::consts::PI))))
    }

    /// `Q` and `U` of light with the coefficients `p`.
    fn stokes(of: SpinFunctions, p: [f32; MOMENTS], cosine: f32, sine: f32) -> [f32; 2] {
        of.at_azimuth(cosine, sine).map(|parts| parts.iter().zip(p).map(|(part, p)| part * p).sum())
    }

    #[test]
    fn a_moment_is_the_integral_over_the_circle() {
        const COUNT: u32 = 64;
        let (of, p) = (SpinFunctions::new(0.3, 0.91f32.sqrt()), [0.7, -0.4, 1.1]);
        let seen = SpinFunctions::new(0.3, 0.91f32.sqrt());
        for n in 0..MOMENTS {
            let mut only = [0.0; MOMENTS];
            only[n] = 1.0;
            for j in 0..6 {
                let at = |i: u32| {
                    let azimuth = 2.0 * PI * (i as f32 + 0.5) / COUNT as f32;
                    let (sine, cosine) = (f64::from(azimuth).sin() as f32, f64::from(azimuth).cos() as f32);
                    let [[q, u], [w, x]] = [stokes(of, p, cosine, sine), stokes(seen, only, cosine, sine)];
                    (q * w + u * x) * (f64::from(azimuth) * j as f64).cos() as f32
                };
                let integral = (0..COUNT).map(at).sum::<f32>() * 2.0 * PI / COUNT as f32;
                // Midpoints are exact for these multiples; 64 terms of up to 1, each rounded by 1e-7.
                assert!((of.moment(p, n, j) - integral).abs() < 5e-6, "{n}, {j}: {}", of.moment(p, n, j));
            }
        }
    }

    #[test]
    fn the_functions_are_orthonormal() {
        const COUNT: usize = 200;
        let mut products = [[0.0f64; MOMENTS]; MOMENTS];
        for (mu, azimuth) in directions(COUNT) {
            let of = SpinFunctions::new(mu as f32, (1.0 - mu * mu).sqrt() as f32);
            let (sine, cosine) = (azimuth.sin() as f32, azimuth.cos() as f32);
            let stokes: [[f32; 2]; MOMENTS] = core::array::from_fn(|m| {
                let mut p = [0.0; MOMENTS];
                p[m] = 1.0;
                stokes(of, p, cosine, sine)
            });
            for (a, products) in stokes.iter().zip(&mut products) {
                for (b, product) in stokes.iter().zip(products) {
                    *product +=
                        f64::from(a[0] * b[0] + a[1] * b[1]) * 4.0 * std::f64::consts::PI / (COUNT * COUNT) as f64;
                }
            }
        }
        for (a, products) in products.iter().enumerate() {
            for (b, product) in products.iter().enumerate() {
                // Midpoints leave 1e-5 of a polynomial of degree 4, single precision 1e-7 of each value.
                assert!((product - f64::from(u8::from(a == b))).abs() < 5e-5, "{a}, {b}: {product}");
            }
        }
    }

    /// The dipole that a beam of natural light shakes, seen from any side: `P T P`, without moments.
    #[test]
    fn a_dipole_polarises_sunlight_by_the_angle_to_the_sun() {
        let (sun_mu, sun_sine) = (0.6f64, 0.8f64);
        let of_sun = functions_of_air(1.0, sun_mu as f32, sun_sine as f32);
        let coupling = Coupling::of_dipoles(1.0);
        for (mu, azimuth) in directions(9) {
            let sine = (1.0 - mu * mu).sqrt();
            // The sun's components up across the ray and to its left.
            let up = sine * sun_mu - mu * azimuth.cos() * sun_sine;
            let left = -azimuth.sin() * sun_sine;
            let scale = 3.0 / (16.0 * std::f64::consts::PI);
            let expected = [scale * (left * left - up * up), -2.0 * scale * up * left];
            let p = [of_sun.y, of_sun.z, of_sun.w].map(|moment| coupling.gamma * moment);
            let of = SpinFunctions::new(mu as f32, sine as f32);
            let found = stokes(of, p, azimuth.cos() as f32, azimuth.sin() as f32);
            for (found, expected) in found.iter().zip(expected) {
                // A few roundings of numbers of 0.1.
                assert!((f64::from(*found) - expected).abs() < 1e-7, "{mu}, {azimuth}: {found}, not {expected}");
            }
        }
    }
}
