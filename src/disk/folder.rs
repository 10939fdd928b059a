//! Output folders: one design or the other, never something in between.
//!
//! A folder belongs to the user; in it, the entries of [`OWNED`] belong to `mpcgear`. A run replaces
//! exactly those and leaves everything else. A folder that already has one of these names but no
//! `design.json` is not ours and is refused.
//!
//! The new design is made ready in a hidden folder beside the target, which gets the user's own
//! entries too (as second names of the same files). Then both folders are exchanged in one step, and
//! what was there before is removed. A kill leaves the old design or the new one, whole, and a hidden
//! folder that the next run clears away.
//!
//! Where the two cannot be exchanged (other systems than Linux, some network disks, a mount point, a
//! folder that the shell stands in, a parent that takes no files) the entries are replaced one by one
//! after a list of them was written, which the next run finishes if a kill came between. `design.json`
//! is then replaced in one step and never missing.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::{Error as IoError, ErrorKind};
use std::path::{Path, PathBuf};

use super::calls;
use super::journal::Changes;
use super::lock::Lock;
use super::stage::{PREFIX, Stage};
use crate::export::File;
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

/// A folder that this process alone writes into, until it is dropped.
#[derive(Debug)]
pub struct Folder {
    /// As the user calls it.
    path: PathBuf,
    /// As it is, without links.
    real: PathBuf,
    /// Name under which its stages are found.
    name: String,
    /// Folders above it that were made for it; gone again when nothing was written.
    made: Vec<PathBuf>,
    /// Whether it can be exchanged as a whole.
    exchange: bool,
    /// Goes before the folders it stands in.
    lock: Option<Lock>,
}

impl Folder {
    /// Takes a folder for writing, before any long work: it is a folder or can become one, takes new
    /// files, and nobody else is writing there. What a kill left in it is finished or cleared away.
    ///
    /// # Errors
    /// [`Error::Io`] with the path and what is wrong with it.
    pub fn open(path: &Path) -> Result<Folder> {
        let (real, made) = locate(path).map_err(Error::io(path))?;
        let name = match real.file_name() {
            Some(name) => name.to_string_lossy().into_owned(),
            None => "root".into(),
        };
        let lock = lock(&real, &name);
        let lock = lock.inspect_err(|_| undo(&made)).map_err(Error::io(path))?;
        let folder = Folder {
            path: path.to_path_buf(),
            exchange: is_exchangeable(&real, &name),
            real,
            name,
            made,
            lock: Some(lock),
        };
        folder.recover().map_err(Error::io(path))?;
        if !folder.exchange {
            // That it can be exchanged was tried with a stage.
            folder.stage(false)?;
        }
        Ok(folder)
    }

    /// [`Folder::open`] for the folder of a design: it also has to be ours, or without any entry of
    /// ours.
    ///
    /// # Errors
    /// [`Error::Io`] with the path and what is wrong with it.
    pub fn claim(path: &Path) -> Result<Folder> {
        let folder = Folder::open(path)?;
        let has = |name: &&str| folder.real.join(name).exists();
        if !has(&"design.json")
            && let Some(name) = OWNED.iter().find(|name| has(name))
        {
            let what = format!(
                "has `{name}` but no design.json, so it is not an output folder; choose another"
            );
            return Err(Error::io(path)(IoError::new(
                ErrorKind::AlreadyExists,
                what,
            )));
        }
        Ok(folder)
    }

    /// The folder as the user calls it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether there is a design in it.
    pub fn has_design(&self) -> bool {
        self.real.join("design.json").exists()
    }

    /// Replaces what an earlier run wrote by `files`. On an error the folder is as it was before.
    ///
    /// # Errors
    /// [`Error::Io`] when something cannot be written.
    pub fn publish(&self, files: &[File]) -> Result<()> {
        self.publish_by(files, self.exchange)
    }

