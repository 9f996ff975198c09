//! Render farms: the script and the job of `docs/farms.md`, and what a killed task leaves.

#![cfg(unix)]

use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use sorairo_tests::program::{binary, contents, names, succeed};
use sorairo_tests::python::python;
use sorairo_tests::wait;
use tempfile::{TempDir, tempdir};

/// What the pages call the shared scene; large enough that a task can be killed in the middle of a frame. That light of
/// all orders is the same in each task is shown in `sequence`.
const SCENE: &str = "[camera]\nsize = '480x240'\n[render]\npath = 'direct'\norders = 1\n";

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs")
}

/// A folder with the scene, and what one process makes of the sequence in another.
fn folders(formats: &[&str]) -> (TempDir, TempDir) {
    let (tasks, whole) = (tempdir().unwrap(), tempdir().unwrap());
    for folder in [&tasks, &whole] {
        std::fs::write(folder.path().join("evening.toml"), SCENE).unwrap();
    }
    let line = ["sequence", "--scene", "evening.toml", "--sun-elevation", "10:-6:1", "--device", "cpu", "--quiet"];
    let outputs = formats.iter().flat_map(|format| ["-o", format]);
    succeed(whole.path(), &line.into_iter().chain(outputs).collect::<Vec<_>>());
    (tasks, whole)
}

/// A program that finds `sorairo` as a person who installed it.
fn with_program(program: impl AsRef<std::ffi::OsStr>, folder: &Path) -> Command {
    let programs = binary().parent().unwrap().to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([programs].into_iter().chain(std::env::split_paths(&path))).unwrap();
    let mut command = Command::new(program);
    command.current_dir(folder).env("PATH", path).env("XDG_RUNTIME_DIR", folder);
    command
}

/// A task of an array, with the variables that Slurm sets for it.
fn slurm_task(folder: &Path, number: u32) -> Command {
    let mut task = with_program("bash", folder);
    task.arg("evening.sbatch");
    let variables = [
        ("SLURM_SUBMIT_DIR", folder.display().to_string()),
        ("SLURM_CPUS_PER_TASK", "1".into()),
        ("SLURM_ARRAY_TASK_ID", number.to_string()),
        ("SLURM_ARRAY_TASK_MIN", "0".into()),
        ("SLURM_ARRAY_TASK_MAX", "16".into()),
    ];
    task.envs(variables).stdin(Stdio::null());
    task
}

/// Whether a file in a folder is being written.
fn is_writing(folder: &Path) -> bool {
    folder.is_dir() && names(folder).iter().any(|name| name.starts_with(".sorairo-"))
}

/// Kills a task of an array, as a farm does: the script and what it started, at once. It was in the middle if it left a
/// file half written; where the task was faster than the blow, another is tried.
fn kill_in_the_middle(folder: &Path, number: u32, frames: &Path) {
    let frame = frames.join(format!("sky.{number:04}.png"));
    wait::until("a task is killed in the middle", || {
        _ = std::fs::remove_dir_all(frames);
        let mut task = slurm_task(folder, number).process_group(0).spawn().unwrap();
        wait::until("a file is begun", || is_writing(frames) || frame.exists());
        let group = format!("-{}", task.id());
        // It fails where the task is over already.
        _ = Command::new("kill").args(["-KILL", "--", &group]).stderr(Stdio::null()).status().unwrap();
        task.wait().unwrap();
        is_writing(frames) && !frame.exists()
    });
}

#[test]
fn tasks_of_a_slurm_array_one_of_which_is_killed_give_the_files_of_one_process() {
    let (tasks, whole) = folders(&["frames/sky.####.png", "frames/sky.####.exr"]);
    let page = std::fs::read_to_string(docs().join("farms.md")).unwrap();
    let script = page.split("```bash\n").find(|part| part.starts_with("#!/bin/bash")).expect("the script");
    let script = script.split("```").next().unwrap();
    std::fs::write(tasks.path().join("evening.sbatch"), script).unwrap();
    let frames = tasks.path().join("frames");
    kill_in_the_middle(tasks.path(), 3, &frames);
    for number in 0..=16 {
        let status = slurm_task(tasks.path(), number).status().unwrap();
        assert!(status.success(), "task {number}: {status}");
    }
    assert!(contents(&frames) == contents(&whole.path().join("frames")));
    // One task too many is refused.
    assert_eq!(slurm_task(tasks.path(), 17).stderr(Stdio::null()).status().unwrap().code(), Some(2));
}

/// Runs the job of the page, on the CPU, and gives what the engine printed.
fn open_job(folder: &Path) -> Command {
    // The program on the device of the whole sequence, which a farm would choose by what its workers have; and which
    // process a task is.
    let program = folder.join("on-the-cpu");
    std::fs::write(&program, "#!/bin/sh\necho $$ > \"$(dirname \"$0\")/task\"\nexec sorairo \"$@\" --device cpu\n")
        .unwrap();
    std::fs::set_permissions(&program, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let mut job = with_program(python().with_file_name("openjd"), folder);
    job.arg("run").arg(docs().join("farms/sorairo.template.yaml"));
    let output = format!("Output={}", folder.join("frames").display());
    let program = format!("Program={}", program.display());
    for parameter in ["Scene=evening.toml", "Sun=10:-6:1", "Frames=0-16", "FramesPerTask=4", &output, &program] {
        job.args(["-p", parameter]);
    }
    job.stdin(Stdio::null());
    job
}

#[test]
fn an_open_job_that_is_killed_and_run_again_gives_the_files_of_one_process() {
    let (tasks, whole) = folders(&["frames/sky.####.png"]);
    let frames = tasks.path().join("frames");
    let mut killed = open_job(tasks.path()).stdout(Stdio::null()).process_group(0).spawn().unwrap();
    // In the second chunk.
    wait::until("the fifth frame is begun", || frames.join("sky.0003.png").exists() && is_writing(&frames));
    // The engine, and the task, which it gave a session of its own.
    killed.kill().unwrap();
    killed.wait().unwrap();
    let task = std::fs::read_to_string(tasks.path().join("task")).unwrap();
    // It fails where the task is over already.
    _ = Command::new("kill").args(["-KILL", task.trim()]).stderr(Stdio::null()).status().unwrap();
    let before = contents(&frames);
    assert!(before.len() < 17, "{} files: the job was not killed in the middle", before.len());
    let job = open_job(tasks.path()).output().unwrap();
    let log = String::from_utf8_lossy(&job.stdout);
    assert!(job.status.success() && log.contains("Chunks run: 5"), "{log}");
    assert!(contents(&frames) == contents(&whole.path().join("frames")));
}
