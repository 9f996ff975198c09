//! What happens when a device fails, a disk is full, or a process is killed. The tests of the GPU need a Vulkan device.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::ops::Range;
use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use sorairo::low_level::device::cpu::Cpu;
use sorairo::low_level::device::{Backend, TakeRows, Times};
use sorairo::low_level::plan::Kernel;
use sorairo::low_level::render::{self, Request};
use sorairo::scene::{Fit, PathChoice, Preset, Projection, Scene};
use sorairo::{Device, DeviceKind, Error, PixelFormat, Plan, Result};
use sorairo_shared::kernels::SENTINEL;
use sorairo_tests::program::{Ended, command, contents, names, run, succeed};
use sorairo_tests::sky::scene;
use sorairo_tests::{gpu, wait};
use tempfile::TempDir;

fn plan(scene: &Scene, pixel: PixelFormat) -> Plan {
    Plan::new(&scene.validated().unwrap(), pixel)
}

#[test]
fn an_image_in_tiles_is_the_same_byte_for_byte() {
    let whole = gpu::limited(u64::MAX);
    for (path, projection, size) in [
        (PathChoice::Direct, Projection::Fisheye, "75x61"),
        (PathChoice::Lookup, Projection::Equirectangular, "75x61"),
        // Wide enough that pixels are looked up in runs.
        (PathChoice::Lookup, Projection::Equirectangular, "1024x61"),
        (PathChoice::Lookup, Projection::Perspective, "75x61"),
    ] {
        for pixel in [PixelFormat::LinearRgb, PixelFormat::Picture, PixelFormat::HalfRgb] {
            let mut scene = scene(Preset::Earth, 10.0, size);
            (scene.render.path, scene.camera.projection, scene.observer.altitude) = (path, projection, 1.0);
            let plan = plan(&scene, pixel);
            let expected = whole.run(&plan, plan.kernel()).unwrap().words;
            // Room for one row, for seven, and for all but one.
            for rows in [1, 7, 60] {
                let room = u64::from(plan.width()) * u64::from(pixel.words()) * 4 * rows;
                let tiled = gpu::limited(room).run(&plan, plan.kernel()).unwrap().words;
                assert!(tiled == expected, "{path:?}, {projection:?}, {pixel:?}, {rows} rows at once");
            }
        }
    }
}

#[test]
fn a_row_that_no_buffer_holds_is_refused_with_the_widest_that_one_does() {
    let plan = plan(&scene(Preset::Earth, 10.0, "75x61"), PixelFormat::Picture);
    let error = gpu::limited(64 * 4).run(&plan, plan.kernel()).unwrap_err();
    assert!(
        matches!(&error, Error::NotAllowed { key: "camera.size", complaint } if complaint.contains("at most 64 pixels")),
        "{error}"
    );
}

/// A device on the CPU that fails after some rows, or leaves a pixel unwritten in the strip after them.
struct Faulty {
    good_rows: u32,
    fault: Fault,
}

#[derive(Clone, Copy, Debug)]
enum Fault {
    Lost,
    Unwritten,
}

impl Backend for Faulty {
    fn lit_rows(&self, plan: &Plan, kernel: Kernel, rows: Range<u32>, take: &mut TakeRows<'_>) -> Result<Times> {
        for row in rows.clone() {
            let broken = row >= rows.start + self.good_rows;
            match (broken, self.fault) {
                (true, Fault::Lost) => return Err(Error::Device("a fault was injected".into())),
                (true, Fault::Unwritten) => Cpu.lit_rows(plan, kernel, row..row + 1, &mut |row, words| {
                    let mut words = words.to_vec();
                    words[0] = SENTINEL;
                    take(row, &words)
                })?,
                _ => Cpu.lit_rows(plan, kernel, row..row + 1, take)?,
            };
        }
        Ok(Times::default())
    }
}

fn device(name: &str, backend: impl Backend + 'static) -> Device {
    Device { name: name.into(), kind: DeviceKind::Gpu, backend: Box::new(backend), spares: VecDeque::new() }
}

/// A device with a fault, and as many spares with the same; each opening is counted.
fn faulty(fault: Fault, good_rows: u32, spares: u32, opened: &Arc<AtomicU32>) -> Device {
    let mut faulty = device("first", Faulty { good_rows, fault });
    for _ in 0..spares {
        let opened = Arc::clone(opened);
        faulty.spares.push_back(Box::new(move || {
            opened.fetch_add(1, Ordering::Relaxed);
            Ok(device("again", Faulty { good_rows, fault }))
        }));
    }
    faulty
}

