//! The skies that were planned last: most questions after a first one are of the same sky with another camera, or of
//! the one beside it.

use std::cell::RefCell;

use sorairo::scene::{Display, Rgb, ValidScene};
use sorairo::{LightFields, Result, Scene, Sky};

thread_local! {
    /// The one that was asked for last comes first.
    static LAST: RefCell<Vec<Sky>> = const { RefCell::new(Vec::new()) };
    /// For a sun that moves.
    static LIGHT_FIELDS: LightFields = LightFields::default();
}

/// A scene from its text, checked.
///
/// # Errors
///
/// What is wrong with it, and where.
pub fn read(toml: &str) -> Result<ValidScene> {
    Scene::parse(toml, "the scene", None)?.validated()
}

/// A scene as a canvas shows it, which is one of sRGB.
///
/// # Errors
///
/// What is wrong with it, and where.
pub fn read_for_canvas(toml: &str) -> Result<ValidScene> {
    let mut scene = Scene::parse(toml, "the scene", None)?;
    scene.render.display = Display::Srgb;
    scene.validated()
}

/// Two skies are compared side by side.
const KEPT: usize = 2;

/// The sky of a scene in a space of linear RGB: a picture's is that of its display.
pub fn sky(scene: &ValidScene, rgb: Rgb) -> Sky {
    LAST.with_borrow_mut(|skies| {
        let known = skies.iter().position(|sky| sky.rgb() == rgb && sky.scene().has_sky_of(scene));
        let planned = || LIGHT_FIELDS.with(|fields| Sky::with_light_fields(scene, rgb, fields));
        let sky = known.map_or_else(planned, |at| skies.remove(at));
        skies.insert(0, sky.clone());
        skies.truncate(KEPT);
        sky
    })
}

/// How many skies this thread has planned and still knows.
#[cfg(test)]
pub fn planned() -> usize {
    LAST.with_borrow(Vec::len)
}
