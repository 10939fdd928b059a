//! `mpcgear` on the command line: parse, run, say what went wrong, leave with its exit code.

use std::process::ExitCode;

use clap::Parser;

mod cli;
mod commands;
mod terminal;

fn main() -> ExitCode {
    let cli = match cli::Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if error.use_stderr() => {
            eprint!("{}", mpcgear::escape::terminal(&error.to_string()));
            return ExitCode::from(2);
        }
        Err(help) => help.exit(),
    };
    match commands::run(&cli) {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            terminal::complain(&error, cli.json);
            ExitCode::from(error.exit_code())
        }
    }
}
