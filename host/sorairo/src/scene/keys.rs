//! The keys of a scene: one row each, with the way to its value, its unit, what it may be, and what stands in for it.
//! Validation, scene files, the help of the flags, the reference page, random scenes and the words of the fuzz targets
//! are all made from these rows; a key's sentence is the doc comment of its field.

use std::ops::RangeInclusive;

use documented::DocumentedFields;
use serde::Deserializer;

use super::aerosol::{Aerosol, AerosolMode};
use super::camera::{Below, CameraScene, Projection, Reflectance, Size};
use super::field::{Field, NumberField, Present, TableField, Way};
use super::preset::{Preset, Scene};
use super::settings::{
    ColourPath, Display, Dither, Exposure, ExrCompression, ExrDepth, Fit, MOST_STOPS, Orders, PathChoice, PictureLook,
    Polarisation, Render, Rgb, ViewTransform, WhiteBalance,
};
use super::sky::{Air, AtmosphereScene, Ground, Observer, Ozone, Site, Sun, Water};
use super::{plausible, rules};
use crate::azimuth::within_a_turn;
use crate::error::{Error, Result, check_range};
use crate::input::shown;
use crate::medium::aerosol::AerosolKind;
use crate::medium::profile::Profile;
use crate::spectra::choice::{AirSpectrum, AlbedoSpectrum, GroundAlbedo, OzoneCrossSection, SunSpectrum};
use crate::spectra::measured::MEASURED_RANGE;
use crate::spectra::named_file::{NamedFile, is_table_file, is_text_file};
use crate::spectra::observer::ColourObserver;
use crate::spectra::table_file::TableFile;
use crate::words::{Word, Words, words};

/// One key of a scene file.
#[non_exhaustive]
pub struct Key {
    /// Its name with its tables, as in `sun.elevation`.
    pub name: &'static str,
    /// Its unit; empty if it has none.
    pub unit: &'static str,
    /// The allowed values.
    pub allowed: Allowed,
    /// Words allowed in addition to a number.
    or_words: Option<fn() -> Vec<Word>>,
    /// The accessor of a user table, if the value may be the name of a CSV file.
    table: Option<&'static dyn TableField>,
    /// Whether it may be the name of another CSV file, or of a text file.
    or_file: bool,
    field: &'static dyn Field,
    /// Whether its number is an azimuth: any finite value is allowed, and the range is the usual one.
    wraps: bool,
    /// Whether it has an effect in a scene.
    matters: fn(&Scene) -> bool,
    /// The description of the default, if that is not a single value.
    otherwise: Option<fn() -> String>,
    /// A rule in addition to `allowed`.
    rule: Option<fn(&Scene) -> Result<()>>,
}

/// The allowed values of a key, except additional words.
#[non_exhaustive]
pub enum Allowed {
    /// A number in a range.
    Range {
        /// The number.
        number: &'static dyn NumberField,
        /// The smallest allowed value.
        low: Bound,
        /// The largest allowed value.
        high: Bound,
    },
    /// One of some words, each with a description.
    Words(fn() -> Vec<Word>),
    /// Anything else, described in words.
    Other(fn() -> String),
}

/// An end of a range.
#[non_exhaustive]
pub enum Bound {
    /// A number.
    At(f64),
    /// A value derived from other keys, and its description.
    From(fn(&Scene) -> f64, fn() -> String),
}

/// The keys of a table: the type that holds them.
struct Table {
    name: &'static str,
    #[cfg(test)]
    fields: &'static [&'static str],
    sentence: fn(&str) -> Option<&'static str>,
}

static TABLES: [Table; 12] = [
    table::<Scene>(""),
    table::<Sun>("sun"),
    table::<Observer>("observer"),
    table::<Site>("site"),
    table::<AtmosphereScene>("atmosphere"),
    table::<Air>("atmosphere.air"),
    table::<Aerosol>("atmosphere.aerosol"),
    table::<Ozone>("atmosphere.ozone"),
    table::<Water>("atmosphere.water"),
    table::<Ground>("ground"),
    table::<CameraScene>("camera"),
    table::<Render>("render"),
];

