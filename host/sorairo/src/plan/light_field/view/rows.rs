//! The lookup of multiply scattered light for an observer; see [`sorairo_shared::light_field::multiple_lookup`].

use std::f64::consts::FRAC_PI_2;

use rayon::prelude::*;
use sorairo_shared::glam::Vec4;
use sorairo_shared::interpolation::azimuth::cosine_at_place;
use sorairo_shared::light_field::gather::gather;
use sorairo_shared::light_field::multiple_lookup::MultipleLookup;
use sorairo_shared::light_field::rays::Sight;
use sorairo_shared::math::acos;
use sorairo_shared::medium::bands::Bands;
use sorairo_shared::value::{Lanes, Value};

use crate::plan::light_field::cache::LightFields;
use crate::plan::light_field::device::rays;
use crate::plan::light_field::orders::field::LightField;
use crate::plan::light_field::orders::irradiance::Irradiance;
use crate::plan::light_field::orders::made::OrdersMade;
use crate::plan::light_field::orders::rays::OwnedRay;
use crate::plan::light_field::orders::room::Room;
use crate::plan::light_field::orders::sampling::Sampling;
use crate::plan::light_field::orders::values::Tiles;
use crate::plan::light_field::resolution::Resolution;
use crate::plan::light_field::setting::Setting;
use crate::plan::light_field::sights::{Light, Row, sight};
use crate::plan::light_field::wavelengths::Wavelengths;
use crate::plan::on_device::PlanDevice;
use crate::plan::rays::directions::horizon;
use crate::scene::Orders;

/// Wavelengths that are computed together, at most: what a path costs is shared by as many.
pub const TOGETHER: usize = 48;

/// Rays this close to the horizon (radians) stand for the horizon itself, seen from above the ground: one side is sky,
/// the other ground.
const HORIZON_MARGIN: f64 = 1e-5;

/// Multiply scattered light, as an observer sees it.
#[derive(Clone, Debug)]
pub struct MultipleLight {
    /// Where the entries are.
    pub lookup: MultipleLookup,
    /// The entries.
    pub values: Vec<Vec4>,
    /// How the light field was made, for each group of bands that were computed together.
    pub orders: Vec<OrdersMade>,
}

/// [`Light`] at some wavelengths.
#[derive(Clone, Copy, Debug)]
pub struct LightOfMany<const N: usize> {
    scattered: Lanes<N>,
    polarised: [Lanes<N>; 2],
    diffuse_irradiance: Lanes<N>,
}

impl<const N: usize> LightOfMany<N> {
    /// At a group of four.
    pub fn of_group(&self, group: usize) -> Light {
        let four = |lanes: &Lanes<N>| Vec4::from_slice(&lanes.0[4 * group..]);
        let [q, u] = self.polarised.each_ref().map(four);
        Light { scattered: four(&self.scattered), q, u, diffuse_irradiance: four(&self.diffuse_irradiance) }
    }
}

impl MultipleLight {
    /// For groups of bands: of light fields of some resolutions, so much of each. How the last of them was made is
    /// told.
    pub fn new(
        fields: &LightFields,
        setting: &Setting,
        bands: &[Bands],
        resolutions: &[(f32, Resolution)],
        orders: Orders,
    ) -> Self {
        let degree = resolutions.iter().map(|(_, resolution)| resolution.first.degree).max().unwrap_or_default();
        let lookup = lookup(setting, degree, bands.len());
        let rows = rows_of(setting, &lookup);
        let mut values = vec![Vec4::ZERO; lookup.len() as usize];
        let mut made = Vec::new();
        for (share, resolution) in resolutions {
            let light;
            (light, made) = light_of_rows(fields, setting, bands, resolution, orders, &rows);
            let scattered = light.iter().flatten().flatten().map(|light| light.scattered);
            let below = light.iter().flat_map(|group| &group[lookup.above as usize..]).flatten();
            let of_all = scattered.chain(below.map(|light| light.diffuse_irradiance));
            values.iter_mut().zip(of_all).for_each(|(value, light)| *value += light * *share);
        }
        Self { lookup, values, orders: made }
    }
}

/// How close to the vertical and to the sun's vertical plane (radians) polarised rays come: at both `U` is a rounding,
/// and what is kept of it is smooth.
const ASIDE: f64 = 0.02;

/// `Q` and `U` of multiply scattered light, as an observer sees them.
#[derive(Clone, Debug)]
pub struct PolarisedLight {
    /// Where the entries are, of two groups: `Q`, and `U` over the sine of the azimuth from the sun.
    pub lookup: MultipleLookup,
    /// Radiance and both at each entry, for each group of bands (sr⁻¹).
    pub groups: Vec<Vec<[Vec4; 3]>>,
}

