//! The judge shares nothing with what it judges.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

#[test]
fn the_oracle_depends_on_no_crate_of_ours() {
    let folder = env!("CARGO_MANIFEST_DIR");
    let mut cargo = Command::new(env!("CARGO"));
    let output = cargo.args(["metadata", "--no-deps", "--offline", "--format-version=1"]).current_dir(folder).output();
    let metadata: Value = serde_json::from_slice(&output.expect("cargo runs").stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let ours: Vec<&str> = packages.iter().filter_map(|package| package["name"].as_str()).collect();
    assert!(ours.contains(&"sorairo-oracle") && ours.contains(&"sorairo-shared"), "{ours:?}");
    let oracle = packages.iter().find(|package| package["name"] == "sorairo-oracle").expect("the oracle");
    for dependency in oracle["dependencies"].as_array().expect("dependencies") {
        let name = dependency["name"].as_str().expect("a name");
        assert!(!ours.contains(&name) && dependency["path"].is_null(), "the oracle depends on {name}");
    }
}

#[test]
fn the_oracle_takes_no_file_from_outside_its_folder() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files: Vec<_> = std::fs::read_dir(sources).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(files.len() > 5, "{files:?}");
    for file in files {
        let source = std::fs::read_to_string(&file).unwrap();
        let words = ["#[path", "include!", "include_str!", "include_bytes!"];
        assert!(!words.iter().any(|word| source.contains(word)), "{}", file.display());
    }
}
