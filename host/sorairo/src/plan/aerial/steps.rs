//! Samples of a ray between given distances.

use std::ops::Range;

use sorairo_shared::geometry::{Ray, Shadow};
use sorairo_shared::glam::{Vec2, Vec4};
use sorairo_shared::medium::atmosphere::{ColumnDensities, Medium};
use sorairo_shared::medium::bands::Coefficients;
use sorairo_shared::medium::tables::shadow_at;
use sorairo_shared::path::pieces::Sample;
use sorairo_shared::variant;

use crate::medium::density::densities_at;

/// Gauss-Legendre nodes of a step, on [0, 1], and their weights.
const NODES: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// The integral of the parabola through the values at the nodes, from 0 to each node: `∫ ℓ_j` for the node `i`, the
/// matrix of Gauss's method of the sixth order (Butcher 1964, <https://doi.org/10.1090/S0025-5718-1964-0159424-9>).
const UP_TO_NODE: [[f64; 3]; 3] = [
    [5.0 / 36.0, 0.222_222_222_222_222_2 - 0.258_198_889_747_161_1, 5.0 / 36.0 - 0.129_099_444_873_580_56],
    [5.0 / 36.0 + 0.161_374_306_091_975_7, 2.0 / 9.0, 5.0 / 36.0 - 0.161_374_306_091_975_7],
    [5.0 / 36.0 + 0.129_099_444_873_580_56, 0.222_222_222_222_222_2 + 0.258_198_889_747_161_1, 5.0 / 36.0],
];

/// The longest step: in optical depth; relative to the scale height of the density; and in km, over which a low sun
/// changes. Compared with half the step, each causes an error of at most 3e-4 of a ray's light.
const MOST_DEPTH: f64 = 0.7;
const MOST_FALL_OFF: f64 = 0.8;
const MOST_KM: f64 = 40.0;

/// The optical depth beyond which nothing is visible.
const OPAQUE: f64 = 30.0;

/// How far below the ground (km) a ray continues under a varying sun.
const UNDER_ITS_SUN: f64 = 150.0;

/// A ray, sampled up to each of some distances.
pub struct Steps {
    /// The samples, in order; a distance counts from the observer.
    pub samples: Vec<Sample>,
    /// Cosine of the zenith angle of the sun at each sample, and whether it shines there.
    pub suns: Vec<(f32, bool)>,
    /// The samples between each distance and the one before.
    pub slices: Vec<Range<usize>>,
    /// Column densities up to each distance.
    pub columns: Vec<ColumnDensities>,
}

/// The medium of a ray.
pub struct Walk<'a> {
    /// What fills the air.
    pub medium: Medium<'a>,
    /// What it has, and what a ray meets.
    pub variant: u32,
    /// The coefficients at the wavelength for which steps are made.
    pub coefficients: Coefficients<Vec4>,
}

/// A ray in double precision.
#[derive(Clone, Copy)]
struct Line {
    ground: f64,
    altitude: f64,
    mu: f64,
    mu_s: f64,
    nu: f64,
    /// Where it meets the ground; infinite where it does not.
    ends: f64,
}

/// A place on it.
#[derive(Clone, Copy)]
struct Place {
    radius: f64,
    altitude: f64,
}

impl Line {
    fn new(medium: Medium<'_>, ray: Ray) -> Self {
        let ground = f64::from(medium.atmosphere.ground_radius);
        let [altitude, mu, mu_s, nu] = [ray.altitude, ray.mu, ray.mu_s, ray.nu].map(f64::from);
        let line = Self { ground, altitude, mu, mu_s, nu, ends: f64::INFINITY };
        let on_ground = line.at_radius(ground).filter(|ends| mu < 0.0 && ends[0] >= 0.0);
        Self { ends: on_ground.map_or(f64::INFINITY, |ends| ends[0]), ..line }
    }

    fn radius(&self) -> f64 {
        self.ground + self.altitude
    }

    /// The two distances at which it is so far from the planet's centre.
    fn at_radius(&self, radius: f64) -> Option<[f64; 2]> {
        let along = self.radius() * self.mu;
        let above = (self.radius() - radius) * (self.radius() + radius);
        let root = along * along - above;
        (root >= 0.0).then(|| [-along - root.sqrt(), -along + root.sqrt()])
    }

    fn at(&self, distance: f64) -> Place {
        let from = self.radius();
        let above = self.altitude * (self.ground + from) + distance * (2.0 * from * self.mu + distance);
        let radius = (self.ground * self.ground + above).max(1.0).sqrt();
        Place { radius, altitude: (above / (radius + self.ground)).max(0.0) }
    }

    /// The cosine of its zenith angle at a distance.
    fn zenith_cosine(&self, distance: f64) -> f64 {
        let distance = distance.min(self.ends + UNDER_ITS_SUN);
        ((self.radius() * self.mu + distance) / self.at(distance).radius).clamp(-1.0, 1.0)
    }

    /// The cosine of the sun's zenith angle at a distance.
    fn sun_cosine(&self, distance: f64) -> f64 {
        let distance = distance.min(self.ends + UNDER_ITS_SUN);
        ((self.radius() * self.mu_s + distance * self.nu) / self.at(distance).radius).clamp(-1.0, 1.0)
    }
}

