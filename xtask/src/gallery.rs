//! The pictures of the gallery, made by the commands in it.

use std::error::Error;
use std::path::Path;
use std::process::Command;

/// The page with the commands.
const PAGE: &str = "docs/gallery.md";
/// Where its pictures are.
const PICTURES: &str = "docs/images/gallery";

/// Runs every command of the gallery with the program as it is built now.
pub fn make(root: &Path) -> Result<String, Box<dyn Error>> {
    let build =
        Command::new("cargo").args(["build", "--release", "--package", "sorairo-cli"]).current_dir(root).status()?;
    if !build.success() {
        return Err("sorairo does not build".into());
    }
    let page = std::fs::read_to_string(root.join(PAGE))?;
    let program = root.join("target/release/sorairo").canonicalize()?;
    std::fs::remove_dir_all(root.join(PICTURES))?;
    std::fs::create_dir_all(root.join(PICTURES))?;
    let commands: Vec<_> = page.lines().filter_map(|line| line.strip_prefix("sorairo ")).collect();
    for command in &commands {
        let status = Command::new(&program).args(command.split(' ')).current_dir(root.join(PICTURES)).status()?;
        if !status.success() {
            return Err(format!("sorairo {command}: {status}").into());
        }
        keep_sheet(&root.join(PICTURES).join(command.rsplit(' ').next().unwrap_or_default()))?;
    }
    Ok(format!("{} pictures in {PICTURES}", commands.len()))
}

/// Of the frames of a sequence, whose name has a run of #, keeps their contact sheet alone.
fn keep_sheet(output: &Path) -> std::io::Result<()> {
    let Some(folder) = output.parent().filter(|_| output.to_string_lossy().contains('#')) else { return Ok(()) };
    for file in std::fs::read_dir(folder)? {
        let file = file?;
        if file.file_name() != "contact.png" {
            std::fs::remove_file(file.path())?;
        }
    }
    Ok(())
}
