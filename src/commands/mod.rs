//! What each command does, from arguments to exit code.

mod check;
mod design;
mod explore;
mod inspect;
mod manual;
mod motions;
mod render;
mod report;
mod size;
mod trial;

use std::io::Write;
use std::path::Path;

use mpcgear::export::figures::Figure;
use mpcgear::{Error, Result, motion};

use crate::cli::{Cli, Command, Standard};

/// Runs the command and returns the exit code.
///
/// # Errors
/// Whatever the command fails of.
pub fn run(cli: &Cli) -> Result<u8> {
    match &cli.command {
        Command::Design(args) => design::run(cli, args),
        Command::New {
            class,
            example,
            file,
        } => {
            let example = example.as_deref().and_then(motion::examples::example);
            let starter = || class.map(motion::starter);
            let text = example.map(String::from).or_else(starter);
            create(file, &text.unwrap_or_default())?;
            say(
                cli,
                &format!(
                    "{} written; next: mpcgear design {0} -o out",
                    file.display()
                ),
            )
        }
        Command::Export(args) => render::export(cli, args),
        Command::Explore(args) => explore::run(cli, args),
        Command::Trial(args) => trial::run(cli, args),
        Command::Report { folder, png } => report::run(cli, folder, png.as_deref()),
        Command::Check(args) => check::run(cli, args),
        Command::Load {
            design,
            payload,
            csv,
            tolerances,
            seed,
        } => match tolerances {
            Some(draws) => inspect::tolerances(cli, design, (*payload, *draws, *seed)),
            None => inspect::load(cli, design, (*payload, *csv)),
        },
        Command::Compare { designs, out, with } => {
            let out = out.as_deref();
            match with {
                None => inspect::compare(cli, designs, out.unwrap_or(Path::new("compare.html"))),
                Some(Standard::Involute) => {
                    inspect::compare_involute(cli, designs, out.unwrap_or(Path::new("involute")))
                }
            }
        }
        Command::Size(args) => size::run(cli, args),
        Command::Motion(command) => motions::run(cli, command),
        Command::Stats { designs, format } => inspect::stats(cli, designs, *format),
        Command::Completions { shell } => manual::completions(*shell),
        Command::Man { folder } => manual::pages(cli, folder),
    }
}

/// Writes a file that must not be there yet.
fn create(path: &Path, text: &str) -> Result<()> {
    use std::io::{Error as IoError, ErrorKind};
    let mut open = std::fs::OpenOptions::new();
    let mut file = open
        .write(true)
        .create_new(true)
        .open(path)
        .map_err(|error| {
            let parent = mpcgear::disk::folder_of(path);
            let what = match error.kind() {
                ErrorKind::AlreadyExists => {
                    "exists already and is left as it is; choose another name".into()
                }
                ErrorKind::NotFound => format!("there is no folder {}", parent.display()),
                _ => error.to_string(),
            };
            Error::io(path)(IoError::new(error.kind(), what))
        })?;
    file.write_all(text.as_bytes()).map_err(|error| {
        // Whole or not at all; the first error is the one to report.
        let _ = std::fs::remove_file(path);
        Error::io(path)(error)
    })
}

/// Writes a line for people to standard output; nothing when quiet or where JSON is wanted.
fn say(cli: &Cli, text: &str) -> Result<u8> {
    if !cli.quiet && !cli.json {
        print_out(text)?;
    }
    Ok(0)
}

/// Writes a line for each figure, in columns at least so wide: name, value, unit.
fn say_figures(cli: &Cli, figures: &[Figure], [name, value, unit]: [usize; 3]) -> Result<u8> {
    for f in figures {
        let line = format!(
            "{:<name$} {:>value$} {:<unit$} {}",
            f.name, f.value, f.unit, f.meaning
        );
        say(cli, line.trim_end())?;
    }
    Ok(0)
}

/// Writes a line to standard output, made harmless for terminals.
fn print_out(text: &str) -> Result<()> {
    write_out(format!("{}\n", mpcgear::escape::terminal(text)).as_bytes())
}

/// Writes bytes to standard output as they are; a closed pipe, a reader that stops early, is no error.
fn write_out(bytes: &[u8]) -> Result<()> {
    match std::io::stdout().write_all(bytes) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::io("standard output")(error))
        }
        _ => Ok(()),
    }
}

/// A value as pretty JSON.
fn json(value: &impl serde::Serialize) -> Result<String> {
    serde_json::to_string_pretty(value).map_err(|e| Error::Internal(e.to_string()))
}