impl PolarisedLight {
    /// For groups of bands, likewise.
    pub fn new(
        fields: &LightFields,
        setting: &Setting,
        bands: &[Bands],
        resolutions: &[(f32, Resolution)],
        orders: Orders,
    ) -> Self {
        let degree = resolutions.iter().map(|(_, resolution)| resolution.first.degree).max().unwrap_or_default();
        let lookup = lookup(setting, degree, 2);
        let (most, least) = (ASIDE.cos(), -ASIDE.cos());
        let aside = |row: Row| Row {
            mu: row.mu.clamp(least, most),
            cosines: row.cosines.iter().map(|cosine| cosine.clamp(least, most)).collect(),
            polarised: true,
            ..row
        };
        let rows: Vec<Row> = rows_of(setting, &lookup).into_iter().map(aside).collect();
        let sines: Vec<f32> = rows[0].cosines.iter().map(|cosine| (1.0 - cosine * cosine).sqrt() as f32).collect();
        let entries = rows.len() * sines.len();
        let mut groups = vec![vec![[Vec4::ZERO; 3]; entries]; bands.len()];
        for (share, resolution) in resolutions {
            let (light, _) = light_of_rows(fields, setting, bands, resolution, orders, &rows);
            for (sums, rows) in groups.iter_mut().zip(&light) {
                let of_rows = rows.iter().flat_map(|row| row.iter().zip(&sines));
                for ([i, q, u], (light, &sine)) in sums.iter_mut().zip(of_rows) {
                    *i += light.scattered * *share;
                    *q += light.q * *share;
                    *u += light.u * (*share / sine);
                }
            }
        }
        Self { lookup, groups }
    }
}

/// Multiply scattered light along the rays of rows: for each group of bands, row and ray. Light fields are taken from
/// those that are kept.
pub fn light_of_rows(
    fields: &LightFields,
    setting: &Setting,
    bands: &[Bands],
    resolution: &Resolution,
    orders: Orders,
    rows: &[Row],
) -> (Vec<Vec<Vec<Light>>>, Vec<OrdersMade>) {
    let (mut light, mut made) = (Vec::new(), Vec::new());
    for bands in bands.chunks(TOGETHER / 4) {
        let (of_chunk, made_of_chunk) = match bands.len() {
            1 => of_groups::<4>(fields, setting, bands, resolution, orders, rows),
            2..=4 => of_groups::<16>(fields, setting, bands, resolution, orders, rows),
            _ => of_groups::<TOGETHER>(fields, setting, bands, resolution, orders, rows),
        };
        light.extend(of_chunk);
        made.push(made_of_chunk);
    }
    (light, made)
}

/// Light along the rays of rows at up to a quarter of `N` groups of bands.
fn of_groups<const N: usize>(
    fields: &LightFields,
    setting: &Setting,
    bands: &[Bands],
    resolution: &Resolution,
    orders: Orders,
    rows: &[Row],
) -> (Vec<Vec<Vec<Light>>>, OrdersMade) {
    let bands = &setting.without_peak(bands);
    // Samples that follow the optical depth are no list that a device takes, nor are rays that end.
    let device_has_it = !resolution.thick && rows.iter().all(|row| row.length.is_infinite());
    let ask = |device: &dyn PlanDevice| {
        let field = fields.get_on_device::<N>(device, setting, bands, resolution, orders)?;
        let light = rays::light_of_rows(device, &field, setting, bands, resolution, rows)?;
        Ok((light, field.orders.clone()))
    };
    if device_has_it && let Some(found) = fields.ask_device(ask) {
        return found;
    }
    let wavelengths = &Wavelengths::<N>::new(bands);
    let field = &*fields.get(setting, wavelengths, resolution, orders);
    let view = View {
        setting,
        wavelengths,
        resolution,
        field,
        tiles: field.tiles(setting),
        sampling: Sampling::new(resolution, resolution.view_samples),
        irradiance: field.diffuse_irradiance(resolution.logarithmic),
    };
    let light: Vec<Vec<LightOfMany<N>>> = rows.par_iter().map(|row| view.light(row)).collect();
    let of_group = |group| light.iter().map(|row| row.iter().map(|light| light.of_group(group)).collect()).collect();
    ((0..bands.len()).map(of_group).collect(), field.orders.clone())
}

/// Rows and columns for an observer: more from farther away, from where more of the planet is seen under its own sun,
/// and more columns for the narrower peak of a higher degree, so that they leave 0.1 % of a direction's light or less.
fn lookup(setting: &Setting, degree: usize, groups: usize) -> MultipleLookup {
    /// Degrees of a sun between two columns, and between two rows at the nadir, that a cubic bridges.
    const SUN_STEP: f64 = 1.8;
    const FEWEST_AZIMUTHS: u32 = 18;
    let ground = f64::from(setting.medium.atmosphere.ground_radius);
    let depth = f64::from(setting.medium.atmosphere.depth);
    let inside = setting.altitude <= depth;
    let seen = -horizon(ground, setting.altitude).to_degrees();
    let at_entry = horizon(ground, setting.altitude.min(depth));
    let suns = (2.0 * seen / SUN_STEP).ceil() as u32;
    MultipleLookup {
        above: 32,
        // From the ground itself nothing lies before what is seen of it.
        below: if setting.altitude > 0.0 { 32 + suns / 2 } else { 4 },
        azimuths: FEWEST_AZIMUTHS.max(degree as u32 + 8) + suns,
        groups: groups as u32,
        horizon: at_entry as f32,
        span_above: (if inside { FRAC_PI_2 } else { 0.0 } - at_entry) as f32,
        span_below: (FRAC_PI_2 + at_entry) as f32,
        padding: 0,
    }
}