impl Walk<'_> {
    /// The samples of a ray up to distances (km) that grow.
    pub fn steps(&self, ray: Ray, distances: &[f64]) -> Steps {
        let line = Line::new(self.medium, ray);
        let air = line.at_radius(line.ground + f64::from(self.medium.atmosphere.depth)).unwrap_or([0.0; 2]);
        let mut steps = Steps { samples: Vec::new(), suns: Vec::new(), slices: Vec::new(), columns: Vec::new() };
        let (mut along, mut depth, mut column) = (air[0].max(0.0), 0.0, [0.0; 5]);
        for &distance in distances {
            let first = steps.samples.len();
            let end = distance.min(air[1]);
            while along < end && depth < OPAQUE {
                let to = self.step(&line, along, end);
                depth += self.take(&line, along..to, &mut column, &mut steps);
                along = to;
            }
            steps.slices.push(first..steps.samples.len());
            steps.columns.push(columns(column));
        }
        steps
    }

    /// Where the step ends that begins at a distance.
    fn step(&self, line: &Line, from: f64, end: f64) -> f64 {
        let here = line.at(from).altitude;
        let density = self.densities(here);
        let extinction = self.extinction(density);
        let fall_off = self.fall_off(density);
        let mut step = (end - from).min(MOST_KM).min(MOST_DEPTH / extinction.max(1e-9));
        let climbed = |step: f64| (line.at(from + step).altitude - here).abs();
        while climbed(step) > MOST_FALL_OFF * fall_off {
            step *= 0.7;
        }
        let to = if from + 1.3 * step > end { end } else { from + step };
        // Densities have a corner on the ground.
        let to = if from < line.ends && line.ends < to { line.ends } else { to };
        self.shadow_edge(line, from, to).unwrap_or(to)
    }

    /// Where the planet's shadow begins or ends in a step, if it does so far enough from its beginning.
    fn shadow_edge(&self, line: &Line, from: f64, to: f64) -> Option<f64> {
        /// Halves of a step of [`MOST_KM`], down to a metre.
        const HALVINGS: u32 = 16;
        let began = self.is_lit(line, from);
        if self.is_lit(line, to) == began {
            return None;
        }
        let (mut low, mut high) = (from, to);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.is_lit(line, middle) == began { low = middle } else { high = middle }
        }
        // The next step then begins behind it.
        (high > from).then_some(high)
    }

    /// Whether the sun shines at a distance: see [`Shadow`].
    fn is_lit(&self, line: &Line, distance: f64) -> bool {
        let mu_s = line.sun_cosine(distance);
        if self.variant & variant::SHADOW == 0 || mu_s >= 0.0 {
            return true;
        }
        let Place { radius, altitude } = line.at(distance);
        let shell = self.medium.shell();
        let is_bent = self.variant & variant::TABLES != 0 && shell.shadow.slope > 0.0;
        let Shadow { offset, slope, begin } =
            if is_bent { shadow_at(self.medium, altitude as f32) } else { shell.shadow };
        let (behind, across) = (-radius.max(line.ground) * mu_s, radius.max(line.ground) * mu_s.acos().sin());
        let wide = line.ground + f64::from(offset) - f64::from(slope) * behind;
        behind <= f64::from(begin) || across >= wide
    }

    /// Adds the samples of a step, and tells its optical depth.
    fn take(&self, line: &Line, step: Range<f64>, column: &mut [f64; 5], steps: &mut Steps) -> f64 {
        let length = step.end - step.start;
        let places = NODES.map(|(node, _)| step.start + node * length);
        let densities = places.map(|place| self.densities(line.at(place).altitude));
        for (i, &distance) in places.iter().enumerate() {
            let before =
                |k: usize| column[k] + length * (0..3).map(|j| UP_TO_NODE[i][j] * densities[j][k]).sum::<f64>();
            steps.samples.push(Sample {
                distance: distance as f32,
                altitude: line.at(distance).altitude as f32,
                mu: line.zenith_cosine(distance) as f32,
                weight: (NODES[i].1 * length) as f32,
                density: Vec2::new(densities[i][0] as f32, densities[i][1] as f32),
                to_observer: columns(std::array::from_fn(before)),
            });
            steps.suns.push((line.sun_cosine(distance) as f32, self.is_lit(line, distance)));
        }
        let mean: [f64; 5] = std::array::from_fn(|k| (0..3).map(|i| NODES[i].1 * densities[i][k]).sum());
        column.iter_mut().zip(mean).for_each(|(column, mean)| *column += mean * length);
        self.extinction(mean) * length
    }

    /// Relative densities of air, aerosol and ozone, and of the gases per km of their columns.
    fn densities(&self, altitude: f64) -> [f64; 5] {
        if altitude > f64::from(self.medium.atmosphere.depth) {
            return [0.0; 5];
        }
        densities_at(self.medium, altitude, self.variant)
    }

    /// The extinction coefficient (km⁻¹) of such densities.
    fn extinction(&self, densities: [f64; 5]) -> f64 {
        f64::from(self.coefficients.optical_depth(columns(densities)).x)
    }

    /// The height over which such air falls off (km).
    fn fall_off(&self, [air, aerosol, ..]: [f64; 5]) -> f64 {
        let atmosphere = self.medium.atmosphere;
        let of_air = air * f64::from(self.coefficients.air_scattering.x);
        let of_aerosol = aerosol * f64::from(self.coefficients.aerosol_extinction.x);
        let [of_air_height, of_aerosol_height] =
            [atmosphere.air.scale_height, atmosphere.aerosol.scale_height].map(f64::from);
        let falls = of_air / of_air_height + of_aerosol / of_aerosol_height;
        ((of_air + of_aerosol) / falls.max(f64::MIN_POSITIVE)).clamp(0.1, 20.0)
    }
}

fn columns([air, aerosol, ozone, pairs, water]: [f64; 5]) -> ColumnDensities {
    let [air, aerosol, ozone, pairs, water] = [air, aerosol, ozone, pairs, water].map(|value| value as f32);
    ColumnDensities { air, aerosol, ozone, pairs, water }
}
