//! The commands about the command: completions and manual pages.

use std::io;

use clap::CommandFactory;
use clap_complete::Shell;

use crate::arguments::Arguments;
use crate::error::{Error, Result};
use crate::output::print_line;

/// `sorairo completions`.
pub fn completions(shell: Shell) -> Result<()> {
    print_bytes(|out| {
        clap_complete::generate(shell, &mut Arguments::command(), "sorairo", out);
        Ok(())
    })
}

/// `sorairo man`: the manual page of the program, or of a command.
pub fn man(name: Option<&str>) -> Result<()> {
    let mut command = Arguments::command().disable_help_subcommand(true);
    command.build();
    if let Some(name) = name {
        command = command.find_subcommand(name).cloned().ok_or_else(|| {
            let names: Vec<_> = command.get_subcommands().map(clap::Command::get_name).collect();
            Error::request(format!("there is no command {name:?}; there are {}", names.join(", ")))
        })?;
    }
    print_bytes(|out| clap_mangen::Man::new(command.clone()).render(out))
}

/// Prints to standard output what is written first to memory.
fn print_bytes(write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> Result<()> {
    let mut bytes = Vec::new();
    write(&mut bytes).expect("memory can be written");
    print_line(String::from_utf8_lossy(&bytes).trim_end())
}
