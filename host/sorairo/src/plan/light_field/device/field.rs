//! The light field on a device, planned: which kernels of [`sorairo_shared::light_field::device`] run after each other,
//! and what lies where.
//!
//! The plan decides, the device runs; what comes back between is the mean radiance of each order, from which the
//! processor tells how many orders are enough. It is the same light field as
//! [`crate::plan::light_field::orders::field`]'s, by the same rules.

use std::ops::Range;
use std::{array, iter};

use sorairo_shared::glam::{Vec2, Vec4};
use sorairo_shared::light_field::device::uniform::{
    FieldUniform, OF_FIRST, OF_STOKES, Orders as OrdersAt, Tables, Values as ValuesAt,
};
use sorairo_shared::light_field::moments::Moments;
use sorairo_shared::medium::bands::Bands;
use sorairo_shared::value::{Lanes, Value};

use crate::error::{Error, Result};
use crate::plan::light_field::device::lists::{
    Lists, NUMBERS, Room, along_rays, both, of_ray, polarised_moments, uniform_of,
};
use crate::plan::light_field::grid::{Direction, Grid, directions};
use crate::plan::light_field::orders::azimuths::Azimuths;
use crate::plan::light_field::orders::made::{MOST, OrdersMade};
use crate::plan::light_field::orders::series::{Series, geometric_factor};
use crate::plan::light_field::resolution::Resolution;
use crate::plan::light_field::setting::Setting;
use crate::plan::on_device::{Dispatch, FieldKernel, Memory, PlanDevice, PlanPass, ReadBack, Retained};
use crate::plan::rays::quadrature::gauss_legendre;
use crate::scene::Orders;

/// The orders that are computed before the device is asked for their means, and after each time that they were not
/// enough.
const AT_FIRST: usize = 4;
const AT_ONCE: usize = 2;

/// A light field that stays in a device: the moments of its sum and the irradiance of the ground.
pub struct DeviceField {
    /// Where its values are.
    pub memory: Memory,
    /// Altitudes and suns.
    pub grid: Grid,
    /// Memory that it takes (bytes).
    pub bytes: usize,
    /// How it was made.
    pub orders: OrdersMade,
}

/// Bytes of a value.
const VALUE: usize = size_of::<Vec4>();

/// The moments of an order, counted from 0.
fn moments_of(resolution: &Resolution, order: usize) -> Moments {
    match order {
        0 => resolution.first,
        1 => resolution.next,
        _ => resolution.later,
    }
}

/// Where the orders of a light field are.
struct OrderPlaces {
    orders: Vec<u32>,
    /// Of each order, and their end.
    means: Vec<u32>,
    sum: u32,
    end: usize,
}

impl OrderPlaces {
    /// Of so many orders at so many altitudes, suns and groups of bands, with so many moments of polarised light.
    fn new(resolution: &Resolution, orders: usize, [altitudes, suns, groups]: [usize; 3], polarised: usize) -> Self {
        let mut room = Room::default();
        let nodes = altitudes * suns;
        let mut order =
            |order| room.take((nodes * (moments_of(resolution, order).count() + polarised) + suns) * groups);
        let (orders_at, sum) = ((0..orders).map(&mut order).collect(), order(0));
        let means = (0..=orders).map(|_| room.take(nodes * (1 + polarised) * groups)).collect();
        Self { orders: orders_at, means, sum, end: room.0 }
    }
}

/// Lists the rays of a light field, and where those of each altitude begin.
fn add_directions(lists: &mut Lists, tables: &mut Tables, grid: &Grid, directions: &[Direction]) {
    let ray = |direction: &Direction| of_ray(grid.altitudes[direction.altitude], direction.mu, direction.weight);
    tables.rays = lists.add(directions.iter().flat_map(ray));
    let first_ray = |altitude| directions.partition_point(|direction| direction.altitude < altitude) as f32;
    tables.first_rays = lists.add((0..=grid.altitudes.len()).map(first_ray));
}

