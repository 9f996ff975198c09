//! Error messages of the command line: they name flags, and have exit codes.

use std::fmt;

use sorairo::Error as Sky;

use crate::flags::flag;

/// Why a command was not carried out.
#[derive(Debug)]
pub enum Error {
    /// What was asked of the library is wrong, or it failed.
    Sky(Sky),
    /// A measurement failed.
    #[cfg(feature = "evaluation")]
    Evaluation(sorairo_evaluation::Error),
    /// The window failed.
    #[cfg(feature = "view")]
    View(sorairo_view::Error),
    /// The request is wrong, in a sentence.
    Request(String),
    /// The request was right and was not carried out, in a sentence.
    Failure(String),
}

/// The result of a command.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// A wrong request.
    pub fn request(message: impl Into<String>) -> Self {
        Self::Request(message.into())
    }

    /// The exit code of the process: 2 for a wrong request, 1 for one that failed.
    pub fn exit_code(&self) -> u8 {
        let failed = match self {
            Self::Sky(error) => error.is_failure(),
            #[cfg(feature = "evaluation")]
            Self::Evaluation(sorairo_evaluation::Error::Sky(error)) => error.is_failure(),
            #[cfg(feature = "evaluation")]
            Self::Evaluation(error) => !matches!(error, sorairo_evaluation::Error::Folder { .. }),
            #[cfg(feature = "view")]
            Self::View(sorairo_view::Error::Sky(error)) => error.is_failure(),
            #[cfg(feature = "view")]
            Self::View(_) => true,
            Self::Request(_) => false,
            Self::Failure(_) => true,
        };
        if failed { 1 } else { 2 }
    }
}

impl From<Sky> for Error {
    fn from(error: Sky) -> Self {
        Self::Sky(error)
    }
}

#[cfg(feature = "evaluation")]
impl From<sorairo_evaluation::Error> for Error {
    fn from(error: sorairo_evaluation::Error) -> Self {
        Self::Evaluation(error)
    }
}

#[cfg(feature = "view")]
impl From<sorairo_view::Error> for Error {
    fn from(error: sorairo_view::Error) -> Self {
        Self::View(error)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sky(error) => f.write_str(&with_flags(error)),
            #[cfg(feature = "evaluation")]
            Self::Evaluation(sorairo_evaluation::Error::Sky(error)) => f.write_str(&with_flags(error)),
            #[cfg(feature = "evaluation")]
            Self::Evaluation(error @ sorairo_evaluation::Error::Folder { .. }) => write!(f, "--out {error}"),
            #[cfg(feature = "evaluation")]
            Self::Evaluation(error) => error.fmt(f),
            #[cfg(feature = "view")]
            Self::View(sorairo_view::Error::Sky(error)) => f.write_str(&with_flags(error)),
            #[cfg(feature = "view")]
            Self::View(error) => error.fmt(f),
            Self::Request(text) | Self::Failure(text) => f.write_str(text),
        }
    }
}

/// The library's sentence with flags in the place of its keys and arguments; what stands in a file keeps its keys.
fn with_flags(error: &Sky) -> String {
    match error {
        Sky::InFile { .. } | Sky::FileExists { .. } => error.to_string(),
        Sky::ForeignFile { path } => format!(
            "{} exists, and sorairo did not write it as it stands; --force replaces it, -o takes another name",
            path.display()
        ),
        Sky::InFrame { number, error } => format!("frame {number}: {}", with_flags(error)),
        Sky::NoSuchDevice { .. } => format!("--device {error}"),
        Sky::FileName { .. } | Sky::SharedFile { .. } | Sky::NotWritable { .. } | Sky::Write { .. } => {
            format!("-o {error}")
        }
        Sky::NoRoom { .. } => format!("-o {}", named_by_flags(&error.to_string())),
        Sky::NoSpectralFile { key } => {
            let flag = flag(key).unwrap_or(key);
            format!("{flag} needs a spectral file: -o NAME.spectral.exr, -o NAME.hsr, or -o NAME.exr with --spectral")
        }
        Sky::OutOfRange { key, .. } | Sky::NotAllowed { key, .. } if !key.contains('.') => {
            error.to_string().replacen(key, flag(key).unwrap_or(key), 1)
        }
        _ => named_by_flags(&error.to_string()),
    }
}

/// A sentence whose keys of a scene are named by their flags: `sun.elevation` as `--sun-elevation (sun.elevation)`, and
/// `render.fit = dense` as `--fit dense`.
fn named_by_flags(sentence: &str) -> String {
    let mut words = sentence.split(' ').peekable();
    let mut named = Vec::new();
    while let Some(word) = words.next() {
        let key = word.trim_matches(['(', ')', ',', ';', ':']);
        let Some(flag) = flag(key).filter(|_| key.contains('.')) else {
            named.push(word.to_owned());
            continue;
        };
        let has_value = words.next_if_eq(&"=").is_some();
        let both = if word.starts_with('(') { format!("{flag}, {key}") } else { format!("{flag} ({key})") };
        named.push(word.replace(key, if has_value { flag } else { &both }));
    }
    named.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_named_by_their_flags() {
        let cases = [
            ("sun.elevation is 100; it must lie", "--sun-elevation (sun.elevation) is 100; it must lie"),
            ("sun.disc needs render.exr = f32: the disc", "--sun-disc (sun.disc) needs --exr f32: the disc"),
            ("an image (camera.size) takes", "an image (--size, camera.size) takes"),
            (
                "sun.place needs a time: give sun.time too",
                "--place (sun.place) needs a time: give --time (sun.time) too",
            ),
            ("atmosphere.ozone.peak is 9", "atmosphere.ozone.peak is 9"),
        ];
        for (sentence, expected) in cases {
            assert_eq!(named_by_flags(sentence), expected);
        }
    }

    #[test]
    fn an_argument_is_its_flag_and_a_place_in_a_file_keeps_its_keys() {
        let error = Sky::not_allowed("wavelengths", "holds 300; wavelengths must lie between 360 and 830 nm");
        assert_eq!(with_flags(&error), "--wavelengths holds 300; wavelengths must lie between 360 and 830 nm");
        let located = sorairo::Scene::parse("sun.elevatoin = 1", "a.toml", None).unwrap_err();
        assert_eq!(with_flags(&located), located.to_string());
    }
}
