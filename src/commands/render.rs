//! `export`: files from a finished design.

use std::collections::BTreeMap;

use mpcgear::design::{Stored, file};
use mpcgear::disk::Folder;
use mpcgear::export::format::{self, Format};
use mpcgear::export::{File, Source};
use mpcgear::{Error, Problem, Result};

use super::{json, print_out, say, write_out};
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
    let (design, motion, origin) = Stored::read(path)?.with_motion()?;
    let solids = file::solids(&design, &motion, &origin)?;
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
        let found = super::check::of(cli, &source, &origin)?;
        files.push(super::report::page(&source, Some(&found), (&[], ""))?);
    }
    if out.as_os_str() == "-" {
        return to_standard_output(&files);
    }
    Folder::open(out)?.add(&files)?;
    let paths = files.iter().map(|file| out.join(&file.path));
    let written: Vec<String> = paths.map(|path| path.display().to_string()).collect();
    for path in &written {
        say(cli, path)?;
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

/// The one file, as it is. Of a body and its pieces to print
/// the body is meant.
fn to_standard_output(files: &[File]) -> Result<u8> {
    let bodies = files.iter().filter(|file| !file.path.starts_with("print"));
    let [file] = bodies.collect::<Vec<_>>()[..] else {
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
                hint: "choose one format that is one file (3mf, freecad), or one --part (openscad, stl)".into(),
            }]
            .into(),
        });
    };
    write_out(&file.bytes)?;
    Ok(0)
}