const fn table<T: DocumentedFields>(name: &'static str) -> Table {
    Table {
        name,
        #[cfg(test)]
        fields: T::FIELD_NAMES,
        sentence: |field| T::get_field_docs(field).ok(),
    }
}

/// The way to a field of a scene.
macro_rules! way {
    ($($part:ident).+) => {
        const { &Way { get: |scene| &scene.$($part).+, get_mut: |scene| &mut scene.$($part).+ } }
    };
}

/// The name of a field of a scene.
macro_rules! name {
    ($first:ident $(. $rest:ident)*) => { concat!(stringify!($first) $(, ".", stringify!($rest))*) };
}

/// A key, from its field and what it may be.
macro_rules! key {
    ($($part:ident).+, $allowed:expr) => { Key::new(name!($($part).+), way!($($part).+), $allowed) };
}

/// A key that is a number, from its field, its unit and the ends of its range.
macro_rules! number {
    ($($part:ident).+, $unit:expr, $low:expr, $high:expr) => {
        key!($($part).+, Allowed::Range { number: way!($($part).+), low: $low, high: $high }).unit($unit)
    };
}

use Allowed::Other;
use Bound::{At, From};

/// The highest top of an atmosphere above the ground (km).
const HIGHEST_TOP: f64 = 1e4;
/// The narrowest and the widest field of view (degrees).
const FIELDS: RangeInclusive<f64> = 0.01..=360.0;
/// The widest field of view of a perspective (degrees).
const WIDEST_PERSPECTIVE: f64 = 170.0;

/// The farthest shift of a perspective (widths of its image): farther off, neighbouring pixels look alike in single
/// precision.
const MOST_SHIFT: f64 = 1000.0;

// Column densities are closed forms for scale heights up to a hundredth of the radius; where the atmosphere ends within
// one scale height, a column density to its top is the small difference of two of them.
const THICKEST: Bound = From(
    |s| (s.atmosphere.ground_radius / 100.0).min(s.atmosphere.top_radius - s.atmosphere.ground_radius),
    || "a hundredth of the ground radius and the depth of the atmosphere".into(),
);
const DEPTH: Bound =
    From(|s| s.atmosphere.top_radius - s.atmosphere.ground_radius, || "the depth of the atmosphere".into());
/// Each height of the ozone layer lies so far above the one before (km).
const OZONE_STEP: f64 = 0.1;

