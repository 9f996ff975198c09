//! `sorairo stress`: what it promises.

use std::path::Path;

use serde_json::Value;
use sorairo_evaluation::stress::integral::integral;
use sorairo_evaluation::stress::scenes::refusals;
use sorairo_tests::program::{contents, run};
use tempfile::tempdir;

/// One turn of every sweep.
const SHORT: [&str; 5] = ["stress", "--minutes", "0", "--device", "cpu"];

fn report(folder: &Path) -> Value {
    let json = std::fs::read_to_string(folder.join("stress.json")).expect("a report");
    serde_json::from_str(&json).expect("JSON")
}

#[test]
fn a_short_run_tries_every_sweep() {
    let folder = tempdir().unwrap();
    let ended = run(folder.path(), &SHORT);
    let out = folder.path().join("stress");
    let files: Vec<String> = contents(&out).into_keys().collect();
    for file in ["integral.png", "report.md", "solve.png", "stress.json"] {
        assert!(files.iter().any(|name| name == file), "{file} in {files:?}");
    }
    let first = report(&out);
    let outcomes = first["outcomes"].as_array().unwrap();
    assert!(outcomes.len() >= 3);
    for outcome in outcomes {
        let [cases, failures] = ["cases", "failures"].map(|key| outcome[key].as_u64().unwrap());
        let is_within = outcome["worst"].as_f64().unwrap() <= outcome["bound"].as_f64().unwrap();
        assert!(cases > 0 && failures == 0 && is_within, "{outcome}");
        let subject = outcome["subject"].as_str().unwrap();
        assert!(ended.stdout.contains(subject), "{subject} in {}", ended.stdout);
    }
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    for key in ["machine", "minutes", "seed", "conditions", "worst_cells"] {
        assert!(!first[key].is_null(), "{key}");
    }
}

/// Which case is the worst, and by how much, does not depend on threads.
#[test]
fn a_seed_gives_the_same_cases_again() {
    let of = |seed| [integral(seed, 640), refusals(seed, 60)].map(|outcome| serde_json::to_value(outcome).unwrap());
    assert_eq!(of(1), of(1));
    assert_ne!(of(1)[0]["worst_case"], of(2)[0]["worst_case"]);
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
