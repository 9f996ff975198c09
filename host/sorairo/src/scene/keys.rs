//! The keys of a scene: one row each, with its flag, its unit, what it may be, and what stands in for it. `validate`, the help of the flags, the
//! reference page and the commented scene file are all made from these rows; a key's sentence is the doc comment of its field.

use std::sync::OnceLock;

use documented::DocumentedFields;

use super::camera::{CameraScene, LONGEST_SIDE, Projection};
use super::place::PlaceAndTime;
use super::preset::{Preset, Scene};
use super::settings::{ColorPath, Exposure, ExrDepth, Fit, MOST_STOPS, PathChoice, Render, Rgb, WhiteBalance};
use super::sky::{Aerosol, Air, AtmosphereScene, Observer, Ozone, Sun};
use crate::error::{Error, Result};
use crate::input::shown;
use crate::spectra::choice::{AlbedoSpectrum, OzoneCrossSection, SunSpectrum};
use crate::spectra::observer::ColorObserver;
use crate::words::{Word, words};

/// One key of a scene file.
pub struct Key {
    /// Its name with its tables, as in `sun.elevation`.
    pub name: &'static str,
    /// The flag that takes its place.
    pub flag: Option<&'static str>,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// What it may be.
    pub allowed: Allowed,
    /// What stands in for a key that is not given, where that is not one value.
    pub otherwise: &'static str,
    /// What is wrong with it in a scene, beyond `allowed`.
    rule: Option<fn(&Scene) -> Option<String>>,
}

