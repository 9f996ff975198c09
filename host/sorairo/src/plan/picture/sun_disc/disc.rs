//! The sun's disc: its size and its light at the observer.

use std::f64::consts::{FRAC_PI_2, PI};

use sorairo_shared::geometry::{Ray, inside_atmosphere};
use sorairo_shared::glam::{DVec3, Vec2, Vec4};
use sorairo_shared::medium::atmosphere::ColumnDensities;
use sorairo_shared::medium::columns::sunlight_at;
use sorairo_shared::medium::density::relative_densities;
use sorairo_shared::picture::disc::{ELEVATIONS, LIMB_COSINES};
use sorairo_shared::variant;

use crate::medium::gases::{Absorption, CLASSES, Relative};
use crate::medium::tables::Tables;
use crate::plan::integral::RayIntegral;
use crate::plan::picture::sun_irradiance::SunIrradiance;
use crate::plan::rays::quadrature::gauss_legendre;
use crate::plan::sky::{SkyPlan, found_once};
use crate::spectra::mean::Window;
use crate::spectra::observer;
use crate::spectra::optics::{Coefficients, Optics};

use super::limb::{limb_darkening, mean_darkening};

/// Nominal radius of the sun (km; IAU 2015 resolution B3).
const SOLAR_RADIUS: f64 = 695_700.0;

/// One astronomical unit (km; IAU 2012 resolution B2).
const ASTRONOMICAL_UNIT: f64 = 149_597_870.7;

/// What single precision leaves of an elevation near the horizon (radians).
const ROUNDED: f64 = 1e-6;

/// Strips of each piece of the disc, and parts of a strip, of the sum over the disc.
const STRIPS: u32 = 48;
const PARTS: u32 = 12;

/// Nodes between two angles, with their weights.
fn nodes_between((low, high): (f64, f64)) -> impl Iterator<Item = (f64, f64)> {
    let node = move |p: Vec2| (low + (high - low) * f64::from(p.x), (high - low) * f64::from(p.y));
    gauss_legendre(STRIPS).into_iter().map(node)
}

/// The sun as the observer sees it.
pub struct Sun<'a> {
    pub(super) sky: &'a SkyPlan,
    /// Angular radius (radians).
    pub(super) radius: f64,
    /// Elevation of the centre, without air (radians).
    elevation: f64,
    /// Elevation of the horizon (radians).
    pub(super) horizon: f64,
    /// Elevation, without air, of what is seen on the horizon (radians).
    lowest: f64,
    /// Elevation at which the centre is seen (radians), and by how much the disc is seen flattened there.
    pub(super) centre: (f64, f64),
    /// Per wavelength (nm): itself, irradiance over the disc's projected solid angle (W·m⁻²·sr⁻¹·nm⁻¹).
    spectrum: Vec<(f64, f64)>,
    /// What weakens it at each wavelength.
    coefficients: Vec<Coefficients>,
    /// What gases take of it at each wavelength, and how much of them there is; none but in a measured profile.
    gases: Option<(Vec<Absorption>, Relative)>,
}

/// A level strip of the disc.
struct Strip {
    /// Optical depth between it and the observer at each wavelength.
    depths: Vec<f64>,
    parts: Vec<Part>,
}

/// A part of the disc.
struct Part {
    /// The direction to it.
    view: DVec3,
    /// Cosine of the angle to the normal of the sun's surface.
    limb_cosine: f64,
    /// Solid angle (sr).
    solid_angle: f64,
}

impl SkyPlan {
    /// The grid from which kernels read the sun's disc; see [`Sun::grid`]. Computed when it is first asked for.
    pub fn disc_grid(&self) -> &[Vec4] {
        let grid: &Vec<Vec4> = found_once(&self.disc_grid, || Sun::new(self).grid());
        grid
    }

    /// What falls from the sun's disc; see [`Sun::irradiance`]. Computed when it is first asked for.
    pub fn sun_irradiance(&self) -> &SunIrradiance {
        found_once(&self.sun_irradiance, || Sun::new(self).irradiance())
    }
}

