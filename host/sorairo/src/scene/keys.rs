//! The keys of a scene: one row each, with its unit, what it may be, and what stands in for it. `validate`, the help of the flags, the
//! reference page and the commented scene file are all made from these rows; a key's sentence is the doc comment of its field.

use std::sync::OnceLock;

use documented::DocumentedFields;

use super::camera::{CameraScene, LONGEST_SIDE, Projection};
use super::place::PlaceAndTime;
use super::preset::{Preset, Scene};
use super::settings::{ColourPath, Exposure, ExrDepth, Fit, MOST_STOPS, PathChoice, Render, Rgb, WhiteBalance};
use super::sky::{Aerosol, Air, AtmosphereScene, Observer, Ozone, Sun};
use crate::error::{Error, Result, check_range};
use crate::input::shown;
use crate::spectra::choice::{AlbedoSpectrum, OzoneCrossSection, SunSpectrum};
use crate::spectra::observer::ColourObserver;
use crate::words::{Word, words};

/// One key of a scene file.
pub struct Key {
    /// Its name with its tables, as in `sun.elevation`.
    pub name: &'static str,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// What it may be.
    pub allowed: Allowed,
    /// What stands in for a key that is not given, where that is not one value.
    pub otherwise: &'static str,
    /// What is wrong with it in a scene, beyond `allowed`.
    rule: Option<fn(&Scene) -> Result<()>>,
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

/// Bands closer than this (nm) make the fit's matrix singular in practice.
pub const CLOSEST_BANDS: f64 = 0.5;

use Bound::{At, From};

// Column densities are closed forms for scale heights up to a hundredth of the radius; where the atmosphere ends within one scale
// height, a column density to its top is the small difference of two of them.
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
    Key::other("preset", Allowed::Words(words::<Preset>)),
    Key::number("sun.elevation", "degrees", |s| Some(s.sun.elevation), At(-90.0), At(90.0)),
    Key::number("sun.azimuth", "degrees", |s| Some(s.sun.azimuth), At(-360.0), At(360.0)),
    Key::other("sun.place", Allowed::Other("\"LATITUDE,LONGITUDE\", -90 to 90 north, -180 to 180 east"))
        .unit("degrees")
        .otherwise("`elevation` and `azimuth` hold"),
    Key::other("sun.time", Allowed::Other("RFC 3339 with an offset, such as \"2026-06-21T04:30:00+09:00\""))
        .otherwise("`elevation` and `azimuth` hold"),
    Key::other("sun.spectrum", Allowed::WordsOrTable(words::<SunSpectrum>)),
    Key::number("sun.distance", "au", |s| Some(s.sun.distance), At(0.01), At(1000.0)),
    Key::other("sun.disc", Allowed::Other("true or false; with a disc the distance is at most 50 au"))
        .rule(disc_too_small),
    Key::number("observer.altitude", "km", |s| Some(s.observer.altitude), At(0.0), At(1e5)),
    // In single precision a horizon is as sharp as 6e-8 of the radius, which must lie far below the scale heights.
    Key::number("atmosphere.ground_radius", "km", |s| Some(s.atmosphere.ground_radius), At(10.0), At(1e5)),
    Key::number(
        "atmosphere.top_radius",
        "km",
        |s| Some(s.atmosphere.top_radius),
        From(|s| s.atmosphere.ground_radius + 1.0, "1 above the ground"),
        // The column density of a layer of ozone is a closed form for heights well below the radius; of the thickest profile, e⁻²⁰ is left there.
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
    Key::other("camera.projection", Allowed::Words(words::<Projection>)),
    Key::other("camera.size", Allowed::Other("\"WIDTHxHEIGHT\", each 1 to 8388608"))
        .unit("pixels")
        .rule(size_out_of_range),
    Key::number(
        "camera.fov",
        "degrees",
        |s| s.camera.fov,
        At(0.01),
        From(|s| if s.camera.projection == Projection::Perspective { 170.0 } else { 360.0 }, "360 (perspective: 170)"),
    )
    .otherwise("fisheye 180, perspective 60"),
    Key::number("camera.look_azimuth", "degrees", |s| s.camera.look_azimuth, At(-360.0), At(360.0))
        .otherwise("0, north; fisheye 180, which puts north on top"),
    Key::number("camera.look_elevation", "degrees", |s| s.camera.look_elevation, At(-90.0), At(90.0))
        .otherwise("fisheye 90, perspective 15"),
    Key::other("render.fit", Allowed::Words(words::<Fit>)),
    Key::other(
        "render.bands",
        Allowed::Other(
            "360 to 830, at least 0.5 apart; 3 to 8 with `extinction`, 3 to 12 with `cubic` and `transfer`, 2 to 512 with \
             `dense`, 4 with `color = \"solve\"`",
        ),
    )
    .unit("nm")
    .otherwise("the best found for the fit")
    .rule(unfit_bands),
    Key::other("render.color", Allowed::Words(words::<ColourPath>)).rule(nothing_to_solve),
    Key::number("render.steps", "samples", |s| s.render.steps.map(f64::from), At(1.0), At(1024.0))
        .otherwise("what the scene's rays need: from the Earth's ground 12, with the sun below 5° 48 to 64"),
    Key::other("render.path", Allowed::Words(words::<PathChoice>)),
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
    .otherwise("\"auto\", from the mean luminance of the sky"),
    Key::other("render.exr", Allowed::Words(words::<ExrDepth>)),
    Key::other("render.rgb", Allowed::Words(words::<Rgb>)),
    Key::other("render.observer", Allowed::Words(words::<ColourObserver>)),
    Key::other("render.white_balance", Allowed::Words(words::<WhiteBalance>)),
];

impl Key {
    const fn other(name: &'static str, allowed: Allowed) -> Self {
        Self { name, unit: "", allowed, otherwise: "", rule: None }
    }

