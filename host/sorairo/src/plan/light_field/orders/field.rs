//! The light field by successive orders of scattering.

use rayon::prelude::*;
use sorairo_shared::geometry::Ray;
use sorairo_shared::glam::{Vec2, Vec3};
use sorairo_shared::light_field::first_order::{single_scattering_of_lit_ray, single_scattering_of_many};
use sorairo_shared::light_field::gather::gather;
use sorairo_shared::light_field::moments::{Moments, legendre};
use sorairo_shared::light_field::polarisation::{self, SpinFunctions};
use sorairo_shared::light_field::rays::{Sight, SunPlace};
use sorairo_shared::math::{acos, max};
use sorairo_shared::medium::bands::ByScatterer;
use sorairo_shared::path::ground::direct_irradiance;
use sorairo_shared::path::pieces::lit_from_end_to_end;
use sorairo_shared::value::{Lanes, Value};
use sorairo_shared::variant;

use crate::plan::light_field::grid::{Direction, Grid, directions};
use crate::plan::light_field::orders::azimuths::{AzimuthalPhases, Azimuths, product};
use crate::plan::light_field::orders::irradiance::Irradiance;
use crate::plan::light_field::orders::made::OrdersMade;
use crate::plan::light_field::orders::plane_parallel::Layers;
use crate::plan::light_field::orders::rays::OwnedRay;
use crate::plan::light_field::orders::room::Room;
use crate::plan::light_field::orders::sampling::{Sampling, altitudes_by_depth};
use crate::plan::light_field::orders::series::{LAST, Series, dark};
use crate::plan::light_field::orders::values::{Tiles, Values};
use crate::plan::light_field::resolution::Resolution;
use crate::plan::light_field::setting::Setting;
use crate::plan::light_field::wavelengths::Wavelengths;
use crate::plan::rays::quadrature::gauss_legendre;
use crate::scene::Orders;

/// The light of all orders that scatters towards an observer, as moments over altitudes and suns.
pub struct LightField<const N: usize> {
    /// Altitudes and suns.
    pub grid: Grid,
    /// Its moments.
    pub moments: Values<N>,
    /// How it was made.
    pub orders: OrdersMade,
}

/// A light field as coefficients of `cos(m φ)` in every direction, for each sun.
struct Fourier<const N: usize> {
    azimuthal: usize,
    rows: Vec<FourierRow<N>>,
}

/// That of one direction.
#[derive(Clone)]
struct FourierRow<const N: usize> {
    /// For each sun the coefficients of radiance.
    radiance: Vec<Lanes<N>>,
    /// For each sun what the direction adds to the moments of polarised light; none where light is taken as natural.
    polarised: Vec<Lanes<N>>,
}

/// A correction of thick air's light is made while it is smaller than this part of the one before.
const LEAST_GAIN: f64 = 0.6;

impl<const N: usize> LightField<N> {
    /// The light of a sky that was scattered once or more often, up to the order before the last that is asked for.
    pub fn new(setting: &Setting, wavelengths: &Wavelengths<N>, resolution: &Resolution, orders: Orders) -> Self {
        let grid = if resolution.thick {
            Grid::of(setting, resolution, altitudes_by_depth(setting, wavelengths))
        } else {
            Grid::new(setting, resolution)
        };
        let table = Table::new(setting, wavelengths, resolution, &grid);
        let mut made = OrdersMade::of(resolution, &grid);
        let moments = match orders {
            Orders::All if resolution.plane => table.all_orders_of_thick_air(&mut made),
            Orders::All => table.all_orders(&mut made),
            Orders::UpTo(orders) => table.orders_up_to(orders.saturating_sub(1).max(1), &mut made),
        };
        Self { moments, grid, orders: made }
    }

    /// The moments as the gathering takes them.
    pub fn tiles(&self, setting: &Setting) -> Tiles {
        self.moments.tiles(&self.grid, self.moments.of, setting.couplings)
    }

    /// Memory that its values take (bytes).
    pub fn bytes(&self) -> usize {
        let Values { values, polarised, irradiance, .. } = &self.moments;
        (values.len() + polarised.len() + irradiance.len()) * size_of::<Lanes<N>>()
    }

    /// The diffuse irradiance of the ground.
    pub fn diffuse_irradiance(&self, logarithmic: bool) -> Irradiance<N> {
        Irradiance::new(&self.moments.irradiance, logarithmic)
    }
}

