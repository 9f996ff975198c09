//! What the kernels of a scene's images are specialised for while the sun moves: what a program compiles before its
//! first frame.

use sorairo_shared::picture::run::RUN;
use sorairo_shared::variant::{self, PixelFormat};

use crate::plan::fit::{self, SpectralFit};
use crate::plan::integral;
use crate::plan::kernel::Kernel;
use crate::plan::picture::below;
use crate::plan::picture::image::of_image;
use crate::plan::rays::directions;
use crate::plan::sky::rest;
use crate::scene::{CameraScene, ColourPath, PathChoice, Projection, Scene};

/// Between two suns that are looked at (degrees). What a scene needs of the integral changes at two elevations, more
/// than this apart.
const STEP: f64 = 0.25;

/// The kernels that images of a scene's sky may take by a camera under any sun from the zenith to the night, each with
/// its variant.
pub fn kernels(scene: &Scene, camera: &CameraScene, pixel: PixelFormat) -> Vec<(Kernel, u32)> {
    let mut kernels = Vec::new();
    for sky in skies(scene) {
        let below = below::of(scene, camera, pixel);
        let image = of_image(sky, scene, camera, below, scene.sun.disc, pixel);
        if scene.render.path != PathChoice::Direct && scene.render.color != ColourPath::Solve {
            let image = if camera.polariser.is_some() { image | variant::POLARISER } else { image };
            kernels.extend([Kernel::Anchors, Kernel::Lookup, Kernel::SkyLookup].map(|kernel| (kernel, image)));
            kernels.extend(has_runs(camera).then_some((Kernel::SkyLookup, image | variant::RUNS)));
        }
        kernels.push((Kernel::Sky, image));
        kernels.extend((sky & variant::MULTIPLE != 0).then_some((Kernel::Sky, image | variant::REFINED)));
    }
    kernels
}

/// The variants of a scene's sky under all suns by which it is lit.
fn skies(scene: &Scene) -> Vec<u32> {
    let optics = scene.optics();
    let wavelengths = fit::wavelengths(scene);
    let fit = SpectralFit::new(scene, &wavelengths).variant(wavelengths.len(), scene.render.color);
    let mut scene = scene.clone();
    let mut skies = Vec::new();
    scene.sun.elevation = 90.0;
    while scene.sun.elevation >= -90.0 && !directions::is_night(&scene) {
        let sky = integral::needed(&scene, &optics) | fit | rest(&scene);
        if !skies.contains(&sky) {
            skies.push(sky);
        }
        scene.sun.elevation -= STEP;
    }
    skies
}

/// Whether pixels may be looked up in runs; see [`crate::plan::lookup::pixels_run`].
fn has_runs(camera: &CameraScene) -> bool {
    matches!(camera.projection, Projection::Equirectangular | Projection::Perspective)
        && camera.size.width.is_multiple_of(RUN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Plan;
    use crate::scene::Preset;

    #[test]
    fn the_kernels_of_a_day_are_those_of_its_images() {
        let mut seen = Vec::new();
        for (projection, size, altitude, disc) in [
            (Projection::Perspective, "640x360", 0.0, true),
            (Projection::Equirectangular, "256x128", 0.0, false),
            (Projection::Fisheye, "60x60", 3.0, true),
        ] {
            let mut scene = Scene::preset(Preset::Standard);
            (scene.camera.projection, scene.camera.size) = (projection, size.parse().unwrap());
            (scene.observer.altitude, scene.sun.disc) = (altitude, disc);
            let pixel = PixelFormat::Picture;
            let of_a_day = kernels(&scene, &scene.camera, pixel);
            for sun in [75.0, 12.0, 5.0, 0.5, -0.5, -5.0, -7.5, -14.0] {
                scene.sun.elevation = sun;
                let plan = Plan::new(&scene.validated().unwrap(), pixel);
                let taken = (plan.kernel(), plan.variant);
                assert!(of_a_day.contains(&taken), "{projection:?}, sun at {sun}: {taken:?} is not in {of_a_day:?}");
                let fills = (Kernel::Lookup, Kernel::Lookup.variant(plan.variant));
                let filled = of_a_day.iter().map(|&(kernel, variant)| (kernel, kernel.variant(variant)));
                assert!(plan.kernel() != Kernel::SkyLookup || filled.clone().any(|of_day| of_day == fills));
                seen.push(taken);
            }
        }
        assert!(seen.iter().any(|(kernel, _)| *kernel == Kernel::Sky), "some are integrated");
        assert!(seen.iter().any(|(kernel, _)| *kernel == Kernel::SkyLookup), "some are looked up");
    }
}
