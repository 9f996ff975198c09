//! Directions at random, and how dense they lie.

use std::f64::consts::{PI, TAU};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::line::{cross, dot};

/// A density of directions about the horizon where the sun has set, for places that it does not reach.
pub(crate) struct Glow {
    up: [f64; 3],
    toward: [f64; 3],
    side: [f64; 3],
}

impl Glow {
    /// Sines of the elevation fall off from this one, e-fold in that many.
    const ELEVATION: (f64, f64) = (0.05, 0.1);
    /// Excentricity of the azimuths.
    const FOCUS: f64 = 0.6;

    /// None where the sun is up.
    pub(crate) fn seen_from(place: [f64; 3], sun: [f64; 3]) -> Option<Self> {
        let up = unit(place);
        let mu = dot(up, sun);
        if !(-0.999..0.0).contains(&mu) {
            return None;
        }
        let toward = unit([0, 1, 2].map(|i| sun[i] - mu * up[i]));
        Some(Self { up, toward, side: cross(up, toward) })
    }

    /// The chances of elevations below and above the middle, up to a factor.
    fn sides() -> [f64; 2] {
        let (middle, scale) = Self::ELEVATION;
        [1.0 + middle, 1.0 - middle].map(|room| -(-room / scale).exp_m1())
    }

    pub(crate) fn draw(&self, rng: &mut ChaCha8Rng) -> [f64; 3] {
        let (middle, scale) = Self::ELEVATION;
        let [below, above] = Self::sides();
        let is_below = rng.random::<f64>() * (below + above) < below;
        let away = -scale * (-rng.random::<f64>() * if is_below { below } else { above }).ln_1p();
        let sine = if is_below { middle - away } else { middle + away }.clamp(-1.0, 1.0);
        let cosine = ((1.0 - sine) * (1.0 + sine)).sqrt();
        let half = (PI * (rng.random::<f64>() - 0.5)).tan();
        let azimuth = 2.0 * ((1.0 - Self::FOCUS) / (1.0 + Self::FOCUS) * half).atan();
        let (sin_azimuth, cos_azimuth) = azimuth.sin_cos();
        let level = |i: usize| cos_azimuth * self.toward[i] + sin_azimuth * self.side[i];
        unit([0, 1, 2].map(|i| sine * self.up[i] + cosine * level(i)))
    }

    /// The density of a direction, sr⁻¹.
    pub(crate) fn density(&self, direction: [f64; 3]) -> f64 {
        let (middle, scale) = Self::ELEVATION;
        let [below, above] = Self::sides();
        let sine = dot(direction, self.up);
        let elevation = (-(sine - middle).abs() / scale).exp() / (scale * (below + above));
        let cosine = ((1.0 - sine) * (1.0 + sine)).max(0.0).sqrt();
        let cos_azimuth = if cosine > 0.0 { (dot(direction, self.toward) / cosine).clamp(-1.0, 1.0) } else { 0.0 };
        let k = Self::FOCUS;
        elevation * (1.0 - k * k) / (TAU * (1.0 + k * k - 2.0 * k * cos_azimuth))
    }
}

/// A cosine of the distribution of [`crate::air_phase`], by rejection.
pub(crate) fn air_angle(depolarisation: f64, rng: &mut ChaCha8Rng) -> f64 {
    loop {
        let nu = 2.0 * rng.random::<f64>() - 1.0;
        if rng.random::<f64>() * 2.0 < 1.0 + depolarisation + (1.0 - depolarisation) * nu * nu {
            return nu;
        }
    }
}

/// A cosine of the distribution of [`crate::aerosol_phase`]: one of Henyey and Greenstein's (1941, DOI 10.1086/144246),
/// by inversion, kept with the probability (1 + ν²) / 2, by which the two differ.
pub(crate) fn aerosol_angle(asymmetry: f64, rng: &mut ChaCha8Rng) -> f64 {
    let g = asymmetry;
    loop {
        let part = 2.0 * rng.random::<f64>() - 1.0;
        // The inversion divides by g.
        let nu = if g.abs() < 1e-4 {
            part
        } else {
            let share = (1.0 - g * g) / (1.0 + g * part);
            ((1.0 + g * g - share * share) / (2.0 * g)).clamp(-1.0, 1.0)
        };
        if rng.random::<f64>() * 2.0 < 1.0 + nu * nu {
            return nu;
        }
    }
}

