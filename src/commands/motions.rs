//! `mpcgear motion`: a motion before anything is designed.

use std::io::{Error as IoError, ErrorKind};
use std::path::{Path, PathBuf};

use mpcgear::disk::{Folder, folder_of};
use mpcgear::export::fitted::{self, Names};
use mpcgear::export::motion_figures;
use mpcgear::motion::fit::{self, Fit, Report};
use mpcgear::motion::survey::{Survey, survey};
use mpcgear::motion::{Measured, MotionFile};
use mpcgear::settings::Settings;
use mpcgear::table::Format;
use mpcgear::{Error, Problem, Result};
use serde::Serialize;

use super::{json, print_out, say, say_figures};
use crate::cli::{Cli, FitArgs, MotionCommand};

/// Runs a command on motions.
///
/// # Errors
/// As those of the command.
pub fn run(cli: &Cli, command: &MotionCommand) -> Result<u8> {
    match command {
        MotionCommand::Show { file, csv } => show(cli, file, *csv),
        MotionCommand::Fit(args) => fit(cli, args),
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

/// The answer of `fit` with `--json`.
#[derive(Serialize)]
struct Fitted<'a> {
    #[serde(flatten)]
    report: &'a Report,
    files: Vec<PathBuf>,
}

/// Fits a motion to poses, writes it and prints what was changed.
///
/// # Errors
/// Poses that cannot be read, a tolerance that cannot be met, files that are there already or cannot be
/// written.
fn fit(cli: &Cli, args: &FitArgs) -> Result<u8> {
    let poses = args.poses.display().to_string();
    let out = target(args)?;
    let text = mpcgear::motion::read_csv(&args.poses)?;
    let measured = Measured::from_csv(&text, &poses)?;
    let wanted = (args.class, args.tolerance);
    let length = Settings::default().gear.center_distance_mm;
    let found: Fit = fit::fit(&measured, wanted, length)?;
    let stem = out.file_stem().unwrap_or_default().to_string_lossy();
    let names = Names {
        stem: &stem,
        poses: &poses,
    };
    let files = fitted::files(&found, names)?;
    let paths = files.each_ref().map(|f| out.with_file_name(&f.path));
    if let Some(taken) = paths.iter().find(|path| path.symlink_metadata().is_ok()) {
        let what = "exists already and is left as it is; choose another name with --out";
        let error = IoError::new(ErrorKind::AlreadyExists, what);
        return Err(Error::io(taken)(error));
    }
    Folder::open(folder_of(&out))?.add(&files)?;
    if cli.json {
        let answer = Fitted {
            report: &found.report,
            files: paths.into(),
        };
        print_out(&json(&answer)?)?;
        return Ok(0);
    }
    say_figures(cli, &fitted::figures(&found.report), [22, 16, 8])?;
    let [motion, table] = paths.each_ref().map(|path| path.display());
    say(
        cli,
        &format!("{motion} and {table} written; next: mpcgear design {motion} -o out"),
    )
}

/// The motion file that is to be written.
fn target(args: &FitArgs) -> Result<PathBuf> {
    let Some(out) = &args.out else {
        let stem = args.poses.file_stem().unwrap_or_default().to_string_lossy();
        return Ok(args.poses.with_file_name(format!("{stem}_fitted.toml")));
    };
    let is_toml = out.extension().is_some_and(|e| e == "toml");
    let is_text = out.to_str().is_some();
    if is_toml && is_text {
        return Ok(out.clone());
    }
    let what = format!(
        "is {}, allowed is the name of a motion file that ends with .toml",
        out.display()
    );
    let hint = "for example --out my_motion.toml";
    let problem = Problem::new("--out", what, hint);
    Err(Error::input("command line", vec![problem]))
}