/// The largest mean radiance of a sum of light fields, relative to that of another at the same node, or to a part of
/// the brightest under the same sun.
fn relative_size<const N: usize>(parts: &[&Values<N>], of: &Values<N>, suns: usize) -> f64 {
    let parts: Vec<Vec<Lanes<N>>> = parts.iter().map(|part| part.means()).collect();
    let all = of.means();
    let mut largest: f64 = 0.0;
    for lane in 0..N {
        let light: Vec<f64> = all.iter().map(|mean| f64::from(mean.0[lane])).collect();
        let dark = dark(&light, suns);
        for (node, light) in light.iter().enumerate().filter(|(node, _)| dark[node % suns] > 0.0) {
            let part: f64 = parts.iter().map(|part| f64::from(part[node].0[lane])).sum();
            largest = largest.max(part.abs() / light.max(dark[node % suns]));
        }
    }
    largest
}

fn largest<const N: usize>(of: &Lanes<N>) -> f32 {
    of.0.into_iter().fold(0.0, max)
}

/// What all orders of a light field share.
struct Table<'a, const N: usize> {
    setting: &'a Setting<'a>,
    wavelengths: &'a Wavelengths<N>,
    resolution: &'a Resolution,
    grid: &'a Grid,
    directions: Vec<Direction>,
    rays: Vec<OwnedRay<N>>,
    /// Of each ray the functions `N_lm P_l^m` for the moments of the first order.
    functions: Vec<Vec<f32>>,
    /// Sines and cosines of the suns' zenith angles.
    suns: Vec<(f32, f32)>,
    /// The azimuths at which light is gathered.
    azimuths: Azimuths,
    /// Of each ray every sun at every azimuth, at its origin and at each of its nodes.
    sights: Vec<(Vec<Sight>, Option<Vec<SunPlace>>)>,
}

impl<'a, const N: usize> Table<'a, N> {
    fn new(setting: &'a Setting, wavelengths: &'a Wavelengths<N>, resolution: &'a Resolution, grid: &'a Grid) -> Self {
        let directions = directions(setting, &grid.altitudes, resolution.directions);
        let sampling = Sampling::new(resolution, resolution.samples);
        let ray = |direction: &Direction| {
            let altitude = grid.altitudes[direction.altitude];
            // No order gathers more of the one before than the second of the first.
            OwnedRay::new(
                setting,
                wavelengths,
                grid,
                &sampling,
                resolution.next,
                altitude,
                (direction.mu, f64::INFINITY),
            )
        };
        let rays: Vec<OwnedRay<N>> = directions.par_iter().map(ray).collect();
        let functions = rays.iter().map(|ray| functions_of(resolution.first, ray.mu, ray.sine)).collect();
        let suns: Vec<(f32, f32)> = grid.suns.iter().map(|sun| (sun.sin() as f32, sun.cos() as f32)).collect();
        let azimuths = Azimuths::new(resolution.azimuths);
        let seen = |ray: &OwnedRay<N>| {
            let sights = sights(ray, &suns, &azimuths);
            // Of the many nodes of thick air they would take more memory than all else, and few orders ask for them.
            let places = (!resolution.thick).then(|| ray.suns_along(grid, &sights));
            (sights, places)
        };
        let sights = rays.par_iter().map(seen).collect();
        Self { setting, wavelengths, resolution, grid, directions, rays, functions, suns, azimuths, sights }
    }

    /// Light of all orders: some are computed, until what stands for the rest is near enough.
    fn all_orders(&self, made: &mut OrdersMade) -> Values<N> {
        let mut sum = self.first_order();
        let nodes = self.grid.altitudes.len() * self.suns.len();
        let mut series = Series::new(sum.falling_together(), nodes, self.suns.len(), made.tolerance);
        // The orders that are not in the sum yet.
        let mut last: Vec<Values<N>> = Vec::new();
        loop {
            let next = match last.last() {
                None => self.next_order(&sum, self.resolution.next),
                Some(last) => self.next_order(last, self.resolution.later),
            };
            if last.len() > LAST {
                sum.add(&last.remove(0), Lanes([1.0; N]));
            }
            let closing = series.close(next.falling_together());
            last.push(next);
            made.computed += 1;
            if let Some(closing) = closing.filter(|closing| made.is_closed_by(closing)) {
                last.iter().zip(&closing.factors).for_each(|(order, factor)| sum.add_radiance(order, *factor));
                sum.close_polarised(&last, &closing.factors);
                return sum;
            }
        }
    }

