//! Light of all orders of scattering: a backward Monte Carlo.
//!
//! A path starts at the eye and goes the way that light came: to a collision with air or aerosol, or to the ground;
//! from there in a direction drawn from the phase function; and so on until it leaves the atmosphere. Absorption is a
//! weight, faint paths end by Russian roulette, and nothing is cut off: the mean over paths is the solution of the
//! transfer equation.
//!
//! Sunlight enters at every turn of a path, as what is scattered once on the way ahead: at one place on it, drawn from
//! where it is bright, and at the ground at its end. The first collision is forced, and lies in even parts of the view.
//! Where the sun has set, half of the directions are drawn from those in which it is still bright. None of this changes
//! the mean.

use std::f64::consts::PI;
use std::ops::RangeInclusive;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::column::column_to_top;
use crate::directions::{Glow, aerosol_angle, air_angle, turned, unit};
use crate::line::dot;
use crate::medium::{Coefficients, Medium};
use crate::phase::air_phase;
use crate::ray::Ray;
use crate::single::{ViewPath, scattered_radiance};
use crate::way::{Shells, Way};

/// Batches of paths, from whose scatter the standard error comes; that is itself uncertain by 1 / √(2 · 63), 9 %.
const BATCHES: u64 = 64;

/// A path whose weight is below this goes on by chance alone.
const ROULETTE: f64 = 0.05;

/// What a Monte Carlo knows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// The standard error of the mean.
    pub standard_error: f64,
}

/// How many paths, and which chance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paths {
    /// Number of paths; rounded up to a multiple of 64.
    pub number: u64,
    /// The same seed gives the same paths. The errors of rays are independent if each has a seed of its own.
    pub seed: u64,
}

/// Radiance of all orders for a solar irradiance of 1 at the top of the atmosphere, sr⁻¹: the first by quadrature, the
/// others by paths.
pub fn radiance_of_all_orders(medium: &Medium, band: &Coefficients, ray: &Ray, paths: Paths) -> Estimate {
    let once = scattered_radiance(medium, band, ray) + sunlit_ground_radiance(medium, band, ray);
    let more = radiance_of_orders(medium, band, ray, 2..=u32::MAX, paths);
    Estimate { mean: once + more.mean, ..more }
}

/// Radiance of the sunlit ground, seen through the air, for a solar irradiance of 1 at the top of the atmosphere, sr⁻¹:
/// what order 1 has beside [`scattered_radiance`].
pub fn sunlit_ground_radiance(medium: &Medium, band: &Coefficients, ray: &Ray) -> f64 {
    let shells = Shells::new(medium, band, ray.sun);
    let view = entered(medium, ray).map(|start| Way::new(&shells, start, ray.view));
    view.map_or(0.0, |view| seen_ground(&shells, &view))
}

/// Radiance of some orders for a solar irradiance of 1 at the top of the atmosphere, sr⁻¹, by paths alone.
///
/// An order counts how often light was scattered, by air, by aerosol or by the ground.
///
/// # Panics
///
/// If the orders begin with 0, which is the sun itself, or no paths are asked for.
pub fn radiance_of_orders(
    medium: &Medium,
    band: &Coefficients,
    ray: &Ray,
    orders: RangeInclusive<u32>,
    paths: Paths,
) -> Estimate {
    assert!(*orders.start() > 0, "order 0 is the sun itself");
    assert!(paths.number > 0, "no paths");
    let shells = Shells::new(medium, band, ray.sun);
    let batches: Vec<f64> = match entered(medium, ray) {
        None => vec![0.0; BATCHES as usize],
        Some(start) => {
            let view = Way::new(&shells, start, ray.view);
            let search = Search { shells: &shells, view: &view, direction: ray.view, orders };
            (0..BATCHES).map(|batch| search.batch(paths.number.div_ceil(BATCHES), stream(paths.seed, batch))).collect()
        }
    };
    mean_of(&batches)
}

fn stream(seed: u64, batch: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(batch);
    rng
}

fn mean_of(batches: &[f64]) -> Estimate {
    let number = batches.len() as f64;
    let mean = batches.iter().sum::<f64>() / number;
    let variance = batches.iter().map(|batch| (batch - mean).powi(2)).sum::<f64>() / (number - 1.0);
    Estimate { mean, standard_error: (variance / number).sqrt() }
}

