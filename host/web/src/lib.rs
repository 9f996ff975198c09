//! sorairo in a browser: what its page asks the library, as `docs/browser.md` lists it.
//!
//! A scene is the text of a scene file. What is refused is thrown as a text of one sentence.

mod answers;
#[cfg(target_arch = "wasm32")]
mod canvas;
#[cfg(target_arch = "wasm32")]
mod gpu;
mod skies;
#[cfg(target_arch = "wasm32")]
mod studio;

pub use answers::{command, direction, errors, errors_scale, exposure, filmstrip, keys, presets, scene, spectrum, sun};

/// The functions as a page calls them.
#[cfg(target_arch = "wasm32")]
mod door {
    use wasm_bindgen::prelude::wasm_bindgen;

    use super::answers;

    type Answer = Result<String, String>;

    #[wasm_bindgen(start, private)]
    fn start() {
        console_error_panic_hook::set_once();
    }

    /// The version of sorairo.
    #[wasm_bindgen]
    pub fn version() -> String {
        env!("CARGO_PKG_VERSION").into()
    }

    /// JSON: every key of a scene with its description, unit, kind, default, minimum, maximum, and choices with their
    /// descriptions.
    #[wasm_bindgen]
    pub fn keys() -> String {
        answers::keys()
    }

    /// JSON: the names of the presets.
    #[wasm_bindgen]
    pub fn presets() -> String {
        answers::presets()
    }

    /// JSON: the value of every key of a scene.
    #[wasm_bindgen]
    pub fn scene(toml: &str) -> Answer {
        answers::scene(toml).map_err(|error| error.to_string())
    }

    /// JSON: `elevation` and `azimuth` of the sun (degrees); `instant` if the scene has a time.
    #[wasm_bindgen]
    pub fn sun(toml: &str) -> Answer {
        answers::sun(toml).map_err(|error| error.to_string())
    }

    /// JSON: moments of the scene's day, each with `label`, `elevation`, `azimuth` (degrees), and `time` if the scene
    /// has a place.
    #[wasm_bindgen]
    pub fn filmstrip(toml: &str) -> Answer {
        answers::filmstrip(toml).map_err(|error| error.to_string())
    }

    /// The exposure (stops) for a camera's EV100; also the inverse.
    #[wasm_bindgen]
    pub fn stops_of_ev100(ev100: f64) -> f64 {
        sorairo::scene::stops_of_ev100(ev100)
    }

    /// The shell command for the same picture.
    #[wasm_bindgen]
    pub fn command(toml: &str) -> Answer {
        answers::command(toml).map_err(|error| error.to_string())
    }

    /// The exposure of the picture (stops): that of the scene, or the result of `auto` or `adapt`.
    #[wasm_bindgen]
    pub fn exposure(toml: &str) -> Result<f32, String> {
        answers::exposure(toml).map_err(|error| error.to_string())
    }

    /// JSON: `azimuth` and `elevation` (degrees) of a pixel, counted from the top left; null outside the projection.
    #[wasm_bindgen]
    pub fn direction(toml: &str, column: u32, row: u32) -> Answer {
        answers::direction(toml, column, row).map_err(|error| error.to_string())
    }

    /// JSON: `wavelengths_nm`, `radiance` (W·m⁻²·sr⁻¹·nm⁻¹), `sun` (its irradiance at the top of the atmosphere,
    /// W·m⁻²·nm⁻¹), `xyz`, `xy`, `luminance_cd_m2` and `colour_temperature_k` in a direction (degrees).
    #[wasm_bindgen]
    pub fn spectrum(toml: &str, azimuth: f64, elevation: f64) -> Answer {
        answers::spectrum(toml, azimuth, elevation).map_err(|error| error.to_string())
    }

    /// RGBA: a map of the colour error of a fit, relative to the integral at every wavelength.
    #[wasm_bindgen]
    pub fn errors(toml: &str, fit: &str) -> Result<Vec<u8>, String> {
        answers::errors(toml, fit).map_err(|error| error.to_string())
    }

    /// JSON: the colour scale of that map.
    #[wasm_bindgen]
    pub fn errors_scale() -> String {
        answers::errors_scale()
    }
}
