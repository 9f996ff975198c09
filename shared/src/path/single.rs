//! Light scattered once: a ray in, the transfer at each band out (Eqs. 1-3).
//!
//! Sunlight of irradiance `E(λ)` reaches a point at distance `s` along the view ray, weakened by the optical depth between the
//! top of the atmosphere and the point. There air scatters the part `β_air ρ_air P_air(ν)` of it towards the observer, and
//! aerosol the part `β_aerosol ρ_aerosol P_aerosol(ν)`; on the way it is weakened once more:
//!
//! ```text
//! L(λ) = E(λ) ∫ Σ_c β_c(λ) ρ_c(h) P_c(ν) exp(-τ(sun → s; λ) - τ(s → observer; λ)) ds        (Eq. 1)
//! τ(λ) = Σ_c β_c,ext(λ) ∫ ρ_c(h) ds                                                        (Eq. 2)
//! β_air(λ) = 4π k / λ⁴                                                                     (Eq. 3)
//! ```
//!
//! The integral runs over the part of the ray that the sun lights. Phase functions do not change along a ray, so the
//! integral of each constituent is returned without its phase function. The host makes the coefficients of Eq. (3).

use crate::geometry::Ray;
use crate::glam::{Vec2, Vec4};
use crate::math::fetch;
use crate::medium::atmosphere::Atmosphere;
use crate::medium::bands::{Bands, ByScatterer, Coefficients};
use crate::path::observer::{TowardsObserver, lit_place};
use crate::path::ray::Way;
use crate::path::samples::{PER_MEAN_FREE_PATH, Place, Samples};
use crate::value::Value;
use crate::variant;

/// The integrand of Eq. (1) at a lit place, with `β = 1`, `P = 1` and `E = 1`, times the weight of a sample there (km).
#[inline(always)]
pub(crate) fn integrand<V: Value>(
    atmosphere: &Atmosphere,
    coefficients: &Coefficients<V>,
    towards_observer: TowardsObserver,
    place: Place,
    weight: f32,
    variant: u32,
) -> ByScatterer<V> {
    let (density, along) = lit_place(atmosphere, towards_observer, place, variant);
    let transmittance = coefficients.transmittance(along).scaled(weight);
    ByScatterer { air: transmittance.scaled(density.x), aerosol: transmittance.scaled(density.y) }
}

/// The integral over a piece; `lowest` is the altitude of the ray's lowest point (km).
#[inline(always)]
fn integrate_piece<V: Value>(
    atmosphere: &Atmosphere,
    coefficients: &Coefficients<V>,
    quadrature: &[Vec2],
    (ray, lowest): (Ray, f32),
    samples: Samples,
    variant: u32,
) -> ByScatterer<V> {
    let shell = atmosphere.shell();
    let towards_observer = TowardsObserver::new(atmosphere, ray, lowest, samples.piece.rising, variant);
    let mut sum = ByScatterer::<V>::ZERO;
    let mut i = 0;
    loop {
        let (place, weight) = samples.at(shell, fetch(quadrature, i));
        let part = integrand(atmosphere, coefficients, towards_observer, place, weight, variant);
        sum.air.add_scaled(&part.air, 1.0);
        if variant & variant::AEROSOL != 0 {
            sum.aerosol.add_scaled(&part.aerosol, 1.0);
        }
        i += 1;
        if i >= quadrature.len() {
            break;
        }
    }
    sum
}

/// The single-scattering integral along a ray from any altitude, inside the atmosphere or above it (Eq. 1).
///
/// The lit part of the ray is cut at its perigee and at the planet's shadow, and each piece is integrated by the same
/// `quadrature`: (node, weight) on [0, 1], Gauss-Legendre in a variable that crowds towards the piece's lowest, densest end (see
/// `crowding`). `variant` says what the scene has; see [`variant`]. Without ozone twelve samples
/// leave 5e-4 of the radiance and sixteen 2e-5. With it, sunlight that grazes the kinks of the ozone tent slows the
/// convergence when the sun is low: sixteen then leave 7e-3, forty-eight 4e-4.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), multiversion::multiversion(targets("x86_64+avx+avx2")))]
pub fn single_scattering(
    atmosphere: &Atmosphere,
    bands: &Bands,
    quadrature: &[Vec2],
    ray: Ray,
    variant: u32,
) -> ByScatterer<Vec4> {
    let coefficients = &bands.coefficients();
    single_scattering_placed_for(atmosphere, coefficients, bands, PER_MEAN_FREE_PATH, quadrature, ray, variant)
}

/// The same at the bands of any value, with samples that are placed for some bands, where a mean free path of light counts as much
/// as is said; see `crowding`.
#[inline(always)]
pub(crate) fn single_scattering_placed_for<V: Value>(
    atmosphere: &Atmosphere,
    coefficients: &Coefficients<V>,
    placed_for: &Bands,
    per_mean_free_path: f32,
    quadrature: &[Vec2],
    ray: Ray,
    variant: u32,
) -> ByScatterer<V> {
    let shell = atmosphere.shell();
    let way = Way::new(shell, ray, variant);
    let mut sum = ByScatterer::<V>::ZERO;
    // Before or behind the shadow, falling or rising: at most three of the four pieces are not empty.
    let mut index = if variant & variant::DESCENT != 0 { 0 } else { 1 };
    let step = if variant & variant::DESCENT != 0 { 1 } else { 2 };
    let pieces = if variant & variant::SHADOW != 0 { 4 } else { 2 };
    let is_single = variant & (variant::DESCENT | variant::SHADOW) == 0;
    loop {
        let rising = is_single | (index & 1 == 1);
        let interval = way.lit(index & 2 == 2, rising);
        if interval.end > interval.start {
            let piece = way.piece(shell, interval, rising, variant);
            let samples = Samples::new(atmosphere, placed_for, way.ray, piece, per_mean_free_path, variant);
            let part = integrate_piece(atmosphere, coefficients, quadrature, (way.ray, way.lowest), samples, variant);
            sum.air.add_scaled(&part.air, 1.0);
            sum.aerosol.add_scaled(&part.aerosol, 1.0);
        }
        index += step;
        // Of one piece the compiler keeps no loop.
        if is_single | (index >= pieces) {
            break;
        }
    }
    ByScatterer {
        air: sum.air.times(&coefficients.air_scattering),
        aerosol: sum.aerosol.times(&coefficients.aerosol_scattering),
    }
}