/// What all orders of a light field share.
struct Table<'a, const N: usize> {
    device: &'a dyn PlanDevice,
    setting: &'a Setting<'a>,
    bands: &'a [Bands],
    resolution: &'a Resolution,
    grid: Grid,
    lists: Lists,
    /// The uniform of a later order, but for where the orders are.
    uniform: FieldUniform,
    /// Where the azimuths of the first order are listed.
    first_azimuths: u32,
    places: OrderPlaces,
    quadratures: [Vec<Vec2>; 2],
    memory: [Memory; 3],
}

impl DeviceField {
    /// The light field of [`crate::plan::light_field::orders::field::LightField::new`] on a device, at up to a quarter
    /// of `N` groups of bands.
    pub fn new<const N: usize>(
        device: &dyn PlanDevice,
        setting: &Setting,
        bands: &[Bands],
        resolution: &Resolution,
        orders: Orders,
    ) -> Result<Self> {
        let most = match orders {
            Orders::All => MOST as usize,
            Orders::UpTo(orders) => (orders as usize).saturating_sub(1).max(1),
        };
        if most > MOST as usize {
            return Err(Error::Device(format!("it adds up at most {MOST} orders")));
        }
        let table = Table::<N>::new(device, setting, bands, resolution, most)?;
        let mut made = OrdersMade::of(resolution, &table.grid);
        let factors = match orders {
            Orders::All => table.all_orders(&mut made)?,
            Orders::UpTo(_) => {
                table.compute(0..most)?;
                made.computed = most as u32;
                vec![Lanes([1.0; N]); (most - 1) * table.kinds()]
            }
        };
        table.sum(&factors, made)
    }
}

impl<'a, const N: usize> Table<'a, N> {
    fn new(
        device: &'a dyn PlanDevice,
        setting: &'a Setting,
        bands: &'a [Bands],
        resolution: &'a Resolution,
        most: usize,
    ) -> Result<Self> {
        let grid = Grid::new(setting, resolution);
        let directions = directions(setting, &grid.altitudes, resolution.directions);
        let mut lists = Lists::default();
        let mut tables = lists.add_grid(setting, &grid);
        add_directions(&mut lists, &mut tables, &grid, &directions);
        let first_azimuths = lists.add(Azimuths::new(resolution.first_azimuths).list());
        tables.azimuths = lists.add(Azimuths::new(resolution.azimuths).list());
        let (groups, rays, suns) = (bands.len(), directions.len(), grid.suns.len());
        let nodes = rays * 2 * resolution.samples as usize;
        let Resolution { first, next, .. } = *resolution;
        let mut functions = Room::default();
        let mut values = Room::default();
        let polarised = polarised_moments(setting);
        let of_light = if polarised > 0 { 1 + OF_STOKES } else { 1 };
        let light = (OF_FIRST * resolution.first_azimuths).max(of_light * resolution.azimuths);
        let at = ValuesAt {
            ray_functions: functions.take(rays * first.count()),
            sun_functions: functions.take(suns * first.count()),
            light: values.take(rays * suns * light * groups),
            phases: values.take(rays * suns * (first.azimuthal + 1)),
            fourier: values.take(rays * suns * (first.azimuthal + 1 + polarised) * groups),
            ..along_rays(&mut functions, &mut values, next, [rays, nodes, suns, groups], next.azimuthal + 1 + polarised)
        };
        let places = OrderPlaces::new(resolution, most, [grid.altitudes.len(), suns, groups], polarised);
        let uniform = FieldUniform {
            at_nodes: both(next),
            rays: rays as u32,
            samples: resolution.samples,
            sights: (suns * resolution.azimuths) as u32,
            azimuths: resolution.azimuths as u32,
            gathered: polarised as u32,
            tables,
            values: at,
            ..uniform_of(setting, resolution, &grid, groups)
        };
        let reserve = |numbers| device.reserve(numbers);
        let memory = [reserve(functions.0)?, reserve(NUMBERS * values.0)?, reserve(NUMBERS * places.end)?];
        Ok(Self {
            device,
            setting,
            bands,
            resolution,
            grid,
            lists,
            uniform,
            first_azimuths,
            places,
            quadratures: [resolution.samples, resolution.first_samples].map(gauss_legendre),
            memory,
        })
    }