/// What a key may be.
pub enum Allowed {
    /// A number in a range.
    Range {
        /// The number in a scene, if the scene has one that matters.
        value: fn(&Scene) -> Option<f64>,
        /// The smallest that is allowed.
        low: Bound,
        /// The largest that is allowed.
        high: Bound,
    },
    /// One of some words, each with its sentence.
    Words(fn() -> Vec<Word>),
    /// One of some words, or the name of a CSV file.
    WordsOrTable(fn() -> Vec<Word>),
    /// Something else, said in words.
    Other(&'static str),
}

/// An end of a range.
pub enum Bound {
    /// A number.
    At(f64),
    /// What follows from other keys, and how to say it.
    From(fn(&Scene) -> f64, &'static str),
}

/// A key whose value is not allowed.
pub struct Violation {
    /// The key.
    pub key: &'static Key,
    /// What follows its name: the value, and what is allowed.
    pub complaint: String,
}

/// Bands closer than this (nm) make the fit's matrix singular in practice.
pub const CLOSEST_BANDS: f64 = 0.5;

use Bound::{At, From};

// Column densities are closed forms for scale heights up to a hundredth of the radius; where the atmosphere ends within one scale
// height, a column to its top is the small difference of two of them.
const THICKEST: Bound = From(
    |s| (s.atmosphere.ground_radius / 100.0).min(s.atmosphere.top_radius - s.atmosphere.ground_radius),
    "a hundredth of the ground radius and the depth of the atmosphere",
);
const DEPTH: Bound = From(|s| s.atmosphere.top_radius - s.atmosphere.ground_radius, "the depth of the atmosphere");

/// A number of the ozone layer, which matters where there is ozone.
fn of_ozone(scene: &Scene, value: fn(&Ozone) -> f64) -> Option<f64> {
    let ozone = &scene.atmosphere.ozone;
    (ozone.column > 0.0).then(|| value(ozone))
}

/// Every key, table by table.
pub static KEYS: &[Key] = &[
    Key::other("preset", Allowed::Words(words::<Preset>)).flag("--preset"),
    Key::number("sun.elevation", "degrees", |s| Some(s.sun.elevation), At(-90.0), At(90.0)).flag("--sun-elevation"),
    Key::number("sun.azimuth", "degrees", |s| Some(s.sun.azimuth), At(-360.0), At(360.0)).flag("--sun-azimuth"),
    Key::other("sun.place", Allowed::Other("\"LATITUDE,LONGITUDE\", -90 to 90 north, -180 to 180 east"))
        .unit("degrees")
        .flag("--place")
        .otherwise("`elevation` and `azimuth` hold"),
    Key::other("sun.time", Allowed::Other("RFC 3339 with an offset, such as \"2026-06-21T04:30:00+09:00\""))
        .flag("--time")
        .otherwise("`elevation` and `azimuth` hold"),
    Key::other("sun.spectrum", Allowed::WordsOrTable(words::<SunSpectrum>)),
    Key::number("sun.distance", "au", |s| Some(s.sun.distance), At(0.01), At(1000.0)),
    Key::other("sun.disc", Allowed::Other("true or false; with a disc the distance is at most 50 au"))
        .flag("--sun-disc")
        .rule(disc_too_small),
    Key::number("observer.altitude", "km", |s| Some(s.observer.altitude), At(0.0), At(1e5)).flag("--altitude"),
    // In single precision a horizon is as sharp as 6e-8 of the radius, which must lie far below the scale heights.
    Key::number("atmosphere.ground_radius", "km", |s| Some(s.atmosphere.ground_radius), At(10.0), At(1e5)),
    Key::number(
        "atmosphere.top_radius",
        "km",
        |s| Some(s.atmosphere.top_radius),
        From(|s| s.atmosphere.ground_radius + 1.0, "1 above the ground"),
        // The column of a layer of ozone is a closed form for heights well below the radius; of the thickest profile, e⁻²⁰ is left there.
        From(
            |s| s.atmosphere.ground_radius + (0.2 * s.atmosphere.ground_radius).min(1e4),
            "10000 km or a fifth of the ground radius above the ground",
        ),
    )
    .rule(opaque_at_its_top),
    Key::number("atmosphere.air.scattering", "km⁻¹", |s| Some(s.atmosphere.air.scattering), At(0.0), At(100.0)),
    Key::number("atmosphere.air.scale_height", "km", |s| Some(s.atmosphere.air.scale_height), At(0.05), THICKEST),
    Key::number(
        "atmosphere.aerosol.optical_depth",
        "",
        |s| Some(s.atmosphere.aerosol.optical_depth),
        At(0.0),
        At(1000.0),
    ),
    Key::number(
        "atmosphere.aerosol.angstrom_exponent",
        "",
        |s| Some(s.atmosphere.aerosol.angstrom_exponent),
        At(-5.0),
        At(5.0),
    ),
    Key::number(
        "atmosphere.aerosol.scale_height",
        "km",
        |s| Some(s.atmosphere.aerosol.scale_height),
        At(0.05),
        THICKEST,
    ),
    Key::number(
        "atmosphere.aerosol.single_scattering_albedo",
        "",
        |s| Some(s.atmosphere.aerosol.single_scattering_albedo),
        At(0.0),
        At(1.0),
    ),
    Key::other(
        "atmosphere.aerosol.single_scattering_albedo_spectrum",
        Allowed::WordsOrTable(words::<AlbedoSpectrum>),
    )
    .rule(albedo_above_1),
    Key::number(
        "atmosphere.aerosol.asymmetry",
        "",
        |s| Some(s.atmosphere.aerosol.asymmetry),
        At(-0.99),
        At(0.99),
    ),
    // Behind a layer that is opaque itself, the samples of a ray would have to follow every edge of its tent.
    Key::number("atmosphere.ozone.column", "Dobson units", |s| Some(s.atmosphere.ozone.column), At(0.0), At(2e3)),
    Key::number("atmosphere.ozone.bottom", "km", |s| of_ozone(s, |ozone| ozone.bottom), At(0.0), DEPTH),
    Key::number(
        "atmosphere.ozone.peak",
        "km",
        |s| of_ozone(s, |ozone| ozone.peak),
        From(|s| s.atmosphere.ozone.bottom + 0.1, "0.1 above `bottom`"),
        DEPTH,
    ),
    Key::number(
        "atmosphere.ozone.top",
        "km",
        |s| of_ozone(s, |ozone| ozone.top),
        From(|s| s.atmosphere.ozone.peak + 0.1, "0.1 above `peak`"),
        DEPTH,
    ),
    Key::other("atmosphere.ozone.cross_section", Allowed::WordsOrTable(words::<OzoneCrossSection>)),
    Key::other("camera.projection", Allowed::Words(words::<Projection>)).flag("--projection"),
    Key::other("camera.size", Allowed::Other("\"WIDTHxHEIGHT\", each 1 to 8388608"))
        .unit("pixels")
        .flag("--size")
        .rule(size_out_of_range),
    Key::number(
        "camera.fov",
        "degrees",
        |s| s.camera.fov,
        At(0.01),
        From(|s| if s.camera.projection == Projection::Perspective { 170.0 } else { 360.0 }, "360 (perspective: 170)"),
    )
    .flag("--fov")
    .otherwise("fisheye 180, perspective 60"),
    Key::number("camera.look_azimuth", "degrees", |s| s.camera.look_azimuth, At(-360.0), At(360.0))
        .flag("--look-azimuth")
        .otherwise("0, north; fisheye 180, which puts north on top"),
    Key::number("camera.look_elevation", "degrees", |s| s.camera.look_elevation, At(-90.0), At(90.0))
        .flag("--look-elevation")
        .otherwise("fisheye 90, perspective 15"),
    Key::other("render.fit", Allowed::Words(words::<Fit>)).flag("--fit"),
    Key::other(
        "render.bands",
        Allowed::Other(
            "360 to 830, at least 0.5 apart; 3 to 8 with `extinction`, 3 to 12 with `cubic` and `transfer`, 2 to 512 with \
             `dense`, 4 with `color = \"solve\"`",
        ),
    )
    .unit("nm")
    .flag("--bands")
    .otherwise("the best found for the fit")
    .rule(unfit_bands),
    Key::other("render.color", Allowed::Words(words::<ColorPath>)).flag("--color").rule(nothing_to_solve),
    Key::number("render.steps", "samples", |s| s.render.steps.map(f64::from), At(1.0), At(1024.0))
        .flag("--steps")
        .otherwise("what the scene's rays need: from the Earth's ground 12, with the sun below 5° 48 to 64"),
    Key::other("render.path", Allowed::Words(words::<PathChoice>)).flag("--path"),
    Key::number(
        "render.exposure",
        "stops",
        |s| match s.render.exposure {
            Exposure::Auto => None,
            Exposure::Stops(stops) => Some(stops),
        },
        At(-MOST_STOPS),
        At(MOST_STOPS),
    )
    .flag("--exposure")
    .otherwise("\"auto\", from the mean luminance of the sky"),
    Key::other("render.exr", Allowed::Words(words::<ExrDepth>)).flag("--exr"),
    Key::other("render.rgb", Allowed::Words(words::<Rgb>)).flag("--rgb"),
    Key::other("render.observer", Allowed::Words(words::<ColorObserver>)).flag("--observer"),
    Key::other("render.white_balance", Allowed::Words(words::<WhiteBalance>)).flag("--white-balance"),
];

impl Key {
    const fn other(name: &'static str, allowed: Allowed) -> Self {
        Self { name, flag: None, unit: "", allowed, otherwise: "", rule: None }
    }

