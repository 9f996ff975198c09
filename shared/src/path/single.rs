//! Light scattered once: a ray in, the transfer at each band out (Eqs. 1-3).
//!
//! Sunlight of irradiance `E(λ)` reaches a point at distance `s` along the view ray, weakened by the optical depth
//! between the top of the atmosphere and the point. There air scatters the part `β_air ρ_air P_air(ν)` of it towards
//! the observer, and aerosol the part `β_aerosol ρ_aerosol P_aerosol(ν)`; on the way it is weakened once more:
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
use crate::medium::atmosphere::{ColumnDensities, Medium};
use crate::medium::bands::{Bands, ByScatterer, Coefficients};
use crate::path::observer::{TowardsObserver, lit_place};
use crate::path::ray::Way;
use crate::path::samples::{PER_MEAN_FREE_PATH, Place, Samples};
use crate::value::Value;
use crate::variant;

/// The integrand of Eq. (1) at a lit place, with `β = 1`, `P = 1` and `E = 1`, times the weight of a sample there (km).
#[inline(always)]
pub(crate) fn integrand<V: Value>(
    medium: Medium<'_>,
    coefficients: &Coefficients<V>,
    towards_observer: TowardsObserver,
    place: Place,
    weight: f32,
    variant: u32,
) -> ByScatterer<V> {
    scattered_at(coefficients, lit_place(medium, towards_observer, place, variant), weight)
}

/// The same by what light meets there; see [`lit_place`].
#[inline(always)]
pub(crate) fn scattered_at<V: Value>(
    coefficients: &Coefficients<V>,
    (density, along): (Vec2, ColumnDensities),
    weight: f32,
) -> ByScatterer<V> {
    let transmittance = coefficients.transmittance(along).scaled(weight);
    ByScatterer { air: transmittance.scaled(density.x), aerosol: transmittance.scaled(density.y) }
}

/// Nodes of a quadrature rule: (place, weight) on [0, 1].
#[derive(Clone, Copy)]
pub(crate) struct Nodes<'a> {
    rule: &'a [Vec2],
    /// The first that is taken, and how many farther the next.
    first: usize,
    step: usize,
}

impl<'a> Nodes<'a> {
    /// All of a rule.
    #[inline(always)]
    pub(crate) fn all(rule: &'a [Vec2]) -> Self {
        Self { rule, first: 0, step: 1 }
    }
}

/// The integral over a piece; `lowest` is the altitude of the ray's lowest point (km).
#[inline(always)]
fn integrate_piece<V: Value>(
    medium: Medium<'_>,
    coefficients: &Coefficients<V>,
    nodes: Nodes<'_>,
    (ray, lowest): (Ray, f32),
    samples: Samples,
    variant: u32,
) -> ByScatterer<V> {
    let shell = medium.shell();
    let towards_observer = TowardsObserver::new(medium, ray, lowest, samples.piece.rising, variant);
    let mut sum = ByScatterer::<V>::ZERO;
    let mut i = nodes.first;
    while i < nodes.rule.len() {
        let (place, weight) = samples.at(shell, fetch(nodes.rule, i));
        let part = integrand(medium, coefficients, towards_observer, place, weight, variant);
        sum.air.add_scaled(&part.air, 1.0);
        if variant & variant::AEROSOL != 0 {
            sum.aerosol.add_scaled(&part.aerosol, 1.0);
        }
        i += nodes.step;
    }
    sum
}

/// The single-scattering integral along a ray from any altitude, inside the atmosphere or above it (Eq. 1).
///
/// The lit part of the ray is cut at its perigee and at the planet's shadow, and each piece is integrated by the same
/// `quadrature`: (node, weight) on [0, 1], Gauss-Legendre in a variable that crowds towards the piece's lowest, densest
/// end (see `path::samples`). `variant` says what the scene has; see [`variant`]. Without ozone twelve samples leave
/// 5e-4 of the radiance and sixteen 2e-5. With it, sunlight that grazes the kinks of the ozone tent slows the
/// convergence when the sun is low: sixteen then leave 7e-3, forty-eight 4e-4.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), multiversion::multiversion(targets("x86_64+avx+avx2")))]
pub fn single_scattering<'a>(
    medium: Medium<'a>,
    bands: &Bands,
    quadrature: &[Vec2],
    ray: Ray,
    variant: u32,
) -> ByScatterer<Vec4> {
    let coefficients = &bands.coefficients();
    single_scattering_placed_for(medium, coefficients, bands, PER_MEAN_FREE_PATH, Nodes::all(quadrature), ray, variant)
}

/// What one of some lanes adds to it: every so manyth node of the quadrature is a lane's.
#[inline(always)]
pub(crate) fn single_scattering_of_lane(
    medium: Medium<'_>,
    bands: &Bands,
    quadrature: &[Vec2],
    (lane, lanes): (u32, u32),
    ray: Ray,
    variant: u32,
) -> ByScatterer<Vec4> {
    let nodes = Nodes { rule: quadrature, first: lane as usize, step: lanes as usize };
    single_scattering_placed_for(medium, &bands.coefficients(), bands, PER_MEAN_FREE_PATH, nodes, ray, variant)
}

/// The same at the bands of any value, with samples that are placed for some bands, where a mean free path of light
/// counts as much as is said; see `path::samples`.
#[inline(always)]
pub(crate) fn single_scattering_placed_for<V: Value>(
    medium: Medium<'_>,
    coefficients: &Coefficients<V>,
    placed_for: &Bands,
    per_mean_free_path: f32,
    nodes: Nodes<'_>,
    ray: Ray,
    variant: u32,
) -> ByScatterer<V> {
    let way = Way::new(medium, ray, variant);
    single_scattering_on_way(medium, coefficients, (placed_for, per_mean_free_path), nodes, way, variant)
}

