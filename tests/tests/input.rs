//! What a person gives, by the hundred thousand: no panic, no hang, no memory out of proportion. `fuzz/` looks further.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::sync::Mutex;
use std::time::Duration;

use clap::Parser;
use cpu_time::ThreadTime;
use peak_alloc::PeakAlloc;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use sorairo::low_level::spectra::table::Table;
use sorairo::scene::file::text;
use sorairo::scene::keys::{KEYS, Key};
use sorairo::scene::{Preset, Scene, reference};
use sorairo_cli::arguments as cli;
use sorairo_cli::flags::flag;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// One property at a time, or their memory could not be told apart.
static ALONE: Mutex<()> = Mutex::new(());

/// Most time that a processor works at one case, however long that waits for other work on a busy machine. They take
/// milliseconds; what grows with the square of the largest files takes minutes.
const LONGEST: Duration = Duration::from_secs(5);

/// Most memory for one case: the largest scenes here have 256 KiB and take up to 90 times as much in the reader of
/// TOML; the largest tables have 4 MiB and take less.
const MOST_MEMORY: usize = 64 << 20;

/// Tries a property on `cases` inputs, and bounds each case's time and memory.
fn hold<S: Strategy>(cases: u32, strategy: S, property: impl Fn(S::Value)) {
    let _alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let mut runner = TestRunner::new(ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() });
    let tried = Cell::new(0);
    runner
        .run(&strategy, |input| {
            let before = MEMORY.current_usage();
            MEMORY.reset_peak_usage();
            let start = ThreadTime::now();
            property(input);
            let (time, memory) = (start.elapsed(), MEMORY.peak_usage().saturating_sub(before));
            prop_assert!(time < LONGEST, "{time:?}");
            prop_assert!(memory < MOST_MEMORY, "{memory} bytes");
            tried.set(tried.get() + 1);
            Ok(())
        })
        .unwrap_or_else(|error| panic!("{error}"));
    assert!(tried.get() >= cases);
}

/// A text as a scene file: refused in one sentence with its place, or a scene that survives its own file.
fn scene_or_sentence(input: &str) {
    match Scene::parse(input, "a.toml", None) {
        Ok(scene) => match scene.validated() {
            Ok(scene) => {
                let again = Scene::parse(&text(&scene), "b.toml", None).expect("a scene's own file is a scene");
                assert_eq!(again, *scene);
            }
            Err(error) => assert_eq!(error.to_string().lines().count(), 1),
        },
        Err(error) => {
            let sentence = error.to_string();
            assert!(sentence.lines().count() == 1 && sentence.len() < 2000, "{sentence}");
        }
    }
}

/// A text as a table: refused in one sentence, or finite values of 0 or more.
fn table_or_sentence(input: &str) {
    match Table::<1>::parse(input) {
        Ok(table) => {
            let (first, last) = table.range();
            assert!(first < last && [first, 550.0, last].iter().all(|&wavelength| table.at(wavelength)[0] >= 0.0));
        }
        Err(sentence) => assert!(sentence.lines().count() == 1 && sentence.len() < 500, "{sentence}"),
    }
}

/// Values that scenes, tables and flags find hard, and some that they do not.
fn value() -> impl Strategy<Value = String> {
    let mut fixed: Vec<String> = KEYS.iter().flat_map(Key::words).map(|word| word.name.to_owned()).collect();
    let hard = [
        "",
        "nan",
        "inf",
        "-inf",
        "1e308",
        "-0",
        "1e-320",
        "0x10",
        "1_000",
        "9223372036854775808",
        "true",
        "auto",
        "64x32",
        "0x0",
        "8388608x1",
        "43.06,141.35",
        "2026-06-21T04:30:00+09:00",
        "0000-01-01T00:00:00Z",
        "9999-12-31T23:59:60Z",
        "x.csv",
        ".csv",
        "/",
        "[1, 2]",
        "[[",
        "{ a = 1 }",
        "é空\u{0}",
        "450,550,650,700",
        "400:700:1",
    ];
    fixed.extend(hard.map(str::to_owned));
    prop_oneof![
        prop::sample::select(fixed),
        any::<f64>().prop_map(|number| number.to_string()),
        any::<i64>().prop_map(|n| n.to_string()),
        "\\PC{0,12}"
    ]
}