    /// Light of all orders in thick air: the first two are computed; what remains is that of a plane atmosphere, which
    /// is then corrected by what one more scattering of it, in this one, says that it lacks. Where light is scattered
    /// thousands of times the errors of single scatterings would add up to more than a plane atmosphere is off, and
    /// nothing is corrected.
    fn all_orders_of_thick_air(&self, made: &mut OrdersMade) -> Values<N> {
        let layers = Layers::new(self.setting, self.wavelengths, self.grid);
        let further = |light: &Values<N>| layers.further_orders(self.setting, self.wavelengths, self.grid, light);
        let whole = Lanes([1.0; N]);
        let mut sum = self.first_order();
        let mut last = self.next_order(&sum, self.resolution.next);
        sum.add(&last, whole);
        made.computed += 1;
        let mut correction = further(&last);
        sum.add(&correction, whole);
        if !self.resolution.corrected {
            return sum;
        }
        let mut before = f64::INFINITY;
        loop {
            last.add(&correction, whole);
            let mut lacking = self.next_order(&last, self.resolution.later);
            lacking.add(&correction, Lanes([-1.0; N]));
            correction = further(&lacking);
            let off = relative_size(&[&lacking, &correction], &sum, self.suns.len());
            if off > LEAST_GAIN * before {
                return sum;
            }
            made.computed += 1;
            // What is left falls from a correction to the next as corrections do; the first is relative to all light.
            made.error = off * off / before.min(1.0);
            sum.add(&lacking, whole);
            sum.add(&correction, whole);
            if off < self.resolution.tolerance {
                return sum;
            }
            (last, before) = (lacking, off);
        }
    }

    /// Light of so many orders, one at least.
    fn orders_up_to(&self, orders: u32, made: &mut OrdersMade) -> Values<N> {
        let mut sum = self.first_order();
        let mut last: Option<Values<N>> = None;
        while made.computed < orders {
            let next = match &last {
                None => self.next_order(&sum, self.resolution.next),
                Some(last) => self.next_order(last, self.resolution.later),
            };
            sum.add(&next, Lanes([1.0; N]));
            last = Some(next);
            made.computed += 1;
        }
        sum
    }

    /// Light of the first order: the sun's, scattered once or reflected by the ground.
    fn first_order(&self) -> Values<N> {
        let of = self.resolution.first;
        let quadrature = gauss_legendre(self.resolution.first_samples);
        let azimuths = Azimuths::new(self.resolution.first_azimuths);
        let functions: Vec<Vec<f32>> = self.suns.iter().map(|&(sine, cosine)| functions_of(of, cosine, sine)).collect();
        let rays = self.directions.par_iter().zip(&self.rays).zip(&self.functions);
        let rows = rays.map(|((direction, ray), of_ray)| {
            let suns = self.suns.iter().zip(&functions);
            let mut row = FourierRow { radiance: Vec::new(), polarised: Vec::new() };
            for (&sun, of_sun) in suns {
                let phases = AzimuthalPhases::new(self.setting, of, of_ray, of_sun);
                self.add_first_order(direction, ray, sun, &quadrature, &azimuths, &phases, &mut row);
            }
            row
        });
        self.moments(of, Fourier { azimuthal: of.azimuthal, rows: rows.collect() })
    }

