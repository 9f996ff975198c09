//! Light that was scattered once, by quadrature.
//!
//! The view ray is cut at its perigee, at the planet's shadow, at the corners of the ozone profile and where the other
//! profiles and the light near the eye fade, then bisected until a panel agrees with its two halves. Its optical depth
//! comes from the same nodes, as the exact integral of the polynomial through them.

use std::sync::LazyLock;

use crate::column::column_to_top;
use crate::line::{Line, cross, dot, entry_distance, length_in_atmosphere, line_from_entry, quadratic_roots};
use crate::medium::{CONSTITUENTS, Coefficients, Medium};
use crate::phase::air_phase;
use crate::quadrature::GaussLegendre;
use crate::ray::Ray;

/// Largest difference that a panel of the view ray may have from its two halves, relative to the
/// whole radiance.
///
/// The halves are kept, so the radiance is closer than this: within 4e-9 where it was measured.
pub const TOLERANCE: f64 = 1e-8;

/// Bisections after which a panel is taken as it is, 1e-6 of its first width.
const MAX_BISECTIONS: u32 = 20;

/// Nodes per panel of the view ray.
const VIEW_ORDER: usize = 10;

/// Altitudes, in scale heights of each constituent, and distances from the eye, in mean free paths,
/// at which the view ray is cut: no corners, but a first panel that were much longer than what is
/// bright in it could step over it.
const FADING_SCALE_HEIGHTS: [f64; 3] = [4.0, 12.0, 30.0];
const FADING_MEAN_FREE_PATHS: [f64; 3] = [3.0, 30.0, 300.0];

/// Light that passes the ground within rounding grazes it.
const GRAZING: f64 = 1.0 - 1e-12;

static VIEW_RULE: LazyLock<GaussLegendre<VIEW_ORDER>> = LazyLock::new(GaussLegendre::new);

/// Radiance that the atmosphere scattered once, over black ground, for a solar irradiance of 1 at the top of the
/// atmosphere, sr⁻¹.
pub fn scattered_radiance(medium: &Medium, coefficients: &Coefficients, ray: &Ray) -> f64 {
    scattered_radiance_bands(medium, std::slice::from_ref(coefficients), ray)[0]
}

/// [`scattered_radiance`] at several wavelengths, which share the geometry of the ray and so most
/// of the cost.
pub fn scattered_radiance_bands(medium: &Medium, bands: &[Coefficients], ray: &Ray) -> Vec<f64> {
    scattered_radiance_bands_within(TOLERANCE, medium, bands, ray)
}

/// [`scattered_radiance_bands`] with a tolerance other than [`TOLERANCE`].
pub fn scattered_radiance_bands_within(tolerance: f64, medium: &Medium, bands: &[Coefficients], ray: &Ray) -> Vec<f64> {
    match ViewPath::new(medium, ray) {
        Some(path) => Integral::new(tolerance, medium, bands, &path).radiance(),
        None => vec![0.0; bands.len()],
    }
}

/// The part of a view ray that is inside the atmosphere and above the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ViewPath {
    /// The ray from the observer or, where that is beyond the atmosphere, from where it enters.
    pub(crate) line: Line,
    /// How far before that the observer is, km.
    pub(crate) entry: f64,
    /// Its length, km.
    pub(crate) length: f64,
    /// Distance of its origin from the plane through the planet's centre that faces the sun, km
    /// (positive by day).
    pub(crate) sunward: f64,
    /// Cosine between view and sun.
    pub(crate) nu: f64,
    /// Squared sine between view and sun; from the cross product, as 1 − ν² would cancel near the
    /// sun.
    sin2: f64,
}

