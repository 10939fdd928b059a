//! `report`: the page and the pictures of a finished design.

use std::path::{Path, PathBuf};

use mpcgear::Result;
use mpcgear::design::{Stored, file as stored};
use mpcgear::disk::{self, Folder};
use mpcgear::export::evidence::{Evidence, Verdicts};
use mpcgear::export::report;
use mpcgear::export::{File, Source};
use mpcgear::verify::Check;

use super::{check, say};
use crate::cli::Cli;

/// Checks the design in an output folder and writes its `report.html` again; or only pictures.
///
/// # Errors
/// Designs that cannot be read or built, files that cannot be written, interruption.
pub fn run(cli: &Cli, folder: &Path, png: Option<&Path>) -> Result<u8> {
    let (design, motion, file) = Stored::read(folder)?.with_motion()?;
    let solids = match design.sub_gear_pairs.is_empty() {
        // A draft that never came as far as bodies.
        true => None,
        false => Some(stored::solids(&design, &motion, &file)?),
    };
    let source = Source {
        design: &design,
        motion: &motion,
        solids: solids.as_ref(),
    };
    if let Some(pictures) = png {
        let evidence = Evidence::gather(&source, Verdicts::default(), &[])?;
        for path in report::write_pictures(&evidence.input(&source, ""), pictures)? {
            say(cli, &path.display().to_string())?;
        }
        return Ok(0);
    }
    let found = check::of(cli, &source, &file)?;
    let page = page(&source, Some(&found), (&beside(&file), ""))?;
    let path = file.with_file_name(&page.path);
    Folder::open(disk::folder_of(&file))?.add(&[page])?;
    say(cli, &format!("written: {}", path.display()))
}

/// `report.html` of a design with the verdicts of its `check`; links to `files`, shows `motion_file`.
///
/// # Errors
/// As [`Evidence::gather`] and [`report::html`].
pub fn page(
    source: &Source,
    check: Option<&Check>,
    (files, motion_file): (&[PathBuf], &str),
) -> Result<File> {
    let verdicts = check.map_or_else(Verdicts::default, Verdicts::from);
    let evidence = Evidence::gather(source, verdicts, files)?;
    let html = report::html(&evidence.input(source, motion_file))?;
    Ok(File::new("report.html", html))
}

/// What lies beside `design.json`, one folder deep, by name; the report itself left out.
fn beside(design: &Path) -> Vec<PathBuf> {
    let folder = design.parent().unwrap_or(Path::new("."));
    let list = |folder: &Path| -> Vec<PathBuf> {
        let items = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut paths: Vec<PathBuf> = items.map(|item| item.path()).collect();
        paths.sort();
        paths
    };
    let owned = |path: &PathBuf| {
        let name = path.file_name().and_then(|n| n.to_str());
        name.is_some_and(|n| n != "report.html" && disk::OWNED.contains(&n))
    };
    list(folder)
        .into_iter()
        .filter(owned)
        .flat_map(|path| match path.is_dir() {
            true => list(&path),
            false => vec![path],
        })
        .filter_map(|path| Some(path.strip_prefix(folder).ok()?.to_path_buf()))
        .collect()
}
