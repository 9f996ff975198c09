//! Errors.

use std::fmt;
use std::path::PathBuf;

use crate::input::shown;

/// The reason why a request failed. Each message is one sentence with the key or file, the value, and the allowed
/// range.
///
/// A `key` is a key of a scene file, such as `sun.elevation`, or the name of an argument, such as `wavelengths`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number is outside its range. Both ends of the range are allowed.
    #[error("{key} is {}; it must lie between {} and {}{}", shown(*value), shown(*low), shown(*high), spaced(unit))]
    OutOfRange {
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
        /// The smallest that is allowed.
        low: f64,
        /// The largest that is allowed.
        high: f64,
        /// The unit of all three; empty if they have none.
        unit: &'static str,
    },
    /// A value violates another rule, or conflicts with other values.
    #[error("{key} {complaint}")]
    NotAllowed {
        /// The key.
        key: &'static str,
        /// The value and what is allowed, to be read after the key.
        complaint: String,
    },
    /// No scene has a key of this name.
    #[error("unknown key `{name}`; {hint}")]
    UnknownKey {
        /// The name.
        name: String,
        /// The key that was probably meant, or the available ones.
        hint: String,
    },
    /// A text is not valid TOML, or a value has the wrong type for its key.
    #[error("{0}")]
    Text(String),
    /// An error at a position in a scene file.
    #[error("{place}: {error}")]
    InFile {
        /// The position.
        place: PlaceInFile,
        /// The error.
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
    /// A file name selects no format that can be written.
    #[error("{}: {complaint}", path.display())]
    FileName {
        /// The name.
        path: PathBuf,
        /// The error.
        complaint: String,
    },
    /// Two files of one request have the same name.
    #[error("{} is {}; every output needs a name of its own", path.display(), how)]
    SharedFile {
        /// The name.
        path: PathBuf,
        /// The two uses of the name.
        how: &'static str,
    },
    /// A file exists that must not be replaced.
    #[error("{} exists; choose another name, or move it away", path.display())]
    FileExists {
        /// Its name.
        path: PathBuf,
    },
    /// A file exists that this program did not write, or that has changed since, and its name was not requested
    /// explicitly.
    #[error("{} exists, and this program did not write it as it stands; choose another name, or move it away", path.display())]
    ForeignFile {
        /// Its name.
        path: PathBuf,
    },
    /// A request concerns spectral files, but no file is spectral.
    #[error("{key} needs a spectral file: NAME.spectral.exr, NAME.hsr, or NAME.exr where every EXR file is spectral")]
    NoSpectralFile {
        /// The request.
        key: &'static str,
    },
    /// The position of the sun is unknown at a time.
    #[error("the sun cannot be placed at {time}: {reason}")]
    UnknownMoment {
        /// The time.
        time: String,
        /// Why not.
        reason: String,
    },
    /// A file cannot be written; found before any work.
    #[error("{} cannot be written: {reason}", path.display())]
    NotWritable {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// A disk has no space for a file; found before any work.
    #[error(
        "{}: an image of {size} pixels (camera.size) takes at least {:.1} GiB, but only {:.1} GiB are free there",
        path.display(), gib(*least), gib(*free)
    )]
    NoRoom {
        /// The file.
        path: PathBuf,
        /// Width and height of its image.
        size: String,
        /// The smallest size of the file (bytes).
        least: u64,
        /// The free space (bytes).
        free: u64,
    },
    /// No device has this name.
    #[error("{choice:?} is not a device of this machine; allowed: {}", names.join(", "))]
    NoSuchDevice {
        /// The requested name.
        choice: String,
        /// The available names.
        names: Vec<String>,
    },
    /// A device failed; the request may succeed on another one.
    #[error("{0}")]
    Device(String),
    /// A buffer or texture of the program is unsuitable for an image.
    #[error("the target {0}")]
    Target(String),
    /// The caller cancelled the request.
    #[error("stopped on request")]
    Stopped,
    /// An image does not fit into memory.
    #[error("{0}")]
    Memory(String),
    /// The system refuses to start another thread.
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

/// A position in a scene file.
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
    /// An error for a value that violates a rule.
    pub fn not_allowed(key: &'static str, complaint: impl Into<String>) -> Self {
        Self::NotAllowed { key, complaint: complaint.into() }
    }

    /// Whether a valid request failed.
    pub fn is_failure(&self) -> bool {
        match self {
            Self::Device(_) | Self::Memory(_) | Self::Stopped | Self::Thread(_) | Self::Write { .. } => true,
            Self::InFile { error, .. } | Self::InFrame { error, .. } => error.is_failure(),
            _ => false,
        }
    }
}

/// Checks that a number is in its range; NaN never is.
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

/// A result with an [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
