//! `mpcgear motion`: a motion before anything is designed.

use std::path::Path;

use mpcgear::Result;
use mpcgear::export::motion_figures;
use mpcgear::motion::MotionFile;
use mpcgear::motion::survey::{Survey, survey};
use mpcgear::table::Format;
use serde::Serialize;

use super::{json, print_out, say, say_figures};
use crate::cli::{Cli, MotionCommand};

/// Runs a command on motions.
///
/// # Errors
/// As those of the command.
pub fn run(cli: &Cli, command: &MotionCommand) -> Result<u8> {
    match command {
        MotionCommand::Show { file, csv } => show(cli, file, *csv),
    }
}

/// The answer with `--json`.
#[derive(Serialize)]
struct Answer<'a> {
    name: &'a str,
    #[serde(flatten)]
    survey: &'a Survey,
    /// What the sharpness means for the search.
    verdict: &'a str,
}

/// Prints the figures of the motion, or its course over the driver angle as CSV.
///
/// # Errors
/// As [`MotionFile::read`].
fn show(cli: &Cli, path: &Path, csv: bool) -> Result<u8> {
    let (file, motion) = MotionFile::read(path)?;
    let settings = &file.settings;
    let point = settings.load.point_mm.into();
    let survey = survey(&motion, settings.gear.center_distance_mm, point);
    if csv {
        let table = motion_figures::course(&survey);
        print_out(table.render(Format::Csv)?.trim_end())?;
        return Ok(0);
    }
    if cli.json {
        let answer = Answer {
            name: &file.name,
            survey: &survey,
            verdict: survey.sharpness.verdict(),
        };
        print_out(&json(&answer)?)?;
        return Ok(0);
    }
    say(cli, &format!("{} ({})", file.name, file.class))?;
    say_figures(cli, &motion_figures::figures(&survey), [22, 16, 8])
}
