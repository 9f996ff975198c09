//! The commands about scene files.

use sorairo::files::text;
use sorairo::scene::file::{self, Draft};
use sorairo::scene::reference;
use sorairo::words::word;

use crate::arguments::{SceneCommand, scene};
use crate::error::{Error, Result};
use crate::flags::flag;
use crate::output::{print_error, print_line, print_note};

/// Runs one of them.
pub fn run(command: &SceneCommand) -> Result<()> {
    match command {
        SceneCommand::New { file, preset, replace } => {
            let write = if replace.force { text::replace } else { text::create };
            write(file, &reference::commented(*preset)).map_err(unnamed)?;
            print_note(&format!("{}: every key of the preset {}", file.display(), word(*preset)));
            Ok(())
        }
        SceneCommand::Check { file } => {
            let file = file.path();
            let mut problems = Draft::problems(file).into_iter().map(Error::from).collect::<Vec<_>>();
            let Some(last) = problems.pop() else {
                return print_line(&format!("{}: ok", file.display()));
            };
            problems.iter().for_each(|problem| print_error(&format!("sorairo: {problem}")));
            Err(last)
        }
        SceneCommand::Show { file, scene: named, flags } => {
            let scene = scene(file.as_deref().or(named.as_deref()), &flags.0)?;
            print_line(file::text(&scene).trim_end())
        }
        SceneCommand::Reference => print_line(reference::markdown(flag).trim_end()),
    }
}

/// What is wrong with a file that no flag names.
fn unnamed(error: sorairo::Error) -> Error {
    let text = error.to_string();
    if error.is_failure() { Error::Failure(text) } else { Error::Request(text) }
}