    fn publish_by(&self, files: &[File], exchange: bool) -> Result<()> {
        let stage = self.stage(exchange)?;
        self.fill(&stage, files)?;
        let io = Error::io(&self.path);
        let new = stage.new_contents();
        if !self.real.exists() {
            return calls::rename(&new, &self.real).map_err(io);
        }
        if exchange && self.exchange(&new).map_err(Error::io(&self.path))? {
            return self.rescue(stage).map_err(io);
        }
        let (put, remove): (Vec<PathBuf>, Vec<PathBuf>) = OWNED
            .iter()
            .map(PathBuf::from)
            .partition(|name| new.join(name).exists());
        let changes = Changes { put, remove };
        changes.commit(&self.real, stage).map_err(io)
    }

    /// Writes `files` among what is there, all of them or none.
    ///
    /// # Errors
    /// [`Error::Io`] when something cannot be written.
    pub fn add(&self, files: &[File]) -> Result<()> {
        let stage = self.stage(false)?;
        self.fill(&stage, files)?;
        let io = Error::io(&self.path);
        if !self.real.exists() {
            return calls::rename(&stage.new_contents(), &self.real).map_err(io);
        }
        let changes = Changes {
            put: files.iter().map(|file| file.path.clone()).collect(),
            remove: Vec::new(),
        };
        changes.commit(&self.real, stage).map_err(io)
    }

    fn fill(&self, stage: &Stage, files: &[File]) -> Result<()> {
        let new = stage.new_contents();
        for file in files {
            let path = new.join(&file.path);
            let made = calls::make_dirs(path.parent().unwrap_or(&new));
            made.and_then(|()| calls::write_new(&path, &file.bytes))
                .map_err(Error::io(self.path.join(&file.path)))?;
        }
        Ok(())
    }

