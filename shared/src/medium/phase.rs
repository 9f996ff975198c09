//! Phase functions: how light that is scattered spreads over directions (sr⁻¹).

use crate::geometry::Ray;
use crate::glam::{Vec3, Vec4};
use crate::math::{PI, abs, acos_beside, exp4, fetch_in, max, min, sqrt};

/// The angle by which light is scattered.
#[derive(Clone, Copy)]
pub struct ScatteringAngle {
    /// Its cosine `ν`.
    pub cosine: f32,
    /// `1 - ν`, which near the sun has more digits than the cosine.
    pub from_sun: f32,
    /// `1 + ν`, which opposite the sun has more digits.
    pub from_antisun: f32,
}

impl ScatteringAngle {
    /// The angle between a ray and the sun.
    #[inline(always)]
    pub fn of_ray(ray: Ray) -> Self {
        Self::new(ray.nu, ray.one_minus_nu_squared)
    }

    /// The angle between the unit vectors along the view and towards the sun.
    #[inline(always)]
    pub fn between(view: Vec3, sun: Vec3) -> Self {
        let cross = view.cross(sun);
        Self::new(view.dot(sun), cross.dot(cross))
    }

    /// The angle of a cosine, and of `1 - ν²` with all its digits.
    #[inline(always)]
    pub fn new(cosine: f32, sine_squared: f32) -> Self {
        let far = 1.0 + abs(cosine);
        let near = sine_squared / far;
        if cosine > 0.0 {
            Self { cosine, from_sun: near, from_antisun: far }
        } else {
            Self { cosine, from_sun: far, from_antisun: near }
        }
    }

    /// The angle itself, in `[0, π]`.
    #[inline(always)]
    pub fn radians(self) -> f32 {
        if self.cosine > 0.0 {
            acos_beside(min(self.cosine, 1.0), max(self.from_sun, 0.0))
        } else {
            PI - acos_beside(min(-self.cosine, 1.0), max(self.from_antisun, 0.0))
        }
    }
}

/// The phase function of air, `3/(16π) ((4 - ε)/3 + ε ν²)`, in sr⁻¹; its integral over the sphere is 1.
///
/// The anisotropy `ε = (1 - ρ)/(1 + ρ/2)` is 1 for Rayleigh's spheres; molecules depolarise by `ρ`, and for air `ρ` is
/// 0.028 and `ε` 0.96 (Chandrasekhar 1950; Bucholtz 1995, <https://doi.org/10.1364/AO.34.002765>, Eq. 12). Its Legendre
/// moments are `χ_0 = 1` and `χ_2 = ε/10`.
#[derive(Clone, Copy)]
pub struct AirPhase {
    /// Its value across.
    across: f32,
    /// What it grows by with the square of the cosine.
    growth: f32,
}

impl AirPhase {
    /// That of an anisotropy.
    #[inline(always)]
    pub fn new(anisotropy: f32) -> Self {
        const SCALE: f32 = 3.0 / (16.0 * PI);
        Self { across: SCALE / 3.0 * (4.0 - anisotropy), growth: SCALE * anisotropy }
    }

    /// At an angle with this cosine (sr⁻¹).
    #[inline(always)]
    pub fn at(self, nu: f32) -> f32 {
        self.across + self.growth * (nu * nu)
    }

    /// The degree of polarisation of natural light scattered by an angle with this cosine: `ε (1 - ν²)` over
    /// `(4 - ε)/3 + ε ν²` (Chandrasekhar 1950, *Radiative Transfer*, section 16), across the plane of both directions.
    #[inline(always)]
    pub fn degree_of_polarisation(self, nu: f32) -> f32 {
        self.growth * (1.0 - nu * nu) / self.at(nu)
    }
}

/// The phase function of aerosol by Cornette and Shanks (1992, <https://doi.org/10.1364/AO.31.003152>, Eq. 8), in sr⁻¹:
/// `3/(8π) (1 - g²)(1 + ν²) / ((2 + g²)(1 + g² - 2 g ν)^(3/2))`; its integral over the sphere is 1.
///
/// `ν` is the cosine of the scattering angle, `g` the asymmetry in (-1, 1).
#[derive(Clone, Copy)]
pub struct AerosolPhase {
    /// `3/(8π) (1 - g²) / (2 + g²)`.
    scale: f32,
    /// `(1 - |g|)²`.
    narrowest: f32,
    /// `2 |g|`.
    widening: f32,
    /// Whether the peak lies behind: `g < 0`.
    is_backward: bool,
}

impl AerosolPhase {
    /// That of an asymmetry.
    #[inline(always)]
    pub fn new(g: f32) -> Self {
        let strength = abs(g);
        let narrowness = 1.0 - strength;
        Self {
            scale: 3.0 / (8.0 * PI) * narrowness * (1.0 + strength) / (2.0 + g * g),
            narrowest: narrowness * narrowness,
            widening: 2.0 * strength,
            is_backward: g < 0.0,
        }
    }

