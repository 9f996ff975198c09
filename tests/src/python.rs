//! Other people's programs from Python's package index, in the environment that `test.sh` makes.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Python: the one that `SORAIRO_PYTHON` names, or the one that test.sh makes.
///
/// # Panics
///
/// If there is none.
pub fn python() -> PathBuf {
    environment("SORAIRO_PYTHON", "python", "requirements.txt")
}

/// Python with Blender in it: the one that `SORAIRO_BLENDER` names, or the one that test.sh makes.
///
/// # Panics
///
/// If there is none.
pub fn blender() -> PathBuf {
    environment("SORAIRO_BLENDER", "blender", "blender.txt")
}

fn environment(variable: &str, folder: &str, list: &str) -> PathBuf {
    let made = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../target").join(folder).join("bin/python");
    let python = std::env::var_os(variable).map_or_else(made, PathBuf::from);
    assert!(
        python.is_file(),
        "{} is missing: run ./test.sh, which makes it, or set {variable} to a Python that has what tests/python/{list} lists",
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
    check_by(&python(), folder, script, arguments);
}

/// Runs a script of `tests/python` in a folder by a Python, successfully.
///
/// # Panics
///
/// If it fails.
pub fn check_by(python: &Path, folder: &Path, script: &str, arguments: &[&str]) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("python").join(script);
    let output = Command::new(python).arg(&script).args(arguments).current_dir(folder).output().expect("Python starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    println!("{}", text(&output.stdout));
    assert!(output.status.success(), "{}: {}\n{}", script.display(), text(&output.stdout), text(&output.stderr));
}
