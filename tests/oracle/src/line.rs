//! Straight lines through spherical shells.

use crate::medium::Medium;

/// A half-line, as a spherical atmosphere sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// Altitude of its origin, km.
    pub(crate) altitude: f64,
    /// Distance of its origin from the planet's centre, km.
    pub(crate) radius: f64,
    /// Cosine of its zenith angle at its origin.
    pub(crate) mu: f64,
}

impl Line {
    pub(crate) fn new(medium: &Medium, altitude: f64, mu: f64) -> Self {
        let radius = medium.ground_radius_km + altitude;
        Self { altitude, radius, mu }
    }

    /// Height of the point at distance `s` above the origin, km.
    ///
    /// r² − r₀² = s (s + 2 r₀ μ) divided by r + r₀, since r − r₀ itself would cancel.
    pub(crate) fn climb(&self, s: f64) -> f64 {
        let square = s * (s + 2.0 * self.radius * self.mu);
        square / ((self.radius * self.radius + square).sqrt() + self.radius)
    }

    /// Distance at which a line that rises (μ ≥ 0) has climbed `height`, km.
    pub(crate) fn distance_to_climb(&self, height: f64) -> f64 {
        let square = height * (height + 2.0 * self.radius);
        let half_b = self.radius * self.mu;
        square / (half_b + (half_b * half_b + square).sqrt()).max(f64::MIN_POSITIVE)
    }

    /// The two distances, maybe negative, at which the whole line crosses the sphere at `altitude`,
    /// in order.
    pub(crate) fn crossings(&self, altitude: f64) -> Option<[f64; 2]> {
        let below = self.altitude - altitude;
        let c = below * (2.0 * self.radius - below);
        quadratic_roots(1.0, self.radius * self.mu, c)
    }

    /// The rising half of this line, from its perigee.
    pub(crate) fn rising_half(&self) -> Self {
        let sin = ((1.0 - self.mu) * (1.0 + self.mu)).sqrt();
        let drop = self.radius * self.mu * self.mu / (1.0 + sin);
        Self { altitude: self.altitude - drop, radius: self.radius * sin, mu: 0.0 }
    }
}

/// Real roots of a s² + 2 b s + c, in order, without cancellation between b and the root of the
/// discriminant.
pub(crate) fn quadratic_roots(a: f64, half_b: f64, c: f64) -> Option<[f64; 2]> {
    let discriminant = half_b * half_b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let q = -(half_b + discriminant.sqrt().copysign(half_b));
    let (first, second) = if q == 0.0 { (0.0, 0.0) } else { (q / a, c / q) };
    Some([first.min(second), first.max(second)])
}

// -------------------------------------------------------------------------------------------------

/// Distance from the observer to the atmosphere, km; None where the ray misses it. `sin` is the
/// sine of the zenith angle.
pub(crate) fn entry_distance(medium: &Medium, observer: &Line, sin: f64) -> Option<f64> {
    if observer.altitude <= medium.top_altitude_km() {
        return Some(0.0);
    }
    let perigee = observer.radius * sin;
    if observer.mu >= 0.0 || perigee >= medium.top_radius_km {
        return None;
    }
    Some(-observer.radius * observer.mu - half_chord(medium.top_radius_km, perigee))
}

/// The observer's line, moved on by `entry` to where it meets the top of the atmosphere.
pub(crate) fn line_from_entry(medium: &Medium, observer: &Line, entry: f64) -> Line {
    if entry == 0.0 {
        return *observer;
    }
    let mu = (observer.radius * observer.mu + entry) / medium.top_radius_km;
    Line::new(medium, medium.top_altitude_km(), mu)
}

/// Half of the chord that a line with this perigee cuts from a sphere, km.
pub(crate) fn half_chord(radius: f64, perigee: f64) -> f64 {
    ((radius - perigee) * (radius + perigee)).sqrt()
}

/// Distance to the ground or else to the top of the atmosphere, km.
pub(crate) fn length_in_atmosphere(medium: &Medium, line: &Line) -> f64 {
    let [near, far] = line.crossings(0.0).unwrap_or([0.0; 2]);
    if line.mu < 0.0 && near < far {
        return near.max(0.0);
    }
    let exit = line.crossings(medium.top_altitude_km());
    exit.map_or(0.0, |[_, far]| far.max(0.0))
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
