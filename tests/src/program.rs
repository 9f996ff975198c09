//! The program as a person runs it, and the files that it writes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, WritableImage, read_first_flat_layer_from_file};

/// How a run of the program ended.
#[derive(Debug)]
pub struct Ended {
    /// The exit code; `None` if a signal ended the program.
    pub code: Option<i32>,
    /// What it printed to standard output.
    pub stdout: String,
    /// What it printed to standard error.
    pub stderr: String,
}

impl From<Output> for Ended {
    fn from(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the program prints UTF-8");
        Self { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

/// The program, which was built beside the tests.
///
/// # Panics
///
/// If it is not built.
pub fn binary() -> PathBuf {
    let test = std::env::current_exe().expect("a test knows its own file");
    let profile = test.parent().and_then(Path::parent).expect("a test lies in deps of the target folder");
    let program = profile.join(format!("sorairo{}", std::env::consts::EXE_SUFFIX));
    assert!(
        program.is_file(),
        "{} is not built: run `cargo build --package sorairo-cli` in the profile of this test first, as test.sh does",
        program.display()
    );
    program
}

/// The program with its arguments, ready to run in a folder.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(binary());
    // Mesa's drivers complain on standard error where this is missing.
    command.args(arguments).current_dir(folder).env("XDG_RUNTIME_DIR", folder);
    command
}

/// Runs the program in a folder.
///
/// # Panics
///
/// If it cannot be started.
pub fn run(folder: &Path, arguments: &[&str]) -> Ended {
    command(folder, arguments).output().expect("the program starts").into()
}

/// Runs the program in a folder, successfully.
///
/// # Panics
///
/// If it fails.
pub fn succeed(folder: &Path, arguments: &[&str]) -> Ended {
    let ended = run(folder, arguments);
    assert_eq!(ended.code, Some(0), "{arguments:?}: {}", ended.stderr);
    ended
}

/// The files of a folder by name, with what they hold; a folder in it holds nothing.
///
/// # Panics
///
/// If the folder cannot be read.
pub fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entry = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.expect("an entry of the folder");
        let bytes = if entry.path().is_dir() { Vec::new() } else { std::fs::read(entry.path()).expect("a file") };
        (entry.file_name().to_string_lossy().into_owned(), bytes)
    };
    std::fs::read_dir(folder).expect("a folder").map(entry).collect()
}

/// The names of what a folder holds, in their order.
///
/// # Panics
///
/// If the folder cannot be read.
pub fn names(folder: &Path) -> Vec<String> {
    let name = |entry: std::io::Result<std::fs::DirEntry>| entry.expect("an entry of the folder").file_name();
    let entries = std::fs::read_dir(folder).expect("a folder").map(name);
    let mut names: Vec<String> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// An image in RGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Image<T> {
    /// Width (pixels).
    pub width: usize,
    /// Height (pixels).
    pub height: usize,
    /// Three values a pixel, row by row from the top.
    pub rgb: Vec<T>,
}

impl<T: Copy> Image<T> {
    /// One pixel.
    pub fn at(&self, column: usize, row: usize) -> [T; 3] {
        let at = 3 * (row * self.width + column);
        std::array::from_fn(|i| self.rgb[at + i])
    }
}

impl Image<f32> {
    /// Column and row of the pixel with the most green, the largest part of luminance.
    pub fn brightest(&self) -> (usize, usize) {
        let green = |i: &usize| self.rgb[3 * i + 1];
        let i = (0..self.width * self.height).max_by(|a, b| green(a).total_cmp(&green(b))).expect("a pixel");
        (i % self.width, i / self.width)
    }
}

/// Reads a picture of 8 bit RGB.
///
/// # Panics
///
/// If the file is not one.
pub fn read_png(path: &Path) -> Image<u8> {
    let image::DynamicImage::ImageRgb8(image) = image::open(path).expect("a picture") else {
        panic!("{} is not 8 bit RGB", path.display())
    };
    Image { width: image.width() as usize, height: image.height() as usize, rgb: image.into_raw() }
}

/// Reads an EXR that holds R, G and B in 32 bit floats and nothing else, and the chromaticities (x, y) of its red,
/// green, blue and white.
///
/// # Panics
///
/// If the file is not one.
pub fn read_exr(path: &Path) -> (Image<f32>, [[f32; 2]; 4]) {
    let file = read_first_flat_layer_from_file(path).expect("an EXR");
    let chromaticities = file.attributes.chromaticities.expect("chromaticities");
    let channels = &file.layer_data.channel_data.list;
    assert_eq!(channels.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>(), ["B", "G", "R"]);
    let samples = |channel: usize| match &channels[channel].sample_data {
        FlatSamples::F32(samples) => samples,
        _ => panic!("{} is not of 32 bit floats", path.display()),
    };
    let (red, green, blue) = (samples(2), samples(1), samples(0));
    let rgb = red.iter().zip(green).zip(blue).flat_map(|((r, g), b)| [*r, *g, *b]).collect();
    let size = file.layer_data.size;
    let c = chromaticities;
    let points = [c.red, c.green, c.blue, c.white].map(|point| [point.x(), point.y()]);
    (Image { width: size.width(), height: size.height(), rgb }, points)
}

/// Writes an EXR of some channels in 32 bit floats, whose values are given row by row from the top.
///
/// # Panics
///
/// If it cannot be written.
pub fn write_channels(path: &Path, (width, height): (usize, usize), channels: &[(&str, Vec<f32>)]) {
    let channel = |(name, values): &(&str, Vec<f32>)| AnyChannel::new(*name, FlatSamples::F32(values.clone()));
    let channels = AnyChannels::sort(channels.iter().map(channel).collect());
    exr::prelude::Image::from_channels((width, height), channels).write().to_file(path).expect("an EXR");
}

/// The channels of an EXR by name.
///
/// # Panics
///
/// If the file is not one.
pub fn read_channels(path: &Path) -> BTreeMap<String, Vec<f32>> {
    let file = read_first_flat_layer_from_file(path).expect("an EXR");
    let channel =
        |channel: AnyChannel<FlatSamples>| (channel.name.to_string(), channel.sample_data.values_as_f32().collect());
    file.layer_data.channel_data.list.into_iter().map(channel).collect()
}