/// A line of a scene file: mostly a key with a value, sometimes a table or anything.
fn line() -> impl Strategy<Value = String> {
    let mut names: Vec<String> =
        KEYS.iter().flat_map(|key| [key.name.to_owned(), key.table_and_name().1.to_owned()]).collect();
    let tables: Vec<String> = KEYS.iter().map(|key| format!("[{}]", key.table_and_name().0)).collect();
    names.extend(["elevatoin", "a.b.c.d", "\"\"", "sun"].map(str::to_owned));
    prop_oneof![
        6 => (prop::sample::select(names), value(), prop::sample::select(vec!["", "\"", "'"]))
            .prop_map(|(name, value, quote)| format!("{name} = {quote}{value}{quote}")),
        2 => prop::sample::select(tables),
        1 => "\\PC{0,30}",
    ]
}

#[test]
fn any_bytes_as_a_scene_file_are_refused_in_a_sentence() {
    hold(20_000, prop::collection::vec(any::<u8>(), 0..400), |bytes| {
        scene_or_sentence(&String::from_utf8_lossy(&bytes))
    });
}

#[test]
fn any_lines_of_keys_are_a_scene_or_a_sentence() {
    hold(25_000, prop::collection::vec(line(), 0..8), |lines| scene_or_sentence(&lines.join("\n")));
}

#[test]
fn a_mutated_scene_file_is_a_scene_or_a_sentence() {
    let files = [Preset::Earth, Preset::Mars].map(reference::commented);
    // What is cut out, where, and what is put in its place.
    let mutation =
        (0.0..1.0, 0..40_usize, prop_oneof![line(), value(), "\\PC{0,6}", Just("\n".into()), Just("\"".into())]);
    hold(15_000, (0..2_usize, prop::collection::vec(mutation, 1..4)), |(file, mutations)| {
        let mut text = files[file].clone();
        for (at, cut, put) in mutations {
            let from = text.floor_char_boundary((at * text.len() as f64) as usize);
            let to = text.floor_char_boundary((from + cut).min(text.len()));
            text.replace_range(from..to, &put);
        }
        scene_or_sentence(&text);
    });
}

#[test]
fn any_table_is_read_or_refused_in_a_sentence() {
    hold(20_000, prop::collection::vec(any::<u8>(), 0..400), |bytes| {
        table_or_sentence(&String::from_utf8_lossy(&bytes))
    });
    let number = || prop_oneof![(0.0..2000.0).prop_map(|number: f64| number.to_string()), value()];
    let row = (number(), number(), prop::sample::select(vec!["\n", "\r\n", ",", "\n#", "\r", " \n\n"]));
    hold(20_000, prop::collection::vec(row, 0..20), |rows| {
        let text: String = rows.iter().map(|(wavelength, value, end)| format!("{wavelength},{value}{end}")).collect();
        table_or_sentence(&text);
    });
}

#[test]
fn the_largest_files_are_refused_in_a_moment() {
    const SCENE: usize = 256 << 10;
    const TABLE: usize = 4 << 20;
    let filled = |part: &str, size: usize| part.repeat(size / part.len());
    let scenes = [
        filled("[", SCENE),
        filled("a.", SCENE),
        filled("a={", SCENE),
        filled("\"", SCENE),
        filled("[a]\n", SCENE),
        filled("[[a]]\n", SCENE),
        filled("[sun]\nelevatoin = 1\n", SCENE),
        format!("a = {}", filled("[", SCENE)),
        format!("render.bands = [{}1]", filled("1,", SCENE)),
        format!("sun.elevation = {}", filled("9", SCENE)),
        format!("sun.{} = 1", filled("e", SCENE)),
        format!("sun.place = '{}'", filled("é", SCENE)),
        (0..60_000).map(|i| format!("elevatoin{i} = 1\n")).collect::<String>()[..SCENE].into(),
        (0..60_000).map(|i| format!("[sun.a{i}]\n")).collect::<String>()[..SCENE].into(),
    ];
    hold(scenes.len() as u32 * 4, prop::sample::select(scenes.to_vec()), |text| scene_or_sentence(&text));
    let tables = [
        filled(",", TABLE),
        filled("1\n", TABLE),
        filled("#\n", TABLE),
        format!("1,{}", filled("9", TABLE)),
        (0..300_000).map(|i| format!("{i},1\n")).collect::<String>() + "0,1\n",
    ];
    hold(tables.len() as u32 * 4, prop::sample::select(tables.to_vec()), |text| table_or_sentence(&text));
}

