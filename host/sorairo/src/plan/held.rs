//! The sky that a program holds.

use std::sync::Arc;

use sorairo_shared::glam::DVec3;

use crate::error::Result;
use crate::plan::light_field::LightFields;
use crate::plan::sky::SkyPlan;
use crate::scene::{Rgb, Scene, ValidScene};

/// The sky of a scene, which answers all queries.
///
/// A sky is immutable. Clones share its data, on any thread. Light fields, fits and colours are computed on first use,
/// and cached.
///
/// ```
/// use sorairo::{Direction, Scene, Sky};
///
/// let mut scene = Scene::default();
/// scene.sun.elevation = 10.0;
/// let sky = Sky::new(&scene)?;
/// let zenith = sky.radiance(&[Direction::new(90.0, 0.0)], &[450.0, 650.0])?;
/// assert!(zenith[0][0] > zenith[0][1], "the zenith is blue");
/// # Ok::<(), sorairo::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sky(Arc<SkyPlan>);

impl Sky {
    /// The sky of a scene. Its linear RGB is in the colour space of the scene, `render.rgb`.
    ///
    /// # Errors
    ///
    /// Those of [`Scene::validated`].
    pub fn new(scene: &Scene) -> Result<Self> {
        let scene = scene.validated()?;
        Ok(Self::with_light_fields(&scene, scene.render.rgb, &LightFields::default()))
    }

    /// The sky of a scene in a space of linear RGB, with the light fields of other skies. Light fields take most of the
    /// time of a sky; skies with the same atmosphere and nearby suns share them. For a picture, pass the space of its
    /// display, `scene.render.display.rgb()`.
    pub fn with_light_fields(scene: &ValidScene, rgb: Rgb, light_fields: &LightFields) -> Self {
        Self(Arc::new(SkyPlan::with_light_fields(scene, rgb, light_fields)))
    }

    /// The scene of the sky. Any camera may view it, that of the scene or another.
    pub fn scene(&self) -> &ValidScene {
        &self.0.scene
    }

    /// The space of its linear RGB.
    pub fn rgb(&self) -> Rgb {
        self.0.space.rgb
    }

    /// Whether its light is computed by vector radiative transfer.
    pub fn is_polarised(&self) -> bool {
        self.0.base.polarised
    }

    /// Whether both are clones of one sky.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// What answers them: for the library itself and its evaluation.
    #[doc(hidden)]
    pub fn plan(&self) -> &SkyPlan {
        &self.0
    }

    /// Computes what images need beyond spectra, so that the first image does not have to.
    pub fn prepare_images(&self) {
        self.0.prepare();
    }

    /// Linear RGB, in the sky's space, of XYZ of its observer. Colours are mapped into the gamut: no channel is
    /// negative.
    pub fn rgb_of_xyz(&self, xyz: [f64; 3]) -> [f64; 3] {
        let space = self.0.space;
        space.into_gamut(space.from_xyz * DVec3::from_array(xyz)).to_array()
    }
}
