//! The oracle: single-scattered sky radiance in f64, written from the equations and for trust, not
//! for speed.
//!
//! It shares no code, no table and no quadrature with the implementation that it judges. Every
//! integral is a Gauss-Legendre rule on pieces where the integrand is smooth:
//!
//! * **sun columns** run outwards from the lowest point of a ray, on panels a fixed number of scale
//!   heights long;
//! * **the view ray** is cut at its perigee, at the planet's shadow, at the corners of the ozone
//!   profile and where the other profiles and the light near the eye fade, then bisected until a
//!   panel agrees with its two halves. Its optical depth comes from
//!   the same nodes, as the exact integral of the polynomial through them.
//!
//! Lengths are in km, coefficients in km⁻¹, z is up, x north, y west. The ground is black, light
//! does not bend, and the atmosphere ends at its top radius.

use std::f64::consts::PI;
use std::sync::LazyLock;

use sorairo::scene::Scene;
use sorairo::spectra::optics::Optics;

/// Largest difference that a panel of the view ray may have from its two halves, relative to the
/// whole radiance.
///
/// The halves are kept, so the radiance is closer than this: within 4e-9 where it was measured.
pub const TOLERANCE: f64 = 1e-8;

/// Bisections after which a panel is taken as it is, 1e-6 of its first width.
const MAX_BISECTIONS: u32 = 20;

/// Nodes per panel of the view ray.
const VIEW_ORDER: usize = 10;

/// Nodes per panel of an exponential column.
const COLUMN_ORDER: usize = 16;

/// Nodes per linear piece of the ozone profile; nearly a parabola along a ray, so few suffice.
const OZONE_ORDER: usize = 8;

/// Panel ends of an exponential column, in scale heights above its lowest point; e⁻⁴² is below f64
/// rounding.
const COLUMN_PANELS: [f64; 3] = [7.0, 18.0, 42.0];

/// Altitudes, in scale heights of each constituent, and distances from the eye, in mean free paths,
/// at which the view ray is cut: no corners, but a first panel that were much longer than what is
/// bright in it could step over it.
const FADING_SCALE_HEIGHTS: [f64; 3] = [4.0, 12.0, 30.0];
const FADING_MEAN_FREE_PATHS: [f64; 3] = [3.0, 30.0, 300.0];

/// Light that passes the ground within rounding grazes it.
const GRAZING: f64 = 1.0 - 1e-12;

static VIEW_RULE: LazyLock<GaussLegendre<VIEW_ORDER>> = LazyLock::new(GaussLegendre::new);
static COLUMN_RULE: LazyLock<GaussLegendre<COLUMN_ORDER>> = LazyLock::new(GaussLegendre::new);
static OZONE_RULE: LazyLock<GaussLegendre<OZONE_ORDER>> = LazyLock::new(GaussLegendre::new);

/// The planet and the shapes of its three constituents, the same at every wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Radius of the black ground, km.
    pub ground_radius_km: f64,
    /// Radius at which the atmosphere ends, km.
    pub top_radius_km: f64,
    /// Scale height of the air's density, km.
    pub air_scale_height_km: f64,
    /// Scale height of the aerosol's density, km.
    pub aerosol_scale_height_km: f64,
    /// Asymmetry g of the aerosol's phase function, in (-1, 1).
    pub aerosol_asymmetry: f64,
    /// Altitude under which there is no ozone, km.
    pub ozone_bottom_km: f64,
    /// Altitude at which the ozone's density is 1, km.
    pub ozone_peak_km: f64,
    /// Altitude above which there is no ozone, km.
    pub ozone_top_km: f64,
}

/// What the constituents do to light of one wavelength where their density is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Scattering by air, which does not absorb, km⁻¹.
    pub air_scattering: f64,
    /// Extinction (scattering and absorption) by aerosol, km⁻¹.
    pub aerosol_extinction: f64,
    /// Scattering by aerosol, km⁻¹.
    pub aerosol_scattering: f64,
    /// Absorption by ozone, which does not scatter, km⁻¹.
    pub ozone_absorption: f64,
}

/// Who looks where, and where the sun is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Altitude of the observer, who stands on the z axis, km; not negative, and free to be beyond
    /// the atmosphere.
    pub observer_altitude_km: f64,
    /// Unit vector along the view.
    pub view: [f64; 3],
    /// Unit vector towards the sun.
    pub sun: [f64; 3],
}

/// The medium of a scene.
pub fn medium(scene: &Scene) -> Medium {
    let a = &scene.atmosphere;
    Medium {
        ground_radius_km: a.ground_radius,
        top_radius_km: a.top_radius,
        air_scale_height_km: a.air.scale_height,
        aerosol_scale_height_km: a.aerosol.scale_height,
        aerosol_asymmetry: a.aerosol.asymmetry,
        ozone_bottom_km: a.ozone.bottom,
        ozone_peak_km: a.ozone.peak,
        ozone_top_km: a.ozone.top,
    }
}

/// The coefficients of a scene at a wavelength (nm).
pub fn coefficients(scene: &Scene, wavelength: f64) -> Coefficients {
    let c = Optics::new(scene).at(wavelength);
    Coefficients {
        air_scattering: c.air_scattering,
        aerosol_extinction: c.aerosol_extinction,
        aerosol_scattering: c.aerosol_scattering,
        ozone_absorption: c.ozone_absorption,
    }
}

