//! Sequences: what their frames show, which of them are rendered again, and what a part, a failure and an interruption
//! leave.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant, SystemTime};

use rayon::prelude::*;
use serde_json::Value;
use sorairo::low_level::files::{Format, Spectra, is_finished};
use sorairo::scene::keys::KEYS;
use sorairo::scene::{ExrDepth, Scene};
use sorairo_cli::flags::flag;
use sorairo_tests::program::{Ended, command, contents, read_exr, read_png, run, succeed};
use sorairo_tests::wait;
use tempfile::{TempDir, tempdir};

/// Ten frames, each a picture and a linear image.
const TEN: &str = "sequence --device cpu --size 48x24 --sun-elevation -6:12:2 -o f/sky.####.png -o f/sky.####.exr";

fn folder() -> TempDir {
    tempdir().expect("a folder for temporary files")
}

fn words(line: &str) -> Vec<&str> {
    line.split(' ').collect()
}

/// Runs a sequence successfully, and gives its summary.
fn sequence(folder: &Path, line: &str) -> Value {
    let ended = succeed(folder, &[&words(line)[..], &["--json"]].concat());
    assert_eq!(ended.stdout.lines().count(), 1, "{}", ended.stdout);
    serde_json::from_str(&ended.stdout).expect("JSON")
}

/// Frames that a run rendered and skipped.
fn counts(summary: &Value) -> (u64, u64) {
    let count = |key: &str| summary[key].as_u64().unwrap_or_else(|| panic!("{key}: {summary}"));
    (count("rendered"), count("skipped"))
}

/// Runs a sequence successfully, and gives the same from its words: JSON tells the light of each frame too, which takes
/// as long as many frames.
fn counted(folder: &Path, line: &str) -> (u64, u64) {
    let said = succeed(folder, &words(line)).stderr;
    let summary = said.lines().find(|line| line.contains(" frames rendered, ")).expect("a summary");
    let said: Vec<&str> = summary.split(' ').collect();
    let before = |word: &str| said[said.iter().position(|said| *said == word).unwrap() - 1].parse().unwrap();
    (before("frames"), before("skipped,"))
}

/// When each file of a folder took its place.
fn times(folder: &Path) -> BTreeMap<String, SystemTime> {
    let name = |name: &String| (name.clone(), std::fs::metadata(folder.join(name)).unwrap().modified().unwrap());
    contents(folder).keys().map(name).collect()
}

/// The frames that have a file with another time than before, and those that had none.
fn touched(folder: &Path, before: &BTreeMap<String, SystemTime>) -> Vec<String> {
    let mut frames: Vec<_> = times(folder)
        .iter()
        .filter(|(name, time)| before.get(*name) != Some(time))
        .filter_map(|(name, _)| Some(name.strip_prefix("sky.")?.split('.').next()?.to_owned()))
        .collect();
    frames.dedup();
    frames
}

#[test]
fn each_frame_of_a_sun_that_is_split_off_is_the_two_files_of_render_and_is_whole_with_both() {
    let folder = folder();
    let sky = "--device cpu --size 48x24 --split-sun --exposure adapt";
    let line = format!("sequence {sky} --sun-elevation 2:6:2 -o f/sky.#.png -o f/sky.#.exr");
    let summary = sequence(folder.path(), &line);
    assert_eq!(counts(&summary), (3, 0));
    let outputs = ["f/sky.1.png", "f/sky.1.exr", "f/sky.1.sun.png", "f/sky.1.sun.exr"];
    let frame = &summary["frames"][1];
    assert_eq!((&frame["outputs"], &frame["sun_disc"]), (&serde_json::json!(outputs), &Value::Bool(false)));
    succeed(folder.path(), &words(&format!("render {sky} --sun-elevation 4 -o f/sky.9.png -o f/sky.9.exr")));
    let files = contents(&folder.path().join("f"));
    for kind in ["png", "exr", "sun.png", "sun.exr"] {
        assert!(files[&format!("sky.1.{kind}")] == files[&format!("sky.9.{kind}")], "{kind}");
    }
    assert_eq!(counted(folder.path(), &line), (0, 3));
    // Without its sheet nothing is known of the files but what stands in them.
    std::fs::remove_file(folder.path().join("f/contact.png")).unwrap();
    assert_eq!(counted(folder.path(), &line), (0, 3));
    std::fs::remove_file(folder.path().join("f/sky.2.sun.exr")).unwrap();
    assert_eq!(counted(folder.path(), &line), (1, 2));
    // Frames of one file have a sun of another kind.
    let whole = line.replace(" --split-sun", "").replace(" --exposure", " --sun-disc --exposure");
    assert_eq!(counted(folder.path(), &whole), (3, 0));
}

#[test]
fn every_frame_is_byte_for_byte_the_rendering_of_its_scene() {
    for device in ["cpu", "gpu"] {
        let folder = folder();
        let common = ["--size", "64x32", "--altitude", "1", "--sun-azimuth", "30", "--device", device];
        let elevations = ["sequence", "--sun-elevation", "0.3:-0.3:0.1", "-o", "frames/sky.##.png", "-o", "e/#.exr"];
        let own = ["--exposure", "auto"];
        let ended = succeed(folder.path(), &[&elevations[..], &common, &own].concat());
        assert!(ended.stdout.is_empty() && ended.stderr.contains("7 frames rendered, 0 skipped, of 7"), "{ended:?}");
        let frames = contents(&folder.path().join("frames"));
        let linear = contents(&folder.path().join("e"));
        assert_eq!(
            frames.keys().collect::<Vec<_>>(),
            [
                "contact.png",
                "sky.00.png",
                "sky.01.png",
                "sky.02.png",
                "sky.03.png",
                "sky.04.png",
                "sky.05.png",
                "sky.06.png"
            ]
        );
        for (number, elevation) in ["0.3", "0.2", "0.1", "0", "-0.1", "-0.2", "-0.3"].iter().enumerate() {
            let one = ["render", "--sun-elevation", elevation, "-o", "one.png", "-o", "one.exr"];
            succeed(folder.path(), &[&one[..], &common].concat());
            let one = contents(folder.path());
            assert!(frames[&format!("sky.{number:02}.png")] == one["one.png"], "{device}: picture of {elevation}");
            assert!(linear[&format!("{number}.exr")] == one["one.exr"], "{device}: linear image of {elevation}");
        }
    }
}

