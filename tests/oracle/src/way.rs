//! Straight ways through the atmosphere, with their optical depths: what the paths of a Monte Carlo are made of.
//!
//! A way is cut into steps where it passes from shell to shell. A shell is a scale height thick, of the constituent
//! that falls off faster, so that a rule of four nodes has its optical depth to 1e-5. Only what has no optical depth to
//! speak of is left in one shell.

use std::sync::LazyLock;

use crate::column::column_to_top;
use crate::line::{dot, quadratic_roots};
use crate::medium::{Coefficients, Medium};
use crate::quadrature::GaussLegendre;

/// A constituent whose part of the extinction is smaller than this needs no shells of its own.
const MATTERS: f64 = 1e-3;

/// What has an optical depth below this on the longest way needs no finer shells.
const THIN: f64 = 1e-4;

/// A step's chance is at least this part of what it were if the sun shone on all of them alike: the guess may err.
const DOUBT: f64 = 0.1;

static RULE: LazyLock<GaussLegendre<4>> = LazyLock::new(GaussLegendre::new);

/// An atmosphere in shells, at one wavelength and under one sun.
#[derive(Clone, Debug)]
pub(crate) struct Shells<'a> {
    pub(crate) medium: &'a Medium,
    pub(crate) band: &'a Coefficients,
    pub(crate) sun: [f64; 3],
    /// Radii of the borders, from the ground to the top, km.
    radii: Vec<f64>,
    guess: SunGuess,
}

/// A part of a way that lies in one shell, and in the light of the sun or in the planet's shadow.
#[derive(Clone, Copy, Debug)]
struct Step {
    start: f64,
    end: f64,
    /// Optical depth of what is before it.
    before: f64,
    /// Its own optical depth.
    depth: f64,
    /// About what it would scatter to the start if the sun shone alike on all steps that it sees, up to a factor.
    even: f64,
    /// Up to a factor, the chance that sunlight is looked for here.
    chance: f64,
}

/// A way from a place to the ground or to the top of the atmosphere.
#[derive(Clone, Debug)]
pub(crate) struct Way<'a> {
    shells: &'a Shells<'a>,
    start: [f64; 3],
    direction: [f64; 3],
    /// Distance from the point that is nearest to the planet's centre, km; negative before it.
    from_perigee: f64,
    perigee_square: f64,
    steps: Vec<Step>,
    end: f64,
    meets_ground: bool,
}

impl<'a> Shells<'a> {
    pub(crate) fn new(medium: &'a Medium, band: &'a Coefficients, sun: [f64; 3]) -> Self {
        let radii = borders(medium, band).iter().map(|altitude| medium.ground_radius_km + altitude).collect();
        Self { medium, band, sun, radii, guess: SunGuess::new(medium, band) }
    }

    fn shell_of(&self, radius: f64) -> usize {
        let above = self.radii.partition_point(|&border| border <= radius);
        above.clamp(1, self.radii.len() - 1) - 1
    }

    /// Extinction at a distance from the planet's centre, km⁻¹.
    fn extinction(&self, radius: f64) -> f64 {
        self.band.optical_depth(self.medium.densities(radius - self.medium.ground_radius_km))
    }
}

impl<'a> Way<'a> {
    pub(crate) fn new(shells: &'a Shells<'a>, start: [f64; 3], direction: [f64; 3]) -> Self {
        let (from_perigee, perigee_square, end) = (0.0, 0.0, 0.0);
        let (steps, meets_ground) = (Vec::new(), false);
        let mut way = Self { shells, start, direction, from_perigee, perigee_square, steps, end, meets_ground };
        way.lead(start, direction);
        way
    }

    /// Leads the way from another place, which is inside the atmosphere, in another direction.
    pub(crate) fn lead(&mut self, start: [f64; 3], direction: [f64; 3]) {
        let start_square = dot(start, start);
        self.start = start;
        self.direction = direction;
        self.from_perigee = dot(start, direction);
        self.perigee_square = (start_square - self.from_perigee.powi(2)).max(0.0);
        self.steps.clear();
        let shadow = self.shadow(start_square);
        let mut shell = self.shells.shell_of(start_square.sqrt());
        let mut distance = 0.0;
        loop {
            let (end, falls) = self.border(shell, distance);
            self.add_steps(distance, end, shadow);
            distance = end;
            let last = if falls { 0 } else { self.shells.radii.len() - 2 };
            if shell == last {
                (self.end, self.meets_ground) = (distance, falls);
                break;
            }
            shell = if falls { shell - 1 } else { shell + 1 };
        }
        self.choose_chances();
    }

