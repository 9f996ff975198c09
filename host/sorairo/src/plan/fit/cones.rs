//! Where colours read an aerosol's phase function.

use std::ops::Range;

use sorairo_shared::glam::{DMat3, DVec3, Vec4};
use sorairo_shared::uniform::Cones;

use crate::medium::aerosol::{Phase, abscissa};
use crate::plan::fit::light::scattered_once_here;
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

/// The matrix from XYZ to the responses of the long, middle and short cones (Hunt, Pointer and Estévez, as in CIE
/// 159:2004, *A colour appearance model for colour management systems: CIECAM02*). Those of the CIE 1931 observer are
/// positive at every wavelength.
pub const XYZ_TO_CONES: DMat3 = DMat3::from_cols(
    DVec3::new(0.38971, -0.22981, 0.0),
    DVec3::new(0.68898, 1.18340, 0.0),
    DVec3::new(-0.07868, 0.04641, 1.0),
);

/// How colours read the table of an aerosol's phase function; zeros where it has none.
pub fn cones(integral: &RayIntegral, observer: ColourObserver, space: &ColourSpace) -> Cones {
    let Some(phase) = integral.optics.aerosol.phase() else { return Cones::default() };
    let columns = |matrix: DMat3| [0, 1, 2].map(|column| matrix.col(column).as_vec3().extend(0.0));
    Cones {
        abscissae: abscissae(integral, observer, phase),
        from_rgb: columns(XYZ_TO_CONES * space.from_xyz.inverse()),
        to_rgb: columns(space.from_xyz * XYZ_TO_CONES.inverse()),
    }
}

/// The abscissae of the cones: where the phase function straight ahead is its mean over the light of the aerosol about
/// the sun. There it is steep; elsewhere, a power of the wavelength nearly, it is what it is at the mean abscissa, which
/// lies close by.
fn abscissae(integral: &RayIntegral, observer: ColourObserver, phase: &Phase) -> Vec4 {
    let RayIntegral { uniform, optics, source, .. } = integral;
    let lowest = f64::from(uniform.horizon).to_degrees();
    let view = direction(source.elevation.max(lowest), source.azimuth).as_vec3();
    let wavelengths: Vec<f64> = WAVELENGTHS.map(|i| STEP * f64::from(i)).collect();
    let at = (&bands(optics, &wavelengths)[..], wavelengths.len());
    let (_, aerosol) = scattered_once_here(integral, &integral.quadrature, &[view], at);
    let sum = |of: &dyn Fn(f64) -> f64| -> DVec3 {
        let seen = |(&nm, light): (&f64, &f64)| {
            observer::weights(observer, nm) * optics.solar_irradiance(nm) * *light * of(nm)
        };
        XYZ_TO_CONES * wavelengths.iter().zip(&aerosol[0]).map(seen).sum::<DVec3>()
    };
    let light = sum(&|_| 1.0);
    let (means, ahead) = (sum(&abscissa) / light, sum(&|nm| phase.at(0.0, nm)) / light);
    let ends = [wavelengths[0], wavelengths[wavelengths.len() - 1]].map(abscissa);
    let of = |cone: usize| {
        let (logarithm, slope) = phase.logarithm(0.0, means[cone]);
        let moved = means[cone] + (ahead[cone].ln() - logarithm) / slope;
        // Of light that has lost what a cone sees there is no mean.
        if moved.is_finite() { moved.clamp(ends[0], ends[1]) } else { 0.0 }
    };
    DVec3::from_array(std::array::from_fn(of)).as_vec3().extend(0.0)
}