    /// Adds the light of the first order in one direction and for one sun to the row of the direction.
    #[expect(clippy::too_many_arguments, reason = "what all suns of a row share, and the row")]
    fn add_first_order(
        &self,
        direction: &Direction,
        ray: &OwnedRay<N>,
        (sine_s, mu_s): (f32, f32),
        quadrature: &[Vec2],
        azimuths: &Azimuths,
        phases: &AzimuthalPhases,
        row: &mut FourierRow<N>,
    ) {
        let (setting, wavelengths) = (self.setting, self.wavelengths);
        let sun = Vec3::new(sine_s, 0.0, mu_s);
        let altitude = self.grid.altitudes[direction.altitude] as f32;
        let count = azimuths.cosines.len();
        let mut parts = vec![[Lanes::ZERO; 3]; count];
        let sight = |cosine: f32| Sight { mu_s, nu: ray.nu(mu_s, sine_s, cosine), near: 0 };
        let rays = |cosine: f32| {
            let view = Vec3::new(ray.sine * cosine, ray.sine * (1.0 - cosine * cosine).sqrt(), ray.mu);
            Ray::new(altitude, view, sun)
        };
        let mut lit = Vec::with_capacity(count);
        for (a, &cosine) in azimuths.cosines.iter().enumerate() {
            if setting.variant & variant::SHADOW == 0
                || lit_from_end_to_end(setting.medium, rays(cosine), setting.variant)
            {
                lit.push(a);
            } else {
                let ByScatterer { air, aerosol } = single_scattering_of_many(
                    setting.medium,
                    &wavelengths.air,
                    &setting.placed_for,
                    quadrature,
                    rays(cosine),
                    setting.variant,
                );
                (parts[a][0], parts[a][1]) = (air, aerosol);
            }
        }
        for two in lit.chunks(2) {
            let sights = [two[0], two[two.len() - 1]].map(|a| sight(azimuths.cosines[a]));
            let light =
                single_scattering_of_lit_ray(setting.medium, &wavelengths.air, ray.view(), sights, setting.variant);
            for (&a, ByScatterer { air, aerosol }) in two.iter().zip(light) {
                (parts[a][0], parts[a][1]) = (air, aerosol);
            }
        }
        if let Some(seen) = &ray.ground {
            for (&cosine, part) in azimuths.cosines.iter().zip(&mut parts) {
                let mu_s = ray.mu_s_on_ground(setting, seen.distance, mu_s, sight(cosine).nu);
                let direct = direct_irradiance(setting.medium, &wavelengths.air, mu_s, setting.variant);
                part[2].add_product(&direct, &seen.radiance);
            }
        }
        let numbers = self.resolution.first.azimuthal + 1;
        let mut fourier = vec![Lanes::ZERO; numbers];
        let mut polarised = [Lanes::ZERO; polarisation::MOMENTS];
        let spin = SpinFunctions::new(ray.mu, ray.sine);
        for j in 0..count {
            let mut amplitudes = [Lanes::ZERO; 3];
            for (part, &share) in parts.iter().zip(azimuths.amplitudes(j)) {
                for (amplitude, value) in amplitudes.iter_mut().zip(part) {
                    amplitude.add_scaled(value, share);
                }
            }
            let [air, aerosol, ground] = amplitudes;
            for (n, coefficient) in fourier.iter_mut().enumerate() {
                coefficient.add_scaled(&air, product(&phases.air, n, j));
                coefficient.add_scaled(&aerosol, product(&phases.aerosol, n, j));
                coefficient.add_scaled(&ground, product(&[1.0], n, j));
            }
            if let Some(of_suns) = phases.polarised {
                for (n, moment) in polarised.iter_mut().enumerate() {
                    moment.add_scaled(&air, spin.moment(of_suns.air, n, j));
                    moment.add_scaled(&aerosol, spin.moment(of_suns.aerosol, n, j));
                }
            }
        }
        row.radiance.extend(fourier);
        if phases.polarised.is_some() {
            row.polarised.extend(polarised);
        }
    }

    /// Light of the order after the one of `last`, in these moments. Scattering mixes moments of different azimuthal
    /// numbers as little as the vertical turns along a ray: those of `last` that are not among them are left out.
    fn next_order(&self, last: &Values<N>, of: Moments) -> Values<N> {
        let tiles = last.tiles(self.grid, of, self.setting.couplings);
        let azimuths = self.azimuths.cosines.len();
        let table = tiles.table(self.grid, self.resolution.logarithmic);
        let irradiance = Irradiance::new(&last.irradiance, self.resolution.logarithmic);
        let rows = self.rays.par_iter().zip(&self.sights).map_init(
            || Room::new::<N>(&table, self.suns.len() * azimuths),
            |room, (ray, (sights, places))| {
                let mut light = vec![Lanes::ZERO; sights.len()];
                let mut stokes = vec![[Lanes::ZERO; 2]; if table.couplings.is_some() { sights.len() } else { 0 }];
                let found = places.is_none().then(|| ray.suns_along(self.grid, sights));
                let places = found.as_ref().or(places.as_ref()).expect("either");
                gather(table, ray.view(), places, &mut room.scratch(), &mut light, &mut stokes);
                self.add_ground(ray, &irradiance, sights, &mut light);
                let mut fourier = vec![Lanes::ZERO; self.suns.len() * (of.azimuthal + 1)];
                let suns = light.chunks(azimuths).zip(fourier.chunks_mut(of.azimuthal + 1));
                suns.for_each(|(light, fourier)| self.azimuths.add_fourier(light, fourier));
                let spin = SpinFunctions::new(ray.mu, ray.sine);
                let polarised =
                    stokes.chunks(azimuths).flat_map(|stokes| self.azimuths.polarised(spin, stokes)).collect();
                FourierRow { radiance: fourier, polarised }
            },
        );
        self.moments(of, Fourier { azimuthal: of.azimuthal, rows: rows.collect() })
    }