/// Every key, table by table.
pub static KEYS: &[Key] = &[
    key!(preset, one_of::<Preset>()),
    number!(sun.elevation, "degrees", At(-90.0), At(90.0)),
    key!(sun.apparent, Other(|| "true or false; true requires `refraction`, and a sun without place and time".into()))
        .rule(rules::apparent_without_refraction),
    number!(sun.azimuth, "degrees", At(-360.0), At(360.0)).wraps(),
    key!(sun.place, Other(|| "\"LATITUDE,LONGITUDE\", -90 to 90 north, -180 to 180 east".into()))
        .unit("degrees")
        .otherwise(|| "`elevation`, `azimuth` and `distance` apply".into())
        .rule(rules::place_elsewhere),
    key!(sun.time, Other(|| "RFC 3339 with an offset, such as \"2026-06-21T04:30:00+09:00\"".into()))
        .otherwise(|| "`elevation`, `azimuth` and `distance` apply".into()),
    key!(sun.spectrum, one_of::<SunSpectrum>()).or_table(way!(sun.spectrum)).rule(plausible::solar_spectrum),
    number!(sun.distance, "au", At(0.01), At(1000.0)),
    key!(sun.disc, Other(|| format!("true or false; with a disc the distance is at most {} au", rules::FARTHEST_DISC)))
        .rule(rules::disc_too_small),
    number!(observer.altitude, "km", At(0.0), At(1e5)),
    number!(site.altitude, "km", At(0.0), At(9.0)).rule(rules::site_of_no_profile),
    // In single precision a horizon is as sharp as 6e-8 of the radius, which must lie far below the scale heights.
    number!(atmosphere.ground_radius, "km", At(10.0), At(1e5)),
    number!(
        atmosphere.top_radius,
        "km",
        From(|s| s.atmosphere.ground_radius + 1.0, || "1 above the ground".into()),
        // The column density of a layer of ozone is a closed form for heights well below the radius; of the thickest
        // profile, e⁻²⁰ is left there.
        From(
            |s| s.atmosphere.ground_radius + (0.2 * s.atmosphere.ground_radius).min(HIGHEST_TOP),
            || format!("{HIGHEST_TOP} km or a fifth of the ground radius above the ground"),
        )
    )
    .rule(opaque_at_its_top),
    key!(atmosphere.profile, one_of::<Profile>()).or_file().rule(rules::profile_cut_short),
    key!(atmosphere.refraction, Other(|| "true or false; true requires a measured `profile` and the Earth".into()))
        .rule(rules::bent_without_a_profile),
    number!(atmosphere.air.scattering, "km⁻¹", At(0.0), At(100.0)),
    key!(atmosphere.air.spectrum, one_of::<AirSpectrum>()),
    number!(atmosphere.air.pressure, "hPa", At(0.0), At(2000.0)),
    number!(atmosphere.air.scale_height, "km", At(0.05), THICKEST),
    key!(atmosphere.aerosol.kind, one_of::<AerosolKind>()),
    number!(atmosphere.aerosol.optical_depth, "", At(0.0), At(1000.0)),
    number!(atmosphere.aerosol.angstrom_exponent, "", At(-5.0), At(5.0)),
    number!(atmosphere.aerosol.scale_height, "km", At(0.05), THICKEST),
    number!(atmosphere.aerosol.single_scattering_albedo, "", At(0.0), At(1.0)),
    key!(atmosphere.aerosol.single_scattering_albedo_spectrum, one_of::<AlbedoSpectrum>())
        .or_table(way!(atmosphere.aerosol.single_scattering_albedo_spectrum))
        .rule(plausible::aerosol_albedo),
    number!(atmosphere.aerosol.asymmetry, "", At(-0.9), At(0.99)),
    key!(atmosphere.aerosol.modes, Other(|| "a list of tables, each with the keys below".into()))
        .otherwise(|| "the one aerosol of the other keys".into())
        .rule(rules::modes_of_aerosol),
    // Behind a layer that is opaque itself, the samples of a ray would have to follow every edge of its tent.
    number!(atmosphere.ozone.column, "Dobson units", At(0.0), At(2e3)),
    number!(atmosphere.ozone.bottom, "km", At(0.0), DEPTH).matters(has_ozone),
    number!(
        atmosphere.ozone.peak,
        "km",
        From(|s| s.atmosphere.ozone.bottom + OZONE_STEP, || format!("{OZONE_STEP} above `bottom`")),
        DEPTH
    )
    .matters(has_ozone),
    number!(
        atmosphere.ozone.top,
        "km",
        From(|s| s.atmosphere.ozone.peak + OZONE_STEP, || format!("{OZONE_STEP} above `peak`")),
        DEPTH
    )
    .matters(has_ozone),
    key!(atmosphere.ozone.cross_section, one_of::<OzoneCrossSection>())
        .or_table(way!(atmosphere.ozone.cross_section))
        .rule(plausible::cross_section),
    number!(atmosphere.water.column, "cm", At(0.0), At(20.0))
        .otherwise(|| "that of the profile: 1.42 of us-standard, 4.1 of tropical".into())
        .rule(rules::water_of_no_profile),
    number!(ground.albedo, "", At(0.0), At(1.0))
        .or_words(words::<GroundAlbedo>)
        .or_table(way!(ground.albedo))
        .rule(plausible::ground_albedo),
    key!(camera.projection, one_of::<Projection>()),
    key!(camera.size, Other(Size::allowed)).unit("pixels").rule(rules::size_out_of_range),
    number!(
        camera.fov,
        "degrees",
        At(*FIELDS.start()),
        From(
            |s| if s.camera.projection == Projection::Perspective { WIDEST_PERSPECTIVE } else { *FIELDS.end() },
            || format!("{} (perspective: {WIDEST_PERSPECTIVE})", FIELDS.end()),
        )
    )
    .otherwise(|| format!("fisheye {}, perspective {}", Projection::FISHEYE.fov, Projection::PERSPECTIVE.fov)),
    number!(camera.look_azimuth, "degrees", At(-360.0), At(360.0)).wraps().otherwise(|| {
        let [perspective, fisheye] = [Projection::PERSPECTIVE, Projection::FISHEYE].map(|view| view.azimuth);
        format!("{perspective}, north; fisheye {fisheye}, which puts north on top")
    }),
    number!(camera.look_elevation, "degrees", At(-90.0), At(90.0)).otherwise(|| {
        format!("fisheye {}, perspective {}", Projection::FISHEYE.elevation, Projection::PERSPECTIVE.elevation)
    }),
    number!(camera.roll, "degrees", At(-360.0), At(360.0)).wraps(),
    number!(camera.shift_x, "", At(-MOST_SHIFT), At(MOST_SHIFT)),
    number!(camera.shift_y, "", At(-MOST_SHIFT), At(MOST_SHIFT)),
    key!(camera.below, one_of::<Below>()).otherwise(|| {
        "`fade` in pictures of the whole sphere from less than 1 km above ground that is not black; else `ground`"
            .into()
    }),
    key!(camera.below_color, Other(Reflectance::allowed)).rule(rules::colour_of_no_ground),
    number!(camera.polariser, "degrees", At(-360.0), At(360.0))
        .wraps()
        .otherwise(|| "none".into())
        .rule(rules::polariser_of_no_light),
    number!(camera.polariser_extinction, "", At(1.0), At(1e9))
        .otherwise(|| "an ideal polariser, without transmittance across its axis".into())
        .rule(rules::extinction_of_no_polariser),
    number!(render.orders, "", At(1.0), At(Orders::MOST as f64)).or_words(words::<Orders>),
    key!(render.polarisation, one_of::<Polarisation>()),
    key!(render.fit, one_of::<Fit>()),
    key!(render.bands, Other(range_of_bands))
        .unit("nm")
        .otherwise(|| "the best found for the fit".into())
        .rule(rules::unfit_bands),
    key!(render.color, one_of::<ColourPath>()).rule(rules::nothing_to_solve),
    number!(render.steps, "samples", At(1.0), At(1024.0)).otherwise(|| {
        "as many as the scene's rays need: 12 from the Earth's ground, 48 to 64 with the sun below 5°".into()
    }),
    key!(render.path, one_of::<PathChoice>()),
    number!(render.exposure, "stops", At(-MOST_STOPS), At(MOST_STOPS))
        .or_words(words::<Exposure>)
        .otherwise(|| "\"auto\"; \"ev15\" is a camera's EV100".into()),
    number!(render.iso, "", At(1.0), At(1e7)).otherwise(no_camera).rule(rules::half_a_camera),
    number!(render.shutter, "s", At(1e-6), At(1e6)).otherwise(no_camera),
    number!(render.aperture, "", At(0.1), At(1e3)).otherwise(no_camera),
    key!(render.view, one_of::<ViewTransform>()).rule(rules::view_of_hdr),
    key!(render.look, one_of::<PictureLook>()),
    key!(render.purkinje, Other(|| "true or false".into())),
    key!(render.display, one_of::<Display>()),
    key!(render.dither, one_of::<Dither>()),
    key!(render.exr, one_of::<ExrDepth>()),
    number!(render.exr_exposure, "stops", At(-MOST_STOPS), At(MOST_STOPS))
        .otherwise(|| "\"auto\": 0, unless half floats would lose the brightest or the darkest values of a sky".into())
        .rule(rules::adapted_halves),
    key!(render.exr_compression, one_of::<ExrCompression>()),
    key!(render.rgb, one_of::<Rgb>()),
    key!(render.observer, one_of::<ColourObserver>()),
    key!(render.white_balance, one_of::<WhiteBalance>()),
];

