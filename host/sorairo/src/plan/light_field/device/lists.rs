//! What lies where in a device's memory for the kernels of a light field.

use sorairo_shared::glam::{UVec2, Vec4};
use sorairo_shared::light_field::device::uniform::{FieldUniform, Tables, Values as ValuesAt};
use sorairo_shared::light_field::moments::Moments;
use sorairo_shared::light_field::polarisation;
use sorairo_shared::medium::atmosphere::Atmosphere;
use sorairo_shared::medium::bands::{Bands, ByScatterer};

use crate::plan::light_field::grid::Grid;
use crate::plan::light_field::resolution::Resolution;
use crate::plan::light_field::setting::Setting;

/// Numbers of a value.
pub const NUMBERS: usize = 4;

/// Moments as a uniform has them.
pub fn both(of: Moments) -> UVec2 {
    UVec2::new(of.degree as u32, of.azimuthal as u32)
}

/// Lists of numbers that a device reads.
#[derive(Default)]
pub struct Lists(pub Vec<f32>);

impl Lists {
    /// Adds a list; where it begins.
    pub fn add(&mut self, list: impl IntoIterator<Item = f32>) -> u32 {
        let first = self.0.len();
        self.0.extend(list);
        first as u32
    }

    /// Adds the lists of altitudes, suns and aerosol.
    pub fn add_grid(&mut self, setting: &Setting, grid: &Grid) -> Tables {
        Tables {
            altitudes: self.add(grid.places.values.iter().copied()),
            suns: self.add(grid.sun_angles.values.iter().copied()),
            sun_angles: self.add(grid.suns.iter().flat_map(|sun| [sun.sin() as f32, sun.cos() as f32])),
            aerosol: self.add(setting.aerosol.iter().copied()),
            ..Tables::default()
        }
    }
}

/// Room that is handed out from its beginning.
#[derive(Default)]
pub struct Room(pub usize);

impl Room {
    /// Takes some of it; where that begins.
    pub fn take(&mut self, numbers: usize) -> u32 {
        self.0 += numbers;
        (self.0 - numbers) as u32
    }
}

/// A ray as the lists have it.
pub fn of_ray(altitude: f64, mu: f64, weight: f64) -> [f32; 4] {
    [altitude as f32, mu as f32, (1.0 - mu * mu).max(0.0).sqrt() as f32, weight as f32]
}

/// Room for what rays cross, and for so many coefficients of their sources: `counts` of rays, their nodes, suns and
/// groups.
pub fn along_rays(
    functions: &mut Room,
    values: &mut Room,
    known: Moments,
    counts: [usize; 4],
    coefficients: usize,
) -> ValuesAt {
    let [rays, nodes, suns, groups] = counts;
    ValuesAt {
        node_functions: functions.take(nodes * known.count()),
        nodes: values.take(4 * nodes),
        scatterers: values.take(2 * nodes * groups),
        origins: values.take(2 * rays),
        grounds: values.take(rays * groups),
        sources: values.take(nodes * suns * (coefficients + 1) * groups),
        ..ValuesAt::default()
    }
}

/// Moments of polarised light of each node.
pub fn polarised_moments(setting: &Setting) -> usize {
    if setting.couplings.is_some() { polarisation::MOMENTS } else { 0 }
}

/// What the kernels of a light field share, whatever their rays.
pub fn uniform_of(setting: &Setting, resolution: &Resolution, grid: &Grid, groups: usize) -> FieldUniform {
    FieldUniform {
        first: both(resolution.first),
        next: both(resolution.next),
        later: both(resolution.later),
        groups: groups as u32,
        altitudes: grid.altitudes.len() as u32,
        suns: grid.suns.len() as u32,
        logarithmic: u32::from(resolution.logarithmic),
        for_air: resolution.for_air,
        thin_air: resolution.thin_air,
        air: setting.air,
        polarised: polarised_moments(setting) as u32,
        couplings: setting.couplings.map_or(Vec4::ZERO, |ByScatterer { air, aerosol }| {
            Vec4::new(air.gamma, air.alpha, aerosol.gamma, aerosol.alpha)
        }),
        ..empty(setting.medium.atmosphere, &setting.placed_for)
    }
}

/// A uniform of nothing.
pub fn empty(atmosphere: &Atmosphere, placed_for: &Bands) -> FieldUniform {
    let nothing: FieldUniform = bytemuck::Zeroable::zeroed();
    FieldUniform { atmosphere: *atmosphere, placed_for: *placed_for, ..nothing }
}