const FILES: [&str; 2] = ["sky.png", "sky.exr"];

fn files(folder: &TempDir, names: &[&str]) -> Request {
    Request { outputs: names.iter().map(|name| folder.path().join(name)).collect(), ..Request::default() }
}

#[test]
fn after_a_lost_device_and_its_spare_the_cpu_finishes_the_image() {
    let folder = tempfile::tempdir().unwrap();
    let expected = tempfile::tempdir().unwrap();
    let scene = scene(Preset::Earth, 10.0, "64x40");
    render::render(&scene.validated().unwrap(), &files(&expected, &FILES), || Ok(sorairo::Device::cpu()), |_| ())
        .unwrap();
    for good_rows in [0, 1, 7] {
        let opened = Arc::default();
        let mut first = faulty(Fault::Lost, good_rows, 1, &opened);
        first.spares.push_back(Box::new(|| Ok(sorairo::Device::cpu())));
        let report =
            render::render(&scene.validated().unwrap(), &files(&folder, &FILES), || Ok(first), |_| ()).unwrap();
        assert_eq!((report.backend, opened.load(Ordering::Relaxed)), (DeviceKind::Cpu, 1));
        assert!(contents(folder.path()) == contents(expected.path()), "after {good_rows} rows");
    }
}

#[test]
fn a_device_without_a_working_spare_is_an_error_that_names_it_and_leaves_no_file() {
    for fault in [Fault::Lost, Fault::Unwritten] {
        for wanted in [0..1, 1..2, 0..2] {
            let folder = tempfile::tempdir().unwrap();
            let first = faulty(fault, 5, 1, &Arc::default());
            let request = files(&folder, &FILES[wanted]);
            let error = render::render(
                &scene(Preset::Earth, 10.0, "64x40").validated().unwrap(),
                &request,
                || Ok(first),
                |_| (),
            )
            .unwrap_err();
            assert!(matches!(&error, Error::Device(_)), "{fault:?}: {error}");
            assert!(error.is_failure());
            assert!(contents(folder.path()).is_empty(), "{fault:?}");
        }
    }
}

#[test]
fn a_vulkan_device_that_is_lost_is_an_error_and_its_replacement_works() {
    let scene = scene(Preset::Earth, 10.0, "64x40");
    let plan = plan(&scene, PixelFormat::Picture);
    let lost = gpu::limited(u64::MAX);
    let expected = lost.run(&plan, plan.kernel()).unwrap().words;
    lost.lose();
    let error = lost.run(&plan, plan.kernel()).unwrap_err();
    assert!(matches!(error, Error::Device(_)), "{error}");
    let mut device = lost.into_device();
    device.spares.push_back(Box::new(|| Ok(gpu::limited(u64::MAX).into_device())));
    assert!(device.run(&plan, plan.kernel()).unwrap().words == expected);
}

/// Mesa's llvmpipe ends the loops of a kernel after 65535 rounds, all together, in silence: a sum over many bands
/// lacked its last.
#[test]
fn a_pixel_of_more_rounds_than_the_driver_makes_is_left_to_the_cpu() {
    // Just below the limit and far beyond it.
    for (steps, bands, is_beyond) in [(770, 81, false), (1024, 81, true), (400, 400, true)] {
        let mut scene = scene(Preset::Earth, -3.0, "16x8");
        scene.observer.altitude = 300.0;
        (scene.render.fit, scene.render.steps, scene.render.path) = (Fit::Dense, Some(steps), PathChoice::Direct);
        scene.render.bands = Some((0..bands).map(|i| 380.0 + 400.0 / f64::from(bands) * f64::from(i)).collect());
        let plan = plan(&scene, PixelFormat::LinearRgb);
        let expected = Cpu.run(&plan, plan.kernel()).unwrap().words;
        let mut device = gpu::limited(u64::MAX).into_device();
        let is_llvmpipe = device.name.contains("llvmpipe");
        assert_eq!(device.backend.refusal(&plan).is_some(), is_beyond && is_llvmpipe, "{steps} samples, {bands} bands");
        if is_beyond && is_llvmpipe {
            let error = device.run(&plan, plan.kernel()).unwrap_err();
            assert!(matches!(&error, Error::Device(words) if words.contains("rounds")), "{error}");
        }
        // A fresh device of the same driver is passed over.
        device.spares.push_back(Box::new(|| Ok(gpu::limited(u64::MAX).into_device())));
        device.spares.push_back(Box::new(|| Ok(sorairo::Device::cpu())));
        let words = device.run(&plan, plan.kernel()).unwrap().words;
        let floats = |words: &[u32]| words.iter().map(|&word| f64::from(f32::from_bits(word))).collect::<Vec<_>>();
        let (image, expected) = (floats(&words), floats(&expected));
        let brightest = expected.iter().copied().fold(0.0, f64::max);
        assert!(brightest > 0.0);
        for (value, expected) in image.into_iter().zip(expected) {
            // The devices round differently; without the last bands the sum was 5e-3 too small.
            assert!((value - expected).abs() <= 1e-4 * brightest, "{steps} samples: {value:e}, {expected:e}");
        }
    }
}