const fn one_of<T: Words>() -> Allowed {
    Allowed::Words(words::<T>)
}

/// What holds without a camera's settings.
fn no_camera() -> String {
    "`exposure` applies".into()
}

/// Heights of the ozone layer matter where there is ozone.
fn has_ozone(scene: &Scene) -> bool {
    scene.atmosphere.ozone.column > 0.0
}

fn range_of_bands() -> String {
    let (shortest, longest) = MEASURED_RANGE;
    let counts = |fit: Fit, color: ColourPath| {
        let (fewest, most) = rules::band_counts(fit, color);
        if fewest == most { fewest.to_string() } else { format!("{fewest} to {most}") }
    };
    let folded = |fit| counts(fit, ColourPath::Folded);
    format!(
        "{shortest} to {longest}, at least {} apart; {} with `regression`, {} with `cubic` and `transfer`, {} with `dense`, {} with \
         `color = \"solve\"`",
        rules::CLOSEST_BANDS,
        folded(Fit::Regression),
        folded(Fit::Cubic),
        folded(Fit::Dense),
        counts(Fit::Cubic, ColourPath::Solve)
    )
}

impl Key {
    const fn new(name: &'static str, field: &'static dyn Field, allowed: Allowed) -> Self {
        Self {
            name,
            unit: "",
            allowed,
            or_words: None,
            table: None,
            or_file: false,
            field,
            wraps: false,
            matters: |_| true,
            otherwise: None,
            rule: None,
        }
    }

