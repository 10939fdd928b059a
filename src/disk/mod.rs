//! Files and folders that appear whole or not at all, whatever stops the program in between.
//!
//! [`Folder`] is an output folder, claimed by one process at a time; [`write_whole`] is for single files.
//! How a folder changes from one design to the next is told in [`folder`].

mod calls;
pub mod folder;
mod journal;
mod lock;
mod stage;

pub use folder::{Folder, OWNED};

use std::io::{Error as IoError, ErrorKind, Write};
use std::path::Path;

use crate::{Error, Result};

/// Writes a file whole or not at all: under a name of its own beside `path` first, which then takes
/// the place of what is there. A link at `path` is replaced, not followed.
///
/// # Errors
/// [`Error::Io`] when `path` is neither free nor a regular file, or cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let taken = path.symlink_metadata().is_ok() && !path.is_file();
    if taken {
        let what = "is not a regular file; choose another name";
        return Err(Error::io(path)(IoError::new(
            ErrorKind::AlreadyExists,
            what,
        )));
    }
    let written = new_file()
        .tempfile_in(folder_of(path))
        .and_then(|mut file| {
            file.write_all(bytes)?;
            file.persist(path).map_err(|e| e.error)
        });
    written.map(|_| ()).map_err(|e| Error::io(path)(plain(e)))
}

/// The folder that a file is in; `.` for a bare name.
pub fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A temporary file that anybody may read once it has its place, as any other file.
fn new_file() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(stage::PREFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder
}

/// An error without the name of the temporary file, which means nothing to the user.
fn plain(error: IoError) -> IoError {
    let cause = std::error::Error::source(&error).map(ToString::to_string);
    match error.get_ref().and(cause) {
        Some(cause) => IoError::new(error.kind(), cause),
        None => error,
    }
}
