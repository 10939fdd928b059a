//! What shells and `man` know of the command line, made from its definition.

use std::path::Path;

use clap::CommandFactory;
use clap_complete::Shell;
use mpcgear::{Error, Result};

use crate::cli::Cli;

/// Prints the completions of a shell.
///
/// # Errors
/// [`Error::Io`] when standard output cannot be written.
pub fn completions(shell: Shell) -> Result<u8> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "mpcgear", &mut script);
    // Not through the terminal's filter: what a shell reads stays as it is.
    super::write_out(&script)?;
    Ok(0)
}

/// Writes a man page for the program and each of its commands into `folder`.
///
/// # Errors
/// [`Error::Io`] when there is no such folder or it cannot be written.
pub fn pages(cli: &Cli, folder: &Path) -> Result<u8> {
    clap_mangen::generate_to(Cli::command(), folder).map_err(Error::io(folder))?;
    super::say(
        cli,
        &format!("written; next: man {}", folder.join("mpcgear.1").display()),
    )
}
