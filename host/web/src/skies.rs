//! The sky that was planned last: most questions after a first one are of the same sky, with another camera.

use std::cell::RefCell;
use std::sync::Arc;

use sorairo::scene::{Rgb, ValidScene};
use sorairo::{Result, Scene, SkyPlan};

thread_local! {
    static LAST: RefCell<Option<Arc<SkyPlan>>> = const { RefCell::new(None) };
}

/// A scene from its text, checked.
///
/// # Errors
///
/// What is wrong with it, and where.
pub fn read(toml: &str) -> Result<ValidScene> {
    Scene::parse(toml, "the scene", None)?.validated()
}

/// The sky of a scene in a space of linear RGB: a picture's is sRGB.
pub fn sky(scene: &ValidScene, rgb: Rgb) -> Arc<SkyPlan> {
    LAST.with_borrow_mut(|last| match last {
        Some(sky) if sky.space.rgb == rgb && is_same_sky(&sky.scene, scene) => Arc::clone(sky),
        _ => Arc::clone(last.insert(Arc::new(SkyPlan::new(scene, rgb)))),
    })
}

fn is_same_sky(one: &Scene, other: &Scene) -> bool {
    Scene { camera: other.camera.clone(), ..one.clone() } == *other
}
