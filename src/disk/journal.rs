//! Replacing single entries of a folder, all of them or none: a list of what is to be done is written
//! first. After an error it is undone, after a kill the next run goes on with it.

use std::io::{Error, ErrorKind, Result};
use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::calls;
use super::stage::Stage;

/// Entries of a folder that change, as paths below it.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Changes {
    /// Files and folders of the stage that take the place of what is there.
    pub put: Vec<PathBuf>,
    /// What goes.
    pub remove: Vec<PathBuf>,
}

/// Name of the list within the stage, and of what makes room there.
const LIST: &str = "changes.json";
const OLD: &str = "old";

impl Changes {
    /// Carries the changes out in `folder` with what is ready in `stage`, or none of them. A stage that
    /// still holds something of the folder stays.
    pub fn commit(&self, folder: &Path, stage: Stage) -> Result<()> {
        let list = serde_json::to_vec(self)?;
        let (draft, list_path) = (stage.path().join("draft"), stage.path().join(LIST));
        calls::write_new(&draft, &list)?;
        calls::rename(&draft, &list_path)?;
        let mut done = Vec::new();
        let result = self.carry_out(folder, &stage, &mut done);
        result.map_err(|error| {
            let mut undo = done.iter().rev();
            let undone = undo
                .try_for_each(|(there, back)| calls::rename(there, back))
                .and_then(|()| calls::remove_file(&list_path));
            match undone {
                Ok(()) => error,
                // The next run finishes what could neither be done nor undone.
                Err(_) => stage.leave(&error),
            }
        })
    }

    /// Goes on with changes that a kill interrupted; nothing if they were never decided on. A stage
    /// that cannot be finished stays.
    pub fn resume(folder: &Path, stage: Stage) -> Result<()> {
        let list = match std::fs::read(stage.path().join(LIST)) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
            list => list,
        };
        let finished = list
            .and_then(|list| Ok(serde_json::from_slice::<Changes>(&list)?))
            .and_then(|changes| changes.carry_out(folder, &stage, &mut Vec::new()));
        finished.map_err(|error| stage.leave(&error))
    }

    /// Notes in `done` the renames that undo what was done, last first.
    fn carry_out(
        &self,
        folder: &Path,
        stage: &Stage,
        done: &mut Vec<(PathBuf, PathBuf)>,
    ) -> Result<()> {
        let old = stage.path().join(OLD);
        let (remove, put) = (self.remove.iter(), self.put.iter());
        for (path, new) in remove.map(|p| (p, None)).chain(put.map(|p| {
            let new = stage.new_contents().join(p);
            (p, Some(new))
        })) {
            below(folder, path)?;
            let (there, kept) = (folder.join(path), old.join(path));
            if new.as_ref().is_some_and(|new| !is_there(new)) {
                // Done before the kill.
                continue;
            }
            calls::make_dirs(kept.parent().unwrap_or(&old))?;
            if is_there(&there) && !is_there(&kept) {
                if new.as_ref().is_some_and(|new| new.is_file()) && is_file(&there) {
                    // A file takes the place of a file in one step: it is never missing.
                    calls::link(&there, &kept)?;
                } else {
                    calls::rename(&there, &kept)?;
                }
                done.push((kept, there.clone()));
            }
            if let Some(new) = new {
                calls::make_dirs(there.parent().unwrap_or(folder))?;
                calls::rename(&new, &there)?;
                done.push((there, new));
            }
        }
        Ok(())
    }
}

fn is_there(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

fn is_file(path: &Path) -> bool {
    path.symlink_metadata().is_ok_and(|m| m.is_file())
}

/// Refuses a path that leads out of `folder`, by its own steps or by a link on its way.
fn below(folder: &Path, path: &Path) -> Result<()> {
    let refuse = |what: String| Err(Error::new(ErrorKind::InvalidInput, what));
    let plain = path.components().all(|c| matches!(c, Component::Normal(_)));
    if !plain || path.as_os_str().is_empty() {
        return refuse(format!("{} leads out of the folder", path.display()));
    }
    let mut way = folder.to_path_buf();
    for step in path.parent().unwrap_or(Path::new("")) {
        way.push(step);
        if way.symlink_metadata().is_ok_and(|m| !m.is_dir()) {
            return refuse(format!("{} is not a folder", way.display()));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_that_lead_out_are_refused() {
        let place = tempfile::tempdir().expect("a folder");
        for path in ["../victim", "/etc/passwd", "", "a/../../b", "."] {
            below(place.path(), Path::new(path)).expect_err(path);
        }
        below(place.path(), Path::new("meshes/driver.stl")).expect("below");
    }

    #[cfg(unix)]
    #[test]
    fn links_are_not_followed() {
        let place = tempfile::tempdir().expect("a folder");
        let elsewhere = tempfile::tempdir().expect("a folder");
        std::os::unix::fs::symlink(elsewhere.path(), place.path().join("meshes")).expect("linked");
        below(place.path(), Path::new("meshes/driver.stl")).expect_err("a link");
    }
}
