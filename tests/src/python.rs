//! Other people's programs from Python's package index, in the environment that `test.sh` makes.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Python: the one that `SORAIRO_PYTHON` names, or the one that test.sh makes.
///
/// # Panics
///
/// If there is none.
pub fn python() -> PathBuf {
    let made = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/python/bin/python");
    let python = std::env::var_os("SORAIRO_PYTHON").map_or_else(made, PathBuf::from);
    assert!(
        python.is_file(),
        "{} is missing: run ./test.sh, which makes it, or set SORAIRO_PYTHON to a Python that has what tests/python/requirements.txt lists",
        python.display()
    );
    python
}

/// Runs a script of `tests/python` in a folder, successfully.
///
/// # Panics
///
/// If it fails.
pub fn check(folder: &Path, script: &str, arguments: &[&str]) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("python").join(script);
    let output =
        Command::new(python()).arg(&script).args(arguments).current_dir(folder).output().expect("Python starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    println!("{}", text(&output.stdout));
    assert!(output.status.success(), "{}: {}\n{}", script.display(), text(&output.stdout), text(&output.stderr));
}
