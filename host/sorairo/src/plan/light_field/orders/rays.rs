//! Rays through a table of the light field: what every sun and azimuth shares.

use sorairo_shared::geometry::Ray;
use sorairo_shared::glam::Vec3;
use sorairo_shared::light_field::moments::{Moments, legendre};
use sorairo_shared::light_field::rays::{NodePlace, Sight, SunPlace, functions_of_air};
use sorairo_shared::light_field::table::{RayNode, TableRay, suns_along};
use sorairo_shared::math::safe_sqrt;
use sorairo_shared::path::ground::LAMBERT;
use sorairo_shared::path::pieces::{PieceSamples, Sample, for_each_piece, for_each_piece_until};
use sorairo_shared::value::{Lanes, Value};

use crate::plan::light_field::grid::Grid;
use crate::plan::light_field::orders::sampling::Sampling;
use crate::plan::light_field::setting::Setting;
use crate::plan::light_field::wavelengths::Wavelengths;

/// The ground that a ray meets.
#[derive(Clone, Copy)]
pub struct Ground<const N: usize> {
    /// Distance from where the ray enters the atmosphere, or begins (km).
    pub distance: f32,
    /// What an irradiance of 1 there adds to the ray: transmittance times albedo over π.
    pub radiance: Lanes<N>,
}

/// A ray through a table, from where it enters the atmosphere.
pub struct OwnedRay<const N: usize> {
    /// Distance of its origin from the planet's centre (km).
    pub radius: f32,
    /// Cosine of its zenith angle at the origin.
    pub mu: f32,
    /// Its sine.
    pub sine: f32,
    /// The ground that it meets.
    pub ground: Option<Ground<N>>,
    nodes: Vec<RayNode<N>>,
    functions: Vec<f32>,
    of: Moments,
}

impl<const N: usize> OwnedRay<N> {
    /// The ray from an altitude (km) with the cosine `mu` of its zenith angle, up to a length (km) or, if that is
    /// infinite, its end; its nodes know the functions of `of`.
    pub fn new(
        setting: &Setting,
        wavelengths: &Wavelengths<N>,
        grid: &Grid,
        sampling: &Sampling,
        of: Moments,
        altitude: f64,
        (mu, length): (f64, f64),
    ) -> Self {
        let sine = (1.0 - mu * mu).max(0.0).sqrt();
        let ray = Ray::new(altitude as f32, Vec3::new(sine as f32, 0.0, mu as f32), Vec3::Z);
        let ground_radius = setting.medium.atmosphere.ground_radius;
        let mut nodes = Vec::with_capacity(2 * sampling.fewest());
        let mut functions = Vec::with_capacity(nodes.capacity() * of.count());
        let chi: Vec<f32> = if setting.aerosol.is_empty() {
            Vec::new()
        } else {
            (0..=of.azimuthal).flat_map(|m| &setting.aerosol[m..=of.degree]).copied().collect()
        };
        let mut near = 0;
        let mut visit = |sample: Sample| {
            let place = grid.place_of(setting, sample.altitude);
            let altitudes = grid.places.axis().stencil(place, near);
            near = altitudes.first;
            let sine = safe_sqrt(1.0 - sample.mu * sample.mu);
            let seen = wavelengths.air.transmittance(sample.to_observer).scaled(sample.weight);
            nodes.push(RayNode {
                place: NodePlace {
                    mu: sample.mu,
                    sine,
                    distance: sample.distance,
                    radius: ground_radius + sample.altitude,
                },
                altitude: sample.altitude,
                density: sample.density,
                altitudes,
                air_functions: functions_of_air(setting.air, sample.mu, sine),
                scatterers: wavelengths.air.scattered(&seen, sample.density),
            });
            if !setting.aerosol.is_empty() {
                let from = functions.len();
                functions.resize(from + of.count(), 0.0);
                legendre(of, sample.mu, sine, &mut functions, from);
                functions[from..].iter_mut().zip(&chi).for_each(|(function, chi)| *function *= chi);
            }
        };
        let mut depth = [0.0; 2];
        let of_piece = |piece: PieceSamples| {
            let rule = sampling.of_piece(setting, wavelengths, piece, &mut depth);
            rule.iter().for_each(|&node| visit(piece.at(setting.medium, node, setting.variant)));
        };
        let Setting { medium, placed_for, variant, .. } = setting;
        let (ray, ground) = if length.is_finite() {
            (for_each_piece_until(*medium, placed_for, (ray, length as f32), *variant, of_piece), None)
        } else {
            let (ray, ground) = for_each_piece(*medium, placed_for, ray, *variant, of_piece);
            (ray, ground.is_seen.then_some(ground))
        };
        let ground = ground.map(|ground| {
            let seen = wavelengths.air.transmittance(ground.along);
            Ground { distance: ground.distance, radiance: seen.times(&wavelengths.albedo).scaled(LAMBERT) }
        });
        let radius = ground_radius + ray.altitude;
        // Where a ray from outside enters, it is as far from the planet's centre as anywhere else.
        let sine = (sine * (f64::from(ground_radius) + altitude) / f64::from(radius)) as f32;
        Self { radius, mu: ray.mu, sine, ground, nodes, functions, of }
    }

    /// The suns of sights at each node, where they stand among those of a table.
    pub fn suns_along(&self, grid: &Grid, sights: &[Sight]) -> Vec<SunPlace> {
        let mut places = Vec::with_capacity(self.nodes.len() * sights.len());
        for index in 0..self.nodes.len() {
            suns_along(grid.sun_angles.axis(), self.view(), index, sights, |place| places.push(place));
        }
        places
    }

    /// As the gathering takes it.
    pub fn view(&self) -> TableRay<'_, N> {
        TableRay { radius: self.radius, nodes: &self.nodes, functions: &self.functions, of: self.of }
    }

    /// Cosine of the angle between the ray and a sun, by the cosines of the sun's zenith angle and of its azimuth from the ray.
    pub fn nu(&self, mu_s: f32, sine_s: f32, cosine: f32) -> f32 {
        self.mu * mu_s + self.sine * sine_s * cosine
    }

    /// Cosine of the zenith angle of the sun where the ray meets the ground at a distance (km).
    pub fn mu_s_on_ground(&self, setting: &Setting, distance: f32, mu_s: f32, nu: f32) -> f32 {
        (self.radius * mu_s + distance * nu) / setting.medium.atmosphere.ground_radius
    }
}
