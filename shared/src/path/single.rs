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

use crate::geometry::{
    self, Interval, Ray, Shell, altitude_along, altitude_from, altitude_of_lit_end, distance_to_top, inside_atmosphere,
    perigee_altitude,
};
use crate::glam::{Vec2, Vec3, Vec4};
use crate::math::{abs, fetch, max, min, sqrt};
use crate::medium::bands::{Bands, ByScatterer, Coefficients};
use crate::medium::profile::{
    Atmosphere, ColumnDensities, LowestPoint, column_densities, column_densities_of_two, equivalent_lengths,
    level_column_densities, relative_densities, stretch_column_densities, sun_column_densities,
};
use crate::value::Value;
use crate::variant;

/// A place on a ray.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    /// Distance from the ray's origin (km).
    pub(crate) distance: f32,
    /// Altitude (km).
    pub(crate) altitude: f32,
    /// Cosine of the angle between the vertical and the ray's rising direction, 0 or more.
    pub(crate) mu: f32,
    /// Cosine of the zenith angle of the sun.
    pub(crate) mu_s: f32,
}

/// What lies between the observer and the places of one piece of a ray.
#[derive(Clone, Copy)]
pub(crate) struct TowardsObserver {
    /// Altitude of the ray's origin (km).
    pub(crate) altitude: f32,
    /// Zenith cosine of the ray at its origin.
    pub(crate) mu: f32,
    /// Whether the ray rises along the piece.
    pub(crate) rising: bool,
    /// What the column densities from a place outwards are taken from (rising ray) or added to (falling ray) to give those between the
    /// observer and the place (km).
    pub(crate) offset: ColumnDensities,
    /// The lowest point between the observer and a piece on which the ray rises.
    pub(crate) lowest: LowestPoint,
}

impl TowardsObserver {
    /// For the pieces of a ray on which it rises or falls; `lowest` is the altitude of its lowest point (km).
    #[inline(always)]
    pub(crate) fn new(atmosphere: &Atmosphere, ray: Ray, lowest: f32, rising: bool, variant: u32) -> Self {
        let density = relative_densities(atmosphere, ray.altitude, variant);
        let outwards = column_densities(atmosphere, ray.altitude, density, abs(ray.mu), variant);
        let offset = if (variant & variant::DESCENT == 0) | (ray.mu >= 0.0) {
            outwards
        } else if rising {
            level_column_densities(atmosphere, lowest, variant) * 2.0 - outwards
        } else {
            -outwards
        };
        let lowest = LowestPoint { altitude: lowest, mu: max(ray.mu, 0.0) };
        Self { altitude: ray.altitude, mu: ray.mu, rising, offset, lowest }
    }

    /// Column densities between the observer and a place (km), given those from the place outwards.
    #[inline(always)]
    pub(crate) fn column_densities(
        self,
        atmosphere: &Atmosphere,
        place: Place,
        outwards: ColumnDensities,
        variant: u32,
    ) -> ColumnDensities {
        let mut between = self.offset - outwards * direction(self.rising);
        if variant & variant::OPAQUE != 0 {
            let here = LowestPoint { altitude: place.altitude, mu: place.mu };
            let lowest = if self.rising { self.lowest } else { here };
            let (altitude, mu, length) = (self.altitude, self.mu, place.distance);
            between = stretch_column_densities(atmosphere, altitude, mu, lowest, length, between, variant);
        }
        between.max(Vec3::ZERO)
    }
}

/// 1 where a ray rises, -1 where it falls.
#[inline(always)]
pub(crate) fn direction(rising: bool) -> f32 {
    if rising { 1.0 } else { -1.0 }
}

/// What light meets that is scattered once at a lit place: the relative densities of (air, aerosol) there, and the column densities
/// between the sun and the observer (km).
#[inline(always)]
pub(crate) fn lit_place(
    atmosphere: &Atmosphere,
    towards_observer: TowardsObserver,
    place: Place,
    variant: u32,
) -> (Vec2, ColumnDensities) {
    let Place { altitude, mu, mu_s, .. } = place;
    let density = relative_densities(atmosphere, altitude, variant);
    let outwards = column_densities_of_two(atmosphere, altitude, density, Vec2::new(mu, abs(mu_s)), variant);
    let to_observer = towards_observer.column_densities(atmosphere, place, outwards.first, variant);
    let to_sun = sun_column_densities(atmosphere, altitude, outwards.second, mu_s, variant);
    (density, to_observer + to_sun)
}

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