impl<'a> Sun<'a> {
    /// That of a sky at the observer nodes, each with the means over what it stands for.
    pub fn new(sky: &'a SkyPlan) -> Self {
        Self::as_read(sky, &sky.base.optics, &observer::wavelengths(), Some(Window::STEP))
    }

    /// Its place and shape in a sky alone, without light.
    pub fn shape(sky: &'a SkyPlan) -> Self {
        Self::as_read(sky, &sky.base.optics, &[], None)
    }

    /// That of a sky at wavelengths (nm) themselves.
    pub fn at(sky: &'a SkyPlan, wavelengths: &[f64]) -> Self {
        Self::as_read(sky, &sky.scene.optics(), wavelengths, None)
    }

    /// That of a sky in means over bands so wide (nm) about wavelengths (nm).
    pub fn over_bands(sky: &'a SkyPlan, wavelengths: &[f64], width: f64) -> Self {
        let window = Window::Band(width);
        Self::as_read(sky, &sky.scene.optics().over(window), wavelengths, Some(window))
    }

    fn as_read(sky: &'a SkyPlan, optics: &Optics, wavelengths: &[f64], window: Option<Window>) -> Self {
        let sine = (SOLAR_RADIUS / (optics.sun_distance * ASTRONOMICAL_UNIT)).min(1.0);
        let mean = |nm: f64| optics.solar_irradiance(nm) / (PI * sine * sine) / mean_darkening(nm);
        let horizon = f64::from(sky.base.uniform.horizon);
        let elevation = sky.base.source.elevation.to_radians();
        let absorption = |&nm: &f64| match window {
            Some(window) => Absorption::mean(&window.nodes(nm), optics.ozone_temperature),
            None => Absorption::at(nm, optics.ozone_temperature),
        };
        let relative = if wavelengths.is_empty() { None } else { sky.scene.gases() };
        let gases = relative.map(|relative| (wavelengths.iter().map(absorption).collect(), relative));
        let straight = Self {
            sky,
            radius: sine.asin(),
            elevation,
            horizon,
            lowest: horizon,
            centre: (elevation, 1.0),
            spectrum: wavelengths.iter().map(|&nm| (nm, mean(nm))).collect(),
            coefficients: wavelengths.iter().map(|&nm| optics.without_gases(nm)).collect(),
            gases,
        };
        let Some((tables, altitude)) = straight.bent() else { return straight };
        let lowest = FRAC_PI_2 - tables.lowest_sun(altitude);
        let horizon = FRAC_PI_2 - tables.seen(altitude, FRAC_PI_2 - lowest);
        Self { lowest, horizon, centre: straight.seen(elevation), ..straight }
    }

    /// The angle across the disc (degrees).
    pub fn across(&self) -> f64 {
        2.0 * self.radius.to_degrees()
    }

    /// The grid of linear RGB from which kernels read the disc, whatever camera sees it.
    pub fn grid(&self) -> Vec<Vec4> {
        let (lowest, highest) = self.heights();
        let entry = |entry| {
            let part = |index: u32, count: u32| f64::from(index) / f64::from(count - 1);
            let height = lowest + (highest - lowest) * part(entry / LIMB_COSINES, ELEVATIONS);
            let limb_cosine = part(entry % LIMB_COSINES, LIMB_COSINES);
            self.rgb(&self.depths(height), limb_cosine).as_vec3().extend(0.0)
        };
        (0..ELEVATIONS * LIMB_COSINES).map(entry).collect()
    }

    /// What falls from the disc, as far as the ground does not hide it; of a sun at the nodes of the observer.
    pub fn irradiance(&self) -> SunIrradiance {
        let mut sum = SunIrradiance::default();
        for Strip { depths, parts } in self.strips() {
            for Part { view, limb_cosine, solid_angle } in parts {
                let power = self.radiance(&depths, limb_cosine).zip(&self.spectrum);
                let power = power.map(|(radiance, &(nm, _))| radiance * observer::width(nm)).sum::<f64>() * solid_angle;
                sum.rgb += self.rgb(&depths, limb_cosine) * solid_angle;
                sum.facing += power;
                sum.level += power * view.z.max(0.0);
            }
        }
        sum
    }

