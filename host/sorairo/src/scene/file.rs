//! Scene files: from TOML to a scene, with the position of every error.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::value::StringDeserializer;
use serde::{Deserialize, Deserializer};
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use super::keys::{self, Allowed, KEYS, Key};
use super::preset::{Preset, Scene};
use super::valid::ValidScene;
use crate::error::{Error, PlaceInFile, Result};
use crate::input::{self, LARGEST_SCENE};
use crate::spectra::named_file::is_table_file;

/// The largest number of errors reported for a file.
const MOST_PROBLEMS: usize = 20;

/// A scene as it is being said: a preset, under a scene file, under single values.
#[derive(Clone, Debug)]
pub struct Draft {
    scene: Scene,
    text: Arc<SourceText>,
    /// Where the value of each key stands in the text.
    spans: Spans,
    /// The keys whose values were said, in the text or since.
    said: BTreeSet<&'static str>,
}

/// A text and the name of its file.
#[derive(Debug, Default)]
struct SourceText {
    name: String,
    text: String,
    /// To which the names of its CSV files are relative.
    folder: PathBuf,
}

impl Scene {
    /// The scene in a TOML text. `preset` overrides the preset of the text; names of CSV files are relative to the
    /// working folder.
    ///
    /// # Errors
    ///
    /// [`Error::InFile`] with the position in `source` for an unknown key or a value of the wrong type.
    pub fn parse(text: &str, source: &str, preset: Option<Preset>) -> Result<Self> {
        Draft::parse(text, source, Path::new("."), preset).map(|draft| draft.scene).map_err(first)
    }

    /// The scene in a TOML file; see [`Scene::parse`]. Names of CSV files are relative to its folder.
    ///
    /// # Errors
    ///
    /// [`Error::SceneFile`] if the file cannot be read, [`Error::InFile`] if it is not a scene.
    pub fn read(path: &Path, preset: Option<Preset>) -> Result<Self> {
        Draft::read(path, preset).map(|draft| draft.scene)
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

impl Draft {
    /// The scene of a preset.
    pub fn of(preset: Preset) -> Self {
        Self { scene: Scene::preset(preset), text: Arc::default(), spans: Spans::new(), said: BTreeSet::new() }
    }

    /// Reads a file; see [`Draft::parse`].
    ///
    /// # Errors
    ///
    /// The first problem.
    pub fn read(path: &Path, preset: Option<Preset>) -> Result<Self> {
        Self::read_all(path, preset).map_err(first)
    }

    /// Reads a TOML text over its preset. `preset` takes the place of the one that the text names; names of CSV files
    /// are relative to `folder`.
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
        let text =
            SourceText { name: source.into(), text: input::without_mark(text).into(), folder: folder.to_owned() };
        let (scene, spans) = text.scene(preset)?;
        Ok(Self { scene, text: text.into(), said: spans.keys().copied().collect(), spans })
    }

    /// The same file over another preset, without what was set since.
    ///
    /// # Errors
    ///
    /// Those of [`Draft::read`] for tables of the file, which are read again.
    pub fn with_preset(&self, preset: Preset) -> Result<Self> {
        let (scene, spans) = self.text.scene(Some(preset)).map_err(first)?;
        Ok(Self { scene, text: Arc::clone(&self.text), said: spans.keys().copied().collect(), spans })
    }

    /// Every problem of a file by itself, without flags: none if it is a scene.
    pub fn problems(path: &Path) -> Vec<Error> {
        let draft = match Self::read_all(path, None) {
            Ok(draft) => draft,
            Err(problems) => return problems,
        };
        let problems = keys::problems(&draft.scene);
        if problems.is_empty() {
            return draft.validated().err().into_iter().collect();
        }
        problems.into_iter().map(|problem| draft.located(problem)).collect()
    }

    fn read_all(path: &Path, preset: Option<Preset>) -> std::result::Result<Self, Vec<Error>> {
        let text = input::read_text(path, LARGEST_SCENE)
            .map_err(|reason| vec![Error::SceneFile { path: path.to_owned(), reason }])?;
        Self::parse(&text, &path.to_string_lossy(), path.parent().unwrap_or(Path::new("")), preset)
    }

    /// The scene so far.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Takes a value of a key.
    ///
    /// # Errors
    ///
    /// [`Error::Text`] if it is of another kind, [`Error::NotAllowed`] for the preset, over which other values may have
    /// been set.
    pub fn set<'de>(&mut self, key: &Key, value: impl Deserializer<'de>) -> Result<()> {
        if key.name == "preset" {
            return Err(Error::not_allowed("preset", "is the start of a scene and cannot be changed afterwards"));
        }
        if key.name.starts_with(AEROSOL_KEYS) && key.name != MODES && !self.scene.atmosphere.aerosol.modes.is_empty() {
            let complaint = "describes an aerosol by keys, and the scene lists its aerosols or reads one from AERONET";
            return Err(Error::not_allowed(key.name, complaint));
        }
        self.spans.remove(key.name);
        key.set(&mut self.scene, value).map_err(|error| match error {
            Error::Text(complaint) => wrong(in_plain_words(&complaint)),
            other => other,
        })?;
        self.said.insert(key.name);
        self.scene.imply(|key| self.said.contains(key));
        keys::change_names(&mut self.scene, |file| file.name_from(&self.text.folder));
        Ok(())
    }

