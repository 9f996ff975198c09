//! Whole rays, dark or lit, as the rays of a light field are sampled.

use crate::geometry::{Interval, Ray, altitude_from};
use crate::glam::Vec2;
use crate::medium::atmosphere::{ColumnDensities, Medium};
use crate::medium::bands::Bands;
use crate::medium::columns::column_densities;
use crate::medium::density::relative_densities;
use crate::path::ground::{GroundView, ground_on_way};
use crate::path::observer::TowardsObserver;
use crate::path::ray::{Way, direction, in_shadow};
use crate::path::samples::Samples;
use crate::variant;

/// How much a mean free path of light counts where the samples of a ray crowd, relative to the length over which the
/// density falls off; see `samples`. Light scattered more than once comes from the dense air at once, where that of the
/// sun does not reach.
pub const PER_MEAN_FREE_PATH_OF_ORDERS: f32 = 0.4;

/// A sample of a view ray.
#[derive(Clone, Copy)]
pub struct Sample {
    /// Distance from where the ray enters the atmosphere, or begins (km).
    pub distance: f32,
    /// Altitude (km).
    pub altitude: f32,
    /// Cosine of the zenith angle of the ray.
    pub mu: f32,
    /// The length that it stands for (km).
    pub weight: f32,
    /// Relative densities of (air, aerosol).
    pub density: Vec2,
    /// Column densities towards the observer (km).
    pub to_observer: ColumnDensities,
}

/// The samples on a part of a ray, dark or lit, on which it only rises or only falls.
#[derive(Clone, Copy)]
pub struct PieceSamples {
    samples: Samples,
    towards_observer: TowardsObserver,
    rising: bool,
}

impl PieceSamples {
    /// Of an interval of a way; `variant` is one in which a ray can descend.
    #[inline(always)]
    pub(crate) fn new(
        medium: Medium<'_>,
        placed_for: &Bands,
        way: Way,
        interval: Interval,
        rising: bool,
        variant: u32,
    ) -> Self {
        let piece = way.piece(medium.shell(), interval, rising, variant & !variant::SHADOW);
        Self {
            samples: Samples::new(medium, placed_for, way.ray, piece, PER_MEAN_FREE_PATH_OF_ORDERS, variant),
            towards_observer: TowardsObserver::new(medium, way.ray, way.lowest, rising, variant),
            rising,
        }
    }

    /// Altitude (km) at a distance (km) from the low end.
    #[inline(always)]
    pub fn altitude(self, medium: Medium<'_>, from_low: f32) -> f32 {
        altitude_from(medium.shell(), self.samples.piece.altitude, self.samples.low_mu, from_low)
    }

    /// Length of the piece (km).
    #[inline(always)]
    pub fn length(self) -> f32 {
        self.samples.piece.length
    }

    /// Whether the ray rises along it.
    #[inline(always)]
    pub fn is_rising(self) -> bool {
        self.rising
    }

    /// The quadrature node whose sample stands at a distance (km) from the low end, for a length (km).
    #[inline(always)]
    pub fn node(self, from_low: f32, weight: f32) -> Vec2 {
        let (length, k) = (self.length(), self.samples.k);
        let stretched = length + k * from_low;
        Vec2::new(from_low * (1.0 + k) / stretched, weight * (1.0 + k) * length / (stretched * stretched))
    }

    /// The one at a quadrature node.
    #[inline(always)]
    pub fn at(self, medium: Medium<'_>, node: Vec2, variant: u32) -> Sample {
        let (place, weight) = self.samples.at(medium.shell(), node);
        let density = relative_densities(medium, place.altitude, variant);
        let outwards = column_densities(medium, place.altitude, density, place.mu, variant);
        let to_observer = self.towards_observer.column_densities(medium, place, outwards, variant);
        let mu = place.mu * direction(self.rising);
        Sample { distance: place.distance, altitude: place.altitude, mu, weight, density, to_observer }
    }
}

/// Whether the sun lights all of a ray.
#[inline(always)]
pub fn lit_from_end_to_end(medium: Medium<'_>, ray: Ray, variant: u32) -> bool {
    let way = Way::new(medium, ray, variant::DESCENT);
    let (shadow, _) = in_shadow(medium, way.ray, way.length, variant);
    (shadow.end <= shadow.start) | (shadow.start >= way.length)
}

/// Visits the pieces of a whole ray, dark or lit, from its origin on. The ray is returned from where it enters the
/// atmosphere, with the ground where it meets it. `variant` is one in which a ray can descend.
#[inline(always)]
pub fn for_each_piece(
    medium: Medium<'_>,
    bands: &Bands,
    ray: Ray,
    variant: u32,
    visit: impl FnMut(PieceSamples),
) -> (Ray, GroundView) {
    let way = Way::new(medium, ray, variant & !variant::SHADOW);
    visit_pieces(medium, bands, way, variant, visit);
    (way.ray, ground_on_way(medium, way, variant))
}

/// Visits those of a ray up to a distance (km) from its origin, and returns it from where it enters the atmosphere.
#[inline(always)]
pub fn for_each_piece_until(
    medium: Medium<'_>,
    bands: &Bands,
    (ray, distance): (Ray, f32),
    variant: u32,
    visit: impl FnMut(PieceSamples),
) -> Ray {
    let way = Way::new(medium, ray, variant & !variant::SHADOW).until(medium.shell(), ray, distance);
    visit_pieces(medium, bands, way, variant, visit);
    way.ray
}

#[inline(always)]
fn visit_pieces(medium: Medium<'_>, bands: &Bands, way: Way, variant: u32, mut visit: impl FnMut(PieceSamples)) {
    for rising in [false, true] {
        let interval = way.lit(false, rising);
        if interval.end > interval.start {
            visit(PieceSamples::new(medium, bands, way, interval, rising, variant));
        }
    }
}

/// Column densities (km) between the origin of a ray and a distance from it (km). `variant` is one in which a ray can
/// descend.
pub fn column_densities_until(medium: Medium<'_>, bands: &Bands, ray: (Ray, f32), variant: u32) -> ColumnDensities {
    let mut along = ColumnDensities::ZERO;
    for_each_piece_until(medium, bands, ray, variant, |piece| {
        // Of the last piece the far end counts.
        let far = Vec2::new(if piece.is_rising() { 1.0 } else { 0.0 }, 0.0);
        along = piece.at(medium, far, variant).to_observer;
    });
    along
}
