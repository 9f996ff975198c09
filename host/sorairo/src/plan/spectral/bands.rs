//! The bands of a spectrum, beside those of colour.

use sorairo_shared::glam::Vec2;
use sorairo_shared::variant;

use crate::plan::fit::SpectralFit;
use crate::plan::integral::RayIntegral;
use crate::plan::rays::quadrature::gauss_legendre;
use crate::plan::samples;
use crate::plan::sky::SkyPlan;
use crate::plan::strengths::{LINE_BANDS, beside_lines};
use crate::scene::{ColourPath, Scene};

/// Bands (nm) that a spectrum takes beside the four of colour, the same for every sky: between those and beyond them,
/// closer where ozone's cross-section bends. What they leave over 70 skies stands in
/// `docs/decisions/04-regression-fit.md`.
pub const BANDS: [f64; 8] = [365.0, 395.0, 480.0, 600.0, 665.0, 700.0, 750.0, 830.0];

/// The same in air with gases, whose lines have [`LINE_BANDS`] beside them: these see light without lines.
pub(crate) const BANDS_BESIDE_LINES: [f64; 5] = [365.0, 395.0, 480.0, 665.0, 830.0];

/// Bands (nm) that lie closer tell nothing new of each other.
const CLOSEST: f64 = 5.0;

/// The sky's light at its own bands and at others (nm).
pub(crate) fn beside_own(sky: &SkyPlan, others: Vec<f64>) -> RayIntegral {
    let bands = [sky.base.wavelengths.clone(), others].concat();
    with_own_bands(&sky.base, at_bands(sky, &SpectralFit::Regression, bands)).with_spectral_light()
}

/// The same with [`LINE_BANDS`] behind them.
pub(crate) fn beside_own_with_lines(sky: &SkyPlan, others: Vec<f64>) -> RayIntegral {
    let bands = [sky.base.wavelengths.clone(), others, LINE_BANDS.map(|(nm, _)| nm).to_vec()].concat();
    let integral = with_own_bands(&sky.base, at_bands(sky, &SpectralFit::Regression, bands));
    with_line_bands(integral).with_spectral_light()
}

/// Bands whose last are [`LINE_BANDS`].
pub(crate) fn with_line_bands(mut integral: RayIntegral) -> RayIntegral {
    beside_lines(&integral.wavelengths, &mut integral.bands);
    integral
}

/// The first bands of an integral as those of a sky's colour, which are means over what they stand for.
pub(crate) fn with_own_bands(sky: &RayIntegral, mut integral: RayIntegral) -> RayIntegral {
    // They fill their groups: a sky that names other bands has no more beside them.
    integral.bands[..sky.bands.len()].copy_from_slice(&sky.bands);
    integral
}

/// The sky's light at bands (nm), sampled as they need it; without that which was scattered more than once.
pub(crate) fn at_bands(sky: &SkyPlan, fit: &SpectralFit, bands: Vec<f64>) -> RayIntegral {
    let own = &sky.base;
    let quadrature = if samples::depends_on_bands(&sky.scene, own.variant) {
        sampled(&sky.scene, own, fit, &bands)
    } else {
        own.quadrature.clone()
    };
    let count = bands.len();
    RayIntegral { quadrature, ..at_wavelengths(own, fit, bands, count) }
}

/// The light of a sky at wavelengths (nm), for a fit through so many bands; without that which was scattered more than
/// once.
pub(crate) fn at_wavelengths(sky: &RayIntegral, fit: &SpectralFit, wavelengths: Vec<f64>, bands: usize) -> RayIntegral {
    RayIntegral {
        bands: fit.bands(&sky.optics, &wavelengths),
        wavelengths,
        variant: sky.variant & !variant::FIT | fit.variant(bands, ColourPath::Folded),
        ..sky.clone()
    }
}

/// The rule by which the rays of a scene's sky are sampled as bands (nm) need it.
pub(crate) fn sampled(scene: &Scene, sky: &RayIntegral, fit: &SpectralFit, bands: &[f64]) -> Vec<Vec2> {
    let RayIntegral { uniform, optics, variant, .. } = sky;
    let bands = fit.bands(optics, bands);
    let fewest =
        || samples::per_piece(scene, sky.tables.as_deref(), uniform, optics, &bands, *variant, &sky.light_fields);
    gauss_legendre(scene.render.steps.unwrap_or_else(fewest))
}

/// Those of some bands (nm) that lie among wavelengths asked for, in order, and apart from the sky's own. What lies
/// beyond moves to their ends.
pub(crate) fn bands_beside(bands: &[f64], own: &[f64], asked: &[f64]) -> Vec<f64> {
    let mut all = own.to_vec();
    for band in bands.iter().map(|band| band.clamp(asked[0], asked[asked.len() - 1])) {
        if all.iter().all(|other| (other - band).abs() >= CLOSEST) {
            all.push(band);
        }
    }
    all.split_off(own.len())
}