    /// Irradiance at each wavelength (W·m⁻²·nm⁻¹) that the disc, as far as the ground does not hide it, sends to a
    /// surface; `cosine` is that between the surface's normal and a direction.
    pub fn spectral_irradiance(&self, cosine: impl Fn(DVec3) -> f64) -> Vec<f64> {
        let mut sum = vec![0.0; self.spectrum.len()];
        for Strip { depths, parts } in self.strips() {
            for Part { view, limb_cosine, solid_angle } in parts {
                let weight = solid_angle * cosine(view).max(0.0);
                sum.iter_mut().zip(self.radiance(&depths, limb_cosine)).for_each(|(sum, value)| *sum += value * weight);
            }
        }
        sum
    }

    /// The part of the light from the disc's centre that the air lets through at each wavelength; none of a centre
    /// below the horizon.
    pub fn transmittance_of_centre(&self) -> Vec<f64> {
        if self.elevation < self.lowest {
            return vec![0.0; self.coefficients.len()];
        }
        self.depths(self.centre.0.sin()).into_iter().map(|depth| (-depth).exp()).collect()
    }

    /// The level strips of the disc that the ground does not hide.
    ///
    /// A strip lies at the height `v = sin θ` over the disc's centre, in radii, and its parts at `u = cos θ sin φ`
    /// across. There the cosine to the normal of the sun's surface is `cos θ cos φ`, and `du dv = cos² θ cos φ dθ dφ`:
    /// smooth to the limb and to the horizon, where both end.
    fn strips(&self) -> impl Iterator<Item = Strip> {
        let across = gauss_legendre(PARTS);
        let ahead = self.sky.base.source.bearing().truncate();
        let disc = self.radius.sin().powi(2);
        let strip = move |(theta, weight): (f64, f64)| {
            let (over, half) = theta.sin_cos();
            let (elevation, spread) = self.seen(self.elevation + self.radius * over);
            let part = |node: &Vec2| {
                let (sine, cosine) = (PI * (f64::from(node.x) - 0.5)).sin_cos();
                // Across, the disc is as good as flat.
                let level = ahead * elevation.cos() + ahead.perp() * (self.radius * half * sine);
                let solid_angle = spread * disc * half * half * cosine * weight * PI * f64::from(node.y);
                Part { view: level.extend(elevation.sin()), limb_cosine: half * cosine, solid_angle }
            };
            Strip { depths: self.depths(elevation.sin()), parts: across.iter().map(part).collect() }
        };
        self.pieces().into_iter().flat_map(nodes_between).map(strip)
    }

    /// Angles `θ` of the heights sin θ over the disc's centre, in radii, between which the light of the disc changes
    /// smoothly: from the horizon to the top, with the limb of the atmosphere in between for an observer above it.
    fn pieces(&self) -> Vec<(f64, f64)> {
        let RayIntegral { uniform, optics, .. } = &self.sky.base;
        let from_centre = optics.ground_radius + f64::from(uniform.altitude);
        let limb = (from_centre > optics.top_radius).then(|| -(optics.top_radius / from_centre).acos());
        let angle = |elevation: f64| ((elevation - self.elevation) / self.radius).clamp(-1.0, 1.0).asin();
        let edges: Vec<f64> =
            [Some(angle(self.lowest)), limb.map(angle), Some(FRAC_PI_2)].into_iter().flatten().collect();
        edges.windows(2).map(|edge| (edge[0], edge[1])).filter(|(low, high)| low < high).collect()
    }

