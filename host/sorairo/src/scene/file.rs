//! Scene files: from TOML to a scene, with the place of everything that is wrong.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use super::keys::{self, Allowed, KEYS, Key};
use super::place::{PlaceAndTime, sun_position};
use super::preset::{Preset, Scene};
use crate::error::{Error, PlaceInFile, Result};
use crate::input::{self, LARGEST_SCENE};
use crate::spectra::choice::is_table_file;

/// Most problems of one file that are told.
const MOST_PROBLEMS: usize = 20;

/// A scene file that was read: the scene over its preset, and where each key stands.
#[derive(Debug)]
pub struct SceneFile {
    /// The scene; where the file names a place and a time, the sun is not there yet.
    pub scene: Scene,
    /// The place and the time that the file names.
    pub sun_from: PlaceAndTime,
    text: SourceText,
    spans: Spans,
}

/// A text and the name of its file.
#[derive(Debug)]
struct SourceText {
    name: String,
    text: String,
}

impl Scene {
    /// The scene in a TOML text. `preset` takes the place of the one that the text names; names of CSV files are relative to
    /// the working folder.
    ///
    /// # Errors
    ///
    /// [`Error::InFile`] with the place in `source` for an unknown key or a value of the wrong kind.
    pub fn parse(text: &str, source: &str, preset: Option<Preset>) -> Result<Self> {
        SceneFile::parse(text, source, Path::new("."), preset).map_err(first)?.resolved()
    }

    /// The scene in a TOML file; see [`Scene::parse`]. Names of CSV files are relative to its folder.
    ///
    /// # Errors
    ///
    /// [`Error::SceneFile`] if the file cannot be read, [`Error::InFile`] if it is not a scene.
    pub fn read(path: &Path, preset: Option<Preset>) -> Result<Self> {
        SceneFile::read(path, preset)?.resolved()
    }
}

/// A whole scene as TOML, from which it is read again as it is.
pub fn text(scene: &Scene) -> String {
    toml::to_string(scene).expect("a scene is TOML")
}

/// The first problem as an error.
fn first(problems: Vec<Error>) -> Error {
    problems.into_iter().next().expect("what is refused has a problem")
}

/// The sun at a place and a time, where a scene has them.
///
/// # Errors
///
/// [`Error::NotAllowed`] if only one of the two is given, or the moment is not known to the algorithm.
pub fn place_sun(scene: &mut Scene, from: PlaceAndTime) -> Result<()> {
    match (from.place, from.time) {
        (None, None) => {}
        (Some(place), Some(time)) => {
            let position = sun_position(place, time, scene.observer.altitude)?;
            (scene.sun.elevation, scene.sun.azimuth) = position;
        }
        (Some(_), None) => return Err(Error::not_allowed("sun.place", "needs a time: give sun.time too")),
        (None, Some(_)) => return Err(Error::not_allowed("sun.time", "needs a place: give sun.place too")),
    }
    Ok(())
}

impl SceneFile {
    /// Reads a file; see [`SceneFile::parse`].
    ///
    /// # Errors
    ///
    /// The first problem.
    pub fn read(path: &Path, preset: Option<Preset>) -> Result<Self> {
        Self::read_all(path, preset).map_err(first)
    }

    /// Every problem of a file by itself, without flags: none if it is a scene.
    pub fn problems(path: &Path) -> Vec<Error> {
        match Self::read_all(path, None) {
            Ok(file) => {
                let mut problems: Vec<Error> =
                    keys::problems(&file.scene).into_iter().map(|error| file.placed(error, &file.scene)).collect();
                problems.extend(file.resolved().err().filter(|_| problems.is_empty()));
                problems
            }
            Err(problems) => problems,
        }
    }

    fn read_all(path: &Path, preset: Option<Preset>) -> std::result::Result<Self, Vec<Error>> {
        let text = input::read_text(path, LARGEST_SCENE)
            .map_err(|reason| vec![Error::SceneFile { path: path.to_owned(), reason }])?;
        Self::parse(&text, &path.to_string_lossy(), path.parent().unwrap_or(Path::new("")), preset)
    }