impl ViewPath {
    /// None where the ray misses the atmosphere.
    pub(crate) fn new(medium: &Medium, ray: &Ray) -> Option<Self> {
        assert!(ray.observer_altitude_km >= 0.0, "the observer is under the ground");
        let (view, sun) = (ray.view, ray.sun);
        let nu = dot(view, sun);
        let observer = Line::new(medium, ray.observer_altitude_km, view[2]);
        let entry = entry_distance(medium, &observer, view[0].hypot(view[1]))?;
        let line = line_from_entry(medium, &observer, entry);
        let sunward = observer.radius * sun[2] + entry * nu;
        let cross = cross(view, sun);
        let length = length_in_atmosphere(medium, &line);
        Some(Self { line, entry, length, sunward, nu, sin2: dot(cross, cross) })
    }

    pub(crate) fn altitude(&self, s: f64) -> f64 {
        self.line.altitude + self.line.climb(s)
    }

    /// Cosine of the sun's zenith angle above the point at distance `s`.
    pub(crate) fn mu_sun(&self, s: f64) -> f64 {
        let radius = self.line.radius + self.line.climb(s);
        ((self.sunward + s * self.nu) / radius).clamp(-1.0, 1.0)
    }

    /// Whether the sun is seen from the point at distance `s`.
    ///
    /// The shadow is half a cylinder: behind the planet's centre and nearer to its axis than the
    /// ground radius, r² − (p·sun)² < R², here with r² − R² = h (h + 2R). What grazes the ground is lit: along a ray
    /// that points away from a sun on the horizon every point does, and rounding must not darken some of them.
    pub(crate) fn is_lit(&self, medium: &Medium, s: f64) -> bool {
        let altitude = self.altitude(s);
        let sunward = self.sunward + s * self.nu;
        sunward >= 0.0 || altitude * (altitude + 2.0 * medium.ground_radius_km) >= GRAZING * sunward * sunward
    }

    /// Distances at which the ray through the sun has its perigee at `altitude`; for altitude 0,
    /// the shadow's edge.
    pub(crate) fn sun_perigee_crossings(&self, altitude: f64) -> Option<[f64; 2]> {
        let below = self.line.altitude - altitude;
        let c = below * (2.0 * self.line.radius - below) - self.sunward * self.sunward;
        let half_b = self.line.radius * self.line.mu - self.sunward * self.nu;
        quadratic_roots(self.sin2, half_b, c)
    }

    /// Distances between which everything along the ray is smooth, from 0 to the ray's length.
    pub(crate) fn smooth_pieces(&self, medium: &Medium, bands: &[Coefficients]) -> Vec<f64> {
        let has = |of: fn(&Coefficients) -> f64| bands.iter().any(|band| of(band) > 0.0);
        let has_kinks = has(|band| band.ozone_absorption) || !medium.levels.is_empty();
        let kinks = if has_kinks { medium.kinks_km() } else { Vec::new() };
        let mut fading = Vec::new();
        if has(|band| band.air_scattering) {
            fading.extend(FADING_SCALE_HEIGHTS.map(|n| n * medium.air_scale_height_km));
        }
        if has(|band| band.aerosol_extinction) {
            fading.extend(FADING_SCALE_HEIGHTS.map(|n| n * medium.aerosol_scale_height_km));
        }
        let shells = kinks.iter().chain(&fading).filter_map(|&h| self.line.crossings(h));
        // Sunlight that has grazed a layer as thin as that fades within a few of its scale heights, too.
        let grazed = kinks.iter().chain(&[0.0]).chain(&fading).filter_map(|&h| self.sun_perigee_crossings(h));
        let mut cuts: Vec<f64> = shells
            .chain(grazed)
            .flatten()
            .chain(self.fading_at_the_eye(medium, bands))
            .chain([-self.line.radius * self.line.mu])
            .filter(|&s| s > 0.0 && s < self.length)
            .chain([0.0, self.length])
            .collect();
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        cuts
    }

    /// Distances at which light fades before the eye, if the density stays what it is there.
    fn fading_at_the_eye(&self, medium: &Medium, bands: &[Coefficients]) -> [f64; 3] {
        let densities = medium.densities(self.line.altitude);
        let thickest = bands.iter().map(|band| band.optical_depth(densities)).fold(f64::MIN_POSITIVE, f64::max);
        FADING_MEAN_FREE_PATHS.map(|n| n / thickest)
    }
}

