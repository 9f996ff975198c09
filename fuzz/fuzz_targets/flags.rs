//! Any lines as flags, one to a line: refused, or a scene whose values are checked.

#![no_main]

use clap::Parser;
use libfuzzer_sys::fuzz_target;
use sorairo_cli::arguments::{Arguments, Command, SceneCommand, scene};

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let arguments = ["sorairo", "scene", "show"].into_iter().chain(text.lines());
    if let Ok(arguments) = Arguments::try_parse_from(arguments) {
        let Command::Scene(SceneCommand::Show { file: None, scene: None, flags }) = arguments.command else { return };
        let _ = scene(None, &flags.0);
    }
});