/// The ray of a scene towards an elevation and an azimuth (degrees).
pub fn ray(scene: &Scene, elevation: f64, azimuth: f64) -> Ray {
    Ray {
        observer_altitude_km: scene.observer.altitude,
        view: direction(elevation, azimuth),
        sun: direction(scene.sun.elevation, scene.sun.azimuth),
    }
}

/// Unit vector (x north, y west, z up) of an elevation above the horizon and an azimuth clockwise
/// from north, both in degrees.
pub fn direction(elevation_deg: f64, azimuth_deg: f64) -> [f64; 3] {
    let (sin_e, cos_e) = elevation_deg.to_radians().sin_cos();
    let (sin_a, cos_a) = azimuth_deg.to_radians().sin_cos();
    [cos_e * cos_a, -cos_e * sin_a, sin_e]
}

/// Rayleigh phase function of air, sr⁻¹: 3/(16π) (1 + ν²), with ν the cosine of the scattering
/// angle.
pub fn air_phase(nu: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + nu * nu)
}

/// Cornette-Shanks phase function of aerosol, sr⁻¹:
/// 3/(8π) (1 − g²)(1 + ν²) / ((2 + g²)(1 + g² − 2gν)^(3/2)).
pub fn aerosol_phase(asymmetry: f64, nu: f64) -> f64 {
    let g2 = asymmetry * asymmetry;
    let spread = 1.0 + g2 - 2.0 * asymmetry * nu;
    3.0 / (8.0 * PI) * (1.0 - g2) * (1.0 + nu * nu) / ((2.0 + g2) * spread * spread.sqrt())
}

/// Column densities of air, aerosol and ozone from an altitude to the top of the atmosphere, km.
///
/// `mu` is the cosine of the zenith angle. The ray must not meet the ground; it may start beyond
/// the atmosphere.
pub fn column_to_top(medium: &Medium, altitude_km: f64, mu: f64) -> [f64; 3] {
    let line = Line::new(medium, altitude_km, mu);
    let top = medium.top_altitude_km();
    let rising = Line { mu: mu.abs(), ..line };
    let outwards = rising_column(medium, &rising, top);
    if mu >= 0.0 {
        return outwards;
    }
    // Down to the perigee and back up to where it started, the same way twice; then on to the top.
    let inwards = rising_column(medium, &line.rising_half(), altitude_km.min(top));
    std::array::from_fn(|i| 2.0 * inwards[i] + outwards[i])
}

/// Single-scattered radiance for a solar irradiance of 1 at the top of the atmosphere, sr⁻¹.
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

impl Medium {
    /// Altitude of the top of the atmosphere, km.
    pub fn top_altitude_km(&self) -> f64 {
        self.top_radius_km - self.ground_radius_km
    }

    /// Relative densities of air, aerosol and ozone at an altitude, each 1 at its reference: the
    /// ground, the ground and the ozone peak.
    pub fn densities(&self, altitude_km: f64) -> [f64; 3] {
        [
            (-altitude_km / self.air_scale_height_km).exp(),
            (-altitude_km / self.aerosol_scale_height_km).exp(),
            self.ozone_density(altitude_km),
        ]
    }

    /// The tent: 0 at the bottom and at the top, 1 at the peak.
    fn ozone_density(&self, altitude_km: f64) -> f64 {
        if altitude_km <= self.ozone_bottom_km || altitude_km >= self.ozone_top_km {
            0.0
        } else if altitude_km < self.ozone_peak_km {
            (altitude_km - self.ozone_bottom_km) / (self.ozone_peak_km - self.ozone_bottom_km)
        } else {
            (self.ozone_top_km - altitude_km) / (self.ozone_top_km - self.ozone_peak_km)
        }
    }

    /// Altitudes where the ozone profile has a corner, km.
    fn ozone_kinks_km(&self) -> [f64; 3] {
        [self.ozone_bottom_km, self.ozone_peak_km, self.ozone_top_km]
    }
}

impl Coefficients {
    /// Optical depth of a column (air, aerosol, ozone) in km.
    fn optical_depth(&self, column: [f64; 3]) -> f64 {
        self.air_scattering * column[0] + self.aerosol_extinction * column[1] + self.ozone_absorption * column[2]
    }
}

// -------------------------------------------------------------------------------------------------
// Straight lines through spherical shells
// -------------------------------------------------------------------------------------------------

/// A half-line, as a spherical atmosphere sees it.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// Altitude of its origin, km.
    altitude: f64,
    /// Distance of its origin from the planet's centre, km.
    radius: f64,
    /// Cosine of its zenith angle at its origin.
    mu: f64,
}

impl Line {
    fn new(medium: &Medium, altitude: f64, mu: f64) -> Self {
        let radius = medium.ground_radius_km + altitude;
        Self { altitude, radius, mu }
    }

    /// Height of the point at distance `s` above the origin, km.
    ///
    /// r² − r₀² = s (s + 2 r₀ μ) divided by r + r₀, since r − r₀ itself would cancel.
    fn climb(&self, s: f64) -> f64 {
        let square = s * (s + 2.0 * self.radius * self.mu);
        square / ((self.radius * self.radius + square).sqrt() + self.radius)
    }