/// What one stretch of the view ray adds, seen from where it starts.
#[derive(Clone, Debug)]
struct Stretch {
    /// Its columns, km.
    column: [f64; CONSTITUENTS],
    /// The radiance that it scatters to its start, per band, sr⁻¹.
    radiance: Vec<f64>,
}

/// A stretch that is still to be integrated.
#[derive(Clone, Copy, Debug)]
struct Panel {
    start: f64,
    end: f64,
    /// Whether the sun sees it; the edges of the shadow are ends of panels.
    lit: bool,
}

/// ∫ (β_air ρ_air P_air + β_aerosol ρ_aerosol P_aerosol) exp(−τ_view − τ_sun) ds over the lit part
/// of a view ray.
struct Integral<'a> {
    tolerance: f64,
    medium: &'a Medium,
    bands: &'a [Coefficients],
    path: &'a ViewPath,
    /// Phase functions along the whole ray, sr⁻¹: of air and of aerosol, per band.
    air_phases: Vec<f64>,
    aerosol_phases: Vec<f64>,
}

impl<'a> Integral<'a> {
    fn new(tolerance: f64, medium: &'a Medium, bands: &'a [Coefficients], path: &'a ViewPath) -> Self {
        let air_phases = bands.iter().map(|band| air_phase(band.air_depolarisation, path.nu)).collect();
        let aerosol_phases = bands.iter().map(|band| band.aerosol_phase(medium.aerosol_asymmetry, path.nu)).collect();
        Self { tolerance, medium, bands, path, air_phases, aerosol_phases }
    }

    fn radiance(&self) -> Vec<f64> {
        let panels = self.first_panels();
        let coarse: Vec<Stretch> = panels.iter().map(|panel| self.stretch(*panel)).collect();
        let mut scale = coarse.iter().fold(self.nothing(), |sum, next| self.join(&sum, next)).radiance;
        loop {
            // A NaN would never agree with its halves, and the bisection would not end in our time.
            assert!(scale.iter().all(|radiance| radiance.is_finite()), "radiance is not finite");
            let mut sum = self.nothing();
            for (panel, whole) in panels.iter().zip(&coarse) {
                let accuracy = self.accuracy_after(sum.column, &scale);
                sum = self.join(&sum, &self.refined(*panel, whole, &accuracy, MAX_BISECTIONS));
            }
            // A first guess that was much too bright has asked for too little.
            if sum.radiance.iter().zip(&scale).all(|(radiance, scale)| *radiance >= 0.5 * scale) {
                return sum.radiance;
            }
            scale = sum.radiance;
        }
    }

    fn first_panels(&self) -> Vec<Panel> {
        let cuts = self.path.smooth_pieces(self.medium, self.bands);
        cuts.windows(2)
            .map(|ends| {
                let lit = self.path.is_lit(self.medium, 0.5 * (ends[0] + ends[1]));
                Panel { start: ends[0], end: ends[1], lit }
            })
            .collect()
    }

    /// Error in radiance that a stretch behind this column may have, per band, for the whole to be
    /// in tolerance.
    fn accuracy_after(&self, column: [f64; CONSTITUENTS], scale: &[f64]) -> Vec<f64> {
        let allowed = |(band, &scale): (&Coefficients, &f64)| {
            // Light so faint that it underflows has no digits to ask for.
            if scale < 1e-290 {
                return f64::INFINITY;
            }
            self.tolerance * scale * band.optical_depth(column).exp()
        };
        self.bands.iter().zip(scale).map(allowed).collect()
    }