/// Where a ray starts inside the atmosphere, from the planet's centre, km.
fn entered(medium: &Medium, ray: &Ray) -> Option<[f64; 3]> {
    let entry = ViewPath::new(medium, ray)?.entry;
    let eye = [0.0, 0.0, medium.ground_radius_km + ray.observer_altitude_km];
    Some([0, 1, 2].map(|i| eye[i] + entry * ray.view[i]))
}

/// The part of sunlight that reaches a place: 0 in the planet's shadow.
fn sunlight(shells: &Shells, place: [f64; 3]) -> f64 {
    let ground = shells.medium.ground_radius_km;
    let radius = dot(place, place).sqrt();
    let mu = (dot(place, shells.sun) / radius).clamp(-1.0, 1.0);
    if mu < 0.0 && radius * ((1.0 - mu) * (1.0 + mu)).sqrt() < ground {
        return 0.0;
    }
    (-shells.band.optical_depth(column_to_top(shells.medium, (radius - ground).max(0.0), mu))).exp()
}

/// What the sunlit ground reflects, sr⁻¹.
fn reflected(shells: &Shells, place: [f64; 3]) -> f64 {
    let mu = dot(place, shells.sun) / shells.medium.ground_radius_km;
    if mu <= 0.0 || shells.band.ground_albedo == 0.0 {
        return 0.0;
    }
    shells.band.ground_albedo / PI * mu * sunlight(shells, place)
}

/// What is seen of the sunlit ground along a way, sr⁻¹.
fn seen_ground(shells: &Shells, way: &Way) -> f64 {
    way.ground().map_or(0.0, |place| (-way.depth()).exp() * reflected(shells, place))
}

/// A search for the light along one view.
struct Search<'a> {
    shells: &'a Shells<'a>,
    view: &'a Way<'a>,
    direction: [f64; 3],
    orders: RangeInclusive<u32>,
}

impl Search<'_> {
    /// The mean of a number of paths.
    fn batch(&self, number: u64, mut rng: ChaCha8Rng) -> f64 {
        let mut way = self.view.clone();
        let mut sum = 0.0;
        for i in 0..number {
            sum += self.path((i as f64 + rng.random::<f64>()) / number as f64, &mut way, &mut rng);
        }
        sum / number as f64
    }

    /// What one path finds; `part`, from 0 to 1, is where on the view it first collides.
    fn path(&self, part: f64, way: &mut Way, rng: &mut ChaCha8Rng) -> f64 {
        let once = if self.orders.contains(&1) { self.once_scattered(self.view, self.direction, rng) } else { 0.0 };
        let Some((first, weight)) = self.first(part) else { return once };
        once + weight * self.more_often_scattered(first, way, rng)
    }

    /// Sunlight that is scattered towards the eye at a place, after one scattering elsewhere or more, sr⁻¹.
    fn more_often_scattered(&self, mut scatter: Scatter, way: &mut Way, rng: &mut ChaCha8Rng) -> f64 {
        let (mut weight, mut sum, mut direction) = (1.0, 0.0, self.direction);
        for order in 2..=*self.orders.end() {
            weight *= scatter.albedo;
            if !survives(&mut weight, rng) {
                break;
            }
            let (next, correction) = scatter.next(self.shells, direction, rng);
            direction = next;
            weight *= correction;
            way.lead(scatter.at, direction);
            if self.orders.contains(&order) {
                sum += weight * self.once_scattered(way, direction, rng);
            }
            let Some(further) = self.collision(way, -(1.0 - rng.random::<f64>()).ln()) else { break };
            scatter = further;
        }
        sum
    }

    /// The first collision of a path, and what it stands for.
    fn first(&self, part: f64) -> Option<(Scatter, f64)> {
        let stopped = -(-self.view.depth()).exp_m1();
        let albedo = self.shells.band.ground_albedo;
        let reflected = self.view.ground().map_or(0.0, |_| (1.0 - stopped) * albedo);
        let weight = stopped + reflected;
        if part * weight < stopped {
            let depth = -(-part * weight).ln_1p();
            return self.collision(self.view, depth).map(|scatter| (scatter, weight));
        }
        let place = self.view.ground().filter(|_| reflected > 0.0)?;
        Some((Scatter::on_ground(self.shells, place), weight / albedo))
    }

    /// What is met behind an optical depth.
    fn collision(&self, way: &Way, depth: f64) -> Option<Scatter> {
        if depth < way.depth() {
            return Some(Scatter::in_air(self.shells, way.place_behind(depth)));
        }
        way.ground().map(|place| Scatter::on_ground(self.shells, place))
    }

    /// Sunlight that is scattered once to the start of a way, sr⁻¹.
    fn once_scattered(&self, way: &Way, direction: [f64; 3], rng: &mut ChaCha8Rng) -> f64 {
        let ground = seen_ground(self.shells, way);
        let Some((place, weight)) = way.sunlit_place(rng.random(), rng.random()) else { return ground };
        let scatter = Scatter::in_air(self.shells, place);
        let phase = scatter.phase(self.shells, dot(direction, self.shells.sun));
        ground + weight * scatter.coefficient * phase * sunlight(self.shells, place)
    }
}

