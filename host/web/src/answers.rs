//! The answers to a page's questions, in JSON.

use serde_json::{Map, Value, json};
use sorairo::scene::filmstrip::{Moment, filmstrip as moments};
use sorairo::scene::keys::{Allowed, KEYS, Key};
use sorairo::scene::{Fit, Polarisation, Preset, Rgb, ValidScene};
use sorairo::words::{Word, words};
use sorairo::{Device, Direction, Error, Image, PixelFormat, Plan, Result, Scene, Sky, StokesFrame, observer};

use crate::skies::{read, read_for_canvas, sky};

/// Every key of a scene: its sentence, its unit, what it may be and what holds without it.
pub fn keys() -> String {
    Value::from_iter(KEYS.iter().map(described)).to_string()
}

fn described(key: &Key) -> Value {
    let scene = Scene::default();
    let bounds = key.bounds(&scene);
    let words = key.words();
    let each =
        |of: fn(&Word) -> &'static str| Some(words.iter().map(of).collect::<Vec<_>>()).filter(|all| !all.is_empty());
    let value = value(key, &scene);
    let kind = match &key.allowed {
        Allowed::Range { .. } => "number",
        Allowed::Words(_) => "choice",
        Allowed::Other(_) if value.is_boolean() => "boolean",
        _ => "text",
    };
    json!({
        "key": key.name,
        "sentence": key.sentence(),
        "unit": Some(key.unit).filter(|unit| !unit.is_empty()),
        "kind": kind,
        "default": if value.is_null() { key.stand_in().into() } else { value },
        "minimum": bounds.map(|(low, _)| low),
        "maximum": bounds.map(|(_, high)| high),
        "choices": each(|word| word.name),
        "choice_sentences": each(|word| word.sentence),
    })
}

/// The value of a key in a scene; null where it has none.
fn value(key: &Key, scene: &Scene) -> Value {
    serde_json::to_value(key.value(scene)).expect("a value is plain data")
}

/// The names of the presets.
pub fn presets() -> String {
    Value::from_iter(words::<Preset>().iter().map(|word| word.name)).to_string()
}

/// The value of every key of a scene.
///
/// # Errors
///
/// What is wrong with the scene.
pub fn scene(toml: &str) -> Result<String> {
    let scene = read(toml)?.as_asked();
    let values: Map<String, Value> = KEYS.iter().map(|key| (key.name.into(), value(key, &scene))).collect();
    Ok(Value::from(values).to_string())
}

/// Where the sun stands (degrees), and the time that puts it there if one does.
///
/// # Errors
///
/// What is wrong with the scene.
pub fn sun(toml: &str) -> Result<String> {
    let scene = read(toml)?;
    let (sun, instant) = (&scene.sun, scene.as_asked().sun.time);
    Ok(json!({ "elevation": sun.elevation, "azimuth": sun.azimuth, "instant": instant }).to_string())
}

/// The moments of the scene's day that stand in a strip, each with its words, its time if it has one, and its sun
/// (degrees).
///
/// # Errors
///
/// What is wrong with the scene.
pub fn filmstrip(toml: &str) -> Result<String> {
    let described = |moment: Moment| {
        let Moment { time, sun } = moment;
        json!({ "label": moment.label(), "time": time, "elevation": sun.elevation, "azimuth": sun.azimuth })
    };
    Ok(Value::from_iter(moments(&read(toml)?.as_asked())?.into_iter().map(described)).to_string())
}

/// The command that renders the same picture.
///
/// # Errors
///
/// What is wrong with the scene.
pub fn command(toml: &str) -> Result<String> {
    Ok(sorairo::scene::command::command(&read(toml)?.as_asked(), "auto"))
}

/// The exposure of the picture (stops): the scene's own, or what `auto` and `adapt` amount to.
///
/// # Errors
///
/// What is wrong with the scene.
pub fn exposure(toml: &str) -> Result<f32> {
    let scene = read_for_canvas(toml)?;
    let plan = Plan::seen(&sky(&scene, Rgb::Srgb), &scene.camera, PixelFormat::Picture)?;
    Ok(plan.exposure())
}