/// The rows of a lookup, those above the horizon first.
fn rows_of(setting: &Setting, lookup: &MultipleLookup) -> Vec<Row> {
    let column = |column: u32| f64::from(cosine_at_place(column as f32 / (lookup.azimuths - 1) as f32));
    let cosines: Vec<f64> = (0..lookup.azimuths).map(column).collect();
    let row = |above: bool, row: u32, rows: u32| {
        let x = f64::from(row) / f64::from(rows - 1);
        let span = f64::from(if above { lookup.span_above } else { lookup.span_below });
        let margin = if setting.altitude > 0.0 || !above { HORIZON_MARGIN } else { 0.0 };
        let from_horizon = (x * x * span).max(margin);
        let elevation = f64::from(lookup.horizon) + if above { from_horizon } else { -from_horizon };
        Row::whole(towards(setting, elevation.clamp(-FRAC_PI_2, FRAC_PI_2)), cosines.clone())
    };
    let above = (0..lookup.above).map(|i| row(true, i, lookup.above));
    above.chain((0..lookup.below).map(|i| row(false, i, lookup.below))).collect()
}

/// Cosine of the zenith angle at the observer of a ray that has an elevation (radians) where it enters the atmosphere,
/// or begins.
fn towards(setting: &Setting, elevation: f64) -> f64 {
    let (ground, depth) =
        (f64::from(setting.medium.atmosphere.ground_radius), f64::from(setting.medium.atmosphere.depth));
    if setting.altitude <= depth {
        return elevation.sin();
    }
    let sine = (ground + depth) * elevation.cos() / (ground + setting.altitude);
    -(1.0 - sine * sine).sqrt()
}

/// An observer before a light field.
pub struct View<'a, const N: usize> {
    /// What it depends on.
    pub setting: &'a Setting<'a>,
    /// At which wavelengths.
    pub wavelengths: &'a Wavelengths<N>,
    /// How finely.
    pub resolution: &'a Resolution,
    /// The light field.
    pub field: &'a LightField<N>,
    /// Its moments, as they are gathered.
    pub tiles: Tiles,
    /// How the rays are sampled.
    pub sampling: Sampling,
    /// The diffuse irradiance of the ground.
    pub irradiance: Irradiance<N>,
}

impl<const N: usize> View<'_, N> {
    /// Light along the rays of a row.
    pub fn light(&self, row: &Row) -> Vec<LightOfMany<N>> {
        let (setting, field) = (self.setting, self.field);
        let Row { mu, cosines, length, polarised } = row;
        let altitude = setting.altitude;
        let ray = OwnedRay::new(
            setting,
            self.wavelengths,
            &field.grid,
            &self.sampling,
            self.resolution.first,
            altitude,
            (*mu, *length),
        );
        let near = field.grid.suns.len() / 2;
        let sight = |&cosine: &f64| {
            let [mu_s, nu] = sight(setting, *mu, cosine);
            Sight { mu_s, nu, near }
        };
        let sights: Vec<Sight> = cosines.iter().map(sight).collect();
        let mut light = vec![Lanes::ZERO; cosines.len()];
        let table = self.tiles.table(&field.grid, self.resolution.logarithmic);
        let mut stokes =
            vec![[Lanes::ZERO; 2]; if *polarised && table.couplings.is_some() { cosines.len() } else { 0 }];
        let mut room = Room::new::<N>(&table, sights.len());
        let places = ray.suns_along(&field.grid, &sights);
        gather(table, ray.view(), &places, &mut room.scratch(), &mut light, &mut stokes);
        stokes.resize(cosines.len(), [Lanes::ZERO; 2]);
        let light_of = |((scattered, polarised), sight): ((Lanes<N>, [Lanes<N>; 2]), &Sight)| {
            let diffuse_irradiance = ray.ground.map_or(Lanes::ZERO, |ground| {
                let mu_s = ray.mu_s_on_ground(setting, ground.distance, sight.mu_s, sight.nu);
                self.irradiance.at(&field.grid, acos(mu_s))
            });
            LightOfMany { scattered, polarised, diffuse_irradiance }
        };
        light.into_iter().zip(stokes).zip(&sights).map(light_of).collect()
    }
}