#[test]
fn through_time_each_frame_is_the_rendering_at_its_place_and_moment() {
    let folder = folder();
    let common = ["--place", "43.06,141.35", "--size", "32x16", "--device", "cpu"];
    let line =
        "sequence --from 2026-06-21T03:30:00+09:00 --to 2026-06-20T20:00:00Z --frames 4 -o t/#.exr --exposure auto";
    succeed(folder.path(), &[&words(line)[..], &common].concat());
    let frames = contents(&folder.path().join("t"));
    assert_eq!(frames.keys().collect::<Vec<_>>(), ["0.exr", "1.exr", "2.exr", "3.exr", "contact.png"]);
    // Every half hour, whatever the offset from UTC is written as.
    for (number, time) in ["03:30:00+09:00", "04:00:00+09:00", "04:30:00+09:00", "05:00:00+09:00"].iter().enumerate() {
        let time = format!("2026-06-21T{time}");
        succeed(folder.path(), &[&["render", "--time", &time, "-o", "one.exr"], &common[..]].concat());
        assert!(frames[&format!("{number}.exr")] == contents(folder.path())["one.exr"], "{time}");
    }
    // A scene file may name the place.
    std::fs::write(folder.path().join("scene.toml"), "[sun]\nplace = '43.06,141.35'").unwrap();
    assert_eq!(counted(folder.path(), &format!("{line} --scene scene.toml --size 32x16 --device cpu")), (0, 4));
}

/// The exposures (stops) of the frames that a run lists.
fn exposures(summary: &Value) -> Vec<f64> {
    let frames = summary["frames"].as_array().expect("a list of frames");
    frames.iter().map(|frame| frame["exposure_ev"].as_f64().expect("an exposure")).collect()
}

#[test]
fn a_time_lapse_gets_dark() {
    let folder = folder();
    let line = |sun: &str, rest: &str| {
        format!("sequence --device cpu --preset earth --size 24x12 --orders 1 --sun-elevation {sun} -o {rest}")
    };
    let mean = |name: &str| {
        let picture = read_png(&folder.path().join(name));
        picture.rgb.iter().map(|&value| f64::from(value)).sum::<f64>() / picture.rgb.len() as f64
    };
    let one = sequence(folder.path(), &line("4:-8:4", "one/#.png --exposure sequence"));
    let adapted = sequence(folder.path(), &line("4:-8:4", "adapted/#.png"));
    for frames in ["one", "adapted"] {
        let brightness: Vec<f64> = (0..4).map(|i| mean(&format!("{frames}/{i}.png"))).collect();
        // An eye that adapts loses a third of each stop by which the light falls.
        let left = if frames == "one" { 0.8 } else { 0.95 };
        assert!(brightness.windows(2).all(|pair| pair[1] < left * pair[0]), "{frames}: {brightness:?}");
    }
    let shared = exposures(&one);
    // Of the frame with the highest sun, to a hundredth of a stop.
    let report = succeed(
        folder.path(),
        &words("render --device cpu --preset earth --size 24x12 --orders 1 --sun-elevation 4 -o a.png --json"),
    );
    let highest = serde_json::from_str::<Value>(&report.stdout).unwrap()["exposure_ev"].as_f64().unwrap();
    assert!(
        shared.iter().all(|&ev| ev == shared[0]) && (shared[0] - highest).abs() <= 0.005 + 1e-4,
        "{shared:?} {highest}"
    );
    // A sun that rises has the same exposure, and so has a part of its way by itself.
    let rising = sequence(folder.path(), &line("-8:4:4", "two/#.png --exposure sequence --frames 1-2"));
    assert_eq!((exposures(&rising), counts(&rising)), (shared[..2].to_vec(), (2, 0)));
    assert_eq!(counted(folder.path(), &line("-8:4:4", "two/#.png --exposure sequence")), (2, 2));
    let first = exposures(&sequence(folder.path(), &line("-8:4:4", "first/#.png --exposure first")));
    assert!(first.iter().all(|&ev| ev == first[0]) && first[0] > shared[0] + 3.0, "{first:?}");
    let own = exposures(&sequence(folder.path(), &line("4:-8:4", "own/#.png --exposure auto")));
    assert!(own.windows(2).all(|pair| pair[1] > pair[0] + 0.5), "{own:?}");
    // From each frame's own light, to the hundredth of a stop that a list tells, so that parts of a sequence agree.
    let daylight = (0.18 * 683.0 / 4096.0f64).log2();
    for (adapted, own) in exposures(&adapted).into_iter().zip(own) {
        assert!((adapted - daylight - 0.62 * (own - daylight)).abs() <= 0.02, "{adapted}, {own}");
    }
    assert_eq!(exposures(&sequence(folder.path(), &line("4:0:4", "stops/#.png --exposure -2.5"))), [-2.5; 2]);
    let wrong = run(folder.path(), &words(&line("4:0:4", "wrong/#.png --exposure bright")));
    assert!(wrong.code == Some(2) && wrong.stderr.contains("auto, adapt, first, sequence"), "{}", wrong.stderr);
}

#[test]
fn json_lists_the_frames_whether_rendered_or_found() {
    let folder = folder();
    let line = "sequence --device cpu --size 8x4 --orders 1 --sun-elevation 0:10:5 --sun-disc -o #.exr -o #.png";
    let (rendered, found) = (sequence(folder.path(), line), sequence(folder.path(), line));
    assert_eq!((&rendered["count"], counts(&rendered), counts(&found)), (&3.into(), (3, 0), (0, 3)));
    for i in 0..3 {
        let (frame, again) = (&rendered["frames"][i], &found["frames"][i]);
        assert_eq!((&frame["number"], &frame["sun_elevation"]), (&i.into(), &(5.0 * i as f64).into()));
        assert_eq!(frame["outputs"], Value::from(vec![format!("{i}.exr"), format!("{i}.png")]));
        assert!(frame["sun_disc"] == true && frame["irradiance_w_m2"].as_f64().unwrap() > 0.0, "{frame}");
        let mut expected = frame.clone();
        expected["rendered"] = false.into();
        assert_eq!(*again, expected);
    }
}

#[test]
fn a_file_keeps_the_place_and_the_time_of_its_sun_and_says_how_it_is_rendered_again() {
    let folder = folder();
    let line = "render --device cpu --size 8x4 --place 43.06,141.35 --time 2026-06-21T04:30+09:00 -o a.png -o a.exr";
    succeed(folder.path(), &words(line));
    let png = std::fs::read(folder.path().join("a.png")).unwrap();
    let text = String::from_utf8_lossy(&png).into_owned();
    let scene = text.split("preset = ").nth(1).map(|rest| format!("preset = {rest}")).expect("a scene");
    let end = "# sun.place = \"43.06,141.35\"\n# sun.time = \"2026-06-21T04:30:00+09:00\"\n";
    let length = scene.find(end).expect("place and time") + end.len();
    std::fs::write(folder.path().join("again.toml"), &scene[..length]).unwrap();
    succeed(folder.path(), &words("render --device cpu --scene again.toml -o b.exr"));
    let pixels = |name: &str| read_exr(&folder.path().join(name)).0;
    assert_eq!(pixels("a.exr"), pixels("b.exr"));
}

