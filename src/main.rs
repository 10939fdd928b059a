//! `mpcgear` on the command line: parse, run, say what went wrong, leave with its exit code.

use std::process::ExitCode;

use clap::Parser;

mod cli;
mod commands;
mod terminal;

fn main() -> ExitCode {
    let cli = cli::Cli::parse();
    match commands::run(&cli) {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            terminal::complain(&error, cli.json);
            ExitCode::from(error.exit_code())
        }
    }
}
