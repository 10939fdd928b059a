//! What the report shows, gathered from a design, its solids, the verdicts of its check and its files.

use std::path::{Path, PathBuf};

use super::Source;
use super::report::{Claim, FileLink, ReportInput};
use crate::load::sensitivity::{Sensitivity, sensitivity};
use crate::load::{LoadReport, Sampling, analyse};
use crate::solid::assembly::SolidBody;
use crate::verify::Check;
use crate::{Error, Result};

/// Angles at which assembly errors are tried; each takes a hundred small programs.
const ERROR_ANGLES: usize = 60;

/// Everything that belongs into a report beside the design itself.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// Bodies at φ = 0 in Σ.
    pub bodies: Vec<SolidBody>,
    /// Load figures; `None` where the contacts cannot hold the load.
    pub load: Option<LoadReport>,
    /// Effect of assembly errors; `None` as above.
    pub sensitivity: Option<Sensitivity>,
    /// Verdicts.
    pub claims: Vec<Claim>,
    /// Files beside the report.
    pub files: Vec<FileLink>,
}

/// What a check has already found out.
#[derive(Debug, Clone, Default)]
pub struct Verdicts {
    /// Verdicts.
    pub claims: Vec<Claim>,
    /// Load figures; `None` where they are still to be computed.
    pub load: Option<LoadReport>,
}

impl From<&Check> for Verdicts {
    fn from(check: &Check) -> Verdicts {
        Verdicts {
            claims: check.claims.clone(),
            load: check.load.clone(),
        }
    }
}

impl Evidence {
    /// Gathers the evidence for `source`, beside which `files` (relative paths) lie. Designs that do
    /// not close lack load figures instead of failing: their report says why they are drafts.
    ///
    /// # Errors
    /// [`Error::Input`] for impossible `[load]` settings.
    pub fn gather(source: &Source, verdicts: Verdicts, files: &[PathBuf]) -> Result<Evidence> {
        let (design, motion) = (source.design, source.motion);
        let settings = &design.settings.load;
        let drive = design.settings.gear.drive();
        let place = |body: &SolidBody| SolidBody {
            mesh: body.mesh.moved(&body.carrier.pose(motion, drive, 0.0)),
            ..body.clone()
        };
        let few = Sampling {
            count: ERROR_ANGLES,
            ..Sampling::of(motion)
        };
        Ok(Evidence {
            bodies: source
                .solids
                .map_or(Vec::new(), |s| s.bodies.iter().map(place).collect()),
            load: match verdicts.load {
                Some(known) => Some(known),
                None => where_closed(analyse(design, motion, settings, Sampling::of(motion)))?,
            },
            sensitivity: where_closed(sensitivity(design, motion, settings, few))?,
            claims: verdicts.claims,
            files: files.iter().filter_map(|f| link(f)).collect(),
        })
    }

    /// Input of the report; `motion_file` is shown as the user wrote it and may be empty.
    pub fn input<'a>(&'a self, source: &Source<'a>, motion_file: &'a str) -> ReportInput<'a> {
        ReportInput {
            design: source.design,
            motion: source.motion,
            sampling: Sampling::of(source.motion),
            bodies: &self.bodies,
            claims: &self.claims,
            load: self.load.as_ref(),
            sensitivity: self.sensitivity.as_ref(),
            files: &self.files,
            motion_file,
        }
    }
}

/// The result, or nothing where the mechanism is not form closed.
fn where_closed<T>(result: Result<T>) -> Result<Option<T>> {
    match result {
        Ok(value) => Ok(Some(value)),
        Err(Error::Infeasible { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Link to a file of the output folder, with what it is for.
fn link(file: &Path) -> Option<FileLink> {
    let path = file.to_str()?.replace('\\', "/");
    let (group, note) = match path.split('/').next()? {
        "print" => ("Pieces to print", "lies as it is printed"),
        "meshes" if path.ends_with(".3mf") => ("Meshes, assembled", "all parts, named"),
        "meshes" => ("Meshes, assembled", "at φ = 0"),
        "openscad" => ("OpenSCAD", "parametric, open and customise"),
        "freecad" => ("FreeCAD", "parametric, run the macro"),
        "parts.md" => ("Documents", "what to print, buy, and how to assemble"),
        "design.json" => ("Data", "the design, to export again"),
        "summary.json" => ("Data", "figures"),
        "poses.csv" => ("Data", "pose of the follower at every degree"),
        _ => ("Further files", ""),
    };
    Some(FileLink {
        path,
        note: note.into(),
        group: group.into(),
    })
}
