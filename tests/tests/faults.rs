//! What happens when a device fails, a disk is full, or a process is killed. The tests of the GPU need a Vulkan device.

use std::collections::VecDeque;
use std::ops::Range;
use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use sorairo::device::cpu::Cpu;
use sorairo::device::gpu::Gpu;
use sorairo::device::{Backend, Device, Kernel, TakeRows, Times};
use sorairo::plan::Plan;
use sorairo::render::{self, Request};
use sorairo::scene::{Fit, PathChoice, Preset, Projection, Scene};
use sorairo::{Error, PixelFormat, Result};
use sorairo_shared::frame::SENTINEL;
use sorairo_tests::program::{Ended, command, contents, read_exr, read_png, run, succeed};
use sorairo_tests::sky::scene;
use tempfile::TempDir;

/// The GPU, as if it took no buffer larger than this (bytes).
fn gpu(largest_buffer: u64) -> Gpu {
    Gpu::open("", largest_buffer).unwrap().unwrap_or_else(|| {
        panic!("no Vulkan device. These tests need one; on Debian: apt-get install mesa-vulkan-drivers libvulkan1")
    })
}

fn plan(scene: &Scene, pixel: PixelFormat) -> Plan {
    Plan::new(scene, pixel).unwrap()
}

#[test]
fn an_image_in_tiles_is_the_same_byte_for_byte() {
    let whole = gpu(u64::MAX);
    for (path, projection, size) in [
        (PathChoice::Direct, Projection::Fisheye, "75x61"),
        (PathChoice::Table, Projection::Equirectangular, "75x61"),
        // Wide enough that pixels are looked up in runs.
        (PathChoice::Table, Projection::Equirectangular, "1024x61"),
        (PathChoice::Table, Projection::Perspective, "75x61"),
    ] {
        for pixel in [PixelFormat::LinearRgb, PixelFormat::Picture, PixelFormat::HalfRgb] {
            let mut scene = scene(Preset::Earth, 10.0, size);
            (scene.render.path, scene.camera.projection, scene.observer.altitude) = (path, projection, 1.0);
            let plan = plan(&scene, pixel);
            let expected = whole.run(&plan, plan.kernel()).unwrap().words;
            // Room for one row, for seven, and for all but one.
            for rows in [1, 7, 60] {
                let room = u64::from(plan.width()) * u64::from(pixel.words()) * 4 * rows;
                let tiled = gpu(room).run(&plan, plan.kernel()).unwrap().words;
                assert!(tiled == expected, "{path:?}, {projection:?}, {pixel:?}, {rows} rows at once");
            }
        }
    }
}

#[test]
fn a_row_that_no_buffer_holds_is_refused_with_the_widest_that_one_does() {
    let plan = plan(&scene(Preset::Earth, 10.0, "75x61"), PixelFormat::Picture);
    let error = gpu(64 * 4).run(&plan, plan.kernel()).unwrap_err();
    assert!(matches!(&error, Error::Request(text) if text.contains("at most 64 pixels")), "{error}");
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
    Device { name: name.into(), kind: "gpu", backend: Box::new(backend), spares: VecDeque::new() }
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
    render::render(&scene, &files(&expected, &FILES), || Ok(sorairo::device::cpu::device()), |_| ()).unwrap();
    for good_rows in [0, 1, 7] {
        let opened = Arc::default();
        let mut first = faulty(Fault::Lost, good_rows, 1, &opened);
        first.spares.push_back(Box::new(|| Ok(sorairo::device::cpu::device())));
        let report = render::render(&scene, &files(&folder, &FILES), || Ok(first), |_| ()).unwrap();
        assert_eq!((report.backend, opened.load(Ordering::Relaxed)), ("cpu", 1));
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
            let error =
                render::render(&scene(Preset::Earth, 10.0, "64x40"), &request, || Ok(first), |_| ()).unwrap_err();
            assert!(matches!(&error, Error::Device(_)), "{fault:?}: {error}");
            assert_eq!(error.exit_code(), 1);
            assert!(contents(folder.path()).is_empty(), "{fault:?}");
        }
    }
}

#[test]
fn a_vulkan_device_that_is_lost_is_an_error_and_its_replacement_works() {
    let scene = scene(Preset::Earth, 10.0, "64x40");
    let plan = plan(&scene, PixelFormat::Picture);
    let lost = gpu(u64::MAX);
    let expected = lost.run(&plan, plan.kernel()).unwrap().words;
    lost.lose();
    let error = lost.run(&plan, plan.kernel()).unwrap_err();
    assert!(matches!(error, Error::Device(_)), "{error}");
    let mut device = lost.into_device();
    device.spares.push_back(Box::new(|| Ok(gpu(u64::MAX).into_device())));
    assert!(device.run(&plan, plan.kernel()).unwrap().words == expected);
}