#[test]
fn only_frames_that_are_missing_damaged_or_of_another_scene_are_rendered_again() {
    let folder = folder();
    let frames = folder.path().join("f");
    let first = sequence(folder.path(), TEN);
    assert_eq!((counts(&first), first["contact_sheet"].as_str()), ((10, 0), Some("f/contact.png")));
    let whole = contents(&frames);

    let before = times(&frames);
    assert_eq!(counted(folder.path(), TEN), (0, 10));
    assert_eq!(touched(&frames, &before), [""; 0]);

    let spoil = |name: &str, change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = whole[name].clone();
        change(&mut bytes);
        std::fs::write(frames.join(name), bytes).unwrap();
    };
    std::fs::remove_file(frames.join("sky.0001.png")).unwrap();
    spoil("sky.0003.exr", &|bytes| bytes.truncate(bytes.len() - 1));
    spoil("sky.0004.png", &|bytes| bytes.truncate(bytes.len() - 1));
    spoil("sky.0006.png", &|bytes| bytes.clear());
    spoil("sky.0007.exr", &|bytes| *bytes.last_mut().unwrap() ^= 1);
    // A picture of another moment.
    spoil("sky.0008.png", &|bytes| bytes.clone_from(&whole["sky.0009.png"]));
    let before = times(&frames);
    assert_eq!(counted(folder.path(), TEN), (6, 4));
    assert_eq!(touched(&frames, &before), ["0001", "0003", "0004", "0006", "0007", "0008"]);
    assert!(contents(&frames) == whole);

    let before = times(&frames);
    let hazier = format!("{TEN} --preset hazy --frames 2-3 --frames 5-5");
    assert_eq!(counted(folder.path(), &hazier), (3, 0));
    assert_eq!(touched(&frames, &before), ["0002", "0003", "0005"]);
    assert_eq!(counted(folder.path(), TEN), (3, 7));
    assert!(contents(&frames) == whole);
}

#[test]
fn a_file_with_any_byte_changed_missing_or_added_is_not_finished() {
    let folder = folder();
    let mut scene = Scene::default();
    (scene.sun.elevation, scene.camera.size) = (5.0, "6x4".parse().unwrap());
    let line = "render --device cpu --size 6x4 --sun-elevation 5";
    succeed(folder.path(), &words(&format!("{line} -o 0.png -o 0.exr -o 0.spectral.exr --wavelengths 450,550")));
    succeed(folder.path(), &words(&format!("{line} --exr f16 -o half.exr")));
    let mut halves = scene.clone();
    halves.render.exr = ExrDepth::Half;
    let path = folder.path().join("spoilt");
    for (name, scene) in [("0.png", &scene), ("0.exr", &scene), ("0.spectral.exr", &scene), ("half.exr", &halves)] {
        let bytes = std::fs::read(folder.path().join(name)).unwrap();
        let format = Format::of(Path::new(name), false).unwrap();
        let wavelengths = if format == Format::SpectralExr { vec![450.0, 550.0] } else { Vec::new() };
        let spectra = Spectra { wavelengths, ..Spectra::default() };
        let is_finished = |bytes: &[u8]| {
            // A file system may wait for its disk where a file is truncated, not where it is new.
            std::fs::remove_file(&path).ok();
            std::fs::write(&path, bytes).unwrap();
            is_finished(&path, format, scene, &spectra)
        };
        assert!(is_finished(&bytes), "{name}");
        let check = |how: &str, at: usize, start: &[u8], middle: &[u8], rest: &[u8]| {
            assert!(!is_finished(&[start, middle, rest].concat()), "{name}, {how} at {at} of {}", bytes.len());
        };
        for at in 0..bytes.len() {
            let (start, byte, rest) = (&bytes[..at], bytes[at], &bytes[at + 1..]);
            check("cut off", at, start, &[], &[]);
            check("a byte missing", at, start, &[], rest);
            [1, 0x10, 0x80].iter().for_each(|bit| check("a bit changed", at, start, &[byte ^ bit], rest));
            [0, byte].iter().for_each(|&added| check("a byte added", at, start, &[added, byte], rest));
        }
        [0, b'\n', 0xff].iter().for_each(|&added| check("a byte added", bytes.len(), &bytes, &[added], &[]));
    }
}

#[test]
fn frames_are_rendered_again_when_a_table_of_ones_own_holds_something_else() {
    let keys: Vec<_> = KEYS.iter().filter(|key| key.takes_table()).map(|key| key.name).collect();
    assert!(keys.len() >= 4, "{keys:?}");
    keys.par_iter().for_each(|key| {
        let folder = folder();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("scene.toml", &format!("{key} = 't.csv'\ncamera.size = '8x4'\nrender.orders = 2\n"));
        write("cases.csv", "sun.elevation\n0\n1\n");
        let unit = if key.ends_with("cross_section") { "e-25" } else { "" };
        let lines = [
            "--sun-elevation 0:1:1 --exposure -5 -o stops/#.exr -o stops/#.png",
            "--sun-elevation 0:1:1 --exposure auto --wavelengths 450,500,550,600 -o auto/#.hsr",
            "--table cases.csv -o table/#.exr",
        ];
        for (table, expected) in [
            (format!("300,0.5{unit}\n900,0.5{unit}"), (2, 0)),
            (format!("# the same\n300,0.5{unit}\n900,0.5{unit}\n"), (0, 2)),
            (format!("300,0.5{unit}\n900,0.25{unit}"), (2, 0)),
        ] {
            write("t.csv", &table);
            for line in lines {
                let found = counted(folder.path(), &format!("sequence --device cpu --scene scene.toml {line}"));
                assert_eq!(found, expected, "{key}, {line}: {table:?}");
            }
        }
    });
}

#[test]
fn a_file_names_tables_as_they_are_found_from_its_scene_and_nothing_of_the_machine() {
    let folder = folder();
    let path = folder.path();
    for name in ["scenes", "scenes/own", "tables"] {
        std::fs::create_dir(path.join(name)).unwrap();
    }
    for (name, value) in [("scenes/own/ground.csv", "0.5"), ("tables/sun.csv", "1"), ("tables/ozone.csv", "5e-25")] {
        std::fs::write(path.join(name), format!("300,{value}\n900,{value}\n")).unwrap();
    }
    let scene = format!(
        "sun.spectrum = '{}'\natmosphere.ozone.cross_section = '../tables/ozone.csv'\ncamera.size = '8x4'\n",
        path.join("tables/sun.csv").display()
    );
    std::fs::write(path.join("scenes/scene.toml"), scene).unwrap();
    let line = "render --device cpu --scene scenes/scene.toml --albedo scenes/own/ground.csv -o";
    let files = ["a.png", "a.exr", "a.spectral.exr", "a.hsr"];
    succeed(path, &[words(line), words(&files.join(" -o "))].concat());
    let holds = |bytes: &[u8], text: &str| bytes.windows(text.len()).any(|part| part == text.as_bytes());
    for file in files {
        let bytes = std::fs::read(path.join(file)).unwrap();
        for name in ["\"../tables/sun.csv\"", "\"../tables/ozone.csv\"", "\"own/ground.csv\""] {
            assert!(holds(&bytes, name), "{file}: no {name}");
        }
        assert!(!holds(&bytes, path.to_str().unwrap()), "{file} names a folder of the machine");
    }
}