    /// Sines of the elevations between which the disc can be seen.
    pub(super) fn heights(&self) -> (f64, f64) {
        let (centre, flattening) = self.centre;
        let low = (centre - self.radius * flattening).max(self.horizon);
        let high = (centre + self.radius * flattening).min(FRAC_PI_2);
        (low.sin(), high.sin().max(low.sin() + 1e-6))
    }

    /// Optical depth between the observer and a place of the disc, by the sine of the elevation at which it is seen, at
    /// each wavelength.
    fn depths(&self, height: f64) -> Vec<f64> {
        let (to_sun, gases) = self.to_sun(height);
        let depth = |c: &Coefficients| {
            let depth = |coefficient: f64, along: f64| if coefficient > 0.0 { coefficient * along } else { 0.0 };
            depth(c.air_scattering, to_sun.x)
                + depth(c.aerosol_extinction, to_sun.y)
                + depth(c.ozone_absorption, to_sun.z)
        };
        let mut depths: Vec<f64> = self.coefficients.iter().map(depth).collect();
        if let Some((absorptions, relative)) = &self.gases {
            let amounts = relative.of(gases);
            let absorbed = absorptions.iter().map(|absorption| absorption.transmittance(&amounts));
            depths.iter_mut().zip(absorbed).for_each(|(depth, left)| *depth -= left.ln());
        }
        depths
    }

    /// What lies between the observer and a place of the disc: column densities (km), and what absorbs, class by class.
    fn to_sun(&self, height: f64) -> (DVec3, [f64; CLASSES]) {
        let Some((tables, altitude)) = self.inside() else { return (self.straight_to_sun(height), [0.0; CLASSES]) };
        let seen = FRAC_PI_2 - height.clamp(-1.0, 1.0).asin();
        // The horizon itself may be rounded to below it.
        let beam = tables.beam(altitude, seen).or_else(|| tables.beam(altitude, seen - ROUNDED));
        let (along, gases) = beam.map_or((DVec3::INFINITY, [0.0; CLASSES]), |beam| (beam.along.into(), beam.gases));
        (if self.bent().is_some() { along } else { self.straight_to_sun(height) }, gases)
    }

    /// Column densities between the observer and the sun along a straight ray (km).
    fn straight_to_sun(&self, height: f64) -> DVec3 {
        let variant = self.sky.base.variant;
        let medium = self.sky.base.medium();
        // Towards the sun itself, tilted to the elevation asked for.
        let level = (1.0 - height * height).max(0.0).sqrt();
        let view = (self.sky.base.source.bearing() * level + DVec3::Z * height).as_vec3();
        let (Ray { altitude, mu, .. }, length) = inside_atmosphere(medium.shell(), self.sky.base.ray(view));
        if length <= 0.0 {
            return DVec3::ZERO;
        }
        let above_top = if variant & variant::TABLES == 0 { variant::ABOVE_TOP } else { 0 };
        let variant = variant | variant::LOW_SUN | above_top;
        let density = relative_densities(medium, altitude, variant);
        let ColumnDensities { air, aerosol, ozone, .. } = sunlight_at(medium, altitude, density, mu, variant).along;
        DVec3::new(air.into(), aerosol.into(), ozone.into())
    }

    /// The tables that bend sunlight to the observer, and the altitude (km); none for straight light, and from above
    /// the atmosphere, where the disc is shown as if light were straight.
    fn bent(&self) -> Option<(&Tables, f64)> {
        self.inside().filter(|(tables, _)| tables.shadow[1] > 0.0)
    }

    /// The tables of a measured profile around the observer, and the altitude (km).
    fn inside(&self) -> Option<(&Tables, f64)> {
        let altitude = f64::from(self.sky.base.uniform.altitude);
        let tables = self.sky.base.tables.as_deref()?;
        (altitude <= f64::from(self.sky.base.uniform.atmosphere.depth)).then_some((tables, altitude))
    }

