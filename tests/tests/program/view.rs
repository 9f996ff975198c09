//! The window, under an X server without a screen. These tests need the program with the feature `view`, and Xvfb.

use std::path::Path;
use std::process::Command;

use sorairo_tests::program::{Ended, Image, binary, command, read_png};
use tempfile::tempdir;

/// The display variables that a window looks at.
const DISPLAYS: [&str; 3] = ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"];

/// `sorairo view` with a display of its own, so large that the pointer in its middle lies outside of the window.
fn view(folder: &Path, arguments: &[&str]) -> Ended {
    let mut command = Command::new("xvfb-run");
    command.args(["-a", "-s", "-screen 0 2600x1500x24"]).arg(binary()).arg("view").args(arguments);
    for display in DISPLAYS {
        command.env_remove(display);
    }
    let output = command.current_dir(folder).env("XDG_RUNTIME_DIR", folder).output();
    let mut ended: Ended = output.expect("xvfb-run starts: install it (Debian: apt-get install xvfb xauth)").into();
    // xvfb-run sends both streams of its program to standard output.
    ended.stderr.push_str(&ended.stdout);
    assert!(!ended.stderr.contains("has no window"), "{NO_WINDOW}");
    ended
}

const NO_WINDOW: &str = "this program was built without its window: run `cargo build --package sorairo-cli --features view` \
                         in the profile of this test first, as test.sh does";

/// What the window shows.
fn screenshot(flags: &[&str]) -> Image<u8> {
    let folder = tempdir().unwrap();
    let ended = view(folder.path(), &[&["--screenshot", "window.png"], flags].concat());
    assert_eq!(ended.code, Some(0), "{flags:?}: {}", ended.stderr);
    read_png(&folder.path().join("window.png"))
}

/// A part of the window: fractions of its width and height.
struct Part {
    across: [f64; 2],
    down: [f64; 2],
}

/// The uppermost rows of the sky, the zenith of an equirectangular image.
const ZENITH: Part = Part { across: [0.4, 0.8], down: [0.0, 0.02] };

/// The lines of the plot, without what stands beside them.
const PLOT: Part = Part { across: [0.35, 0.95], down: [0.72, 0.88] };

impl Part {
    fn pixels<'a>(&self, image: &'a Image<u8>) -> impl Iterator<Item = [u8; 3]> + 'a {
        let range = |[from, to]: [f64; 2], side: usize| (from * side as f64) as usize..(to * side as f64) as usize;
        let columns = range(self.across, image.width);
        range(self.down, image.height).flat_map(move |row| columns.clone().map(move |column| image.at(column, row)))
    }

    /// Mean of each channel.
    fn mean(&self, image: &Image<u8>) -> [f64; 3] {
        let count = self.pixels(image).count() as f64;
        std::array::from_fn(|i| self.pixels(image).map(|pixel| f64::from(pixel[i])).sum::<f64>() / count)
    }
}

#[test]
fn the_window_shows_a_blue_noon_and_the_spectrum_of_a_point_that_is_clicked() {
    let noon = ["--sun-elevation", "50", "--device", "cpu"];
    let plain = screenshot(&noon);
    let clicked = screenshot(&[&noon[..], &["--click", "0.6,0.25"]].concat());
    for image in [&plain, &clicked] {
        assert_eq!((image.width, image.height), (1280, 720));
        let [red, green, blue] = ZENITH.mean(image);
        assert!(blue > green && green > red && blue > 1.3 * red, "the zenith is {red} {green} {blue}");
    }
    // Without a click one line of text stands there; the line and the area below it fill a good part of it.
    let differing = PLOT.pixels(&plain).zip(PLOT.pixels(&clicked)).filter(|(a, b)| a != b).count();
    let part = differing as f64 / PLOT.pixels(&plain).count() as f64;
    assert!(part > 0.2, "a click changes {part} of the plot");
}

#[test]
fn the_window_shows_the_pixels_that_a_rendering_writes() {
    // The window's own device draws the one, and shows pixels of the other.
    for (device, picture) in [
        ("gpu", &[][..]),
        ("cpu", &[]),
        ("gpu", &["--view", "aces", "--exposure", "adapt"]),
        ("cpu", &["--look", "high-contrast", "--exposure", "ev14"]),
    ] {
        check_pixels(device, picture);
    }
}

fn check_pixels(device: &str, picture: &[&str]) {
    let scene = [&["--projection", "perspective", "--look-elevation", "40", "--device", device], picture].concat();
    let window = screenshot(&scene);
    // A perspective fills its part of the window, and only grey stands around it.
    let coloured = |column: usize, row: usize| {
        let [red, _, blue] = window.at(column, row);
        red.abs_diff(blue) > 8
    };
    let left = (0..window.width).find(|&column| coloured(column, 0)).expect("a sky");
    let lit = |row: usize| (left..window.width).any(|column| coloured(column, row));
    let height = (0..window.height).find(|&row| !lit(row)).expect("an end of the sky");
    let size = format!("{}x{height}", window.width - left);
    let folder = tempdir().unwrap();
    let render = [&["render", "--size", &size, "-o", "sky.png"][..], &scene].concat();
    let ended: Ended = command(folder.path(), &render).output().expect("the program starts").into();
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let sky = read_png(&folder.path().join("sky.png"));
    let worst = (0..sky.height)
        .flat_map(|row| (0..sky.width).map(move |column| (column, row)))
        .flat_map(|(column, row)| {
            let (shown, rendered) = (window.at(left + column, row), sky.at(column, row));
            (0..3).map(move |i| shown[i].abs_diff(rendered[i]))
        })
        .max();
    // The window's texture passes through linear values and back, which may round by one.
    assert!(worst.is_some_and(|worst| worst <= 1), "{size}: the window is off by {worst:?}");
}

