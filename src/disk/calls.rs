//! The calls that change the disk, all in one place: the tests let the program die before any of them.

use std::fs;
use std::io::{Result, Write};
use std::path::Path;

/// Creates a folder.
pub fn make_dir(path: &Path) -> Result<()> {
    step()?;
    fs::create_dir(path)
}

/// Creates a folder with those above it that are missing.
pub fn make_dirs(path: &Path) -> Result<()> {
    match path.parent() {
        _ if path.is_dir() => return Ok(()),
        Some(parent) if !parent.as_os_str().is_empty() => make_dirs(parent)?,
        _ => {}
    }
    make_dir(path)
}

/// Writes a file that is not there yet.
pub fn write_new(path: &Path, bytes: &[u8]) -> Result<()> {
    step()?;
    let mut file = fs::OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(path)?;
    step()?;
    file.write_all(bytes)
}

/// Gives what is at `from` the name `to`.
pub fn rename(from: &Path, to: &Path) -> Result<()> {
    step()?;
    fs::rename(from, to)
}

/// Exchanges what is at `a` for what is at `b` in one step, where the system can.
#[cfg(target_os = "linux")]
pub fn exchange(a: &Path, b: &Path) -> Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    step()?;
    Ok(renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE)?)
}

/// No system call for this here.
#[cfg(not(target_os = "linux"))]
pub fn exchange(_: &Path, _: &Path) -> Result<()> {
    Err(std::io::ErrorKind::Unsupported.into())
}

/// Gives the file at `from` a second name; a copy where the file system knows no such thing.
pub fn link(from: &Path, to: &Path) -> Result<()> {
    step()?;
    fs::hard_link(from, to).or_else(|_| fs::copy(from, to).map(|_| ()))
}

/// Removes a file.
pub fn remove_file(path: &Path) -> Result<()> {
    step()?;
    fs::remove_file(path)
}

/// Removes an empty folder.
pub fn remove_empty(path: &Path) -> Result<()> {
    step()?;
    fs::remove_dir(path)
}

/// Removes a folder with all that is in it; links in it are not followed.
pub fn remove_tree(path: &Path) -> Result<()> {
    step()?;
    fs::remove_dir_all(path)
}

#[cfg(not(test))]
fn step() -> Result<()> {
    Ok(())
}

#[cfg(test)]
thread_local! {
    /// Calls that are left before the program is dead for the disk; `None` for ever.
    pub static LEFT: std::cell::Cell<Option<usize>> = const { std::cell::Cell::new(None) };
}

#[cfg(test)]
fn step() -> Result<()> {
    match LEFT.get() {
        Some(0) => Err(std::io::Error::other("killed")),
        left => {
            LEFT.set(left.map(|n| n - 1));
            Ok(())
        }
    }
}