    const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    const fn or_words(mut self, words: fn() -> Vec<Word>) -> Self {
        self.or_words = Some(words);
        self
    }

    const fn or_table(mut self, table: &'static dyn TableField) -> Self {
        self.table = Some(table);
        self
    }

    const fn or_file(mut self) -> Self {
        self.or_file = true;
        self
    }

    /// Whether its number is an azimuth, for which whole turns have no effect; any finite one is allowed.
    pub fn is_cyclic(&self) -> bool {
        self.wraps
    }

    const fn wraps(mut self) -> Self {
        self.wraps = true;
        self
    }

    const fn matters(mut self, matters: fn(&Scene) -> bool) -> Self {
        self.matters = matters;
        self
    }

    const fn otherwise(mut self, otherwise: fn() -> String) -> Self {
        self.otherwise = Some(otherwise);
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

    /// The description of the key: the doc comment of its field.
    pub fn sentence(&self) -> String {
        let (table, name) = self.table_and_name();
        let table = TABLES.iter().find(|known| known.name == table).expect("a key lies in a table");
        (table.sentence)(name).expect("every key is a documented field").replace('\n', " ")
    }

    /// The value in a scene.
    pub fn value<'a>(&self, scene: &'a Scene) -> &'a dyn erased_serde::Serialize {
        self.field.get(scene)
    }

    /// Sets the value in a scene; [`Scene::validated`] checks its range.
    ///
    /// # Errors
    ///
    /// [`Error::Text`] if it has the wrong type.
    pub fn set<'de>(&self, scene: &mut Scene, value: impl Deserializer<'de>) -> Result<()> {
        let mut value = <dyn erased_serde::Deserializer<'_>>::erase(Present(value));
        self.field.set(scene, &mut value).map_err(|error| Error::Text(error.to_string()))
    }

    /// Mutable access to the number in a scene; `None` if the key is not a plain number. A number that was not given
    /// starts at 0.
    pub fn number_mut<'a>(&self, scene: &'a mut Scene) -> Option<&'a mut f64> {
        match &self.allowed {
            Allowed::Range { number, .. } => number.number_mut(scene),
            _ => None,
        }
    }

    /// The smallest and the largest allowed number in a scene; `None` if the key is not a number.
    pub fn bounds(&self, scene: &Scene) -> Option<(f64, f64)> {
        match &self.allowed {
            Allowed::Range { low, high, .. } => Some((low.of(scene), high.of(scene))),
            _ => None,
        }
    }

    /// Whether the key may be the name of a CSV file that is a spectrum.
    pub fn takes_table(&self) -> bool {
        self.table.is_some()
    }

    /// Whether a text is the name of a file that the key may be: of a CSV file, or of a table with spaces.
    pub fn is_file(&self, text: &str) -> bool {
        self.takes_table() && is_table_file(text) || self.or_file && (is_table_file(text) || is_text_file(text))
    }

    /// The words that the key accepts.
    pub fn words(&self) -> Vec<Word> {
        match &self.allowed {
            Allowed::Words(words) => words(),
            _ => self.or_words.map(|words| words()).unwrap_or_default(),
        }
    }

    /// The word of the key that matches a text, ignoring case; or else the text itself.
    pub fn word_or<'a>(&self, text: &'a str) -> &'a str {
        self.words().iter().find(|word| word.is(text)).map_or(text, |word| word.name)
    }

    /// The allowed values of the key, in words.
    pub fn range(&self) -> String {
        let table = match (self.takes_table(), self.or_file) {
            (true, _) => ", or the name of a .csv file",
            (_, true) => ", or the name of a .csv or .txt file",
            _ => "",
        };
        match &self.allowed {
            Allowed::Range { low, high, .. } => {
                let words = self.or_words.map(|words| format!(", {}", listed(&words()))).unwrap_or_default();
                if self.wraps {
                    return "any number: 360 is a whole turn".into();
                }
                format!("{} to {}{words}{table}", low.words(), high.words())
            }
            Allowed::Words(words) => format!("{}{table}", listed(&words())),
            Allowed::Other(words) => words(),
        }
    }

    /// The description of the default, if that is not a single value.
    pub fn stand_in(&self) -> Option<String> {
        self.otherwise.map(|words| words())
    }

    /// Whether its number lies in its range.
    pub(super) fn check_range(&self, scene: &Scene) -> Result<()> {
        let Allowed::Range { number, low, high } = &self.allowed else { return Ok(()) };
        match number.number(scene).filter(|_| self.wraps || (self.matters)(scene)) {
            Some(azimuth) if self.wraps => within_a_turn(self.name, azimuth).map(drop),
            Some(number) => check_range(self.name, number, (low.of(scene), high.of(scene)), self.unit),
            None => Ok(()),
        }
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
            From(_, words) => words(),
        }
    }
}

