//! Light scattered once in air of any profile, with sunlight that the air bends: by marching, in place of any formula.
//!
//! A ray of light follows `d/ds (n dr/ds) = ∇n` (Born and Wolf, *Principles of Optics*, 3.2), here in the plane through
//! the planet's centre, by the classical Runge-Kutta steps. The sun is found by shooting rays out of a place until one
//! leaves in the sun's direction; how much bending weakens the beam is told by a second ray beside it. The view ray is
//! straight.

use crate::line::dot;
use crate::medium::{CONSTITUENTS, Coefficients};
use crate::phase::air_phase;
use crate::ray::Ray;

/// Air of a profile.
pub struct Profile<'a> {
    /// Radius of the ground, km.
    pub ground_radius_km: f64,
    /// Height of the top of the atmosphere above it, km.
    pub top_altitude_km: f64,
    /// Relative densities at an altitude (km).
    pub densities: &'a (dyn Fn(f64) -> [f64; CONSTITUENTS] + Sync),
    /// `n - 1` at an altitude (km).
    pub excess: &'a (dyn Fn(f64) -> f64 + Sync),
    /// Asymmetry of the aerosol's phase function.
    pub aerosol_asymmetry: f64,
}

/// Where a ray leaves the air, and what it crossed.
#[derive(Clone, Copy, Debug)]
pub struct Exit {
    /// Angle from the vertical of the place where it began (radians).
    pub zenith: f64,
    /// Column densities, km.
    pub columns: [f64; CONSTITUENTS],
}

/// A beam of sunlight to a place.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// Zenith angle at which it arrives (radians).
    pub seen: f64,
    /// Column densities, km.
    pub columns: [f64; CONSTITUENTS],
    /// What bending leaves of its irradiance.
    pub spread: f64,
}

/// A place, a direction, and the column densities so far.
type State = [f64; 4 + CONSTITUENTS];

/// Densities of a ray that is asked for its way alone.
fn uncounted(_: f64) -> [f64; CONSTITUENTS] {
    [0.0; CONSTITUENTS]
}