#[test]
fn spectral_frames_hold_the_wavelengths_that_were_asked_for() {
    let folder = folder();
    let line = "sequence --device cpu --size 16x8 --sun-elevation 0:2:1 -o #.exr --spectral --exposure auto";
    for (wavelengths, expected) in [("450,550", (3, 0)), ("450,550", (0, 3)), ("450,560", (3, 0))] {
        let found = counted(folder.path(), &format!("{line} --wavelengths {wavelengths}"));
        assert_eq!(found, expected, "{wavelengths}");
    }
    let mut scene = Scene::default();
    (scene.sun.elevation, scene.camera.size) = (0.0, "16x8".parse().unwrap());
    assert!(is_finished(
        &folder.path().join("0.exr"),
        Format::SpectralExr,
        &scene,
        &Spectra { wavelengths: vec![450.0, 560.0], ..Spectra::default() }
    ));
}

#[test]
fn parts_by_two_processes_are_the_whole_and_the_last_leaves_the_contact_sheet() {
    let (whole, parts) = (folder(), folder());
    counted(whole.path(), TEN);
    // While a frame is missing there is no sheet.
    let first = sequence(parts.path(), &format!("{TEN} --frames 5-9"));
    assert_eq!((counts(&first), &first["contact_sheet"]), ((5, 0), &Value::Null));
    assert!(!parts.path().join("f/contact.png").exists());
    let start = |part: &str| {
        command(parts.path(), &words(&format!("{TEN} --frames {part}")))
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts")
    };
    for child in [start("0-4"), start("5-9")] {
        let ended: Ended = child.wait_with_output().unwrap().into();
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    }
    assert!(contents(&parts.path().join("f")) == contents(&whole.path().join("f")));
}

#[test]
fn a_frame_a_task_is_byte_for_byte_the_whole_and_the_last_task_leaves_sheet_and_manifest() {
    let (whole, parts) = (folder(), folder());
    let line = "sequence --device cpu --size 48x24 --table cases.csv -o f/####.png -o f/####.exr";
    for folder in [&whole, &parts] {
        std::fs::write(folder.path().join("cases.csv"), CASES).unwrap();
    }
    counted(whole.path(), line);
    // In no order, as a farm starts its tasks.
    for (number, sheet) in [("2", None), ("0", None), ("1", Some("f/contact.png"))] {
        let summary = sequence(parts.path(), &format!("{line} --frame {number}"));
        assert_eq!((counts(&summary), summary["contact_sheet"].as_str()), ((1, 0), sheet), "{number}: {summary}");
        assert_eq!(summary["manifest"].is_string(), sheet.is_some(), "{number}: {summary}");
    }
    let frames = parts.path().join("f");
    assert!(contents(&frames) == contents(&whole.path().join("f")));
    // A task that is run again when all is done leaves everything, and what is missing it makes.
    let before = times(&frames);
    assert_eq!(counted(parts.path(), &format!("{line} --frame 1")), (0, 1));
    assert!(times(&frames) == before);
    for lost in ["contact.png", "manifest.csv"] {
        std::fs::remove_file(frames.join(lost)).unwrap();
        assert_eq!(counted(parts.path(), &format!("{line} --frame 1")), (0, 1));
        assert!(contents(&frames) == contents(&whole.path().join("f")), "{lost}");
    }
    // Numbers and parts together, and beside the number of frames between two times.
    let times = "sequence --device cpu --size 8x4 --place 43,141 --from 2026-06-21T03:00:00Z --to 2026-06-21T04:00:00Z -o t/#.png";
    assert_eq!(counted(parts.path(), &format!("{times} --frames 9 --frames 2-3 --frame 8 --frame 3")), (3, 0));
    assert_eq!(contents(&parts.path().join("t")).keys().collect::<Vec<_>>(), ["2.png", "3.png", "8.png"]);
}

/// Three tasks of a farm, all of whose frames are there, and the summary of the second run again.
const TASK: &str = "sequence --device cpu --orders 1 --size 48x24 --table cases.csv -o f/#.png --frame 1";

#[test]
fn a_frame_that_changed_and_kept_its_old_time_is_noticed() {
    let folder = folder();
    let frames = folder.path().join("f");
    std::fs::write(folder.path().join("cases.csv"), CASES).unwrap();
    sequence(folder.path(), TASK.trim_end_matches(" --frame 1"));
    assert!(sequence(folder.path(), TASK)["contact_sheet"].is_string());
    // Another task's frame is spoilt, and has the time that it had, as after a copy that keeps times.
    let spoilt = frames.join("2.png");
    let time = std::fs::metadata(&spoilt).unwrap().modified().unwrap();
    let mut bytes = std::fs::read(&spoilt).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&spoilt, bytes).unwrap();
    std::fs::File::options().write(true).open(&spoilt).unwrap().set_modified(time).unwrap();
    let summary = sequence(folder.path(), TASK);
    assert_eq!((&summary["contact_sheet"], &summary["manifest"]), (&Value::Null, &Value::Null), "{summary}");
}

#[test]
fn the_frames_of_another_table_are_not_taken_for_those_of_this_one() {
    let folder = folder();
    std::fs::write(folder.path().join("cases.csv"), CASES).unwrap();
    sequence(folder.path(), TASK.trim_end_matches(" --frame 1"));
    // The last case alone is another.
    let (same, last) = CASES.trim_end().rsplit_once('\n').unwrap();
    let other = last.replacen(|c: char| c.is_ascii_digit(), "1", 1);
    assert_ne!(last, other);
    std::fs::write(folder.path().join("cases.csv"), format!("{same}\n{other}\n")).unwrap();
    let summary = sequence(folder.path(), TASK);
    assert_eq!((counts(&summary), &summary["contact_sheet"]), ((0, 1), &Value::Null), "{summary}");
}

