//! A ray's way through the atmosphere: where it is lit, and its pieces.

use crate::geometry::{
    Interval, Ray, Shell, altitude_along, altitude_of_lit_end, distance_to_top, inside_atmosphere, perigee_altitude,
};
use crate::math::{max, min};
use crate::{geometry, variant};

/// 1 where a ray rises, -1 where it falls.
#[inline(always)]
pub(crate) fn direction(rising: bool) -> f32 {
    if rising { 1.0 } else { -1.0 }
}

/// A stretch of a ray on which its altitude only rises or only falls.
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
        // The ends that are known better than by their distance: the ground, the ray's lowest point, the observer, the
        // shadow.
        let at_lowest = (low == perigee) | (!rising & (low == length));
        let mut altitude = if at_lowest { lowest } else { altitude_along(shell, ray, low) };
        if (variant & variant::SHADOW != 0) & (low != perigee) {
            altitude = altitude_of_lit_end(shell, ray, low, altitude);
        }
        Piece { low, altitude, length: interval.end - interval.start, rising }
    }
}
