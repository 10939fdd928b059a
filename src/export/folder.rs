//! Output folders that appear whole or not at all.
//!
//! A folder belongs to the user; in it, the entries of [`OWNED`] belong to `mpcgear`. A run replaces
//! exactly those, all together, and leaves everything else where it is. A folder that already has
//! one of these names but no `design.json` is not ours and is refused.

use std::fs;
use std::io::{Error as IoError, ErrorKind};
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::File;
use crate::{Error, Result};

/// Top-level entries of an output folder that a run replaces.
pub const OWNED: [&str; 9] = [
    "design.json",
    "summary.json",
    "poses.csv",
    "meshes",
    "print",
    "openscad",
    "freecad",
    "report.html",
    "parts.md",
];

const PREFIX: &str = ".mpcgear-";

/// Checks that an output folder can be written, before any long work: it is a folder (or can
/// become one), takes new files, and is either ours or has no entry of ours.
///
/// # Errors
/// [`Error::Io`] with the path and what is wrong with it.
pub fn check_writable(folder: &Path) -> Result<()> {
    refuse_foreign(folder)?;
    staging(folder).map(|_| ())
}

/// Writes `files` into `folder`, replacing what an earlier run wrote there. On an error the folder
/// is as it was before.
///
/// # Errors
/// [`Error::Io`] when something cannot be written.
pub fn publish(folder: &Path, files: &[File]) -> Result<()> {
    refuse_foreign(folder)?;
    let stage = staging(folder)?;
    let new = stage.path().join("new");
    for file in files {
        let path = new.join(&file.path);
        let parent = path.parent().unwrap_or(&new);
        fs::create_dir_all(parent).map_err(Error::io(folder))?;
        fs::write(&path, &file.bytes).map_err(Error::io(folder.join(&file.path)))?;
    }
    if folder.is_dir() {
        swap(folder, &new, &stage.path().join("old"))
    } else {
        if let Some(parent) = folder.parent() {
            fs::create_dir_all(parent).map_err(Error::io(parent))?;
        }
        fs::rename(&new, folder).map_err(Error::io(folder))
    }
}

/// Exchanges the owned entries of `folder` for those of `new`, keeping the replaced ones in `old`
/// until all is done; puts them back when a step fails.
fn swap(folder: &Path, new: &Path, old: &Path) -> Result<()> {
    fs::create_dir_all(old).map_err(Error::io(folder))?;
    let mut done: Vec<(PathBuf, PathBuf)> = Vec::new();
    let mut step = |from: PathBuf, to: PathBuf| {
        if from.exists() {
            fs::rename(&from, &to).map_err(Error::io(&to))?;
            done.push((from, to));
        }
        Ok(())
    };
    let out = OWNED.iter().map(|name| (folder.join(name), old.join(name)));
    let into = OWNED.iter().map(|name| (new.join(name), folder.join(name)));
    let result = out.chain(into).try_for_each(|(from, to)| step(from, to));
    if result.is_err() {
        for (from, to) in done.iter().rev() {
            // Nothing better can be done if this fails too: the first error is reported.
            let _ = fs::rename(to, from);
        }
    }
    result
}

/// A temporary folder on the same file system as `folder`: inside it if it exists (it may be a
/// mount point), else in its nearest ancestor that exists.
fn staging(folder: &Path) -> Result<TempDir> {
    let absolute = std::path::absolute(folder).map_err(Error::io(folder))?;
    let place = absolute
        .ancestors()
        .find(|path| path.symlink_metadata().is_ok())
        .unwrap_or(&absolute);
    if !place.is_dir() {
        let what = format!("{} is not a folder", place.display());
        return Err(Error::io(folder)(IoError::new(
            ErrorKind::NotADirectory,
            what,
        )));
    }
    let made = tempfile::Builder::new().prefix(PREFIX).tempdir_in(place);
    made.map_err(|error| {
        // Without the name of the temporary folder, which means nothing to the user.
        let cause = std::error::Error::source(&error).map_or(error.to_string(), |e| e.to_string());
        let what = format!("nothing can be written in {}: {cause}", place.display());
        Error::io(folder)(IoError::new(error.kind(), what))
    })
}

fn refuse_foreign(folder: &Path) -> Result<()> {
    if folder.join("design.json").exists() {
        return Ok(());
    }
    match OWNED.iter().find(|name| folder.join(name).exists()) {
        None => Ok(()),
        Some(name) => {
            let what = format!(
                "has `{name}` but no design.json, so it is not an output folder; choose another"
            );
            Err(Error::io(folder)(IoError::new(
                ErrorKind::AlreadyExists,
                what,
            )))
        }
    }
}
