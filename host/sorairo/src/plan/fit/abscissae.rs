//! Where colours see an aerosol's phase function.

use std::ops::Range;

use sorairo_shared::glam::{DVec3, Vec4};

use crate::medium::aerosol::abscissa;
use crate::plan::fit::training::scattered_once_here;
use crate::plan::integral::RayIntegral;
use crate::plan::picture::colour_space::ColourSpace;
use crate::plan::rays::directions::direction;
use crate::plan::upload::bands;
use crate::scene::ColourObserver;
use crate::spectra::observer;

/// Step of wavelengths (nm).
const STEP: f64 = 20.0;

/// Wavelengths, in steps of [`STEP`], from whose light the abscissae are taken.
const WAVELENGTHS: Range<u32> = 20..35;

/// The abscissae of red, green and blue in an aerosol's phase function: where it is, straight ahead, what it is in the
/// mean over the light of the aerosol about the sun. There it is steep; elsewhere, a power of the wavelength nearly, it
/// is what it is at the mean abscissa, which lies close by.
pub fn rgb_abscissae(integral: &RayIntegral, observer: ColourObserver, space: &ColourSpace) -> Vec4 {
    let RayIntegral { uniform, optics, source, .. } = integral;
    let Some(phase) = optics.aerosol.phase() else { return Vec4::ZERO };
    let lowest = f64::from(uniform.horizon).to_degrees();
    let view = direction(source.elevation.max(lowest), source.azimuth).as_vec3();
    let wavelengths: Vec<f64> = WAVELENGTHS.map(|i| STEP * f64::from(i)).collect();
    let at = (&bands(optics, &wavelengths)[..], wavelengths.len());
    let (_, aerosol) = scattered_once_here(integral, &integral.quadrature, &[view], at);
    let sum = |of: &dyn Fn(f64) -> f64| -> DVec3 {
        let seen = |(&nm, light): (&f64, &f64)| {
            observer::weights(observer, nm) * optics.solar_irradiance(nm) * *light * of(nm)
        };
        space.from_xyz * wavelengths.iter().zip(&aerosol[0]).map(seen).sum::<DVec3>()
    };
    let light = sum(&|_| 1.0);
    let (means, ahead) = (sum(&abscissa) / light, sum(&|nm| phase.at(0.0, nm)) / light);
    let ends = [wavelengths[0], wavelengths[wavelengths.len() - 1]].map(abscissa);
    let of = |channel: usize| {
        let (logarithm, slope) = phase.logarithm(0.0, means[channel]);
        let moved = means[channel] + (ahead[channel].ln() - logarithm) / slope;
        // Of light that has lost a channel there is no mean.
        if moved.is_finite() { moved.clamp(ends[0], ends[1]) } else { 0.0 }
    };
    DVec3::from_array(std::array::from_fn(of)).as_vec3().extend(0.0)
}
