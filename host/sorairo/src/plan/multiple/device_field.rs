//! The light field on a device, planned: which kernels of [`sorairo_shared::field_kernels`] run after each other, and what lies where.
//!
//! The plan decides, the device runs; what comes back between is the mean radiance of each order, from which the processor tells how many orders are
//! enough. It is the same light field as [`super::field`]'s, by the same rules.

use std::ops::Range;

use sorairo_shared::field_kernels::{
    FieldUniform, OF_FIRST, OF_LISTED_RAY, Orders as OrdersAt, Tables, Values as ValuesAt,
};
use sorairo_shared::glam::{UVec2, Vec2, Vec3, Vec4};
use sorairo_shared::moments::Moments;
use sorairo_shared::multiple::Lanes;
use sorairo_shared::profile::Atmosphere;
use sorairo_shared::single::Bands;

use super::field::{Azimuths, OrdersMade};
use super::grid::{Direction, Grid, directions};
use super::resolution::Resolution;
use super::series::{Closing, LAST};
use super::setting::Setting;
use super::sights::{Light, Row, sight};
use crate::plan::on_device::{FieldKernel, Keeping, Memory, PlanDevice, Reading, Step, Work};
use crate::plan::quadrature::gauss_legendre;
use crate::scene::Orders;

/// The orders that are computed before the device is asked for their means, and after each time that they were not enough.
const AT_FIRST: usize = 4;
const AT_ONCE: usize = 2;

/// The most orders that are computed.
const MOST: usize = 24;

/// Lists of numbers that a device reads.
#[derive(Default)]
struct Lists(Vec<f32>);

impl Lists {
    /// Adds a list; where it begins.
    fn add(&mut self, list: impl IntoIterator<Item = f32>) -> u32 {
        let first = self.0.len();
        self.0.extend(list);
        first as u32
    }
}

/// Room that is handed out from its beginning.
#[derive(Default)]
struct Room(usize);

impl Room {
    /// Takes some of it; where that begins.
    fn take(&mut self, numbers: usize) -> u32 {
        self.0 += numbers;
        (self.0 - numbers) as u32
    }
}

/// A light field that stays in a device: the moments of its sum and the irradiance of the ground.
pub struct DeviceField {
    memory: Memory,
    grid: Grid,
    /// Memory that it takes (bytes).
    pub bytes: usize,
    /// How it was made.
    pub orders: OrdersMade,
}

/// Bytes of a value.
const VALUE: usize = size_of::<Vec4>();
/// Numbers of a value.
const NUMBERS: usize = 4;

fn both(of: Moments) -> UVec2 {
    UVec2::new(of.degree as u32, of.azimuthal as u32)
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
    /// Where the orders begin, and their means; the end of all.
    orders: Vec<u32>,
    means: Vec<u32>,
    sum: u32,
    quadratures: [Vec<Vec2>; 2],
    memory: [Memory; 3],
}