    /// The elevation at which a place of the disc is seen, by that without air (radians), and its solid angle there
    /// relative to that without air.
    fn seen(&self, elevation: f64) -> (f64, f64) {
        let Some((tables, altitude)) = self.bent() else { return (elevation, 1.0) };
        const STEP: f64 = 1e-4;
        let at = |elevation: f64| {
            // Of a sun overhead a part stands beyond the zenith.
            let zenith = FRAC_PI_2 - elevation;
            FRAC_PI_2 - tables.seen(altitude, zenith.abs()).copysign(zenith)
        };
        let lowest = FRAC_PI_2 - tables.lowest_sun(altitude);
        let (low, high) = ((elevation - STEP).max(lowest), (elevation + STEP).max(lowest + STEP));
        let slope = (at(high) - at(low)) / (high - low);
        // A centre below the horizon stands as far below it as the disc that is left asks for.
        let seen = at(elevation.max(lowest)) + (elevation - elevation.max(lowest)) * slope;
        let level = if elevation.cos().abs() > STEP { seen.cos() / elevation.cos() } else { slope };
        (seen, slope * level)
    }

    /// Radiance at each wavelength (W·m⁻²·sr⁻¹·nm⁻¹).
    fn radiance(&self, depths: &[f64], limb_cosine: f64) -> impl Iterator<Item = f64> {
        self.spectrum
            .iter()
            .zip(depths)
            .map(move |(&(nm, mean), depth)| mean * limb_darkening(nm, limb_cosine).max(0.0) * (-depth).exp())
    }

    fn rgb(&self, depths: &[f64], limb_cosine: f64) -> DVec3 {
        self.linear_rgb(&self.radiance(depths, limb_cosine).collect::<Vec<_>>())
    }

    /// Linear RGB of radiances at the nodes of the observer.
    fn linear_rgb(&self, radiances: &[f64]) -> DVec3 {
        let radiances = radiances.iter().zip(&self.spectrum);
        let xyz: DVec3 = radiances.map(|(value, &(nm, _))| observer::weights(self.sky.observer, nm) * value).sum();
        self.sky.space.into_gamut(self.sky.space.from_xyz * xyz)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Preset, Rgb, Scene};

    /// Irradiance at each wavelength of the disc by rows and columns so fine that its edges do not matter.
    fn by_a_fine_grid(sun: &Sun<'_>) -> Vec<f64> {
        const ROWS: u32 = 6000;
        const COLUMNS: u32 = 100;
        let low = (sun.elevation - sun.radius).max(sun.horizon);
        let high = sun.elevation + sun.radius;
        let mut sum = vec![0.0; sun.spectrum.len()];
        for row in 0..ROWS {
            let elevation = low + (high - low) * (f64::from(row) + 0.5) / f64::from(ROWS);
            let over = (elevation - sun.elevation) / sun.radius;
            let half = (1.0 - over * over).sqrt();
            let depths = sun.depths(elevation.sin());
            let cell =
                (sun.radius.sin() / sun.radius).powi(2) * (high - low) / f64::from(ROWS) * 2.0 * half * sun.radius
                    / f64::from(COLUMNS);
            for column in 0..COLUMNS {
                let across = half * (2.0 * (f64::from(column) + 0.5) / f64::from(COLUMNS) - 1.0);
                let radiances = sun.radiance(&depths, (half * half - across * across).sqrt());
                sum.iter_mut().zip(radiances).for_each(|(sum, radiance)| *sum += radiance * cell);
            }
        }
        sum
    }