/// The same on a way, or a part of one.
#[inline(always)]
pub(crate) fn single_scattering_on_way<V: Value>(
    medium: Medium<'_>,
    coefficients: &Coefficients<V>,
    (placed_for, per_mean_free_path): (&Bands, f32),
    nodes: Nodes<'_>,
    way: Way,
    variant: u32,
) -> ByScatterer<V> {
    let shell = medium.shell();
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
            let samples = Samples::new(medium, placed_for, way.ray, piece, per_mean_free_path, variant);
            let part = integrate_piece(medium, coefficients, nodes, (way.ray, way.lowest), samples, variant);
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

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;
    use crate::glam::Vec3;
    use crate::math::sqrt;
    use crate::medium::atmosphere::Atmosphere;
    use crate::medium::exponential::Exponential;
    use crate::value::Lanes;

    /// So large that a sky of air is as good as flat.
    const RADIUS: f64 = 1e6;
    const SCALE_HEIGHT: f64 = 8.0;

    fn air() -> Atmosphere {
        let air = Exponential::new(SCALE_HEIGHT, RADIUS);
        Atmosphere { air, aerosol: air, ground_radius: RADIUS as f32, depth: 120.0, ..Atmosphere::zeroed() }
    }

    fn exponential(atmosphere: &Atmosphere) -> Medium<'_> {
        Medium { atmosphere, tables: &[] }
    }

    /// A ray up from the ground and a sun in one vertical plane, by the cosines of their zenith angles.
    fn ray(mu: f32, mu_s: f32) -> Ray {
        let towards = |mu: f32| Vec3::new(sqrt(1.0 - mu * mu), 0.0, mu);
        Ray::new(0.0, towards(mu), towards(mu_s))
    }

    fn midpoints() -> Vec<Vec2> {
        (0..400).map(|i| Vec2::new((i as f32 + 0.5) / 400.0, 1.0 / 400.0)).collect()
    }

    fn bands(scattering: [f32; 4]) -> Bands {
        Bands { air_scattering: Vec4::from_array(scattering), ..Bands::zeroed() }
    }

    /// Light that is scattered once down through a plane layer of optical depth τ, without its phase function: the
    /// transmission `μ_s/(μ_s - μ) (e^(-τ/μ_s) - e^(-τ/μ))`, and `τ/μ e^(-τ/μ)` where both angles are one
    /// (Chandrasekhar 1950, §12.1).
    #[test]
    fn a_flat_layer_transmits_what_chandrasekhar_says() {
        let depths = [0.05f32, 0.3, 1.0, 2.5];
        let coefficients = depths.map(|depth| depth / SCALE_HEIGHT as f32);
        for (mu, mu_s) in [(1.0f32, 1.0f32), (0.5, 0.9), (0.8, 0.35), (0.4, 0.4)] {
            let found =
                single_scattering(exponential(&air()), &bands(coefficients), &midpoints(), ray(mu, mu_s), 0).air;
            for (found, depth) in found.to_array().into_iter().zip(depths.map(f64::from)) {
                let (mu, mu_s) = (f64::from(mu), f64::from(mu_s));
                let truth = if mu == mu_s {
                    depth / mu * (-depth / mu).exp()
                } else {
                    mu_s / (mu_s - mu) * ((-depth / mu_s).exp() - (-depth / mu).exp())
                };
                // The curvature bends slants by H/R (1/μ² - 1), 4e-5 of an optical depth of up to 7; the
                // midpoints leave 1e-4.
                assert!((f64::from(found) / truth - 1.0).abs() < 1e-3, "{mu}, {mu_s}, {depth}: {found}, not {truth}");
            }
        }
    }

    #[test]
    fn what_lanes_add_is_the_integral() {
        let bands = bands([0.002, 0.01, 0.03, 0.2]);
        let (rule, ray) = (&midpoints()[..21], ray(0.3, 0.6));
        let air = air();
        let whole = single_scattering(exponential(&air), &bands, rule, ray, 0).air;
        let of_lane = |lane| single_scattering_of_lane(exponential(&air), &bands, rule, (lane, 8), ray, 0).air;
        let sum = (0..8).map(of_lane).fold(Vec4::ZERO, |sum, part| sum + part);
        // Another order of 21 terms, each rounded by 6e-8.
        assert!(((sum - whole) / whole).abs().max_element() < 1e-6, "{sum}, not {whole}");
        assert!(((of_lane(0) - whole) / whole).abs().min_element() > 0.5, "negative control");
    }

    #[test]
    fn many_wavelengths_are_integrated_as_four_bands_are() {
        let bands = bands([0.002, 0.01, 0.03, 0.2]);
        let four = single_scattering(exponential(&air()), &bands, &midpoints(), ray(0.3, 0.6), 0).air;
        let lanes = |value: Vec4| Lanes(core::array::from_fn::<f32, 8, _>(|i| value.to_array()[i % 4]));
        let coefficients = Coefficients {
            air_scattering: lanes(bands.air_scattering),
            aerosol_scattering: Lanes::ZERO,
            aerosol_extinction: Lanes::ZERO,
            ozone_absorption: Lanes::ZERO,
            pair_absorption: Lanes::ZERO,
            water_absorption: Lanes::ZERO,
        };
        let crowding = PER_MEAN_FREE_PATH;
        let many = single_scattering_placed_for(
            exponential(&air()),
            &coefficients,
            &bands,
            crowding,
            Nodes::all(&midpoints()),
            ray(0.3, 0.6),
            0,
        )
        .air;
        // A processor's exponentials are the same numbers whatever stands beside them.
        assert_eq!(many, lanes(four));
    }
}