/// Starts the program in a folder, without a voice.
fn start(folder: &Path, arguments: &[&str]) -> Child {
    command(folder, arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

#[cfg(unix)]
fn signal(child: &Child, name: &str) {
    let sent = std::process::Command::new("kill").args([format!("-{name}"), child.id().to_string()]).status().unwrap();
    assert!(sent.success(), "kill -{name}");
}

/// Names of the files of a folder that are being written, or were.
fn unfinished(folder: &Path) -> BTreeSet<String> {
    names(folder).into_iter().filter(|name| name.starts_with(".sorairo-")).collect()
}

const BOTH: [&str; 7] = ["render", "--device", "cpu", "-o", "sky.png", "-o", "sky.exr"];

/// Moments are what is seen of a run: how many bytes of its files are there. A run that ended before its kill proves
/// nothing, and is repeated.
#[test]
fn a_process_killed_at_any_moment_leaves_whole_files() {
    const KILLS: u32 = 32;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // Some 13 MB, which are written in pieces of 256 KiB.
    let large = [&BOTH[..], &["--size", "2048x1024", "--sun-elevation"]].concat();
    let whole: Vec<BTreeMap<String, Vec<u8>>> = ["30", "31"]
        .map(|elevation| {
            let _ = succeed(folder, &[&large[..], &[elevation]].concat());
            contents(folder)
        })
        .into();
    assert!(whole[0]["sky.png"] != whole[1]["sky.png"] && whole[0]["sky.exr"] != whole[1]["sky.exr"]);
    let bytes: usize = whole[0].values().map(Vec::len).sum();
    let (mut kills, mut runs) = (0, 0_u32);
    while kills < KILLS {
        // A golden-ratio sequence spreads the moments evenly, from before the first byte to the last.
        let moment = 1.02 * (f64::from(runs) * 0.618_033_988_75 % 1.0) - 0.02;
        let before = unfinished(folder);
        let mut child = start(folder, &[&large[..], &[["30", "31"][runs as usize % 2]]].concat());
        wait::until("the moment of a kill", || {
            written(folder, &before) as f64 >= moment * bytes as f64 || child.try_wait().unwrap().is_some()
        });
        child.kill().unwrap();
        kills += u32::from(!child.wait().unwrap().success());
        runs += 1;
        for name in FILES {
            let found = std::fs::read(folder.join(name)).unwrap();
            assert!(
                whole.iter().any(|whole| whole[name] == found),
                "{name} is not whole after run {runs}, kill {kills}"
            );
        }
        assert!(runs < 50 * KILLS, "only {kills} of {runs} runs were killed before their end");
    }
    println!("{KILLS} of {runs} runs were killed before their end");
    let _ = succeed(folder, &[&large[..], &["30"]].concat());
    assert!(contents(folder) == whole[0]);
}

/// Bytes in the unfinished files of a folder that were not there before.
fn written(folder: &Path, before: &BTreeSet<String>) -> u64 {
    // A file may take its place between the two looks at it.
    let length = |name: &String| std::fs::metadata(folder.join(name)).map_or(0, |metadata| metadata.len());
    unfinished(folder).difference(before).map(length).sum()
}

#[cfg(unix)]
#[test]
fn an_interruption_is_one_sentence_and_leaves_nothing() {
    for name in ["INT", "TERM", "HUP"] {
        let folder = tempfile::tempdir().unwrap();
        let size = ["--size", "8192x4096", "--path", "direct", "--steps", "1024"];
        let child = command(folder.path(), &[&BOTH[..], &size].concat()).stderr(Stdio::piped()).spawn().unwrap();
        // The many pixels that are left take minutes.
        wait::until("the first bytes of two files", || unfinished(folder.path()).len() == 2);
        signal(&child, name);
        let ended: Ended = child.wait_with_output().unwrap().into();
        assert_eq!(ended.code, Some(130), "{name}: {}", ended.stderr);
        let words: Vec<_> = ended.stderr.lines().filter(|line| !line.ends_with("...")).collect();
        assert_eq!(words, ["sorairo: interrupted; files that were not finished are removed"], "{name}");
        assert!(contents(folder.path()).is_empty(), "{name}");
    }
}

#[test]
fn a_file_that_another_process_is_writing_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let size = ["--size", "8192x4096", "--path", "direct", "--steps", "1024"];
    let mut slow = start(folder.path(), &[&BOTH[..], &size].concat());
    wait::until("the first bytes of two files", || unfinished(folder.path()).len() == 2);
    succeed(folder.path(), &["render", "--device", "cpu", "--size", "8x4", "-o", "other.png"]);
    assert_eq!(unfinished(folder.path()).len(), 2);
    assert!(slow.try_wait().unwrap().is_none(), "nothing was being written any more");
    slow.kill().unwrap();
    slow.wait().unwrap();
    succeed(folder.path(), &["render", "--device", "cpu", "--size", "8x4", "-o", "other.png"]);
    assert_eq!(contents(folder.path()).into_keys().collect::<Vec<_>>(), ["other.png"]);
}

/// A pipe has no end until somebody writes into it, and what a person calls their own is theirs.
#[cfg(unix)]
#[test]
fn a_persons_own_files_and_pipes_beside_the_outputs_are_neither_opened_nor_removed() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = |name: &str| {
        let made = std::process::Command::new("mkfifo").arg(folder.path().join(name)).status().unwrap();
        assert!(made.success(), "mkfifo {name}");
    };
    pipe(".sorairo-x");
    for name in [".sorairo-mine.txt", ".sorairo-abcdef"] {
        std::fs::write(folder.path().join(name), "mine").unwrap();
    }
    let sequence = ["sequence", "--device", "cpu", "--size", "8x4", "--sun-elevation", "0:1:1", "-o", "a#.png"];
    for arguments in [&["render", "--device", "cpu", "--size", "8x4", "-o", "a.png"][..], &sequence] {
        succeed_in_time(folder.path(), arguments);
    }
    let there = ["a.png", "a0.png", "a1.png", "contact.png"];
    assert_eq!(names(folder.path()), [&[".sorairo-abcdef", ".sorairo-mine.txt", ".sorairo-x"][..], &there].concat());
    // A frame whose place a pipe has is refused, and not waited for.
    std::fs::remove_file(folder.path().join("a1.png")).unwrap();
    pipe("a1.png");
    let mut child = command(folder.path(), &sequence).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    wait::until("the end of a run", || child.try_wait().unwrap().is_some());
    let ended: Ended = child.wait_with_output().unwrap().into();
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    assert!(ended.stderr.contains("a1.png") && ended.stderr.contains("no ordinary file"), "{}", ended.stderr);
}