    const fn number(
        name: &'static str,
        unit: &'static str,
        value: fn(&Scene) -> Option<f64>,
        low: Bound,
        high: Bound,
    ) -> Self {
        Self { name, flag: None, unit, allowed: Allowed::Range { value, low, high }, otherwise: "", rule: None }
    }

    const fn flag(mut self, flag: &'static str) -> Self {
        self.flag = Some(flag);
        self
    }

    const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    const fn otherwise(mut self, otherwise: &'static str) -> Self {
        self.otherwise = otherwise;
        self
    }

    const fn rule(mut self, rule: fn(&Scene) -> Option<String>) -> Self {
        self.rule = Some(rule);
        self
    }

    /// The tables that the key lies in, and its name in them.
    pub fn table_and_name(&self) -> (&'static str, &'static str) {
        self.name.rsplit_once('.').unwrap_or(("", self.name))
    }

    /// What the key means, as the doc comment of its field says it.
    pub fn sentence(&self) -> String {
        let (table, name) = self.table_and_name();
        let docs = match table {
            "" => Scene::get_field_docs(name),
            "sun" => Sun::get_field_docs(name).or_else(|_| PlaceAndTime::get_field_docs(name)),
            "observer" => Observer::get_field_docs(name),
            "atmosphere" => AtmosphereScene::get_field_docs(name),
            "atmosphere.air" => Air::get_field_docs(name),
            "atmosphere.aerosol" => Aerosol::get_field_docs(name),
            "atmosphere.ozone" => Ozone::get_field_docs(name),
            "camera" => CameraScene::get_field_docs(name),
            _ => Render::get_field_docs(name),
        };
        docs.expect("every key is a documented field").replace('\n', " ")
    }