    const fn number(
        name: &'static str,
        unit: &'static str,
        value: fn(&Scene) -> Option<f64>,
        low: Bound,
        high: Bound,
    ) -> Self {
        Self { name, unit, allowed: Allowed::Range { value, low, high }, otherwise: "", rule: None }
    }

    const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    const fn otherwise(mut self, otherwise: &'static str) -> Self {
        self.otherwise = otherwise;
        self
    }

    const fn rule(mut self, rule: fn(&Scene) -> Result<()>) -> Self {
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

    fn check_range(&self, scene: &Scene) -> Result<()> {
        let Allowed::Range { value, low, high } = &self.allowed else { return Ok(()) };
        value(scene).map_or(Ok(()), |value| check_range(self.name, value, (low.of(scene), high.of(scene)), self.unit))
    }

    fn check(&self, scene: &Scene) -> Result<()> {
        self.check_range(scene)?;
        self.rule.map_or(Ok(()), |rule| rule(scene))
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
    /// [`Error::OutOfRange`] or [`Error::NotAllowed`] that names the first key that does not.
    pub fn validate(&self) -> Result<()> {
        problems(self).into_iter().next().map_or(Ok(()), Err)
    }
}

/// What is wrong with a scene, key by key.
pub fn problems(scene: &Scene) -> Vec<Error> {
    KEYS.iter().filter_map(|key| key.check(scene).err()).collect()
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

fn size_out_of_range(scene: &Scene) -> Result<()> {
    let size = scene.camera.size;
    if size.is_allowed() {
        return Ok(());
    }
    let complaint = format!("is {size}; each side must lie between 1 and {LONGEST_SIDE} pixels");
    Err(Error::not_allowed("camera.size", complaint))
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

fn opaque_at_its_top(scene: &Scene) -> Result<()> {
    // Where one of them is out of its range, that is what is wrong.
    if OF_THE_TOP.iter().any(|name| find(name).expect("a key").check_range(scene).is_err()) {
        return Ok(());
    }
    let depth = scene.optics().depth_above_top();
    if depth <= DENSEST_TOP {
        return Ok(());
    }
    let complaint = format!(
        "is {}, where the air is opaque still: what would lie above has an optical depth of {depth:.0} on a level ray, and at most \
         {DENSEST_TOP} may be cut off",
        shown(scene.atmosphere.top_radius)
    );
    Err(Error::not_allowed("atmosphere.top_radius", complaint))
}

/// Farther away (au) the disc is smaller than single precision can place it.
pub const FARTHEST_DISC: f64 = 50.0;

fn disc_too_small(scene: &Scene) -> Result<()> {
    let distance = scene.sun.distance;
    if !scene.sun.disc || distance <= FARTHEST_DISC {
        return Ok(());
    }
    let complaint = format!("is true with sun.distance {}; a disc is shown up to {FARTHEST_DISC} au", shown(distance));
    Err(Error::not_allowed("sun.disc", complaint))
}

fn albedo_above_1(scene: &Scene) -> Result<()> {
    let Some(file) = scene.atmosphere.aerosol.single_scattering_albedo_spectrum.file() else { return Ok(()) };
    let (albedo, wavelength) = file.table().largest(0);
    if albedo <= 1.0 {
        return Ok(());
    }
    let name = file.path().display();
    let complaint =
        format!("is {name}, which holds {} at {} nm; an albedo is at most 1", shown(albedo), shown(wavelength));
    Err(Error::not_allowed("atmosphere.aerosol.single_scattering_albedo_spectrum", complaint))
}

fn nothing_to_solve(scene: &Scene) -> Result<()> {
    if scene.render.fit != Fit::Dense || scene.render.color != ColourPath::Solve {
        return Ok(());
    }
    let complaint = "is solve; render.color = solve needs a fit to solve, and render.fit = dense has none";
    Err(Error::not_allowed("render.color", complaint))
}

/// The fewest and the most bands that a fit takes.
pub fn band_counts(fit: Fit, color: ColourPath) -> (usize, usize) {
    match (fit, color) {
        (Fit::Dense, _) => (2, 512),
        (_, ColourPath::Solve) => (4, 4),
        (Fit::Extinction, ColourPath::Folded) => (3, 8),
        (Fit::Cubic | Fit::Transfer, ColourPath::Folded) => (3, 12),
    }
}

fn unfit_bands(scene: &Scene) -> Result<()> {
    const KEY: &str = "render.bands";
    let Some(bands) = &scene.render.bands else { return Ok(()) };
    let (fewest, most) = band_counts(scene.render.fit, scene.render.color);
    let count = bands.len();
    if !(fewest..=most).contains(&count) {
        let complaint = format!("holds {count} wavelengths; this fit takes {fewest} to {most} of them");
        return Err(Error::not_allowed(KEY, complaint));
    }
    let known = scene.optics().known_wavelengths();
    bands.iter().try_for_each(|&band| check_range(KEY, band, known, "nm"))?;
    let mut sorted = bands.clone();
    sorted.sort_by(f64::total_cmp);
    match sorted.windows(2).find(|pair| pair[1] - pair[0] < CLOSEST_BANDS) {
        Some(pair) => Err(Error::not_allowed(
            KEY,
            format!("holds {} and {}; bands must lie at least {CLOSEST_BANDS} nm apart", pair[0], pair[1]),
        )),
        None => Ok(()),
    }
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
        let error = scene.validate().unwrap_err();
        let expected = "sun.elevation is 100; it must lie between -90 and 90 degrees";
        assert_eq!(error.to_string(), expected);
        assert!(matches!(error, Error::OutOfRange { key: "sun.elevation", low: -90.0, high: 90.0, .. }));
        scene.sun.elevation = f64::NAN;
        assert!(scene.validate().is_err());
    }
}