#[test]
fn the_contact_sheet_shows_at_most_64_frames_and_the_sky() {
    let folder = folder();
    let line = "sequence --device cpu --size 8x4 --sun-elevation 0:70:1 -o #.png";
    assert_eq!(counted(folder.path(), line), (71, 0));
    let sheet = read_png(&folder.path().join("contact.png"));
    // Eight by eight cells of 192 by 96 pixels, 20 for a label below each, gaps of 6.
    assert_eq!((sheet.width, sheet.height), (6 + 8 * 198, 6 + 8 * 122));
    let blue = |column: usize, row: usize| sheet.at(6 + 198 * column + 96, 6 + 122 * row + 5);
    for (column, row) in [(0, 1), (7, 1), (3, 4), (0, 7), (7, 7)] {
        let [red, _, blue] = blue(column, row);
        assert!(red > 0 && blue > red, "the zenith of frame {column}, {row} is blue: {red} {blue}");
    }
    let dark = |pixels: &[u8]| pixels.iter().filter(|&&value| value < 128).count();
    let labels: Vec<u8> = (102..122)
        .flat_map(|row| (0..sheet.width).flat_map(move |x| [(x, row)]))
        .flat_map(|(x, y)| sheet.at(x, y))
        .collect();
    assert!(dark(&labels) > 100, "no labels");
}

#[test]
fn a_wrong_sequence_exits_with_2_and_one_sentence() {
    let there = folder();
    std::fs::write(there.path().join("taken"), "").unwrap();
    let range = "--from 2026-06-21T04:00:00Z --to 2026-06-21T05:00:00Z";
    let from_to = |rest: &str| format!("{range} {rest}");
    let table: &[(&str, &[&str])] = &[
        ("", &["--sun-elevation", "--from", "--help"]),
        ("--sun-elevation 5", &["--sun-elevation", "\"5\"", "A:B:STEP"]),
        ("--sun-elevation 0:5:0", &["--sun-elevation", "0:5:0", "A:B:STEP"]),
        ("--sun-elevation 0:5:-1", &["--sun-elevation", "0:5:-1", "A:B:STEP"]),
        ("--sun-elevation 0:90:1e-9", &["--sun-elevation", "at most 100000"]),
        ("--sun-elevation 80:100:5", &["--sun-elevation", "95", "between -90 and 90"]),
        ("--sun-elevation 0:5:1 --place 43,141", &["--sun-elevation", "--place", "cannot be used"]),
        ("--sun-elevation 0:5:1 --frames 6", &["--frames 6", "--sun-elevation"]),
        ("--sun-elevation 0:5:1 --frames 3-6", &["--frames 3-6", "6 frames", "0 to 5"]),
        ("--sun-elevation 0:5:1 --frame 6", &["--frame 6", "6 frames", "0 to 5"]),
        ("--sun-elevation 0:5:1 --frame 2 --frame 7 --frames 0-3", &["--frame 7", "0 to 5"]),
        ("--sun-elevation 0:5:1 --frame -1", &["-1", "--frame"]),
        ("--sun-elevation 0:5:1 --frame 1-2", &["--frame", "1-2"]),
        ("--sun-elevation 0:5:1 --frames 5-3", &["--frames", "5-3", "0-9"]),
        ("--sun-elevation 0:5:1 --frames some", &["--frames", "some", "48"]),
        ("--sun-elevation 0:5:1 -o sky.png", &["-o sky.png", "#", "sky.####.exr"]),
        ("--sun-elevation 0:5:1 -o a#b#.png", &["-o a#b#.png", "one run of #"]),
        ("--sun-elevation 0:5:1 -o sky.#.jpg", &["-o sky.#.jpg", ".png, .exr, .hdr, .hsr, .rad or .usda"]),
        ("--sun-elevation 0:5:1 -o #.png -o #.png", &["-o 0.png", "a name of its own"]),
        ("--sun-elevation 0:5:1 -o taken/#.png", &["-o taken/0.png", "folder taken cannot be made"]),
        ("--sun-elevation 0:5:1 --altitude -1", &["--altitude", "-1", "between 0 and 100000 km"]),
        ("--sun-elevation 0:5:1 --device abacus", &["--device", "abacus", "auto", "cpu"]),
        ("--from noon", &["--from", "noon", "offset from UTC"]),
        ("--from 2026-06-21T04:00:00Z", &["--to", "required"]),
        (&from_to("--frames 3"), &["--from and --to", "--place"]),
        (&from_to("--place 43,141"), &["--from and --to", "--frames N"]),
        (&from_to("--place 43,141 --frames 0-9"), &["--from and --to", "--frames N"]),
        (&from_to("--place 43,141 --frames 1"), &["--frames 1", "2 to 100000"]),
        (&from_to("--place 43,141 --frames 100001"), &["--frames 100001", "2 to 100000"]),
        (&from_to("--place 43,141 --frames 3 --frames 4"), &["--frames 3", "--frames 4", "once"]),
        (&from_to("--place 43,141 --frames 3 --sun-elevation 0:5:1"), &["--sun-elevation", "--from", "cannot be used"]),
        (&from_to("--place 43,141 --frames 3 --sun-azimuth 5"), &["--sun-azimuth", "cannot be used"]),
        (
            "--from 2026-06-21T05:00:00Z --to 2026-06-21T13:59:00+09:00 --place 43,141 --frames 3",
            &["--to 2026-06-21T13:59:00+09:00", "later", "--from 2026-06-21T05:00:00"],
        ),
    ];
    for (flags, named) in table {
        let device = if flags.contains("--device") { "" } else { " --device cpu" };
        let line = format!("sequence {flags}{device}");
        let ended = run(there.path(), &line.split_whitespace().collect::<Vec<_>>());
        assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""), "{flags}: {}", ended.stderr);
        match ended.stderr.strip_prefix("sorairo: ") {
            Some(sentence) => assert_eq!(sentence.trim_end().lines().count(), 1, "{flags}: {sentence}"),
            // The parser of the flags adds where to find help.
            None => assert!(ended.stderr.starts_with("error: ") && ended.stderr.contains("--help"), "{}", ended.stderr),
        }
        for part in *named {
            assert!(ended.stderr.contains(part), "{flags}: no {part:?} in {}", ended.stderr);
        }
        assert_eq!(contents(there.path()).keys().collect::<Vec<_>>(), ["taken"], "{flags}");
    }
}

#[test]
fn a_failure_names_its_frame_and_leaves_the_frames_before_it() {
    let folder = folder();
    let frames = folder.path().join("f");
    std::fs::create_dir_all(frames.join("sky.0003.png")).unwrap();
    // Without the progress, which says a line on a slow machine.
    let ended = run(folder.path(), &words(&format!("{TEN} --quiet")));
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    assert_eq!(ended.stderr, "sorairo: frame 3: -o f/sky.0003.png cannot be written: it is a folder\n");
    let left: Vec<_> = contents(&frames).into_keys().collect();
    let expected = [0, 1, 2].map(|n| [format!("sky.000{n}.exr"), format!("sky.000{n}.png")]).concat();
    assert_eq!(left, [&expected[..], &["sky.0003.png".into()]].concat());
    std::fs::remove_dir(frames.join("sky.0003.png")).unwrap();
    assert_eq!(counted(folder.path(), TEN), (7, 3));
}