/// The direction (degrees) of a pixel, counted from the top left; null where the projection covers nothing.
///
/// # Errors
///
/// What is wrong with the scene.
pub fn direction(toml: &str, column: u32, row: u32) -> Result<String> {
    let scene = read(toml)?;
    let is_inside = column < scene.camera.size.width && row < scene.camera.size.height;
    let direction = if is_inside { Direction::of_scene_pixel(&scene, column, row) } else { None };
    let found = direction.map(|Direction { elevation, azimuth }| json!({ "azimuth": azimuth, "elevation": elevation }));
    Ok(Value::from(found).to_string())
}

/// The wavelength (nm) whose polarisation is told.
const POLARISED_AT: f64 = 550.0;

/// The spectrum in a direction (degrees), by the fit, as `sorairo spectrum` prints it, beside that of the sun, and how
/// it looks.
///
/// # Errors
///
/// What is wrong with the scene or the direction.
pub fn spectrum(toml: &str, azimuth: f64, elevation: f64) -> Result<String> {
    let sky = sky(&read(toml)?, Rgb::Srgb);
    let (wavelengths, towards) = (observer::wavelengths(), [Direction::new(elevation, azimuth)]);
    let radiance = sky.radiance(&towards, &wavelengths)?.remove(0);
    let colour = sky.xyz(&towards)?.remove(0);
    let appearance = sky.appearance(&towards)?.remove(0);
    let is_natural = sky.scene().render.polarisation == Polarisation::Off;
    let stokes = || sky.stokes(&[POLARISED_AT], StokesFrame::Vertical)?.in_directions(&towards);
    let polarisation = if is_natural { None } else { Some(stokes()?[0][0]) };
    let optics = sky.scene().optics();
    let sun = |&wavelength: &f64| optics.solar_irradiance(wavelength);
    Ok(json!({
        "wavelengths_nm": wavelengths,
        "radiance": radiance,
        "sun": wavelengths.iter().map(sun).collect::<Vec<_>>(),
        "xyz": colour,
        "xy": appearance.x.zip(appearance.y).map(|(x, y)| [x, y]),
        "luminance_cd_m2": appearance.luminance_cd_m2,
        "colour_temperature_k": appearance.cct_k,
        "polarisation": polarisation,
    })
    .to_string())
}

/// The colours of an error map, each from a share of the pixel's luminance on.
const STEPS: [(f32, &str, [u8; 3]); 5] = [
    (0.0, "below 0.1 %", [0x1f, 0x3a, 0x5f]),
    (0.001, "from 0.1 %", [0x2a, 0x7f, 0x8e]),
    (0.005, "from 0.5 %", [0x7f, 0xb8, 0x6f]),
    (0.02, "from 2 %", [0xf0, 0xb4, 0x3c]),
    (0.1, "from 10 %", [0xc8, 0x32, 0x2d]),
];

/// What the colours of an error map mean.
pub fn errors_scale() -> String {
    let step = |(_, label, [red, green, blue]): &(f32, &str, [u8; 3])| json!({ "label": label, "color": format!("#{red:02x}{green:02x}{blue:02x}") });
    let sentence = "Largest difference of linear red, green or blue from the sky integrated at every wavelength, beside the pixel's luminance";
    json!({ "sentence": sentence, "steps": STEPS.iter().map(step).collect::<Vec<_>>() }).to_string()
}

/// How far a picture by a fit lies from that of the dense integral, pixel by pixel: red, green, blue and opacity, in
/// the colours of [`errors_scale`].
///
/// # Errors
///
/// What is wrong with the scene, or with its fit.
pub fn errors(toml: &str, fit: &str) -> Result<Vec<u8>> {
    let fit = fit.parse().map_err(|_| {
        let names: Vec<_> = words::<Fit>().iter().map(|word| word.name).collect();
        Error::not_allowed("render.fit", format!("is {fit:?}; allowed: {}", names.join(", ")))
    })?;
    let scene = read(toml)?;
    let (by_fit, dense) = (linear(&scene, fit)?, linear(&scene, Fit::Dense)?);
    let luminance = dense.luminance_weights().map(|weight| weight as f32);
    let pixels = by_fit.rgb.chunks_exact(3).zip(dense.rgb.chunks_exact(3));
    Ok(pixels.flat_map(|(fitted, dense)| colour(fitted, dense, luminance)).collect())
}