    /// The panel as its two halves and, until those agree with the whole, their halves.
    fn refined(&self, panel: Panel, whole: &Stretch, accuracy: &[f64], bisections: u32) -> Stretch {
        let middle = 0.5 * (panel.start + panel.end);
        let halves = [Panel { end: middle, ..panel }, Panel { start: middle, ..panel }];
        let [near, far] = halves.map(|half| self.stretch(half));
        let both = self.join(&near, &far);
        if bisections == 0 || self.agree(whole, &both, accuracy) {
            return both;
        }
        let near = self.refined(halves[0], &near, accuracy, bisections - 1);
        let far = self.refined(halves[1], &far, accuracy, bisections - 1);
        self.join(&near, &far)
    }

    /// Whether two integrals of one panel are close in radiance and in transmittance.
    ///
    /// What lies behind is dimmed by exp(−τ) and cannot be brighter than the phase function, so an
    /// error in τ matters less the more opaque the panel is.
    fn agree(&self, a: &Stretch, b: &Stretch, accuracy: &[f64]) -> bool {
        let difference = std::array::from_fn(|i| (a.column[i] - b.column[i]).abs());
        self.bands.iter().enumerate().all(|(i, band)| {
            let brightest = self.air_phases[i].max(self.aerosol_phases[i]);
            let depth_error = band.optical_depth(difference);
            let behind = brightest * (-band.optical_depth(b.column)).exp();
            // Close to itself is enough too: the scale is a first guess, and everything adds up.
            let enough = accuracy[i].max(self.tolerance * b.radiance[i]);
            (a.radiance[i] - b.radiance[i]).abs() <= enough
                && (depth_error <= self.tolerance || depth_error * behind <= accuracy[i])
        })
    }

    /// A panel by the Gauss-Legendre rule alone.
    fn stretch(&self, panel: Panel) -> Stretch {
        let rule = &*VIEW_RULE;
        let width = panel.end - panel.start;
        let distances = rule.nodes.map(|x| panel.start + width * x);
        let densities = distances.map(|s| self.medium.densities(self.path.altitude(s)));
        let column = |weights: &[f64; VIEW_ORDER]| -> [f64; CONSTITUENTS] {
            std::array::from_fn(|i| {
                width * weights.iter().zip(&densities).map(|(w, density)| w * density[i]).sum::<f64>()
            })
        };
        let mut sum = Stretch { column: column(&rule.weights), ..self.nothing() };
        if !panel.lit {
            return sum;
        }
        for node in 0..VIEW_ORDER {
            let to_sun = self.column_to_sun(distances[node]);
            let to_start = column(&rule.running[node]);
            let both = std::array::from_fn(|i| to_start[i] + to_sun[i]);
            self.add_scattered(&mut sum.radiance, width * rule.weights[node], densities[node], both);
        }
        sum
    }

    fn column_to_sun(&self, s: f64) -> [f64; CONSTITUENTS] {
        column_to_top(self.medium, self.path.altitude(s), self.path.mu_sun(s))
    }

    /// Adds what a point scatters, `weight` km long and seen through `column`.
    fn add_scattered(&self, sum: &mut [f64], weight: f64, density: [f64; CONSTITUENTS], column: [f64; CONSTITUENTS]) {
        let phases = self.air_phases.iter().zip(&self.aerosol_phases);
        for ((sum, band), (air, aerosol)) in sum.iter_mut().zip(self.bands).zip(phases) {
            let scattered =
                weight * (density[0] * air * band.air_scattering + density[1] * aerosol * band.aerosol_scattering);
            *sum += scattered * (-band.optical_depth(column)).exp();
        }
    }

    /// Two stretches, one behind the other, as one.
    fn join(&self, near: &Stretch, far: &Stretch) -> Stretch {
        let seen = |(i, band): (usize, &Coefficients)| {
            near.radiance[i] + far.radiance[i] * (-band.optical_depth(near.column)).exp()
        };
        Stretch {
            column: std::array::from_fn(|i| near.column[i] + far.column[i]),
            radiance: self.bands.iter().enumerate().map(seen).collect(),
        }
    }

    fn nothing(&self) -> Stretch {
        Stretch { column: [0.0; CONSTITUENTS], radiance: vec![0.0; self.bands.len()] }
    }
}