/// The key of a name.
pub fn find(name: &str) -> Option<&'static Key> {
    KEYS.iter().find(|key| key.name == name)
}

/// The user tables that a scene reads, each with its key.
pub fn tables(scene: &Scene) -> impl Iterator<Item = (&'static str, &TableFile)> {
    KEYS.iter().filter_map(|key| Some((key.name, key.table?.table(scene)?)))
}

/// The files that a scene reads, each with its key and the CRC-32 of what it holds.
pub fn files(scene: &Scene) -> impl Iterator<Item = (&'static str, &NamedFile, u32)> {
    let tables = tables(scene).map(|(key, table)| (key, &table.file, table.checksum()));
    let profile = match &scene.atmosphere.profile {
        Profile::File(own) => Some(("atmosphere.profile", &own.file, own.checksum)),
        _ => None,
    };
    let modes = scene.atmosphere.aerosol.modes.iter().flat_map(AerosolMode::files);
    tables.chain(profile).chain(modes.map(|(file, checksum)| ("atmosphere.aerosol", file, checksum)))
}

/// Changes the name of each of [`files`].
#[cfg_attr(
    not(feature = "scene-files"),
    allow(dead_code, reason = "scenes that come from files alone have names to change")
)]
pub(crate) fn change_names(scene: &mut Scene, mut change: impl FnMut(&mut NamedFile)) {
    for way in KEYS.iter().filter_map(|key| key.table) {
        way.table_mut(scene).into_iter().for_each(|table| change(&mut table.file));
    }
    if let Profile::File(own) = &mut scene.atmosphere.profile {
        change(&mut own.file);
    }
    scene.atmosphere.aerosol.modes.iter_mut().flat_map(AerosolMode::names_mut).for_each(change);
}

/// The errors of a scene, key by key.
pub fn problems(scene: &Scene) -> Vec<Error> {
    KEYS.iter().filter_map(|key| key.check(scene).err()).collect()
}

/// Takes whole turns off the azimuths of a scene.
pub(super) fn unwind(scene: &mut Scene) -> Result<()> {
    for key in KEYS.iter().filter(|key| key.wraps) {
        let Allowed::Range { number, .. } = &key.allowed else { continue };
        if let Some(azimuth) = number.number(scene)
            && let Some(place) = number.number_mut(scene)
        {
            *place = within_a_turn(key.name, azimuth)?;
        }
    }
    Ok(())
}

