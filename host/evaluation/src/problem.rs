//! The ways in which a measurement can end badly.

use std::path::PathBuf;

/// Why something was not measured, or not reported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The sky could not be computed, a file not written, or an argument is out of its range.
    #[error(transparent)]
    Sky(#[from] sorairo::Error),
    /// The folder of a report cannot be made.
    #[error("{} cannot be made: {reason}", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// Why not.
        reason: String,
    },
    /// A chart or a picture cannot be drawn.
    #[error("{what} cannot be drawn: {reason}")]
    Drawing {
        /// What was to be drawn.
        what: String,
        /// Why not.
        reason: String,
    },
    /// A picture cannot be read.
    #[error("{} cannot be read: {reason}", path.display())]
    Picture {
        /// The picture.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// What is to be measured does not happen.
    #[error("{0}")]
    Nothing(String),
}

/// The result of anything that can end in an [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
