//! `export` and `report`: files from a finished design.

use std::io::Write;
use std::path::{Path, PathBuf};

use mpcgear::design::Design;
use mpcgear::export::report::ReportInput;
use mpcgear::export::{File, Source, evidence, freecad, openscad, report, stl, threemf};
use mpcgear::motion::Motion;
use mpcgear::solid::assembly::Solids;
use mpcgear::verify::Proof;
use mpcgear::{Error, Problem, Result};

use super::{print_out, read_design, say};
use crate::cli::{Cli, ExportArgs};

/// Formats of `export`: name, what comes out.
const FORMATS: [(&str, &str); 6] = [
    ("openscad", "parametric scripts, one per body, and the animated assembly"),
    ("freecad", "macro that builds the parametric document"),
    ("stl", "bodies in assembled position and pieces to print, binary"),
    ("3mf", "assembly with named, coloured bodies"),
    ("step", "STEP file and FreeCAD document, made by freecadcmd if it is installed"),
    ("report", "report.html, one page without network"),
];

/// Renders a design again.
///
/// # Errors
/// Unknown formats and parts, designs that cannot be read, folders that cannot be written.
pub fn export(cli: &Cli, args: &ExportArgs) -> Result<u8> {
    if args.list {
        for (name, what) in FORMATS {
            print_out(&format!("{name:10} {what}"))?;
        }
        return Ok(0);
    }
    let (Some(path), Some(out)) = (&args.design, &args.out) else {
        return Err(Error::Internal("arguments missing".into()));
    };
    let (design, motion, _) = read_design(path)?;
    let solids = Solids::build(&design, &motion)?;
    let source = Source { design: &design, motion: &motion, solids: Some(&solids) };
    let mut files = Vec::new();
    for format in &args.to {
        files.extend(render(format, &source, &solids)?);
    }
    if let Some(part) = &args.part {
        let of_part = |file: &File| file.path.file_stem().is_some_and(|stem| stem == part.as_str());
        if !files.iter().any(of_part) {
            return Err(wrong("--part", part, &solids.bodies.iter().map(|b| b.name.as_str()).collect::<Vec<_>>()));
        }
        files.retain(of_part);
    }
    if out.as_os_str() == "-" {
        let [file] = files.as_slice() else {
            let names: Vec<String> = files.iter().map(|f| f.path.display().to_string()).collect();
            return Err(wrong("-o -", &format!("{} files", names.len()), &["one format and one --part"]));
        };
        std::io::stdout().write_all(&file.bytes).map_err(Error::io("standard output"))?;
        return Ok(0);
    }
    std::fs::create_dir_all(out).map_err(Error::io(out))?;
    for file in &files {
        report::write_whole(&out.join(&file.path), &file.bytes)?;
        say(cli, &out.join(&file.path).display().to_string())?;
    }
    if args.to.iter().any(|f| f == "step") {
        let program = Path::new("freecadcmd");
        let headless = freecad::Headless { program, folder: out, thorough: false };
        let built = freecad::run(&design, DATE, &headless)?;
        say(cli, &format!("{}\n{}", built.step.display(), built.document.display()))?;
    }
    Ok(0)
}

/// Scripts are dated by their generator, not by the clock: same design, same bytes.
const DATE: &str = "2026-11-23";

fn render(format: &str, source: &Source, solids: &Solids) -> Result<Vec<File>> {
    let l = source.design.settings.gear.center_distance_mm;
    match format {
        "openscad" => Ok(openscad::scripts(source, &solids.recipe)?
            .into_iter()
            .map(|script| File::new(script.name, script.text))
            .collect()),
        "freecad" => {
            let name = format!("{}.FCMacro", freecad::stem(source.design));
            Ok(vec![File::new(name, freecad::macro_text(source.design, DATE)?)])
        }
        "stl" => {
            let mut files = Vec::new();
            for body in &solids.bodies {
                let mesh = body.mesh.moved(&body.carrier.pose(source.motion, l, 0.0));
                files.push(File::new(format!("{}.stl", body.name), stl::binary(&mesh)?));
            }
            for piece in &solids.pieces {
                files.push(File::new(format!("print/{}.stl", piece.name), stl::binary(&piece.mesh)?));
            }
            Ok(files)
        }
        "3mf" => Ok(vec![File::new("assembly.3mf", threemf::assembly(source.design, source.motion, solids)?)]),
        "step" => Ok(Vec::new()),
        "report" => Ok(vec![report_file(source.design, source.motion, solids, None, "")?]),
        other => Err(wrong("--to", other, &FORMATS.map(|(name, _)| name))),
    }
}

fn wrong(place: &str, value: &str, allowed: &[&str]) -> Error {
    Error::Input {
        file: "command line".into(),
        problems: vec![Problem {
            place: place.into(),
            what: format!("`{value}` is not one of {}", allowed.join(", ")),
            hint: "mpcgear export --list shows the formats".into(),
        }],
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
        Ok(File::new(PathBuf::from("report.html"), report::html(input)?))
    })
}

fn with_report<T>(
    design: &Design,
    motion: &Motion,
    (solids, proof, motion_file): (&Solids, Option<&Proof>, &str),
    make: impl FnOnce(&ReportInput) -> Result<T>,
) -> Result<T> {
    let source = Source { design, motion, solids: Some(solids) };
    let residual = mpcgear::synthesis::conjugation_residual(design, motion);
    let claims = evidence::claims(&source, proof, residual);
    let evidence = evidence::Evidence::gather(&source, claims, &[])?;
    make(&evidence.input(&source, motion_file))
}
