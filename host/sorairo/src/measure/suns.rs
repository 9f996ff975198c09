//! Queries of many skies, on all cores.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::plan::{LightFields, Sky};
use crate::scene::ValidScene;

/// Calls `ask` for the sky of each scene and its number (from 0), and returns the results in the order of the scenes. A
/// sky is planned when its turn comes, and dropped afterwards, so a year of suns takes no more memory than a few. Skies
/// with the same atmosphere share their light fields; see [`LightFields`].
///
/// ```
/// use sorairo::{Direction, Scene, of_each_sky};
///
/// let mut scene = Scene::default();
/// let scenes = [5.0, 40.0].map(|elevation| {
///     scene.sun.elevation = elevation;
///     scene.validated()
/// });
/// let scenes: Vec<_> = scenes.into_iter().collect::<sorairo::Result<_>>()?;
/// let zenith = [Direction::new(90.0, 0.0)];
/// let zeniths = of_each_sky(&scenes, |_, sky| sky.radiance(&zenith, &[450.0, 650.0]))?;
/// assert!(zeniths[1][0][0] > zeniths[0][0][0], "a higher sun gives a brighter zenith");
/// # Ok::<(), sorairo::Error>(())
/// ```
///
/// # Errors
///
/// Those of `ask`, with the number of the scene.
pub fn of_each_sky<T: Send>(scenes: &[ValidScene], ask: impl Fn(usize, &Sky) -> Result<T> + Sync) -> Result<Vec<T>> {
    let light_fields = LightFields::default();
    let of_scene = |(number, scene): (usize, &ValidScene)| {
        ask(number, &Sky::with_light_fields(scene, scene.render.rgb, &light_fields))
            .map_err(|error| Error::InFrame { number: number as u32, error: Box::new(error) })
    };
    scenes.par_iter().enumerate().map(of_scene).collect()
}