/// A lit stretch of a ray on which its altitude only rises or only falls.
#[derive(Clone, Copy)]
pub(crate) struct Piece {
    /// Distance of its low end along the ray (km).
    pub(crate) low: f32,
    /// Altitude of its low end (km).
    pub(crate) altitude: f32,
    /// Its length (km).
    pub(crate) length: f32,
    /// Whether the ray rises from the low end on, and does not fall to it.
    pub(crate) rising: bool,
}

/// How strongly the samples of a piece crowd towards its low end: `k` of the substitution
/// `s = length · u / (1 + k (1 - u))`.
///
/// The integrand falls off over the distance `D` in which the density does, or over a few mean free paths of light, whichever is shorter;
/// `k` makes the sampled variable as long as three of those. `low` is the distance of the low end along the ray. A falling ray
/// reaches its low end last: in opaque air nothing is seen of it, and the density alone counts. `mu` is the cosine of the angle between
/// the vertical and the piece at its low end; `per_mean_free_path` says how much a mean free path of light counts beside `D`.
#[inline(always)]
fn crowding(
    atmosphere: &Atmosphere,
    bands: &Bands,
    piece: Piece,
    mu: f32,
    per_mean_free_path: f32,
    variant: u32,
) -> f32 {
    let Piece { altitude, length, rising, .. } = piece;
    let g = sqrt(1.0 + altitude / atmosphere.ground_radius);
    let fall_off = equivalent_lengths(atmosphere, g, Vec2::splat(mu), variant).x;
    let density = relative_densities(atmosphere, altitude, variant);
    let extinction = bands.air_scattering * density.x + bands.aerosol_extinction * density.y;
    let strongest = if rising { max(max(extinction.x, extinction.y), max(extinction.z, extinction.w)) } else { 0.0 };
    max(0.35 * length * (1.0 / fall_off + per_mean_free_path * strongest) - 1.0, 0.0)
}

/// A sample of a piece with this length (km), crowded by `k`: its distance from the low end and its weight (km), for a quadrature node
/// (place, weight) on [0, 1].
#[inline(always)]
fn sample(length: f32, k: f32, node: Vec2) -> (f32, f32) {
    let compression = 1.0 / (1.0 + k * (1.0 - node.x));
    (length * node.x * compression, node.y * length * (1.0 + k) * compression * compression)
}

/// [`crowding`] of single scattering by the mean free path.
pub(crate) const PER_MEAN_FREE_PATH: f32 = 0.05;

/// The samples of a piece.
///
/// They are placed by their distance from the low end: altitudes there are sums of positive terms, and near the ground keep the digits
/// that they would lose as distances from an observer far above.
#[derive(Clone, Copy)]
pub(crate) struct Samples {
    pub(crate) piece: Piece,
    /// Radius at the low end (km).
    pub(crate) low_r: f32,
    /// Cosine of the angle between the vertical and the ray's rising direction at the low end.
    pub(crate) low_mu: f32,
    /// Radius times the cosine of the zenith angle of the sun at the low end (km).
    pub(crate) low_r_mu_s: f32,
    /// Cosine of the angle between the ray's rising direction and the sun.
    pub(crate) nu: f32,
    /// See [`crowding`].
    pub(crate) k: f32,
}

impl Samples {
    #[inline(always)]
    pub(crate) fn new(
        atmosphere: &Atmosphere,
        bands: &Bands,
        ray: Ray,
        piece: Piece,
        per_mean_free_path: f32,
        variant: u32,
    ) -> Self {
        let outwards = direction(piece.rising);
        let r = atmosphere.ground_radius + ray.altitude;
        let low_r = atmosphere.ground_radius + piece.altitude;
        let low_mu = max((r * ray.mu + piece.low) * outwards, 0.0) / low_r;
        let low_r_mu_s = r * ray.mu_s + piece.low * ray.nu;
        let k = crowding(atmosphere, bands, piece, low_mu, per_mean_free_path, variant);
        Self { piece, low_r, low_mu, low_r_mu_s, nu: ray.nu * outwards, k }
    }