impl DeviceField {
    /// The light field of [`super::field::LightField::new`] on a device, at up to a quarter of `N` groups of bands.
    pub fn new<const N: usize>(
        device: &dyn PlanDevice,
        setting: &Setting,
        bands: &[Bands],
        resolution: &Resolution,
        orders: Orders,
    ) -> Option<Self> {
        let most = match orders {
            Orders::All => MOST,
            Orders::UpTo(orders) => (orders as usize).saturating_sub(1).max(1),
        };
        if most > MOST {
            return None;
        }
        let table = Table::<N>::new(device, setting, bands, resolution, most)?;
        let mut made = OrdersMade::of(resolution, &table.grid);
        let factors = match orders {
            Orders::All => table.all_orders(&mut made)?,
            Orders::UpTo(_) => {
                table.compute(0..most)?;
                made.computed = most as u32;
                vec![Lanes([1.0; N]); most - 1]
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
    ) -> Option<Self> {
        let grid = Grid::new(setting, resolution.altitudes, resolution.thin_air);
        let directions = directions(setting, &grid.altitudes, resolution.directions);
        let mut lists = Lists::default();
        let mut tables = lists_of_grid(&mut lists, setting, &grid);
        let ray = |direction: &Direction| of_ray(grid.altitudes[direction.altitude], direction.mu, direction.weight);
        tables.rays = lists.add(directions.iter().flat_map(ray));
        let first_ray = |altitude| directions.partition_point(|direction| direction.altitude < altitude) as f32;
        tables.first_rays = lists.add((0..=grid.altitudes.len()).map(first_ray));
        let first_azimuths = lists.add(Azimuths::new(resolution.first_azimuths).list());
        tables.azimuths = lists.add(Azimuths::new(resolution.azimuths).list());

        let (groups, rays, suns) = (bands.len(), directions.len(), grid.suns.len());
        let nodes = rays * 2 * resolution.samples as usize;
        let Resolution { first, next, later, .. } = *resolution;
        let mut functions = Room::default();
        let mut values = Room::default();
        let light = 3 * resolution.first_azimuths.max(resolution.azimuths.div_ceil(3));
        let at = ValuesAt {
            ray_functions: functions.take(rays * first.count()),
            sun_functions: functions.take(suns * first.count()),
            light: values.take(rays * suns * light * groups),
            phases: values.take(rays * suns * (first.azimuthal + 1)),
            fourier: values.take(rays * suns * (first.azimuthal + 1) * groups),
            ..along_rays(&mut functions, &mut values, next, [rays, nodes, suns, groups], next.azimuthal)
        };
        let mut of_orders = Room::default();
        let of_order = |order: usize| {
            if order == 0 {
                first
            } else if order == 1 {
                next
            } else {
                later
            }
        };
        let sun_nodes = grid.altitudes.len() * suns;
        let mut order = |of: Moments| of_orders.take((sun_nodes * of.count() + suns) * groups);
        let orders: Vec<u32> = (0..most).map(|number| order(of_order(number))).collect();
        let sum = order(first);
        let means = (0..=most).map(|_| of_orders.take(sun_nodes * groups)).collect();
        let uniform = FieldUniform {
            at_nodes: both(next),
            rays: rays as u32,
            samples: resolution.samples,
            sights: (suns * resolution.azimuths) as u32,
            azimuths: resolution.azimuths as u32,
            tables,
            values: at,
            ..uniform_of(setting, resolution, &grid, groups)
        };
        let memory = [functions.0, NUMBERS * values.0, NUMBERS * of_orders.0].map(|numbers| device.reserve(numbers));
        let [Some(functions), Some(values), Some(of_orders)] = memory else { return None };
        Some(Self {
            device,
            setting,
            bands,
            resolution,
            grid,
            lists,
            uniform,
            first_azimuths,
            orders,
            means,
            sum,
            quadratures: [resolution.samples, resolution.first_samples].map(gauss_legendre),
            memory: [functions, values, of_orders],
        })
    }

    fn work<'b>(&'b self, tables: &'b [f32]) -> Work<'b> {
        Work {
            variant: self.setting.variant,
            bands: self.bands,
            quadratures: [&self.quadratures[0], &self.quadratures[1]],
            tables,
            memory: [&self.memory[0], &self.memory[1], &self.memory[2]],
        }
    }

    fn moments_of(&self, order: usize) -> Moments {
        match order {
            0 => self.resolution.first,
            1 => self.resolution.next,
            _ => self.resolution.later,
        }
    }

    /// The steps of an order, counted from 0; see [`super::field`].
    fn steps(&self, order: usize) -> Vec<Step> {
        let of = self.moments_of(order);
        let mut uniform = FieldUniform {
            of: both(of),
            kept: OrdersAt {
                last: self.orders[order.saturating_sub(1)],
                of: self.orders[order],
                means: self.means[order],
                sum: self.sum,
            },
            ..self.uniform
        };
        let FieldUniform { rays, suns, groups, altitudes, samples, .. } = uniform;
        let (nodes, of_moments) = (2 * rays * samples, (altitudes * suns * of.count() as u32 + suns) * groups);
        let step = |kernel, uniform, invocations| Step { kernel, uniform: FieldUniform { invocations, ..uniform } };
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
                step(FieldKernel::FieldFirstFourier, uniform, under_suns * (of.azimuthal as u32 + 1)),
                step(FieldKernel::FieldMoments, uniform, of_moments),
            ];
        }
        let last = self.moments_of(order - 1);
        uniform.last = both(last);
        uniform.taken =
            both(Moments { degree: of.degree.min(last.degree), azimuthal: of.azimuthal.min(last.azimuthal) });
        vec![
            step(FieldKernel::FieldSources, uniform, nodes * suns * groups),
            step(FieldKernel::FieldGather, uniform, rays * uniform.sights * groups),
            step(FieldKernel::FieldFourier, uniform, under_suns * (of.azimuthal as u32 + 1)),
            step(FieldKernel::FieldMoments, uniform, of_moments),
        ]
    }