#[cfg(unix)]
#[test]
fn an_interruption_leaves_whole_frames_from_which_the_next_run_goes_on() {
    let folder = folder();
    let frames = folder.path().join("f");
    let long = "sequence --device cpu --size 640x320 --sun-elevation 0:90:0.1 -o f/####.png -o f/####.exr";
    let child = command(folder.path(), &words(long)).stderr(Stdio::piped()).spawn().expect("the program starts");
    // The hundreds of frames that are left take far longer than a signal.
    wait::until("the third frame", || frames.join("0002.png").exists());
    let sent = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let ended: Ended = child.wait_with_output().unwrap().into();
    assert_eq!(ended.code, Some(130), "{}", ended.stderr);
    assert!(
        ended.stderr.ends_with("sorairo: interrupted; files that were not finished are removed\n"),
        "{}",
        ended.stderr
    );
    let left = contents(&frames);
    assert!(
        left.len() >= 5 && left.len() < 1800 && left.keys().all(|name| !name.starts_with('.')),
        "{:?}",
        left.keys()
    );
    let found = counted(folder.path(), &format!("{long} --frames 0-2"));
    // The third picture may have taken its place without its linear image.
    assert!([(0, 3), (1, 2)].contains(&found), "{found:?}");
}

#[test]
fn progress_is_a_line_now_and_then_with_rate_and_time_left() {
    let folder = folder();
    // So many slow frames that they end only when they are killed.
    let line = "sequence --device cpu --path direct --steps 1024 --size 64x32 --sun-elevation 0:90:0.01 -o #.png";
    let began = Instant::now();
    let mut command = command(folder.path(), &words(line));
    let mut child = command.env("RAYON_NUM_THREADS", "1").stderr(Stdio::piped()).spawn().expect("the program starts");
    let lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let mut told = 0;
    // Before the first frame is done nobody knows how long they take.
    let with_rest = lines.inspect(|_| told += 1).find(|line| line.contains(" left"));
    let took = began.elapsed();
    child.kill().unwrap();
    child.wait().unwrap();
    let line = with_rest.expect("a line before the end");
    assert!(
        line.starts_with("sorairo: ") && line.contains(" of 9001 frames, ") && line.contains("; 0 skipped; "),
        "{line}"
    );
    assert!(line.contains(" frames/s, "), "{line}");
    // What makes it slow.
    assert!(line.contains(" direct, every pixel integrated, ") && line.ends_with(" frames/s"), "{line}");
    // Each comes two seconds after what was before, or later.
    assert!(told >= 1 && took >= told * Duration::from_secs(2), "{told} lines in {took:?}");
}

#[test]
fn a_quiet_sequence_says_nothing() {
    let folder = folder();
    let ended =
        succeed(folder.path(), &words("sequence --device cpu --size 64x32 --sun-elevation 0:1:1 -o #.png --quiet"));
    assert_eq!((ended.stdout, ended.stderr), (String::new(), String::new()));
}

const CASES: &str =
    "sun.elevation,atmosphere.aerosol.optical_depth,ground.albedo\n30,0.05,grass\n2,0.2,0.3\n-4,0,snow\n";

#[test]
fn a_table_is_a_sky_for_each_row_and_a_manifest_of_what_the_files_show() {
    let folder = folder();
    std::fs::write(folder.path().join("cases.csv"), CASES).unwrap();
    std::fs::write(folder.path().join("base.toml"), "[camera]\nsize = '48x24'\n").unwrap();
    let line = "sequence --device cpu --scene base.toml --table cases.csv -o f/####.exr -o f/####.png";
    let first = sequence(folder.path(), line);
    assert_eq!(counts(&first), (3, 0));
    let single = "render --device cpu --scene base.toml --sun-elevation 2 --albedo 0.3 -o one.exr -o one.png --json";
    let scene = "[camera]\nsize = '48x24'\n[atmosphere.aerosol]\noptical_depth = 0.2\n";
    std::fs::write(folder.path().join("one.toml"), scene).unwrap();
    let report = succeed(folder.path(), &words(&single.replace("base.toml", "one.toml")));
    let report: Value = serde_json::from_str(&report.stdout).unwrap();
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("f/0001.png"), bytes("one.png"));
    let manifest = String::from_utf8(bytes("f/manifest.csv")).unwrap();
    let rows: Vec<Vec<&str>> = manifest.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 1 + 3 * 2, "{manifest}");
    assert_eq!(rows[0][..4], ["frame", "sun.elevation", "atmosphere.aerosol.optical_depth", "ground.albedo"]);
    let column = |name: &str| rows[0].iter().position(|column| *column == name).unwrap();
    let of_second = &rows[3];
    assert_eq!((of_second[0], of_second[1], of_second[column("file")]), ("1", "2", "0001.exr"));
    for name in ["irradiance_w_m2", "direct_irradiance_w_m2", "luminance_zenith_cd_m2"] {
        let (found, expected) = (of_second[column(name)].parse::<f64>().unwrap(), report[name].as_f64().unwrap());
        assert!(found > 0.0 && (found / expected - 1.0).abs() < 1e-12, "{name}: {found}, not {expected}");
    }
    // What is whole is left, and what the manifest says stays what it was.
    std::fs::remove_file(folder.path().join("f/0002.exr")).unwrap();
    assert_eq!(counted(folder.path(), line), (1, 2));
    assert_eq!(String::from_utf8(bytes("f/manifest.csv")).unwrap(), manifest);
}