/// Checks the keys of one table of a scene.
pub(super) fn check_table(table: &str, scene: &Scene) -> Result<()> {
    KEYS.iter().filter(|key| key.table_and_name().0 == table).try_for_each(|key| key.check(scene))
}

fn listed(words: &[Word]) -> String {
    words.iter().map(|word| format!("`{}`", word.name)).collect::<Vec<_>>().join(", ")
}

/// The largest optical depth, on a level ray and at the shortest wavelength, of what the atmosphere's top cuts off.
///
/// A denser top is an edge: the level sun lights the air within metres of it, and an altitude in single precision has
/// no digits for them.
pub const DENSEST_TOP: f64 = 20.0;

/// What the optical depth above the top follows from.
const OF_THE_TOP: [&str; 7] = [
    "atmosphere.ground_radius",
    "atmosphere.air.scattering",
    "atmosphere.air.pressure",
    "atmosphere.air.scale_height",
    "atmosphere.aerosol.optical_depth",
    "atmosphere.aerosol.angstrom_exponent",
    "atmosphere.aerosol.scale_height",
];

fn opaque_at_its_top(scene: &Scene) -> Result<()> {
    // Where one of them is out of its range, that is what is wrong.
    let is_wrong = |name: &str| find(name).expect("a key").check_range(scene).is_err();
    if OF_THE_TOP.into_iter().any(is_wrong) || rules::modes_of_aerosol(scene).is_err() {
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

#[cfg(test)]
mod tests {
    use strum::IntoEnumIterator;

    use super::*;

    #[test]
    fn every_field_of_a_scene_is_a_key() {
        let is_table = |name: &str| TABLES.iter().any(|table| table.name == name);
        let of_table =
            |table: &Table| table.fields.iter().map(|field| format!("{}.{field}", table.name)).collect::<Vec<_>>();
        let mut names: Vec<String> = TABLES
            .iter()
            .flat_map(of_table)
            .map(|name| name.trim_start_matches('.').to_owned())
            .filter(|name| !is_table(name))
            .collect();
        let mut keys: Vec<_> = KEYS.iter().map(|key| key.name.to_owned()).collect();
        names.sort();
        keys.sort();
        assert_eq!(keys, names);
    }

    #[test]
    fn every_key_has_a_sentence_and_a_range() {
        for key in KEYS {
            let texts = [key.sentence(), key.range()];
            assert!(texts.iter().all(|text| !text.is_empty()), "{}: {texts:?}", key.name);
        }
    }

    #[test]
    fn every_key_is_the_way_to_its_own_value() {
        for key in KEYS.iter().filter(|key| key.bounds(&Scene::default()).is_some()) {
            let mut scene = Scene::default();
            key.set(&mut scene, serde::de::value::U32Deserializer::<serde::de::value::Error>::new(77)).unwrap();
            let value = serde_json::to_value(key.value(&scene)).unwrap();
            let at = format!("/{}", key.name.replace('.', "/"));
            let whole = serde_json::to_value(&scene).unwrap();
            assert!(value.as_f64() == Some(77.0) && whole.pointer(&at) == Some(&value), "{}: {value}", key.name);
        }
    }

    #[test]
    fn each_key_that_takes_the_name_of_a_file_is_in_the_list_of_tables() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, "380,0.25\n780,0.5\n").unwrap();
        let name = path.to_str().unwrap();
        let mut found = 0;
        for key in KEYS {
            let mut scene = Scene::default();
            let value = serde::de::value::StrDeserializer::<serde::de::value::Error>::new(name);
            let is_read = key.set(&mut scene, value).is_ok();
            let listed: Vec<_> = tables(&scene).map(|(key, table)| (key, table.table().at(780.0))).collect();
            assert_eq!(listed, if is_read { vec![(key.name, [0.5])] } else { vec![] }, "{}", key.name);
            assert_eq!(is_read, key.takes_table(), "{}", key.name);
            found += u32::from(is_read);
        }
        assert!(found >= 4, "{found} keys take tables");
    }

    #[test]
    fn every_preset_is_allowed() {
        for preset in Preset::iter() {
            assert!(Scene::preset(preset).validated().is_ok(), "{preset:?}");
        }
    }
}
