//! The ways in which a request can end badly.

/// Why a request was not carried out. Each message is one sentence that names what, where, and what is allowed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The request itself is wrong: a value out of range, an unknown key, an unknown device. Exit code 2.
    #[error("{0}")]
    Request(String),
    /// The request was right and could not be carried out: a file could not be written. Exit code 1.
    #[error("{0}")]
    Failure(String),
    /// The request was right and a device failed; another one may carry it out. Exit code 1.
    #[error("{0}")]
    Device(String),
}

impl Error {
    /// A wrong request.
    pub fn request(message: impl Into<String>) -> Self {
        Self::Request(message.into())
    }

    /// A failure.
    pub fn failure(message: impl Into<String>) -> Self {
        Self::Failure(message.into())
    }

    /// The process exit code for this error.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Request(_) => 2,
            Self::Failure(_) | Self::Device(_) => 1,
        }
    }
}

/// The result of anything that can end in an [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