    /// Refuses an elevation, an azimuth or a distance that was set over a place or a time, as a file may not hold both;
    /// `is_set` tells by a key's name.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] for such a key.
    pub fn refuse_two_suns(&self, is_set: impl Fn(&str) -> bool) -> Result<()> {
        let sun = &self.scene.sun;
        let there = [("sun.place", sun.place.is_some()), ("sun.time", sun.time.is_some())];
        let Some((from, _)) = there.into_iter().find(|(_, is_there)| *is_there) else { return Ok(()) };
        match SUN_POSITION.into_iter().find(|key| is_set(key)) {
            Some(key) => Err(Error::not_allowed(
                key,
                format!("cannot be given beside {from}: a place and a time determine the sun's direction and distance"),
            )),
            None => Ok(()),
        }
    }

    /// The scene, checked; see [`Scene::validated`].
    ///
    /// # Errors
    ///
    /// Those of [`Scene::validated`], with their place where the value stands in the file.
    pub fn validated(&self) -> Result<ValidScene> {
        self.scene.validated().map_err(|problem| self.located(problem))
    }

    /// What is wrong with a key, with its place if its value stands in the file.
    fn located(&self, problem: Error) -> Error {
        let (Error::OutOfRange { key, .. } | Error::NotAllowed { key, .. }) = &problem else { return problem };
        match self.spans.get(key) {
            Some(span) => self.text.problem(span.start, problem),
            None => problem,
        }
    }
}

/// The problems found so far, each with its byte of the text.
struct Problems<'a> {
    text: &'a SourceText,
    found: Vec<(usize, Error)>,
}

impl Problems<'_> {
    fn add(&mut self, at: usize, error: Error) {
        self.found.push((at, error));
    }

    /// In the order of the text, no more than anyone reads, and how many more there are.
    fn told(mut self) -> Vec<Error> {
        self.found.sort_by_key(|(at, _)| *at);
        let more = self.found.len().saturating_sub(MOST_PROBLEMS);
        let told = self.found.into_iter().take(MOST_PROBLEMS).map(|(at, error)| self.text.problem(at, error));
        let rest = (more > 0).then(|| Error::Text(format!("{}: {more} more like these", self.text.name)));
        told.chain(rest).collect()
    }
}

type Spans = BTreeMap<&'static str, Range<usize>>;