    /// Adds the light of the ground.
    fn add_ground(&self, ray: &OwnedRay<N>, irradiance: &Irradiance<N>, sights: &[Sight], light: &mut [Lanes<N>]) {
        let Some(ground) = &ray.ground else { return };
        if largest(&self.wavelengths.albedo) == 0.0 {
            return;
        }
        for (sight, light) in sights.iter().zip(light) {
            let mu_s = ray.mu_s_on_ground(self.setting, ground.distance, sight.mu_s, sight.nu);
            light.add_product(&irradiance.at(self.grid, acos(mu_s)), &ground.radiance);
        }
    }

    /// The moments of a light field and the irradiance of the ground.
    fn moments(&self, of: Moments, field: Fourier<N>) -> Values<N> {
        let suns = self.suns.len();
        let numbers = field.azimuthal + 1;
        let of_altitude = |altitude: usize| {
            let mut values = vec![Lanes::ZERO; suns * of.count()];
            let rays = self.directions.iter().zip(&self.functions).zip(&field.rows);
            for ((direction, functions), row) in rays.filter(|((direction, _), _)| direction.altitude == altitude) {
                for (values, fourier) in values.chunks_mut(of.count()).zip(row.radiance.chunks(numbers)) {
                    for (m, fourier) in fourier.iter().enumerate() {
                        let functions = &functions[self.resolution.first.first(m)..];
                        for (value, function) in values[of.first(m)..of.first(m + 1)].iter_mut().zip(functions) {
                            value.add_scaled(fourier, function * direction.weight as f32);
                        }
                    }
                }
            }
            values
        };
        let values = (0..self.grid.altitudes.len()).into_par_iter().flat_map_iter(of_altitude).collect();
        let of_node = suns * if self.setting.couplings.is_some() { polarisation::MOMENTS } else { 0 };
        let mut polarised = vec![Lanes::ZERO; self.grid.altitudes.len() * of_node];
        for (direction, row) in self.directions.iter().zip(&field.rows) {
            let moments = polarised[direction.altitude * of_node..].iter_mut().zip(&row.polarised);
            moments.for_each(|(moment, of_row)| moment.add_scaled(of_row, direction.weight as f32));
        }
        let mut irradiance = vec![Lanes::ZERO; suns];
        let down = |direction: &&Direction| direction.altitude == 0 && direction.mu > 0.0;
        for (direction, row) in self.directions.iter().zip(&field.rows).filter(|(direction, _)| down(direction)) {
            for (irradiance, fourier) in irradiance.iter_mut().zip(row.radiance.chunks(numbers)) {
                irradiance.add_scaled(&fourier[0], (direction.mu * direction.weight) as f32);
            }
        }
        Values { of, values, polarised, irradiance }
    }
}

/// Every sun at every azimuth, as a ray sees it.
pub(crate) fn sights<const N: usize>(ray: &OwnedRay<N>, suns: &[(f32, f32)], azimuths: &Azimuths) -> Vec<Sight> {
    let of_sun = |(near, &(sine_s, mu_s)): (usize, &(f32, f32))| {
        let sight = move |&cosine: &f32| Sight { mu_s, nu: ray.nu(mu_s, sine_s, cosine), near: near.saturating_sub(1) };
        azimuths.cosines.iter().map(sight).collect::<Vec<_>>()
    };
    suns.iter().enumerate().flat_map(of_sun).collect()
}

/// The functions `N_lm P_l^m` of a direction.
fn functions_of(of: Moments, mu: f32, sine: f32) -> Vec<f32> {
    let mut functions = vec![0.0; of.count()];
    legendre(of, mu, sine, &mut functions, 0);
    functions
}