    /// Exchanges the folder for `new`; false where the file system cannot.
    fn exchange(&self, new: &Path) -> std::io::Result<bool> {
        for own in users(&self.real)? {
            link_tree(&self.real.join(&own), &new.join(&own))?;
        }
        fs::set_permissions(new, fs::metadata(&self.real)?.permissions())?;
        match calls::exchange(new, &self.real) {
            Ok(()) => Ok(true),
            Err(error) if cannot(&error) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Moves the user's entries that are in a stage only to the folder: what was put there while it
    /// was exchanged. A stage that cannot be emptied stays.
    fn rescue(&self, stage: Stage) -> std::io::Result<()> {
        let new = stage.new_contents();
        if !new.is_dir() || !self.real.is_dir() {
            return Ok(());
        }
        let moved = users(&new).and_then(|names| {
            let mut names = names.iter();
            names.try_for_each(|name| merge(&new.join(name), &self.real.join(name)))
        });
        moved.map_err(|error| stage.leave(&error))
    }

    /// A hidden folder on the target's file system: beside it to be exchanged for it, else within it.
    fn stage(&self, exchange: bool) -> Result<Stage> {
        let inside = self.real.exists() && !exchange;
        let place = match self.real.parent() {
            Some(parent) if !inside => parent,
            _ => &self.real,
        };
        Stage::new(place, &self.name).map_err(|error| {
            let what = nothing_in(place, &error);
            Error::io(&self.path)(IoError::new(error.kind(), what))
        })
    }

    /// Finishes or clears away what killed runs left of their stages.
    fn recover(&self) -> std::io::Result<()> {
        let parent = self.real.parent().unwrap_or(&self.real);
        let inside = Stage::left(&self.real, &self.name).into_iter();
        let beside = Stage::left(parent, &self.name).into_iter();
        let inside = inside.map(|stage| Changes::resume(&self.real, stage));
        // All are tried, whatever one of them says: an untried stage would be cleared away.
        let tried: Vec<_> = inside
            .chain(beside.map(|stage| self.rescue(stage)))
            .collect();
        tried.into_iter().collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        self.lock = None;
        undo(&self.made);
    }
}

/// Whether a new folder beside `real` could take its place in one step.
fn is_exchangeable(real: &Path, name: &str) -> bool {
    let here = std::env::current_dir().and_then(fs::canonicalize);
    let stands_in_it = here.is_ok_and(|here| here.starts_with(real));
    cfg!(target_os = "linux")
        && !stands_in_it
        && real
            .parent()
            .is_some_and(|parent| same_disk(parent, real) && Stage::new(parent, name).is_ok())
}

/// Removes folders that are still empty, the deepest first.
fn undo(made: &[PathBuf]) {
    for path in made.iter().rev() {
        // Not empty: it is needed.
        let _ = calls::remove_empty(path);
    }
}

/// Where `path` leads, and the folders above it that had to be made.
fn locate(path: &Path) -> std::io::Result<(PathBuf, Vec<PathBuf>)> {
    if path.symlink_metadata().is_ok() {
        if !path.is_dir() {
            return Err(no_folder(path));
        }
        return Ok((fs::canonicalize(path)?, Vec::new()));
    }
    let absolute = std::path::absolute(path)?;
    let Some((parent, name)) = absolute.parent().zip(absolute.file_name()) else {
        return Err(ErrorKind::InvalidInput.into());
    };
    let mut missing: Vec<PathBuf> = parent
        .ancestors()
        .take_while(|p| p.symlink_metadata().is_err())
        .map(Path::to_path_buf)
        .collect();
    missing.reverse();
    let above = absolute.ancestors().find(|p| p.symlink_metadata().is_ok());
    if let Some(above) = above
        && !above.is_dir()
    {
        return Err(no_folder(above));
    }
    let mut made = Vec::new();
    for folder in missing {
        match calls::make_dir(&folder) {
            Ok(()) => made.push(folder),
            // Another process was faster; it is not for this one to remove.
            Err(error) if error.kind() == ErrorKind::AlreadyExists && folder.is_dir() => {}
            Err(error) => {
                undo(&made);
                return Err(error);
            }
        }
    }
    Ok((fs::canonicalize(parent)?.join(name), made))
}

fn no_folder(path: &Path) -> IoError {
    let what = format!("{} is not a folder", path.display());
    IoError::new(ErrorKind::NotADirectory, what)
}

/// The lock of a folder, beside it; within it where the parent takes no files.
fn lock(real: &Path, name: &str) -> std::io::Result<Lock> {
    let file = format!("{PREFIX}{name}.lock");
    let take = |place: &Path| {
        Lock::take(place.join(&file)).map_err(|error| match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::AlreadyExists => error,
            kind => IoError::new(kind, nothing_in(place, &error)),
        })
    };
    match real.parent().map(take) {
        Some(Err(error)) if error.kind() != ErrorKind::WouldBlock && real.is_dir() => take(real),
        Some(taken) => taken,
        None => take(real),
    }
}

fn nothing_in(place: &Path, error: &IoError) -> String {
    format!("nothing can be written in {}: {error}", place.display())
}

/// Names of the entries that are the user's.
fn users(folder: &Path) -> std::io::Result<Vec<OsString>> {
    let ours = |name: &OsStr| {
        let name = name.to_str();
        name.is_some_and(|n| OWNED.contains(&n) || n.starts_with(PREFIX))
    };
    let mut users = Vec::new();
    for entry in fs::read_dir(folder)? {
        users.push(entry?.file_name());
    }
    users.retain(|name| !ours(name));
    users.sort();
    Ok(users)
}

/// The same files under `to` as under `from`; what is neither file, folder nor link is left to
/// [`Folder::rescue`].
fn link_tree(from: &Path, to: &Path) -> std::io::Result<()> {
    let kind = from.symlink_metadata()?.file_type();
    if kind.is_dir() {
        calls::make_dir(to)?;
        for entry in fs::read_dir(from)? {
            let name = entry?.file_name();
            link_tree(&from.join(&name), &to.join(&name))?;
        }
        fs::set_permissions(to, fs::metadata(from)?.permissions())
    } else if kind.is_file() || kind.is_symlink() {
        calls::link(from, to)
    } else {
        Ok(())
    }
}

/// Moves what is missing at `to` there, however deep.
fn merge(from: &Path, to: &Path) -> std::io::Result<()> {
    let is_dir = |path: &Path| path.symlink_metadata().is_ok_and(|m| m.is_dir());
    if to.symlink_metadata().is_err() {
        return calls::rename(from, to);
    }
    if is_dir(from) && is_dir(to) {
        for entry in fs::read_dir(from)? {
            let name = entry?.file_name();
            merge(&from.join(&name), &to.join(&name))?;
        }
    }
    Ok(())
}

/// Whether an exchange is beyond the file system, rather than wrong.
fn cannot(error: &IoError) -> bool {
    matches!(
        error.kind(),
        ErrorKind::Unsupported
            | ErrorKind::InvalidInput
            | ErrorKind::CrossesDevices
            | ErrorKind::ResourceBusy
            | ErrorKind::PermissionDenied
    )
}

#[cfg(unix)]
fn same_disk(parent: &Path, folder: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let disk = |path: &Path| path.metadata().map(|m| m.dev()).ok();
    !folder.exists() || disk(parent) == disk(folder)
}

#[cfg(not(unix))]
fn same_disk(_: &Path, _: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use std::thread;

    /// A design whose files say which one it is.
    fn design(mark: &str) -> Vec<File> {
        let more = if mark == "old" {
            "print/a.stl"
        } else {
            "parts.md"
        };
        ["design.json", "summary.json", "meshes/driver.stl", more]
            .map(|name| File::new(name, mark))
            .to_vec()
    }

    /// Contents of all files below `folder` that are not ours to hide, by path.
    fn tree(folder: &Path) -> BTreeMap<PathBuf, String> {
        let mut files = BTreeMap::new();
        let mut open = vec![folder.to_path_buf()];
        while let Some(here) = open.pop() {
            for entry in fs::read_dir(here).expect("a folder") {
                let path = entry.expect("an entry").path();
                let hidden = path.file_name().and_then(OsStr::to_str);
                if hidden.is_some_and(|name| name.starts_with(PREFIX)) {
                    continue;
                }
                if path.is_dir() {
                    open.push(path);
                } else {
                    let below = path.strip_prefix(folder).expect("below").to_path_buf();
                    files.insert(below, fs::read_to_string(&path).expect("text"));
                }
            }
        }
        files
    }

    fn expected(mark: &str) -> BTreeMap<PathBuf, String> {
        let own = [("notes.txt", "mine"), ("cad/arm.scad", "arm")];
        let own = own.map(|(path, text)| (PathBuf::from(path), text.to_string()));
        let design = design(mark);
        let text = |f: &File| String::from_utf8(f.bytes.clone()).expect("text");
        own.into_iter()
            .chain(design.iter().map(|f| (f.path.clone(), text(f))))
            .collect()
    }

    fn publish(out: &Path, mark: &str) {
        let folder = Folder::claim(out).expect("claimed");
        folder.publish(&design(mark)).expect("published");
    }

    /// Publishes over an old design with the user's files beside it, killed before every call in turn.
    /// Returns how many there are.
    fn killed_everywhere(exchange: bool, after_kill: impl Fn(&Path)) -> usize {
        for calls_left in 0.. {
            let place = tempfile::tempdir().expect("a folder");
            let out = place.path().join("out");
            publish(&out, "old");
            fs::write(out.join("notes.txt"), "mine").expect("written");
            fs::create_dir(out.join("cad")).expect("made");
            fs::write(out.join("cad/arm.scad"), "arm").expect("written");

            calls::LEFT.set(Some(calls_left));
            let killed = Folder::claim(&out).is_ok_and(|folder| {
                folder
                    .publish_by(&design("new"), exchange && folder.exchange)
                    .is_ok()
            });
            let through = calls::LEFT.replace(None) != Some(0);

            after_kill(&out);
            let next = Folder::claim(&out).expect("claimed after the kill");
            let found = tree(&out);
            let whole = ["old", "new"].into_iter().find(|m| found == expected(m));
            assert!(whole.is_some(), "after {calls_left} calls: {found:?}");
            next.publish(&design("next")).expect("published again");
            drop(next);
            assert_eq!(tree(&out), expected("next"));
            let beside: Vec<_> = fs::read_dir(place.path()).expect("a folder").collect();
            assert_eq!(beside.len(), 1, "after {calls_left} calls: {beside:?}");
            let hidden = fs::read_dir(&out).expect("a folder").flatten();
            let hidden = hidden.filter(|e| e.file_name().to_string_lossy().starts_with(PREFIX));
            assert_eq!(hidden.count(), 0);
            if killed && through {
                return calls_left;
            }
        }
        unreachable!("counting up")
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn folders_above_may_be_made_by_several_at_once() {
        let place = tempfile::tempdir().expect("a folder");
        for round in 0..50 {
            let above = place.path().join(format!("{round}/a/b"));
            let both = thread::scope(|s| {
                let one = s.spawn(|| Folder::open(&above.join("one")));
                let two = Folder::open(&above.join("two"));
                (one.join().expect("no panic"), two)
            });
            assert!(both.0.is_ok() && both.1.is_ok(), "{both:?}");
            drop(both);
            Folder::open(&above.join("three")).expect("free");
        }
    }

    #[test]
    fn a_kill_anywhere_leaves_one_design_or_the_other() {
        let kills = killed_everywhere(true, |out| {
            let found = tree(out);
            let whole = ["old", "new"].into_iter().any(|m| found == expected(m));
            assert!(whole, "{found:?}");
        });
        assert!(kills > 15, "{kills} kills");
    }

    #[test]
    fn where_folders_cannot_be_exchanged_the_next_run_finishes_what_a_kill_left() {
        let kills = killed_everywhere(false, |out| {
            assert!(out.join("design.json").exists());
            assert_eq!(fs::read(out.join("notes.txt")).expect("kept"), b"mine");
        });
        assert!(kills > 25, "{kills} kills");
    }

    #[test]
    fn what_killed_runs_left_is_put_back_and_never_cleared_away_unread() {
        let place = tempfile::tempdir().expect("a folder");
        let out = place.path().join("out");
        publish(&out, "old");
        let left = |place: &Path, id: &str| {
            let stage = place.join(format!("{PREFIX}out-{id}"));
            fs::create_dir_all(stage.join("new/notes")).expect("made");
            fs::write(stage.join("new/notes/late.txt"), "late").expect("written");
            stage
        };
        // A list that nobody can read, and what the user put there during an exchange.
        let unreadable = left(&out, "aaaaaaaaaaaa");
        fs::write(unreadable.join("changes.json"), "{").expect("written");
        let exchanged = left(place.path(), "bbbbbbbbbbbb");
        let error = Folder::claim(&out).expect_err("unfinished").to_string();
        assert!(error.contains("aaaaaaaaaaaa"), "{error}");
        assert!(unreadable.join("new/notes/late.txt").exists());
        assert!(!exchanged.exists(), "the other one is done");
        let late = fs::read_to_string(out.join("notes/late.txt"));
        assert_eq!(late.expect("put back"), "late");
        fs::remove_dir_all(unreadable).expect("removed by hand");
        Folder::claim(&out).expect("free");
    }

    #[test]
    fn a_folder_has_one_writer() {
        let place = tempfile::tempdir().expect("a folder");
        let out = place.path().join("a/out");
        let first = Folder::claim(&out).expect("free");
        let error = Folder::claim(&out).expect_err("taken").to_string();
        assert!(
            error.contains("another mpcgear is writing there"),
            "{error}"
        );
        drop(first);
        assert_eq!(tree(place.path()).len(), 0);
        assert!(!place.path().join("a").exists(), "nothing was written");
        Folder::claim(&out).expect("free again");
    }

    #[test]
    fn files_are_added_all_or_none() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = Folder::open(place.path()).expect("free");
        fs::write(place.path().join("b.stl"), "old").expect("written");
        let files = |names: &[&str]| -> Vec<File> {
            names.iter().map(|name| File::new(*name, "new")).collect()
        };
        // `b.stl` is no folder: the third file cannot be.
        folder
            .add(&files(&["a.stl", "c/d.stl", "b.stl/e.stl"]))
            .expect_err("in the way");
        let found = tree(place.path());
        assert_eq!(
            found.into_iter().collect::<Vec<_>>(),
            [("b.stl".into(), "old".into())]
        );
        folder
            .add(&files(&["a.stl", "b.stl", "c/d.stl"]))
            .expect("written");
        assert!(tree(place.path()).values().all(|text| text == "new"));
    }
}