#[test]
fn a_manifest_that_is_not_whole_is_written_anew() {
    let folder = folder();
    let (manifest, sheet) = (folder.path().join("f/manifest.csv"), folder.path().join("f/contact.png"));
    std::fs::write(folder.path().join("cases.csv"), "sun.elevation,ground.albedo\n30,0.5\n2,snow\n").unwrap();
    let line = "sequence --device cpu --orders 1 --size 8x4 --table cases.csv -o f/#.png -o f/#.exr";
    counted(folder.path(), line);
    let whole = contents(&folder.path().join("f"));
    let text = std::fs::read_to_string(&manifest).unwrap();
    let without_column =
        |text: &str| -> String { text.lines().map(|line| format!("{}\n", line.split_once(',').unwrap().1)).collect() };
    let with_last_columns = |text: &str| -> String {
        let last = |line: &str| line.rsplitn(3, ',').take(2).map(str::to_owned).collect::<Vec<_>>();
        text.lines().map(last).map(|last| format!("{},{}\n", last[1], last[0])).collect()
    };
    let (first, rest) = text.split_once('\n').unwrap();
    let digit = rest.rfind(|c: char| c.is_ascii_digit()).unwrap();
    let spoilt = [
        ("two columns", with_last_columns(&text)),
        ("a missing column", without_column(&text)),
        ("nothing", String::new()),
        ("a header alone", format!("{first}\n")),
        ("an edited number", text.replacen("30,0.5", "31,0.5", 1)),
        ("an edited checksum", format!("{first}\n{}x{}", &rest[..digit], &rest[digit + 1..])),
        ("no last line", text.trim_end().rsplit_once('\n').unwrap().0.to_owned()),
        ("quotes", format!("{text}\"")),
    ];
    for (how, spoilt) in &spoilt {
        assert_ne!(spoilt, &text, "{how}");
        for has_sheet in [true, false] {
            std::fs::write(&manifest, spoilt).unwrap();
            if !has_sheet {
                std::fs::remove_file(&sheet).unwrap();
            }
            for task in ["", " --frame 1"] {
                assert_eq!(counted(folder.path(), &format!("{line}{task}")).0, 0, "{how}");
                assert!(contents(&folder.path().join("f")) == whole, "{how}, with the sheet: {has_sheet}{task}");
            }
        }
    }
}

#[test]
fn a_manifest_of_another_program_is_refused_before_any_work() {
    let folder = folder();
    let (frames, manifest) = (folder.path().join("f"), folder.path().join("f/manifest.csv"));
    std::fs::write(folder.path().join("cases.csv"), CASES).unwrap();
    std::fs::create_dir(&frames).unwrap();
    let line = "sequence --device cpu --orders 1 --size 8x4 --table cases.csv -o f/#.png";
    // The last is a person's own table of cases.
    for foreign in ["mine", "name,sha256\nsky.png,00\n", "\n", "\u{0}\u{1}", "frame,\"", CASES] {
        std::fs::write(&manifest, foreign).unwrap();
        for flags in ["", " --frame 1", " --no-clobber"] {
            let ended = run(folder.path(), &words(&format!("{line}{flags}")));
            let sentence = "f/manifest.csv exists, and sorairo did not write it as it stands; --force replaces it";
            assert_eq!(ended.code, Some(2), "{foreign}{flags}: {}", ended.stderr);
            assert!(ended.stderr.contains(sentence) && ended.stderr.lines().count() == 1, "{}", ended.stderr);
            assert_eq!(contents(&frames).into_values().collect::<Vec<_>>(), [foreign.as_bytes()], "{foreign}{flags}");
        }
    }
    assert_eq!(counted(folder.path(), &format!("{line} --force")), (3, 0));
    let whole = contents(&frames);
    assert!(whole["manifest.csv"].starts_with(b"frame,sun.elevation,"));
    // That of another table is its own, and --no-clobber keeps it.
    std::fs::write(folder.path().join("cases.csv"), CASES.replace("30,", "31,")).unwrap();
    std::fs::remove_file(frames.join("0.png")).unwrap();
    std::fs::remove_file(frames.join("contact.png")).unwrap();
    let kept = run(folder.path(), &words(&format!("{line} --no-clobber")));
    assert!(kept.code == Some(2) && kept.stderr.contains("f/manifest.csv exists; choose"), "{}", kept.stderr);
    assert_eq!(contents(&frames)["manifest.csv"], whole["manifest.csv"]);
    assert_eq!(counted(folder.path(), line), (0, 3));
    assert!(contents(&frames)["manifest.csv"] != whole["manifest.csv"]);
}

#[test]
fn a_wrong_row_of_a_table_is_told_before_anything_is_rendered() {
    let folder = folder();
    for (table, words) in [
        (CASES.replace("0.3", "1.5"), "cases.csv, line 3, column 3: ground.albedo is 1.5; it must lie"),
        (CASES.replace("ground.albedo", "sun.elevation"), "line 1, column 3: sun.elevation stands there twice"),
        (CASES.replace("ground.albedo", "ground.colour"), "line 1, column 3: \"ground.colour\" is no key"),
    ] {
        std::fs::write(folder.path().join("cases.csv"), table).unwrap();
        let ended = run(folder.path(), &["sequence", "--table", "cases.csv", "-o", "f/####.exr"]);
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains(words) && ended.stderr.lines().count() == 1, "{}", ended.stderr);
        assert!(!folder.path().join("f").exists());
    }
}

/// A value of each key, as a scene file says it, and what stands beside it there.
const VALUES: [(&str, &str, &str); 70] = [
    ("preset", "'mars'", ""),
    ("sun.elevation", "3.5", ""),
    ("sun.apparent", "true", "atmosphere.profile = 'us-standard'\natmosphere.refraction = true\n"),
    ("sun.azimuth", "-20", ""),
    ("sun.place", "'43.06,141.35'", "sun.time = 2026-06-21T04:30:00+09:00\n"),
    ("sun.time", "2026-06-21T04:30:00+09:00", "sun.place = '43.06,141.35'\n"),
    ("sun.spectrum", "'flat'", ""),
    ("sun.distance", "1.5", ""),
    ("sun.disc", "true", ""),
    ("observer.altitude", "2.5", ""),
    ("site.altitude", "1.5", "atmosphere.profile = 'us-standard'\n"),
    ("atmosphere.ground_radius", "6370", ""),
    ("atmosphere.top_radius", "6450", ""),
    ("atmosphere.profile", "'us-standard'", ""),
    ("atmosphere.profile", "'tables/air.csv'", ""),
    ("atmosphere.refraction", "true", "atmosphere.profile = 'us-standard'\n"),
    ("atmosphere.air.scattering", "0.0012", ""),
    ("atmosphere.air.spectrum", "'fourth-power'", ""),
    ("atmosphere.air.pressure", "900", ""),
    ("atmosphere.air.scale_height", "7.5", ""),
    ("atmosphere.aerosol.kind", "'desert'", ""),
    ("atmosphere.aerosol.optical_depth", "0.2", ""),
    ("atmosphere.aerosol.angstrom_exponent", "0.5", ""),
    ("atmosphere.aerosol.scale_height", "1.5", ""),
    ("atmosphere.aerosol.single_scattering_albedo", "0.8", ""),
    ("atmosphere.aerosol.single_scattering_albedo_spectrum", "'mars-dust'", ""),
    ("atmosphere.aerosol.asymmetry", "-0.5", ""),
    ("atmosphere.aerosol.modes", "[{ kind = 'desert', optical_depth = 0.2 }]", ""),
    ("atmosphere.ozone.column", "500", ""),
    ("atmosphere.ozone.bottom", "12", ""),
    ("atmosphere.ozone.peak", "22", ""),
    ("atmosphere.ozone.top", "45.5", ""),
    ("atmosphere.ozone.cross_section", "'tables/ozone.csv'", ""),
    ("atmosphere.water.column", "2.5", "atmosphere.profile = 'us-standard'\n"),
    ("ground.albedo", "'tables/ground.csv'", ""),
    ("camera.projection", "'fisheye'", ""),
    ("camera.size", "'12x6'", ""),
    ("camera.fov", "100", "camera.projection = 'fisheye'\n"),
    ("camera.look_azimuth", "30", "camera.projection = 'fisheye'\n"),
    ("camera.look_elevation", "80", "camera.projection = 'fisheye'\n"),
    ("camera.roll", "20", "camera.projection = 'fisheye'\n"),
    ("camera.shift_x", "0.2", "camera.projection = 'perspective'\n"),
    ("camera.shift_y", "0.2", "camera.projection = 'perspective'\n"),
    ("camera.below", "'mirror'", ""),
    ("camera.below_color", "'0.3,0.2,0.1'", "camera.below = 'colour'\n"),
    ("render.orders", "2", ""),
    ("camera.polariser", "30", ""),
    ("camera.polariser_extinction", "100", "camera.polariser = 30\n"),
    ("render.polarisation", "'on'", ""),
    ("render.fit", "'cubic'", ""),
    ("render.bands", "[433, 525.5, 564, 632]", ""),
    ("render.color", "'solve'", "render.fit = 'cubic'\n"),
    ("render.steps", "7", ""),
    ("render.path", "'direct'", ""),
    ("render.exposure", "-3", ""),
    ("render.view", "'srgb'", ""),
    ("render.look", "'none'", ""),
    ("render.iso", "200", "render.shutter = '1/125'\nrender.aperture = 8\n"),
    ("render.shutter", "'1/125'", "render.iso = 200\nrender.aperture = 8\n"),
    ("render.aperture", "8", "render.shutter = 0.008\nrender.iso = 200\n"),
    ("render.purkinje", "true", "sun.elevation = -10\n"),
    ("render.display", "'display-p3'", "render.rgb = 'rec2020'\n"),
    ("render.dither", "'none'", ""),
    ("render.exr", "'f16'", ""),
    ("render.exr_compression", "'none'", ""),
    ("render.exr_exposure", "-2", ""),
    ("render.rgb", "'acescg'", ""),
    ("render.observer", "'cie2015'", ""),
    ("render.white_balance", "'d65'", "render.rgb = 'acescg'\n"),
    ("sun.disc", "false", "sun.disc = true\n"),
];