    /// Distance at which a line that rises (μ ≥ 0) has climbed `height`, km.
    fn distance_to_climb(&self, height: f64) -> f64 {
        let square = height * (height + 2.0 * self.radius);
        let half_b = self.radius * self.mu;
        square / (half_b + (half_b * half_b + square).sqrt()).max(f64::MIN_POSITIVE)
    }

    /// The two distances, maybe negative, at which the whole line crosses the sphere at `altitude`,
    /// in order.
    fn crossings(&self, altitude: f64) -> Option<[f64; 2]> {
        let below = self.altitude - altitude;
        let c = below * (2.0 * self.radius - below);
        quadratic_roots(1.0, self.radius * self.mu, c)
    }

    /// The rising half of this line, from its perigee.
    fn rising_half(&self) -> Self {
        let sin = ((1.0 - self.mu) * (1.0 + self.mu)).sqrt();
        let drop = self.radius * self.mu * self.mu / (1.0 + sin);
        Self { altitude: self.altitude - drop, radius: self.radius * sin, mu: 0.0 }
    }
}

/// Real roots of a s² + 2 b s + c, in order, without cancellation between b and the root of the
/// discriminant.
fn quadratic_roots(a: f64, half_b: f64, c: f64) -> Option<[f64; 2]> {
    let discriminant = half_b * half_b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let q = -(half_b + discriminant.sqrt().copysign(half_b));
    let (first, second) = if q == 0.0 { (0.0, 0.0) } else { (q / a, c / q) };
    Some([first.min(second), first.max(second)])
}

// -------------------------------------------------------------------------------------------------
// Columns to the top of the atmosphere
// -------------------------------------------------------------------------------------------------

/// Columns along a line that rises, from its origin up to an altitude, km.
fn rising_column(medium: &Medium, line: &Line, end_km: f64) -> [f64; 3] {
    if end_km <= line.altitude {
        return [0.0; 3];
    }
    [
        exponential_column(medium.air_scale_height_km, line, end_km),
        exponential_column(medium.aerosol_scale_height_km, line, end_km),
        ozone_column(medium, line, end_km),
    ]
}

/// ∫ exp(−h/H) ds along a line that rises, km.
fn exponential_column(scale_height: f64, line: &Line, end_km: f64) -> f64 {
    let whole_climb = end_km - line.altitude;
    let mut start = 0.0;
    let mut sum = 0.0;
    for scale_heights in COLUMN_PANELS {
        let climb = (scale_heights * scale_height).min(whole_climb);
        let end = line.distance_to_climb(climb);
        sum += COLUMN_RULE.integrate(start, end, |s| (-line.climb(s) / scale_height).exp());
        if climb == whole_climb {
            break;
        }
        start = end;
    }
    sum * (-line.altitude / scale_height).exp()
}

/// ∫ ozone density ds along a line that rises, piece by piece of the tent, km.
fn ozone_column(medium: &Medium, line: &Line, end_km: f64) -> f64 {
    let kinks = medium.ozone_kinks_km().map(|h| h.clamp(line.altitude, end_km));
    let piece = |low: f64, high: f64| {
        if high <= low {
            return 0.0;
        }
        let start = line.distance_to_climb(low - line.altitude);
        let end = line.distance_to_climb(high - line.altitude);
        let density = |s| medium.ozone_density(line.altitude + line.climb(s));
        OZONE_RULE.integrate(start, end, density)
    };
    piece(kinks[0], kinks[1]) + piece(kinks[1], kinks[2])
}

// -------------------------------------------------------------------------------------------------
// The view ray and the sun
// -------------------------------------------------------------------------------------------------

/// The part of a view ray that is inside the atmosphere and above the ground.
#[derive(Clone, Copy, Debug)]
struct ViewPath {
    /// The ray from the observer or, where that is beyond the atmosphere, from where it enters.
    line: Line,
    /// Its length, km.
    length: f64,
    /// Distance of its origin from the plane through the planet's centre that faces the sun, km
    /// (positive by day).
    sunward: f64,
    /// Cosine between view and sun.
    nu: f64,
    /// Squared sine between view and sun; from the cross product, as 1 − ν² would cancel near the
    /// sun.
    sin2: f64,
}

impl ViewPath {
    /// None where the ray misses the atmosphere.
    fn new(medium: &Medium, ray: &Ray) -> Option<Self> {
        assert!(ray.observer_altitude_km >= 0.0, "the observer is under the ground");
        let (view, sun) = (ray.view, ray.sun);
        let nu = dot(view, sun);
        let observer = Line::new(medium, ray.observer_altitude_km, view[2]);
        let entry = entry_distance(medium, &observer, view[0].hypot(view[1]))?;
        let line = line_from_entry(medium, &observer, entry);
        let sunward = observer.radius * sun[2] + entry * nu;
        let cross = cross(view, sun);
        let length = length_in_atmosphere(medium, &line);
        Some(Self { line, length, sunward, nu, sin2: dot(cross, cross) })
    }

    fn altitude(&self, s: f64) -> f64 {
        self.line.altitude + self.line.climb(s)
    }

    /// Cosine of the sun's zenith angle above the point at distance `s`.
    fn mu_sun(&self, s: f64) -> f64 {
        let radius = self.line.radius + self.line.climb(s);
        ((self.sunward + s * self.nu) / radius).clamp(-1.0, 1.0)
    }