/// Mesa's llvmpipe ends the loops of a kernel after 65535 rounds, all together, in silence: a sum over many bands lacked its last.
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
        let mut device = gpu(u64::MAX).into_device();
        let is_llvmpipe = device.name.contains("llvmpipe");
        assert_eq!(device.backend.refusal(&plan).is_some(), is_beyond && is_llvmpipe, "{steps} samples, {bands} bands");
        if is_beyond && is_llvmpipe {
            let error = device.run(&plan, plan.kernel()).unwrap_err();
            assert!(matches!(&error, Error::Device(words) if words.contains("rounds")), "{error}");
        }
        // A fresh device of the same driver is passed over.
        device.spares.push_back(Box::new(|| Ok(gpu(u64::MAX).into_device())));
        device.spares.push_back(Box::new(|| Ok(sorairo::device::cpu::device())));
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
fn unfinished(folder: &Path) -> usize {
    contents(folder).keys().filter(|name| name.starts_with(".sorairo-")).count()
}

const BOTH: [&str; 7] = ["render", "--device", "cpu", "-o", "sky.png", "-o", "sky.exr"];

#[test]
fn a_process_killed_at_any_moment_leaves_whole_files() {
    const KILLS: u32 = 200;
    let folder = tempfile::tempdir().unwrap();
    let large = [&BOTH[..], &["--size", "640x320", "--sun-elevation"]].concat();
    let began = Instant::now();
    let _ = succeed(folder.path(), &[&large[..], &["40"]].concat());
    let whole_run = began.elapsed();
    let mut versions = Vec::new();
    let mut interrupted = 0;
    for kill in 0..KILLS {
        // A golden-ratio sequence fills the run evenly, its writing at the end twice as often.
        let moment = f64::from(kill) * 0.618_033_988_75 % 1.0;
        let moment = if kill % 2 == 0 { moment } else { 0.5 + moment / 2.0 };
        let elevation = (30 + kill % 2).to_string();
        let mut child = start(folder.path(), &[&large[..], &[&elevation]].concat());
        std::thread::sleep(whole_run.mul_f64(moment));
        child.kill().unwrap();
        interrupted += u32::from(!child.wait().unwrap().success());
        let (picture, image) = (read_png(&folder.path().join("sky.png")), read_exr(&folder.path().join("sky.exr")).0);
        assert_eq!((picture.width, image.width, picture.height, image.height), (640, 640, 320, 320), "kill {kill}");
        if !versions.contains(&image.rgb) {
            versions.push(image.rgb);
        }
    }
    println!("{interrupted} of {KILLS} killed before their end; {} versions were seen", versions.len());
    assert!(interrupted > KILLS / 2 && versions.len() <= 3);
    succeed(folder.path(), &[&large[..], &["40"]].concat());
    assert_eq!(contents(folder.path()).into_keys().collect::<Vec<_>>(), ["sky.exr", "sky.png"]);
}

#[cfg(unix)]
#[test]
fn an_interruption_is_one_sentence_and_leaves_nothing() {
    for name in ["INT", "TERM", "HUP"] {
        let folder = tempfile::tempdir().unwrap();
        let size = ["--size", "8192x4096", "--path", "direct"];
        let child = command(folder.path(), &[&BOTH[..], &size].concat()).stderr(Stdio::piped()).spawn().unwrap();
        let began = Instant::now();
        while unfinished(folder.path()) < 2 {
            assert!(began.elapsed() < Duration::from_secs(60), "no file was begun");
            std::thread::sleep(Duration::from_millis(5));
        }
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
    let size = ["--size", "8192x4096", "--path", "direct"];
    let mut slow = start(folder.path(), &[&BOTH[..], &size].concat());
    let began = Instant::now();
    while unfinished(folder.path()) < 2 {
        assert!(began.elapsed() < Duration::from_secs(60), "no file was begun");
        std::thread::sleep(Duration::from_millis(5));
    }
    succeed(folder.path(), &["render", "--device", "cpu", "--size", "8x4", "-o", "other.png"]);
    assert_eq!(unfinished(folder.path()), 2);
    slow.kill().unwrap();
    slow.wait().unwrap();
    succeed(folder.path(), &["render", "--device", "cpu", "--size", "8x4", "-o", "other.png"]);
    assert_eq!(contents(folder.path()).into_keys().collect::<Vec<_>>(), ["other.png"]);
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
    let began = Instant::now();
    let ended = run(folder.path(), &["render", "--size", "8388608x8388608", "-o", "sky.exr"]);
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    assert!(ended.stderr.contains("-o sky.exr") && ended.stderr.contains("GiB are free"), "{}", ended.stderr);
    assert!(contents(folder.path()).is_empty());
    assert!(began.elapsed() < Duration::from_secs(20), "that was work");
}
