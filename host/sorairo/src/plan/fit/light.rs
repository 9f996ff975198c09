//! Light along rays at many wavelengths, by its constituents.

use rayon::prelude::*;
use sorairo_shared::glam::{DVec3, Vec2, Vec3, Vec4};
use sorairo_shared::light_field::first_order::single_scattering_of_many;
use sorairo_shared::medium::bands::Bands;
use sorairo_shared::path::ground::{GroundView, ground_light, ground_seen};
use sorairo_shared::sky::ByConstituent;
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant;

use crate::plan::fit::rays::Grid;
use crate::plan::integral::RayIntegral;
use crate::plan::light_field;
use crate::plan::light_field::{Light, Resolution, Row, TOGETHER, Wavelengths, light_of_rows};
use crate::plan::on_device::PlanDevice;

/// Light along rays at the bands of an integral, by its constituents, in a light field as fine as that of its spectra;
/// of what a sky does not have there is none.
pub fn light_of(integral: &RayIntegral, grids: &[Grid]) -> ByConstituent<Vec<Vec<f64>>> {
    let views: Vec<Vec3> = grids.iter().flat_map(|grid| grid.views(integral)).collect();
    let rows: Vec<Row> = grids.iter().flat_map(Grid::rows).collect();
    let at = (&integral.bands[..], integral.wavelengths.len());
    let (air, aerosol) = scattered_once(integral, &integral.quadrature, &views, at);
    let (multiple, ground) = rest(integral, at, &rows, &integral.spectral_resolution());
    ByConstituent { air, aerosol, multiple, ground }
}

/// Spectra along rays, of air and of aerosol.
pub type AirAndAerosol = (Vec<Vec<f64>>, Vec<Vec<f64>>);

/// Light of the first order along rays, by air and by aerosol before their phase functions, at the first so many of
/// groups of bands (transfer times sr), by a rule of quadrature on each piece.
pub fn scattered_once(
    integral: &RayIntegral,
    quadrature: &[Vec2],
    views: &[Vec3],
    (groups, count): (&[Bands], usize),
) -> AirAndAerosol {
    if let Some(found) = scattered_once_on_device(integral, quadrature, views, groups, count) {
        return found;
    }
    scattered_once_here(integral, quadrature, views, (groups, count))
}

/// The same without a device.
pub(crate) fn scattered_once_here(
    integral: &RayIntegral,
    quadrature: &[Vec2],
    views: &[Vec3],
    (groups, count): (&[Bands], usize),
) -> AirAndAerosol {
    let chunks: Vec<Wavelengths<TOGETHER>> = groups.chunks(TOGETHER / 4).map(Wavelengths::new).collect();
    let placed_for = integral.placed_for();
    let along = |&view: &Vec3| {
        let (mut air, mut aerosol) = (Vec::new(), Vec::new());
        for chunk in &chunks {
            let light = single_scattering_of_many(
                integral.medium(),
                &chunk.air,
                &placed_for,
                quadrature,
                integral.ray(view),
                integral.variant,
            );
            air.extend(light.air.0.map(f64::from));
            aerosol.extend(light.aerosol.0.map(f64::from));
        }
        air.truncate(count);
        aerosol.truncate(count);
        (air, aerosol)
    };
    views.par_iter().map(along).unzip()
}

/// The same on the device of the integral, if there is one that can.
fn scattered_once_on_device(
    integral: &RayIntegral,
    quadrature: &[Vec2],
    views: &[Vec3],
    groups: &[Bands],
    wavelengths: usize,
) -> Option<AirAndAerosol> {
    let Uniform { altitude, sun, .. } = &integral.uniform;
    let rays = (*altitude, views, sun.truncate());
    let bands = (groups, &integral.placed_for());
    let ask = |device: &dyn PlanDevice| {
        light_field::scattered_once(device, integral.medium(), bands, quadrature, rays, integral.variant)
    };
    let light = integral.light_fields.ask_device(ask)?;
    let spectrum = |ray: &[[Vec4; 2]], of: usize| {
        let values = ray.iter().flat_map(|both| both[of].to_array()).map(f64::from);
        values.take(wavelengths).collect()
    };
    let of_ray = |ray: &[[Vec4; 2]]| (spectrum(ray, 0), spectrum(ray, 1));
    Some(light.chunks_exact(groups.len()).map(of_ray).unzip())
}

/// Light that was scattered more than once, and light from the ground, at the first so many of groups of bands along
/// the rays of rows in a light field of a resolution; 0 where a ray meets no ground.
pub fn rest(
    integral: &RayIntegral,
    (groups, count): (&[Bands], usize),
    rows: &[Row],
    resolution: &Resolution,
) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let has = |bit: u32| integral.variant & bit != 0;
    let (mut multiple, mut ground) = (Vec::new(), Vec::new());
    if !has(variant::REST) {
        return (multiple, ground);
    }
    let setting = integral.setting();
    let of_rows = || light_of_rows(&integral.light_fields, &setting, groups, resolution, integral.orders, rows).0;
    let diffuse = has(variant::MULTIPLE).then(of_rows);
    for (r, row) in rows.iter().enumerate() {
        for (c, &cosine) in row.cosines.iter().enumerate() {
            let along = |group: usize| diffuse.as_ref().map_or(Light::default(), |light| light[group][r][c]);
            let spectrum = |four: &dyn Fn(usize) -> Vec4| {
                let values = (0..groups.len()).flat_map(|group| four(group).to_array().map(f64::from));
                values.take(count).collect::<Vec<_>>()
            };
            if has(variant::MULTIPLE) {
                multiple.push(spectrum(&|group| along(group).scattered));
            }
            let seen = ground_of(integral, row.mu, cosine);
            if has(variant::GROUND) {
                let of_ground = |group: usize| ground_at(integral, &groups[group], seen, along(group));
                ground.push(spectrum(&|group| if seen.is_seen { of_ground(group) } else { Vec4::ZERO }));
            }
        }
    }
    (multiple, ground)
}

/// Light of the ground at a group of bands, as if its albedo were 1.
fn ground_at(integral: &RayIntegral, group: &Bands, seen: GroundView, light: Light) -> Vec4 {
    ground_light(integral.medium(), group, seen, light.diffuse_irradiance, integral.variant)
}

/// The ground that a ray meets, by the cosines of its zenith angle and of its azimuth from the sun.
fn ground_of(integral: &RayIntegral, mu: f64, cosine: f64) -> GroundView {
    let (to_sun, level) = (integral.uniform.bearing.as_dvec4().truncate(), (1.0 - mu * mu).max(0.0).sqrt());
    let across = DVec3::new(-to_sun.y, to_sun.x, 0.0);
    let view = (to_sun * cosine + across * (1.0 - cosine * cosine).max(0.0).sqrt()) * level + DVec3::Z * mu;
    ground_seen(integral.medium(), integral.ray(view.as_vec3()), integral.variant)
}