/// A run that succeeds, or a test that fails where it hangs.
#[cfg(unix)]
fn succeed_in_time(folder: &Path, arguments: &[&str]) {
    let mut child = start(folder, arguments);
    wait::until("the end of a run", || child.try_wait().unwrap().is_some());
    assert!(child.wait().unwrap().success(), "{arguments:?}");
}

#[test]
fn sixteen_processes_at_once_finish_with_correct_files() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["render", "--device", "gpu", "--size", "256x128", "-o"];
    succeed(folder.path(), &[&arguments[..], &["alone.png", "-o", "alone.exr"]].concat());
    let names: Vec<_> = (0..16).map(|i| (format!("{i}.png"), format!("{i}.exr"))).collect();
    let children: Vec<_> = names
        .iter()
        .map(|(png, exr)| start(folder.path(), &[&arguments[..], &[png.as_str(), "-o", exr.as_str()]].concat()))
        .collect();
    for mut child in children {
        assert!(child.wait().unwrap().success());
    }
    let files = contents(folder.path());
    assert_eq!(files.len(), 34, "{:?}", files.keys());
    for (png, exr) in &names {
        assert!(files[png] == files["alone.png"] && files[exr] == files["alone.exr"], "{png}, {exr}");
    }
}

#[test]
fn an_image_that_the_disk_cannot_hold_is_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    // The work would take months, and end with the code 1 of a full disk.
    let ended = run(folder.path(), &["render", "--size", "8388608x8388608", "-o", "sky.exr"]);
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    assert!(ended.stderr.contains("-o sky.exr") && ended.stderr.contains("GiB are free"), "{}", ended.stderr);
    assert!(contents(folder.path()).is_empty());
}
