//! In-scattered light up to each of some distances, at the bands of an integral.

use std::ops::Range;

use rayon::prelude::*;
use sorairo_shared::glam::{Vec3, Vec4};
use sorairo_shared::light_field::gather::gather;
use sorairo_shared::light_field::rays::Sight;
use sorairo_shared::medium::atmosphere::ColumnDensities;
use sorairo_shared::medium::columns::sunlight_at;
use sorairo_shared::sky::ByConstituent;
use sorairo_shared::value::{Lanes, Value};
use sorairo_shared::variant;

use crate::plan::aerial::steps::{Steps, Walk};
use crate::plan::integral::RayIntegral;
use crate::plan::light_field::{OwnedRay, Resolution, Room, TOGETHER, Wavelengths};

/// In-scattered light and column densities up to a distance along a ray.
#[derive(Clone, Debug)]
pub struct LightBefore {
    /// Light of all orders scattered towards the observer, by constituent, at each group of bands (transfer; for air
    /// and aerosol times sr). It excludes the ground.
    pub light: Vec<ByConstituent<Vec4>>,
    /// Column densities up to the distance.
    pub columns: ColumnDensities,
}

/// Multiply scattered light from each slice of a ray, at each of some groups of bands: by slices, then by groups.
type Gather<'a> = Box<dyn Fn(&Steps, (f64, f64), Sight) -> Vec<Vec<Vec4>> + Send + Sync + 'a>;

/// The air in front of an observer, for ray marching.
pub struct SlicedAir<'a> {
    integral: &'a RayIntegral,
    walk: Walk<'a>,
    /// The light fields of each chunk of groups of bands that are computed together.
    gathers: Vec<(Range<usize>, Vec<Gather<'a>>)>,
}

impl<'a> SlicedAir<'a> {
    /// That of an integral, with the light field of its multiple scattering.
    pub fn new(integral: &'a RayIntegral) -> Self {
        let coefficients = integral.placed_for().coefficients();
        let walk = Walk { medium: integral.medium(), variant: integral.variant | variant::DESCENT, coefficients };
        let has_orders = integral.variant & variant::MULTIPLE != 0;
        let chunks: Vec<Range<usize>> = if has_orders { chunks(integral.bands.len()) } else { Vec::new() };
        let resolutions = Resolution::mixed(&integral.setting(), integral.aerosol_depth());
        let of_chunk = |groups: Range<usize>| {
            let of = |(share, resolution): &(f32, Resolution)| gather_of(integral, groups.clone(), *share, resolution);
            (groups.clone(), resolutions.par_iter().map(of).collect())
        };
        Self { integral, walk, gathers: chunks.into_iter().map(of_chunk).collect() }
    }

    /// In-scattered light and column densities up to each of some increasing distances (km, from 0) in a direction.
    /// Below the ground the air continues.
    pub fn along(&self, view: Vec3, distances: &[f64]) -> Vec<LightBefore> {
        let ray = self.integral.ray(view);
        let steps = self.walk.steps(ray, distances);
        let mut light = vec![vec![ByConstituent::default(); self.integral.bands.len()]; distances.len()];
        for (slice, light) in steps.slices.iter().zip(&mut light) {
            self.add_scattered_once(&steps, slice.clone(), light);
        }
        let sight = Sight { mu_s: ray.mu_s, nu: ray.nu, near: 0 };
        let from = (f64::from(ray.altitude), f64::from(ray.mu));
        for (groups, gathers) in &self.gathers {
            for found in gathers.iter().map(|gather| gather(&steps, from, sight)) {
                for (light, found) in light.iter_mut().zip(found) {
                    light[groups.clone()].iter_mut().zip(found).for_each(|(light, found)| light.multiple += found);
                }
            }
        }
        let mut before = vec![ByConstituent::default(); self.integral.bands.len()];
        let summed = light.into_iter().map(|slice| {
            before.iter_mut().zip(slice).for_each(|(before, slice)| add(before, slice));
            before.clone()
        });
        summed.zip(steps.columns.iter()).map(|(light, &columns)| LightBefore { light, columns }).collect()
    }

    fn add_scattered_once(&self, steps: &Steps, slice: Range<usize>, light: &mut [ByConstituent<Vec4>]) {
        let Walk { medium, variant, .. } = self.walk;
        for (sample, &(mu_s, is_lit)) in steps.samples[slice.clone()].iter().zip(&steps.suns[slice]) {
            if !is_lit {
                continue;
            }
            let sunlight = sunlight_at(medium, sample.altitude, sample.density, mu_s, variant);
            let along = sample.to_observer + sunlight.along;
            for (bands, light) in self.integral.bands.iter().zip(light.iter_mut()) {
                let coefficients = bands.coefficients();
                let seen = coefficients.transmittance(along).scaled(sample.weight * sunlight.spread);
                let scattered = coefficients.scattered(&seen, sample.density);
                light.air += scattered.air;
                light.aerosol += scattered.aerosol;
            }
        }
    }
}

fn add(sum: &mut ByConstituent<Vec4>, other: ByConstituent<Vec4>) {
    sum.air += other.air;
    sum.aerosol += other.aerosol;
    sum.multiple += other.multiple;
}

/// So many groups of bands, in chunks that are computed together.
fn chunks(groups: usize) -> Vec<Range<usize>> {
    let most = TOGETHER / 4;
    (0..groups).step_by(most).map(|first| first..(first + most).min(groups)).collect()
}

fn gather_of<'a>(integral: &'a RayIntegral, groups: Range<usize>, share: f32, resolution: &Resolution) -> Gather<'a> {
    match groups.len() {
        1 => gather_of_many::<4>(integral, groups, share, resolution),
        2..=4 => gather_of_many::<16>(integral, groups, share, resolution),
        _ => gather_of_many::<TOGETHER>(integral, groups, share, resolution),
    }
}

fn gather_of_many<'a, const N: usize>(
    integral: &'a RayIntegral,
    groups: Range<usize>,
    share: f32,
    resolution: &Resolution,
) -> Gather<'a> {
    let setting = integral.setting();
    let bands = setting.without_peak(&integral.bands[groups]);
    let wavelengths = Wavelengths::<N>::new(&bands);
    let field = integral.light_fields.get(&setting, &wavelengths, resolution, integral.orders);
    let tiles = field.tiles(&setting);
    let (of, logarithmic) = (resolution.first, resolution.logarithmic);
    Box::new(move |steps, from, sight| {
        let table = tiles.table(&field.grid, logarithmic);
        let ray = OwnedRay::through(&setting, &wavelengths, &field.grid, of, from, &steps.samples);
        let places = ray.suns_along(&field.grid, &[Sight { near: field.grid.suns.len() / 2, ..sight }]);
        let mut room = Room::new::<N>(&table, 1);
        let of_slice = |slice: &Range<usize>| {
            let mut light = [Lanes::<N>::ZERO];
            let part = ray.part(slice.clone());
            gather(table, part, &places[slice.clone()], &mut room.scratch(), &mut light, &mut []);
            (0..bands.len()).map(|group| Vec4::from_slice(&light[0].0[4 * group..]) * share).collect()
        };
        steps.slices.iter().map(of_slice).collect()
    })
}
