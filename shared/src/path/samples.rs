//! The samples of a ray: where the quadrature of a piece places them, and for what length each stands.

use crate::geometry::{Ray, Shell, altitude_from};
use crate::glam::Vec2;
use crate::math::{max, sqrt};
use crate::medium::atmosphere::Medium;
use crate::medium::bands::Bands;
use crate::medium::columns::equivalent_lengths;
use crate::medium::density::relative_densities;
use crate::path::ray::{Piece, direction};

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

/// How strongly the samples of a piece crowd towards its low end: `k` of the substitution
/// `s = length · u / (1 + k (1 - u))`.
///
/// The integrand falls off over the distance `D` in which the density does, or over a few mean free paths of light,
/// whichever is shorter; `k` makes the sampled variable as long as three of those. `low` is the distance of the low end
/// along the ray. A falling ray reaches its low end last: in opaque air nothing is seen of it, and the density alone
/// counts. `mu` is the cosine of the angle between the vertical and the piece at its low end; `per_mean_free_path` says
/// how much a mean free path of light counts beside `D`.
#[inline(always)]
pub(crate) fn crowding(
    medium: Medium<'_>,
    bands: &Bands,
    piece: Piece,
    mu: f32,
    per_mean_free_path: f32,
    variant: u32,
) -> f32 {
    let Piece { altitude, length, rising, .. } = piece;
    let g = sqrt(1.0 + altitude / medium.atmosphere.ground_radius);
    let fall_off = equivalent_lengths(medium, g, Vec2::splat(mu), variant).x;
    let density = relative_densities(medium, altitude, variant);
    let extinction = bands.air_scattering * density.x + bands.aerosol_extinction * density.y;
    let strongest = if rising { max(max(extinction.x, extinction.y), max(extinction.z, extinction.w)) } else { 0.0 };
    max(0.35 * length * (1.0 / fall_off + per_mean_free_path * strongest) - 1.0, 0.0)
}

/// A sample of a piece with this length (km), crowded by `k`: its distance from the low end and its weight (km), for a
/// quadrature node (place, weight) on [0, 1].
#[inline(always)]
pub(crate) fn sample(length: f32, k: f32, node: Vec2) -> (f32, f32) {
    let compression = 1.0 / (1.0 + k * (1.0 - node.x));
    (length * node.x * compression, node.y * length * (1.0 + k) * compression * compression)
}

/// [`crowding`] of single scattering by the mean free path.
pub(crate) const PER_MEAN_FREE_PATH: f32 = 0.05;

/// The samples of a piece.
///
/// They are placed by their distance from the low end: altitudes there are sums of positive terms, and near the ground
/// keep the digits that they would lose as distances from an observer far above.
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
        medium: Medium<'_>,
        bands: &Bands,
        ray: Ray,
        piece: Piece,
        per_mean_free_path: f32,
        variant: u32,
    ) -> Self {
        let outwards = direction(piece.rising);
        let r = medium.atmosphere.ground_radius + ray.altitude;
        let low_r = medium.atmosphere.ground_radius + piece.altitude;
        let low_mu = max((r * ray.mu + piece.low) * outwards, 0.0) / low_r;
        let low_r_mu_s = r * ray.mu_s + piece.low * ray.nu;
        let k = crowding(medium, bands, piece, low_mu, per_mean_free_path, variant);
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