#[test]
fn any_flags_are_a_scene_or_refused() {
    let mut flags: Vec<String> = KEYS.iter().filter_map(|key| flag(key.name)).map(str::to_owned).collect();
    flags.extend(
        ["--scene", "--device", "-o", "--json", "--help", "--", "-", "--wavelengths", "--shell"].map(str::to_owned),
    );
    let argument = prop_oneof![3 => prop::sample::select(flags), 3 => value(), 1 => "\\PC{0,12}"];
    let commands =
        prop::sample::select(vec!["render", "spectrum", "bands", "scene", "show", "new", "man", "completions"]);
    hold(5_000, (commands, prop::collection::vec(argument.clone(), 0..7)), |(command, given)| {
        let arguments = ["sorairo", command].into_iter().chain(given.iter().map(String::as_str));
        let _ = cli::Arguments::try_parse_from(arguments);
    });
    hold(5_000, prop::collection::vec(argument, 0..7), |given| {
        let arguments = ["sorairo", "scene", "show"].into_iter().chain(given.iter().map(String::as_str));
        let Ok(arguments) = cli::Arguments::try_parse_from(arguments) else { return };
        // Without a file: this test reads none.
        if let cli::Command::Scene(cli::SceneCommand::Show { flags, .. }) = arguments.command {
            let _ = cli::scene(None, &flags.0);
        }
    });
}

/// What numbers and TOML find hard, as libFuzzer reads it.
const HARD: [&str; 17] = [
    r#""\"\"\"""#,
    r#""'''""#,
    r#""-inf""#,
    r#"".csv""#,
    r#""0x7fffffffffffffff""#,
    r#""1979-05-27T07:32:00Z""#,
    r#""1e308""#,
    r#""9223372036854775808""#,
    r#""= ""#,
    r#""[[""#,
    r#""\x0a""#,
    r#""\xef\xbb\xbf""#,
    r#""]]""#,
    r#""auto""#,
    r#""inf""#,
    r#""nan""#,
    r#""true""#,
];

#[test]
fn the_dictionary_of_the_fuzz_targets_holds_every_key_word_and_flag() {
    let parts = KEYS.iter().flat_map(|key| key.name.split('.'));
    let words = KEYS.iter().flat_map(Key::words).map(|word| word.name);
    let flags = KEYS.iter().filter_map(|key| flag(key.name));
    let named = parts.chain(words).chain(flags).map(|word| format!("\"{word}\""));
    let lines: BTreeSet<String> = named.chain(HARD.map(str::to_owned)).collect();
    let head = "# Keys, words and flags of a scene, and what numbers and TOML find hard.\n";
    let expected = lines.into_iter().fold(head.to_owned(), |text, line| text + &line + "\n");
    let kept = include_str!("../../fuzz/keys.dict");
    assert!(kept == expected, "fuzz/keys.dict is out of date; it should be\n{expected}");
}

/// A line break was written as in Rust, and libFuzzer refused the whole dictionary: no target ran.
#[test]
fn the_dictionary_of_the_fuzz_targets_is_one_that_libfuzzer_reads() {
    let lines = include_str!("../../fuzz/keys.dict").lines();
    let lines: Vec<&str> = lines.filter(|line| !line.is_empty() && !line.starts_with('#')).collect();
    assert!(lines.len() > 50, "{} words", lines.len());
    for line in lines {
        assert!(is_word(line), "{line}");
    }
    assert!(!is_word(r#""\n""#) && is_word(r#""\x0a""#) && !is_word("air"));
}

/// Whether libFuzzer reads a line as a word: within quotes, where a backslash stands before itself, a quote or `x` and
/// two digits.
fn is_word(line: &str) -> bool {
    let Some(word) = line.strip_prefix('"').and_then(|line| line.strip_suffix('"')) else { return false };
    let mut escapes = word.replace(r"\\", "").replace(r#"\""#, "");
    while let Some(at) = escapes.find(r"\x") {
        if !escapes.get(at + 2..at + 4).is_some_and(|digits| digits.chars().all(|digit| digit.is_ascii_hexdigit())) {
            return false;
        }
        escapes.replace_range(at..at + 4, "");
    }
    !escapes.contains('\\') && !escapes.contains('"')
}

#[test]
fn nothing_in_a_scene_file_steers_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let long = "x".repeat(300);
    for (text, words) in [
        ("sun.elevation = \"a\u{1b}[2Jb\"\n".to_owned(), "\\u{1b}"),
        ("sun.elevation = \"\u{202e}b\"\n".to_owned(), "\\u{202e}"),
        (format!("sun.elevation = \"{long}\"\n"), "xxx..."),
    ] {
        std::fs::write(folder.path().join("s.toml"), text).unwrap();
        let ended = sorairo_tests::program::run(folder.path(), &["scene", "check", "s.toml"]);
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains(words), "{}", ended.stderr);
        let steers = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
        assert!(!ended.stderr.contains(steers) && ended.stderr.len() < 400, "{:?}", ended.stderr);
    }
}