    /// Computes orders; returns the mean radiances of each at all nodes.
    fn compute(&self, orders: Range<usize>) -> Option<Vec<Vec<Lanes<N>>>> {
        let steps: Vec<Step> = orders.clone().flat_map(|order| self.steps(order)).collect();
        let means = self.means[orders.start] as usize..self.means[orders.end] as usize;
        let read = self.device.run(&self.work(&self.lists.0), &steps, None, Some(Reading::Orders(means)))?;
        let nodes = self.grid.altitudes.len() * self.grid.suns.len();
        let mean = |groups: &[Vec4]| {
            let mut lanes = Lanes::ZERO;
            groups.iter().zip(lanes.0.chunks_mut(4)).for_each(|(four, lanes)| lanes.copy_from_slice(&four.to_array()));
            lanes
        };
        let of_order = |order: &[Vec4]| order.chunks_exact(self.bands.len()).map(mean).collect();
        Some(read.chunks_exact(nodes * self.bands.len()).map(of_order).collect())
    }

    /// Light of all orders: some are computed, until what stands for the rest is near enough. How often each of those after the first counts.
    fn all_orders(&self, made: &mut OrdersMade) -> Option<Vec<Lanes<N>>> {
        let mut means = self.compute(0..AT_FIRST)?;
        let mut sum = means[0].clone();
        // The last that is in the sum, and the last that is looked at.
        let (mut before, mut last) = (0, 2);
        loop {
            if last >= means.len() {
                means.extend(self.compute(means.len()..(means.len() + AT_ONCE).min(MOST))?);
            }
            let closing = Closing::new(&means[before..=last], &sum, self.grid.suns.len());
            made.computed = last as u32 + 1;
            made.error = closing.error;
            made.ratio = std::array::from_fn(|i| closing.ratio[i]);
            if closing.error <= made.tolerance || last + 1 == MOST {
                return Some([vec![Lanes([1.0; N]); before], closing.factors].concat());
            }
            if last - before == LAST {
                before += 1;
                sum.iter_mut().zip(&means[before]).for_each(|(sum, mean)| sum.add_scaled(mean, 1.0));
            }
            last += 1;
        }
    }

