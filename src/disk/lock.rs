//! One writer a folder: a lock file that the system lets go of when its process ends, however it ends.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};

use super::calls;

/// A lock that is held until it is dropped.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    /// Holds the system's lock, where there are such.
    _file: File,
}

/// What a file system without locks (some network disks) answers with.
type TryLock = fn(&File) -> std::result::Result<(), TryLockError>;

impl Lock {
    /// Takes the lock at `path`. Where the file system knows no locks, the file itself is the lock; it
    /// then has to be removed by hand after a crash, as the message says.
    ///
    /// # Errors
    /// [`ErrorKind::WouldBlock`] when somebody else has it; others when the file cannot be made.
    pub fn take(path: PathBuf) -> Result<Lock> {
        Lock::take_by(path, File::try_lock)
    }

    fn take_by(path: PathBuf, try_lock: TryLock) -> Result<Lock> {
        for _ in 0..TRIES {
            let (file, new) = open(&path)?;
            match try_lock(&file) {
                // The one before us removes its file when it is done: then this is nobody's name.
                Ok(()) if !is_at(&file, &path) => continue,
                Ok(()) => return Ok(Lock { path, _file: file }),
                Err(TryLockError::WouldBlock) => break,
                Err(TryLockError::Error(_)) if new => return Ok(Lock { path, _file: file }),
                Err(TryLockError::Error(_)) => {
                    let what = format!(
                        "another mpcgear is writing there; if none is running, remove {}",
                        path.display()
                    );
                    return Err(Error::new(ErrorKind::WouldBlock, what));
                }
            }
        }
        let what = "another mpcgear is writing there; wait for it or choose another folder";
        Err(Error::new(ErrorKind::WouldBlock, what))
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // A file that stays is no lock: the next process takes it over.
        let _ = calls::remove_file(&self.path);
    }
}

/// Tries to lock a file that is still in its place.
const TRIES: usize = 100;

/// Opens the lock file and tells whether it is new.
fn open(path: &Path) -> Result<(File, bool)> {
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    match options.clone().create_new(true).open(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
        other => return other.map(|file| (file, true)),
    }
    // Links are not followed: nothing outside the folder is touched.
    if path.symlink_metadata().is_ok_and(|m| !m.is_file()) {
        let what = format!("{} is in the way: not a lock file", path.display());
        return Err(Error::new(ErrorKind::AlreadyExists, what));
    }
    match options.open(path) {
        // Just removed by its owner.
        Err(error) if error.kind() == ErrorKind::NotFound => open(path),
        other => other.map(|file| (file, false)),
    }
}

/// Whether `file` is what stands at `path` now.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), path.symlink_metadata()) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

/// Open files keep their names here.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_has_one_owner_and_goes_with_it() {
        let place = tempfile::tempdir().expect("a folder");
        let path = place.path().join("lock");
        let first = Lock::take(path.clone()).expect("free");
        let error = Lock::take(path.clone()).expect_err("taken");
        assert_eq!(error.kind(), ErrorKind::WouldBlock);
        drop(first);
        assert!(!path.exists());
        // What a killed process leaves is taken over.
        std::fs::write(&path, "").expect("written");
        Lock::take(path).expect("nobody holds it");
    }

    #[test]
    fn where_locks_fail_the_file_is_the_lock() {
        let no_locks = |_: &File| Err(TryLockError::Error(ErrorKind::Unsupported.into()));
        let place = tempfile::tempdir().expect("a folder");
        let path = place.path().join("lock");
        let first = Lock::take_by(path.clone(), no_locks).expect("free");
        let error = Lock::take_by(path.clone(), no_locks).expect_err("taken");
        assert!(error.to_string().contains("if none is running, remove"));
        drop(first);
        Lock::take_by(path, no_locks).expect("free again");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_in_the_place_of_a_lock_is_not_followed() {
        let place = tempfile::tempdir().expect("a folder");
        let (path, victim) = (place.path().join("lock"), place.path().join("victim"));
        std::os::unix::fs::symlink(&victim, &path).expect("linked");
        Lock::take(path).expect_err("a link");
        assert!(!victim.exists());
    }
}