impl Profile<'_> {
    fn slopes(&self, [x, y, px, py, ..]: State) -> State {
        const STEP: f64 = 1e-3;
        let radius = x.hypot(y);
        let altitude = radius - self.ground_radius_km;
        let index = 1.0 + (self.excess)(altitude);
        let slope = ((self.excess)(altitude + STEP) - (self.excess)(altitude - STEP)) / (2.0 * STEP);
        let densities = (self.densities)(altitude);
        let gradient = index * slope / radius;
        let of_ray = [px, py, gradient * x, gradient * y];
        std::array::from_fn(|i| if i < 4 { of_ray[i] } else { densities[i - 4] * index })
    }

    /// The way out of the air from an altitude (km) at a zenith angle (radians); none into the ground.
    pub fn way_out(&self, altitude: f64, zenith: f64) -> Option<Exit> {
        let index = 1.0 + (self.excess)(altitude);
        let mut state: State = [0.0; 4 + CONSTITUENTS];
        state[1] = self.ground_radius_km + altitude;
        (state[2], state[3]) = (index * zenith.sin(), index * zenith.cos());
        loop {
            let altitude = state[0].hypot(state[1]) - self.ground_radius_km;
            let rises = state[0] * state[2] + state[1] * state[3] >= 0.0;
            if altitude < 0.0 && !rises {
                return None;
            }
            if altitude > self.top_altitude_km && rises {
                let columns = std::array::from_fn(|i| state[4 + i]);
                return Some(Exit { zenith: state[2].atan2(state[3]), columns });
            }
            // As far as densities change by a tenth or so.
            let upwards = (state[0] * state[2] + state[1] * state[3]).abs() / state[0].hypot(state[1]);
            let step = ((0.1 + 0.08 * altitude.max(0.0)) / upwards.max(0.02)).min(4.0 + 0.05 * altitude.max(0.0));
            let moved = |by: f64, slopes: State| std::array::from_fn(|i| state[i] + by * slopes[i]);
            let a = self.slopes(state);
            let b = self.slopes(moved(0.5 * step, a));
            let c = self.slopes(moved(0.5 * step, b));
            let d = self.slopes(moved(step, c));
            state = std::array::from_fn(|i| state[i] + step / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        }
    }

    /// The beam to an altitude (km) from a sun whose zenith angle without air is known (radians); none from one below
    /// the horizon.
    pub fn beam(&self, altitude: f64, sun: f64) -> Option<Beam> {
        /// Light bends by less than this (radians).
        const MOST: f64 = 0.05;
        // Most rays are shot for their direction, on which the densities have no part.
        let shot = Profile { densities: &uncounted, ..*self };
        let off = |seen: f64| shot.way_out(altitude, seen).map(|exit| exit.zenith - sun);
        let (mut high, mut low) = ((sun - MOST).max(0.0), sun);
        let mut of_high = off(high)?;
        // The lowest ray that leaves the air, or one that leaves it below the sun.
        let mut of_low = off(low);
        let mut touching = high;
        for _ in 0..50 {
            if of_low.is_some() {
                break;
            }
            let middle = 0.5 * (touching + low);
            match off(middle) {
                None => low = middle,
                Some(found) if found >= 0.0 => (low, of_low) = (middle, Some(found)),
                Some(found) => (touching, high, of_high) = (middle, middle, found),
            }
        }
        let mut of_low = of_low?;
        // Regula falsi after Illinois.
        let mut seen = high;
        let mut last = 0.0;
        for _ in 0..100 {
            if of_high == of_low {
                break;
            }
            seen = (high * of_low - low * of_high) / (of_low - of_high);
            let found = off(seen)?;
            if found.abs() < 1e-10 {
                break;
            }
            if found < 0.0 {
                (high, of_high) = (seen, found);
                of_low *= if last < 0.0 { 0.5 } else { 1.0 };
            } else {
                (low, of_low) = (seen, found);
                of_high *= if last > 0.0 { 0.5 } else { 1.0 };
            }
            last = found;
        }
        let exit = self.way_out(altitude, seen).filter(|exit| (exit.zenith - sun).abs() < 1e-6)?;
        const BESIDE: f64 = 1e-5;
        let above = shot.way_out(altitude, seen - BESIDE)?.zenith;
        let spread = if sun < 1e-3 { 1.0 } else { seen.sin() / sun.sin() * BESIDE / (exit.zenith - above) };
        Some(Beam { seen, columns: exit.columns, spread })
    }

    /// Radiance scattered once along a straight view ray up to the ground or the top of the air, at several wavelengths,
    /// for an irradiance of 1 (sr⁻¹).
    pub fn scattered_once(&self, bands: &[Coefficients], ray: &Ray) -> Vec<f64> {
        const SAMPLES: u32 = 160;
        let (radius, mu) = (self.ground_radius_km + ray.observer_altitude_km, ray.view[2]);
        let nu = dot(ray.view, ray.sun);
        let top = self.ground_radius_km + self.top_altitude_km;
        let perigee_squared = radius * radius * (1.0 - mu * mu);
        let meets_ground = mu < 0.0 && perigee_squared < self.ground_radius_km.powi(2);
        let length = if meets_ground {
            -radius * mu - (self.ground_radius_km.powi(2) - perigee_squared).sqrt()
        } else {
            (top * top - perigee_squared).sqrt() - radius * mu
        };
        let at = |s: f64| {
            let here = (radius * radius + s * s + 2.0 * radius * mu * s).sqrt();
            (here - self.ground_radius_km, (radius * ray.sun[2] + s * nu) / here)
        };
        let sun_at = |s: f64| {
            let (altitude, mu_sun) = at(s);
            self.beam(altitude, mu_sun.clamp(-1.0, 1.0).acos())
        };
        // In twilight the ray comes out of the planet's shadow once.
        let mut edge = 0.0;
        if sun_at(1e-6 * length).is_none() {
            let mut lit = length;
            for _ in 0..40 {
                let middle = 0.5 * (edge + lit);
                if sun_at(middle).is_some() { lit = middle } else { edge = middle }
            }
            edge = lit;
        }
        let cells = |from: f64, to: f64| {
            // Crowded towards the eye, or towards the shadow.
            let place = move |i: u32| from + (to - from) * (f64::from(i) / f64::from(SAMPLES)).powi(3);
            (0..SAMPLES).map(move |i| (place(i), place(i + 1)))
        };
        let column =
            |from: f64, to: f64| (self.densities)(at(0.5 * (from + to)).0).map(|density| density * (to - from));
        let mut along = [0.0; CONSTITUENTS];
        for (start, end) in cells(0.0, edge).filter(|_| edge > 0.0) {
            (0..CONSTITUENTS).for_each(|c| along[c] += column(start, end)[c]);
        }
        let mut sum = vec![0.0; bands.len()];
        for (start, end) in cells(edge, length) {
            let middle = 0.5 * (start + end);
            let densities = (self.densities)(at(middle).0);
            let half = column(start, middle);
            if let Some(beam) = sun_at(middle) {
                for (sum, band) in sum.iter_mut().zip(bands) {
                    let columns = std::array::from_fn(|c| along[c] + half[c] + beam.columns[c]);
                    let scattered = band.air_scattering * densities[0] * air_phase(band.air_depolarisation, nu)
                        + band.aerosol_scattering * densities[1] * band.aerosol_phase(self.aerosol_asymmetry, nu);
                    *sum += scattered * beam.spread * (-band.optical_depth(columns)).exp() * (end - start);
                }
            }
            (0..CONSTITUENTS).for_each(|c| along[c] += column(start, end)[c]);
        }
        sum
    }
}