    #[test]
    fn a_half_set_sun_sends_the_light_of_the_part_that_is_seen() {
        let wavelengths = [400.0, 550.0, 700.0];
        for altitude in [0.0, 0.0017, 1.0, 12.0, 400.0, 30_000.0] {
            let at = |sun: f64| {
                // Straight light, as the grid has it.
                let mut scene = Scene::preset(Preset::Standard).in_closed_form();
                (scene.observer.altitude, scene.sun.elevation) = (altitude, sun);
                SkyPlan::new(&scene.validated().unwrap(), Rgb::Srgb)
            };
            let horizon = f64::from(at(0.0).base.uniform.horizon).to_degrees();
            let whole = Sun::at(&at(horizon + 0.5), &wavelengths).spectral_irradiance(|_| 1.0);
            let mut compared = 0;
            for step in 0..27 {
                let sky = at(horizon - 0.262 + 0.02 * f64::from(step));
                let sun = Sun::at(&sky, &wavelengths);
                let found = sun.spectral_irradiance(|_| 1.0);
                for ((found, expected), whole) in found.iter().zip(by_a_fine_grid(&sun)).zip(&whole) {
                    // Below a thousandth of the whole disc's nothing is promised. The grid itself is good to 2e-4.
                    if expected > 1e-3 * whole {
                        compared += 1;
                        assert!(
                            (found / expected - 1.0).abs() < 1e-3,
                            "{altitude} km, {step}: {found}, not {expected}"
                        );
                    }
                }
            }
            println!("{altitude} km: {compared} compared");
            assert!(compared > 20, "{altitude} km: {compared}");
        }
    }

    #[test]
    fn without_air_all_of_the_sun_arrives_that_the_ground_does_not_hide() {
        for (sun, part) in [(30.0, 1.0), (90.0, 1.0), (0.0, 0.5)] {
            let mut scene = Scene::preset(Preset::Earth);
            scene.sun.elevation = sun;
            (scene.atmosphere.air.scattering, scene.atmosphere.aerosol.optical_depth) = (0.0, 0.0);
            scene.atmosphere.ozone.column = 0.0;
            let sky = SkyPlan::new(&scene.validated().unwrap(), Rgb::Srgb);
            let found =
                Sun::at(&sky, &[550.0]).spectral_irradiance(|_| 1.0)[0] / sky.scene.optics().solar_irradiance(550.0);
            // What single precision leaves of the nodes of a quadrature.
            assert!((found / part - 1.0).abs() < 1e-6, "sun at {sun}: {found}");
        }
    }

    #[test]
    fn the_sun_is_as_bright_as_itself_in_its_centre_and_darker_and_redder_at_its_limb() {
        for nm in [380.0, 400.0, 422.0, 423.0, 550.0, 700.0, 830.0] {
            // The coefficients are rounded to five digits.
            assert!((limb_darkening(nm, 1.0) - 1.0).abs() < 1e-4, "{nm}");
            let mean: f64 = gauss_legendre(16)
                .into_iter()
                .map(|p| 2.0 * f64::from(p.x) * f64::from(p.y) * limb_darkening(nm, f64::from(p.x)))
                .sum();
            assert!((mean - mean_darkening(nm)).abs() < 1e-6, "{nm}");
        }
        assert!(limb_darkening(450.0, 0.2) < limb_darkening(650.0, 0.2));
        // Allen's Astrophysical Quantities (4th ed., 14.7): 0.80 of the centre at 550 nm and 0.6 of its cosine.
        assert!((limb_darkening(550.0, 0.6) - 0.76).abs() < 0.03, "{}", limb_darkening(550.0, 0.6));
    }

    #[test]
    fn a_sun_overhead_lights_as_one_beside_it() {
        let light = |elevation: f64| {
            let mut scene = Scene::default();
            scene.sun.elevation = elevation;
            let scene = scene.validated().unwrap();
            Sun::new(&SkyPlan::new(&scene, Rgb::Srgb)).irradiance()
        };
        let (beside, below) = (light(88.0), light(87.5));
        for elevation in [89.6, 89.73, 89.9, 89.999, 90.0] {
            let overhead = light(elevation);
            // An air mass grows by 6e-4 over two degrees.
            assert!((overhead.facing / beside.facing - 1.0).abs() < 5e-4, "{elevation}: {}", overhead.facing);
            assert!((overhead.level / overhead.facing - 1.0).abs() < 1e-4, "{elevation}: {}", overhead.level);
        }
        assert!(below.facing < beside.facing && light(60.0).facing < 0.99 * beside.facing);
    }
}