    /// The sum of the first order and those after it, as often as each counts.
    fn sum(mut self, factors: &[Lanes<N>], orders: OrdersMade) -> Option<DeviceField> {
        let groups = self.bands.len();
        let count = self.resolution.first.count();
        let values = (self.grid.altitudes.len() * self.grid.suns.len() * count + self.grid.suns.len()) * groups;
        let of_order = |factors: &Lanes<N>| factors.0.into_iter().take(4 * groups);
        let mut uniform = self.uniform;
        uniform.tables.factors = self.lists.add(factors.iter().flat_map(of_order));
        let uniform = FieldUniform {
            invocations: values as u32,
            orders: factors.len() as u32,
            kept: OrdersAt {
                of: self.orders[0],
                last: self.orders.get(1).copied().unwrap_or_default(),
                means: 0,
                sum: self.sum,
            },
            ..uniform
        };
        let memory = self.device.reserve(NUMBERS * values)?;
        let keep = Keeping { values: self.sum as usize..self.sum as usize + values, to: &memory };
        let step = Step { kernel: FieldKernel::FieldSum, uniform };
        self.device.run(&self.work(&self.lists.0), &[step], Some(keep), None)?;
        Some(DeviceField { memory, grid: self.grid, bytes: VALUE * values, orders })
    }
}

/// The lists of altitudes, suns and aerosol.
fn lists_of_grid(lists: &mut Lists, setting: &Setting, grid: &Grid) -> Tables {
    Tables {
        altitudes: lists.add(grid.places.values.iter().copied()),
        suns: lists.add(grid.sun_angles.values.iter().copied()),
        sun_angles: lists.add(grid.suns.iter().flat_map(|sun| [sun.sin() as f32, sun.cos() as f32])),
        aerosol: lists.add(setting.aerosol.iter().copied()),
        ..Tables::default()
    }
}

/// A ray as the lists have it.
fn of_ray(altitude: f64, mu: f64, weight: f64) -> [f32; 4] {
    [altitude as f32, mu as f32, (1.0 - mu * mu).max(0.0).sqrt() as f32, weight as f32]
}

/// Room for what rays cross, and for the sources of so many azimuthal numbers: `counts` of rays, their nodes, suns and groups.
fn along_rays(
    functions: &mut Room,
    values: &mut Room,
    known: Moments,
    counts: [usize; 4],
    azimuthal: usize,
) -> ValuesAt {
    let [rays, nodes, suns, groups] = counts;
    ValuesAt {
        node_functions: functions.take(nodes * known.count()),
        nodes: values.take(4 * nodes),
        scatterers: values.take(2 * nodes * groups),
        origins: values.take(2 * rays),
        grounds: values.take(rays * groups),
        sources: values.take(nodes * suns * (azimuthal + 2) * groups),
        ..ValuesAt::default()
    }
}

/// What the kernels of a light field share, whatever their rays.
fn uniform_of(setting: &Setting, resolution: &Resolution, grid: &Grid, groups: usize) -> FieldUniform {
    FieldUniform {
        first: both(resolution.first),
        next: both(resolution.next),
        later: both(resolution.later),
        groups: groups as u32,
        altitudes: grid.altitudes.len() as u32,
        suns: grid.suns.len() as u32,
        logarithmic: u32::from(resolution.logarithmic),
        thin_air: resolution.thin_air,
        air: setting.air,
        ..empty(setting.atmosphere, &setting.placed_for)
    }
}

/// A uniform of nothing.
fn empty(atmosphere: &Atmosphere, placed_for: &Bands) -> FieldUniform {
    let nothing: FieldUniform = bytemuck::Zeroable::zeroed();
    FieldUniform { atmosphere: *atmosphere, placed_for: *placed_for, ..nothing }
}