    fn work<'b>(&'b self, steps: &'b [Dispatch], keep: Option<Retained<'b>>, read: Option<ReadBack>) -> PlanPass<'b> {
        PlanPass {
            steps,
            variant: self.setting.variant,
            bands: self.bands,
            quadratures: [&self.quadratures[0], &self.quadratures[1]],
            tables: &self.lists.0,
            columns: self.setting.medium.tables,
            memory: [&self.memory[0], &self.memory[1], &self.memory[2]],
            keep,
            read,
        }
    }

    /// The steps of an order, counted from 0; see [`crate::plan::light_field::orders::field`].
    fn steps(&self, order: usize) -> Vec<Dispatch> {
        let of = moments_of(self.resolution, order);
        let mut uniform = FieldUniform {
            of: both(of),
            kept: OrdersAt {
                last: self.places.orders[order.saturating_sub(1)],
                of: self.places.orders[order],
                means: self.places.means[order],
                sum: self.places.sum,
            },
            ..self.uniform
        };
        let FieldUniform { rays, suns, groups, altitudes, samples, polarised, .. } = uniform;
        let of_node = of.count() as u32 + polarised;
        let (nodes, of_moments) = (2 * rays * samples, (altitudes * suns * of_node + suns) * groups);
        let coefficients = of.azimuthal as u32 + 1 + polarised;
        let step = |kernel, uniform, invocations| Dispatch { kernel, uniform: FieldUniform { invocations, ..uniform } };
        let under_suns = rays * suns * groups;
        if order == 0 {
            uniform.azimuths = self.resolution.first_azimuths as u32;
            uniform.sights = suns * uniform.azimuths;
            uniform.tables.azimuths = self.first_azimuths;
            return vec![
                step(FieldKernel::FieldNodes, uniform, nodes),
                step(FieldKernel::FieldFunctions, uniform, rays + suns),
                step(FieldKernel::FieldPhases, uniform, rays * suns * (of.azimuthal as u32 + 1)),
                step(FieldKernel::FieldFirst, uniform, rays * uniform.sights * groups),
                step(FieldKernel::FieldFirstFourier, uniform, under_suns * coefficients),
                step(FieldKernel::FieldMoments, uniform, of_moments),
            ];
        }
        let last = moments_of(self.resolution, order - 1);
        uniform.last = both(last);
        uniform.taken =
            both(Moments { degree: of.degree.min(last.degree), azimuthal: of.azimuthal.min(last.azimuthal) });
        vec![
            step(FieldKernel::FieldSources, uniform, nodes * suns * groups),
            step(FieldKernel::FieldGather, uniform, rays * uniform.sights * groups),
            step(FieldKernel::FieldFourier, uniform, under_suns * coefficients),
            step(FieldKernel::FieldMoments, uniform, of_moments),
        ]
    }

    /// Factors of an order: those of radiance and `E_20`, and where light is polarised of `E_21` and of `E_22`.
    fn kinds(&self) -> usize {
        polarised_moments(self.setting).max(1)
    }

    fn nodes(&self) -> usize {
        self.grid.altitudes.len() * self.grid.suns.len()
    }

    /// Computes orders; returns the mean radiances of each at all nodes, then the moments of polarised light.
    fn compute(&self, orders: Range<usize>) -> Result<Vec<Vec<Lanes<N>>>> {
        let steps: Vec<Dispatch> = orders.clone().flat_map(|order| self.steps(order)).collect();
        let means = self.places.means[orders.start] as usize..self.places.means[orders.end] as usize;
        let read = self.device.run(&self.work(&steps, None, Some(ReadBack::Orders(means))))?;
        let of_order = self.nodes() * (1 + polarised_moments(self.setting)) * self.bands.len();
        let mean = |groups: &[Vec4]| {
            let mut lanes = Lanes::ZERO;
            groups.iter().zip(lanes.0.chunks_mut(4)).for_each(|(four, lanes)| lanes.copy_from_slice(&four.to_array()));
            lanes
        };
        let means = |order: &[Vec4]| order.chunks_exact(self.bands.len()).map(mean).collect();
        Ok(read.chunks_exact(of_order).map(means).collect())
    }

    /// Light of all orders: some are computed, until what stands for the rest is near enough. How often each of those
    /// after the first counts.
    fn all_orders(&self, made: &mut OrdersMade) -> Result<Vec<Lanes<N>>> {
        let mut means = self.compute(0..AT_FIRST)?;
        let nodes = self.nodes();
        // `E_20` mixes with the mean radiances from order to order.
        let fall_together = |order: &[Lanes<N>]| order[..order.len().min(2 * nodes)].to_vec();
        let mut series = Series::new(fall_together(&means[0]), nodes, self.grid.suns.len(), made.tolerance);
        let mut next = 1;
        loop {
            if next == means.len() {
                means.extend(self.compute(next..(next + AT_ONCE).min(MOST as usize))?);
            }
            let closing = series.close(fall_together(&means[next]));
            made.computed += 1;
            if let Some(closing) = closing.filter(|closing| made.is_closed_by(closing)) {
                let last = closing.factors.len();
                let of_order = |order: usize| {
                    let of_radiance = order.checked_sub(next - last + 1).map(|at| closing.factors[at]);
                    let others = (1..self.kinds()).map(|m| match order == next && last > 1 {
                        true => self.closing_of_polarised(&means[next - 1..=next], m),
                        false => Lanes([1.0; N]),
                    });
                    let others: Vec<Lanes<N>> = others.collect();
                    iter::once(of_radiance.unwrap_or(Lanes([1.0; N]))).chain(others)
                };
                return Ok((1..=next).flat_map(of_order).collect());
            }
            next += 1;
        }
    }

    /// How often the last of two orders counts for `E_2m`; see
    /// [`crate::plan::light_field::orders::values::Values::close_polarised`].
    fn closing_of_polarised(&self, last: &[Vec<Lanes<N>>], m: usize) -> Lanes<N> {
        let nodes = self.nodes();
        let size = |order: &[Lanes<N>], lane: usize| {
            order[(1 + m) * nodes..(2 + m) * nodes].iter().map(|moment| f64::from(moment.0[lane].abs())).sum::<f64>()
        };
        Lanes(array::from_fn(|lane| geometric_factor(size(&last[0], lane), size(&last[1], lane))))
    }

    /// The sum of the first order and those after it, as often as each counts.
    fn sum(mut self, factors: &[Lanes<N>], orders: OrdersMade) -> Result<DeviceField> {
        let groups = self.bands.len();
        let count = self.resolution.first.count() + polarised_moments(self.setting);
        let values = (self.nodes() * count + self.grid.suns.len()) * groups;
        let of_order = |factors: &Lanes<N>| factors.0.into_iter().take(4 * groups);
        let mut uniform = self.uniform;
        uniform.tables.factors = self.lists.add(factors.iter().flat_map(of_order));
        let uniform = FieldUniform {
            invocations: values as u32,
            orders: (factors.len() / self.kinds()) as u32,
            kept: OrdersAt {
                of: self.places.orders[0],
                last: self.places.orders.get(1).copied().unwrap_or_default(),
                means: 0,
                sum: self.places.sum,
            },
            ..uniform
        };
        let (memory, first) = (self.device.reserve(NUMBERS * values)?, self.places.sum as usize);
        let keep = Retained { values: first..first + values, to: &memory };
        let step = Dispatch { kernel: FieldKernel::FieldSum, uniform };
        self.device.run(&self.work(&[step], Some(keep), None))?;
        Ok(DeviceField { memory, grid: self.grid, bytes: VALUE * values, orders })
    }
}