    /// At an angle (sr⁻¹).
    ///
    /// `(1 - |g|)² + 2|g|(1 - |ν|)` is `1 + g² - 2gν` on the side of the peak, and keeps its digits there.
    #[inline(always)]
    pub fn at(self, angle: ScatteringAngle) -> f32 {
        let from_peak = if self.is_backward { angle.from_antisun } else { angle.from_sun };
        let spread = max(self.narrowest + self.widening * from_peak, 1e-12);
        self.scale * (1.0 + angle.cosine * angle.cosine) / (spread * sqrt(spread))
    }
}

/// Entries of a table of a phase function, at the angles `π (i / 127)²`: they crowd where a phase function has its
/// peak.
pub const PHASE_ENTRIES: usize = 128;

/// The phase function of aerosol from a table, at four wavelengths (sr⁻¹).
///
/// An entry holds the coefficients of `ln P = a + b x + c x²` in the abscissa `x = ln(λ / 550 nm)`; between two of them
/// they are straight lines over the root of the angle.
#[inline(always)]
pub fn tabulated_phase(table: &[Vec4; PHASE_ENTRIES], angle: ScatteringAngle, abscissae: Vec4) -> Vec4 {
    let along = sqrt(angle.radians() * (1.0 / PI)) * (PHASE_ENTRIES - 1) as f32;
    let first = min(along, (PHASE_ENTRIES - 2) as f32) as u32;
    let below = fetch_in(table, first as usize);
    let entry = below + (fetch_in(table, first as usize + 1) - below) * (along - first as f32);
    exp4((abscissae * entry.z + Vec4::splat(entry.y)) * abscissae + Vec4::splat(entry.x))
}

/// The phase function of air at an angle (sr⁻¹); see [`AirPhase`].
#[inline(always)]
pub fn air_phase(anisotropy: f32, nu: f32) -> f32 {
    AirPhase::new(anisotropy).at(nu)
}

/// The phase function of aerosol at an angle (sr⁻¹); see [`AerosolPhase`].
#[inline(always)]
pub fn cornette_shanks_phase(angle: ScatteringAngle, g: f32) -> f32 {
    AerosolPhase::new(g).at(angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integral_over_the_sphere(phase: impl Fn(f32) -> f32) -> f64 {
        let n = 20_000;
        let cosine = |i: u32| -1.0 + (2.0 * f64::from(i) + 1.0) / f64::from(n);
        (0..n).map(|i| f64::from(phase(cosine(i) as f32))).sum::<f64>() * 4.0 * std::f64::consts::PI / f64::from(n)
    }

    fn angle(nu: f32) -> ScatteringAngle {
        ScatteringAngle::new(nu, ((1.0 - f64::from(nu)) * (1.0 + f64::from(nu))) as f32)
    }

    /// At g = ±0.99 the peak is half a degree wide: a cosine in single precision alone lost 1.5e-3 of it.
    #[test]
    fn the_phase_function_keeps_its_digits_in_its_peak_ahead_and_behind() {
        for g in [-0.99f32, 0.99] {
            for degrees in [0.0, 0.01, 0.1, 0.3, 1.0, 90.0] {
                let (sine, cosine) = f64::to_radians(degrees).sin_cos();
                let side = if g < 0.0 { -1.0 } else { 1.0 };
                let wide = f64::from(g);
                let spread = 1.0 + wide * wide - 2.0 * wide.abs() * cosine;
                let truth = 3.0 / (8.0 * std::f64::consts::PI) * (1.0 - wide * wide) * (1.0 + cosine * cosine)
                    / ((2.0 + wide * wide) * spread.powf(1.5));
                let angle = ScatteringAngle::new((side * cosine) as f32, (sine * sine) as f32);
                let error = f64::from(cornette_shanks_phase(angle, g)) / truth - 1.0;
                // Ten roundings.
                assert!(error.abs() < 6e-7, "g = {g}, {degrees} degrees: {error:e}");
            }
        }
    }

    #[test]
    fn phase_functions_integrate_to_one() {
        // 20 000 midpoints leave 1e-8 of the peak; rounding of single precision leaves 1e-7 a term.
        for anisotropy in [1.0, 0.96, 0.5] {
            assert!((integral_over_the_sphere(|nu| air_phase(anisotropy, nu)) - 1.0).abs() < 1e-6);
        }
        for g in [-0.5, 0.0, 0.3, 0.8, 0.9] {
            let integral = integral_over_the_sphere(|nu| cornette_shanks_phase(angle(nu), g));
            // Twenty thousand terms, each rounded by 1e-7 or less.
            assert!((integral - 1.0).abs() < 2e-5, "g = {g}: {integral}");
        }
    }

    #[test]
    fn an_isotropic_asymmetry_gives_the_rayleigh_phase() {
        for nu in [-1.0, -0.3, 0.0, 0.5, 1.0] {
            assert!((cornette_shanks_phase(angle(nu), 0.0) / air_phase(1.0, nu) - 1.0).abs() < 1e-6);
        }
    }
}
