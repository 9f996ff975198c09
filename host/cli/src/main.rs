//! The command `sorairo`.

use std::process::ExitCode;

fn main() -> ExitCode {
    quiet_loader();
    ExitCode::from(sorairo_cli::run(std::env::args_os()))
}

/// Where nobody has said where the sockets of a session lie, as on a machine without a screen, Mesa's loader complains
/// of it before anything else: the program runs again with a folder that holds none. Where that fails it goes on with
/// the complaint.
#[cfg(target_os = "linux")]
fn quiet_loader() {
    use std::os::unix::process::CommandExt;

    const FOLDER: &str = "XDG_RUNTIME_DIR";
    if std::env::var_os(FOLDER).is_some() {
        return;
    }
    if let Ok(program) = std::env::current_exe() {
        let mut arguments = std::env::args_os();
        let mut again = std::process::Command::new(program);
        if let Some(name) = arguments.next() {
            again.arg0(name);
        }
        let _failed = again.args(arguments).env(FOLDER, std::env::temp_dir()).exec();
    }
}

#[cfg(not(target_os = "linux"))]
fn quiet_loader() {}
