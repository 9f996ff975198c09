//! The commands and their flags.

#![expect(missing_docs, reason = "a doc comment here is the text of a help page")]

mod between;
#[cfg(feature = "evaluation")]
mod measuring;
mod shared;

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use sorairo::files::{Format, Replace};
use sorairo::scene::Preset;
use sorairo::scene::place::Time;
use sorairo::{Request, StokesFrame};

use crate::flags::{SceneFlags, SharedFlags, SkyFlags, word_of};
use crate::ranges::{FrameChoice, FrameExposure, Numbers, elevations, wavelengths};

pub use between::{AerialArguments, BetweenArguments, BetweenFormat};
#[cfg(feature = "evaluation")]
pub use measuring::{BandsArguments, BenchArguments, EvaluationCommand, ReproduceArguments, StressArguments};
pub use shared::{ReplaceFlags, SceneArguments, SpectralFlags, scene};
use shared::{device, number};

/// Renders the clear sky in full spectrum on the GPU.
#[derive(Parser)]
#[command(name = "sorairo", version)]
pub struct Arguments {
    /// Print no progress and no summary; errors and warnings remain.
    #[arg(long, global = true)]
    pub quiet: bool,
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    /// Renders the sky into PNG and EXR files.
    Render(RenderArguments),
    /// Renders numbered frames under a moving sun, and skips frames that exist already.
    ///
    /// The sun moves through elevations (--sun-elevation) or through time at a place (--from, --to, --frames N,
    /// --place). A frame is skipped if all its files are complete and from this version of the program and the same
    /// scene. --frames A-B renders a range and --frame N one frame, so that processes or machines share the work. When
    /// the last frame is complete, contact.png beside the frames shows up to 64 of them, evenly spaced.
    Sequence(SequenceArguments),
    /// Prints the spectrum of the sky in one direction or many.
    Spectrum(SpectrumArguments),
    /// Prints the transmittance and the in-scattered radiance of the air up to a distance.
    Between(BetweenArguments),
    /// Writes the in-scattered light and the transmittance of the air in front of each pixel of a depth image, or an
    /// image seen through it.
    ///
    /// The depth image gives the size of the output. An infinite depth, or one of 10¹⁰ and more, is the sky or the
    /// scene's ground; a depth behind the ground ends on it. Light is linear RGB as in the EXR files of `render`,
    /// exposed by --exr-exposure alone.
    Aerial(Box<AerialArguments>),
    /// Opens a window that shows the sky; a click plots its spectrum.
    View(ViewArguments),
    #[cfg(feature = "evaluation")]
    #[command(flatten)]
    Evaluation(EvaluationCommand),
    /// Lists the devices of this machine, best first.
    Devices(DevicesArguments),
    /// Writes, checks and shows scene files.
    #[command(subcommand)]
    Scene(SceneCommand),
    /// Prints completions of commands and flags for a shell.
    Completions {
        /// The shell.
        #[arg(ignore_case = true)]
        shell: Shell,
    },
    /// Prints the manual page of the program, or of one of its commands.
    Man {
        /// The command.
        #[arg(value_name = "COMMAND")]
        command: Option<String>,
    },
}

#[derive(Subcommand)]
pub enum SceneCommand {
    /// Writes a scene file with every key and its default, each under a comment; --force replaces an existing file.
    New {
        /// File to write.
        #[arg(default_value = "scene.toml")]
        file: PathBuf,
        /// Preset whose values are written.
        #[arg(long, default_value = "standard", ignore_case = true, value_parser = word_of::<Preset>())]
        preset: Preset,
        #[command(flatten)]
        replace: ReplaceFlags,
    },
    /// Checks a scene file, and reports every error in it.
    Check {
        #[command(flatten)]
        file: SceneFile,
    },
    /// Prints a complete scene as TOML: the preset, overridden by the file, overridden by the flags.
    Show {
        /// Scene file (TOML) [default: none, the preset alone].
        file: Option<PathBuf>,
        /// The same, as the other commands name it.
        #[arg(long, value_name = "FILE", conflicts_with = "file")]
        scene: Option<PathBuf>,
        #[command(flatten)]
        flags: SceneFlags,
    },
    /// Prints the reference of every key, in Markdown.
    Reference,
}

/// The file of a command that needs one.
#[derive(Args)]
#[group(required = true, multiple = false)]
pub struct SceneFile {
    /// Scene file (TOML).
    file: Option<PathBuf>,
    /// The same, as the other commands name it.
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
}

impl SceneFile {
    /// Its path.
    pub fn path(&self) -> &Path {
        self.file.as_deref().or(self.scene.as_deref()).expect("one of the two is required")
    }
}