    /// The value in a scene, as it stands in a file.
    pub fn value(&self, scene: &toml::Table) -> Option<toml::Value> {
        let (table, name) = self.table_and_name();
        let tables = table.split('.').filter(|part| !part.is_empty());
        let table = tables.into_iter().try_fold(scene, |table, part| table.get(part)?.as_table())?;
        table.get(name).cloned()
    }

    /// The smallest and the largest number that the key may be in a scene; `None` if it is not a number.
    pub fn bounds(&self, scene: &Scene) -> Option<(f64, f64)> {
        match &self.allowed {
            Allowed::Range { low, high, .. } => Some((low.of(scene), high.of(scene))),
            _ => None,
        }
    }

    /// What the key may be, in words.
    pub fn range(&self) -> String {
        match &self.allowed {
            Allowed::Range { low, high, .. } => format!("{} to {}", low.words(), high.words()),
            Allowed::Words(words) => listed(&words()),
            Allowed::WordsOrTable(words) => format!("{}, or the name of a .csv file", listed(&words())),
            Allowed::Other(words) => (*words).into(),
        }
    }

    /// What holds without the key.
    pub fn default_words(&self) -> String {
        if !self.otherwise.is_empty() {
            return self.otherwise.into();
        }
        match self.value(default_scene()) {
            Some(toml::Value::String(word)) => word,
            Some(value) => plain(&value),
            None => String::new(),
        }
    }

    fn out_of_range(&self, scene: &Scene) -> Option<String> {
        match &self.allowed {
            Allowed::Range { value, low, high } => {
                value(scene).and_then(|value| out_of_range(value, low.of(scene), high.of(scene), self.unit))
            }
            _ => None,
        }
    }

    fn violation(&'static self, scene: &Scene) -> Option<Violation> {
        let complaint = self.out_of_range(scene).or_else(|| self.rule.and_then(|rule| rule(scene)))?;
        Some(Violation { key: self, complaint })
    }
}

impl Bound {
    fn of(&self, scene: &Scene) -> f64 {
        match self {
            At(value) => *value,
            From(value, _) => value(scene),
        }
    }

