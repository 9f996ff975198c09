//! The error of a plan's colours over the whole sky.
//!
//! Colours are compared as XYZ before they are brought into the gamut of the display, which would hide part of an
//! error. A plan's XYZ comes from the kernels' own functions in single precision, up to and without that last step. The
//! reference is the observer's 81-sample sum of [`DenseSpectrum`]: every sample integrated, and summed in double
//! precision.

use rayon::prelude::*;
use sorairo_shared::fit::observer::observe_cubic;
use sorairo_shared::glam::{DVec3, Vec3, Vec4};
use sorairo_shared::variant::is_solved_cubic;

use super::metrics::Errors;
use crate::problem::Result;
use sorairo::low_level::plan::direction;
use sorairo::low_level::spectra::observer;
use sorairo::low_level::spectrum::DenseSpectrum;
use sorairo::scene::{ColourPath, Exposure, Fit, PathChoice, Scene};
use sorairo::{PixelFormat, Plan};

/// Elevations (degrees) at which the sky is compared: they resolve the horizon.
const ELEVATIONS: [f64; 17] =
    [0.0, 0.2, 0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 60.0, 75.0, 90.0];

/// Azimuths from the sun (degrees), over the half of the sky that the other half mirrors.
const AZIMUTHS: [f64; 9] = [0.0, 22.5, 45.0, 67.5, 90.0, 112.5, 135.0, 157.5, 180.0];

/// The sun's elevations (degrees) over which an error is stated.
pub const SUNS: [f64; 11] = [-4.0, -2.0, 0.0, 2.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 90.0];

/// The directions of a scene's sky that are compared: 145 above the horizon, and as many below it for an observer above
/// the ground.
pub fn views(scene: &Scene) -> Vec<Vec3> {
    let view = |elevation: f64, azimuth: f64| direction(elevation, scene.sun.azimuth + azimuth).as_vec3();
    let half = |sign: f64| {
        let level = ELEVATIONS[..16].iter().flat_map(move |&e| AZIMUTHS.map(|azimuth| view(sign * e, azimuth)));
        level.chain([view(sign * 90.0, 0.0)])
    };
    let below = scene.observer.altitude > 0.0;
    half(1.0).chain(half(-1.0).filter(|_| below)).collect()
}

/// A scene's plan for its error: as it stands, except that every pixel is integrated and no time is spent on an
/// exposure.
///
/// # Errors
///
/// [`crate::Error::Sky`] if a value of the scene is out of range.
pub fn plan(scene: &Scene) -> Result<Plan> {
    let mut scene = scene.clone();
    scene.render.exposure = Exposure::Stops(0.0);
    scene.render.path = PathChoice::Direct;
    Ok(Plan::new(&scene.validated()?, PixelFormat::LinearRgb))
}

/// The true colours of a scene's sky.
pub struct Reference {
    /// The directions.
    pub views: Vec<Vec3>,
    /// XYZ in each direction (radiance weighted by the observer, W·m⁻²·sr⁻¹).
    pub xyz: Vec<DVec3>,
}

impl Reference {
    /// Those of a scene, whatever its fit.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Sky`] if a value of the scene is out of range.
    pub fn new(scene: &Scene) -> Result<Self> {
        let views = views(scene);
        let xyz = true_xyz(scene, &views)?;
        Ok(Self { views, xyz })
    }

    /// The error of a plan's colours.
    pub fn errors(&self, plan: &Plan) -> Errors {
        let xyz: Vec<DVec3> = self.views.par_iter().map(|&view| xyz(plan, view)).collect();
        Errors::of(xyz.into_iter().zip(self.xyz.iter().copied()))
    }
}

/// The true XYZ of a scene in some directions (W·m⁻²·sr⁻¹).
///
/// # Errors
///
/// [`crate::Error::Sky`] if a value of the scene is out of range.
pub fn true_xyz(scene: &Scene, views: &[Vec3]) -> Result<Vec<DVec3>> {
    let mut cheapest = scene.clone();
    (cheapest.render.fit, cheapest.render.bands) = (Fit::Transfer, None);
    cheapest.render.color = ColourPath::Folded;
    let dense = DenseSpectrum::over_steps(plan(&cheapest)?.sky.plan());
    let weights: Vec<DVec3> =
        observer::wavelengths().into_iter().map(|nm| observer::weights(scene.render.observer, nm)).collect();
    let sum = |view: &Vec3| dense.radiance(*view).into_iter().zip(&weights).map(|(radiance, &w)| w * radiance).sum();
    Ok(views.par_iter().map(sum).collect())
}

/// A plan's XYZ in a direction, integrated there, before it is brought into the gamut of the display (W·m⁻²·sr⁻¹).
pub fn xyz(plan: &Plan, view: Vec3) -> DVec3 {
    let (sky, integral) = (&plan.sky, plan.sky.plan().integral());
    if is_solved_cubic(integral.variant) {
        let irradiance = integral.bands[0].fit_irradiance.to_array();
        let transfer = integral.transfer(view);
        let radiance = Vec4::from_array(std::array::from_fn(|i| transfer[i] as f32 * irradiance[i]));
        return observe_cubic(integral.uniform.band_wavelengths, radiance, &sky.plan().colours().rows).as_dvec3();
    }
    sky.plan().space.from_xyz.inverse() * integral.rgb(view, sky.plan().constituents(&[view])[0]).as_dvec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sorairo::scene::Preset;
    use sorairo_shared::display::rgb::into_gamut;

    /// What is compared is what the kernels draw, but for the gamut.
    #[test]
    fn a_plan_is_judged_by_the_colours_that_its_kernel_draws() {
        for (fit, color, bands) in [
            (Fit::Cubic, ColourPath::Folded, None),
            (Fit::Cubic, ColourPath::Solve, None),
            (Fit::Transfer, ColourPath::Folded, Some(vec![430.0, 480.0, 530.0, 580.0, 620.0, 660.0])),
            (Fit::Regression, ColourPath::Folded, None),
            (Fit::Regression, ColourPath::Solve, None),
            (Fit::Dense, ColourPath::Folded, None),
        ] {
            let mut scene = Scene::preset(Preset::Earth).first_order();
            (scene.render.fit, scene.render.color, scene.render.bands) = (fit, color, bands);
            let plan = plan(&scene).unwrap();
            for view in views(&scene) {
                let rgb = (plan.sky.plan().space.from_xyz * xyz(&plan, view)).as_vec3();
                let (mapped, drawn) = (into_gamut(rgb, &plan.uniform.rgb), plan.radiance(view));
                // Folding the rows in single precision rounds each of a dozen terms that nearly cancel.
                assert!(
                    (mapped - drawn).abs().max_element() <= 1e-5 * drawn.max_element(),
                    "{fit:?}: {mapped} {drawn}"
                );
            }
        }
    }
}