#[derive(Args)]
pub struct RenderArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    #[arg(short = 'o', long = "output", value_name = "OUT", help = format!(
        "File to write, {} (.spectral.exr for a spectral one); repeatable [default: sky.png and sky.exr, which replace \
         only files that sorairo wrote]",
        Format::extensions()
    ))]
    output: Vec<PathBuf>,
    #[command(flatten)]
    replace: ReplaceFlags,
    #[command(flatten)]
    spectral: SpectralFlags,
    /// Write each .png, .exr and .hdr twice: without the sun's disc, for lighting, and with it, for the camera (sky.exr
    /// and sky.sun.exr).
    #[arg(long)]
    pub split_sun: bool,
    /// Write a map of the polarisation with a legend, a .png, in the place of the sky.
    #[arg(long, value_name = "WHAT", value_enum, ignore_case = true, conflicts_with_all = ["json", "explain", "stokes"])]
    pub show: Option<Shown>,
    /// Print what the kernels skip, how the light field was made, and counts of samples and bytes (in --json as
    /// `explain`).
    #[arg(long)]
    pub explain: bool,
    /// Print one JSON object about the rendering to standard output.
    #[arg(long)]
    pub json: bool,
}

/// What a map shows.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Shown {
    /// The polarised fraction of the luminance, 0 to 1.
    PolarisationDegree,
    /// The angle of its electric vector, counterclockwise from the top of the image; grey where little is polarised.
    PolarisationAngle,
}

#[derive(Args)]
#[command(group(ArgGroup::new("suns").required(true).args(["sun-elevation", "from", "table"])))]
pub struct SequenceArguments {
    /// Elevations of the sun (degrees), one per frame: from A to B by STEP, B included if it falls on a step. The sun
    /// sinks if B is below A.
    #[arg(id = "sun-elevation", long, value_name = "A:B:STEP", allow_hyphen_values = true, value_parser = elevations)]
    pub sun_elevation: Option<Numbers>,
    /// Time of the first frame, with an offset from UTC, such as 2026-06-21T04:30:00+09:00; needs --to, --frames N and
    /// a place.
    #[arg(long, value_name = "TIME", requires = "to", conflicts_with = "sun-azimuth")]
    pub from: Option<Time>,
    /// Time of the last frame, in the same format.
    #[arg(long, value_name = "TIME", requires = "from")]
    pub to: Option<Time>,
    /// Table (CSV) of cases, one per frame. Its header names keys of a scene, such as sun.elevation,ground.albedo. A
    /// manifest.csv beside the frames lists the case of each file.
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// N: number of frames from --from to --to, evenly spaced in time, both ends included. A-B: render only frames A to
    /// B, counted from 0; repeatable [default: all].
    #[arg(long = "frames", value_name = "N|A-B")]
    pub frames: Vec<FrameChoice>,
    /// Exposure of the pictures: a number of stops; adapt: each frame as an eye adapts; auto: each frame metered;
    /// sequence: one for all, of the brightest frame; first: one for all, of the first [default: that of the scene file
    /// if it is fixed, else adapt; with --table that of the scene file].
    #[arg(long, value_name = "EV", allow_negative_numbers = true)]
    pub exposure: Option<FrameExposure>,
    /// Number of a frame to render, counted from 0, as farms pass it to a task; repeatable, and combines with --frames
    /// A-B.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub frame: Vec<u32>,
    /// Scene file (TOML).
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub sky: SharedFlags,
    /// Device: auto, cpu, gpu, or part of the name of a graphics device.
    #[arg(long, default_value = "auto", value_name = "NAME", value_parser = device)]
    pub device: String,
    #[arg(short = 'o', long = "output", value_name = "OUT", help = format!(
        "Files to write, {} (.spectral.exr for spectral ones); a run of # in the file name becomes the frame number with at \
         least as many digits. The folder is created. Repeatable [default: frames/sky.####.png, which replaces only files \
         that sorairo wrote]",
        Format::extensions()
    ))]
    output: Vec<PathBuf>,
    #[command(flatten)]
    pub replace: ReplaceFlags,
    #[command(flatten)]
    pub spectral: SpectralFlags,
    /// Write each .png, .exr and .hdr twice: without the sun's disc, for lighting, and with it, for the camera
    /// (sky.0001.exr and sky.0001.sun.exr).
    #[arg(long)]
    pub split_sun: bool,
    /// Print one JSON object about the sequence and each of its frames to standard output.
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub struct SpectrumArguments {
    /// Scene file (TOML).
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub sky: SkyFlags,
    /// Elevation of the direction (degrees).
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = number)]
    #[arg(required_unless_present_any = ["directions", "direct"], conflicts_with_all = ["directions", "direct"])]
    pub view_elevation: Option<f64>,
    /// Azimuth of the direction, clockwise from north (degrees).
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = number)]
    #[arg(required_unless_present_any = ["directions", "direct"], conflicts_with_all = ["directions", "direct"])]
    pub view_azimuth: Option<f64>,
    /// Print the sun's beam in place of the sky: rows of wavelength_nm,transmittance,irradiance.
    #[arg(long, conflicts_with = "luminance")]
    pub direct: bool,
    /// Width of the band about each wavelength over which spectra are averaged (nm).
    #[arg(long, value_name = "NM", conflicts_with = "luminance", value_parser = number)]
    pub resolution: Option<f64>,
    /// Table (CSV) of directions: an elevation and an azimuth per row (degrees).
    #[arg(long, value_name = "FILE", conflicts_with = "direct")]
    pub directions: Option<PathBuf>,
    /// Wavelengths in nm: START:END:STEP, or a list with commas.
    #[arg(long, value_name = "LIST", default_value = "380:780:5", value_parser = wavelengths)]
    pub wavelengths: Numbers,
    /// Print luminance (cd·m⁻²), chromaticity and correlated colour temperature (K) in place of the spectrum.
    #[arg(long, conflicts_with = "wavelengths")]
    pub luminance: bool,
    /// Print the Stokes vector in place of radiance: rows of wavelength_nm,stokes_i,stokes_q,stokes_u and the degree
    /// and angle of polarisation.
    #[arg(long, conflicts_with_all = ["luminance", "direct", "resolution"])]
    pub stokes: bool,
    /// Reference plane of the Stokes vector.
    #[arg(long, value_name = "NAME", requires = "stokes", default_value = "vertical", ignore_case = true, value_parser = word_of::<StokesFrame>())]
    pub stokes_frame: StokesFrame,
    /// Format of the output.
    #[arg(long, value_enum, ignore_case = true, default_value_t = SpectrumFormat::Csv)]
    pub format: SpectrumFormat,
}