    /// Where the way leaves a shell, and whether downwards.
    fn border(&self, shell: usize, distance: f64) -> (f64, bool) {
        let [below, above] = [0, 1].map(|i| self.shells.radii[shell + i].powi(2) - self.perigee_square);
        let falls = distance < -self.from_perigee && below > 0.0;
        let end = if falls { -below.sqrt() } else { above.max(0.0).sqrt() } - self.from_perigee;
        (end.max(distance), falls)
    }

    /// The distances at which the line meets the planet's shadow as if that had no end.
    fn shadow(&self, start_square: f64) -> [f64; 2] {
        let (sunward, nu) = (dot(self.start, self.shells.sun), dot(self.direction, self.shells.sun));
        let c = start_square - sunward * sunward - self.shells.medium.ground_radius_km.powi(2);
        quadratic_roots(1.0 - nu * nu, self.from_perigee - sunward * nu, c).unwrap_or([f64::INFINITY; 2])
    }

    /// Adds what lies between two distances in one shell, cut at the shadow's edges.
    fn add_steps(&mut self, start: f64, end: f64, shadow: [f64; 2]) {
        let [first, second] = shadow.map(|edge| if edge.is_nan() { end } else { edge.clamp(start, end) });
        for (start, end) in [(start, first), (first, second), (second, end)] {
            if start < end {
                let before = self.depth();
                let depth = self.depth_between(start, end);
                self.steps.push(Step { start, end, before, depth, even: 0.0, chance: 0.0 });
            }
        }
    }

    /// Gives each step a chance by the light that it is guessed to scatter; some to every step that the sun sees at
    /// all.
    fn choose_chances(&mut self) {
        let (mut bright, mut even) = (0.0, 0.0);
        for i in 0..self.steps.len() {
            let step = self.steps[i];
            let middle = 0.5 * (step.start + step.end);
            let radius = self.radius(middle);
            let sunward = dot(self.start, self.shells.sun) + middle * dot(self.direction, self.shells.sun);
            let sunlight = self.shells.guess.sunlight(radius - self.shells.medium.ground_radius_km, sunward / radius);
            let seen = (-step.before).exp() * -(-step.depth).exp_m1();
            self.steps[i].even = if sunlight.is_some() { seen } else { 0.0 };
            self.steps[i].chance = seen * sunlight.unwrap_or(0.0);
            bright += self.steps[i].chance;
            even += self.steps[i].even;
        }
        let doubt = if bright > 0.0 { DOUBT * bright / even } else { 1.0 };
        self.steps.iter_mut().for_each(|step| step.chance += doubt * step.even);
    }

    fn radius(&self, distance: f64) -> f64 {
        (self.perigee_square + (self.from_perigee + distance).powi(2)).sqrt()
    }

    fn depth_between(&self, start: f64, end: f64) -> f64 {
        RULE.integrate(start, end, |distance| self.shells.extinction(self.radius(distance)))
    }

    /// The place at a distance.
    fn place(&self, distance: f64) -> [f64; 3] {
        [0, 1, 2].map(|i| self.start[i] + distance * self.direction[i])
    }

    /// Its optical depth.
    pub(crate) fn depth(&self) -> f64 {
        self.steps.last().map_or(0.0, |step| step.before + step.depth)
    }

    /// Where it meets the ground, if it does.
    pub(crate) fn ground(&self) -> Option<[f64; 3]> {
        self.meets_ground.then(|| self.place(self.end))
    }

    /// The place behind an optical depth, which the way must have.
    pub(crate) fn place_behind(&self, depth: f64) -> [f64; 3] {
        let number = self.steps.partition_point(|step| step.before + step.depth <= depth);
        let step = &self.steps[number.min(self.steps.len() - 1)];
        self.place(self.distance_behind(step, depth - step.before))
    }

    /// The distance behind an optical depth of a step: by Newton's method, and by bisection where that leaves what is
    /// known.
    fn distance_behind(&self, step: &Step, depth: f64) -> f64 {
        let (mut low, mut high) = (step.start, step.end);
        let mut distance = low + (high - low) * (depth / step.depth).clamp(0.0, 1.0);
        for _ in 0..60 {
            let excess = self.depth_between(step.start, distance) - depth;
            if excess.abs() <= 1e-9 * step.depth {
                break;
            }
            *(if excess > 0.0 { &mut high } else { &mut low }) = distance;
            let next = distance - excess / self.shells.extinction(self.radius(distance));
            distance = if low < next && next < high { next } else { 0.5 * (low + high) };
        }
        distance
    }

