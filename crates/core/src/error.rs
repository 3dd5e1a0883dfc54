use std::{
    borrow::Cow,
    path::{Path, PathBuf},
};

/// A result with [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// The error of reading, of a stage or of writing.
///
/// Messages are lower case, name the element, and say what was expected and found; [`hint`](Self::hint) says a way out.
/// A stage does not repeat its own name or the name of a file it was not told: the pipeline adds both.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Two inputs disagree about a count.
    #[error("{what}: expected {expected}, found {found}")]
    Shape {
        /// The quantity, in words, e.g. "posed source vertices (#V)".
        what: &'static str,
        /// The count that the other inputs imply.
        expected: usize,
        /// The count given.
        found: usize,
    },
    /// A mesh, marker or correspondence that no stage can work with.
    #[error("{message}")]
    Data {
        /// The element, what was expected and what was found.
        message: String,
        /// A way out.
        hint: String,
    },
    /// A setting outside its range.
    #[error("{setting}: expected {expected}, found {found}")]
    Setting {
        /// The key as in YAML, with those that lead to it, e.g. `term_weights.gaps`.
        setting: Cow<'static, str>,
        /// The range in words.
        expected: String,
        /// The value.
        found: String,
    },
    /// A file whose contents cannot be read.
    #[error("{}{}: {message}", path.display(), line.map(|l| format!(":{l}")).unwrap_or_default())]
    File {
        /// The file.
        path: PathBuf,
        /// The line, from 1, in text files.
        line: Option<usize>,
        /// The expected and the found contents.
        message: String,
        /// A way out.
        hint: String,
    },
    /// A file that cannot be opened, read or written.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// "read" or "write".
        action: &'static str,
        /// The system's answer.
        source: std::io::Error,
    },
    /// A file that another refers to and that may not be opened.
    #[error("{}: it refers to {}, {reason}", path.display(), referenced.display())]
    OutOfReach {
        /// The file that refers to the other.
        path: PathBuf,
        /// The other.
        referenced: PathBuf,
        /// Why it may not be opened.
        reason: &'static str,
    },
    /// A linear system without a unique solution.
    #[error("{what} is not positive definite")]
    Singular {
        /// The system, in words.
        what: &'static str,
        /// The usual cause.
        hint: String,
    },
    /// An iteration that stopped before it reached its tolerance.
    #[error(
        "{what} did not converge: residual {residual:.3e} after {iterations} iterations, tolerance {tolerance:.3e}"
    )]
    NoConvergence {
        /// The solver.
        what: &'static str,
        /// Iterations done.
        iterations: usize,
        /// Residual reached.
        residual: f64,
        /// Residual asked for.
        tolerance: f64,
    },
    /// Work that would take more memory than the process may have.
    #[error(
        "{what} would take {} of memory beside the {} in use, and {} are allowed",
        in_words(*needed), in_words(*used), in_words(*limit)
    )]
    Memory {
        /// The work or the data, in words.
        what: String,
        /// What it takes, in bytes.
        needed: u64,
        /// What the process has now, in bytes.
        used: u64,
        /// What the process may have, in bytes.
        limit: u64,
    },
    /// Anything else a plug-in raises itself.
    #[error(transparent)]
    Other(#[from] Box<dyn std::error::Error + Send + Sync>),
}

/// A number of bytes in words, as `2.1 GB`.
fn in_words(bytes: u64) -> String {
    match bytes as f64 {
        b if b < 1e9 => format!("{:.0} MB", (b / 1e6).ceil()),
        b => format!("{:.1} GB", b / 1e9),
    }
}

impl Error {
    /// An [`Error::Data`].
    pub fn data(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::Data { message: message.into(), hint: hint.into() }
    }

    /// An [`Error::File`] at a line (from 1) of a text file.
    pub fn line(path: &Path, line: usize, message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::File { path: path.into(), line: Some(line), message: message.into(), hint: hint.into() }
    }

    /// An [`Error::File`] about a file as a whole.
    pub fn file(path: &Path, message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::File { path: path.into(), line: None, message: message.into(), hint: hint.into() }
    }

    /// An [`Error::Io`] from reading `path`.
    pub fn read(path: &Path, source: std::io::Error) -> Self {
        Self::Io { path: path.into(), action: "read", source }
    }

    /// An [`Error::Io`] from writing `path`.
    pub fn write(path: &Path, source: std::io::Error) -> Self {
        Self::Io { path: path.into(), action: "write", source }
    }

    /// `Ok` if `found == expected`, else [`Error::Shape`].
    ///
    /// # Errors
    ///
    /// [`Error::Shape`], naming `what`.
    pub fn check_shape(what: &'static str, expected: usize, found: usize) -> Result<()> {
        if expected == found { Ok(()) } else { Err(Self::Shape { what, expected, found }) }
    }

    /// A way out, if there is one to tell.
    pub fn hint(&self) -> Option<&str> {
        match self {
            Self::Data { hint, .. } | Self::File { hint, .. } | Self::Singular { hint, .. } if !hint.is_empty() => {
                Some(hint)
            }
            Self::Memory { .. } => Some("take meshes of fewer vertices, or fewer threads"),
            Self::OutOfReach { .. } => Some("put the file beside the one that refers to it"),
            _ => None,
        }
    }
}