    /// Reads a TOML text. `preset` takes the place of the one that the text names; names of CSV files are relative to
    /// `folder`.
    ///
    /// # Errors
    ///
    /// Every problem, with its place in `source`.
    pub fn parse(
        text: &str,
        source: &str,
        folder: &Path,
        preset: Option<Preset>,
    ) -> std::result::Result<Self, Vec<Error>> {
        let text = SourceText { name: source.into(), text: input::without_mark(text).into() };
        let (scene, sun_from, spans) = text.scene(folder, preset)?;
        Ok(Self { scene, sun_from, spans, text })
    }

    /// The scene with the sun where place and time put it.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] if only one of the two is given, or the moment is not known to the algorithm.
    pub fn resolved(&self) -> Result<Scene> {
        let mut scene = self.scene.clone();
        place_sun(&mut scene, self.sun_from)?;
        Ok(scene)
    }

    /// Whether every value of a scene that began as this file lies in its range.
    ///
    /// # Errors
    ///
    /// The first that does not, with its place where it stands in this file.
    pub fn validate(&self, scene: &Scene) -> Result<()> {
        scene.validate().map_err(|error| self.placed(error, scene))
    }

    /// What is wrong with a key of a scene, with its place if the value is the one that stands in this file.
    fn placed(&self, error: Error, scene: &Scene) -> Error {
        let (Error::OutOfRange { key, .. } | Error::NotAllowed { key, .. }) = &error else { return error };
        let [here, now] = [&self.scene, scene].map(|scene| toml::Table::try_from(scene).expect("a scene is a table"));
        let shown = |scene| keys::find(key).and_then(|key| key.value(scene)).map(|value| value.to_string());
        match self.spans.get(key).filter(|_| shown(&here) == shown(&now)) {
            Some(span) => self.text.problem(span.start, error),
            None => error,
        }
    }
}

/// The problems found so far, no more than anyone reads.
struct Problems<'a> {
    text: &'a SourceText,
    found: Vec<Error>,
}

impl Problems<'_> {
    fn add(&mut self, at: usize, error: Error) {
        if !self.are_enough() {
            self.found.push(self.text.problem(at, error));
        }
    }

    fn are_enough(&self) -> bool {
        self.found.len() >= MOST_PROBLEMS
    }
}

type Spans = BTreeMap<&'static str, Range<usize>>;

impl SourceText {
    /// The scene that the text says over its preset, the place and time it names, and where each key's value stands.
    fn scene(
        &self,
        folder: &Path,
        preset: Option<Preset>,
    ) -> std::result::Result<(Scene, PlaceAndTime, Spans), Vec<Error>> {
        let document = DeTable::parse(&self.text).map_err(|error| {
            vec![self.problem(error.span().map_or(0, |span| span.start), wrong(in_plain_words(error.message())))]
        })?;
        let mut problems = Problems { text: self, found: Vec::new() };
        let mut given = Vec::new();
        collect(document.get_ref(), "", &mut given, &mut problems);
        let preset = preset.unwrap_or_else(|| named_preset(&given));
        let mut scene = toml::Table::try_from(Scene::preset(preset)).expect("a scene is a table");
        let mut sun_from = PlaceAndTime::default();
        let mut spans = Spans::new();
        for (key, value) in &given {
            spans.insert(key.name, value.span());
            let outcome = match key.name {
                "sun.place" => text_of(value).parse().map(|place| sun_from.place = Some(place)),
                "sun.time" => text_of(value).parse().map(|time| sun_from.time = Some(time)),
                _ => lay_over(&mut scene, key, value, folder),
            };
            if let Err(complaint) = outcome {
                problems.add(value.span().start, wrong(complaint));
            }
        }
        refuse_two_suns(&given, &mut problems);
        if !problems.found.is_empty() {
            return Err(problems.found);
        }
        let mut scene: Scene = scene.try_into().expect("every value was tried");
        scene.preset = preset;
        Ok((scene, sun_from, spans))
    }

