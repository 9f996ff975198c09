//! What rays of an observer see, found on a device: light of a light field, and light scattered once.

use sorairo_shared::glam::{Vec2, Vec3, Vec4};
use sorairo_shared::light_field::device::first::OF_LISTED_RAY;
use sorairo_shared::light_field::device::uniform::{
    FieldUniform, OF_FIRST, OF_OBSERVER, OF_STOKES, Values as ValuesAt,
};
use sorairo_shared::medium::atmosphere::Medium;
use sorairo_shared::medium::bands::Bands;

use crate::error::Result;
use crate::plan::light_field::device::field::DeviceField;
use crate::plan::light_field::device::lists::{
    Lists, NUMBERS, Room, along_rays, both, empty, of_ray, polarised_moments, uniform_of,
};
use crate::plan::light_field::resolution::Resolution;
use crate::plan::light_field::setting::Setting;
use crate::plan::light_field::sights::{Light, Row, sight};
use crate::plan::on_device::{Dispatch, FieldKernel, PlanDevice, PlanPass, ReadBack};
use crate::plan::rays::quadrature::gauss_legendre;

/// Multiply scattered light along the rays of rows in a light field on a device: for each group of bands, row and ray.
pub fn light_of_rows(
    device: &dyn PlanDevice,
    field: &DeviceField,
    setting: &Setting,
    bands: &[Bands],
    resolution: &Resolution,
    rows: &[Row],
) -> Result<Vec<Vec<Vec<Light>>>> {
    let mut lists = Lists::default();
    let mut tables = lists.add_grid(setting, &field.grid);
    let columns = rows.iter().map(|row| row.cosines.len()).max().unwrap_or_default();
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
    let gathered = if rows.iter().any(|row| row.polarised) { polarised_moments(setting) } else { 0 };
    let of_light = OF_OBSERVER + if gathered > 0 { OF_STOKES } else { 0 };
    let coefficients = first.azimuthal + 1 + gathered;
    let at = ValuesAt {
        light: values.take(of_light * light),
        ..along_rays(&mut functions, &mut values, first, [rays, nodes, suns, groups], coefficients)
    };
    let uniform = FieldUniform {
        at_nodes: both(first),
        last: both(first),
        taken: both(first),
        rays: rays as u32,
        samples: resolution.view_samples,
        sights: columns as u32,
        gathered: gathered as u32,
        tables,
        values: at,
        ..uniform_of(setting, resolution, &field.grid, groups)
    };
    let step = |kernel, invocations: usize| Dispatch {
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
    let from = at.light as usize;
    let read = device.run(&PlanPass {
        steps: &steps,
        variant: setting.variant,
        bands,
        quadratures: [&quadrature, &quadrature],
        tables: &lists.0,
        columns: setting.medium.tables,
        memory: [&functions, &values, &field.memory],
        keep: None,
        read: Some(ReadBack::Values(from..from + of_light * light)),
    })?;
    let of_ray = |group: usize, row: usize, column: usize| {
        let of_sight = &read[of_light * ((row * columns + column) * groups + group)..][..of_light];
        let (q, u) = if let [_, _, q, u] = *of_sight { (q, u) } else { Default::default() };
        Light { scattered: of_sight[0], q, u, diffuse_irradiance: of_sight[1] }
    };
    let of_row = |group, row: usize| (0..rows[row].cosines.len()).map(|column| of_ray(group, row, column)).collect();
    Ok((0..groups).map(|group| (0..rows.len()).map(|row| of_row(group, row)).collect()).collect())
}

/// Light scattered once along rays, from an altitude (km) in some directions under a sun: for each ray and group of
/// bands that of air and of aerosol, before their phase functions.
pub fn scattered_once(
    device: &dyn PlanDevice,
    medium: Medium<'_>,
    (bands, placed_for): (&[Bands], &Bands),
    quadrature: &[Vec2],
    (altitude, views, sun): (f32, &[Vec3], Vec3),
    variant: u32,
) -> Result<Vec<[Vec4; 2]>> {
    let mut lists = Lists::default();
    let of_ray = |view: &Vec3| -> [f32; OF_LISTED_RAY] { [altitude, view.x, view.y, view.z, sun.x, sun.y, sun.z] };
    let sights = lists.add(views.iter().flat_map(of_ray));
    let count = views.len() * bands.len();
    let mut uniform =
        FieldUniform { invocations: count as u32, groups: bands.len() as u32, ..empty(medium.atmosphere, placed_for) };
    uniform.tables.sights = sights;
    let (values, none) = (device.reserve(NUMBERS * OF_FIRST * count)?, device.reserve(NUMBERS)?);
    let read = device.run(&PlanPass {
        steps: &[Dispatch { kernel: FieldKernel::FieldFirst, uniform }],
        variant,
        bands,
        quadratures: [quadrature, quadrature],
        tables: &lists.0,
        columns: medium.tables,
        memory: [&none, &values, &none],
        keep: None,
        read: Some(ReadBack::Values(0..OF_FIRST * count)),
    })?;
    Ok(read.chunks_exact(OF_FIRST).map(|of| [of[0], of[1]]).collect())
}
