//! The Stokes vectors of a spectral image, beside its radiance.
//!
//! A pixel's light is integrated at the bands of its spectrum. The parts `Q / I` and `U / I` follow at the bands: light
//! of the first order in closed form, light of higher orders from a lookup of directions. Between the bands the parts
//! are straight lines, and radiance is that of the spectrum.

use rayon::prelude::*;
use sorairo_shared::camera::{Camera, pixel_view, top_of_image};
use sorairo_shared::glam::{Vec3, Vec4};
use sorairo_shared::light_field::multiple_lookup::{MultipleLookup, place, value};
use sorairo_shared::sky::{ByConstituent, cosine_from_sun};
use sorairo_shared::variant::{self, PixelFormat};

use crate::measure::direction::Direction;
use crate::measure::stokes::{Plane, StokesFrame};
use crate::plan::integral::RayIntegral;
use crate::plan::light_field::{PolarisedLight, Resolution};
use crate::plan::spectral::{SpectralPlan, weights_of_bands};
use crate::plan::{SkyPlan, upload};

/// Computes `Q` and `U` at the pixels of an image.
pub struct StokesImage<'a> {
    spectral: &'a SpectralPlan,
    camera: Camera,
    projection: u32,
    frame: StokesFrame,
    higher: HigherOrders,
    /// The bands between which each wavelength lies, with their weights.
    bands: Vec<Vec<(usize, f64)>>,
    is_night: bool,
}

/// `Q` and `U` of light of higher orders.
#[derive(Default)]
struct HigherOrders {
    lookup: MultipleLookup,
    /// `Q` at the entries of each group of bands, then `U` over the sine of the azimuth likewise (sr⁻¹).
    entries: Vec<Vec4>,
}

impl HigherOrders {
    fn new(integral: &RayIntegral) -> Self {
        if integral.variant & variant::MULTIPLE == 0 {
            return Self::default();
        }
        let setting = integral.setting();
        let resolutions = Resolution::mixed(&setting, integral.aerosol_depth());
        let bands = &integral.bands[..integral.wavelengths.len().div_ceil(4)];
        let light = PolarisedLight::new(&integral.light_fields, &setting, bands, &resolutions, integral.orders);
        let part = |of: usize| light.groups.iter().flatten().map(move |entry| entry[of]);
        Self { lookup: light.lookup, entries: part(1).chain(part(2)).collect() }
    }

    /// `Q` and `U` at a group of bands in a direction, relative to the vertical plane.
    fn at(&self, integral: &RayIntegral, group: usize, view: Vec3, sine: f32) -> [Vec4; 2] {
        if self.entries.is_empty() {
            return [Vec4::ZERO; 2];
        }
        let cosine = cosine_from_sun(&integral.uniform, view);
        let place = place(self.lookup, &integral.uniform.atmosphere, integral.ray(view), cosine);
        let groups = integral.wavelengths.len().div_ceil(4);
        let part = |of: usize| value(self.lookup, &self.entries, (0, (of * groups + group) as u32), place, 0);
        [part(0), part(1) * sine]
    }
}

impl<'a> StokesImage<'a> {
    /// That of a sky's spectrum, through the scene's camera.
    pub fn new(sky: &SkyPlan, spectral: &'a SpectralPlan, frame: StokesFrame) -> Self {
        let at = |&nm: &f64| weights_of_bands(spectral.smooth_bands(), nm);
        Self {
            spectral,
            camera: upload::camera(&sky.scene),
            projection: upload::projection(sky.scene.camera.projection),
            frame,
            higher: if sky.is_night { HigherOrders::default() } else { HigherOrders::new(&spectral.integral) },
            bands: spectral.wavelengths.iter().map(at).collect(),
            is_night: sky.is_night,
        }
    }

    /// The words of rows of a spectral image from row `first` on, with `S1`, `S2` and `S3` at each wavelength
    /// (W·m⁻²·sr⁻¹·nm⁻¹) behind those of each pixel.
    pub fn beside(&self, first: u32, rows: &[u32]) -> Vec<u32> {
        let (width, wavelengths) = (self.camera.width as usize, self.bands.len());
        let pixel_words = PixelFormat::LinearRgb.words() as usize + wavelengths;
        let circular = vec![0; wavelengths];
        let with_stokes = |(at, words): (usize, &[u32])| {
            let found = self.pixel((at % width) as u32, first + (at / width) as u32);
            [words, bytemuck::cast_slice(&found), &circular].concat()
        };
        rows.par_chunks_exact(pixel_words).enumerate().flat_map_iter(with_stokes).collect()
    }

    /// `Q` at every wavelength of a pixel, then `U`.
    fn pixel(&self, column: u32, row: u32) -> Vec<f32> {
        let seen = pixel_view(&self.camera, self.projection, column, row);
        let Some(direction) = Direction::of_view(seen).filter(|_| !self.is_night) else {
            return vec![0.0; 2 * self.bands.len()];
        };
        let view = seen.direction;
        let light = self.spectral.integral.light_of_directions(&[view]);
        let parts = self.parts(view, &direction, &light);
        let radiance = self.spectral.radiance_of_light(view, &light);
        let at = |parameter: usize, wavelength: usize| {
            let part = |&(band, weight): &(usize, f64)| weight * parts[band][parameter];
            let polarised: f64 = self.bands[wavelength].iter().map(part).sum();
            (radiance[wavelength].max(0.0) * polarised) as f32
        };
        let wavelengths = 0..self.bands.len();
        wavelengths.clone().map(|nm| at(0, nm)).chain(wavelengths.map(|nm| at(1, nm))).collect()
    }

    /// `Q / I` and `U / I` at each band in a direction.
    fn parts(&self, view: Vec3, direction: &Direction, light: &[ByConstituent<Vec4>]) -> Vec<[f64; 2]> {
        let integral = &self.spectral.integral;
        let plane = Plane::new(direction, integral.source.direction(), integral.source.azimuth);
        let sine = (integral.source.azimuth - direction.azimuth).to_radians().sin() as f32;
        let up =
            (self.frame == StokesFrame::Camera).then(|| top_of_image(&self.camera, self.projection, view).as_dvec3());
        let all = integral.at_bands(integral.transfers_of_light(view, light).into_iter());
        let first = plane.of_first_order(integral, light);
        let higher: Vec<_> = (0..integral.wavelengths.len().div_ceil(4))
            .map(|group| self.higher.at(integral, group, view, sine))
            .collect();
        let [q, u] = [0, 1].map(|part| integral.at_bands(higher.iter().map(|higher| higher[part])));
        let at = |band: usize| {
            let [_, polarised] = first[band];
            let [of_q, of_u] = plane.of_sun.map(|part| polarised * part);
            let [q, u] = plane.towards(up, [q[band] - of_q, u[band] - of_u]);
            if all[band] > 0.0 { [q / all[band], u / all[band]] } else { [0.0; 2] }
        };
        (0..integral.wavelengths.len()).map(at).collect()
    }
}