    fn words(&self) -> String {
        match self {
            At(value) => value.to_string(),
            From(_, words) => (*words).into(),
        }
    }
}

impl Violation {
    /// One sentence that names the flag and the key.
    pub fn as_request(&self) -> String {
        let Self { key, complaint } = self;
        match key.flag {
            Some(flag) => format!("{flag} ({}) {complaint}", key.name),
            None => format!("{} {complaint}", key.name),
        }
    }
}

/// The key of a name.
pub fn find(name: &str) -> Option<&'static Key> {
    KEYS.iter().find(|key| key.name == name)
}

/// The help of a flag, from its key.
///
/// # Panics
///
/// If there is no such key.
pub fn help(name: &str) -> String {
    let key = find(name).expect("the flag of a key");
    format!("{} [default: {}]", key.sentence().trim_end_matches('.'), key.default_words())
}

impl Scene {
    /// Whether every value lies in its range.
    ///
    /// # Errors
    ///
    /// [`Error::Request`] that names the first key (and flag) out of range, its value, and what is allowed.
    pub fn validate(&self) -> Result<()> {
        match violations(self).first() {
            Some(violation) => Err(Error::request(violation.as_request())),
            None => Ok(()),
        }
    }
}

/// What is wrong with a scene, key by key.
pub fn violations(scene: &Scene) -> Vec<Violation> {
    KEYS.iter().filter_map(|key| key.violation(scene)).collect()
}

/// A number as a person writes it.
pub fn plain(value: &toml::Value) -> String {
    match value {
        toml::Value::Float(number) => number.to_string(),
        other => other.to_string(),
    }
}

/// The default scene as a file holds it.
pub fn default_scene() -> &'static toml::Table {
    static SCENE: OnceLock<toml::Table> = OnceLock::new();
    SCENE.get_or_init(|| toml::Table::try_from(Scene::default()).expect("a scene is a table"))
}

fn listed(words: &[Word]) -> String {
    words.iter().map(|word| format!("`{}`", word.name)).collect::<Vec<_>>().join(", ")
}

/// Checks one value against its range; NaN is out of every range.
fn out_of_range(value: f64, low: f64, high: f64, unit: &str) -> Option<String> {
    let space = if unit.is_empty() { "" } else { " " };
    let allowed = (low..=high).contains(&value);
    let [value, low, high] = [value, low, high].map(shown);
    (!allowed).then(|| format!("is {value}; it must lie between {low} and {high}{space}{unit}"))
}

fn size_out_of_range(scene: &Scene) -> Option<String> {
    let size = scene.camera.size;
    (!size.is_allowed()).then(|| format!("is {size}; each side must lie between 1 and {LONGEST_SIDE} pixels"))
}

/// The largest optical depth, on a level ray and at the shortest wavelength, of what the atmosphere's top cuts off.
///
/// A denser top is an edge: the level sun lights the air within metres of it, and an altitude in single precision has no digits for them.
pub const DENSEST_TOP: f64 = 20.0;

/// What the optical depth above the top follows from.
const OF_THE_TOP: [&str; 6] = [
    "atmosphere.ground_radius",
    "atmosphere.air.scattering",
    "atmosphere.air.scale_height",
    "atmosphere.aerosol.optical_depth",
    "atmosphere.aerosol.angstrom_exponent",
    "atmosphere.aerosol.scale_height",
];

fn opaque_at_its_top(scene: &Scene) -> Option<String> {
    // Where one of them is out of its range, that is what is wrong.
    if OF_THE_TOP.iter().any(|name| find(name).expect("a key").out_of_range(scene).is_some()) {
        return None;
    }
    let depth = scene.optics().depth_above_top();
    (depth > DENSEST_TOP).then(|| {
        format!(
            "is {}, where the air is opaque still: what would lie above has an optical depth of {depth:.0} on a level ray, and at most \
             {DENSEST_TOP} may be cut off",
            shown(scene.atmosphere.top_radius)
        )
    })
}

/// Farther away (au) the disc is smaller than single precision can place it.
pub const FARTHEST_DISC: f64 = 50.0;

fn disc_too_small(scene: &Scene) -> Option<String> {
    let distance = scene.sun.distance;
    (scene.sun.disc && distance > FARTHEST_DISC)
        .then(|| format!("is true with sun.distance {}; a disc is shown up to {FARTHEST_DISC} au", shown(distance)))
}

fn albedo_above_1(scene: &Scene) -> Option<String> {
    let file = scene.atmosphere.aerosol.single_scattering_albedo_spectrum.file()?;
    let (albedo, wavelength) = file.table().largest(0);
    let name = file.path().display();
    (albedo > 1.0).then(|| {
        format!("is {name}, which holds {} at {} nm; an albedo is at most 1", shown(albedo), shown(wavelength))
    })
}

