//! `load`, `compare`, `stats`: figures of finished designs.

use std::path::{Path, PathBuf};

use mpcgear::design::Stored;
use mpcgear::disk::Folder;
use mpcgear::export::{figures, reference};
use mpcgear::load::sensitivity::{Sensitivity, sensitivity};
use mpcgear::load::tolerances::{self, Draws};
use mpcgear::load::{self, LoadReport, Sampling};
use mpcgear::table::Format;
use mpcgear::{Error, Problem, Result, export, stats};
use serde::Serialize;

use super::{json, print_out, say, say_figures};
use crate::cli::{Cli, TableFormat};

/// Angles at which assembly errors are tried; each takes a hundred small programs.
const ERROR_ANGLES: usize = 60;

/// Of the load figures over 360 angles, the text shows every so many.
const TEXT_STEP: usize = 15;

/// The answer with `--json`.
#[derive(Serialize)]
struct Answer<'a> {
    #[serde(flatten)]
    load: &'a LoadReport,
    sensitivity: Sensitivity,
}

/// Prints what the design has to bear: figures and a table over the driver angle, or all of it as
/// JSON or CSV.
///
/// # Errors
/// As [`load::analyse`] and [`sensitivity`].
pub fn load(cli: &Cli, path: &Path, (payload, csv): (Option<f64>, bool)) -> Result<u8> {
    let (design, motion, _) = Stored::read(path)?.with_motion()?;
    let mut carried = design.settings.load.clone();
    carried.mass_g = payload.unwrap_or(carried.mass_g);
    let report = load::analyse(&design, &motion, &carried, Sampling::of(&motion))?;
    if csv {
        print_out(report.table(1).render(Format::Csv)?.trim_end())?;
        return Ok(0);
    }
    let few = Sampling {
        count: ERROR_ANGLES,
        ..Sampling::of(&motion)
    };
    let sensitivity = sensitivity(&design, &motion, &carried, few)?;
    if cli.json {
        let load = &report;
        print_out(&json(&Answer { load, sensitivity })?)?;
        return Ok(0);
    }
    let mut figures = figures::load(&carried, &report);
    figures.extend(figures::assembly_errors(
        &carried,
        &sensitivity,
        design.class,
    ));
    say_figures(cli, &figures, [31, 18, 6])?;
    say(cli, "")?;
    say(
        cli,
        report.table(TEXT_STEP).render(Format::Text)?.trim_end(),
    )
}

/// Prints how gears come out that are made within the tolerances.
///
/// # Errors
/// As [`tolerances::spread`].
pub fn tolerances(
    cli: &Cli,
    path: &Path,
    (payload, draws, seed): (Option<f64>, u32, u64),
) -> Result<u8> {
    let (design, motion, _) = Stored::read(path)?.with_motion()?;
    let mut carried = design.settings.load.clone();
    carried.mass_g = payload.unwrap_or(carried.mass_g);
    let spread = tolerances::spread(&design, &motion, &carried, Draws { count: draws, seed })?;
    if cli.json {
        print_out(&json(&spread)?)?;
        return Ok(0);
    }
    say_figures(cli, &figures::tolerances(&spread), [31, 24, 6])
}

/// Writes the comparison page and prints its table.
///
/// # Errors
/// As [`stats::collect`] and [`export::compare::write`].
pub fn compare(cli: &Cli, designs: &[PathBuf], out: &Path) -> Result<u8> {
    let entries = stats::collect(designs)?;
    export::compare::write(&entries, out)?;
    if cli.json {
        print_out(&json(&stats::table(&entries).records())?)?;
    }
    say(cli, &stats::table(&entries).render(Format::Text)?)?;
    say(cli, &format!("written: {}", out.display()))
}

/// Prints a design beside the standard pair of spur gears; writes the table and that pair's meshes into a folder.
///
/// # Errors
/// As [`reference::of`]; more than one design, files that cannot be written.
pub fn compare_involute(cli: &Cli, designs: &[PathBuf], out: &Path) -> Result<u8> {
    let [path] = designs else {
        let what = format!("{} designs are given, allowed is one", designs.len());
        let problem = Problem::new("--with involute", what, "");
        return Err(Error::input("command line", vec![problem]));
    };
    let (design, motion, _) = Stored::read(path)?.with_motion()?;
    let found = reference::of(&design, &motion)?;
    let table = reference::table(&design.name, &found);
    Folder::open(out)?.add(&reference::files(&found.pair, &table)?)?;
    if cli.json {
        print_out(&json(&table.records())?)?;
    }
    say(cli, table.render(Format::Text)?.trim_end())?;
    say(
        cli,
        &format!(
            "under {} N·mm on the follower; table and meshes written: {}",
            reference::TORQUE,
            out.display()
        ),
    )
}

/// Prints the table of designs.
///
/// # Errors
/// As [`stats::collect`].
pub fn stats(cli: &Cli, designs: &[PathBuf], format: TableFormat) -> Result<u8> {
    let format = match format {
        TableFormat::Text => Format::Text,
        TableFormat::Csv => Format::Csv,
        TableFormat::Markdown => Format::Markdown,
    };
    let table = stats::table(&stats::collect(designs)?);
    let text = match cli.json {
        true => json(&table.records())?,
        false => table.render(format)?,
    };
    print_out(text.trim_end())?;
    Ok(0)
}