impl SourceText {
    /// The scene that the text says over its preset, and where each key's value stands.
    fn scene(&self, preset: Option<Preset>) -> std::result::Result<(Scene, Spans), Vec<Error>> {
        let document = DeTable::parse(&self.text).map_err(|error| {
            vec![self.problem(error.span().map_or(0, |span| span.start), wrong(in_plain_words(error.message())))]
        })?;
        let mut problems = Problems { text: self, found: Vec::new() };
        let mut given = Vec::new();
        collect(document.get_ref(), "", &mut given, &mut problems);
        let preset = preset.unwrap_or_else(|| named_preset(&given));
        let mut scene = Scene::preset(preset);
        let mut spans = Spans::new();
        for (key, value) in &given {
            spans.insert(key.name, value.span());
            if let Err(error) = lay_over(&mut scene, key, value, &self.folder) {
                problems.add(value.span().start, wrong(in_plain_words(&error.to_string())));
            }
        }
        keys::change_names(&mut scene, |file| file.name_from(&self.folder));
        refuse_two_suns(&given, &mut problems);
        if !problems.found.is_empty() {
            return Err(problems.told());
        }
        scene.preset = preset;
        scene.imply(|key| spans.contains_key(key));
        Ok((scene, spans))
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

/// What a reader says is wrong, without the rest of long values that it quotes, and without its middle if it is long
/// all the same.
fn wrong(complaint: String) -> Error {
    Error::Text(without_middle(&with_short_values(&complaint)))
}

/// A sentence whose quoted values are cut where they are longer than anyone reads.
fn with_short_values(sentence: &str) -> String {
    const MOST: usize = 80;
    let parts = sentence.split('"').enumerate().map(|(i, part)| {
        let is_value = i % 2 == 1 && part.chars().count() > MOST;
        if is_value { part.chars().take(MOST - 3).chain("...".chars()).collect() } else { part.to_owned() }
    });
    parts.collect::<Vec<_>>().join("\"")
}

type Given<'a> = (&'static Key, &'a Spanned<DeValue<'a>>);

/// Finds the keys of a table and of those in it.
fn collect<'a>(table: &'a DeTable<'a>, prefix: &str, given: &mut Vec<Given<'a>>, problems: &mut Problems<'_>) {
    for (key, value) in table {
        let name = format!("{prefix}{}", key.get_ref());
        let inside = format!("{name}.");
        let is_table = KEYS.iter().any(|key| key.name.starts_with(&inside));
        match (keys::find(&name), value.get_ref()) {
            (None, DeValue::Array(_)) if inside == AEROSOL_KEYS => {
                given.push((keys::find(MODES).expect("a key"), value));
            }
            (Some(key), _) => given.push((key, value)),
            (None, DeValue::Table(table)) if is_table => collect(table, &inside, given, problems),
            (None, _) if is_table => {
                problems.add(value.span().start, wrong(format!("`{name}` must be a table of keys")));
            }
            (None, _) => problems.add(key.span().start, unknown(prefix, key.get_ref())),
        }
    }
}

/// Where the keys of one aerosol stand, and that of several, which in a file is the array `[[atmosphere.aerosol]]`.
const AEROSOL_KEYS: &str = "atmosphere.aerosol.";
const MODES: &str = "atmosphere.aerosol.modes";

/// The key of a name with its tables, as in `sun.elevation`.
///
/// # Errors
///
/// [`Error::UnknownKey`] if there is none.
pub fn key(name: &str) -> Result<&'static Key> {
    let name = if AEROSOL_KEYS.strip_suffix('.') == Some(name) { MODES } else { name };
    let tables = name.rfind('.').map_or("", |dot| &name[..=dot]);
    let prefix = if KEYS.iter().any(|key| key.name.starts_with(tables)) { tables } else { "" };
    keys::find(name).ok_or_else(|| unknown(prefix, name.strip_prefix(prefix).unwrap_or(name)))
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
        Some(same) if same == name => format!("`{same}` belongs outside of all tables"),
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
    named.and_then(|(key, value)| key.word_or(value.get_ref().as_str()?).parse().ok()).unwrap_or_default()
}

/// Lays one value over a scene, if it is of the right kind.
fn lay_over(scene: &mut Scene, key: &Key, value: &Spanned<DeValue<'_>>, folder: &Path) -> Result<()> {
    let text = match (&key.allowed, value.get_ref()) {
        (_, DeValue::String(name)) if key.is_file(name) => path_from(folder, name)?,
        (_, DeValue::Array(modes)) if key.name == MODES => {
            let rooted = modes.iter().map(|mode| with_paths(mode, folder)).collect::<Result<Vec<_>>>()?;
            return key.set(scene, toml::Value::Array(rooted));
        }
        // A place or a time that is none is quoted as it stands, whatever TOML takes it for.
        (Allowed::Other(_), _) if ["sun.place", "sun.time"].contains(&key.name) => as_it_stands(value),
        (_, DeValue::String(text)) => key.word_or(text).to_owned(),
        _ => return key.set(scene, ValueDeserializer::from(value.clone())),
    };
    key.set(scene, StringDeserializer::<serde::de::value::Error>::new(text))
}

/// The path of a user table from the root, from its name in a file of a folder.
fn path_from(folder: &Path, name: &str) -> Result<String> {
    let complaint = |error: io::Error| match error.kind() {
        io::ErrorKind::Unsupported => {
            format!("{name}: a table is a file, and none is available here; use a word or a number")
        }
        _ => format!("{name}: {error}"),
    };
    let path = std::path::absolute(folder.join(name)).map_err(|error| Error::Text(complaint(error)))?;
    Ok(path.to_string_lossy().into_owned())
}

