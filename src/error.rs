//! The one error of the crate, with the exit code each kind stands for.

use std::path::PathBuf;

/// Result with the crate's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// One thing that is wrong in the input: where, what was found, what is allowed, what to do.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Field path (`gear.teeth`), CSV line (`motion.csv line 14`) or phase.
    pub place: String,
    /// The offending value or fact, and the allowed range, in one sentence.
    pub what: String,
    /// What the user can do about it; empty when obvious.
    pub hint: String,
}

impl Problem {
    /// A problem at `place`; `hint` may be empty.
    pub fn new(
        place: impl Into<String>,
        what: impl Into<String>,
        hint: impl Into<String>,
    ) -> Problem {
        Problem {
            place: place.into(),
            what: what.into(),
            hint: hint.into(),
        }
    }
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.place, self.what)?;
        if !self.hint.is_empty() {
            write!(f, "\n      hint: {}", self.hint)?;
        }
        Ok(())
    }
}

/// Everything that can go wrong, by who has to act on it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The input is wrong; all problems found are listed. Exit code 2.
    #[error("{}: {} problem(s)\n{}", file.display(), problems.len(),
        problems.iter().map(|p| format!("  - {p}")).collect::<Vec<_>>().join("\n"))]
    Input {
        /// File the problems are in.
        file: PathBuf,
        /// All problems found, in reading order.
        problems: Vec<Problem>,
    },
    /// A file or folder could not be read or written. Exit code 2.
    #[error("{}: {source}", path.display())]
    Io {
        /// Path that was touched.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The motion cannot be made into a gear. Exit code 3.
    #[error("infeasible: {reason}\n  where: {place}\n  hint: {hint}")]
    Infeasible {
        /// Named reason.
        reason: String,
        /// φ, sub-gear pair, tooth.
        place: String,
        /// What to change.
        hint: String,
    },
    /// Stopped by Ctrl-C before there was any design. Exit code 130.
    #[error("interrupted before there was any design; nothing was written")]
    Interrupted,
    /// The solid kernel or a template failed: a defect of ours, with what is known. Exit code 1.
    #[error("internal: {0}")]
    Internal(String),
}

impl Error {
    /// Process exit code of this error.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Input { .. } | Error::Io { .. } => 2,
            Error::Infeasible { .. } => 3,
            Error::Interrupted => 130,
            Error::Internal(_) => 1,
        }
    }

    /// Bad input found in `file`.
    pub fn input(file: impl Into<PathBuf>, problems: Vec<Problem>) -> Error {
        Error::Input {
            file: file.into(),
            problems,
        }
    }

    /// Wraps an I/O error with the path it happened at.
    pub fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Error {
        let path = path.into();
        move |source| Error::Io { path, source }
    }
}
