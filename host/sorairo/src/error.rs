//! The ways in which a request can end badly.

use std::fmt;
use std::path::PathBuf;

use crate::input::shown;

/// Why a request was not carried out. Each message is one sentence that names what, where, and what is allowed.
///
/// A `key` is a key of a scene file, such as `sun.elevation`, or else the name of an argument, such as `wavelengths`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number lies outside its range, both ends of which are allowed.
    #[error("{key} is {}; it must lie between {} and {}{}", shown(*value), shown(*low), shown(*high), spaced(unit))]
    OutOfRange {
        /// What is out of its range.
        key: &'static str,
        /// Its value.
        value: f64,
        /// The smallest that is allowed.
        low: f64,
        /// The largest that is allowed.
        high: f64,
        /// The unit of all three; empty where they have none.
        unit: &'static str,
    },
    /// A value breaks another rule, or does not go with other values.
    #[error("{key} {complaint}")]
    NotAllowed {
        /// What is not allowed.
        key: &'static str,
        /// The value and what is allowed, to be read after the key.
        complaint: String,
    },
    /// No scene has a key of this name.
    #[error("unknown key `{name}`; {hint}")]
    UnknownKey {
        /// The name.
        name: String,
        /// The key that may have been meant, or those that there are.
        hint: String,
    },
    /// A text is not TOML, or a value of it is not of its key's kind.
    #[error("{0}")]
    Text(String),
    /// What is wrong stands at a place in a scene file.
    #[error("{place}: {error}")]
    InFile {
        /// The place.
        place: PlaceInFile,
        /// What is wrong there.
        error: Box<Error>,
    },
    /// A scene file cannot be read.
    #[error("the scene file {} {reason}", path.display())]
    SceneFile {
        /// The file.
        path: PathBuf,
        /// What follows its name.
        reason: String,
    },
    /// The name of a file says nothing that can be written.
    #[error("{}: {complaint}", path.display())]
    FileName {
        /// The name.
        path: PathBuf,
        /// What is wrong with it.
        complaint: String,
    },
    /// Two files of one request have the same name.
    #[error("{} is {}; every output needs a name of its own", path.display(), how)]
    SharedFile {
        /// The name.
        path: PathBuf,
        /// How it is there twice.
        how: &'static str,
    },
    /// There is a file already that must not be replaced.
    #[error("{} exists; choose another name, or move it away", path.display())]
    FileExists {
        /// Its name.
        path: PathBuf,
    },
    /// There is a file already that this program did not write, or that has changed since, and nobody asked for its
    /// name.
    #[error("{} exists, and this program did not write it as it stands; choose another name, or move it away", path.display())]
    ForeignFile {
        /// Its name.
        path: PathBuf,
    },
    /// Something is asked of spectral files, and no file is one.
    #[error("{key} needs a spectral file: NAME.spectral.exr, NAME.hsr, or NAME.exr where every EXR file is spectral")]
    NoSpectralFile {
        /// What is asked.
        key: &'static str,
    },
    /// The sun's place in the sky is not known at a time.
    #[error("the sun cannot be placed at {time}: {reason}")]
    UnknownMoment {
        /// The time.
        time: String,
        /// Why not.
        reason: String,
    },
    /// A file cannot be written there; found before any work.
    #[error("{} cannot be written: {reason}", path.display())]
    NotWritable {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// A disk has no room for a file; found before any work.
    #[error(
        "{}: an image of {size} pixels (camera.size) takes at least {:.1} GiB, and {:.1} GiB are free there",
        path.display(), gib(*least), gib(*free)
    )]
    NoRoom {
        /// The file.
        path: PathBuf,
        /// Width and height of its image.
        size: String,
        /// The fewest bytes that it takes.
        least: u64,
        /// The bytes that are free.
        free: u64,
    },
    /// No device has this name.
    #[error("{choice:?} is not a device of this machine; allowed: {}", names.join(", "))]
    NoSuchDevice {
        /// What was asked for.
        choice: String,
        /// What may be asked for.
        names: Vec<String>,
    },
    /// A device failed; another one may carry the request out.
    #[error("{0}")]
    Device(String),
    /// A program's own buffer or texture cannot take an image.
    #[error("the target {0}")]
    Target(String),
    /// The caller asked to stop.
    #[error("stopped on request")]
    Stopped,
    /// An image does not fit into memory.
    #[error("{0}")]
    Memory(String),
    /// The system lets the process have no further thread.
    #[error("no thread can be started: {0}")]
    Thread(std::io::Error),
    /// A file could not be written.
    #[error("{} cannot be written: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// One frame of a sequence could not be rendered.
    #[error("frame {number}: {error}")]
    InFrame {
        /// Its number.
        number: u32,
        /// Why not.
        error: Box<Error>,
    },
}

/// A place in a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PlaceInFile {
    /// The name of the file.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column, from 1.
    pub column: usize,
    /// The line's text, or the first of it.
    pub text: String,
}

impl fmt::Display for PlaceInFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, line, column, text } = self;
        write!(f, "{file}, line {line}, column {column} ({text})")
    }
}

impl Error {
    /// A value that breaks a rule.
    pub fn not_allowed(key: &'static str, complaint: impl Into<String>) -> Self {
        Self::NotAllowed { key, complaint: complaint.into() }
    }

    /// Whether the request was right, and could not be carried out all the same.
    pub fn is_failure(&self) -> bool {
        match self {
            Self::Device(_) | Self::Memory(_) | Self::Stopped | Self::Thread(_) | Self::Write { .. } => true,
            Self::InFile { error, .. } | Self::InFrame { error, .. } => error.is_failure(),
            _ => false,
        }
    }
}

/// Checks that a number lies in its range; NaN lies in none.
///
/// # Errors
///
/// [`Error::OutOfRange`] if it does not.
pub fn check_range(key: &'static str, value: f64, (low, high): (f64, f64), unit: &'static str) -> Result<()> {
    if (low..=high).contains(&value) { Ok(()) } else { Err(Error::OutOfRange { key, value, low, high, unit }) }
}

/// Checks that wavelengths (nm) lie between two.
///
/// # Errors
///
/// [`Error::NotAllowed`] for the first that does not.
pub fn check_wavelengths((shortest, longest): (f64, f64), wavelengths: &[f64]) -> Result<()> {
    match wavelengths.iter().find(|&&wavelength| !(shortest..=longest).contains(&wavelength)) {
        Some(outside) => {
            let complaint = format!("holds {outside}; wavelengths must lie between {shortest} and {longest} nm");
            Err(Error::not_allowed("wavelengths", complaint))
        }
        None => Ok(()),
    }
}

/// A unit as it follows a number.
fn spaced(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}

fn gib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 30)
}

/// The result of anything that can end in an [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
