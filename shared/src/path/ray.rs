//! A ray's way through the atmosphere: where it is lit, and its pieces.

use crate::geometry::{
    Interval, Ray, Shadow, Shell, altitude_along, altitude_of_lit_end, distance_to_top, inside_atmosphere,
    perigee_altitude, shadow,
};
use crate::math::{max, min};
use crate::medium::atmosphere::Medium;
use crate::medium::tables;
use crate::variant;

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
    /// The cones on which that begins and ends.
    edges: [Shadow; 2],
    /// Whether it ends in the air while it falls, on neither the ground nor a cone.
    ends_falling: bool,
}

/// The part of a ray of so many km that lies in the planet's shadow, and the cones on which it begins and ends. Of bent
/// light the edge is no cone: each end is found on one that touches it near there.
#[inline(always)]
pub(crate) fn in_shadow(medium: Medium<'_>, ray: Ray, length: f32, variant: u32) -> (Interval, [Shadow; 2]) {
    let shell = medium.shell();
    let widest = shadow(shell, ray);
    let (mut interval, mut edges) = (widest, [shell.shadow; 2]);
    if (variant & variant::TABLES != 0) & (shell.shadow.slope > 0.0) {
        // All of the ray is lit, and it may end on lit ground: on a cone that lies below the ground.
        interval = Interval { start: length, end: length };
        edges = [Shadow { offset: -shell.ground_radius, slope: 0.0, begin: 0.0 }; 2];
        if widest.end > widest.start {
            let (begins, beginning) = shadow_touched(medium, ray, min(widest.start, length));
            // A cone about a lower altitude narrows less. Towards a sun that has just set a ray leaves no other one.
            let nearer = earlier_end(beginning, widest.end);
            let (_, leaving) = shadow_touched(medium, ray, min(nearer, length));
            let (ends, ending) = shadow_touched(medium, ray, min(earlier_end(leaving, nearer), length));
            // The widest cone is the first: a ray may pass the one that is right where it would begin.
            if beginning.end > beginning.start {
                let end = if ending.end > ending.start { ending.end } else { beginning.end };
                interval = Interval { start: beginning.start, end };
                edges = [begins, ends];
            }
        }
    }
    (interval, edges)
}

/// The cone that touches the shadow's edge at the altitude of a ray at a distance (km), and the ray's part inside it.
#[inline(always)]
fn shadow_touched(medium: Medium<'_>, ray: Ray, distance: f32) -> (Shadow, Interval) {
    let shell = medium.shell();
    let cone = tables::shadow_at(medium, altitude_along(shell, ray, distance));
    (cone, shadow(Shell { shadow: cone, ..shell }, ray))
}

/// The end of an interval that is not empty, or an earlier distance (km).
#[inline(always)]
fn earlier_end(interval: Interval, distance: f32) -> f32 {
    if interval.end > interval.start { min(interval.end, distance) } else { distance }
}

impl Way {
    #[inline(always)]
    pub(crate) fn new(medium: Medium<'_>, ray: Ray, variant: u32) -> Self {
        let shell = medium.shell();
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
        let mut dark = Interval { start: length, end: length };
        let mut edges = [shell.shadow; 2];
        if variant & variant::SHADOW != 0 {
            (dark, edges) = in_shadow(medium, ray, length, variant);
        }
        Self { ray, length, perigee, lowest, shadow: dark, edges, ends_falling: false }
    }

    /// The part of it up to a distance (km) from where its ray begins, which may be before it enters the atmosphere.
    /// It ends on no ground.
    #[inline(always)]
    pub(crate) fn until(self, shell: Shell, begins: Ray, distance: f32) -> Self {
        let along = |ray: Ray| (shell.ground_radius + ray.altitude) * ray.mu;
        let entered = along(self.ray) - along(begins);
        let length = min(max(distance - entered, 0.0), self.length);
        let falls = (length < self.perigee) & (length < self.length);
        let lowest = if falls { altitude_along(shell, self.ray, length) } else { self.lowest };
        Self { length, lowest, ends_falling: falls, ..self }
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
        let is_in_the_air = self.ends_falling & (low == length);
        if (variant & variant::SHADOW != 0) & (low != perigee) & !is_in_the_air {
            let [begins, ends] = self.edges;
            let edge = if low >= self.shadow.end { ends } else { begins };
            altitude = altitude_of_lit_end(Shell { shadow: edge, ..shell }, ray, low, altitude);
        }
        Piece { low, altitude, length: interval.end - interval.start, rising }
    }
}
