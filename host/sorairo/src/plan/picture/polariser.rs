//! A polariser before the lens: what it lets pass, and what the kernel reads for it beside the sky lookup; see
//! [`sorairo_shared::picture::polariser`].

use std::f64::consts::PI;

use rayon::prelude::*;
use sorairo_shared::fit::spectrum::Dozen;
use sorairo_shared::glam::{DMat3, DVec3, Vec4};
use sorairo_shared::light_field::multiple_lookup::MultipleLookup;
use sorairo_shared::picture::polariser::DEGREES;
use sorairo_shared::sky::{ByConstituent, Gathered, regression_constituents};
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant;

use crate::plan::fit::SpectralFit;
use crate::plan::fit::cones::XYZ_TO_CONES;
use crate::plan::fit::linear::{Interpolant, LinearFit};
use crate::plan::light_field::{PolarisedLight, Resolution};
use crate::plan::picture::polarised_rgb::PolarisedRgb;
use crate::plan::sky::{SkyPlan, found_once};
use crate::plan::upload;
use crate::scene::CameraScene;
use crate::spectra::observer;

impl SkyPlan {
    /// How its light is polarised, in linear RGB: found when a polariser first asks.
    pub fn polarised(&self) -> &PolarisedRgb {
        found_once(&self.polarised, || polarised(self))
    }
}

fn polarised(sky: &SkyPlan) -> PolarisedRgb {
    let mut found = PolarisedRgb { rows: degrees_of_aerosol(sky), lookup: MultipleLookup::default() };
    if sky.base.variant & variant::MULTIPLE != 0 {
        let (integral, setting) = (&sky.base, sky.base.setting());
        let resolutions = Resolution::mixed(&setting, integral.aerosol_depth());
        let light =
            PolarisedLight::new(&integral.light_fields, &setting, &integral.bands, &resolutions, integral.orders);
        found.lookup = light.lookup;
        found.rows.extend(in_rgb(sky, &light));
    }
    found
}

/// What passes a camera's polariser of `I`, `Q` and `U` relative to the top of the image; none without one.
pub fn passes(camera: &CameraScene) -> Option<Vec4> {
    let (sine, cosine) = (2.0 * camera.polariser?.to_radians()).sin_cos();
    let across = camera.polariser_extinction.map_or(0.0, f64::recip);
    let [mean, difference] = [0.5 * (1.0 + across), 0.5 * (1.0 - across)];
    Some(Vec4::new(mean as f32, (difference * cosine) as f32, (difference * sine) as f32, 0.0))
}

/// The degree of polarisation of light that aerosol scatters once, over the scattering angle: of the cones, or of red,
/// green and blue, the mean over the light that it scatters of the sun; see
/// [`sorairo_shared::uniform::Polariser::first`].
fn degrees_of_aerosol(sky: &SkyPlan) -> Vec<Vec4> {
    let optics = &sky.base.optics;
    if !optics.aerosol.is_there() {
        return vec![Vec4::ZERO; DEGREES as usize];
    }
    let wavelengths = observer::wavelengths();
    let scattered = |&nm: &f64| optics.solar_irradiance(nm) * optics.at(nm).aerosol_scattering;
    let from_xyz = if sky.base.variant & variant::PHASE_TABLE != 0 { XYZ_TO_CONES } else { sky.space.from_xyz };
    let weight = |nm: &f64| from_xyz * observer::weights(sky.observer, *nm) * scattered(nm);
    let weights: Vec<DVec3> = wavelengths.iter().map(weight).collect();
    let all: DVec3 = weights.iter().sum();
    let at = |i: u32| {
        let angle = PI * f64::from(i) / f64::from(DEGREES - 1);
        let degree = |(weight, &nm): (&DVec3, &f64)| *weight * optics.aerosol.degree(angle, nm);
        let sum: DVec3 = weights.iter().zip(&wavelengths).map(degree).sum();
        (sum / all).as_vec3().extend(0.0)
    };
    (0..DEGREES).map(at).collect()
}

/// `Q`, then `U` over the sine of the azimuth, of light of higher orders in linear RGB.
fn in_rgb(sky: &SkyPlan, light: &PolarisedLight) -> Vec<Vec4> {
    let entries = 0..light.groups[0].len();
    let of_entry = |entry: usize| -> [Vec<Vec4>; 3] {
        std::array::from_fn(|component| light.groups.iter().map(|group| group[entry][component]).collect())
    };
    let found: Vec<[Vec4; 2]> = match &sky.fit {
        SpectralFit::Linear(fit) => {
            let rows = fit.folded(&sky.base.optics, sky.observer, &sky.space);
            let of = |entry| {
                let [_, q, u] = of_entry(entry);
                [folded(&rows, &q), folded(&rows, &u)].map(|rgb| rgb.as_vec3().extend(0.0))
            };
            entries.into_par_iter().map(of).collect()
        }
        SpectralFit::Regression => {
            let by_regression = ByRegression::new(sky);
            entries.into_par_iter().map(|entry| by_regression.polarised(of_entry(entry))).collect()
        }
    };
    [0, 1].map(|component| found.iter().map(|of| of[component]).collect::<Vec<_>>()).concat()
}

/// What the rows of a linear fit make of values at groups of bands.
fn folded(rows: &[Vec4], groups: &[Vec4]) -> DVec3 {
    let of_group = |(rows, &light): (&[Vec4], &Vec4)| {
        DVec3::from_array([0, 1, 2].map(|channel| rows[channel].as_dvec4().dot(light.as_dvec4())))
    };
    rows.chunks_exact(3).zip(groups).map(of_group).sum()
}

/// Polarised colours by a regression, which is made for radiance: it gives the colour, and straight lines between the
/// bands the part that is polarised. The part is taken of X, Y and Z, to which no wavelength adds less than nothing.
struct ByRegression<'a> {
    sky: &'a SkyPlan,
    uniform: Uniform,
    /// Of straight lines.
    rows: Vec<Vec4>,
    to_xyz: DMat3,
}

impl<'a> ByRegression<'a> {
    fn new(sky: &'a SkyPlan) -> Self {
        let lines = LinearFit {
            wavelengths: sky.base.wavelengths.clone(),
            interpolant: Interpolant::Segments,
            of_radiance: false,
        };
        let rows = lines.folded(&sky.base.optics, sky.observer, &sky.space);
        let (uniform, _) = upload::with_rows(sky.base.uniform, &sky.colours().rows, sky.base.variant);
        Self { sky, uniform, rows, to_xyz: sky.space.from_xyz.inverse() }
    }

    /// Linear RGB of `Q` and `U` from `I`, `Q` and `U` at groups of bands.
    fn polarised(&self, [i, q, u]: [Vec<Vec4>; 3]) -> [Vec4; 2] {
        let group = |at: usize| i.get(at).copied().unwrap_or_default();
        let multiple = Dozen { first: group(0), second: group(1), third: group(2) };
        let lights = ByConstituent { multiple, ..Gathered::DARK.lights };
        let rgb = regression_constituents(&self.uniform, lights, self.sky.base.variant & !variant::GROUND).rest;
        let xyz = self.to_xyz * rgb.as_dvec3();
        let by_lines = |of: &[Vec4]| self.to_xyz * folded(&self.rows, of);
        let all = by_lines(&i).max(DVec3::splat(f64::MIN_POSITIVE));
        [q, u].map(|of| (self.sky.space.from_xyz * (xyz * by_lines(&of) / all)).as_vec3().extend(0.0))
    }
}