/// A table whose names of files are paths from the root.
fn with_paths(table: &Spanned<DeValue<'_>>, folder: &Path) -> Result<toml::Value> {
    let read = toml::Value::deserialize(ValueDeserializer::from(table.clone()));
    let mut value = read.map_err(|error| Error::Text(error.message().to_owned()))?;
    for (key, text) in value.as_table_mut().into_iter().flatten() {
        if let toml::Value::String(name) = text
            && (key == "aeronet" || is_table_file(name))
        {
            *name = path_from(folder, name)?;
        }
    }
    Ok(value)
}

/// A text, or a date of TOML as text; anything else as it stands in TOML.
fn as_it_stands(value: &Spanned<DeValue<'_>>) -> String {
    match value.get_ref() {
        DeValue::String(text) => text.to_string(),
        DeValue::Datetime(time) => time.to_string(),
        _ => match toml::Value::deserialize(ValueDeserializer::from(value.clone())) {
            Ok(value) => shortened(&value.to_string()),
            Err(error) => in_plain_words(error.message()),
        },
    }
}

/// The keys for which a place and a time stand.
const SUN_POSITION: [&str; 3] = ["sun.elevation", "sun.azimuth", "sun.distance"];

/// Refuses an elevation, an azimuth or a distance beside a place or a time.
fn refuse_two_suns(given: &[Given<'_>], problems: &mut Problems<'_>) {
    let find = |name: &str| given.iter().find(|(key, _)| key.name == name);
    let Some((from, _)) = find("sun.place").or_else(|| find("sun.time")) else { return };
    for name in SUN_POSITION {
        if let Some((_, value)) = find(name) {
            let complaint = format!(
                "`{name}` and `{}` cannot both be given: a place and a time determine the sun's direction and distance",
                from.name
            );
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
        match Draft::parse(text, "a.toml", Path::new("."), None) {
            Ok(draft) => draft.validated().unwrap_err().to_string(),
            Err(problems) => first(problems).to_string(),
        }
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
            ("[sun]\npreset = 'earth'", "unknown key `preset`; `preset` belongs outside of all tables"),
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
        let problems = |text: &str| Draft::parse(text, "a.toml", Path::new(""), None).unwrap_err();
        assert_eq!(problems("sun.elevatoin = 1\nsun.azimuth = 'x'\nmoon = 2").len(), 3);
        let many: String = (0..1000).map(|i| format!("moon{i} = 1\n")).collect();
        let many = problems(&many);
        assert_eq!(many.len(), MOST_PROBLEMS + 1);
        assert!(many[1].to_string().contains("line 2,"), "{}", many[1]);
        assert_eq!(many[MOST_PROBLEMS].to_string(), "a.toml: 980 more like these");
    }

    #[test]
    fn place_and_time_give_the_sun_and_refuse_another() {
        let sun = |text: &str| Scene::parse(text, "a.toml", None).unwrap().validated().unwrap();
        let placed = sun("[sun]\nplace = '43.06,141.35'\ntime = 2026-06-21T04:30:00+09:00");
        let quoted = sun("[sun]\nplace = '43.06,141.35'\ntime = '2026-06-20T19:30:00Z'");
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
            (
                "[sun]\nplace = '43,141'\ntime = 2026-06-21T04:30:00Z\ndistance = 1",
                "line 4, column 12 (distance = 1): `sun.distance` and `sun.place`",
            ),
        ];
        for (text, words) in cases {
            assert!(refused(text).contains(words), "{text:?}: {}", refused(text));
        }
    }

    #[test]
    fn a_value_out_of_range_is_named_with_its_place_unless_a_flag_gave_it() {
        let mut draft = Draft::parse("[sun]\nelevation = 100", "a.toml", Path::new(""), None).unwrap();
        let error = draft.validated().unwrap_err().to_string();
        assert!(
            error.starts_with("a.toml, line 2, column 13 (elevation = 100): sun.elevation is 100; it must"),
            "{error}"
        );
        let value = serde::de::value::F64Deserializer::<serde::de::value::Error>::new(200.0);
        draft.set(keys::find("sun.elevation").unwrap(), value).unwrap();
        let error = draft.validated().unwrap_err().to_string();
        assert!(error.starts_with("sun.elevation is 200"), "{error}");
    }

    #[test]
    fn a_word_is_read_in_any_case_of_letters() {
        let read = |text: &str| Scene::parse(text, "scene.toml", None).unwrap();
        let words = "preset = 'mars'\n[camera]\nprojection = 'fisheye'\n[render]\nview = 'agx'\norders = 'all'\n";
        assert_eq!(read(&words.replace("mars", "MARS").replace("fish", "Fish").replace("agx", "AgX")), read(words));
        assert_eq!(read("render.exposure = 'AUTO'\nrender.orders = 'All'"), read(""));
        assert!(refused("render.view = 'AgY'").contains("unknown variant `AgY`"));
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

    fn draft_of(modes: &str, folder: &Path) -> std::result::Result<Draft, String> {
        Draft::parse(modes, "a.toml", folder, None).map_err(|problems| problems[0].to_string())
    }

    /// What is wrong with a list of modes.
    fn complaint(modes: &str) -> String {
        match draft_of(modes, Path::new(".")) {
            Ok(draft) => draft.validated().unwrap_err().to_string(),
            Err(complaint) => complaint,
        }
    }

    #[test]
    fn modes_are_written_as_they_are_read() {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [
            ("phase.csv", "angle_deg,440,675\n0,40,30\n10,9,8\n60,1,1\n180,0.4,0.5\n"),
            ("levels.csv", "altitude_km,density\n0,1\n2,1\n3,0\n"),
            ("ext.csv", "wavelength_nm,extinction\n440,0.5\n675,0.25\n"),
        ] {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let modes = "[[atmosphere.aerosol]]\nkind = 'desert'\nprofile = [2.0, 4.0]\n[[atmosphere.aerosol]]\noptical_depth = 0.1\n\
                     extinction = 'ext.csv'\nphase_function = 'phase.csv'\nprofile = 'levels.csv'\nsingle_scattering_albedo = 'urban'\n";
        let draft = draft_of(modes, folder.path()).unwrap();
        let scene = draft.validated().unwrap().into_scene();
        let aerosol = &scene.atmosphere.aerosol;
        assert_eq!(aerosol.modes.len(), 2);
        assert!(text(&scene).contains("[[atmosphere.aerosol]]"), "{}", text(&scene));
        let again = Scene::parse(&text(&scene), "again.toml", None).unwrap();
        assert_eq!(again.atmosphere.aerosol.modes, aerosol.modes);
        assert!(toml::from_str::<Scene>(&text(&scene)).unwrap().atmosphere.aerosol.modes == aerosol.modes);
        // Phase functions to any scale have a mean of 1 over the sphere.
        let phase = scene.optics().aerosol;
        let moments = phase.phase().unwrap().moments(1);
        assert!((moments[0] - 1.0).abs() < 1e-9 && (0.3..0.9).contains(&moments[1]), "{moments:?}");
    }

    #[test]
    fn what_is_wrong_with_a_mode_is_one_sentence() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.csv");
        std::fs::write(&path, "angle_deg,440\n0,40\n90,-999\n180,1\n").unwrap();
        let mode = |keys: &str| complaint(&format!("[[atmosphere.aerosol]]\n{keys}\n"));
        for (found, words) in [
            (
                mode("optical_depth = -1"),
                "atmosphere.aerosol has a mode whose optical_depth is -1; it must lie between 0 and 1000",
            ),
            (mode("profile = 2.0"), "has a mode with neither a kind nor an optical_depth"),
            (mode("kind = 'urban'\nprofile = [3.0, 2.0]"), "a layer is 0.5 km thick or more"),
            (mode("kind = 'urban'\ncolour = 1"), "unknown field `colour`"),
            (mode("kind = 'urban'\nphase_function = 'dust'"), "\"dust\" is no kind of aerosol"),
            (mode(&format!("kind = 'urban'\nphase_function = '{}'", path.display())), "line 3: column 2 is \"-999\""),
            (
                complaint(
                    "atmosphere.profile = 'exponential'\n[[atmosphere.aerosol]]\nkind = 'urban'\nprofile = [2.0, 3.0]\n",
                ),
                "which needs a measured atmosphere.profile",
            ),
        ] {
            assert!(found.contains(words), "{found}\nwithout: {words}");
        }
        let mut draft = draft_of("[[atmosphere.aerosol]]\nkind = 'urban'\n", folder.path()).unwrap();
        let key = keys::find("atmosphere.aerosol.optical_depth").unwrap();
        let number = serde::de::value::F64Deserializer::<serde::de::value::Error>::new(0.1);
        let refused = draft.set(key, number).unwrap_err().to_string();
        assert!(refused.contains("the scene lists its aerosols"), "{refused}");
    }
}
