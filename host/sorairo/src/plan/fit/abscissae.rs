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

/// The abscissae of red, green and blue in an aerosol's phase function: their means over the light of the aerosol about
/// the sun, where the phase function is steep. A phase function is a power of the wavelength nearly, of which a mean is
/// that at the mean abscissa.
pub fn rgb_abscissae(integral: &RayIntegral, observer: ColourObserver, space: &ColourSpace) -> Vec4 {
    let RayIntegral { uniform, optics, source, .. } = integral;
    if optics.aerosol.phase().is_none() {
        return Vec4::ZERO;
    }
    let lowest = f64::from(uniform.horizon).to_degrees();
    let view = direction(source.elevation.max(lowest), source.azimuth).as_vec3();
    let wavelengths: Vec<f64> = WAVELENGTHS.map(|i| STEP * f64::from(i)).collect();
    let at = (&bands(optics, &wavelengths)[..], wavelengths.len());
    let (_, aerosol) = scattered_once_here(integral, &integral.quadrature, &[view], at);
    let light = |i: usize| aerosol[0][i] * optics.solar_irradiance(wavelengths[i]);
    let mean = |of: &dyn Fn(usize) -> f64| -> DVec3 {
        let xyz: DVec3 = (0..wavelengths.len()).map(|i| observer::weights(observer, wavelengths[i]) * of(i)).sum();
        space.from_xyz * xyz
    };
    let (weighed, sum) = (mean(&|i| light(i) * abscissa(wavelengths[i])), mean(&light));
    let ends = [wavelengths[0], wavelengths[wavelengths.len() - 1]].map(abscissa);
    // Of light that has lost a channel there is no mean.
    let of = |channel: usize| match weighed[channel] / sum[channel] {
        mean if mean.is_finite() => mean.clamp(ends[0], ends[1]),
        _ => 0.0,
    };
    DVec3::from_array(std::array::from_fn(of)).as_vec3().extend(0.0)
}
