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
            place: shortened(place.into()),
            what: shortened(what.into()),
            hint: shortened(hint.into()),
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

/// Longest part of a message, letters; what is longer has a gap after the first [`BEGINNING`].
const LONGEST: usize = 600;
const BEGINNING: usize = 400;

/// Values as users give them can have millions of letters.
fn shortened(text: String) -> String {
    if text.len() <= LONGEST {
        return text;
    }
    let letters = text.chars().count();
    if letters <= LONGEST {
        return text;
    }
    let from = |n: usize| text.char_indices().nth(n).map_or(text.len(), |(at, _)| at);
    let (head, tail) = (from(BEGINNING), from(letters + BEGINNING - LONGEST));
    format!("{} … {}", &text[..head], &text[tail..])
}

/// Problems as they are found: the first [`Problems::KEPT`] are kept, the others counted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Problems {
    first: Vec<Problem>,
    more: usize,
}

impl Problems {
    /// How many are kept.
    pub const KEPT: usize = 20;

    /// Adds a problem.
    pub fn push(&mut self, problem: Problem) {
        self.add(|| problem);
    }

    /// Adds a problem that is only put into words if it is kept.
    pub fn add(&mut self, problem: impl FnOnce() -> Problem) {
        if self.first.len() < Self::KEPT {
            self.first.push(problem());
        } else {
            self.more += 1;
        }
    }

    /// `value` within `[min, max]`; `place` is only asked when it is not. NaN is not.
    pub(crate) fn range(
        &mut self,
        place: impl FnOnce() -> String,
        value: f64,
        [min, max]: [f64; 2],
    ) {
        if !(min..=max).contains(&value) {
            self.add(|| Problem::new(place(), format!("is {value}, allowed {min} to {max}"), ""));
        }
    }

    /// At most `most` entries; whether it is so.
    pub(crate) fn count(
        &mut self,
        place: impl FnOnce() -> String,
        count: usize,
        most: usize,
    ) -> bool {
        if count > most {
            self.add(|| Problem::new(place(), format!("has {count} entries, allowed {most}"), ""));
        }
        count <= most
    }

    /// Adds those that were found elsewhere.
    pub fn append(&mut self, other: Problems) {
        self.extend(other.first);
        self.more += other.more;
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.first.is_empty()
    }

    /// How many were found.
    pub fn len(&self) -> usize {
        self.first.len() + self.more
    }

    /// Those that are kept.
    pub fn first(&self) -> &[Problem] {
        &self.first
    }

    /// Those that are kept, to be changed.
    pub fn first_mut(&mut self) -> &mut [Problem] {
        &mut self.first
    }
}

impl Extend<Problem> for Problems {
    fn extend<I: IntoIterator<Item = Problem>>(&mut self, problems: I) {
        for problem in problems {
            self.push(problem);
        }
    }
}

impl From<Vec<Problem>> for Problems {
    fn from(list: Vec<Problem>) -> Problems {
        let mut problems = Problems::default();
        problems.extend(list);
        problems
    }
}

impl From<Problem> for Problems {
    fn from(problem: Problem) -> Problems {
        Problems::from(vec![problem])
    }
}

impl std::fmt::Display for Problems {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} problem(s)", self.len())?;
        for problem in &self.first {
            write!(f, "\n  - {problem}")?;
        }
        match self.more {
            0 => Ok(()),
            more => write!(f, "\n  … and {more} more"),
        }
    }
}

/// Everything that can go wrong, by who has to act on it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The input is wrong; the problems found are listed. Exit code 2.
    #[error("{}: {problems}", file.display())]
    Input {
        /// File the problems are in.
        file: PathBuf,
        /// The problems, in reading order.
        problems: Problems,
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
    pub fn input(file: impl Into<PathBuf>, problems: impl Into<Problems>) -> Error {
        Error::Input {
            file: file.into(),
            problems: problems.into(),
        }
    }

    /// Wraps an I/O error with the path it happened at.
    pub fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Error {
        let path = path.into();
        move |source| Error::Io { path, source }
    }
}
