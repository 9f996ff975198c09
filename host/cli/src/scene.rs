//! The commands about scene files.

use sorairo::files::text;
use sorairo::scene::file::{self, SceneFile};
use sorairo::scene::reference;
use sorairo::words::word;
use sorairo::{Error, Result};

use crate::arguments::SceneCommand;
use crate::{print_line, print_note};

/// Runs one of them.
pub fn run(command: &SceneCommand) -> Result<()> {
    match command {
        SceneCommand::New { file, preset } => {
            text::create(file, &reference::commented(*preset))?;
            print_note(&format!("{}: every key of the preset {}", file.display(), word(*preset)));
            Ok(())
        }
        SceneCommand::Check { file } => {
            let problems = SceneFile::problems(file);
            let Some((last, others)) = problems.split_last() else {
                return print_line(&format!("{}: ok", file.display()));
            };
            others.iter().for_each(|problem| print_note(&format!("sorairo: {problem}")));
            Err(Error::request(last))
        }
        SceneCommand::Show { file: path, flags } => {
            let scene = flags.over(path.as_deref())?;
            print_line(file::text(&scene).trim_end())
        }
        SceneCommand::Reference => print_line(reference::markdown().trim_end()),
    }
}
