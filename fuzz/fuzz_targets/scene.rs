//! Any bytes as a scene file: refused in one sentence, or a scene whose values are checked and that survives its own
//! file.

#![no_main]

use libfuzzer_sys::fuzz_target;
use sorairo::scene::Scene;

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match Scene::parse(text, "scene.toml", None) {
        Ok(scene) => {
            if let Ok(scene) = scene.validated() {
                let again = Scene::parse(&sorairo::scene::file::text(&scene), "again.toml", None);
                assert_eq!(again.expect("a scene's own file is a scene"), *scene);
            }
        }
        Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
    }
});