    /// Whether the sun is seen from the point at distance `s`.
    ///
    /// The shadow is half a cylinder: behind the planet's centre and nearer to its axis than the
    /// ground radius, r² − (p·sun)² < R², here with r² − R² = h (h + 2R). What grazes the ground is lit: along a ray
    /// that points away from a sun on the horizon every point does, and rounding must not darken some of them.
    fn is_lit(&self, medium: &Medium, s: f64) -> bool {
        let altitude = self.altitude(s);
        let sunward = self.sunward + s * self.nu;
        sunward >= 0.0 || altitude * (altitude + 2.0 * medium.ground_radius_km) >= GRAZING * sunward * sunward
    }

    /// Distances at which the ray through the sun has its perigee at `altitude`; for altitude 0,
    /// the shadow's edge.
    fn sun_perigee_crossings(&self, altitude: f64) -> Option<[f64; 2]> {
        let below = self.line.altitude - altitude;
        let c = below * (2.0 * self.line.radius - below) - self.sunward * self.sunward;
        let half_b = self.line.radius * self.line.mu - self.sunward * self.nu;
        quadratic_roots(self.sin2, half_b, c)
    }

    /// Distances between which everything along the ray is smooth, from 0 to the ray's length.
    fn smooth_pieces(&self, medium: &Medium, bands: &[Coefficients]) -> Vec<f64> {
        let has = |of: fn(&Coefficients) -> f64| bands.iter().any(|band| of(band) > 0.0);
        let ozone: &[f64] = if has(|band| band.ozone_absorption) { &medium.ozone_kinks_km() } else { &[] };
        let mut fading = Vec::new();
        if has(|band| band.air_scattering) {
            fading.extend(FADING_SCALE_HEIGHTS.map(|n| n * medium.air_scale_height_km));
        }
        if has(|band| band.aerosol_extinction) {
            fading.extend(FADING_SCALE_HEIGHTS.map(|n| n * medium.aerosol_scale_height_km));
        }
        let shells = ozone.iter().chain(&fading).filter_map(|&h| self.line.crossings(h));
        // Sunlight that has grazed a layer as thin as that fades within a few of its scale heights, too.
        let grazed = ozone.iter().chain(&[0.0]).chain(&fading).filter_map(|&h| self.sun_perigee_crossings(h));
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

/// Distance from the observer to the atmosphere, km; None where the ray misses it. `sin` is the
/// sine of the zenith angle.
fn entry_distance(medium: &Medium, observer: &Line, sin: f64) -> Option<f64> {
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
fn line_from_entry(medium: &Medium, observer: &Line, entry: f64) -> Line {
    if entry == 0.0 {
        return *observer;
    }
    let mu = (observer.radius * observer.mu + entry) / medium.top_radius_km;
    Line::new(medium, medium.top_altitude_km(), mu)
}

/// Half of the chord that a line with this perigee cuts from a sphere, km.
fn half_chord(radius: f64, perigee: f64) -> f64 {
    ((radius - perigee) * (radius + perigee)).sqrt()
}

/// Distance to the ground or else to the top of the atmosphere, km.
fn length_in_atmosphere(medium: &Medium, line: &Line) -> f64 {
    let [near, far] = line.crossings(0.0).unwrap_or([0.0; 2]);
    if line.mu < 0.0 && near < far {
        return near.max(0.0);
    }
    let exit = line.crossings(medium.top_altitude_km());
    exit.map_or(0.0, |[_, far]| far.max(0.0))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

// -------------------------------------------------------------------------------------------------
// The single-scattering integral
// -------------------------------------------------------------------------------------------------

/// What one stretch of the view ray adds, seen from where it starts.
#[derive(Clone, Debug)]
struct Stretch {
    /// Its columns of air, aerosol and ozone, km.
    column: [f64; 3],
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
    /// Phase functions of air and aerosol along the whole ray, sr⁻¹.
    phases: [f64; 2],
}

impl<'a> Integral<'a> {
    fn new(tolerance: f64, medium: &'a Medium, bands: &'a [Coefficients], path: &'a ViewPath) -> Self {
        let phases = [air_phase(path.nu), aerosol_phase(medium.aerosol_asymmetry, path.nu)];
        Self { tolerance, medium, bands, path, phases }
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
    fn accuracy_after(&self, column: [f64; 3], scale: &[f64]) -> Vec<f64> {
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
        let brightest = self.phases[0].max(self.phases[1]);
        self.bands.iter().enumerate().all(|(i, band)| {
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
        let column = |weights: &[f64; VIEW_ORDER]| -> [f64; 3] {
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

    fn column_to_sun(&self, s: f64) -> [f64; 3] {
        column_to_top(self.medium, self.path.altitude(s), self.path.mu_sun(s))
    }

    /// Adds what a point scatters, `weight` km long and seen through `column`.
    fn add_scattered(&self, sum: &mut [f64], weight: f64, density: [f64; 3], column: [f64; 3]) {
        let air = weight * density[0] * self.phases[0];
        let aerosol = weight * density[1] * self.phases[1];
        for (sum, band) in sum.iter_mut().zip(self.bands) {
            let scattered = air * band.air_scattering + aerosol * band.aerosol_scattering;
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
        Stretch { column: [0.0; 3], radiance: vec![0.0; self.bands.len()] }
    }
}

// -------------------------------------------------------------------------------------------------
// Quadrature
// -------------------------------------------------------------------------------------------------

/// Gauss-Legendre quadrature on [0, 1].
struct GaussLegendre<const N: usize> {
    nodes: [f64; N],
    weights: [f64; N],
    /// Row j integrates from 0 to node j: the integral of the polynomial through all N nodes.
    running: [[f64; N]; N],
}

impl<const N: usize> GaussLegendre<N> {
    fn new() -> Self {
        let roots: [f64; N] = std::array::from_fn(|i| legendre_root(N, i));
        let weights = roots.map(|x| {
            let slope = legendre_slope(N, x);
            1.0 / ((1.0 - x * x) * slope * slope)
        });
        let running =
            std::array::from_fn(|j| std::array::from_fn(|k| weights[k] * running_weight(N, roots[j], roots[k])));
        Self { nodes: roots.map(|x| 0.5 + 0.5 * x), weights, running }
    }

    /// ∫ f from `start` to `end`.
    fn integrate(&self, start: f64, end: f64, f: impl Fn(f64) -> f64) -> f64 {
        let width = end - start;
        let mut sum = 0.0;
        for i in 0..N {
            sum += self.weights[i] * f(start + width * self.nodes[i]);
        }
        width * sum
    }
}

/// Σ over m < n of P_m(node) (P_m+1(x) − P_m−1(x)) / 2, with P_−1 = −1: half the integral from −1
/// to x of the series that is 1 over its Gauss weight at `node` and 0 at the other nodes.
fn running_weight(n: usize, x: f64, node: f64) -> f64 {
    let term = |m: usize| {
        let before = if m == 0 { -1.0 } else { legendre(m - 1, x) };
        0.5 * legendre(m, node) * (legendre(m + 1, x) - before)
    };
    (0..n).map(term).sum()
}

/// Legendre polynomial P_n(x), by Bonnet's recursion.
fn legendre(n: usize, x: f64) -> f64 {
    let (mut before, mut value) = (0.0, 1.0);
    for k in 0..n {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0));
    }
    value
}

/// dP_n/dx inside (−1, 1).
fn legendre_slope(n: usize, x: f64) -> f64 {
    n as f64 * (x * legendre(n, x) - legendre(n - 1, x)) / (x * x - 1.0)
}

/// The i-th root of P_n, ascending, by Newton's method from Tricomi's estimate.
fn legendre_root(n: usize, i: usize) -> f64 {
    let mut x = -(PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
    for _ in 0..8 {
        x -= legendre(n, x) / legendre_slope(n, x);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    const EARTH: Medium = Medium {
        ground_radius_km: 6360.0,
        top_radius_km: 6460.0,
        air_scale_height_km: 8.0,
        aerosol_scale_height_km: 1.2,
        aerosol_asymmetry: 0.8,
        ozone_bottom_km: 10.0,
        ozone_peak_km: 25.0,
        ozone_top_km: 40.0,
    };

    /// Violet, where air is thickest; orange, where ozone is; and orange through heavy haze.
    const BANDS: [Coefficients; 3] = [
        Coefficients {
            air_scattering: 4.8e-2,
            aerosol_extinction: 4.44e-3,
            aerosol_scattering: 4.0e-3,
            ozone_absorption: 1e-5,
        },
        Coefficients {
            air_scattering: 9.0e-3,
            aerosol_extinction: 4.44e-3,
            aerosol_scattering: 4.0e-3,
            ozone_absorption: 2.6e-3,
        },
        Coefficients {
            air_scattering: 9.0e-3,
            aerosol_extinction: 4.44e-2,
            aerosol_scattering: 4.0e-2,
            ozone_absorption: 2.6e-3,
        },
    ];

    const ONLY_AIR: Coefficients =
        Coefficients { air_scattering: 0.05, aerosol_extinction: 0.0, aerosol_scattering: 0.0, ozone_absorption: 0.0 };

    fn ray(observer_altitude_km: f64, view: [f64; 3], sun: [f64; 3]) -> Ray {
        Ray { observer_altitude_km, view, sun }
    }

    /// Rays from the ground to beyond the atmosphere, night to noon, ground to zenith.
    fn rays() -> Vec<Ray> {
        let mut rays = Vec::new();
        for altitude in [0.0, 0.5, 12.0, 60.0, 400.0, 36000.0] {
            for sun in [-9.0, -4.0, 0.0, 2.0, 45.0] {
                for view in [-89.9, -20.0, -7.2, -2.1, 0.0, 0.3, 10.0, 90.0] {
                    for azimuth in [0.01, 90.0, 180.0] {
                        rays.push(ray(altitude, direction(view, azimuth), direction(sun, 0.0)));
                    }
                }
            }
        }
        rays
    }

    #[track_caller]
    fn assert_close(actual: f64, expected: f64, tolerance: f64) {
        let close = (actual - expected).abs() <= tolerance * expected.abs();
        assert!(close, "{actual:e} is not {expected:e} within {tolerance:e}");
    }

    /// Simpson's rule with 20000 steps: 5e-3 km where the integrand changes over 1 km, so exact to
    /// 1e-11.
    fn simpson(start: f64, end: f64, f: impl Fn(f64) -> f64) -> f64 {
        let steps = 20000;
        let step = (end - start) / steps as f64;
        let weight = |i| match i {
            0 => 1.0,
            i if i == steps => 1.0,
            i if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        (0..=steps).map(|i| weight(i) * f(start + i as f64 * step)).sum::<f64>() * step / 3.0
    }

    /// A column by Simpson's rule, between the corners of the ozone profile, in distance from the
    /// perigee.
    fn column_by_simpson(medium: &Medium, altitude: f64, mu: f64) -> [f64; 3] {
        let radius = medium.ground_radius_km + altitude;
        let perigee = radius * (1.0 - mu * mu).sqrt();
        let start = radius * mu;
        let end = half_chord(medium.top_radius_km, perigee);
        let mut cuts = vec![start, end];
        for kink in medium.ozone_kinks_km() {
            let chord = half_chord(medium.ground_radius_km + kink, perigee);
            cuts.extend([-chord, chord].into_iter().filter(|t| *t > start && *t < end));
        }
        cuts.sort_by(f64::total_cmp);
        let density = |t: f64| medium.densities(perigee.hypot(t) - medium.ground_radius_km);
        std::array::from_fn(|i| cuts.windows(2).map(|ends| simpson(ends[0], ends[1], |t| density(t)[i])).sum())
    }

    /// The definition, in vectors, with uniform steps and no thought.
    fn radiance_by_brute_force(medium: &Medium, band: &Coefficients, ray: &Ray, length: f64) -> f64 {
        let steps = 3000;
        let step = length / steps as f64;
        let nu = dot(ray.view, ray.sun);
        let along = |p: [f64; 3], v: [f64; 3], s: f64| [0, 1, 2].map(|i| p[i] + s * v[i]);
        let altitude = |p: [f64; 3]| dot(p, p).sqrt() - medium.ground_radius_km;
        let observer = [0.0, 0.0, medium.ground_radius_km + ray.observer_altitude_km];
        let depth_to_sun = |p: [f64; 3]| {
            let b = dot(p, ray.sun);
            let distance = -b + (b * b + medium.top_radius_km.powi(2) - dot(p, p)).sqrt();
            let step = distance / 1000.0;
            let mut depth = 0.0;
            for j in 0..1000 {
                let height = altitude(along(p, ray.sun, (j as f64 + 0.5) * step));
                if height < 0.0 {
                    return f64::INFINITY;
                }
                depth += step * band.optical_depth(medium.densities(height));
            }
            depth
        };
        let (mut depth, mut radiance) = (0.0, 0.0);
        for i in 0..steps {
            let p = along(observer, ray.view, (i as f64 + 0.5) * step);
            let density = medium.densities(altitude(p));
            let half = 0.5 * step * band.optical_depth(density);
            let scattered = density[0] * band.air_scattering * air_phase(nu)
                + density[1] * band.aerosol_scattering * aerosol_phase(medium.aerosol_asymmetry, nu);
            radiance += step * scattered * (-(depth + half) - depth_to_sun(p)).exp();
            depth += 2.0 * half;
        }
        radiance
    }

    #[test]
    fn azimuth_reads_like_a_compass() {
        let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15);
        assert!(near(direction(0.0, 0.0), [1.0, 0.0, 0.0]), "north is x");
        assert!(near(direction(0.0, 90.0), [0.0, -1.0, 0.0]), "east is -y");
        assert!(near(direction(0.0, 270.0), [0.0, 1.0, 0.0]), "west is y");
        assert!(near(direction(90.0, 12.0), [0.0, 0.0, 1.0]), "up is z");
    }

    #[test]
    fn phase_functions_integrate_to_one() {
        let rule = GaussLegendre::<64>::new();
        let sphere = |phase: &dyn Fn(f64) -> f64| 2.0 * PI * rule.integrate(-1.0, 1.0, phase);
        assert_close(sphere(&air_phase), 1.0, 1e-14);
        for asymmetry in [-0.5, 0.0, 0.3, 0.8] {
            // Poles of the phase function at ν = (1 + g²) / 2g: 64 nodes give 1e-12 for g = 0.8.
            assert_close(sphere(&|nu| aerosol_phase(asymmetry, nu)), 1.0, 1e-11);
        }
    }

    #[test]
    fn gauss_legendre_is_exact_for_polynomials() {
        let rule = GaussLegendre::<10>::new();
        assert_close(rule.integrate(1.0, 3.0, |x| x.powi(19)), (3f64.powi(20) - 1.0) / 20.0, 1e-14);
        for (node, row) in rule.nodes.iter().zip(&rule.running) {
            let ninth: f64 = row.iter().zip(&rule.nodes).map(|(w, x)| w * x.powi(9)).sum();
            assert!((ninth - node.powi(10) / 10.0).abs() < 1e-15);
        }
    }

    #[test]
    fn vertical_column_of_an_exponential_atmosphere_is_h_times_one_minus_exp() {
        for altitude in [0.0, 1.0, 20.0, 99.0] {
            let column = column_to_top(&EARTH, altitude, 1.0);
            for (i, scale_height) in [(0, 8.0_f64), (1, 1.2)] {
                let depth = (100.0 - altitude) / scale_height;
                let expected = scale_height * (-altitude / scale_height).exp() * -(-depth).exp_m1();
                assert_close(column[i], expected, 1e-12);
            }
        }
    }

    #[test]
    fn vertical_ozone_column_is_half_of_its_thickness() {
        assert_close(column_to_top(&EARTH, 0.0, 1.0)[2], 15.0, 1e-13);
        assert_close(column_to_top(&EARTH, 25.0, 1.0)[2], 7.5, 1e-13);
        assert_eq!(column_to_top(&EARTH, 40.0, 1.0)[2], 0.0);
    }

    #[test]
    fn columns_agree_with_simpson() {
        let thin_haze = Medium { aerosol_scale_height_km: 0.3, ..EARTH };
        for (medium, tolerance) in [(EARTH, 1e-10), (thin_haze, 1e-9)] {
            for altitude in [0.0, 0.01, 1.0, 10.0, 24.0, 39.0, 70.0, 99.0] {
                let radius = medium.ground_radius_km + altitude;
                let horizon = -(1.0 - (medium.ground_radius_km / radius).powi(2)).sqrt();
                for mu in [horizon, 0.5 * horizon, 1e-3 * horizon, 0.0, 1e-3, 0.02, 0.1, 0.4, 0.9] {
                    let column = column_to_top(&medium, altitude, mu);
                    let expected = column_by_simpson(&medium, altitude, mu);
                    for i in 0..3 {
                        assert_close(column[i], expected[i], tolerance);
                    }
                }
            }
        }
    }

    #[test]
    fn a_chord_seen_from_space_is_twice_its_half() {
        let grazing = Line::new(&EARTH, 200.0, -half_chord(6560.0, 6365.0) / 6560.0);
        let chord = column_to_top(&EARTH, 200.0, grazing.mu);
        let half = column_to_top(&EARTH, 5.0, 0.0);
        for i in 0..3 {
            assert_close(chord[i], 2.0 * half[i], 1e-11);
        }
        assert_eq!(column_to_top(&EARTH, 200.0, -0.1), [0.0; 3]);
    }

    #[test]
    fn radiance_towards_a_zenith_sun_is_depth_times_its_transmittance() {
        // Every path, down to a point and on to the observer, is the same column: ∫ β ρ exp(−τ) = τ
        // exp(−τ).
        let depth = 0.05 * 8.0 * -(-100.0_f64 / 8.0).exp_m1();
        let up = [0.0, 0.0, 1.0];
        let radiance = scattered_radiance(&EARTH, &ONLY_AIR, &ray(0.0, up, up));
        assert_close(radiance, air_phase(1.0) * depth * (-depth).exp(), 1e-11);
    }

    #[test]
    fn radiance_straight_down_from_space_is_half_of_what_the_double_path_removes() {
        let depth = 0.05 * 8.0 * -(-100.0_f64 / 8.0).exp_m1();
        let (up, down) = ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
        let expected = air_phase(-1.0) * 0.5 * -(-2.0 * depth).exp_m1();
        for altitude in [100.0, 101.0, 400.0, 384400.0] {
            let radiance = scattered_radiance(&EARTH, &ONLY_AIR, &ray(altitude, down, up));
            assert_close(radiance, expected, 1e-10);
        }
    }

    #[test]
    fn thin_zenith_at_sun_minus_four_is_lit_from_the_shadow_edge_up() {
        let edge: f64 = 6360.0 * (1.0 / 4.0_f64.to_radians().cos() - 1.0);
        let sun = direction(-4.0, 0.0);
        let lit_column = |h: f64| h * ((-edge / h).exp() - (-100.0 / h).exp());
        let air = Coefficients { air_scattering: 1e-9, ..ONLY_AIR };
        let haze = Coefficients {
            air_scattering: 0.0,
            aerosol_extinction: 1e-9,
            aerosol_scattering: 1e-9,
            ozone_absorption: 0.0,
        };
        let zenith = ray(0.0, [0.0, 0.0, 1.0], sun);
        let [air, haze] = [air, haze].map(|band| scattered_radiance(&EARTH, &band, &zenith));
        // The longest path is 600 km at density 1: at 1e-9 km⁻¹ it takes less than 1e-6 away.
        assert_close(air / (1e-9 * air_phase(sun[2])), lit_column(8.0), 1e-6);
        assert_close(haze / (1e-9 * aerosol_phase(0.8, sun[2])), lit_column(1.2), 1e-6);
    }

    #[test]
    fn thin_lit_slant_is_its_column() {
        let thin = Coefficients { air_scattering: 1e-9, ..ONLY_AIR };
        let sun = direction(50.0, 0.0);
        for elevation in [0.0, 0.5, 10.0, 60.0] {
            let view = direction(elevation, 130.0);
            let radiance = scattered_radiance(&EARTH, &thin, &ray(0.0, view, sun));
            let column = column_to_top(&EARTH, 0.0, view[2])[0];
            assert_close(radiance / (1e-9 * air_phase(dot(view, sun))), column, 1e-6);
        }
    }

    #[test]
    fn radiance_is_linear_in_the_scattering_alone() {
        let albedo = |scattering| Coefficients {
            air_scattering: 0.0,
            aerosol_extinction: 0.04,
            aerosol_scattering: scattering,
            ozone_absorption: 1e-3,
        };
        let ray = ray(0.0, direction(3.0, 20.0), direction(5.0, 0.0));
        let radiance = scattered_radiance_bands(&EARTH, &[albedo(0.04), albedo(0.01)], &ray);
        assert_close(radiance[0], 4.0 * radiance[1], 1e-12);
    }

    #[test]
    fn an_opaque_atmosphere_still_has_a_radiance() {
        let opaque = Coefficients { air_scattering: 50.0, ..BANDS[0] };
        for ray in rays().iter().step_by(11) {
            let radiance = scattered_radiance(&EARTH, &opaque, ray);
            assert!((0.0..1.0).contains(&radiance), "{radiance} along {ray:?}");
        }
    }

    #[test]
    fn night_is_black() {
        for elevation in [0.0, 30.0, 90.0] {
            let ray = ray(0.0, direction(elevation, 40.0), direction(-90.0, 0.0));
            assert_eq!(scattered_radiance(&EARTH, &BANDS[0], &ray), 0.0);
        }
    }

    #[test]
    fn empty_space_and_the_ground_underfoot_are_black() {
        let sun = direction(30.0, 0.0);
        for (altitude, elevation) in [(100.1, 1.0), (400.0, -5.0), (0.0, -0.01), (0.0, -90.0)] {
            let ray = ray(altitude, direction(elevation, 0.0), sun);
            assert_eq!(scattered_radiance(&EARTH, &BANDS[0], &ray), 0.0);
        }
    }

    #[test]
    fn shadow_edges_are_the_distances_where_the_sun_appears() {
        let mut edges = 0;
        for ray in rays() {
            let Some(path) = ViewPath::new(&EARTH, &ray) else {
                continue;
            };
            for s in path.sun_perigee_crossings(0.0).into_iter().flatten() {
                let behind = path.sunward + s * path.nu < -1.0;
                let (before, after) = (s - 1e-3, s + 1e-3);
                if behind && before > 0.0 && after < path.length {
                    assert_ne!(path.is_lit(&EARTH, before), path.is_lit(&EARTH, after));
                    edges += 1;
                }
            }
        }
        assert!(edges > 50, "only {edges} edges were looked at");
    }

    #[test]
    fn radiance_agrees_with_brute_force() {
        // Midpoint steps of 0.1 km towards the sun and 0.03 to 0.4 km along the view, in haze of
        // 1.2 km, agree to 3e-5.
        let cases = [
            (0.0, 90.0, 0.0, 45.0),
            (0.0, 5.0, 30.0, 20.0),
            (0.0, 0.5, 170.0, 2.0),
            (0.0, 20.0, 10.0, -4.0),
            (2.0, -1.0, 60.0, 10.0),
            (60.0, -5.0, 150.0, -1.0),
        ];
        for (altitude, elevation, azimuth, sun) in cases {
            let ray = ray(altitude, direction(elevation, azimuth), direction(sun, 0.0));
            let length = ViewPath::new(&EARTH, &ray).unwrap().length;
            for band in [&BANDS[0], &BANDS[2]] {
                let expected = radiance_by_brute_force(&EARTH, band, &ray, length);
                assert_close(scattered_radiance(&EARTH, band, &ray), expected, 1e-4);
            }
        }
    }

    #[test]
    fn a_thousand_times_finer_changes_less_than_1e_8() {
        let mut compared = 0;
        for ray in rays() {
            let radiance = scattered_radiance_bands(&EARTH, &BANDS, &ray);
            let fine = scattered_radiance_bands_within(1e-11, &EARTH, &BANDS, &ray);
            for (radiance, fine) in radiance.iter().zip(&fine).filter(|(_, fine)| **fine > 1e-30) {
                assert_close(*radiance, *fine, 1e-8);
                compared += 1;
            }
        }
        assert!(compared > 500, "only {compared} radiances were compared");
    }

    #[test]
    fn bands_together_equal_bands_alone() {
        for ray in rays().iter().step_by(7) {
            let together = scattered_radiance_bands(&EARTH, &BANDS, ray);
            for (band, radiance) in BANDS.iter().zip(together) {
                assert!((scattered_radiance(&EARTH, band, ray) - radiance).abs() <= 2e-8 * radiance);
            }
        }
    }

    #[test]
    fn radiance_is_continuous_as_the_observer_goes_up() {
        // 1 m of air at these coefficients is at most 5e-5 of optical depth, against radiances of
        // some 1e-2 sr⁻¹.
        let sun = direction(3.0, 0.0);
        for elevation in [90.0, 20.0, 0.0, -30.0] {
            let view = direction(elevation, 25.0);
            for altitude in [0.0, 0.5, 1.2, 10.0, 25.0, 40.0, 99.9995, 150.0] {
                let [low, high] = [altitude, altitude + 1e-3]
                    .map(|altitude| scattered_radiance(&EARTH, &BANDS[0], &ray(altitude, view, sun)));
                assert!((low - high).abs() <= 1e-2 * low.max(high) + 1e-4, "{altitude} {elevation}");
            }
        }
    }

    #[test]
    fn entering_from_space_equals_standing_at_the_entry() {
        // Down the plane of the sun, from 500 km to the top: the view turns with the vertical.
        let (view, sun) = (direction(-35.0, 0.0), direction(40.0, 0.0));
        let observer = Line::new(&EARTH, 500.0, view[2]);
        let entry = entry_distance(&EARTH, &observer, view[0]).unwrap();
        let turn = (entry * view[0]).atan2(6860.0 + entry * view[2]).to_degrees();
        let there = ray(100.0, direction(-35.0 + turn, 0.0), direction(40.0 + turn, 0.0));
        let from_space = scattered_radiance(&EARTH, &BANDS[1], &ray(500.0, view, sun));
        assert_close(from_space, scattered_radiance(&EARTH, &BANDS[1], &there), 1e-9);
    }
}