/// What one of the twelve pictures of the day shows, below the sky.
fn of_the_day(i: u32) -> Part {
    let middle = (314.0 + (f64::from(i) + 0.5) * 79.7) / 1280.0;
    Part { across: [middle - 0.02, middle + 0.02], down: [0.57, 0.6] }
}

#[test]
fn below_the_sky_stands_a_day_of_its_place_from_night_through_noon_to_night() {
    let day = ["--place", "35.68,139.77", "--time", "2026-09-22T09:00:00+09:00", "--exposure", "adapt"];
    let window = screenshot(&[&day[..], &["--device", "cpu"]].concat());
    let light = |i| of_the_day(i).mean(&window).iter().sum::<f64>();
    assert!(light(5) > 4.0 * light(0) && light(6) > 4.0 * light(11), "{:?}", (0..12).map(light).collect::<Vec<_>>());
    // The sun stands in the east before noon and in the west after it; the middle of these pictures looks north.
    let halves = |i| {
        let Part { across: [left, right], down } = of_the_day(i);
        let middle = (left + right) / 2.0;
        [[left, middle], [middle, right]].map(|across| Part { across, down }.mean(&window).iter().sum::<f64>())
    };
    assert!(halves(3)[1] > halves(3)[0] && halves(8)[0] > halves(8)[1], "{:?} {:?}", halves(3), halves(8));
}

#[test]
fn each_sky_of_a_sun_that_moves_is_drawn_where_it_is_shown_and_none_is_read_back() {
    // The processor's pixels are read back, every one of them.
    for (device, drawn, read_back) in [("gpu", 12, 0), ("cpu", 0, 12)] {
        let folder = tempdir().unwrap();
        let ended = view(folder.path(), &["--device", device, "--projection", "perspective", "--frames", "12"]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let line = ended.stdout.lines().find(|line| line.contains("skies of")).expect("the count");
        println!("{device}: {line}");
        assert!(line.starts_with("12 skies of 960x540 in "), "{line}");
        assert!(line.ends_with(&format!("; {drawn} drawn in place, {read_back} read back")), "{line}");
        let before = line.split(" a second").next().unwrap();
        let rate: f64 = before.rsplit(' ').next().unwrap().parse().unwrap();
        // How many there are in a second depends on the machine and on what else it does; one takes no minute on any.
        assert!(rate > 1.0 / 60.0, "{line}");
    }
}

#[test]
fn what_the_rest_of_a_day_takes_is_compiled_beside_its_first_skies() {
    let folder = tempdir().unwrap();
    let ended = view(folder.path(), &["--device", "gpu", "--projection", "perspective", "--frames", "3", "--json"]);
    let count: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap_or_else(|_| panic!("{ended:?}"));
    // These skies take three themselves; those of a low sun and of twilight take as many again.
    assert!(count["pipelines"].as_u64().is_some_and(|pipelines| pipelines >= 9), "{count}");
}

#[test]
fn without_a_display_one_sentence_says_so() {
    let folder = tempdir().unwrap();
    for (display, expected) in [(None, "there is no display"), (Some(":4711"), "no window can be opened")] {
        let mut command = command(folder.path(), &["view", "--device", "cpu", "--screenshot", "window.png"]);
        for variable in DISPLAYS {
            command.env_remove(variable);
        }
        command.envs(display.map(|display| ("DISPLAY", display)));
        let ended: Ended = command.output().expect("the program starts").into();
        assert!(!ended.stderr.contains("has no window"), "{NO_WINDOW}");
        assert_eq!(ended.code, Some(1), "{display:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(expected), "{display:?}: {}", ended.stderr);
        assert_eq!(ended.stderr.lines().count(), 1, "{display:?}: {}", ended.stderr);
        assert!(ended.stdout.is_empty() && !folder.path().join("window.png").exists(), "{display:?}");
    }
}

#[test]
fn a_screenshot_that_cannot_be_a_picture_is_refused_before_a_window_opens() {
    let folder = tempdir().unwrap();
    for (arguments, expected) in [
        (["--screenshot", "window.exr"], "must end in .png"),
        (["--screenshot", "nowhere/window.png"], "the folder does not exist"),
        (["--click", "0.5,2"], "two numbers from 0 to 1"),
    ] {
        let ended = view(folder.path(), &arguments);
        assert_eq!(ended.code, Some(2), "{arguments:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(expected), "{arguments:?}: {}", ended.stderr);
    }
}
