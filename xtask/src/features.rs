//! `cargo xtask features`: every package that others depend on compiles without its features, and with each alone.

use std::error::Error;
use std::path::Path;
use std::process::Command;

/// The packages that are published and have features.
const PACKAGES: [&str; 3] = ["sorairo-shared", "sorairo", "sorairo-cli"];

/// Checks each package with no feature, with each alone and with all, without a warning.
///
/// # Errors
///
/// The package and the features with which it does not compile.
pub fn check(root: &Path) -> Result<String, Box<dyn Error>> {
    let mut checked = 0;
    for (package, mut features) in features(root)? {
        features.extend([String::new(), features.join(",")]);
        for feature in &features {
            let chosen = ["--package", &package, "--no-default-features", "--features", feature];
            let status = Command::new(env!("CARGO"))
                .args(["clippy", "--quiet", "--release"])
                .args(chosen)
                .args(["--", "--deny", "warnings"])
                .current_dir(root)
                .status()?;
            if !status.success() {
                return Err(format!("{package} does not compile with the features {feature:?} alone").into());
            }
            checked += 1;
        }
    }
    Ok(format!("{} compile with no feature, with each alone and with all: {checked} choices", PACKAGES.join(", ")))
}

/// A package and its features.
type Features = (String, Vec<String>);

/// The features of each package.
fn features(root: &Path) -> Result<Vec<Features>, Box<dyn Error>> {
    let metadata = ["metadata", "--no-deps", "--format-version", "1"];
    let output = Command::new(env!("CARGO")).args(metadata).current_dir(root).output()?;
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout)?;
    let of = |name: &str| {
        let packages = metadata["packages"].as_array()?;
        let package = packages.iter().find(|package| package["name"] == name)?;
        let features = package["features"].as_object()?.keys().filter(|feature| *feature != "default");
        Some((name.to_owned(), features.cloned().collect()))
    };
    let found = PACKAGES.into_iter().map(|name| of(name).ok_or_else(|| format!("there is no package {name}").into()));
    found.collect()
}