    /// A place where sunlight may be scattered towards the start, chosen by two numbers at random from 0 to 1, and the
    /// light that is left of what comes from there over the density of its choice, km. None where all is in the shadow.
    pub(crate) fn sunlit_place(&self, step: f64, within: f64) -> Option<([f64; 3], f64)> {
        let all: f64 = self.steps.iter().map(|step| step.chance).sum();
        let mut left = step * all;
        let chosen = self.steps.iter().filter(|step| step.chance > 0.0).find(|step| {
            left -= step.chance;
            left < 0.0
        })?;
        let (distance, weight) = self.place_within(chosen, within);
        Some((self.place(distance), weight * all / chosen.chance))
    }

    /// A distance in a step, and the light that is left from there over the density of its choice, km: evenly in what
    /// is thin, and in what is opaque by the light that is left.
    fn place_within(&self, step: &Step, within: f64) -> (f64, f64) {
        let stopped = -(-step.depth).exp_m1();
        if step.depth > 1.0 {
            let distance = self.distance_behind(step, -(-within * stopped).ln_1p());
            return (distance, (-step.before).exp() * stopped / self.shells.extinction(self.radius(distance)));
        }
        let width = step.end - step.start;
        let distance = step.start + within * width;
        (distance, (-step.before - self.depth_between(step.start, distance)).exp() * width)
    }
}

/// About what part of sunlight reaches a place: good enough to choose by, and for nothing else.
#[derive(Clone, Debug)]
struct SunGuess {
    ground_radius: f64,
    top: f64,
    /// Optical depths to the top, straight up and level, by the square root of the altitude.
    depths: Vec<[f64; 2]>,
}

impl SunGuess {
    const LAST: usize = 127;

    fn new(medium: &Medium, band: &Coefficients) -> Self {
        let top = medium.top_altitude_km();
        let depths = |i: usize| {
            let altitude = top * (i as f64 / Self::LAST as f64).powi(2);
            [1.0, 0.0].map(|mu| band.optical_depth(column_to_top(medium, altitude, mu)))
        };
        Self { ground_radius: medium.ground_radius_km, top, depths: (0..=Self::LAST).map(depths).collect() }
    }

    fn depths(&self, altitude: f64) -> [f64; 2] {
        let place = (altitude / self.top).clamp(0.0, 1.0).sqrt() * Self::LAST as f64;
        let below = (place as usize).min(Self::LAST - 1);
        let part = place - below as f64;
        [0, 1].map(|i| self.depths[below][i] * (1.0 - part) + self.depths[below + 1][i] * part)
    }

    /// Optical depth upwards: that straight up and the level one at the ends.
    fn upwards(&self, altitude: f64, mu: f64) -> f64 {
        let [vertical, level] = self.depths(altitude);
        if level == 0.0 { 0.0 } else { vertical / (mu * mu + (vertical / level).powi(2)).sqrt() }
    }

    /// None in the planet's shadow.
    fn sunlight(&self, altitude: f64, mu: f64) -> Option<f64> {
        if mu >= 0.0 {
            return Some((-self.upwards(altitude, mu)).exp());
        }
        let lowest = (self.ground_radius + altitude) * ((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt() - self.ground_radius;
        let depth = 2.0 * self.depths(lowest)[1] - self.upwards(altitude, -mu);
        (lowest > 0.0).then(|| (-depth).min(0.0).exp())
    }
}

/// Altitudes of the shells' borders, km.
fn borders(medium: &Medium, band: &Coefficients) -> Vec<f64> {
    let top = medium.top_altitude_km();
    let longest = 2.0 * (top * (top + 2.0 * medium.ground_radius_km)).sqrt();
    let mut borders = vec![0.0];
    let mut low = 0.0;
    while let Some(scale_height) = steepest_fall(medium, band, low, THIN / longest) {
        low += scale_height;
        borders.push(low);
    }
    if band.ozone_absorption > 0.0 || !medium.levels.is_empty() {
        borders.extend(medium.kinks_km());
    }
    borders.retain(|&border| border == 0.0 || (0.0..top).contains(&border));
    borders.push(top);
    borders.sort_by(f64::total_cmp);
    borders.dedup();
    borders
}

/// The smaller scale height (km) of air and aerosol, of those that matter at an altitude below the top; None where
/// neither extinguishes more than `thin` (km⁻¹).
fn steepest_fall(medium: &Medium, band: &Coefficients, altitude: f64, thin: f64) -> Option<f64> {
    let [air, aerosol, ..] = medium.densities(altitude);
    let extinctions = [air * band.air_scattering, aerosol * band.aerosol_extinction];
    let least = thin.max(MATTERS * (extinctions[0] + extinctions[1]));
    let scale_heights = [medium.air_scale_height_km(altitude), medium.aerosol_scale_height_km];
    let matter = scale_heights.into_iter().zip(extinctions).filter(|(_, extinction)| *extinction > least);
    let steepest = matter.map(|(scale_height, _)| scale_height).reduce(f64::min);
    steepest.filter(|_| altitude < medium.top_altitude_km())
}