/// A unit vector at an angle, given by its cosine, from another, at any azimuth about it.
pub(crate) fn turned(axis: [f64; 3], cosine: f64, rng: &mut ChaCha8Rng) -> [f64; 3] {
    let (sin_azimuth, cos_azimuth) = (TAU * rng.random::<f64>()).sin_cos();
    let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
    let across = unit(cross(axis, if axis[2].abs() < 0.7 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] }));
    let other = cross(axis, across);
    let side = |i: usize| cos_azimuth * across[i] + sin_azimuth * other[i];
    unit([0, 1, 2].map(|i| cosine * axis[i] + sine * side(i)))
}

pub(crate) fn unit(vector: [f64; 3]) -> [f64; 3] {
    vector.map(|x| x / dot(vector, vector).sqrt())
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;
    use crate::phase::{aerosol_phase, air_phase};
    use crate::quadrature::GaussLegendre;
    use crate::ray::direction;

    const DRAWN: usize = 100_000;

    /// Means of 1, ν, ν² and ν³ of cosines drawn, against those of a phase function.
    fn assert_drawn(draw: impl Fn(&mut ChaCha8Rng) -> f64, phase: impl Fn(f64) -> f64) {
        let rng = &mut ChaCha8Rng::seed_from_u64(3);
        let drawn: Vec<f64> = (0..DRAWN).map(|_| draw(rng)).collect();
        let rule = GaussLegendre::<64>::new();
        for power in 1..4 {
            let mean = drawn.iter().map(|nu| nu.powi(power)).sum::<f64>() / DRAWN as f64;
            let expected = TAU * rule.integrate(-1.0, 1.0, |nu| phase(nu) * nu.powi(power));
            // Three standard errors of numbers between -1 and 1.
            assert!((mean - expected).abs() < 3.0 / (DRAWN as f64).sqrt(), "ν^{power}: {mean}, {expected}");
        }
    }

    #[test]
    fn angles_are_drawn_from_the_phase_functions() {
        for depolarisation in [0.0, 0.03, 1.0] {
            assert_drawn(|rng| air_angle(depolarisation, rng), |nu| air_phase(depolarisation, nu));
        }
        for asymmetry in [-0.5, 0.0, 0.3, 0.8] {
            assert_drawn(|rng| aerosol_angle(asymmetry, rng), |nu| aerosol_phase(asymmetry, nu));
        }
    }

    #[test]
    fn the_glow_has_the_density_that_it_says() {
        let place = direction(50.0, 20.0).map(|x| 6400.0 * x);
        let glow = Glow::seen_from(place, direction(-47.0, 20.0)).expect("the sun has set");
        let rng = &mut ChaCha8Rng::seed_from_u64(5);
        let drawn: Vec<[f64; 3]> = (0..DRAWN).map(|_| glow.draw(rng)).collect();
        let rule = GaussLegendre::<64>::new();
        let middle = Glow::ELEVATION.0;
        for (low, high) in [(-1.0, middle), (middle, 0.15), (0.15, 1.0)] {
            for (first, last) in [(-PI, -0.5), (-0.5, 0.5), (0.5, PI)] {
                let at = |sine: f64, azimuth: f64| {
                    let cosine = (1.0 - sine * sine).sqrt();
                    let level = |i: usize| azimuth.cos() * glow.toward[i] + azimuth.sin() * glow.side[i];
                    glow.density([0, 1, 2].map(|i| sine * glow.up[i] + cosine * level(i)))
                };
                let chance = rule.integrate(low, high, |sine| rule.integrate(first, last, |azimuth| at(sine, azimuth)));
                let is_there = |way: &&[f64; 3]| {
                    let azimuth = dot(**way, glow.side).atan2(dot(**way, glow.toward));
                    (low..high).contains(&dot(**way, glow.up)) && (first..last).contains(&azimuth)
                };
                let part = drawn.iter().filter(is_there).count() as f64 / DRAWN as f64;
                // Three standard errors of a part.
                let error = 3.0 * (chance / DRAWN as f64).sqrt();
                assert!((part - chance).abs() < error, "{low} to {high}, {first} to {last}: {part}, {chance}");
            }
        }
    }

    #[test]
    fn no_glow_is_seen_while_the_sun_is_up() {
        assert!(Glow::seen_from([0.0, 0.0, 6400.0], direction(1.0, 0.0)).is_none());
    }
}
