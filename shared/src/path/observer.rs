//! What lies between the observer and a place on a ray, and between that place and the sun.

use crate::geometry::Ray;
use crate::glam::Vec2;
use crate::math::{abs, max};
use crate::medium::atmosphere::{ColumnDensities, Medium};
use crate::medium::columns::{
    LowestPoint, column_densities, level_column_densities, outwards_and_sunlight, stretch_column_densities,
};
use crate::medium::density::relative_densities;
use crate::medium::tables::Sunlight;
use crate::path::ray::direction;
use crate::path::samples::Place;
use crate::variant;

/// What lies between the observer and the places of one piece of a ray.
#[derive(Clone, Copy)]
pub(crate) struct TowardsObserver {
    /// Altitude of the ray's origin (km).
    pub(crate) altitude: f32,
    /// Zenith cosine of the ray at its origin.
    pub(crate) mu: f32,
    /// Whether the ray rises along the piece.
    pub(crate) rising: bool,
    /// What the column densities from a place outwards are taken from (rising ray) or added to (falling ray) to give
    /// those between the observer and the place (km).
    pub(crate) offset: ColumnDensities,
    /// The lowest point between the observer and a piece on which the ray rises.
    pub(crate) lowest: LowestPoint,
}

impl TowardsObserver {
    /// For the pieces of a ray on which it rises or falls; `lowest` is the altitude of its lowest point (km).
    #[inline(always)]
    pub(crate) fn new(medium: Medium<'_>, ray: Ray, lowest: f32, rising: bool, variant: u32) -> Self {
        let density = relative_densities(medium, ray.altitude, variant);
        let outwards = column_densities(medium, ray.altitude, density, abs(ray.mu), variant);
        let offset = if (variant & variant::DESCENT == 0) | (ray.mu >= 0.0) {
            outwards
        } else if rising {
            level_column_densities(medium, lowest, variant) * 2.0 - outwards
        } else {
            ColumnDensities::ZERO - outwards
        };
        let lowest = LowestPoint { altitude: lowest, mu: max(ray.mu, 0.0) };
        Self { altitude: ray.altitude, mu: ray.mu, rising, offset, lowest }
    }

    /// Column densities between the observer and a place (km), given those from the place outwards.
    #[inline(always)]
    pub(crate) fn column_densities(
        self,
        medium: Medium<'_>,
        place: Place,
        outwards: ColumnDensities,
        variant: u32,
    ) -> ColumnDensities {
        let mut between = self.offset - outwards * direction(self.rising);
        if variant & variant::OPAQUE != 0 {
            let here = LowestPoint { altitude: place.altitude, mu: place.mu };
            let lowest = if self.rising { self.lowest } else { here };
            let (altitude, mu, length) = (self.altitude, self.mu, place.distance);
            between = stretch_column_densities(medium, altitude, mu, lowest, length, between, variant);
        }
        between.at_least_zero()
    }
}

/// What light meets that is scattered once at a lit place: the relative densities of (air, aerosol) there times what
/// bending leaves of the beam, and the column densities between the sun and the observer (km).
#[inline(always)]
pub(crate) fn lit_place(
    medium: Medium<'_>,
    towards_observer: TowardsObserver,
    place: Place,
    variant: u32,
) -> (Vec2, ColumnDensities) {
    let Place { altitude, mu, mu_s, .. } = place;
    let density = relative_densities(medium, altitude, variant);
    let (outwards, sunlight) = outwards_and_sunlight(medium, altitude, density, mu, mu_s, variant);
    joined(medium, towards_observer, place, (density, outwards), sunlight, variant)
}

/// The same by the relative densities at the place, the column densities from there outwards along the ray (km), and
/// the sunlight there.
#[inline(always)]
pub(crate) fn joined(
    medium: Medium<'_>,
    towards_observer: TowardsObserver,
    place: Place,
    (density, outwards): (Vec2, ColumnDensities),
    sunlight: Sunlight,
    variant: u32,
) -> (Vec2, ColumnDensities) {
    let to_observer = towards_observer.column_densities(medium, place, outwards, variant);
    (density * sunlight.spread, to_observer + sunlight.along)
}
