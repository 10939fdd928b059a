//! The hidden folder in which new contents are made ready, under a name that nobody can guess.

use std::io::{Error, Result};
use std::path::{Path, PathBuf};

use super::calls;

/// Beginning of all names that are ours and only there while something is written.
pub const PREFIX: &str = ".mpcgear-";

/// Letters of the part of a name that cannot be guessed.
const RANDOM: usize = 12;

/// A stage for one target; removed with all that is in it when dropped.
#[derive(Debug)]
pub struct Stage {
    path: PathBuf,
}

impl Stage {
    /// Makes a stage in `place` for the target called `name`.
    pub fn new(place: &Path, name: &str) -> Result<Stage> {
        let made = tempfile::Builder::new()
            .prefix(&format!("{PREFIX}{name}-"))
            .rand_bytes(RANDOM)
            .tempdir_in(place)
            .map_err(super::plain)?;
        let stage = Stage { path: made.keep() };
        calls::make_dir(&stage.new_contents())?;
        Ok(stage)
    }

    /// Stages for `name` that killed processes left in `place`; only the owner of the target's lock
    /// may ask.
    pub fn left(place: &Path, name: &str) -> Vec<Stage> {
        let beginning = format!("{PREFIX}{name}-");
        let entries = std::fs::read_dir(place).into_iter().flatten().flatten();
        let mut left: Vec<Stage> = entries
            .filter(|entry| {
                let name = entry.file_name();
                let random = name.to_str().and_then(|n| n.strip_prefix(&beginning));
                random.is_some_and(|r| {
                    r.len() == RANDOM && r.bytes().all(|b| b.is_ascii_alphanumeric())
                })
            })
            .filter(|entry| entry.file_type().is_ok_and(|t| t.is_dir()))
            .map(|entry| Stage { path: entry.path() })
            .collect();
        left.sort_by(|a, b| a.path.cmp(&b.path));
        left
    }

    /// The stage itself.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where new contents are made ready.
    pub fn new_contents(&self) -> PathBuf {
        self.path.join("new")
    }
}

impl Stage {
    /// Leaves the stage where it is, since it may hold what is nowhere else: the next run tries again.
    /// Returns `error` with the place.
    pub fn leave(self, error: &Error) -> Error {
        let what = format!(
            "{error}; what was to be written is in {}",
            self.path.display()
        );
        std::mem::forget(self);
        Error::new(error.kind(), what)
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        // What cannot be removed now is removed by the next run.
        let _ = calls::remove_tree(&self.path);
    }
}