fn nothing_to_solve(scene: &Scene) -> Option<String> {
    (scene.render.fit == Fit::Dense && scene.render.color == ColorPath::Solve)
        .then(|| "is solve; --color solve needs a fit to solve, and --fit dense has none".into())
}

/// The fewest and the most bands that a fit takes.
pub fn band_counts(fit: Fit, color: ColorPath) -> (usize, usize) {
    match (fit, color) {
        (Fit::Dense, _) => (2, 512),
        (_, ColorPath::Solve) => (4, 4),
        (Fit::Extinction, ColorPath::Folded) => (3, 8),
        (Fit::Cubic | Fit::Transfer, ColorPath::Folded) => (3, 12),
    }
}

fn unfit_bands(scene: &Scene) -> Option<String> {
    let bands = scene.render.bands.as_ref()?;
    let (fewest, most) = band_counts(scene.render.fit, scene.render.color);
    let count = bands.len();
    if !(fewest..=most).contains(&count) {
        return Some(format!("holds {count} wavelengths; this fit takes {fewest} to {most} of them"));
    }
    let (shortest, longest) = scene.optics().known_wavelengths();
    if let Some(complaint) = bands.iter().find_map(|&band| out_of_range(band, shortest, longest, "nm")) {
        return Some(complaint);
    }
    let mut sorted = bands.clone();
    sorted.sort_by(f64::total_cmp);
    let pair = sorted.windows(2).find(|pair| pair[1] - pair[0] < CLOSEST_BANDS)?;
    Some(format!("holds {} and {}; bands must lie at least {CLOSEST_BANDS} nm apart", pair[0], pair[1]))
}

#[cfg(test)]
mod tests {
    use strum::IntoEnumIterator;

    use super::*;

    #[test]
    fn every_field_of_a_scene_is_a_key() {
        let fields: [(&str, &[&str]); 10] = [
            ("sun", Sun::FIELD_NAMES),
            ("sun", PlaceAndTime::FIELD_NAMES),
            ("observer", Observer::FIELD_NAMES),
            ("atmosphere", AtmosphereScene::FIELD_NAMES),
            ("atmosphere.air", Air::FIELD_NAMES),
            ("atmosphere.aerosol", Aerosol::FIELD_NAMES),
            ("atmosphere.ozone", Ozone::FIELD_NAMES),
            ("camera", CameraScene::FIELD_NAMES),
            ("render", Render::FIELD_NAMES),
            ("", Scene::FIELD_NAMES),
        ];
        let is_table = |name: &str| KEYS.iter().any(|key| key.name.starts_with(&format!("{name}.")));
        let mut names: Vec<String> = fields
            .iter()
            .flat_map(|(table, fields)| fields.iter().map(move |field| format!("{table}.{field}")))
            .map(|name| name.trim_start_matches('.').to_owned())
            .filter(|name| !is_table(name))
            .collect();
        let mut keys: Vec<_> = KEYS.iter().map(|key| key.name.to_owned()).collect();
        names.sort();
        keys.sort();
        assert_eq!(keys, names);
    }

    #[test]
    fn every_key_has_a_sentence_a_default_and_a_range() {
        for key in KEYS {
            let texts = [key.sentence(), key.default_words(), key.range()];
            assert!(texts.iter().all(|text| !text.is_empty()), "{}: {texts:?}", key.name);
        }
    }

    #[test]
    fn every_preset_is_allowed() {
        for preset in Preset::iter() {
            assert!(Scene::preset(preset).validate().is_ok(), "{preset:?}");
        }
    }

    #[test]
    fn a_value_out_of_range_is_named_with_what_is_allowed() {
        let mut scene = Scene::default();
        scene.sun.elevation = 100.0;
        let error = scene.validate().unwrap_err().to_string();
        assert!(error.contains("--sun-elevation") && error.contains("100") && error.contains("90"), "{error}");
        scene.sun.elevation = f64::NAN;
        assert!(scene.validate().is_err());
    }
}
