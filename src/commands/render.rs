//! `export` and `report`: files from a finished design.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use mpcgear::design::Design;
use mpcgear::export::format::{self, Format};
use mpcgear::export::report::ReportInput;
use mpcgear::export::{File, Source, evidence, report};
use mpcgear::motion::Motion;
use mpcgear::solid::assembly::Solids;
use mpcgear::verify::Proof;
use mpcgear::{Error, Problem, Result};

use super::{json, print_out, read_design, say};
use crate::cli::{Cli, ExportArgs};

/// The format that is not a rendering of the solids alone.
const REPORT: &str = "report";

/// Renders a design again.
///
/// # Errors
/// Unknown formats and parts, designs that cannot be read, folders that cannot be written.
pub fn export(cli: &Cli, args: &ExportArgs) -> Result<u8> {
    if args.list {
        return list(cli);
    }
    let (Some(path), Some(out)) = (&args.design, &args.out) else {
        return Err(Error::Internal("arguments missing".into()));
    };
    let (reports, names): (Vec<String>, Vec<String>) =
        args.to.iter().cloned().partition(|name| name == REPORT);
    let formats = Format::parse(&names)?;
    let (design, motion, _) = read_design(path)?;
    let solids = Solids::build(&design, &motion)?;
    let source = Source {
        design: &design,
        motion: &motion,
        solids: Some(&solids),
    };
    let mut files = Vec::new();
    for format in formats {
        files.extend(format::render(&source, format, args.part.as_deref())?);
    }
    if !reports.is_empty() {
        files.push(report_file(&design, &motion, &solids, None, "")?);
    }
    if out.as_os_str() == "-" {
        return to_standard_output(&files);
    }
    let mut written = Vec::new();
    for file in &files {
        let path = out.join(&file.path);
        let folder = path.parent().unwrap_or(out);
        std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
        report::write_whole(&path, &file.bytes)?;
        say(cli, &path.display().to_string())?;
        written.push(path.display().to_string());
    }
    if cli.json {
        print_out(&json(&BTreeMap::from([("files", written)]))?)?;
    }
    Ok(0)
}

/// The formats, for people or for programs.
fn list(cli: &Cli) -> Result<u8> {
    let formats = Format::ALL.map(|format| (format.name(), format.description()));
    let report = (REPORT, "one page without network (report.html)");
    let formats: BTreeMap<_, _> = formats.into_iter().chain([report]).collect();
    if cli.json {
        print_out(&json(&formats)?)?;
    } else {
        for (name, description) in formats {
            print_out(&format!("{name:10} {description}"))?;
        }
    }
    Ok(0)
}

/// The one file, as it is; a reader that stops early is no error.
fn to_standard_output(files: &[File]) -> Result<u8> {
    let [file] = files else {
        let names: Vec<String> = files.iter().map(|f| f.path.display().to_string()).collect();
        return Err(Error::Input {
            file: "command line".into(),
            problems: vec![Problem {
                place: "-o -".into(),
                what: format!(
                    "{} files cannot all go to standard output: {}",
                    names.len(),
                    names.join(", ")
                ),
                hint: "choose one format that is one file (3mf, freecad), or one --part".into(),
            }],
        });
    };
    match std::io::stdout().write_all(&file.bytes) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::io("standard output")(error))
        }
        _ => Ok(0),
    }
}

/// Writes `report.html` of an output folder again, or pictures.
///
/// # Errors
/// Designs that cannot be read or built, files that cannot be written.
pub fn report(cli: &Cli, folder: &Path, png: Option<&Path>) -> Result<u8> {
    let (design, motion, file) = read_design(folder)?;
    let solids = Solids::build(&design, &motion)?;
    if let Some(pictures) = png {
        let written = with_report(&design, &motion, (&solids, None, ""), |input| {
            report::write_pictures(input, pictures)
        })?;
        for path in written {
            say(cli, &path.display().to_string())?;
        }
        return Ok(0);
    }
    let page = report_file(&design, &motion, &solids, None, "")?;
    let path = file.with_file_name(&page.path);
    report::write_whole(&path, &page.bytes)?;
    say(cli, &format!("written: {}", path.display()))
}

/// `report.html` of a design.
///
/// # Errors
/// [`Error::Internal`] when the template fails.
pub fn report_file(
    design: &Design,
    motion: &Motion,
    solids: &Solids,
    proof: Option<&Proof>,
    motion_file: &str,
) -> Result<File> {
    with_report(design, motion, (solids, proof, motion_file), |input| {
        Ok(File::new(
            PathBuf::from("report.html"),
            report::html(input)?,
        ))
    })
}

fn with_report<T>(
    design: &Design,
    motion: &Motion,
    (solids, proof, motion_file): (&Solids, Option<&Proof>, &str),
    make: impl FnOnce(&ReportInput) -> Result<T>,
) -> Result<T> {
    let source = Source {
        design,
        motion,
        solids: Some(solids),
    };
    let residual = mpcgear::synthesis::conjugation_residual(design, motion);
    let claims = evidence::claims(&source, proof, residual);
    let evidence = evidence::Evidence::gather(&source, claims, &[])?;
    make(&evidence.input(&source, motion_file))
}
