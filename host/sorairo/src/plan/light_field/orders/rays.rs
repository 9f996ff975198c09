//! Rays through a table of the light field: what every sun and azimuth shares.

use std::ops::Range;

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

/// Nodes of a ray that are made one after the other.
struct NodesMade<'a, const N: usize> {
    setting: &'a Setting<'a>,
    wavelengths: &'a Wavelengths<N>,
    grid: &'a Grid,
    of: Moments,
    /// `χ_l` of aerosol for each of the functions.
    chi: Vec<f32>,
    /// The altitude of the table near the last node.
    near: usize,
    nodes: Vec<RayNode<N>>,
    functions: Vec<f32>,
}

impl<'a, const N: usize> NodesMade<'a, N> {
    fn new(
        setting: &'a Setting,
        wavelengths: &'a Wavelengths<N>,
        grid: &'a Grid,
        of: Moments,
        expected: usize,
    ) -> Self {
        let chi: Vec<f32> = if setting.aerosol.is_empty() {
            Vec::new()
        } else {
            (0..=of.azimuthal).flat_map(|m| &setting.aerosol[m..=of.degree]).copied().collect()
        };
        let functions = Vec::with_capacity(expected * chi.len());
        Self { setting, wavelengths, grid, of, chi, near: 0, nodes: Vec::with_capacity(expected), functions }
    }

    fn add(&mut self, sample: Sample) {
        let Self { setting, wavelengths, grid, of, .. } = *self;
        let place = grid.place_of(setting, sample.altitude);
        let altitudes = grid.places.axis().stencil(place, self.near);
        self.near = altitudes.first;
        let sine = safe_sqrt(1.0 - sample.mu * sample.mu);
        let seen = wavelengths.air.transmittance(sample.to_observer).scaled(sample.weight);
        self.nodes.push(RayNode {
            place: NodePlace {
                mu: sample.mu,
                sine,
                distance: sample.distance,
                radius: setting.medium.atmosphere.ground_radius + sample.altitude,
            },
            altitude: sample.altitude,
            density: sample.density,
            altitudes,
            air_functions: functions_of_air(setting.air, sample.mu, sine),
            scatterers: wavelengths.air.scattered(&seen, sample.density),
        });
        if !self.chi.is_empty() {
            let from = self.functions.len();
            self.functions.resize(from + of.count(), 0.0);
            legendre(of, sample.mu, sine, &mut self.functions, from);
            self.functions[from..].iter_mut().zip(&self.chi).for_each(|(function, chi)| *function *= chi);
        }
    }
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
        let mut made = NodesMade::new(setting, wavelengths, grid, of, 2 * sampling.fewest());
        let mut depth = [0.0; 2];
        let of_piece = |piece: PieceSamples| {
            let rule = sampling.of_piece(setting, wavelengths, piece, &mut depth);
            rule.iter().for_each(|&node| made.add(piece.at(setting.medium, node, setting.variant)));
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
        let NodesMade { nodes, functions, .. } = made;
        Self { radius, mu: ray.mu, sine, ground, nodes, functions, of }
    }

    /// The ray from an altitude (km) with the cosine `mu` of its zenith angle through samples whose distances count
    /// from there; without its ground.
    pub fn through(
        setting: &Setting,
        wavelengths: &Wavelengths<N>,
        grid: &Grid,
        of: Moments,
        (altitude, mu): (f64, f64),
        samples: &[Sample],
    ) -> Self {
        let mut made = NodesMade::new(setting, wavelengths, grid, of, samples.len());
        samples.iter().for_each(|&sample| made.add(sample));
        let radius = setting.medium.atmosphere.ground_radius + altitude as f32;
        let sine = (1.0 - mu * mu).max(0.0).sqrt() as f32;
        let NodesMade { nodes, functions, .. } = made;
        Self { radius, mu: mu as f32, sine, ground: None, nodes, functions, of }
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
        self.part(0..self.nodes.len())
    }

    /// The same of some of its nodes.
    pub fn part(&self, nodes: Range<usize>) -> TableRay<'_, N> {
        let of_node = if self.functions.is_empty() { 0 } else { self.of.count() };
        let functions = &self.functions[nodes.start * of_node..nodes.end * of_node];
        TableRay { radius: self.radius, nodes: &self.nodes[nodes], functions, of: self.of }
    }

    /// Cosine of the angle between the ray and a sun, by the cosines of the sun's zenith angle and of its azimuth from
    /// the ray.
    pub fn nu(&self, mu_s: f32, sine_s: f32, cosine: f32) -> f32 {
        self.mu * mu_s + self.sine * sine_s * cosine
    }

    /// Cosine of the zenith angle of the sun where the ray meets the ground at a distance (km).
    pub fn mu_s_on_ground(&self, setting: &Setting, distance: f32, mu_s: f32, nu: f32) -> f32 {
        (self.radius * mu_s + distance * nu) / setting.medium.atmosphere.ground_radius
    }
}
