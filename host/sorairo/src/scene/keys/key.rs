//! One key of a scene: the way to its value, its unit, what it may be, and what stands in for it.

use documented::DocumentedFields;
use serde::Deserializer;

use crate::azimuth::within_a_turn;
use crate::error::{Error, Result, check_range};
use crate::scene::aerosol::Aerosol;
use crate::scene::camera::CameraScene;
use crate::scene::field::{Field, NumberField, Present, TableField};
use crate::scene::preset::Scene;
use crate::scene::settings::Render;
use crate::scene::sky::{Air, AtmosphereScene, Ground, Observer, Ozone, Site, Sun, Water};
use crate::spectra::named_file::{is_table_file, is_text_file};
use crate::words::Word;

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
    pub(super) table: Option<&'static dyn TableField>,
    /// Whether it may be the name of another CSV file, or of a text file.
    or_file: bool,
    field: &'static dyn Field,
    /// Whether its number is an azimuth: any finite value is allowed, and the range is the usual one.
    pub(super) wraps: bool,
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
pub(super) struct Table {
    pub(super) name: &'static str,
    #[cfg(test)]
    pub(super) fields: &'static [&'static str],
    sentence: fn(&str) -> Option<&'static str>,
}

pub(super) static TABLES: [Table; 12] = [
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

impl Key {
    pub(super) const fn new(name: &'static str, field: &'static dyn Field, allowed: Allowed) -> Self {
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

    pub(super) const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    pub(super) const fn or_words(mut self, words: fn() -> Vec<Word>) -> Self {
        self.or_words = Some(words);
        self
    }

    pub(super) const fn or_table(mut self, table: &'static dyn TableField) -> Self {
        self.table = Some(table);
        self
    }

    pub(super) const fn or_file(mut self) -> Self {
        self.or_file = true;
        self
    }

    /// Whether its number is an azimuth, for which whole turns have no effect; any finite one is allowed.
    pub fn is_cyclic(&self) -> bool {
        self.wraps
    }

    pub(super) const fn wraps(mut self) -> Self {
        self.wraps = true;
        self
    }

    pub(super) const fn matters(mut self, matters: fn(&Scene) -> bool) -> Self {
        self.matters = matters;
        self
    }

    pub(super) const fn otherwise(mut self, otherwise: fn() -> String) -> Self {
        self.otherwise = Some(otherwise);
        self
    }

    pub(super) const fn rule(mut self, rule: fn(&Scene) -> Result<()>) -> Self {
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
    pub(crate) fn check_range(&self, scene: &Scene) -> Result<()> {
        let Allowed::Range { number, low, high } = &self.allowed else { return Ok(()) };
        match number.number(scene).filter(|_| self.wraps || (self.matters)(scene)) {
            Some(azimuth) if self.wraps => within_a_turn(self.name, azimuth).map(drop),
            Some(number) => check_range(self.name, number, (low.of(scene), high.of(scene)), self.unit),
            None => Ok(()),
        }
    }

    pub(super) fn check(&self, scene: &Scene) -> Result<()> {
        self.check_range(scene)?;
        self.rule.map_or(Ok(()), |rule| rule(scene))
    }
}

impl Bound {
    fn of(&self, scene: &Scene) -> f64 {
        match self {
            Self::At(value) => *value,
            Self::From(value, _) => value(scene),
        }
    }

    fn words(&self) -> String {
        match self {
            Self::At(value) => value.to_string(),
            Self::From(_, words) => words(),
        }
    }
}

fn listed(words: &[Word]) -> String {
    words.iter().map(|word| format!("`{}`", word.name)).collect::<Vec<_>>().join(", ")
}