/// What a run writes into a folder of its own, with these files in it.
fn written(line: &[&str], files: &[(&str, &str)]) -> BTreeMap<String, Vec<u8>> {
    let folder = folder();
    std::fs::create_dir(folder.path().join("tables")).unwrap();
    let tables = [
        ("tables/ground.csv", "wavelength_nm,albedo\n380,0.1\n780,0.6\n"),
        ("tables/ozone.csv", "380,0\n600,5e-25\n780,1e-26\n"),
        ("tables/air.csv", "altitude_km,pressure_hpa,temperature_k\n0,990,290\n15,115,215\n45,1.4,265\n100,3e-4,195\n"),
    ];
    files.iter().chain(&tables).for_each(|(name, text)| std::fs::write(folder.path().join(name), text).unwrap());
    succeed(folder.path(), line);
    let pictures = contents(folder.path()).into_iter();
    pictures.filter(|(name, _)| name == "0.png" || name == "0.exr").collect()
}

#[test]
fn each_key_is_the_same_in_a_scene_by_its_flag_and_in_a_table() {
    assert!(KEYS.iter().all(|key| VALUES.iter().any(|(name, ..)| *name == key.name)), "a key without a value");
    VALUES.par_iter().for_each(|&(name, value, beside)| {
        let size = if name == "camera.size" { "" } else { "camera.size = '8x4'\n" };
        let orders = if name == "render.orders" { "" } else { "render.orders = 1\n" };
        let base = [beside, size, orders].concat();
        let files = ["-o", "0.png", "-o", "0.exr"];
        let render = ["render", "--device", "cpu", "--scene", "scene.toml"];
        let scene =
            if beside.contains(name) { base.replace("true", value) } else { format!("{name} = {value}\n{base}") };
        let expected = written(&[&render[..], &files].concat(), &[("scene.toml", &scene)]);
        assert_eq!(expected.len(), 2, "{name}");

        let said = value.trim_matches(['\'', '[', ']']);
        if let Some(flag) = flag(name).filter(|_| value != "false") {
            let at_its_wavelength = format!("{said}@1000");
            let given: &[&str] = match name {
                "sun.disc" | "sun.apparent" | "render.purkinje" | "atmosphere.refraction" => &[flag],
                "atmosphere.aerosol.optical_depth" => &[flag, &at_its_wavelength],
                _ => &[flag, said],
            };
            let by_flag = written(&[&render[..], &files, given].concat(), &[("scene.toml", &base)]);
            assert!(by_flag == expected, "{name} by {flag}");
        }

        let sequence =
            ["sequence", "--device", "cpu", "--scene", "scene.toml", "--table", "t.csv", "-o", "#.png", "-o", "#.exr"];
        let cells: &[&str] = match said {
            // As spreadsheets and Python write it.
            "true" => &["true", "TRUE", "True"],
            "false" => &["false", "FALSE", "False"],
            "7" => &["7", "7.0"],
            // A list of tables has no cell.
            _ if name == "atmosphere.aerosol.modes" => &[],
            said => &[said],
        };
        for cell in cells {
            let table = format!("{name}\n\"{cell}\"\n");
            let in_table = written(&sequence, &[("scene.toml", &base), ("t.csv", &table)]);
            assert!(in_table == expected, "{name} as {cell:?} in a table");
        }
    });
}

#[test]
fn no_file_takes_the_place_of_the_scene_file() {
    let folder = folder();
    let scene = "sun.elevation = 20.0\n";
    std::fs::create_dir(folder.path().join("f")).unwrap();
    for name in ["sc.png", "f/sc.0003.png", "f/contact.png"] {
        std::fs::write(folder.path().join(name), scene).unwrap();
    }
    for line in [
        "render --scene sc.png -o sc.png",
        "render --scene sc.png -o f/../sc.png",
        "sequence --scene f/sc.0003.png --sun-elevation 0:10:2 -o f/sc.####.png",
        "sequence --scene f/contact.png --sun-elevation 0:10:2 -o f/sky.####.png",
    ] {
        let ended = run(folder.path(), &words(line));
        assert_eq!(ended.code, Some(2), "{line}: {}", ended.stderr);
        assert!(ended.stderr.contains("this is the scene file"), "{line}: {}", ended.stderr);
    }
    for (name, text) in contents(folder.path()) {
        assert!(!name.ends_with(".png") || text == scene.as_bytes(), "{name}");
    }
}