/// A scene's image by a fit at the fit's own bands.
fn linear(scene: &ValidScene, fit: Fit) -> Result<Image> {
    let mut scene = scene.as_asked();
    if scene.render.fit != fit {
        scene.render.bands = None;
    }
    scene.render.fit = fit;
    scene.render.rgb = Default::default();
    Sky::new(&scene)?.image(&scene.camera, &mut Device::open("cpu")?)
}

/// The colour of an error; none where there is no light.
fn colour(fitted: &[f32], dense: &[f32], luminance: [f32; 3]) -> [u8; 4] {
    let light: f32 = dense.iter().zip(luminance).map(|(value, weight)| value * weight).sum();
    if light <= 0.0 {
        return [0; 4];
    }
    let differences = || fitted.iter().zip(dense).map(|(fitted, dense)| (fitted - dense).abs());
    let reached = |from: f32| differences().any(|difference| difference >= from * light);
    let step = STEPS.iter().rev().find(|(from, ..)| reached(*from)).unwrap_or(&STEPS[0]);
    let [red, green, blue] = step.2;
    [red, green, blue, 255]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skies::planned;

    fn json(text: &str) -> Value {
        serde_json::from_str(text).unwrap()
    }

    #[test]
    fn every_key_of_a_scene_has_a_value_in_its_range() {
        let values = json(&scene("").unwrap());
        for key in json(&keys()).as_array().unwrap() {
            let value = &values[key["key"].as_str().unwrap()];
            if let (Some(value), Some(low), Some(high)) =
                (value.as_f64(), key["minimum"].as_f64(), key["maximum"].as_f64())
            {
                assert!((low..=high).contains(&value), "{key}: {value}");
            }
        }
        assert_eq!(values["sun.elevation"], 30.0);
    }

    #[test]
    fn a_darker_sky_is_exposed_longer_and_a_number_is_that_number() {
        assert!(exposure("sun.elevation = -4").unwrap() > exposure("sun.elevation = 40").unwrap() + 5.0);
        assert_eq!(exposure("render.exposure = -3.0").unwrap(), -3.0);
    }

    #[test]
    fn every_choice_has_a_sentence() {
        for key in json(&keys()).as_array().unwrap() {
            let count = |name: &str| key[name].as_array().map(Vec::len);
            assert_eq!(count("choices"), count("choice_sentences"), "{key}");
        }
    }

    #[test]
    fn outside_of_a_fisheye_there_is_no_direction() {
        let fisheye = "camera.projection = \"fisheye\"\ncamera.size = \"65x65\"";
        assert_eq!(json(&direction(fisheye, 0, 0).unwrap()), Value::Null);
        assert_eq!(json(&direction(fisheye, 65, 32).unwrap()), Value::Null);
        let zenith = json(&direction(fisheye, 32, 32).unwrap());
        assert!(zenith["elevation"].as_f64().unwrap() > 89.9, "{zenith}");
    }

    #[test]
    fn what_a_page_asks_at_every_movement_of_a_hand_plans_no_sky() {
        let twilight = "sun.elevation = -4\ncamera.projection = \"perspective\"";
        let asks = || {
            for answer in [scene, sun, command, filmstrip, |toml: &str| direction(toml, 0, 0)] {
                answer(twilight).unwrap();
                assert_eq!(planned(), 0);
            }
            exposure(twilight).unwrap();
            assert_eq!(planned(), 1);
        };
        // A thread of its own knows no sky of another test.
        std::thread::scope(|scope| scope.spawn(asks).join().unwrap());
    }

    #[test]
    fn the_integral_itself_has_no_error_and_the_papers_cubic_has_one_at_sunset() {
        let sunset = "sun.elevation = 0.0\ncamera.size = \"16x8\"";
        let map = |fit| errors(sunset, fit).unwrap();
        let colours = |fit| map(fit).chunks_exact(4).filter(|pixel| pixel[..3] != STEPS[0].2 && pixel[3] != 0).count();
        assert_eq!(colours("dense"), 0);
        assert!(colours("cubic") > 8);
    }

    #[test]
    fn what_is_not_allowed_is_told_in_a_sentence() {
        assert!(scene("sun.elevation = 100").unwrap_err().to_string().contains("between -90 and 90"));
        assert!(errors("", "best").unwrap_err().to_string().contains("allowed: "));
        assert!(spectrum("", 0.0, 91.0).unwrap_err().to_string().contains("between -90 and 90"));
    }
}