    /// What is wrong at a byte of the text.
    fn problem(&self, at: usize, error: Error) -> Error {
        let before = &self.text[..self.text.floor_char_boundary(at)];
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let place = PlaceInFile {
            file: self.name.clone(),
            line: 1 + before.matches('\n').count(),
            column: 1 + before[start..].chars().count(),
            text: shortened(self.text[start..].lines().next().unwrap_or_default().trim()),
        };
        Error::InFile { place, error: Box::new(error) }
    }
}

/// What a reader says is wrong, without the middle of what it quotes.
fn wrong(complaint: String) -> Error {
    Error::Text(without_middle(&complaint))
}

type Given<'a> = (&'static Key, &'a Spanned<DeValue<'a>>);

/// Finds the keys of a table and of those in it.
fn collect<'a>(table: &'a DeTable<'a>, prefix: &str, given: &mut Vec<Given<'a>>, problems: &mut Problems<'_>) {
    for (key, value) in table {
        if problems.are_enough() {
            return;
        }
        let name = format!("{prefix}{}", key.get_ref());
        let inside = format!("{name}.");
        let is_table = KEYS.iter().any(|key| key.name.starts_with(&inside));
        match (keys::find(&name), value.get_ref()) {
            (Some(key), _) => given.push((key, value)),
            (None, DeValue::Table(table)) if is_table => collect(table, &inside, given, problems),
            (None, _) if is_table => {
                problems.add(value.span().start, wrong(format!("`{name}` must be a table of keys")));
            }
            (None, _) => problems.add(key.span().start, unknown(prefix, key.get_ref())),
        }
    }
}

/// A key that is none: what it may have been meant to be, or what there is.
fn unknown(prefix: &str, name: &str) -> Error {
    let mut siblings: Vec<&str> = KEYS
        .iter()
        .filter_map(|key| key.name.strip_prefix(prefix))
        .map(|rest| rest.split('.').next().unwrap_or(rest))
        .collect();
    siblings.dedup();
    let elsewhere = || KEYS.iter().map(|key| (key.table_and_name().1, key.name));
    let candidates = siblings.iter().map(|&sibling| (sibling, sibling)).chain(elsewhere());
    let hint = match nearest(name, candidates) {
        Some(meant) => format!("did you mean `{meant}`?"),
        None => format!("here may stand `{}`", siblings.join("`, `")),
    };
    Error::UnknownKey { name: shortened(name), hint }
}

