//! `load`, `compare`, `stats`: figures of finished designs.

use std::path::{Path, PathBuf};

use mpcgear::load::{self, Sampling};
use mpcgear::{Result, export, stats};

use super::{json, print_out, read_design, say};
use crate::cli::{Cli, TableFormat};

/// Prints what the design has to bear.
///
/// # Errors
/// As [`load::analyse`].
pub fn load(cli: &Cli, path: &Path, (payload, _csv): (Option<f64>, bool)) -> Result<u8> {
    let (design, motion, _) = read_design(path)?;
    let mut carried = design.settings.load.clone();
    carried.mass_g = payload.unwrap_or(carried.mass_g);
    let report = load::analyse(&design, &motion, &carried, Sampling::default())?;
    if cli.json {
        print_out(&json(&report)?)?;
        return Ok(0);
    }
    say(
        cli,
        &format!(
            "payload {:.0} g: largest contact force {:.2} N, driver torque up to {:.1} N·mm, payload at {:.0} N a contact {:.0} g",
            carried.mass_g,
            report.force_max,
            report.torque_max,
            carried.force_limit_n,
            1000.0 * report.payload_max,
        ),
    )
}

/// Writes the comparison page and prints its table.
///
/// # Errors
/// As [`stats::collect`] and [`export::compare::write`].
pub fn compare(cli: &Cli, designs: &[PathBuf], out: &Path) -> Result<u8> {
    let entries = stats::collect(designs)?;
    export::compare::write(&entries, out)?;
    say(cli, &stats::table(&entries).render(stats::Format::Text)?)?;
    say(cli, &format!("written: {}", out.display()))
}

/// Prints the table of designs.
///
/// # Errors
/// As [`stats::collect`].
pub fn stats(_cli: &Cli, designs: &[PathBuf], format: TableFormat) -> Result<u8> {
    let format = match format {
        TableFormat::Text => stats::Format::Text,
        TableFormat::Csv => stats::Format::Csv,
        TableFormat::Markdown => stats::Format::Markdown,
    };
    print_out(
        stats::table(&stats::collect(designs)?)
            .render(format)?
            .trim_end(),
    )?;
    Ok(0)
}