/// Multiply scattered light along the rays of rows in a light field on a device: for each group of bands, row and ray.
pub fn light_of_rows(
    device: &dyn PlanDevice,
    field: &DeviceField,
    setting: &Setting,
    bands: &[Bands],
    resolution: &Resolution,
    rows: &[Row],
) -> Option<Vec<Vec<Vec<Light>>>> {
    let mut lists = Lists::default();
    let mut tables = lists_of_grid(&mut lists, setting, &field.grid);
    let columns = rows.iter().map(|row| row.cosines.len()).max()?;
    tables.rays = lists.add(rows.iter().flat_map(|row| of_ray(setting.altitude, row.mu, 0.0)));
    let of_row = |row: &Row| {
        // Shorter rows repeat their last ray.
        let cosine = |column: usize| row.cosines[column.min(row.cosines.len() - 1)];
        let sight = |column| sight(setting, row.mu, cosine(column));
        (0..columns).map(sight).collect::<Vec<[f32; 2]>>()
    };
    tables.sights = lists.add(rows.iter().flat_map(of_row).flatten());
    let (groups, rays, suns) = (bands.len(), rows.len(), field.grid.suns.len());
    let nodes = rays * 2 * resolution.view_samples as usize;
    let first = resolution.first;
    let (mut functions, mut values) = (Room::default(), Room::default());
    let light = rays * columns * groups;
    let at = ValuesAt {
        light: values.take(2 * light),
        ..along_rays(&mut functions, &mut values, first, [rays, nodes, suns, groups], first.azimuthal)
    };
    let uniform = FieldUniform {
        at_nodes: both(first),
        last: both(first),
        taken: both(first),
        rays: rays as u32,
        samples: resolution.view_samples,
        sights: columns as u32,
        tables,
        values: at,
        ..uniform_of(setting, resolution, &field.grid, groups)
    };
    let step = |kernel, invocations: usize| Step {
        kernel,
        uniform: FieldUniform { invocations: invocations as u32, ..uniform },
    };
    let steps = [
        step(FieldKernel::FieldNodes, nodes),
        step(FieldKernel::FieldSources, nodes * suns * groups),
        step(FieldKernel::FieldGather, light),
    ];
    let quadrature = gauss_legendre(resolution.view_samples);
    let (functions, values) = (device.reserve(functions.0)?, device.reserve(NUMBERS * values.0)?);
    let work = Work {
        variant: setting.variant,
        bands,
        quadratures: [&quadrature, &quadrature],
        tables: &lists.0,
        memory: [&functions, &values, &field.memory],
    };
    let from = at.light as usize;
    let read = device.run(&work, &steps, None, Some(Reading::Values(from..from + 2 * light)))?;
    let of_ray = |group: usize, row: usize, column: usize| {
        let at = 2 * ((row * columns + column) * groups + group);
        Light { scattered: read[at], diffuse_irradiance: read[at + 1] }
    };
    let of_row = |group, row: usize| (0..rows[row].cosines.len()).map(|column| of_ray(group, row, column)).collect();
    Some((0..groups).map(|group| (0..rows.len()).map(|row| of_row(group, row)).collect()).collect())
}

/// Light scattered once along rays, from an altitude (km) in some directions under a sun: for each ray and group of bands that of air and of aerosol, before
/// their phase functions.
pub fn scattered_once(
    device: &dyn PlanDevice,
    atmosphere: &Atmosphere,
    (bands, placed_for): (&[Bands], &Bands),
    quadrature: &[Vec2],
    (altitude, views, sun): (f32, &[Vec3], Vec3),
    variant: u32,
) -> Option<Vec<[Vec4; 2]>> {
    let mut lists = Lists::default();
    let of_ray = |view: &Vec3| -> [f32; OF_LISTED_RAY] { [altitude, view.x, view.y, view.z, sun.x, sun.y, sun.z] };
    let sights = lists.add(views.iter().flat_map(of_ray));
    let count = views.len() * bands.len();
    let mut uniform =
        FieldUniform { invocations: count as u32, groups: bands.len() as u32, ..empty(atmosphere, placed_for) };
    uniform.tables.sights = sights;
    let (values, none) = (device.reserve(NUMBERS * OF_FIRST * count)?, device.reserve(NUMBERS)?);
    let work = Work {
        variant,
        bands,
        quadratures: [quadrature, quadrature],
        tables: &lists.0,
        memory: [&none, &values, &none],
    };
    let steps = [Step { kernel: FieldKernel::FieldFirst, uniform }];
    let read = device.run(&work, &steps, None, Some(Reading::Values(0..OF_FIRST * count)))?;
    Some(read.chunks_exact(OF_FIRST).map(|of| [of[0], of[1]]).collect())
}