#[derive(Args)]
pub struct ViewArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Point whose spectrum is plotted first, as fractions of the sky's width and height from the top left.
    #[arg(long, value_name = "X,Y", value_parser = fractions)]
    pub click: Option<[f64; 2]>,
    /// Save the window as a picture once it is complete, and close.
    #[arg(short = 'o', long, value_name = "FILE.png")]
    pub screenshot: Option<PathBuf>,
    /// Show N skies under a rising sun, print their rate, and close.
    #[arg(long, value_name = "N", conflicts_with = "screenshot", value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: Option<u32>,
    /// Print the rate as one JSON object.
    #[arg(long, requires = "frames")]
    pub json: bool,
}

fn fractions(text: &str) -> std::result::Result<[f64; 2], String> {
    let fraction = |text: &str| text.trim().parse().ok().filter(|fraction| (0.0..=1.0).contains(fraction));
    let point = text.split_once(',').and_then(|(x, y)| Some([fraction(x)?, fraction(y)?]));
    point.ok_or_else(|| "two numbers from 0 to 1 are wanted, such as 0.5,0.25".into())
}

#[derive(Clone, Copy, ValueEnum)]
pub enum SpectrumFormat {
    /// Rows of wavelength_nm,radiance,dense; for many directions preceded by view_elevation,view_azimuth.
    Csv,
    /// An array of objects with the same names; for many directions an array of such arrays.
    Json,
}

#[derive(Args)]
pub struct DevicesArguments {
    /// Print a JSON array.
    #[arg(long)]
    pub json: bool,
}

impl RenderArguments {
    /// Whether files are named.
    pub fn names_files(&self) -> bool {
        !self.output.is_empty()
    }

    /// What to write and to measure.
    pub fn request(&self) -> Request {
        Request {
            sky_light: self.json,
            split_sun: self.split_sun,
            ..request(&self.output, &["sky.png", "sky.exr"], &self.replace, &self.spectral)
        }
    }
}

impl SequenceArguments {
    /// What to write and to measure.
    pub fn request(&self) -> Request {
        let request = request(&self.output, &["frames/sky.####.png"], &self.replace, &self.spectral);
        Request { split_sun: self.split_sun, ..request }
    }
}

/// A request for the named files, or for the default ones, which replace no other program's files.
fn request(outputs: &[PathBuf], usual: &[&str], replace: &ReplaceFlags, spectral: &SpectralFlags) -> Request {
    let (outputs, allowed) = match outputs {
        [] => (usual.iter().map(PathBuf::from).collect(), Replace::Own),
        named => (named.to_vec(), Replace::All),
    };
    Request { replace: replace.or(allowed), ..spectral.request(outputs) }
}
