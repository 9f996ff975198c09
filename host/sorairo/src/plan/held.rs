//! The sky that a program holds.

use std::ops::Deref;
use std::sync::Arc;

use sorairo_shared::glam::DVec3;

use crate::error::Result;
use crate::plan::light_field::LightFields;
use crate::plan::sky::SkyPlan;
use crate::scene::{Rgb, Scene, ValidScene};

/// The sky of a scene: whatever is computed is asked of it.
///
/// A sky never changes. Clones share it, on any thread. Light fields, fits and colours are computed when a question
/// first needs them, and kept.
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
    /// The sky of a scene. Its linear RGB has the scene's own space, `render.rgb`.
    ///
    /// # Errors
    ///
    /// Those of [`Scene::validated`].
    pub fn new(scene: &Scene) -> Result<Self> {
        let scene = scene.validated()?;
        Ok(Self::with_light_fields(&scene, scene.render.rgb, &LightFields::default()))
    }

    /// The sky of a scene with a space of linear RGB and the light fields of other skies. A light field takes most of
    /// the time of a sky; skies of the same air under suns that are near each other share it. A picture takes the
    /// space of its display, `scene.render.display.rgb()`.
    pub fn with_light_fields(scene: &ValidScene, rgb: Rgb, light_fields: &LightFields) -> Self {
        SkyPlan::with_light_fields(scene, rgb, light_fields).into()
    }

    /// The scene whose sky this is. Any camera may look at it, the scene's or another.
    pub fn scene(&self) -> &ValidScene {
        &self.0.scene
    }

    /// The space of its linear RGB.
    pub fn rgb(&self) -> Rgb {
        self.0.space.rgb
    }

    /// Whether its light is computed with polarisation.
    pub fn is_polarised(&self) -> bool {
        self.0.base.polarised
    }

    /// Whether both are clones of one sky.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// Computes now what images take and spectra do not, so that the first image does not wait for it.
    pub fn prepare_images(&self) {
        self.0.prepare();
    }

    /// Linear RGB of the sky's space of XYZ of its observer, brought into the gamut: no channel is negative.
    pub fn rgb_of_xyz(&self, xyz: [f64; 3]) -> [f64; 3] {
        let space = self.0.space;
        space.into_gamut(space.from_xyz * DVec3::from_array(xyz)).to_array()
    }
}

impl From<SkyPlan> for Sky {
    fn from(plan: SkyPlan) -> Self {
        Self(Arc::new(plan))
    }
}

/// For the library itself, its tests and its evaluation.
#[doc(hidden)]
impl Deref for Sky {
    type Target = SkyPlan;

    fn deref(&self) -> &SkyPlan {
        &self.0
    }
}