/// Whether a path goes on; one that does by chance stands for those that did not.
fn survives(weight: &mut f64, rng: &mut ChaCha8Rng) -> bool {
    if *weight >= ROULETTE {
        return true;
    }
    let goes_on = rng.random::<f64>() * ROULETTE < *weight;
    *weight = ROULETTE;
    goes_on
}

/// Something that scatters.
struct Scatter {
    at: [f64; 3],
    /// The part of what it stops that it scatters.
    albedo: f64,
    /// Scattering coefficient, km⁻¹.
    coefficient: f64,
    /// The part that air scatters; None on the ground.
    by_air: Option<f64>,
}

impl Scatter {
    fn on_ground(shells: &Shells, at: [f64; 3]) -> Self {
        Self { at, albedo: shells.band.ground_albedo, coefficient: 0.0, by_air: None }
    }

    fn in_air(shells: &Shells, at: [f64; 3]) -> Self {
        let densities = shells.medium.densities(dot(at, at).sqrt() - shells.medium.ground_radius_km);
        let air = densities[0] * shells.band.air_scattering;
        let coefficient = air + densities[1] * shells.band.aerosol_scattering;
        if coefficient == 0.0 {
            return Self { at, albedo: 0.0, coefficient, by_air: Some(1.0) };
        }
        Self {
            at,
            albedo: coefficient / shells.band.optical_depth(densities),
            coefficient,
            by_air: Some(air / coefficient),
        }
    }

    /// The phase function of air and aerosol together, sr⁻¹.
    fn phase(&self, shells: &Shells, nu: f64) -> f64 {
        let by_air = self.by_air.unwrap_or(0.0);
        let aerosol = if by_air < 1.0 {
            (1.0 - by_air) * shells.band.aerosol_phase(shells.medium.aerosol_asymmetry, nu)
        } else {
            0.0
        };
        by_air * air_phase(shells.band.air_depolarisation, nu) + aerosol
    }

    /// A direction as light may have come, and what corrects its chance.
    fn next(&self, shells: &Shells, direction: [f64; 3], rng: &mut ChaCha8Rng) -> ([f64; 3], f64) {
        let Some(by_air) = self.by_air else {
            let normal = unit(self.at);
            return (turned(normal, rng.random::<f64>().sqrt(), rng), 1.0);
        };
        let glow = Glow::seen_from(self.at, shells.sun);
        if let Some(glow) = glow.as_ref().filter(|_| rng.random()) {
            let next = glow.draw(rng);
            return (next, self.correction(shells, dot(direction, next), glow, next));
        }
        let nu = if rng.random::<f64>() < by_air {
            air_angle(shells.band.air_depolarisation, rng)
        } else if let Some(rows) = shells.band.aerosol_phase {
            rows.cosine_of_part(rng.random())
        } else {
            aerosol_angle(shells.medium.aerosol_asymmetry, rng)
        };
        let next = turned(direction, nu, rng);
        (next, glow.map_or(1.0, |glow| self.correction(shells, nu, &glow, next)))
    }

    /// The phase function over the density of directions, half of which come from the glow.
    fn correction(&self, shells: &Shells, nu: f64, glow: &Glow, next: [f64; 3]) -> f64 {
        let phase = self.phase(shells, nu);
        2.0 * phase / (phase + glow.density(next))
    }
}