    /// The sample at a quadrature node, (place, weight) on [0, 1], and its weight (km).
    #[inline(always)]
    pub(crate) fn at(self, shell: Shell, node: Vec2) -> (Place, f32) {
        let Self { piece, low_r, low_mu, low_r_mu_s, nu, k } = self;
        let (s, weight) = sample(piece.length, k, node);
        let altitude = altitude_from(shell, piece.altitude, low_mu, s);
        let inverse_r = 1.0 / (shell.ground_radius + altitude);
        let mu = (low_r * low_mu + s) * inverse_r;
        let mu_s = (low_r_mu_s + s * nu) * inverse_r;
        (Place { distance: piece.low + direction(piece.rising) * s, altitude, mu, mu_s }, weight)
    }
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

/// A ray's way through the atmosphere.
#[derive(Clone, Copy)]
pub(crate) struct Way {
    /// The ray, from where it enters the atmosphere.
    pub(crate) ray: Ray,
    /// Its length inside, up to the ground or the top (km).
    pub(crate) length: f32,
    /// Distance of its lowest point (km).
    perigee: f32,
    /// Altitude of its lowest point (km).
    pub(crate) lowest: f32,
    /// Its part in the planet's shadow.
    shadow: Interval,
}

impl Way {
    #[inline(always)]
    pub(crate) fn new(shell: Shell, ray: Ray, variant: u32) -> Self {
        let mut ray = ray;
        let length;
        let mut perigee = 0.0;
        let mut lowest = ray.altitude;
        if variant & variant::DESCENT != 0 {
            (ray, length) = inside_atmosphere(shell, ray);
            perigee = max(-(shell.ground_radius + ray.altitude) * ray.mu, 0.0);
            lowest = if ray.mu < 0.0 { max(perigee_altitude(shell, ray.altitude, ray.mu), 0.0) } else { ray.altitude };
        } else {
            // From the ground itself every falling ray ends where it begins.
            length = if ray.mu < 0.0 { 0.0 } else { distance_to_top(shell, ray.altitude, ray.mu) };
        }
        let mut shadow = Interval { start: length, end: length };
        if variant & variant::SHADOW != 0 {
            shadow = geometry::shadow(shell, ray);
        }
        Self { ray, length, perigee, lowest, shadow }
    }

    /// Whether it ends on the ground: before its lowest point. Only for a variant in which a ray can descend.
    #[inline(always)]
    pub(crate) fn meets_ground(self, shell: Shell) -> bool {
        (self.ray.altitude <= shell.depth) & (self.length < self.perigee)
    }

    /// The lit interval before or behind the shadow on which the ray rises or falls.
    #[inline(always)]
    pub(crate) fn lit(self, behind_shadow: bool, rising: bool) -> Interval {
        let lit = if behind_shadow {
            Interval { start: self.shadow.end, end: self.length }
        } else {
            Interval { start: 0.0, end: min(self.shadow.start, self.length) }
        };
        if rising {
            Interval { start: max(lit.start, self.perigee), end: lit.end }
        } else {
            Interval { start: lit.start, end: min(lit.end, self.perigee) }
        }
    }

    /// The piece that such an interval is.
    #[inline(always)]
    pub(crate) fn piece(self, shell: Shell, interval: Interval, rising: bool, variant: u32) -> Piece {
        let Self { ray, length, perigee, lowest, .. } = self;
        let low = if rising { interval.start } else { interval.end };
        // The ends that are known better than by their distance: the ground, the ray's lowest point, the observer, the shadow.
        let at_lowest = (low == perigee) | (!rising & (low == length));
        let mut altitude = if at_lowest { lowest } else { altitude_along(shell, ray, low) };
        if (variant & variant::SHADOW != 0) & (low != perigee) {
            altitude = altitude_of_lit_end(shell, ray, low, altitude);
        }
        Piece { low, altitude, length: interval.end - interval.start, rising }
    }
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
