//! Light along a ray that ends at a distance, at the bands of an integral: what the air up to there lets through, and
//! what it adds.

use sorairo_shared::glam::{DVec2, DVec3, Vec3};
use sorairo_shared::light_field::first_order::single_scattering_until;
use sorairo_shared::medium::atmosphere::ColumnDensities;
use sorairo_shared::path::ground::ground_seen;
use sorairo_shared::path::pieces::column_densities_until;
use sorairo_shared::variant;

use crate::plan::integral::{Constituent, RayIntegral};
use crate::plan::light_field::{Resolution, Row, TOGETHER, Wavelengths, light_of_rows};

/// How many times as many samples of multiply scattered light as a row of the sky's has a ray of its own: with as many
/// the two parts of a ray differ from the whole by up to 1.4e-3 of the brightest of a sky, with these by 3e-4 in 70
/// random skies.
const FINER_SAMPLES: u32 = 3;

impl RayIntegral {
    /// Distance of the ground in a direction (km), if it is seen there.
    pub fn ground_distance(&self, view: Vec3) -> Option<f64> {
        let ray = self.ray(view);
        let ground = ground_seen(self.medium(), ray, self.variant | variant::DESCENT);
        // Its own distance counts from where a ray from above enters the atmosphere.
        let radius = f64::from(self.uniform.atmosphere.ground_radius);
        let (from, mu) = (radius + f64::from(ray.altitude), f64::from(view.z));
        let nearest = from * from * (1.0 - mu * mu);
        ground.is_seen.then(|| (-from * mu - (radius * radius - nearest).max(0.0).sqrt()).max(0.0))
    }

    /// The part of light that the air up to a distance (km) lets through at each band. The forward peak of aerosol
    /// counts as let through, as it does along whole rays.
    pub fn transmittance_until(&self, view: Vec3, distance: f64) -> Vec<f64> {
        let along = self.columns_until(view, distance);
        self.at_bands(self.bands.iter().map(|group| group.coefficients().transmittance(along)))
    }

    /// Column densities up to a distance (km; infinite for all air, up to the ground where it is seen).
    pub fn columns_until(&self, view: Vec3, distance: f64) -> ColumnDensities {
        let distance = if distance.is_finite() { distance } else { self.ground_distance(view).unwrap_or(distance) };
        let ray = (self.ray(view), distance as f32);
        column_densities_until(self.medium(), &self.placed_for(), ray, self.variant | variant::DESCENT)
    }

    /// Transfer (sr⁻¹) at each band of light of all orders that the air up to a distance (km) scatters towards the
    /// observer.
    pub fn transfer_until(&self, view: Vec3, distance: f64) -> Vec<f64> {
        let (once, multiple) = (self.scattered_once_until(view, distance), self.multiple_until(view, distance));
        once.into_iter().zip(multiple).map(|(once, multiple)| once + multiple).collect()
    }

    fn scattered_once_until(&self, view: Vec3, distance: f64) -> Vec<f64> {
        let [air_phase, aerosol_phase] = [Constituent::Air, Constituent::Aerosol]
            .map(|constituent| self.phases_at(constituent, view, &self.wavelengths));
        let ray = (self.ray(view), distance as f32);
        let of_chunk = |chunk| {
            let Wavelengths { air, .. } = Wavelengths::<TOGETHER>::new(chunk);
            let light = single_scattering_until(
                self.medium(),
                &air,
                &self.placed_for(),
                &self.quadrature,
                ray,
                self.variant | variant::DESCENT,
            );
            light.air.0.into_iter().zip(light.aerosol.0)
        };
        let light = self.bands.chunks(TOGETHER / 4).flat_map(of_chunk);
        let phases = air_phase.into_iter().zip(aerosol_phase);
        // Of a chunk that is not full the last bands are repeated.
        light.zip(phases).map(|((air, aerosol), (p, q))| f64::from(air) * p + f64::from(aerosol) * q).collect()
    }

    fn multiple_until(&self, view: Vec3, distance: f64) -> Vec<f64> {
        let mut sum = vec![0.0; self.wavelengths.len()];
        if self.variant & variant::MULTIPLE == 0 {
            return sum;
        }
        let (view, bearing) = (view.as_dvec3(), self.uniform.bearing.as_dvec4().truncate());
        let cosine = level(view).dot(level(bearing));
        let row = Row { mu: view.z, cosines: vec![cosine], length: distance, polarised: false };
        for (share, resolution) in self.spectral_resolutions() {
            let resolution = Resolution { view_samples: FINER_SAMPLES * resolution.view_samples, ..resolution };
            let setting = self.setting();
            let (light, _) = light_of_rows(
                &self.light_fields,
                &setting,
                &self.bands,
                &resolution,
                self.orders,
                std::slice::from_ref(&row),
            );
            let scattered = self.at_bands(light.iter().map(|group| group[0][0].scattered));
            sum.iter_mut().zip(scattered).for_each(|(sum, light)| *sum += f64::from(share) * light);
        }
        sum
    }
}

/// The azimuth of a direction as a unit vector; of the zenith any.
fn level(direction: DVec3) -> DVec2 {
    direction.truncate().try_normalize().unwrap_or(DVec2::X)
}