/// The name of the candidate that is spelt most like `word`, if any is close.
fn nearest<'a>(word: &str, candidates: impl Iterator<Item = (&'a str, &'a str)>) -> Option<&'a str> {
    // No key is as long, and distances cost the product of the lengths.
    const LONGEST: usize = 64;
    if word.len() > LONGEST {
        return None;
    }
    let distance = |(spelling, name): (&str, &'a str)| (strsim::damerau_levenshtein(word, spelling), name);
    let (distance, name) = candidates.map(distance).min_by_key(|&(distance, _)| distance)?;
    (distance <= word.chars().count() / 3).then_some(name)
}

/// The preset that a file names; the default if it names none, or none that there is.
fn named_preset(given: &[Given<'_>]) -> Preset {
    let named = given.iter().find(|(key, _)| key.name == "preset");
    named.and_then(|(_, value)| plain_value(value).ok()?.try_into().ok()).unwrap_or_default()
}

/// A value of a document by itself.
fn plain_value(value: &Spanned<DeValue<'_>>) -> std::result::Result<toml::Value, String> {
    toml::Value::deserialize(ValueDeserializer::from(value.clone())).map_err(|error| in_plain_words(error.message()))
}

/// A text, or a date of TOML as text; anything else as it stands in TOML, to be refused.
fn text_of(value: &Spanned<DeValue<'_>>) -> String {
    match plain_value(value) {
        Ok(toml::Value::String(text)) => text,
        Ok(other) => shortened(&other.to_string()),
        Err(complaint) => complaint,
    }
}

/// Lays one value over a scene, if it is of the right kind.
fn lay_over(
    scene: &mut toml::Table,
    key: &Key,
    value: &Spanned<DeValue<'_>>,
    folder: &Path,
) -> std::result::Result<(), String> {
    let mut value = plain_value(value)?;
    if let (Allowed::WordsOrTable(_), toml::Value::String(name)) = (&key.allowed, &mut value)
        && is_table_file(name)
    {
        let path = std::path::absolute(folder.join(&*name)).map_err(|error| format!("{name}: {error}"))?;
        *name = path.to_string_lossy().into_owned();
    }
    let (tables, name) = key.table_and_name();
    // Alone over an empty file, so that the scene's own values are not read again.
    let alone = tables
        .rsplit('.')
        .filter(|part| !part.is_empty())
        .fold(toml::Table::from_iter([(name.to_owned(), value.clone())]), |inner, part| {
            toml::Table::from_iter([(part.to_owned(), toml::Value::Table(inner))])
        });
    alone.try_into::<Scene>().map_err(|error| in_plain_words(error.message()))?;
    let mut table = scene;
    for part in tables.split('.').filter(|part| !part.is_empty()) {
        table = table
            .entry(part)
            .or_insert_with(|| toml::Table::new().into())
            .as_table_mut()
            .expect("a scene's tables are tables");
    }
    table.insert(name.into(), value);
    Ok(())
}

/// Refuses an elevation or an azimuth beside a place or a time.
fn refuse_two_suns(given: &[Given<'_>], problems: &mut Problems<'_>) {
    let find = |name: &str| given.iter().find(|(key, _)| key.name == name);
    let Some((from, _)) = find("sun.place").or_else(|| find("sun.time")) else { return };
    for name in ["sun.elevation", "sun.azimuth"] {
        if let Some((_, value)) = find(name) {
            let complaint =
                format!("`{name}` and `{}` cannot both be given: a place and a time say where the sun is", from.name);
            problems.add(value.span().start, Error::Text(complaint));
        }
    }
}

/// The first part of a text that is too long to be quoted.
fn shortened(text: &str) -> String {
    const MOST: usize = 60;
    if text.chars().count() <= MOST { text.to_owned() } else { text.chars().take(MOST).chain("...".chars()).collect() }
}

/// A sentence without its middle if it quotes a value that is too long to be read.
fn without_middle(sentence: &str) -> String {
    const MOST: usize = 500;
    if sentence.len() <= MOST {
        return sentence.to_owned();
    }
    let end = sentence.ceil_char_boundary(sentence.len() - MOST / 2);
    format!("{} ... {}", &sentence[..sentence.floor_char_boundary(MOST / 2)], &sentence[end..])
}

/// A message of the TOML reader in one line, for people who do not know Rust's types.
fn in_plain_words(message: &str) -> String {
    let words = message.trim().replace('\n', " ").replace("expected f64", "expected a number");
    words.replace("expected u32", "expected a whole number, 0 or more")
}

#[cfg(test)]
mod tests {
    use strum::IntoEnumIterator;

    use super::*;
    use crate::scene::{Exposure, Size, SunSpectrum};

    fn refused(text: &str) -> String {
        Scene::parse(text, "a.toml", None).unwrap_err().to_string()
    }

    #[test]
    fn an_unknown_key_is_named_with_its_place_and_the_nearest_key() {
        let cases = [
            (
                "[sun]\nelevation = 3\nelevatoin = 4\n",
                "a.toml, line 3, column 1 (elevatoin = 4): unknown key `elevatoin`; did you mean `elevation`?",
            ),
            (
                "sun = { elevation = 3, azimut = 4 }",
                "line 1, column 24 (sun = { elevation = 3, azimut = 4 }): unknown key `azimut`; did you mean `azimuth`?",
            ),
            ("elevation = 3", "did you mean `sun.elevation`?"),
            (
                "[atmosphere.arosol]\n",
                "line 1, column 13 ([atmosphere.arosol]): unknown key `arosol`; did you mean `aerosol`?",
            ),
            ("[moon]\nx = 1", "unknown key `moon`; here may stand `preset`, `sun`, `observer`"),
        ];
        for (text, words) in cases {
            assert!(refused(text).contains(words), "{text:?}: {}", refused(text));
        }
    }

    #[test]
    fn a_value_of_the_wrong_kind_is_named_with_its_place() {
        let cases = [
            (
                "[sun]\nelevation = 'high'",
                "line 2, column 13 (elevation = 'high'): invalid type: string \"high\", expected a number",
            ),
            ("render.steps = -1", "line 1, column 16"),
            ("'å' = 1", "line 1, column 1 ('å' = 1): unknown"),
            ("sun.azimuth = \"é\"", "line 1, column 15"),
            ("[[sun]]\nelevation = 3", "must be a table of keys"),
        ];
        for (text, words) in cases {
            assert!(refused(text).contains(words), "{text:?}: {}", refused(text));
        }
    }

    #[test]
    fn every_problem_of_a_file_is_told_but_no_more_than_anyone_reads() {
        let problems = |text: &str| SceneFile::parse(text, "a.toml", Path::new(""), None).unwrap_err();
        assert_eq!(problems("sun.elevatoin = 1\nsun.azimuth = 'x'\nmoon = 2").len(), 3);
        let many: String = (0..1000).map(|i| format!("moon{i} = 1\n")).collect();
        assert_eq!(problems(&many).len(), MOST_PROBLEMS);
    }

    #[test]
    fn place_and_time_give_the_sun_and_refuse_another() {
        let placed =
            Scene::parse("[sun]\nplace = '43.06,141.35'\ntime = 2026-06-21T04:30:00+09:00", "a.toml", None).unwrap();
        let quoted =
            Scene::parse("[sun]\nplace = '43.06,141.35'\ntime = '2026-06-20T19:30:00Z'", "a.toml", None).unwrap();
        assert_eq!(placed.sun, quoted.sun);
        assert!(
            (placed.sun.elevation - 4.6).abs() < 1.0 && (placed.sun.azimuth - 61.0).abs() < 2.0,
            "{:?}",
            placed.sun
        );
        let cases = [
            ("sun.place = '43,141'", "needs a time"),
            ("sun.time = 2026-06-21T04:30:00Z", "needs a place"),
            ("sun.time = 2026-06-21T04:30:00", "line 1, column 12 (sun.time = 2026-06-21T04:30:00): a time is written"),
            ("sun.place = 43.0", "a place is LATITUDE,LONGITUDE"),
            (
                "[sun]\nplace = '43,141'\nelevation = 3",
                "line 3, column 13 (elevation = 3): `sun.elevation` and `sun.place`",
            ),
        ];
        for (text, words) in cases {
            assert!(refused(text).contains(words), "{text:?}: {}", refused(text));
        }
    }

    #[test]
    fn a_value_out_of_range_is_named_with_its_place_unless_a_flag_gave_it() {
        let file = SceneFile::parse("[sun]\nelevation = 100", "a.toml", Path::new(""), None).unwrap();
        let error = file.validate(&file.scene).unwrap_err().to_string();
        assert!(
            error.starts_with("a.toml, line 2, column 13 (elevation = 100): sun.elevation is 100; it must"),
            "{error}"
        );
        let mut flagged = file.scene.clone();
        flagged.sun.elevation = 200.0;
        let error = file.validate(&flagged).unwrap_err().to_string();
        assert!(error.starts_with("sun.elevation is 200"), "{error}");
    }

    #[test]
    fn a_file_overrides_single_keys_of_its_preset() {
        let text = "preset = \"paper\"\n[atmosphere.aerosol]\nscale_height = 2.0\n[camera]\nsize = \"64x32\"\n";
        let scene = Scene::parse(text, "scene.toml", None).unwrap();
        assert_eq!(scene.sun.spectrum, SunSpectrum::Flat);
        assert_eq!(scene.atmosphere.aerosol.scale_height, 2.0);
        assert_eq!(scene.atmosphere.aerosol.asymmetry, 0.8);
        assert_eq!(scene.camera.size, Size { width: 64, height: 32 });
    }

    #[test]
    fn every_scene_survives_a_round_trip_through_its_file() {
        for preset in Preset::iter() {
            let mut scene = Scene::preset(preset);
            scene.camera.fov = Some(100.0);
            scene.render.exposure = Exposure::Stops(-3.5);
            assert_eq!(Scene::parse(&toml::to_string(&scene).unwrap(), "scene.toml", None).unwrap(), scene);
        }
    }
}
